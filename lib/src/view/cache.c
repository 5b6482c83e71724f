/* SPDX-License-Identifier: MIT */
/* The records around a place, and the quadratic polynomial that is most probable by them. */
#include "view/cache.h"

#include "base/internal.h"
#include "geometry/vec.h"
#include "scene/scene_internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { TERMS = 6, LEAF = 4, NEAR_MAX = 512, DEPTH_MAX = 64 };

/* Before anything is measured: how much irradiance changes over a radius, as part of itself, by
 * the linear and by the quadratic terms. */
static const double prior_linear = 0.6, prior_quadratic = 0.4;
/* Planes apart by less than this part of the scene's diameter are one, if the cosine between their
 * normals is less than 1 by no more either: then these differ by `same_normal`. */
static const double same_plane = 1e-6, same_normal = 1.4143e-3;
/* Ways between places are tried so far above their plane: lower things hide nothing. */
static const double lift_share = 1e-4;

void cache_clear(light_cache *cache)
{
    lcor_array_clear(cache->allocator, &cache->records);
    lcor_array_clear(cache->allocator, &cache->nodes);
    lcor_array_clear(cache->allocator, &cache->order);
}

/* ---- the tree ---- */

typedef struct sort_key {
    double at;
    size_t record;
} sort_key;

static int compare_keys(const void *a, const void *b)
{
    const sort_key *p = a, *q = b;

    if (p->at != q->at)
        return p->at < q->at ? -1 : 1;
    return p->record < q->record ? -1 : p->record > q->record;
}

static void set_node(const light_cache *cache, cache_node *node, size_t first, size_t count)
{
    const sort_key *order = (const sort_key *)cache->order.items + first;

    *node = (cache_node){.first = first, .count = count};
    for (int k = 0; k < 3; k++) {
        node->low[k] = node->normal_low[k] = HUGE_VAL;
        node->high[k] = node->normal_high[k] = -HUGE_VAL;
    }
    for (size_t i = 0; i < count; i++) {
        const cache_record *r = cache_record_at(cache, order[i].record);

        for (int k = 0; k < 3; k++) { /* an ellipse's extent along the axis */
            const double disc = 1 - r->normal[k] * r->normal[k];
            const double longer = (r->stretch * r->stretch - 1) * r->along[k] * r->along[k];
            const double reach =
                r->radius * sqrt(fmax(0, disc + longer)) + same_plane * cache->scene->diameter;

            node->low[k] = fmin(node->low[k], r->x[k] - reach);
            node->high[k] = fmax(node->high[k], r->x[k] + reach);
            node->normal_low[k] = fmin(node->normal_low[k], r->normal[k] - same_normal);
            node->normal_high[k] = fmax(node->normal_high[k], r->normal[k] + same_normal);
        }
    }
}

/* Halves a node's records by their place along its longest axis. */
static void split_node(light_cache *cache, size_t index)
{
    cache_node *nodes = cache->nodes.items, *node = &nodes[index];
    sort_key *order = (sort_key *)cache->order.items + node->first;
    const size_t half = node->count / 2;
    int axis = 0;

    for (int k = 1; k < 3; k++)
        if (node->high[k] - node->low[k] > node->high[axis] - node->low[axis])
            axis = k;
    for (size_t i = 0; i < node->count; i++)
        order[i].at = cache_record_at(cache, order[i].record)->x[axis];
    qsort(order, node->count, sizeof *order, compare_keys);
    node->child = cache->nodes.count;
    set_node(cache, &nodes[node->child], node->first, half);
    set_node(cache, &nodes[node->child + 1], node->first + half, node->count - half);
    cache->nodes.count += 2;
}

int cache_index(light_cache *cache)
{
    const size_t n = cache->records.count;
    sort_key *order;
    cache_node *nodes;

    cache->order.count = cache->nodes.count = 0;
    order = lcor_array_reserve(cache->allocator, &cache->order, n + 1, sizeof *order);
    nodes = lcor_array_reserve(cache->allocator, &cache->nodes, 2 * n + 2, sizeof *nodes);
    if (!order || !nodes)
        return 0;
    for (size_t i = 0; i < n; i++)
        order[i] = (sort_key){0, i};
    if (n == 0)
        return 1;
    set_node(cache, &nodes[0], 0, n);
    cache->nodes.count = 1;
    for (size_t i = 0; i < cache->nodes.count; i++)
        if (nodes[i].count > LEAF)
            split_node(cache, i);
    return 1;
}

/* ---- neighbours ---- */

typedef struct neighbour {
    const cache_record *record;
    double kernel, weight;
} neighbour;

/* Whether a record of the node may be valid at a place. On a curved surface of many planes hardly
 * one is, however many reach there. */
static int may_hold(const cache_node *node, const double x[3], const double normal[3])
{
    for (int k = 0; k < 3; k++)
        if (x[k] < node->low[k] || x[k] > node->high[k] || normal[k] < node->normal_low[k] ||
            normal[k] > node->normal_high[k])
            return 0;
    return 1;
}

static int blocked(const light_cache *cache, const double x[3], const double normal[3],
                   const double to[3])
{
    const double lift = lift_share * cache->scene->diameter;
    double from[3], end[3];

    vec_add_scaled(x, lift, normal, from);
    vec_add_scaled(to, lift, normal, end);
    return lcor_scene_blocked(cache->scene, from, end, LCOR_BVH_NONE, NULL);
}

/* What is taken off the square of a length along the record's ellipse to measure it as across. */
static double shortened(const cache_record *r) { return 1 - 1 / (r->stretch * r->stretch); }

/* Smooth, 1 at the record and 0 at its rim and off its plane. */
static double kernel_at(const light_cache *cache, const cache_record *r, double radius,
                        const double x[3], const double normal[3])
{
    double away[3], along, q;

    vec_sub(x, r->x, away);
    along = vec_dot(away, r->along);
    q = 1 - (vec_dot(away, away) - shortened(r) * along * along) / (radius * radius);
    if (!(q > 0) || vec_dot(normal, r->normal) < 1 - same_plane ||
        fabs(vec_dot(away, normal)) > same_plane * cache->scene->diameter)
        return 0;
    return q * q;
}

/* All records valid at a place, seen from there or not. */
static size_t find_neighbours(const light_cache *cache, const double x[3], const double normal[3],
                              double part, neighbour *found)
{
    const cache_node *nodes = cache->nodes.items;
    const sort_key *order = cache->order.items;
    size_t stack[DEPTH_MAX], depth = 0, count = 0;

    if (cache->nodes.count > 0)
        stack[depth++] = 0;
    while (depth > 0) {
        const cache_node *node = &nodes[stack[--depth]];

        if (!may_hold(node, x, normal))
            continue;
        if (node->child) {
            stack[depth++] = node->child + 1;
            stack[depth++] = node->child;
            continue;
        }
        for (size_t i = node->first; i < node->first + node->count && count < NEAR_MAX; i++) {
            const cache_record *r = cache_record_at(cache, order[i].record);
            const double kernel = kernel_at(cache, r, part * r->radius, x, normal);

            if (kernel > 0)
                found[count++] = (neighbour){r, kernel, kernel};
        }
    }
    return count;
}

/* Keeps those that nothing stands before. Where no record is fenced off, nothing does. */
static size_t keep_seen(const light_cache *cache, const double x[3], const double normal[3],
                        neighbour *found, size_t count)
{
    size_t seen = 0;
    int fenced = 0;

    for (size_t i = 0; i < count && !fenced; i++)
        fenced = found[i].record->fenced;
    if (!fenced)
        return count;
    for (size_t i = 0; i < count; i++)
        if (!blocked(cache, x, normal, found[i].record->x))
            found[seen++] = found[i];
    return seen;
}

void cache_fence(const light_cache *cache, size_t record)
{
    cache_record *r = cache_record_at(cache, record);
    neighbour found[NEAR_MAX];
    const size_t count = find_neighbours(cache, r->x, r->normal, 1, found);

    r->fenced = 0;
    for (size_t i = 0; i < count && !r->fenced; i++)
        r->fenced = found[i].record != r && blocked(cache, r->x, r->normal, found[i].record->x);
}

/* ---- regression ---- */

/* What a fit at a place needs: frame, scale of lengths and of values, noise of a record. */
typedef struct model {
    double u[3], v[3], radius;
    double
        shape[3]; /* of a u + b v in the mean ellipse: (shape0 a + shape1 b, shape2 b) / radius */
    double mean;
    double variance; /* of one sample */
} model;

static double mean_of(const light_cache *cache, const double *values)
{
    double sum = 0;

    for (size_t c = 0; c < cache->channels; c++)
        sum += values[c] / (double)cache->channels;
    return sum;
}

/* The mean of the records' ellipses, of small ones most. */
static void set_shape(double part, const neighbour *near, size_t count, model *m)
{
    double weights = 0, uu = 0, uv = 0, vv = 0;

    m->radius = 0;
    for (size_t i = 0; i < count; i++) {
        const cache_record *record = near[i].record;
        const double r = part * record->radius, w = near[i].kernel / (r * r * r * r);
        const double u = vec_dot(record->along, m->u), v = vec_dot(record->along, m->v);

        weights += w;
        m->radius += w * r;
        uu += w * shortened(record) * u * u;
        uv += w * shortened(record) * u * v;
        vv += w * shortened(record) * v * v;
    }
    m->radius /= weights;
    m->shape[0] = sqrt(1 - uu / weights);
    m->shape[1] = -uv / weights / m->shape[0];
    m->shape[2] = sqrt(1 - vv / weights - m->shape[1] * m->shape[1]);
}

/* Small records outweigh large ones: they were made small because light changes there. The noise
 * is that of all: a record's own would favour those that have missed something bright. */
static void weigh(const light_cache *cache, double part, neighbour *near, size_t count, model *m)
{
    double weights = 0, variance = 0;

    m->mean = 0;
    for (size_t i = 0; i < count; i++) {
        const cache_record *r = near[i].record;
        const double q = fmin(1, m->radius / (part * r->radius)), samples = r->samples;

        near[i].weight = near[i].kernel * q * q * q * q;
        weights += near[i].weight * samples;
        m->mean += near[i].weight * samples * mean_of(cache, r->value);
        variance += near[i].weight * samples * samples * r->variance;
    }
    m->mean = fmax(m->mean / weights, cache->floor);
    m->variance = variance / weights;
}

static void terms_at(const model *m, const double x[3], const cache_record *r, double f[TERMS])
{
    double away[3], u, v, a, b;

    vec_sub(r->x, x, away);
    u = vec_dot(away, m->u) / m->radius;
    v = vec_dot(away, m->v) / m->radius;
    a = m->shape[0] * u + m->shape[1] * v;
    b = m->shape[2] * v;
    f[0] = 1;
    f[1] = a;
    f[2] = b;
    f[3] = a * a;
    f[4] = a * b;
    f[5] = b * b;
}

/* Cholesky factor L of a positive definite matrix, in its lower half. */
static void factorise(double a[TERMS][TERMS])
{
    for (int i = 0; i < TERMS; i++)
        for (int j = 0; j <= i; j++) {
            double sum = a[i][j];

            for (int k = 0; k < j; k++)
                sum -= a[i][k] * a[j][k];
            a[i][j] = i == j ? sqrt(sum) : sum / a[j][j];
        }
}

/* x = (L L^T)^-1 x */
static void substitute(double l[TERMS][TERMS], double x[TERMS])
{
    for (int i = 0; i < TERMS; i++) {
        for (int k = 0; k < i; k++)
            x[i] -= l[i][k] * x[k];
        x[i] /= l[i][i];
    }
    for (int i = TERMS - 1; i >= 0; i--) {
        for (int k = i + 1; k < TERMS; k++)
            x[i] -= l[k][i] * x[k];
        x[i] /= l[i][i];
    }
}

/* Mean square by which records differ from the fit beyond what noise explains; that of so many as
 * are more than the polynomial has terms is by chance up to twice its deviation larger. */
static double misfit_of(const light_cache *cache, const model *m, const double x[3],
                        const neighbour *near, size_t count, const double fit[TERMS], double own)
{
    double square = 0, weights = 0, squares = 0, spare;

    for (size_t i = 0; i < count; i++) {
        const double noise = m->variance / near[i].record->samples + own;
        double f[TERMS], off = mean_of(cache, near[i].record->value);

        terms_at(m, x, near[i].record, f);
        for (int k = 0; k < TERMS; k++)
            off -= fit[k] * f[k];
        square += near[i].weight * off * off / noise;
        weights += near[i].weight;
        squares += near[i].weight * near[i].weight;
    }
    spare = fmax(weights * weights / squares - TERMS, 1);
    return fmax(0, square / weights - 1 - 2 * sqrt(2 / spare));
}

void cache_fit_at(const light_cache *cache, const double x[3], const double normal[3], double part,
                  cache_fit *out)
{
    neighbour near[NEAR_MAX];
    double a[TERMS][TERMS] = {{0}}, b[CACHE_CHANNELS][TERMS] = {{0}};
    double first[TERMS] = {1}, all[TERMS] = {0}, own;
    model m;

    memset(out, 0, sizeof *out);
    out->count = keep_seen(cache, x, normal, near, find_neighbours(cache, x, normal, part, near));
    if (out->count == 0)
        return;
    vec_frame(normal, m.u, m.v);
    set_shape(part, near, out->count, &m);
    weigh(cache, part, near, out->count, &m);
    out->radius = m.radius;
    out->stretch = 1 / (m.shape[0] * m.shape[2]);
    out->variance = m.variance;
    if (!(m.mean > 0))
        return;
    own = cache->tolerance * cache->tolerance * m.mean * m.mean;
    for (size_t i = 0; i < out->count; i++) {
        const double noise = m.variance / near[i].record->samples + own;
        double f[TERMS];

        terms_at(&m, x, near[i].record, f);
        for (int j = 0; j < TERMS; j++) {
            const double p = near[i].weight / noise * f[j];

            for (int k = 0; k <= j; k++)
                a[j][k] += p * f[k];
            for (size_t c = 0; c < cache->channels; c++)
                b[c][j] += p * near[i].record->value[c];
        }
    }
    for (int j = 1; j < TERMS; j++) {
        const double spread = (j < 3 ? prior_linear : prior_quadratic) * m.mean;

        a[j][j] += 1 / (spread * spread);
    }
    factorise(a);
    substitute(a, first);
    for (size_t c = 0; c < cache->channels; c++)
        for (int j = 0; j < TERMS; j++) {
            out->value[c] += first[j] * b[c][j];
            all[j] += b[c][j] / (double)cache->channels;
        }
    out->deviation = sqrt(first[0]);
    substitute(a, all);
    out->unrest = sqrt(first[0] * misfit_of(cache, &m, x, near, out->count, all, own));
}
