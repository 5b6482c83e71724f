/* SPDX-License-Identifier: MIT */
/* Answers: quasi-Monte-Carlo integrals over the hemisphere, and over a patch. */
#include "radiosity/gather.h"

#include "geometry/vec.h"

#include <math.h>
#include <string.h>

enum { RAYS_FIRST = 16, DOUBLINGS_MAX = 16, DOUBLINGS_USED = 3, RAYS_USUAL = 256, PILOTS = 32 };

/* Variance of low-discrepancy samples over that of independent ones, about. */
static const double stratified = 0.5;
/* Light that no ray has met yet, through a slit say: as if the next one met so much of the mean. */
static const double unmet_share = 0.5;

void gather_query_point(const gather *g, const double x[3], const double normal[3],
                        uint32_t surface, gather_query *q)
{
    const double at[3] = {x[0], x[1], x[2]};

    memset(q, 0, sizeof *q);
    q->near = g->effort.near;
    q->stop = g->effort.stop;
    q->share_effort = g->effort.share;
    q->samples = g->effort.samples;
    if (surface == LCOR_BVH_NONE) {
        vec_copy(normal, q->stand.normal);
        vec_frame(normal, q->stand.u, q->stand.v);
        q->stand.surface = LCOR_BVH_NONE;
        q->seed = 1;
    } else {
        const int back = vec_dot(normal, scene_surface_at(g->scene, surface)->normal) < 0;

        gather_stand_on(g, surface, back, &q->stand);
        q->seed = random_hash(gather_side_of(g, surface, back));
    }
    vec_copy(at, q->stand.x);
}

double gather_expected(const gather *g, const gather_stand *stand, const double *direct)
{
    double at[2], sum = 0;
    uint32_t leaf;

    for (int c = 0; c < g->channels; c++)
        sum += direct[c] / g->channels;
    if (stand->surface == LCOR_BVH_NONE)
        return fmax(sum, g->mean);
    leaf = gather_leaf_at_stand(g, stand, at);
    for (int c = 0; c < g->channels; c++)
        sum += leaf == gather_none ? g->mean / g->channels
                                   : gather_field_at(g, g->field, leaf, at, c) / g->channels;
    return fmax(sum, engine_dark * g->mean);
}

/* Sums over the rays of an answer. */
typedef struct sums {
    double value[GATHER_CHANNELS], group[GATHER_GROUPS];
    double square; /* of samples, channels summed */
    uint64_t rays;
} sums;

static void add_sample(const gather *g, const gather_query *q, const guide_view *view,
                       uint32_t index, sums *s)
{
    gather_stand stand = q->stand;
    double value[GATHER_CHANNELS] = {0}, all = 0;
    gather_sample sample;

    if (q->average) {
        double place[2], st[2];

        sobol_point(&g->sobol, index, q->seed, 2, 2, place);
        gather_square_to_edges(q->triangle, place, st);
        vec_plane_point(q->patch, q->patch + 3, q->patch + 6, st[0], st[1], stand.x);
    }
    gather_sample_at(g, &stand, view, q->near, index, q->seed, &sample);
    if (q->average)
        emitters_at(&g->emitters, stand.x, stand.normal, stand.surface, value);
    for (int c = 0; c < g->channels; c++) {
        value[c] += gather_sample_value(g, &sample, g->field, c);
        s->value[c] += value[c];
        all += value[c];
        for (int k = 0; k < GATHER_GROUPS && q->groups; k++)
            s->group[k] +=
                (gather_sample_value(g, &sample, q->groups[k], c) - sample.source[c]) / g->channels;
    }
    s->square += all * all;
    s->rays += sample.rays;
}

/* The squared standard error of a mean over twice as many samples as the last but one, channels
 * summed. The change by a doubling has the variance of the mean itself where samples are
 * independent, that of the doubling before has twice as much; one alone is small by chance too
 * often. Low-discrepancy samples do better than that. */
static double error_squared(const gather *g, double means[][GATHER_CHANNELS], int count)
{
    const int used = count - 1 < DOUBLINGS_USED ? count - 1 : DOUBLINGS_USED;
    double sum = 0;

    for (int k = 0; k < used; k++) {
        const double *to = means[count - 1 - k], *from = means[count - 2 - k];
        double change = 0;

        for (int c = 0; c < g->channels; c++)
            change += fabs(to[c] - from[c]);
        sum += change * change / (1 << k) / used;
    }
    return sum;
}

/* About the same by the spread of `count` samples. It is more than low-discrepancy samples err by,
 * the more of them there are, but as many numbers tell it, while changes are few and small or large
 * by chance: whoever shares effort by it takes a tenth less time. */
static double spread_squared(const gather *g, const sums *s, double count)
{
    double mean = 0;

    for (int c = 0; c < g->channels; c++)
        mean += s->value[c] / count;
    return stratified * fmax(s->square / count - mean * mean, 0) / count;
}

/* Tries which targets can be seen; where none can, guiding is a waste. */
static int look_out(const gather *g, const gather_query *q, guide_view *view, sums *s)
{
    int tries[GUIDE_TARGETS] = {0}, seen[GUIDE_TARGETS] = {0}, any = 0;

    for (uint32_t i = 0; i < PILOTS; i++) {
        double random[2];
        guide_place target;

        sobol_point(&g->sobol, i, q->seed + 3, 0, 2, random);
        guide_choose(g, view, random[0], random[1], &target);
        tries[target.target]++;
        if (!lcor_scene_blocked(g->scene, q->stand.x, target.x, q->stand.surface, NULL)) {
            seen[target.target]++;
            any = 1;
        }
    }
    s->rays += PILOTS;
    if (any)
        guide_learn(g, view, tries, seen);
    return any;
}

uint64_t gather_answer(const gather *g, const gather_query *q, double *total, double *group)
{
    double means[DOUBLINGS_MAX][GATHER_CHANNELS];
    const guide_view *guided = NULL;
    guide_view view;
    sums s = {{0}, {0}, 0, 0};
    uint32_t count = 0;
    int steps = 0, enough = 0, done;

    if (g->dark)
        return 0;
    if (!q->average)
        emitters_at(&g->emitters, q->stand.x, q->stand.normal, q->stand.surface, total);
    if (guide_look(g, q->stand.x, q->stand.normal, gather_expected(g, &q->stand, total), GUIDE_FINE,
                   &view) &&
        look_out(g, q, &view, &s))
        guided = &view;
    /* Rays that have missed something bright err little by their own account. What tells them to
     * stop is therefore not all of the answer: as many rays follow. */
    do {
        double scale = 0, allowed, unmet, error;

        for (const uint32_t end = (uint32_t)RAYS_FIRST << steps; count < end; count++)
            add_sample(g, q, guided, count, &s);
        for (int c = 0; c < g->channels; c++) {
            means[steps][c] = s.value[c] / (double)count;
            scale += total[c] + means[steps][c];
        }
        steps++;
        allowed = q->stop * fmax(scale, engine_dark * g->mean * g->channels);
        if (q->share_effort)
            allowed *= sqrt((double)count / RAYS_USUAL);
        unmet = unmet_share * g->mean * g->channels / (double)count;
        error = q->share_effort ? spread_squared(g, &s, count) : error_squared(g, means, steps);
        done = enough;
        enough = steps >= DOUBLINGS_USED && error + unmet * unmet <= allowed * allowed;
    } while (!done && steps < DOUBLINGS_MAX && 2 * count <= q->samples);
    for (int c = 0; c < g->channels; c++)
        total[c] += fmax(means[steps - 1][c], 0);
    if (q->variance)
        *q->variance = error_squared(g, means, steps) / (g->channels * g->channels);
    for (int k = 0; k < GATHER_GROUPS && group; k++)
        group[k] = s.group[k] / (double)count;
    return s.rays;
}

void gather_query_patch(const gather *g, size_t surface, lcor_value value, size_t index,
                        gather_query *q)
{
    const scene_surface *s = scene_surface_at(g->scene, surface);
    double corner[3][3], a = 0, b = 0;
    scene_patch p;

    lcor_scene_patch(g->scene, s, index, &p);
    for (int c = 0; c < p.corner_count; c++) {
        a += p.s[c] / p.corner_count;
        b += p.t[c] / p.corner_count;
    }
    for (int c = 0; c < 3; c++) /* of a parallelogram: corner 0 and its neighbours */
        vec_plane_point(s->origin, s->edge_u, s->edge_v, p.s[c == 2 ? p.corner_count - 1 : c],
                        p.t[c == 2 ? p.corner_count - 1 : c], corner[c]);
    vec_plane_point(s->origin, s->edge_u, s->edge_v, a, b, q->stand.x);
    gather_query_point(g, q->stand.x, s->normal, (uint32_t)surface, q);
    q->average = value == LCOR_VALUE_AVERAGE;
    if (!q->average)
        return;
    q->stop = g->effort.patch_stop;
    q->triangle = p.corner_count == 3;
    vec_copy(corner[0], q->patch);
    vec_sub(corner[1], corner[0], q->patch + 3);
    vec_sub(corner[2], corner[0], q->patch + 6);
}
