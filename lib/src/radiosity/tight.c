/* SPDX-License-Identifier: MIT */
/* One gathering of the solution at a point, and the error estimate made of such gatherings. */
#include "base/internal.h"
#include "geometry/vec.h"
#include "radiosity/links.h"
#include "radiosity/transfer.h"

#include <math.h>

enum { OCCLUDERS_MAX = 256, CHUNK = 4 };

typedef struct gatherer {
    const links *l;
    transfer t;
    double accuracy, expected; /* wanted, of about so much irradiance */
    double *out;
} gatherer;

/* Descends until the polynomial of an element is as good as those of its parts. */
static void gather_element(gatherer *g, size_t index)
{
    const links *l = g->l;
    const links_element *e = links_at(l, index);
    const face *f = links_face_of(l, e);
    float weights[RULE_Q];

    if (!(e->b_max > 0))
        return;
    g->t.accuracy = g->accuracy * fmin(1, g->expected / e->b_max);
    if (e->child >= 0) {
        double q[2], least, squared;
        const double d2 = transfer_ellipse(g->t.x, f, &e->c, q);
        const double bound = fmin(1, e->area / (d2 + 1e-300));

        least = fmin(q[0], q[1]);
        squared = least * least;
        if (bound > g->t.accuracy * squared * squared) {
            gather_element(g, (size_t)e->child);
            gather_element(g, (size_t)e->child + 1);
            return;
        }
    }
    (void)transfer_weights(&g->t, &e->c, weights);
    for (int c = 0; c < l->channels; c++) {
        const double *b = links_channel(l, &l->radiosity, index, c);

        for (int k = 0; k < RULE_Q; k++)
            g->out[c] += (double)weights[k] * b[k];
    }
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
        transfer_aim(&g.t, l->scene, x, normal, f, occluders, kept > 0 ? (size_t)kept : 0,
                     accuracy);
        g.t.sight.crowded |= kept == OCCLUDERS_CROWD;
        gather_element(&g, (size_t)f->root);
    }
}

typedef struct sample {
    size_t leaf;
    double u, v, weight;
    double defect; /* signed, relative, mean of the channels */
} sample;

typedef struct estimate_job {
    const links *l;
    sample *samples;
    size_t count;
    double accuracy;
} estimate_job;

static void estimate_task(void *arg, size_t chunk)
{
    const estimate_job *job = arg;
    const links *l = job->l;
    const int channels = l->channels;

    for (size_t i = chunk * CHUNK; i < (chunk + 1) * CHUNK && i < job->count; i++) {
        sample *p = &job->samples[i];
        const links_element *e = links_at(l, p->leaf);
        const face *f = links_face_of(l, e);
        double x[3], at_s[RULE_P], at_t[RULE_P], gathered[3], direct[3], here[3];
        double expected = l->floor;

        face_point(f, e->c.s0 + p->u * e->c.hs, e->c.t0 + p->v * e->c.ht, x);
        rule_values(p->u, at_s);
        rule_values(p->v, at_t);
        light_at(l->lights, x, f->normal, f->surface, direct);
        for (int c = 0; c < channels; c++) {
            const double *in = links_channel(l, &l->irradiance, p->leaf, c);

            here[c] = rule_interpolate(in, at_s, at_t);
            expected = fmax(expected, direct[c] + here[c]);
        }
        links_gather(l, x, f->normal, f->surface, job->accuracy, expected, gathered);
        p->defect = 0;
        for (int c = 0; c < channels; c++) {
            p->defect +=
                (here[c] - gathered[c]) / fmax(direct[c] + gathered[c], l->floor) / channels;
        }
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

/* Points in proportion to the root of a leaf's area, so that small ones at edges are seen, more in
 * narrow gaps, weighted back to area; within leaves on a sequence of low discrepancy, a quarter of
 * a patch away from their border, since errors are those of patches. Returns how many, 0 without
 * memory. */
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

            samples[count++] = (sample){i, u, v, e->area / density[i], 0};
        }
    }
    lcor_internal_free(&l->allocator, density);
    return count;
}

/* Errors at edges and corners are few and large: so much more than the sample's is the whole's, as
 * found in rooms whose solution is known. */
static const double tails = 1.4;

int links_estimate(links *l, size_t n, links_errors *out)
{
    estimate_job job = {l, NULL, 0, 0.1 * l->accuracy};
    double weight = 0, mean = 0, square = 0, fourth = 0, spread, amplify;

    job.samples = lcor_internal_alloc(&l->allocator, n * sizeof *job.samples);
    if (!job.samples)
        return 0;
    job.count = place_samples(l, n, job.samples);
    if (job.count == 0) {
        lcor_internal_free(&l->allocator, job.samples);
        return 0;
    }
    links_run(l, (job.count + CHUNK - 1) / CHUNK, estimate_task, &job);
    out->max = 0;
    for (size_t i = 0; i < job.count; i++) {
        const double d = job.samples[i].defect, w = job.samples[i].weight;

        weight += w;
        mean += w * d;
        square += w * d * d;
        fourth += w * w * d * d * d * d;
        out->max = fmax(out->max, fabs(d));
    }
    mean /= weight;
    square /= weight;
    spread = sqrt(fmax(0, fourth / (weight * weight) - square * square / (double)job.count));
    /* One gathering shows the defect; what of it survives averaging over the hemisphere comes back
     * with every further reflection. Both by the upper end of what the sample leaves open. */
    amplify = l->contraction / fmax(1 - l->contraction, 1e-4);
    mean = fabs(mean) + sqrt(square / (double)(job.count + 1));
    out->rms = tails * sqrt(square + spread + amplify * amplify * mean * mean);
    out->max += amplify * mean;
    lcor_internal_free(&l->allocator, job.samples);
    return 1;
}
