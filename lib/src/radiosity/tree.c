/* SPDX-License-Identifier: MIT */
/* Element trees: splitting, and what the lights do to an element. */
#include "base/internal.h"
#include "geometry/factor.h"
#include "geometry/vec.h"
#include "radiosity/engine.h"
#include "radiosity/links.h"

#include <math.h>
#include <string.h>

/* Where polynomials are tried against the truth: near the corners and in the middle. */
static const double test_s[5] = {0.02, 0.02, 0.5, 0.98, 0.98};
static const double test_t[5] = {0.02, 0.98, 0.5, 0.02, 0.98};

/* All lights at once, mean of the channels. */
static double brightness(const links *l, size_t f, const double x[3])
{
    const face *at = (const face *)l->faces.items + f;
    const size_t lights = l->scene->lights.count;
    double sum = 0;

    for (size_t i = 0; i < lights; i++) {
        const lcor_light *light = scene_light_at(l->scene, i);
        const links_shadow *shadow = &l->shadows[f * lights + i];
        double value, power = 0;

        if (shadow->dark)
            continue;
        value = lcor_direct_unshadowed(light, x, at->normal);
        if (!(value > 0) ||
            (shadow->count > 0 && lcor_direct_shadowed(l->scene, light, x, at->surface, NULL)))
            continue;
        for (int c = 0; c < l->channels; c++)
            power += light_channel(l->lights, light->intensity, c) / l->channels;
        sum += value * power;
    }
    return sum;
}

static void look_at_light(const links *l, links_element *e)
{
    const face *f = links_face_of(l, e);
    double x[RULE_Q][3], value[RULE_Q], lowest = HUGE_VAL, highest = 0, worst = 0;

    links_nodes(l, e, x);
    for (int k = 0; k < RULE_Q; k++) {
        value[k] = brightness(l, e->face, x[k]);
        lowest = fmin(lowest, value[k]);
        highest = fmax(highest, value[k]);
    }
    for (int i = 0; i < 5; i++) {
        double at_s[RULE_P], at_t[RULE_P], seen;

        face_point(f, e->c.s0 + test_s[i] * e->c.hs, e->c.t0 + test_t[i] * e->c.ht, x[0]);
        seen = brightness(l, e->face, x[0]);
        rule_values(test_s[i], at_s);
        rule_values(test_t[i], at_t);
        worst = fmax(worst, fabs(seen - rule_interpolate(value, at_s, at_t)));
        lowest = fmin(lowest, seen);
        highest = fmax(highest, seen);
    }
    e->direct_min = lowest;
    e->direct_max = highest;
    e->rough_direct = worst;
}

static void set_look(links *l, links_element *e)
{
    const face *f = links_face_of(l, e);
    const lcor_surface *look = face_look(l->scene, f);
    double rho = 0, emission = 0;

    for (int c = 0; c < l->channels; c++) {
        rho += light_channel(l->lights, look->reflectance, c) / l->channels;
        emission += light_channel(l->lights, look->emission, c) / l->channels;
    }
    look_at_light(l, e);
    e->rough_direct *= rho;
    e->rough = e->rough_direct;
    e->b_max = emission + rho * (e->direct_max + l->ambient);
    e->e_min = e->direct_min + 0.5 * l->ambient;
}

static int add_element(links *l, uint32_t face_number, const cell *c)
{
    const size_t values = RULE_Q * (size_t)l->channels * sizeof(double);
    links_element *e = lcor_array_reserve(&l->allocator, &l->elements, 1, sizeof *e);
    lcor_array *arrays[3] = {&l->irradiance, &l->radiosity, &l->source};
    double corners[4][3];

    if (!e)
        return 0;
    for (int i = 0; i < 3; i++) {
        void *room = lcor_array_reserve(&l->allocator, arrays[i], 1, values);

        if (!room)
            return 0;
        memset(room, 0, values);
        arrays[i]->count++;
    }
    memset(e, 0, sizeof *e);
    e->face = face_number;
    e->child = -1;
    e->leaf = -1;
    e->c = *c;
    e->area = face_cell_area(links_face_of(l, e), c);
    face_cell_corners(links_face_of(l, e), c, corners);
    vec_copy(corners[0], e->low);
    vec_copy(corners[0], e->high);
    for (int i = 0; i < 4; i++)
        for (int k = 0; k < 3; k++) {
            e->low[k] = fmin(e->low[k], corners[i][k]);
            e->high[k] = fmax(e->high[k], corners[i][k]);
            e->centre[k] += 0.25 * corners[i][k];
        }
    set_look(l, e);
    l->elements.count++;
    return 1;
}

double links_extent(const links *l, const links_element *e, int axis)
{
    double a[3], b[3];

    face_point(links_face_of(l, e), e->c.s0 + (axis == 0 ? 0 : 0.5 * e->c.hs),
               e->c.t0 + (axis == 1 ? 0 : 0.5 * e->c.ht), a);
    face_point(links_face_of(l, e), e->c.s0 + (axis == 0 ? 1 : 0.5) * e->c.hs,
               e->c.t0 + (axis == 1 ? 1 : 0.5) * e->c.ht, b);
    vec_sub(b, a, b);
    return vec_length(b);
}

int links_may_split(const links *l, const links_element *e, int axis)
{
    /* a little more, so that rounding does not decide for edges that are just as long */
    return links_extent(l, e, axis) > 1.001 * l->finest * links_face_of(l, e)->finest;
}

int links_split(links *l, size_t element, int axis)
{
    const links_element parent = *links_at(l, element);
    const size_t child = l->elements.count;
    cell half = parent.c;

    half.hs *= axis == 0 ? 0.5 : 1;
    half.ht *= axis == 1 ? 0.5 : 1;
    for (int i = 0; i < 2; i++) {
        half.s0 = parent.c.s0 + (axis == 0 ? i * half.hs : 0);
        half.t0 = parent.c.t0 + (axis == 1 ? i * half.ht : 0);
        if (!add_element(l, parent.face, &half))
            return 0;
        for (int c = 0; c < l->channels; c++)
            rule_push(axis, i, links_channel(l, &l->irradiance, element, c),
                      links_channel(l, &l->irradiance, child + (size_t)i, c));
    }
    links_at(l, element)->child = (int32_t)child;
    links_at(l, element)->axis = axis;
    return 1;
}

void links_nodes(const links *l, const links_element *e, double x[RULE_Q][3])
{
    const face *f = links_face_of(l, e);

    for (int a = 0; a < RULE_P; a++) { /* a line of constant s */
        const double s = e->c.s0 + rule_x[a] * e->c.hs;
        double start[3], line[3];

        face_point(f, s, 0, start);
        face_point(f, s, 1, line);
        vec_sub(line, start, line);
        for (int b = 0; b < RULE_P; b++)
            vec_add_scaled(start, e->c.t0 + rule_x[b] * e->c.ht, line, x[a * RULE_P + b]);
    }
}

void links_region(const links *l, const links_element *e, region *out)
{
    const face *f = links_face_of(l, e);

    face_cell_corners(f, &e->c, out->corners);
    vec_copy(f->normal, out->normal);
}

size_t links_leaf_at(const links *l, const face *f, double s, double t, double *u, double *v)
{
    size_t at = (size_t)f->root;

    for (;;) {
        const links_element *e = links_at(l, at);

        if (e->child < 0) {
            *u = (s - e->c.s0) / e->c.hs;
            *v = (t - e->c.t0) / e->c.ht;
            return at;
        }
        at = (size_t)e->child;
        if ((e->axis == 0 ? s - e->c.s0 - 0.5 * e->c.hs : t - e->c.t0 - 0.5 * e->c.ht) >=
            -LINKS_ON_EDGE)
            at++;
    }
}

/* Lists what may stand between each light and each face. */
static int find_shadows(links *l)
{
    const size_t lights = l->scene->lights.count;

    for (size_t f = 0; f < l->faces.count; f++)
        for (size_t i = 0; i < lights; i++) {
            const face *at = (const face *)l->faces.items + f;
            const lcor_light *light = scene_light_at(l->scene, i);
            const cell all = {0, 0, 1, 1};
            links_shadow *shadow = &l->shadows[f * lights + i];
            const uint32_t *blockers;
            size_t candidates;
            region r;
            uint32_t *room;
            long count;

            memset(shadow, 0, sizeof *shadow);
            if (l->lights->open[i])
                continue;
            blockers =
                occluders_of(l->scene, at->back || light_in_solid(l->scene, light), &candidates);
            room = lcor_array_reserve(&l->allocator, &l->occluders, candidates, sizeof *room);
            if (!room)
                return 0;
            face_cell_corners(at, &all, r.corners);
            vec_copy(at->normal, r.normal);
            count = occluders_of_light(l->scene, light, &r, blockers, candidates, room, candidates);
            shadow->dark = count == OCCLUDERS_BLOCK;
            shadow->first = (uint32_t)l->occluders.count;
            shadow->count = count > 0 ? (uint32_t)count : 0;
            l->occluders.count += shadow->count;
        }
    return 1;
}

/* Mean irradiance to which errors refer before anything is solved: the direct light that is
 * reflected, and reflected again by the mean surface. */
static void guess_ambient(links *l)
{
    double sent = 0, direct = 0, rho = 0, area = 0;

    for (size_t f = 0; f < l->faces.count; f++) {
        const face *at = (const face *)l->faces.items + f;
        const lcor_surface *look = face_look(l->scene, at);
        const cell all = {0, 0, 1, 1};
        const double a = face_cell_area(at, &all);

        for (int k = 0; k < RULE_Q; k++) {
            double x[3], e;
            const double w = a * rule_w[k / RULE_P] * rule_w[k % RULE_P];

            face_point(at, rule_x[k / RULE_P], rule_x[k % RULE_P], x);
            e = brightness(l, f, x);
            direct += w * e;
            for (int c = 0; c < l->channels; c++) {
                const double r = light_channel(l->lights, look->reflectance, c) / l->channels;

                sent += w * (r * e + light_channel(l->lights, look->emission, c) / l->channels);
                rho += w * r;
            }
        }
        area += a;
    }
    l->ambient = sent / area / (1 - rho / area);
    l->floor = fmax(engine_dark * (direct / area + l->ambient), 1e-300); /* in the dark, anything */
}

/* A convex scene is closed everywhere if the faces fill the hemispheres over their middles. */
static int is_closed(const links *l)
{
    const cell all = {0, 0, 1, 1};

    if (!l->scene->convex)
        return 0;
    for (size_t r = 0; r < l->faces.count; r++) {
        const face *at = (const face *)l->faces.items + r;
        double x[3], sum = 0;

        face_point(at, 0.5, 0.5, x);
        for (size_t s = 0; s < l->faces.count; s++) {
            const face *from = (const face *)l->faces.items + s;
            double corners[4][3];

            face_cell_corners(from, &all, corners);
            if (from->surface != at->surface) /* its own back lies in its plane */
                sum += lcor_factor_point(x, at->normal, 4, corners[0]);
        }
        if (fabs(sum - 1) > 1e-9)
            return 0;
    }
    return 1;
}

int links_relight(links *l)
{
    if (!find_shadows(l))
        return 0;
    guess_ambient(l);
    for (size_t i = 0; i < l->elements.count; i++)
        set_look(l, links_at(l, i));
    return 1;
}

int links_init(links *l)
{
    const cell all = {0, 0, 1, 1};
    const size_t surfaces = l->scene->surfaces.count, lights = l->scene->lights.count;

    l->sides = lcor_internal_alloc(&l->allocator, 2 * surfaces * sizeof *l->sides);
    if (!l->sides || !face_build(l->scene, &l->allocator, &l->faces, l->sides))
        return 0;
    l->shadows = lcor_internal_alloc(&l->allocator, l->faces.count * lights * sizeof *l->shadows);
    if (!l->shadows || !find_shadows(l))
        return 0;
    guess_ambient(l);
    l->closed = is_closed(l);
    for (size_t f = 0; f < l->faces.count; f++) {
        ((face *)l->faces.items)[f].root = (int32_t)l->elements.count;
        if (!add_element(l, (uint32_t)f, &all))
            return 0;
    }
    return 1;
}

void links_clear(links *l)
{
    lcor_array *arrays[] = {&l->faces,     &l->elements, &l->list,       &l->blocks,    &l->factors,
                            &l->occluders, &l->scratch,  &l->irradiance, &l->radiosity, &l->source,
                            &l->deviation, &l->mean,     &l->work};

    for (size_t i = 0; i < sizeof arrays / sizeof arrays[0]; i++)
        lcor_array_clear(&l->allocator, arrays[i]);
    lcor_internal_free(&l->allocator, l->sides);
    lcor_internal_free(&l->allocator, l->shadows);
}
