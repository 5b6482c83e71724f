/* SPDX-License-Identifier: MIT */
/* One gathering of the solution at a point, and the error estimate made of such gatherings. */
#include "base/internal.h"
#include "geometry/vec.h"
#include "radiosity/links.h"
#include "radiosity/transfer.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { OCCLUDERS_MAX = 256, TOGETHER = 2 * TRANSFER_LANES };

/* From so many on, points that see all of a face gather from it at once, repeated up to TOGETHER.
 */
enum { WORTHWHILE = 3 };

/* Points of one plane that gather from a face. */
typedef struct gatherer {
    const links *l;
    transfer t; /* looks at the face, from the only point if there is one */
    double accuracy;
    double expected; /* the least irradiance of any */
    size_t n;
    double x[TOGETHER][3];
    double *out[TOGETHER];
} gatherer;

/* Whether the polynomial of an element is as good as those of its parts, seen from where 1/r^2 is
 * analytic within an ellipse of parameter q. */
static int is_fine(const links_element *e, double q, double distance2, double accuracy)
{
    const double squared = q * q;

    return e->child < 0 || fmin(1, e->area / (distance2 + 1e-300)) <= accuracy * squared * squared;
}

/* Of a form factor to an element. */
static double factor_accuracy(const gatherer *g, const links_element *e)
{
    return g->accuracy * fmin(1, g->expected / e->b_max);
}

static void add_weighed(const links *l, size_t index, const float weights[RULE_Q], double *out)
{
    for (int c = 0; c < l->channels; c++) {
        const double *b = links_channel(l, &l->radiosity, index, c);

        for (int k = 0; k < RULE_Q; k++)
            out[c] += (double)weights[k] * b[k];
    }
}

static void gather_element(gatherer *g, size_t index)
{
    const links_element *e = links_at(g->l, index);
    float weights[RULE_Q];
    double q[2], distance2;

    if (!(e->b_max > 0))
        return;
    g->t.accuracy = factor_accuracy(g, e);
    distance2 = e->child < 0 ? 0 : transfer_ellipse(g->x[0], g->t.f, &e->c, q);
    if (!is_fine(e, e->child < 0 ? 1 : fmin(q[0], q[1]), distance2, g->t.accuracy)) {
        gather_element(g, (size_t)e->child);
        gather_element(g, (size_t)e->child + 1);
        return;
    }
    transfer_weights(&g->t, &e->c, transfer_factor(&g->t, &e->c), weights);
    add_weighed(g->l, index, weights, g->out[0]);
}

/* The same for points that see all of the face. */
static void gather_together(gatherer *g, size_t index)
{
    const links_element *e = links_at(g->l, index);
    const links *l = g->l;
    double exact[TOGETHER], accuracy;
    int fine = 1;

    if (!(e->b_max > 0))
        return;
    accuracy = factor_accuracy(g, e);
    for (int i = 0; fine && e->child >= 0 && i < TOGETHER; i += TRANSFER_LANES) {
        double q[TRANSFER_LANES], distance2[TRANSFER_LANES];

        transfer_ellipses(g->x + i, g->t.f, &e->c, q, distance2);
        for (int k = 0; k < TRANSFER_LANES; k++)
            fine &= is_fine(e, q[k], distance2[k], accuracy);
    }
    if (!fine) {
        gather_together(g, (size_t)e->child);
        gather_together(g, (size_t)e->child + 1);
        return;
    }
    transfer_factors(&g->t, TOGETHER, g->x, &e->c, exact);
    for (size_t i = 0; i < g->n; i += TRANSFER_LANES) {
        float weights[TRANSFER_LANES][RULE_Q];

        transfer_open(l->scene, g->x + i, g->t.normal, g->t.f, &e->c, accuracy, exact + i, weights);
        for (size_t k = i; k < i + TRANSFER_LANES && k < g->n; k++)
            add_weighed(l, index, weights[k - i], g->out[k]);
    }
}

/* From a face of which all points see the whole. */
static void gather_open(gatherer *g, const face *f, size_t n, double (*x)[3], double **out)
{
    const size_t step = n < WORTHWHILE ? 1 : TOGETHER;

    for (size_t i = 0; i < n; i += step) {
        g->n = step == 1 ? 1 : n;
        for (size_t k = 0; k < step; k++) {
            const size_t from = i + k < n ? i + k : i;

            vec_copy(x[from], g->x[k]);
            g->out[k] = out[from];
        }
        if (step > 1) {
            gather_together(g, (size_t)f->root);
        } else {
            transfer_aim(&g->t, g->x[0]);
            gather_element(g, (size_t)f->root);
        }
    }
}

/* What a point sees of a face: OCCLUDERS_BLOCK nothing, else how many occluders may stand between,
 * or that there is a crowd of them. */
static long look(const lcor_scene *scene, const double x[3], const double normal[3], const face *f,
                 int inside, uint32_t *occluders)
{
    const cell all = {0, 0, 1, 1};
    const uint32_t *blockers;
    size_t candidates;
    region here, there;
    double d[3];

    vec_sub(x, f->origin, d);
    if (vec_dot(d, f->normal) <= SCENE_TOUCH * scene->diameter)
        return OCCLUDERS_BLOCK;
    if (scene->convex)
        return 0;
    vec_copy(normal, here.normal);
    for (int i = 0; i < 4; i++)
        vec_copy(x, here.corners[i]);
    face_cell_corners(f, &all, there.corners);
    vec_copy(f->normal, there.normal);
    blockers = occluders_of(scene, inside || f->back, &candidates);
    return occluders_between(scene, &here, &there, blockers, candidates, occluders, OCCLUDERS_MAX);
}

/* Irradiance at points of one plane, TOGETHER at most. */
static void gather(const links *l, size_t n, double (*x)[3], const double normal[3], uint32_t skip,
                   double accuracy, const double *expected, double (*out)[3])
{
    const cell all = {0, 0, 1, 1};
    const lcor_scene *scene = l->scene;
    uint32_t occluders[OCCLUDERS_MAX];
    double open[TOGETHER][3], *open_out[TOGETHER];
    int inside[TOGETHER];
    gatherer g;

    g.l = l;
    g.accuracy = accuracy;
    g.expected = expected[0];
    for (size_t i = 0; i < n; i++) {
        double above[3];

        vec_add_scaled(x[i], 10 * SCENE_TOUCH * scene->diameter, normal, above);
        inside[i] = !scene->convex && lcor_scene_in_solid(scene, above);
        g.expected = fmin(g.expected, expected[i]);
        memset(out[i], 0, sizeof out[i]);
    }
    for (size_t k = 0; k < l->faces.count; k++) {
        const face *f = (const face *)l->faces.items + k;
        size_t opens = 0;

        for (size_t i = 0; i < n && f->surface != skip; i++) {
            const long kept = look(scene, x[i], normal, f, inside[i], occluders);

            if (kept == OCCLUDERS_BLOCK)
                continue;
            transfer_target(&g.t, scene, normal, f, occluders, kept > 0 ? (size_t)kept : 0,
                            accuracy);
            if (kept == 0 && transfer_is_open(&g.t, x[i], &all)) {
                vec_copy(x[i], open[opens]);
                open_out[opens++] = out[i];
                continue;
            }
            vec_copy(x[i], g.x[0]);
            g.out[0] = out[i];
            transfer_aim(&g.t, g.x[0]);
            g.t.sight.crowded |= kept == OCCLUDERS_CROWD;
            gather_element(&g, (size_t)f->root);
        }
        transfer_target(&g.t, scene, normal, f, NULL, 0, accuracy);
        gather_open(&g, f, opens, open, open_out);
    }
}

void links_gather(const links *l, const double x[3], const double normal[3], uint32_t skip,
                  double accuracy, double expected, double *out)
{
    double at[1][3], sum[1][3];

    vec_copy(x, at[0]);
    gather(l, 1, at, normal, skip, accuracy, &expected, sum);
    for (int c = 0; c < l->channels; c++)
        out[c] = sum[0][c];
}

typedef struct sample {
    uint32_t face;
    size_t number, leaf;
    double u, v, weight;
    double defect;   /* signed, relative, mean of the channels */
    size_t together; /* so many from this one on are gathered at once: 0, with one before */
} sample;

typedef struct estimate_job {
    const links *l;
    sample *samples;
    double accuracy;
} estimate_job;

static void estimate_task(void *arg, size_t first)
{
    const estimate_job *job = arg;
    const links *l = job->l;
    sample *samples = job->samples + first;
    const size_t n = samples->together;
    const int channels = l->channels;
    const face *f = links_face_of(l, links_at(l, samples->leaf));
    double x[TOGETHER][3], gathered[TOGETHER][3], direct[TOGETHER][3], here[TOGETHER][3];
    double expected[TOGETHER];

    for (size_t i = 0; i < n; i++) {
        const sample *p = &samples[i];
        const links_element *e = links_at(l, p->leaf);
        double at_s[RULE_P], at_t[RULE_P];

        face_point(f, e->c.s0 + p->u * e->c.hs, e->c.t0 + p->v * e->c.ht, x[i]);
        rule_values(p->u, at_s);
        rule_values(p->v, at_t);
        light_at(l->lights, x[i], f->normal, f->surface, direct[i]);
        expected[i] = l->floor;
        for (int c = 0; c < channels; c++) {
            const double *in = links_channel(l, &l->irradiance, p->leaf, c);

            here[i][c] = rule_interpolate(in, at_s, at_t);
            expected[i] = fmax(expected[i], direct[i][c] + here[i][c]);
        }
    }
    if (n == 0)
        return;
    gather(l, n, x, f->normal, f->surface, job->accuracy, expected, gathered);
    for (size_t i = 0; i < n; i++) {
        samples[i].defect = 0;
        for (int c = 0; c < channels; c++)
            samples[i].defect += (here[i][c] - gathered[i][c]) /
                                 fmax(direct[i][c] + gathered[i][c], l->floor) / channels;
    }
}

/* How many times as many points lie where leaves are too large for the gap they look into. */
static const double gap_boost = 16;

/* Whether another surface faces the leaf nearer than the smallest leaf is long. */
static int in_gap(const links *l, const links_element *e)
{
    static const double at[5][2] = {{0.5, 0.5}, {0.1, 0.1}, {0.9, 0.1}, {0.1, 0.9}, {0.9, 0.9}};
    const face *f = links_face_of(l, e);

    for (int i = 0; i < 5 && !l->scene->convex; i++) {
        double x[3], above[3];

        face_point(f, e->c.s0 + at[i][0] * e->c.hs, e->c.t0 + at[i][1] * e->c.ht, x);
        vec_add_scaled(x, f->finest, f->normal, above);
        if (lcor_scene_blocked(l->scene, x, above, f->surface, NULL))
            return 1;
    }
    return 0;
}

static int compare_samples(const void *a, const void *b)
{
    const sample *p = a, *q = b;

    if (p->face != q->face)
        return p->face < q->face ? -1 : 1;
    return p->number < q->number ? -1 : p->number > q->number;
}

/* Points in proportion to the root of a leaf's area, so that small ones at edges are seen, more in
 * narrow gaps, weighted back to area; within leaves on a sequence of low discrepancy, a quarter of
 * a patch away from their border, since errors are those of patches. In the order of faces. Returns
 * how many, 0 without memory. */
static size_t place_samples(const links *l, size_t n, sample *samples)
{
    double *density = lcor_internal_alloc(&l->allocator, l->elements.count * sizeof *density);
    double total = 0, sum = 0, margin[2];
    size_t count = 0;

    if (!density)
        return 0;
    for (size_t i = 0; i < l->elements.count; i++) {
        const links_element *e = links_at(l, i);

        density[i] = e->child >= 0 ? 0 : sqrt(e->area) * (in_gap(l, e) ? gap_boost : 1);
        total += density[i];
    }
    for (size_t i = 0; i < l->elements.count; i++) {
        const links_element *e = links_at(l, i);

        if (e->child >= 0)
            continue;
        sum += density[i];
        margin[0] = fmin(0.0625, 0.25 * links_face_of(l, e)->patch / links_extent(l, e, 0));
        margin[1] = fmin(0.0625, 0.25 * links_face_of(l, e)->patch / links_extent(l, e, 1));
        while (count < n && ((double)count + 0.5) * total < sum * (double)n) {
            const double s = (double)(count + 1) * 0.7548776662466927;
            const double t = (double)(count + 1) * 0.5698402909980532;
            const double u = margin[0] + (1 - 2 * margin[0]) * (s - floor(s));
            const double v = margin[1] + (1 - 2 * margin[1]) * (t - floor(t));

            samples[count] = (sample){e->face, count, i, u, v, e->area / density[i], 0, 0};
            count++;
        }
    }
    lcor_internal_free(&l->allocator, density);
    qsort(samples, count, sizeof *samples, compare_samples);
    for (size_t i = 0, end; i < count; i += samples[i].together) {
        for (end = i; end < count && end < i + TOGETHER && samples[end].face == samples[i].face;)
            end++;
        samples[i].together = end - i;
    }
    return count;
}

/* Errors at edges and corners are few and large: so much more than the sample's is the whole's, as
 * found in rooms whose solution is known. */
static const double tails = 1.4;

int links_estimate(links *l, size_t n, links_errors *out)
{
    estimate_job job = {l, NULL, 0.4 * l->accuracy};
    size_t count;
    double weight = 0, mean = 0, square = 0, fourth = 0, spread, amplify;

    job.samples = lcor_internal_alloc(&l->allocator, n * sizeof *job.samples);
    if (!job.samples)
        return 0;
    count = place_samples(l, n, job.samples);
    if (count == 0) {
        lcor_internal_free(&l->allocator, job.samples);
        return 0;
    }
    links_run(l, count, estimate_task, &job);
    out->max = 0;
    for (size_t i = 0; i < count; i++) {
        const double d = job.samples[i].defect, w = job.samples[i].weight;

        weight += w;
        mean += w * d;
        square += w * d * d;
        fourth += w * w * d * d * d * d;
        out->max = fmax(out->max, fabs(d));
    }
    mean /= weight;
    square /= weight;
    spread = sqrt(fmax(0, fourth / (weight * weight) - square * square / (double)count));
    /* One gathering shows the defect; what of it survives averaging over the hemisphere comes back
     * with every further reflection. Both by the upper end of what the sample leaves open. */
    amplify = l->contraction / fmax(1 - l->contraction, 1e-4);
    mean = fabs(mean) + sqrt(square / (double)(count + 1));
    out->rms = tails * sqrt(square + spread + amplify * amplify * mean * mean);
    out->max += amplify * mean;
    lcor_internal_free(&l->allocator, job.samples);
    return 1;
}
