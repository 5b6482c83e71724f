/* SPDX-License-Identifier: MIT */
#include "radiosity/emitters.h"

#include "geometry/vec.h"
#include "radiosity/occluders.h"
#include "radiosity/transfer.h"

#include <math.h>

/* A place looks at every face past what may hide it: so much at most is worth an exact answer. */
enum { FACES_MAX = 32, HIDERS_MAX = 24, POINTS = 5 };
/* Sides of surfaces times faces times blockers: what finding out may cost. */
static const double tests_most = 1 << 19;

/* What may hide a face from a side. */
typedef struct hiders {
    uint32_t first, count; /* in emitter_set.occluders */
    int never;             /* the face is not seen from there */
} hiders;

static const face *face_at(const emitter_set *set, size_t i)
{
    return (const face *)set->faces.items + i;
}

static int emits(const lcor_surface *look)
{
    return look->emission[0] > 0 || look->emission[1] > 0 || look->emission[2] > 0;
}

/* ---- faces ---- */

/* The emitting sides of a shape that looks like `surface` all over. */
static int add_shape(emitter_set *set, const lcor_allocator *allocator, const scene_surface *shape,
                     uint32_t surface)
{
    const lcor_scene *scene = set->lights->scene;
    const lcor_surface *look = &scene_surface_at(scene, surface)->look;
    const double *p = scene_corners(scene, shape);
    const int quad = shape->shape == SCENE_QUAD;
    int good = 1;

    for (int back = 0; back <= (look->two_sided != 0) && emits(look); back++)
        for (size_t i = 1; i + 1 < (quad ? 3 : shape->corner_count) && good; i++)
            good = face_append(allocator, &set->faces, shape->normal, surface, back, p, p + 3 * i,
                               p + 3 * (quad ? 3 : i + 1), !quad);
    return good;
}

/* A sheet whose surfaces still look alike is one emitter. */
static int add_sheet(emitter_set *set, const lcor_allocator *allocator, const scene_sheet *sheet)
{
    const lcor_scene *scene = set->lights->scene;
    const uint32_t *members = (const uint32_t *)scene->sheet_members.items + sheet->first_member;
    const lcor_surface *first = &scene_surface_at(scene, members[0])->look;
    int alike = 1, good = 1;

    for (size_t i = 1; i < sheet->member_count && alike; i++)
        alike = lcor_scene_look_alike(first, &scene_surface_at(scene, members[i])->look);
    if (alike)
        return add_shape(set, allocator, &sheet->shape, members[0]);
    for (size_t i = 0; i < sheet->member_count && good; i++)
        good = add_shape(set, allocator, scene_surface_at(scene, members[i]), members[i]);
    return good;
}

static int find_faces(emitter_set *set, const lcor_allocator *allocator)
{
    const lcor_scene *scene = set->lights->scene;
    const uint32_t *shapes = scene->shapes.items;
    int good = 1;

    for (size_t i = 0; i < scene->shapes.count && good && set->faces.count <= FACES_MAX; i++) {
        const scene_sheet *sheet = scene_sheet_of(scene, shapes[i]);

        good = sheet ? add_sheet(set, allocator, sheet)
                     : add_shape(set, allocator, scene_surface_at(scene, shapes[i]), shapes[i]);
    }
    return good;
}

/* ---- what may hide them ---- */

/* Four corners around a surface. */
static void region_of(const lcor_scene *scene, const scene_surface *s, int back, region *out)
{
    const double *p = scene_corners(scene, s);
    double low[2] = {HUGE_VAL, HUGE_VAL}, high[2] = {-HUGE_VAL, -HUGE_VAL};

    for (int k = 0; k < 3; k++)
        out->normal[k] = back ? -s->normal[k] : s->normal[k];
    if (s->corner_count <= 4) {
        for (size_t i = 0; i < 4; i++)
            vec_copy(p + 3 * (i < s->corner_count ? i : s->corner_count - 1), out->corners[i]);
        return;
    }
    for (size_t i = 0; i < s->corner_count; i++) {
        double at[2];

        lcor_scene_coordinates(s, p + 3 * i, &at[0], &at[1]);
        for (int k = 0; k < 2; k++) {
            low[k] = fmin(low[k], at[k]);
            high[k] = fmax(high[k], at[k]);
        }
    }
    for (int i = 0; i < 4; i++)
        vec_plane_point(s->origin, s->edge_u, s->edge_v, i == 1 || i == 2 ? high[0] : low[0],
                        i < 2 ? low[1] : high[1], out->corners[i]);
}

/* Whether light that leaves the region lies within a solid: then single shapes hide, as they do
 * what looks at the inner side of one. */
static int within_solid(const lcor_scene *scene, const region *here)
{
    double above[3] = {0, 0, 0};

    for (int i = 0; i < 4; i++)
        vec_add_scaled(above, 0.25, here->corners[i], above);
    vec_add_scaled(above, 10 * SCENE_TOUCH * scene->diameter, here->normal, above);
    return lcor_scene_in_solid(scene, above);
}

/* Returns as occluders_between, which for what does not face each other is OCCLUDERS_BLOCK. */
static long find_hiders(const lcor_scene *scene, const region *here, int back, const face *f,
                        uint32_t *out)
{
    const cell all = {0, 0, 1, 1};
    const double touch = SCENE_TOUCH * scene->diameter;
    int above = 0, before = 0;
    const uint32_t *in;
    region there;
    size_t count;

    face_cell_corners(f, &all, there.corners);
    vec_copy(f->normal, there.normal);
    for (int i = 0; i < 4; i++) {
        double d[3];

        vec_sub(there.corners[i], here->corners[0], d);
        above |= vec_dot(d, here->normal) > touch;
        vec_sub(here->corners[i], f->origin, d);
        before |= vec_dot(d, f->normal) > touch;
    }
    if (!above || !before)
        return OCCLUDERS_BLOCK;
    if (scene->convex)
        return 0;
    in = occluders_of(scene, back || f->back || within_solid(scene, here), &count);
    return occluders_between(scene, here, &there, in, count, out, HIDERS_MAX);
}

/* Returns 0 without memory. */
static int find_lists(emitter_set *set, const lcor_allocator *allocator)
{
    const lcor_scene *scene = set->lights->scene;
    const size_t sides = 2 * scene->surfaces.count;
    hiders *list =
        lcor_array_reserve(allocator, &set->lists, sides * set->faces.count, sizeof *list);

    if (!list)
        return 0;
    for (size_t side = 0; side < sides; side++) {
        region here;

        region_of(scene, scene_surface_at(scene, side / 2), side % 2 != 0, &here);
        for (size_t i = 0; i < set->faces.count; i++, list++) {
            uint32_t *out = lcor_array_reserve(allocator, &set->occluders, HIDERS_MAX, sizeof *out);
            const long kept =
                out ? find_hiders(scene, &here, side % 2 != 0, face_at(set, i), out) : 0;

            if (!out)
                return 0;
            if (kept == OCCLUDERS_CROWD)
                return 1;
            *list = (hiders){(uint32_t)set->occluders.count, kept > 0 ? (uint32_t)kept : 0,
                             kept == OCCLUDERS_BLOCK};
            set->occluders.count += list->count;
        }
    }
    set->exact = 1;
    return 1;
}

int emitters_find(emitter_set *set, const lcor_allocator *allocator, const light_set *lights)
{
    const lcor_scene *scene = lights->scene;
    double tests;

    emitters_clear(set, allocator);
    set->lights = lights;
    if (!find_faces(set, allocator))
        return 0;
    tests = 2 * (double)scene->surfaces.count * (double)set->faces.count;
    if (!scene->convex)
        tests *= (double)scene->blockers.count;
    return set->faces.count == 0 || set->faces.count > FACES_MAX || tests > tests_most ||
           find_lists(set, allocator);
}

void emitters_clear(emitter_set *set, const lcor_allocator *allocator)
{
    lcor_array_clear(allocator, &set->faces);
    lcor_array_clear(allocator, &set->lists);
    lcor_array_clear(allocator, &set->occluders);
    set->exact = 0;
}

int emitters_point(const emitter_set *set, size_t index, double x[3], double facing[3])
{
    static const double places[POINTS][2] = {{0.5, 0.5}, {0, 0}, {0, 1}, {1, 0}, {1, 1}};
    const double *at = places[index % POINTS];

    if (!set->exact || index / POINTS >= set->faces.count)
        return 0;
    face_point(face_at(set, index / POINTS), at[0], at[1], x);
    vec_copy(face_at(set, index / POINTS)->normal, facing);
    return 1;
}

/* ---- light ---- */

/* Form factor of what a place sees of a face. */
static double factor_at(const emitter_set *set, size_t index, const double x[3],
                        const double normal[3], uint32_t surface)
{
    const lcor_scene *scene = set->lights->scene;
    const uint32_t *between = set->occluders.items;
    const face *f = face_at(set, index);
    const cell all = {0, 0, 1, 1};
    uint32_t found[HIDERS_MAX];
    long count;
    transfer t;

    if (surface == LCOR_BVH_NONE) {
        region here;

        vec_copy(normal, here.normal);
        for (int i = 0; i < 4; i++)
            vec_copy(x, here.corners[i]);
        count = find_hiders(scene, &here, 0, f, found);
        between = found;
    } else {
        const int back = vec_dot(scene_surface_at(scene, surface)->normal, normal) < 0;
        const hiders *list = (const hiders *)set->lists.items +
                             (2 * (size_t)surface + (size_t)back) * set->faces.count + index;

        count = list->never ? OCCLUDERS_BLOCK : (long)list->count;
        between += list->first;
    }
    if (count == OCCLUDERS_BLOCK)
        return 0;
    transfer_target(&t, scene, normal, f, between, count > 0 ? (size_t)count : 0, 1);
    transfer_aim(&t, x);
    t.sight.crowded |= count == OCCLUDERS_CROWD;
    return transfer_factor(&t, &all);
}

void emitters_at(const emitter_set *set, const double x[3], const double normal[3],
                 uint32_t surface, double *out)
{
    for (size_t i = 0; i < set->faces.count && set->exact; i++) {
        const double factor = factor_at(set, i, x, normal, surface);
        const double *emission =
            scene_surface_at(set->lights->scene, face_at(set, i)->surface)->look.emission;

        for (int c = 0; c < set->lights->channels && factor > 0; c++)
            out[c] += factor * light_channel(set->lights, emission, c);
    }
}
