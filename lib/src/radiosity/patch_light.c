/* SPDX-License-Identifier: MIT */
#include "radiosity/patch_light.h"

#include "geometry/vec.h"
#include "radiosity/face.h"
#include "radiosity/gather_random.h"
#include "radiosity/moments.h"
#include "radiosity/occluders.h"
#include "radiosity/transfer.h"

#include <math.h>
#include <string.h>

enum { OCCLUDERS_MAX = SIGHT_CONES, HALVINGS = 4, RAY_DOUBLINGS = 11, BLOCK = 16 };
/* Doublings before rays are believed, and before they are when none has got through. */
enum { DOUBLINGS_LEAST = 3, DOUBLINGS_DARK = 7 };

/* Rays need not be as accurate as quadrature. */
static const double rays_accuracy = 80;

static const double gauss2[2] = {0.21132486540518711775, 0.78867513459481288225};

/* One light on one quad. Results are scalar, for intensity 1. */
typedef struct quad_job {
    const light_set *set;
    const lcor_light *light;
    face whole; /* the quad */
    uint32_t surface;
    size_t nu, nv, row0;
    double accuracy;
    double *out; /* of intensity 1, patch (row0, 0) first */
    double power[3];
} quad_job;

static void add(const quad_job *j, size_t row, size_t column, size_t n, const double *values)
{
    const size_t channels = (size_t)j->set->channels;
    double *out = j->out + ((row - j->row0) * j->nv + column) * channels;

    if (channels == 1)
        for (size_t k = 0; k < n; k++)
            out[k] += values[k] * j->power[0];
    else
        for (size_t k = 0; k < n * channels; k++)
            out[k] += values[k / channels] * j->power[k % channels];
}

/* The parts of a patch before which too much stands to clip light against: rays decide there. */
typedef struct crowds {
    cell cells[1 << HALVINGS];
    int count;
} crowds;

/* Flux of a light of intensity 1 on a cell, clipped at what may hide it. Where that is too much,
 * the cell is halved `depth` times until less is in the way of each part; the rest is listed. */
static double flux_on(const light_set *set, const lcor_light *light, const face *f, const cell *c,
                      const uint32_t *in, size_t in_count, double accuracy, int depth, crowds *rest)
{
    uint32_t occluders[OCCLUDERS_MAX];
    double out[RULE_Q], sum = 0;
    region r;
    long count = 0;
    moments m;

    if (in_count > 0) {
        face_cell_corners(f, c, r.corners);
        vec_copy(f->normal, r.normal);
        count = occluders_of_light(set->scene, light, &r, in, in_count, occluders, OCCLUDERS_MAX);
    }
    if (count == OCCLUDERS_BLOCK)
        return 0;
    if (count == OCCLUDERS_CROWD && depth == 0) {
        rest->cells[rest->count++] = *c;
        return 0;
    }
    if (count == OCCLUDERS_CROWD) {
        cell half = *c;

        half.hs *= depth % 2 ? 0.5 : 1;
        half.ht *= depth % 2 ? 1 : 0.5;
        for (int i = 0; i < 2; i++) {
            half.s0 = c->s0 + (depth % 2 ? i * half.hs : 0);
            half.t0 = c->t0 + (depth % 2 ? 0 : i * half.ht);
            sum += flux_on(set, light, f, &half, in, in_count, accuracy, depth - 1, rest);
        }
        return sum;
    }
    moments_aim(&m, set->scene, light, f, occluders, (size_t)count, accuracy);
    return moments_of(&m, c, out);
}

/* Ray `index` of a cell: the flux on it if the light were the same everywhere. Each cell has a
 * sequence of its own, so that things in rows do not meet rays in rows. */
static double flux_by_ray(const light_set *set, const lcor_light *light, const face *f,
                          const cell *c, const sobol *sequence, uint32_t index, uint32_t seed,
                          uint32_t *cache)
{
    double q[2], x[3], s, value;

    sobol_point(sequence, index, seed, 0, 2, q);
    s = c->s0 + q[0] * c->hs;
    face_point(f, s, c->t0 + q[1] * c->ht, x);
    value = lcor_direct_unshadowed(light, x, f->normal);
    return value > 0 && !lcor_direct_shadowed(set->scene, light, x, f->surface, cache)
               ? value * f->jacobian * c->hs * c->ht * (f->triangle ? s : 1)
               : 0;
}

/* Flux on crowded cells beside `known`, by more and more rays until the last three doublings agree
 * to the accuracy: a change by doubling has the size of the error that is left, the one before that
 * of more by the root of 2. */
static double flux_by_rays(const light_set *set, const lcor_light *light, const face *f,
                           const crowds *rest, double known, double accuracy)
{
    double sum = 0, last = 0, change[3] = {0};
    uint32_t cache = LCOR_BVH_NONE;
    sobol sequence;

    sobol_init(&sequence);
    for (uint32_t n = 0, step = 0;; step++) {
        double mean, error2;

        for (; n < 1u << step; n++)
            for (int i = 0; i < rest->count; i++)
                sum +=
                    flux_by_ray(set, light, f, &rest->cells[i], &sequence, n, (uint32_t)i, &cache);
        mean = sum / n;
        change[step % 3] = mean - last;
        last = mean;
        error2 = fmax(change[step % 3] * change[step % 3],
                      fmax(change[(step + 2) % 3] * change[(step + 2) % 3] / 2,
                           change[(step + 1) % 3] * change[(step + 1) % 3] / 4));
        if (step == RAY_DOUBLINGS || (step >= (mean > 0 ? DOUBLINGS_LEAST : DOUBLINGS_DARK) &&
                                      sqrt(error2) <= rays_accuracy * accuracy * (known + mean)))
            return mean;
    }
}

/* Flux on a patch, or the part of one. */
static double flux_on_patch(const light_set *set, const lcor_light *light, const face *f,
                            const cell *c, const uint32_t *in, size_t in_count, double accuracy)
{
    crowds rest = {.count = 0};
    const double known = flux_on(set, light, f, c, in, in_count, accuracy, HALVINGS, &rest);

    return rest.count > 0 ? known + flux_by_rays(set, light, f, &rest, known, accuracy) : known;
}

/* Points a side that the average over an unshadowed patch of the block needs: 1 or 2, or 0 if it
 * takes more. An n-point rule is good to q^-2n, q about distance over half the edge, twice. */
static int points_needed(const quad_job *j, const cell *block)
{
    const double edge =
        0.5 * fmax(vec_length(j->whole.u) / (double)j->nu, vec_length(j->whole.v) / (double)j->nv);
    double ellipse[2], distance, q2;

    if (j->light->kind == LCOR_LIGHT_DIRECTIONAL)
        return 1;
    if (j->light->kind == LCOR_LIGHT_SPOT || j->light->range > 0)
        return 0;
    distance = sqrt(transfer_ellipse(j->light->position, &j->whole, block, ellipse));
    q2 = 4 * distance * distance / (edge * edge);
    return q2 * j->accuracy > 1 ? 1 : q2 * q2 * j->accuracy > 1 ? 2 : 0;
}

/* Averages of an isotropic or parallel light over unshadowed patches of one row. */
static void clear_row(const quad_job *j, size_t row, size_t first, size_t end, int points)
{
    double height, from[3], to[3];

    if (j->light->kind == LCOR_LIGHT_DIRECTIONAL) {
        const double value = lcor_direct_unshadowed(j->light, j->whole.origin, j->whole.normal);

        for (size_t k = first; k < end; k++)
            add(j, row, k, 1, &value);
        return;
    }
    vec_sub(j->light->position, j->whole.origin, from);
    height = vec_dot(from, j->whole.normal);
    if (!(height > 0))
        return;
    for (int a = 0; a < points; a++) {
        const double s = ((double)row + (points == 2 ? gauss2[a] : 0.5)) / (double)j->nu;
        const double length = vec_length(j->whole.v), share = height / (points * points);
        double foot, off2; /* of the light on the row's line, and its squared distance from it */

        vec_add_scaled(from, -s, j->whole.u, to);
        foot = vec_dot(to, j->whole.v) / length;
        off2 = fmax(vec_dot(to, to) - foot * foot, height * height);
        for (int b = 0; b < points; b++)
            for (size_t base = first; base < end; base += BLOCK) {
                const size_t n = end - base < BLOCK ? end - base : BLOCK;
                const double offset = (double)base + (points == 2 ? gauss2[b] : 0.5);
                const double step = length / (double)j->nv, start = offset * step - foot;
                double value[BLOCK];

                for (int k = 0; k < BLOCK; k++) {
                    const double x = start + k * step, r2 = x * x + off2;

                    value[k] = share / (r2 * sqrt(r2));
                }
                add(j, row, base, n, value);
            }
    }
}

/* A block of patches, halved until it is clear, dark or a single patch. */
static void light_block(const quad_job *j, size_t r0, size_t r1, size_t c0, size_t c1,
                        const uint32_t *in, size_t in_count)
{
    const cell block = {(double)r0 / (double)j->nu, (double)c0 / (double)j->nv,
                        (double)(r1 - r0) / (double)j->nu, (double)(c1 - c0) / (double)j->nv};
    uint32_t occluders[OCCLUDERS_MAX];
    region r;
    long count = 0;
    int points;

    if (in_count > 0) {
        face_cell_corners(&j->whole, &block, r.corners);
        vec_copy(j->whole.normal, r.normal);
        count =
            occluders_of_light(j->set->scene, j->light, &r, in, in_count, occluders, OCCLUDERS_MAX);
    }
    if (count == OCCLUDERS_BLOCK)
        return;
    points = count == 0 ? points_needed(j, &block) : 0;
    if (points > 0) {
        for (size_t row = r0; row < r1; row++)
            clear_row(j, row, c0, c1, points);
    } else if (r1 - r0 == 1 && c1 - c0 == 1) {
        const int crowd = count == OCCLUDERS_CROWD;
        const double value =
            flux_on_patch(j->set, j->light, &j->whole, &block, crowd ? in : occluders,
                          crowd ? in_count : (size_t)count, j->accuracy) /
            face_cell_area(&j->whole, &block);

        add(j, r0, c0, 1, &value);
    } else {
        const int rows = r1 - r0 >= c1 - c0;
        const size_t rm = rows ? (r0 + r1) / 2 : r1, cm = rows ? c1 : (c0 + c1) / 2;
        const uint32_t *next = count == OCCLUDERS_CROWD ? in : occluders;
        const size_t n = count == OCCLUDERS_CROWD ? in_count : (size_t)count;

        light_block(j, r0, rm, c0, cm, next, n);
        light_block(j, rows ? rm : r0, r1, rows ? c0 : cm, c1, next, n);
    }
}

static void quad_averages(const light_set *set, const scene_surface *s, size_t surface,
                          size_t first, size_t count, double accuracy, double *out)
{
    const uint32_t *blockers;
    size_t candidates;
    quad_job j;

    memset(&j, 0, sizeof j);
    j.set = set;
    j.surface = (uint32_t)surface;
    j.accuracy = accuracy;
    j.out = out;
    j.nu = s->look.patches[0] ? s->look.patches[0] : 1;
    j.nv = s->look.patches[1] ? s->look.patches[1] : 1;
    j.row0 = first / j.nv;
    (void)face_set(&j.whole, s->origin, s->edge_u, s->edge_v, 0);
    vec_copy(s->normal, j.whole.normal);
    j.whole.surface = (uint32_t)surface;
    for (size_t i = 0; i < set->scene->lights.count; i++) {
        j.light = scene_light_at(set->scene, i);
        for (int c = 0; c < set->channels; c++)
            j.power[c] = light_channel(set, j.light->intensity, c);
        blockers = occluders_of(set->scene, light_in_solid(set->scene, j.light), &candidates);
        light_block(&j, j.row0, j.row0 + count / j.nv, 0, j.nv, blockers,
                    set->open[i] ? 0 : candidates);
    }
}

/* Average over one patch of a triangle or polygon. */
static void triangle_average(const light_set *set, const scene_surface *s, size_t surface,
                             const scene_patch *p, double accuracy, double *out)
{
    const cell all = {0, 0, 1, 1};
    double corner[3][3], u[3], v[3];
    face f;

    memset(&f, 0, sizeof f);
    for (int c = 0; c < 3; c++)
        vec_plane_point(s->origin, s->edge_u, s->edge_v, p->s[c], p->t[c], corner[c]);
    vec_sub(corner[1], corner[0], u);
    vec_sub(corner[2], corner[0], v);
    (void)face_set(&f, corner[0], u, v, 1);
    vec_copy(s->normal, f.normal);
    f.surface = (uint32_t)surface;
    for (size_t i = 0; i < set->scene->lights.count; i++) {
        const lcor_light *light = scene_light_at(set->scene, i);
        size_t candidates;
        const uint32_t *blockers =
            occluders_of(set->scene, light_in_solid(set->scene, light), &candidates);
        const double value =
            flux_on_patch(set, light, &f, &all, blockers, set->open[i] ? 0 : candidates, accuracy) /
            (0.5 * f.jacobian);

        for (int c = 0; c < set->channels; c++)
            out[c] += value * light_channel(set, light->intensity, c);
    }
}

void patch_light(const light_set *set, size_t surface, lcor_value value, size_t first, size_t count,
                 double accuracy, double *out)
{
    const scene_surface *s = scene_surface_at(set->scene, surface);
    const size_t channels = (size_t)set->channels;

    memset(out, 0, count * channels * sizeof *out);
    if (value == LCOR_VALUE_AVERAGE && s->shape == SCENE_QUAD) {
        quad_averages(set, s, surface, first, count, accuracy, out);
        return;
    }
    for (size_t i = 0; i < count; i++) {
        scene_patch p;
        double a = 0, b = 0, x[3];

        lcor_scene_patch(set->scene, s, first + i, &p);
        if (value == LCOR_VALUE_AVERAGE) {
            triangle_average(set, s, surface, &p, accuracy, out + channels * i);
            continue;
        }
        for (int c = 0; c < p.corner_count; c++) {
            a += p.s[c] / p.corner_count;
            b += p.t[c] / p.corner_count;
        }
        vec_plane_point(s->origin, s->edge_u, s->edge_v, a, b, x);
        light_at(set, x, s->normal, (uint32_t)surface, out + channels * i);
    }
}
