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
    uint32_t skip;
    int crowded; /* too many occluders to clip against: rays decide */
    double *out;
} gatherer;

/* Descends until the polynomial of an element is as good as those of its parts. */
static void gather_element(const gatherer *g, size_t index)
{
    const links *l = g->l;
    const links_element *e = links_at(l, index);
    const face *f = links_face_of(l, e);
    double weights[RULE_Q];

    if (!(e->b_max > 0))
        return;
    if (e->child >= 0) {
        double q[2], d2, bound;

        d2 = transfer_ellipse(g->t.x, f, &e->c, q);
        bound = fmin(1, e->area / (d2 + 1e-300));
        if (bound * pow(fmin(q[0], q[1]), -RULE_P) > g->t.accuracy) {
            gather_element(g, (size_t)e->child);
            gather_element(g, (size_t)e->child + 1);
            return;
        }
    }
    if (g->crowded && lcor_scene_blocked(l->scene, g->t.x, e->centre, g->skip, NULL))
        return;
    (void)transfer_weights(&g->t, f, &e->c, weights);
    for (int c = 0; c < l->channels; c++) {
        const double *b = links_values(l, &l->radiosity, index) + c * RULE_Q;

        for (int k = 0; k < RULE_Q; k++)
            g->out[c] += weights[k] * b[k];
    }
}

void links_gather(const links *l, const double x[3], const double normal[3], uint32_t skip,
                  double accuracy, double *out)
{
    const cell all = {0, 0, 1, 1};
    const size_t surfaces = l->scene->convex ? 0 : l->scene->surfaces.count;
    uint32_t occluders[OCCLUDERS_MAX];
    gatherer g = {l, {l->scene, x, normal, NULL, occluders, 0, accuracy, -1}, skip, 0, out};
    region here, there;

    vec_copy(normal, here.normal);
    for (int i = 0; i < 4; i++)
        vec_copy(x, here.corners[i]);
    for (int c = 0; c < l->channels; c++)
        out[c] = 0;
    for (size_t i = 0; i < l->faces.count; i++) {
        const face *f = (const face *)l->faces.items + i;
        double d[3];

        vec_sub(x, f->origin, d);
        if (f->surface == skip || vec_dot(d, f->normal) <= SCENE_TOUCH * l->scene->diameter)
            continue;
        if (surfaces > 0) {
            long kept;

            face_cell_corners(f, &all, there.corners);
            vec_copy(f->normal, there.normal);
            kept = occluders_between(l->scene, &here, &there, NULL, surfaces, occluders,
                                     OCCLUDERS_MAX);
            if (kept == OCCLUDERS_BLOCK)
                continue;
            g.crowded = kept == OCCLUDERS_CROWD;
            g.t.occluder_count = g.crowded ? 0 : (size_t)kept;
        }
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

    for (size_t i = chunk * CHUNK; i < (chunk + 1) * CHUNK && i < job->count; i++) {
        sample *p = &job->samples[i];
        const links_element *e = links_at(l, p->leaf);
        const face *f = links_face_of(l, e);
        double x[3], at_s[RULE_P], at_t[RULE_P], gathered[3], direct[3];

        face_point(f, e->c.s0 + p->u * e->c.hs, e->c.t0 + p->v * e->c.ht, x);
        rule_values(p->u, at_s);
        rule_values(p->v, at_t);
        links_gather(l, x, f->normal, f->surface, job->accuracy, gathered);
        light_at(l->lights, x, f->normal, f->surface, direct);
        p->defect = 0;
        for (int c = 0; c < l->channels; c++) {
            const double *in = links_values(l, &l->irradiance, p->leaf) + c * RULE_Q;

            p->defect += (rule_interpolate(in, at_s, at_t) - gathered[c]) /
                         fmax(direct[c] + gathered[c], l->floor) / l->channels;
        }
    }
}

/* Points in proportion to the root of a leaf's area, so that small ones at edges are seen, weighted
 * back to area; within leaves on a sequence of low discrepancy. */
static size_t place_samples(const links *l, size_t n, sample *samples)
{
    double total = 0, sum = 0;
    size_t count = 0;

    for (size_t i = 0; i < l->elements.count; i++)
        total += links_at(l, i)->child < 0 ? sqrt(links_at(l, i)->area) : 0;
    for (size_t i = 0; i < l->elements.count; i++) {
        const links_element *e = links_at(l, i);

        if (e->child >= 0)
            continue;
        sum += sqrt(e->area);
        while (count < n && ((double)count + 0.5) * total < sum * (double)n) {
            const double s = (double)(count + 1) * 0.7548776662466927;
            const double t = (double)(count + 1) * 0.5698402909980532;

            samples[count++] = (sample){i, s - floor(s), t - floor(t), sqrt(e->area), 0};
        }
    }
    return count;
}

int links_estimate(links *l, size_t n, links_errors *out)
{
    estimate_job job = {l, NULL, 0, 0.5 * l->accuracy};
    double weight = 0, mean = 0, square = 0, fourth = 0, spread, amplify;

    job.samples = lcor_internal_alloc(&l->allocator, n * sizeof *job.samples);
    if (!job.samples)
        return 0;
    job.count = place_samples(l, n, job.samples);
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
    out->rms = sqrt(square + spread + amplify * amplify * mean * mean);
    out->max += amplify * mean;
    lcor_internal_free(&l->allocator, job.samples);
    return 1;
}
