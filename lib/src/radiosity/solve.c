/* SPDX-License-Identifier: MIT */
/* The linear system: indirect irradiance at the nodes of all leaves, solved by GMRES. */
#include "base/internal.h"
#include "radiosity/krylov.h"
#include "radiosity/links.h"

#include <math.h>
#include <string.h>

enum { RECEIVERS = 8 };

static const double dark_share = 0.1;

/* radiosity(leaf) = source or zero + rho * irradiance(leaf) */
static void reflect(links *l, size_t element, const double *irradiance, int with_source)
{
    const links_element *e = links_at(l, element);
    const lcor_surface *look = face_look(l->scene, links_face_of(l, e));
    const double *source = links_values(l, &l->source, element);
    double *out = links_values(l, &l->radiosity, element);

    for (int c = 0; c < l->channels; c++) {
        const double rho = light_channel(l->lights, look->reflectance, c);

        for (int k = c * RULE_Q; k < (c + 1) * RULE_Q; k++)
            out[k] = (with_source ? source[k] : 0) + (irradiance ? rho * irradiance[k] : 0);
    }
}

/* Radiosity of split elements from their halves: the transpose of interpolation, weighted by area,
 * which keeps the power. Children have higher numbers than parents. */
static void pull(links *l)
{
    for (size_t i = l->elements.count; i-- > 0;) {
        const links_element *e = links_at(l, i);
        double *out = links_values(l, &l->radiosity, i), area[RULE_Q];

        if (e->child < 0)
            continue;
        memset(out, 0, RULE_Q * (size_t)l->channels * sizeof *out);
        for (int h = 0; h < 2; h++) {
            const size_t child = (size_t)e->child + (size_t)h;
            const double *in = links_values(l, &l->radiosity, child);

            links_node_areas(l, links_at(l, child), area);
            for (int c = 0; c < l->channels; c++) {
                double power[RULE_Q];

                for (int k = 0; k < RULE_Q; k++)
                    power[k] = area[k] * in[c * RULE_Q + k];
                rule_fold(e->axis, h, power, out + (size_t)c * RULE_Q);
            }
        }
        links_node_areas(l, e, area);
        for (int k = 0; k < RULE_Q * l->channels; k++)
            out[k] /= area[k % RULE_Q];
    }
}

/* Splits the radiosity of all elements into mean and what is left, as links take it. */
static void set_deviations(links *l)
{
    const size_t n = l->elements.count * (size_t)l->channels;
    const double *b = l->radiosity.items;
    links_mean *mean = l->mean.items;
    float *out = l->deviation.items;

    for (size_t i = 0; i < n; i++, b += RULE_Q, out += RULE_Q) {
        double sum = 0, most = 0;

        for (int k = 0; k < RULE_Q; k++)
            sum += rule_w[k / RULE_P] * rule_w[k % RULE_P] * b[k];
        for (int k = 0; k < RULE_Q; k++)
            most = fmax(most, fabs(b[k] - sum));
        mean[i].value = sum;
        mean[i].deviation = most;
        for (int k = 0; k < RULE_Q; k++)
            out[k] = most > 0 ? (float)((b[k] - sum) / most) : 0;
    }
}

static void receive(const links *l, const links_link *link)
{
    const links_block *block = (const links_block *)l->blocks.items + link->block;
    const size_t channels = (size_t)l->channels, sender = link->sender * channels;

    for (size_t c = 0; c < channels; c++) {
        const float *b = (const float *)l->deviation.items + (sender + c) * RULE_Q;
        const links_mean mean = ((const links_mean *)l->mean.items)[sender + c];
        double *e = links_values(l, &l->irradiance, link->receiver) + c * RULE_Q;

        float sum[RULE_Q];

        for (int i = 0; i < RULE_Q; i += 4) { /* four sums at a time become one vector */
            float s0 = 0, s1 = 0, s2 = 0, s3 = 0;

            for (int k = 0; k < RULE_Q; k++) {
                const float *row = block->k[k] + i;

                s0 += row[0] * b[k];
                s1 += row[1] * b[k];
                s2 += row[2] * b[k];
                s3 += row[3] * b[k];
            }
            sum[i] = s0;
            sum[i + 1] = s1;
            sum[i + 2] = s2;
            sum[i + 3] = s3;
        }
        for (int i = 0; i < RULE_Q; i++)
            e[i] += block->exact[i] * mean.value + (double)sum[i] * mean.deviation;
    }
}

/* How much of the receiver's hemisphere the sender fills. */
static void fill_hemisphere(const links *l, const links_link *link)
{
    const links_block *block = (const links_block *)l->blocks.items + link->block;
    double *e = links_values(l, &l->irradiance, link->receiver);

    for (int i = 0; i < RULE_Q * l->channels; i++)
        e[i] += block->exact[i % RULE_Q];
}

typedef struct receive_job {
    const links *l;
    void (*add)(const links *l, const links_link *link); /* to what the receiver gets */
} receive_job;

/* Links of one receiver stay together, so that sums have one order on any number of threads. */
static void receive_task(void *arg, size_t chunk)
{
    const receive_job *job = arg;
    const links_link *list = job->l->list.items;
    const size_t n = job->l->list.count, parts = RECEIVERS;
    size_t first = n * chunk / parts, end = n * (chunk + 1) / parts;

    while (first > 0 && first < n && list[first].receiver == list[first - 1].receiver)
        first++;
    while (end > 0 && end < n && list[end].receiver == list[end - 1].receiver)
        end++;
    for (size_t i = first; i < end; i++)
        job->add(job->l, &list[i]);
}

static void push(links *l)
{
    for (size_t i = 0; i < l->elements.count; i++) {
        const links_element *e = links_at(l, i);

        for (int h = 0; e->child >= 0 && h < 2; h++)
            for (int c = 0; c < l->channels; c++)
                rule_push(e->axis, h, links_channel(l, &l->irradiance, i, c),
                          links_channel(l, &l->irradiance, (size_t)e->child + (size_t)h, c));
    }
}

static void set_radiosity(links *l, const double *irradiance, int with_source)
{
    const size_t values = RULE_Q * (size_t)l->channels;

    for (size_t i = 0; i < l->elements.count; i++) {
        const int leaf = links_at(l, i)->leaf;

        if (leaf >= 0)
            reflect(l, i, irradiance ? irradiance + (size_t)leaf * values : NULL, with_source);
    }
}

/* What the links bring to the leaves. */
static void collect(links *l, void (*add)(const links *l, const links_link *link), double *out)
{
    receive_job job = {l, add};
    const size_t values = RULE_Q * (size_t)l->channels;

    memset(l->irradiance.items, 0, l->elements.count * values * sizeof(double));
    links_run(l, RECEIVERS, receive_task, &job);
    push(l);
    for (size_t i = 0; i < l->elements.count; i++) {
        const int leaf = links_at(l, i)->leaf;

        if (leaf >= 0)
            memcpy(out + (size_t)leaf * values, links_values(l, &l->irradiance, i),
                   values * sizeof(double));
    }
}

/* Irradiance of the leaves that their radiosity causes, times `closure` where that is not NULL. */
static void transport(links *l, const double *closure, double *out)
{
    const size_t n = l->leaf_count * RULE_Q * (size_t)l->channels;

    pull(l);
    set_deviations(l);
    collect(l, receive, out);
    for (size_t i = 0; closure && i < n; i++)
        out[i] *= closure[i];
}

static void number_leaves(links *l, double *weight)
{
    l->leaf_count = 0;
    for (size_t i = 0; i < l->elements.count; i++) {
        links_element *e = links_at(l, i);

        e->leaf = e->child < 0 ? (int)l->leaf_count++ : -1;
        if (weight && e->leaf >= 0)
            weight[e->leaf] = e->area;
    }
}

/* How far the polynomial of a split element is from that of its half h, mean of the channels. */
static double halves_differ(const links *l, const links_element *e, const double *b, int h)
{
    const double *half = links_values(l, &l->radiosity, (size_t)e->child + (size_t)h);
    double worst = 0, pushed[RULE_Q];

    for (int c = 0; c < l->channels; c++) {
        double most = 0;

        memset(pushed, 0, sizeof pushed);
        rule_push(e->axis, h, b + (size_t)c * RULE_Q, pushed);
        for (int k = 0; k < RULE_Q; k++)
            most = fmax(most, fabs(pushed[k] - half[c * RULE_Q + k]));
        worst += most / l->channels;
    }
    return worst;
}

static void set_bounds(links *l, size_t i)
{
    links_element *e = links_at(l, i);
    const double *b = links_values(l, &l->radiosity, i), *in = links_values(l, &l->irradiance, i);
    double least = HUGE_VAL;

    e->rough = e->rough_direct;
    if (e->child >= 0) {
        const links_element *child = links_at(l, (size_t)e->child);

        e->b_max = fmax(child[0].b_max, child[1].b_max);
        e->e_min = fmin(child[0].e_min, child[1].e_min);
        e->rough = fmax(child[0].rough, child[1].rough) +
                   fmax(halves_differ(l, e, b, 0), halves_differ(l, e, b, 1));
        return;
    }
    e->b_max = 0;
    for (int k = 0; k < RULE_Q; k++) {
        double b_mean = 0, in_mean = 0;

        for (int c = 0; c < l->channels; c++) {
            b_mean += fabs(b[c * RULE_Q + k]) / l->channels;
            in_mean += in[c * RULE_Q + k] / l->channels;
        }
        e->b_max = fmax(e->b_max, b_mean);
        least = fmin(least, in_mean);
    }
    e->e_min = e->direct_min + fmax(least, 0);
}

/* What the solution means for the next refinement, and the elements' values for evaluation. */
static void accept_solution(links *l, const double *x)
{
    const size_t values = RULE_Q * (size_t)l->channels;

    set_radiosity(l, x, 1);
    pull(l);
    for (size_t i = l->elements.count; i-- > 0;) {
        const int leaf = links_at(l, i)->leaf;

        if (leaf >= 0)
            memcpy(links_values(l, &l->irradiance, i), x + (size_t)leaf * values,
                   values * sizeof *x);
        set_bounds(l, i);
    }
}

/* Power that is sent towards surfaces but not received, of the power put in. What of a node's
 * hemisphere is open follows from the row sums: as receiver and, by reciprocity, as sender. */
static double energy_defect(links *l, const double *x, const double *seen)
{
    const size_t values = RULE_Q * (size_t)l->channels;
    double defect = 0, power = 0;

    for (size_t i = 0; i < l->elements.count; i++) {
        const links_element *e = links_at(l, i);
        double area[RULE_Q];

        if (e->leaf < 0)
            continue;
        reflect(l, i, x + (size_t)e->leaf * values, 1);
        links_node_areas(l, e, area);
        power += e->power * l->channels;
        for (size_t k = 0; k < values; k++)
            defect += area[k % RULE_Q] * (links_values(l, &l->radiosity, i)[k] *
                                              (l->closed ? 1 : seen[(size_t)e->leaf * values + k]) -
                                          x[(size_t)e->leaf * values + k]);
    }
    return power > 0 ? fabs(defect) / power : 0;
}

/* What each node sees, or the closure that makes it exactly all of the hemisphere. */
typedef struct reflection {
    links *l;
    const double *closure; /* or NULL */
} reflection;

/* What irradiance x causes by one more reflection. */
static void reflect_once(void *arg, const double *x, double *out)
{
    const reflection *r = arg;

    set_radiosity(r->l, x, 0);
    transport(r->l, r->closure, out);
}

/* Closing hemispheres spreads what the links of dark senders, kept coarse, are in error over the
 * light of all: only where no face is dark. */
static int may_close(const links *l)
{
    for (size_t f = 0; f < l->faces.count; f++)
        if (!(links_at(l, (size_t)((const face *)l->faces.items)[f].root)->b_max >
              dark_share * l->ambient))
            return 0;
    return l->closed;
}

int links_solve(links *l, double tolerance, int max_iterations)
{
    const int closed = may_close(l);
    const size_t group = RULE_Q * (size_t)l->channels;
    double *weight, *seen, *right, *solution;
    reflection r = {l, NULL};
    krylov k;
    size_t n;

    number_leaves(l, NULL);
    n = l->leaf_count * group;
    l->work.count = l->mean.count = l->deviation.count = 0;
    if (!lcor_array_reserve(&l->allocator, &l->work, l->leaf_count + 3 * n, sizeof(double)) ||
        !lcor_array_reserve(&l->allocator, &l->mean, l->elements.count,
                            (size_t)l->channels * sizeof(links_mean)) ||
        !lcor_array_reserve(&l->allocator, &l->deviation, l->elements.count, group * sizeof(float)))
        return 0;
    weight = l->work.items;
    seen = weight + l->leaf_count;
    right = seen + n;
    solution = right + n;
    number_leaves(l, weight);
    collect(l, fill_hemisphere, seen); /* what radiosity 1 everywhere sends */
    for (size_t i = 0; closed && i < n; i++)
        seen[i] = 1 / seen[i];
    r.closure = closed ? seen : NULL;
    set_radiosity(l, NULL, 1);
    transport(l, r.closure, right);
    k = (krylov){.n = n,
                 .map = reflect_once,
                 .arg = &r,
                 .weight = weight,
                 .group = group,
                 .tolerance = tolerance,
                 .iterations = max_iterations};
    if (!krylov_solve(&k, &l->allocator, right, solution))
        return 0;
    l->iterations = k.iterations;
    l->contraction = k.contraction;
    l->basis_bytes = k.bytes;
    l->energy_defect = energy_defect(l, solution, seen);
    accept_solution(l, solution);
    return 1;
}
