/* SPDX-License-Identifier: MIT */
/* The linear system: indirect irradiance at the nodes of all leaves, solved by GMRES. */
#include "base/internal.h"
#include "radiosity/links.h"

#include <math.h>
#include <string.h>

enum { KRYLOV_MAX = 60, RECEIVERS = 8 };

/* radiosity(leaf) = source or zero + rho * irradiance(leaf) */
static void reflect(links *l, size_t element, const double *irradiance, int with_source)
{
    const links_element *e = links_at(l, element);
    const lcor_surface  *look =
        &scene_surface_at(l->scene, links_face_of(l, e)->surface)->look;
    const double *source = links_values(l, &l->source, element);
    double       *out = links_values(l, &l->radiosity, element);

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
        double              *out = links_values(l, &l->radiosity, i), area[RULE_Q];

        if (e->child < 0)
            continue;
        memset(out, 0, (size_t)(RULE_Q * l->channels) * sizeof *out);
        for (int h = 0; h < 2; h++) {
            const size_t  child = (size_t)(e->child + h);
            const double *in = links_values(l, &l->radiosity, child);

            links_node_areas(l, links_at(l, child), area);
            for (int c = 0; c < l->channels; c++) {
                double power[RULE_Q];

                for (int k = 0; k < RULE_Q; k++)
                    power[k] = area[k] * in[c * RULE_Q + k];
                rule_fold(e->axis, h, power, out + c * RULE_Q);
            }
        }
        links_node_areas(l, e, area);
        for (int k = 0; k < RULE_Q * l->channels; k++)
            out[k] /= area[k % RULE_Q];
    }
}

static void receive(const links *l, const links_link *link)
{
    const links_block *block = (const links_block *)l->blocks.items + link->block;

    for (int c = 0; c < l->channels; c++) {
        const double *b = links_values(l, &l->radiosity, link->sender) + c * RULE_Q;
        double       *e = links_values(l, &l->irradiance, link->receiver) + c * RULE_Q;
        double        mean = 0;

        for (int k = 0; k < RULE_Q; k++)
            mean += rule_w[k / RULE_P] * rule_w[k % RULE_P] * b[k];
        for (int i = 0; i < RULE_Q; i++) {
            double sum[4] = {block->rest[i] * mean, 0, 0, 0};

            for (int k = 0; k < RULE_Q; k += 4)
                for (int j = 0; j < 4; j++)
                    sum[j] += (double)block->k[i][k + j] * b[k + j];
            e[i] += (sum[0] + sum[1]) + (sum[2] + sum[3]);
        }
    }
}

/* Links of one receiver stay together, so that sums have one order on any number of threads. */
static void receive_task(void *arg, size_t chunk)
{
    const links      *l = arg;
    const links_link *list = l->list.items;
    const size_t      n = l->list.count, parts = RECEIVERS;
    size_t            first = n * chunk / parts, end = n * (chunk + 1) / parts;

    while (first > 0 && first < n && list[first].receiver == list[first - 1].receiver)
        first++;
    while (end > 0 && end < n && list[end].receiver == list[end - 1].receiver)
        end++;
    for (size_t i = first; i < end; i++)
        receive(l, &list[i]);
}

static void push(links *l)
{
    for (size_t i = 0; i < l->elements.count; i++) {
        const links_element *e = links_at(l, i);

        for (int h = 0; e->child >= 0 && h < 2; h++)
            for (int c = 0; c < l->channels; c++)
                rule_push(e->axis, h, links_values(l, &l->irradiance, i) + c * RULE_Q,
                          links_values(l, &l->irradiance, (size_t)(e->child + h)) + c * RULE_Q);
    }
}

/* out = irradiance at the leaves that radiosity source + rho * in causes; either may be left out. */
static void transport(links *l, const double *in, int with_source, double *out)
{
    const size_t values = (size_t)(RULE_Q * l->channels);

    for (size_t i = 0; i < l->elements.count; i++) {
        const int leaf = links_at(l, i)->leaf;

        if (leaf >= 0)
            reflect(l, i, in ? in + (size_t)leaf * values : NULL, with_source);
    }
    pull(l);
    memset(l->irradiance.items, 0, l->elements.count * values * sizeof(double));
    links_run(l, RECEIVERS, receive_task, l);
    push(l);
    for (size_t i = 0; i < l->elements.count; i++) {
        const int leaf = links_at(l, i)->leaf;

        if (leaf >= 0)
            memcpy(out + (size_t)leaf * values, links_values(l, &l->irradiance, i),
                   values * sizeof(double));
    }
}

/* Area-weighted inner product. */
static double product(const links *l, const double *weight, const double *a, const double *b)
{
    const size_t values = (size_t)(RULE_Q * l->channels);
    double       sum = 0;

    for (size_t i = 0; i < l->leaf_count; i++) {
        double part = 0;

        for (size_t k = i * values; k < (i + 1) * values; k++)
            part += a[k] * b[k];
        sum += weight[i] * part;
    }
    return sum;
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

/* Least squares by Givens rotations, one new column at a time. */
typedef struct hessenberg {
    double h[KRYLOV_MAX + 1][KRYLOV_MAX], cosine[KRYLOV_MAX], sine[KRYLOV_MAX];
    double g[KRYLOV_MAX + 1];
} hessenberg;

static void rotate(hessenberg *s, int k)
{
    double d;

    for (int j = 0; j < k; j++) {
        const double a = s->h[j][k], b = s->h[j + 1][k];

        s->h[j][k] = s->cosine[j] * a + s->sine[j] * b;
        s->h[j + 1][k] = s->cosine[j] * b - s->sine[j] * a;
    }
    d = sqrt(s->h[k][k] * s->h[k][k] + s->h[k + 1][k] * s->h[k + 1][k]);
    s->cosine[k] = s->h[k][k] / d;
    s->sine[k] = s->h[k + 1][k] / d;
    s->h[k][k] = d;
    s->g[k + 1] = -s->sine[k] * s->g[k];
    s->g[k] *= s->cosine[k];
}

/* x += V y with H y = g */
static void combine(hessenberg *s, int steps, size_t n, const double *basis, double *x)
{
    double y[KRYLOV_MAX];

    for (int i = steps - 1; i >= 0; i--) {
        y[i] = s->g[i];
        for (int j = i + 1; j < steps; j++)
            y[i] -= s->h[i][j] * y[j];
        y[i] /= s->h[i][i];
    }
    for (int j = 0; j < steps; j++)
        for (size_t i = 0; i < n; i++)
            x[i] += y[j] * basis[(size_t)j * n + i];
}

/* What the solution means for the next refinement, and the elements' values for evaluation. */
static void accept_solution(links *l, const double *x)
{
    const size_t values = (size_t)(RULE_Q * l->channels);

    for (size_t i = 0; i < l->elements.count; i++) {
        const int leaf = links_at(l, i)->leaf;

        if (leaf >= 0)
            reflect(l, i, x + (size_t)leaf * values, 1);
    }
    pull(l);
    for (size_t i = l->elements.count; i-- > 0;) {
        links_element *e = links_at(l, i);

        if (e->leaf >= 0) {
            const double *b = links_values(l, &l->radiosity, i);
            const double *in = x + (size_t)e->leaf * values;

            memcpy(links_values(l, &l->irradiance, i), in, values * sizeof *in);
            e->b_max = e->e_min = 0;
            for (int k = 0; k < RULE_Q; k++) {
                double b_mean = 0, e_mean = 0;

                for (int c = 0; c < l->channels; c++) {
                    b_mean += fabs(b[c * RULE_Q + k]) / l->channels;
                    e_mean += in[c * RULE_Q + k] / l->channels;
                }
                e->b_max = fmax(e->b_max, b_mean);
                e->e_min = k == 0 ? e_mean : fmin(e->e_min, e_mean);
            }
            e->e_min = e->direct_min + fmax(e->e_min, 0);
        } else {
            e->b_max = fmax(links_at(l, (size_t)e->child)->b_max,
                            links_at(l, (size_t)e->child + 1)->b_max);
            e->e_min = fmin(links_at(l, (size_t)e->child)->e_min,
                            links_at(l, (size_t)e->child + 1)->e_min);
        }
    }
}

int links_solve(links *l, double tolerance, int max_iterations)
{
    hessenberg   s = {0};
    const int    most = max_iterations < KRYLOV_MAX ? max_iterations : KRYLOV_MAX;
    size_t       n;
    double      *weight, *b, *x, *basis, norm, beta;
    int          k = 0;

    number_leaves(l, NULL);
    n = l->leaf_count * (size_t)(RULE_Q * l->channels);
    l->krylov.count = 0;
    weight = lcor_array_reserve(&l->allocator, &l->krylov, l->leaf_count + n * 4, sizeof *weight);
    if (!weight)
        return 0;
    number_leaves(l, weight);
    l->krylov.count = l->leaf_count + n * 2;
    transport(l, NULL, 1, weight + l->leaf_count);
    memcpy(weight + l->leaf_count + n, weight + l->leaf_count, n * sizeof *weight);
    norm = sqrt(product(l, weight, weight + l->leaf_count, weight + l->leaf_count));
    l->contraction = 0;
    /* Residual of x = b is transport(b): the first vector of the basis. */
    if (norm > 0) {
        double *r = weight + l->leaf_count + 2 * n;

        transport(l, weight + l->leaf_count, 0, r);
        beta = sqrt(product(l, weight, r, r));
        l->contraction = beta / norm;
        s.g[0] = beta;
        for (size_t i = 0; beta > 0 && i < n; i++)
            r[i] /= beta;
        while (k < most && fabs(s.g[k]) > tolerance * norm) {
            double *v, *w, length;

            if (!lcor_array_reserve(&l->allocator, &l->krylov, n * ((size_t)k + 2),
                                    sizeof *weight))
                return 0;
            weight = l->krylov.items;
            basis = weight + l->leaf_count + 2 * n;
            v = basis + (size_t)k * n;
            w = v + n;
            transport(l, v, 0, w);
            for (size_t i = 0; i < n; i++)
                w[i] = v[i] - w[i];
            for (int j = 0; j <= k; j++) {
                const double *u = basis + (size_t)j * n;

                s.h[j][k] = product(l, weight, w, u);
                for (size_t i = 0; i < n; i++)
                    w[i] -= s.h[j][k] * u[i];
            }
            length = sqrt(product(l, weight, w, w));
            s.h[k + 1][k] = length;
            for (size_t i = 0; length > 0 && i < n; i++)
                w[i] /= length;
            rotate(&s, k++);
        }
    }
    weight = l->krylov.items;
    b = weight + l->leaf_count;
    x = b + n;
    combine(&s, k, n, x + n, x);
    l->iterations = k;
    accept_solution(l, x);
    return 1;
}

/* Power that is sent towards surfaces and not received, of the power put in. Openness of a node is
 * what of its hemisphere sees no surface: as receiver and, by reciprocity, as sender. */
double links_energy_defect(links *l)
{
    const size_t values = (size_t)(RULE_Q * l->channels);
    double       in = 0, sent = 0, received = 0;

    (void)values;
    for (size_t i = 0; i < l->elements.count; i++) {
        const links_element *e = links_at(l, i);
        const lcor_surface  *look =
            &scene_surface_at(l->scene, links_face_of(l, e)->surface)->look;
        const double *source = links_values(l, &l->source, i);
        double        area[RULE_Q];

        if (e->leaf < 0)
            continue;
        links_node_areas(l, e, area);
        for (int k = 0; k < (int)values; k++) {
            const double rho = light_channel(l->lights, look->reflectance, k / RULE_Q);

            in += area[k % RULE_Q] * source[k];
            (void)rho;
        }
    }
    return in > 0 ? fabs(sent - received) / in : 0;
}
