/* SPDX-License-Identifier: MIT */
/* One gathering of the solution at a point, and the error estimate made of such gatherings. */
#include "base/internal.h"
#include "geometry/vec.h"
#include "radiosity/links.h"
#include "radiosity/transfer.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { OCCLUDERS_MAX = 256 };

typedef struct gatherer {
    const links *l;
    transfer t;
    double accuracy, expected; /* wanted, of about so much irradiance */
    double *out;
} gatherer;

/* Whether the polynomial of an element is as good as those of its parts, seen from where 1/r^2 is
 * analytic within an ellipse of parameter q. */
static int is_fine(const links_element *e, double q, double distance2, double accuracy)
{
    const double squared = q * q;

    return e->child < 0 || fmin(1, e->area / (distance2 + 1e-300)) <= accuracy * squared * squared;
}

/* Of a form factor to an element, if as much irradiance is expected. */
static double factor_accuracy(const links_element *e, double accuracy, double expected)
{
    return accuracy * fmin(1, expected / e->b_max);
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
    const face *f = links_face_of(g->l, e);
    float weights[RULE_Q];
    double q[2], distance2;

    if (!(e->b_max > 0))
        return;
    g->t.accuracy = factor_accuracy(e, g->accuracy, g->expected);
    distance2 = e->child < 0 ? 0 : transfer_ellipse(g->t.x, f, &e->c, q);
    if (!is_fine(e, e->child < 0 ? 1 : fmin(q[0], q[1]), distance2, g->t.accuracy)) {
        gather_element(g, (size_t)e->child);
        gather_element(g, (size_t)e->child + 1);
        return;
    }
    (void)transfer_weights(&g->t, &e->c, weights);
    add_weighed(g->l, index, weights, g->out);
}

/* Points of a face of a convex scene, all of which see everything. */
enum { TOGETHER = 2 * TRANSFER_LANES };
typedef struct batch {
    const links *l;
    const face *on;
    double x[TOGETHER][3];
    double accuracy, expected; /* the least of all */
    double out[TOGETHER][3];
} batch;

static void gather_together(batch *g, size_t index)
{
    const links_element *e = links_at(g->l, index);
    const face *f = links_face_of(g->l, e);
    double exact[TOGETHER], accuracy;
    int fine = 1;

    if (!(e->b_max > 0))
        return;
    accuracy = factor_accuracy(e, g->accuracy, g->expected);
    for (int i = 0; fine && e->child >= 0 && i < TOGETHER; i += TRANSFER_LANES) {
        double q[TRANSFER_LANES], distance2[TRANSFER_LANES];

        transfer_ellipses(g->x + i, f, &e->c, q, distance2);
        for (int k = 0; k < TRANSFER_LANES; k++)
            fine &= is_fine(e, q[k], distance2[k], accuracy);
    }
    if (!fine) {
        gather_together(g, (size_t)e->child);
        gather_together(g, (size_t)e->child + 1);
        return;
    }
    /* nothing of a convex scene is behind a face */
    (void)transfer_factors(g->l->scene, g->on, TOGETHER, g->x, f, &e->c, exact);
    for (int i = 0; i < TOGETHER; i += TRANSFER_LANES) {
        float weights[TRANSFER_LANES][RULE_Q];

        transfer_open(g->l->scene, g->x + i, g->on->normal, f, &e->c, accuracy, exact + i, weights);
        for (int k = 0; k < TRANSFER_LANES; k++)
            add_weighed(g->l, index, weights[k], g->out[i + k]);
    }
}

/* As links_gather, at n points of a face of a convex scene, TOGETHER at most. */
static void gather_batch(const links *l, const face *on, size_t n, double (*x)[3], double accuracy,
                         const double *expected, double (*out)[3])
{
    batch g = {.l = l, .on = on, .accuracy = accuracy, .expected = expected[0]};

    for (size_t i = 0; i < TOGETHER; i++) {
        const size_t k = i < n ? i : n - 1;

        vec_copy(x[k], g.x[i]);
        g.expected = fmin(g.expected, expected[k]);
    }
    for (size_t i = 0; i < l->faces.count; i++) {
        const face *f = (const face *)l->faces.items + i;

        if (f->surface != on->surface)
            gather_together(&g, (size_t)f->root);
    }
    memcpy(out, g.out, n * sizeof *out);
}

void links_gather(const links *l, const double x[3], const double normal[3], uint32_t skip,
                  double accuracy, double expected, double *out)
{
    const cell all = {0, 0, 1, 1};
    uint32_t occluders[OCCLUDERS_MAX];
    gatherer g;
    region here, there;
    double above[3];
    int inside;

    g.l = l;
    g.accuracy = accuracy;
    g.expected = expected;
    g.out = out;
    vec_add_scaled(x, 10 * SCENE_TOUCH * l->scene->diameter, normal, above);
    inside = lcor_scene_in_solid(l->scene, above);
    vec_copy(normal, here.normal);
    for (int i = 0; i < 4; i++)
        vec_copy(x, here.corners[i]);
    for (int c = 0; c < l->channels; c++)
        out[c] = 0;
    for (size_t i = 0; i < l->faces.count; i++) {
        const face *f = (const face *)l->faces.items + i;
        const uint32_t *blockers;
        size_t candidates;
        long kept = 0;
        double d[3];

        vec_sub(x, f->origin, d);
        if (f->surface == skip || vec_dot(d, f->normal) <= SCENE_TOUCH * l->scene->diameter)
            continue;
        if (!l->scene->convex) {
            face_cell_corners(f, &all, there.corners);
            vec_copy(f->normal, there.normal);
            blockers = occluders_of(l->scene, inside || f->back, &candidates);
            kept = occluders_between(l->scene, &here, &there, blockers, candidates, occluders,
                                     OCCLUDERS_MAX);
            if (kept == OCCLUDERS_BLOCK)
                continue;
        }
        transfer_target(&g.t, l->scene, normal, f, occluders, kept > 0 ? (size_t)kept : 0,
                        accuracy);
        transfer_aim(&g.t, x);
        g.t.sight.crowded |= kept == OCCLUDERS_CROWD;
        gather_element(&g, (size_t)f->root);
    }
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
        for (int c = 0; c < l->channels; c++) {
            const double *in = links_channel(l, &l->irradiance, p->leaf, c);

            here[i][c] = rule_interpolate(in, at_s, at_t);
            expected[i] = fmax(expected[i], direct[i][c] + here[i][c]);
        }
    }
    if (l->scene->convex && n > 0)
        gather_batch(l, f, n, x, job->accuracy, expected, gathered);
    for (size_t i = 0; i < n; i++) {
        if (!l->scene->convex)
            links_gather(l, x[i], f->normal, f->surface, job->accuracy, expected[i], gathered[i]);
        samples[i].defect = 0;
        for (int c = 0; c < l->channels; c++)
            samples[i].defect += (here[i][c] - gathered[i][c]) /
                                 fmax(direct[i][c] + gathered[i][c], l->floor) / l->channels;
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
    estimate_job job = {l, NULL, 0.1 * l->accuracy};
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
