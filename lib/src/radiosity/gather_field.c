/* SPDX-License-Identifier: MIT */
/* The field: rays of every leaf, traced once, and the polynomials that agree with them. */
#include "radiosity/gather.h"

#include "base/internal.h"
#include "geometry/vec.h"
#include "radiosity/krylov.h"

#include <math.h>
#include <string.h>

enum { ITERATIONS_MAX = 60, RAYS_PER_TERM = 4, DARK_PLACES = 8 };

/* Half sizes, in mean ray lengths and less where it is dark, below which a leaf's polynomial is
 * constant or linear. */
static const double constant_below = 0.05, linear_below = 0.4;
/* Ridge of the least squares, against few rays in a corner of a leaf. */
static const double ridge = 0.004;
/* Least and most rays of a leaf, of the average. */
static const double rays_least = 0.25, rays_most = 4;
/* Least where a promise holds everywhere. */
static const double rays_uniform = 64;
/* Least average whatever the limits. */
static const double rays_fewest = 8;
/* The solver's part of the tolerance. */
static const double solver_share = 0.02;

static gather_record *record_at(const gather *g, size_t i)
{
    return (gather_record *)g->records.items + i;
}

static void basis(double x, double y, double f[GATHER_TERMS])
{
    f[0] = 1;
    f[1] = x;
    f[2] = y;
    f[3] = 1.5 * x * x - 0.5;
    f[4] = x * y;
    f[5] = 1.5 * y * y - 0.5;
}

static size_t coefficients_of(const gather *g, const gather_leaf *l, int channel)
{
    return (l->slot * (size_t)g->channels + (size_t)channel) * GATHER_TERMS;
}

/* The polynomial of GATHER_TERMS coefficients at coordinates of -1..1. */
static double polynomial(const double *a, double x, double y)
{
    double f[GATHER_TERMS], sum = 0;

    basis(x, y, f);
    for (int k = 0; k < GATHER_TERMS; k++)
        sum += a[k] * f[k];
    return sum;
}

static double evaluate(const gather *g, const gather_leaf *l, const double *field,
                       const double at[2], int channel)
{
    return polynomial(field + coefficients_of(g, l, channel), (at[0] - l->centre[0]) / l->half[0],
                      (at[1] - l->centre[1]) / l->half[1]);
}

double gather_field_at(const gather *g, const double *field, uint32_t leaf, const double at[2],
                       int channel)
{
    return evaluate(g, gather_leaf_at(g, leaf), field, at, channel);
}

double gather_sample_value(const gather *g, const gather_sample *sample, const double *field,
                           int channel)
{
    double value = sample->source[channel];

    if (sample->leaf != gather_none)
        value += sample->through[channel] *
                 evaluate(g, gather_leaf_at(g, sample->leaf), field, sample->at, channel);
    return value;
}

/* ---- rays ---- */

static int degree_terms(const gather_leaf *l)
{
    const double size = fmax(l->half[0], l->half[1]) / (l->ray_length * sqrt(l->brightness));
    const size_t most = l->record_count / RAYS_PER_TERM;

    if (size < constant_below || most < 3)
        return 1;
    return size < linear_below || most < GATHER_TERMS ? 3 : GATHER_TERMS;
}

/* Rays of a leaf, on average, that time and memory allow. */
static double rays_allowed(const gather *g, size_t leaves)
{
    const uint64_t most = g->solution->options.max_bytes;
    const double record = sizeof(gather_record) + 2 * (double)g->channels * sizeof(float);
    double rays = 0.25 * gather_rays_left(g) / (double)leaves;

    if (most > 0)
        rays =
            fmin(rays, fmax((double)most - (double)gather_bytes(g), 0) / (record * (double)leaves));
    return fmax(rays, rays_fewest);
}

/* Records and what belongs to them. */
typedef struct record_store {
    lcor_array records;
    float *source, *through;
} record_store;

static record_store take_store(gather *g)
{
    const record_store store = {g->records, g->source, g->through};

    memset(&g->records, 0, sizeof g->records);
    g->source = g->through = NULL;
    return store;
}

static void clear_store(const gather *g, record_store *store)
{
    lcor_array_clear(g->allocator, &store->records);
    lcor_internal_free(g->allocator, store->source);
    lcor_internal_free(g->allocator, store->through);
}

static int reserve_store(gather *g, size_t count)
{
    const size_t values = (count + 1) * (size_t)g->channels;

    g->source = lcor_internal_alloc(g->allocator, values * sizeof *g->source);
    g->through = lcor_internal_alloc(g->allocator, values * sizeof *g->through);
    return g->source && g->through &&
           lcor_array_reserve(g->allocator, &g->records, count, sizeof(gather_record));
}

/* A leaf's records from where they were in the store. */
static void move_records(gather *g, const record_store *from, size_t first, const gather_leaf *l)
{
    const size_t channels = (size_t)g->channels, count = l->record_count;

    if (count == 0)
        return;
    memcpy(record_at(g, l->first_record), (gather_record *)from->records.items + first,
           count * sizeof(gather_record));
    memcpy(g->source + l->first_record * channels, from->source + first * channels,
           count * channels * sizeof *g->source);
    memcpy(g->through + l->first_record * channels, from->through + first * channels,
           count * channels * sizeof *g->through);
}

void gather_forget_records(gather *g)
{
    for (size_t i = 0; i < g->leaves.count; i++) {
        gather_leaf_at(g, i)->record_count = 0;
        gather_leaf_at(g, i)->tries = 0;
    }
}

/* Numbers the leaves. Returns the sum of the roots of their areas. */
static double number_leaves(gather *g)
{
    double sum = 0;

    g->slots = 0;
    for (size_t i = 0; i < g->leaves.count; i++) {
        gather_leaf *l = gather_leaf_at(g, i);

        if (l->terms == 0)
            continue;
        l->slot = g->slots++;
        sum += sqrt(l->area);
    }
    return sum;
}

/* Gives each leaf room for its records. */
static int plan_records(gather *g)
{
    const double area = number_leaves(g), leaves = (double)g->slots;
    const double allowed = rays_allowed(g, g->slots + 1), rays = fmin(g->effort.rays, allowed);
    const double least = g->effort.share ? 0 : fmin(rays_uniform, allowed);
    record_store old = take_store(g);
    size_t count = 0;
    int ok;

    for (size_t i = 0; i < g->leaves.count; i++) {
        gather_leaf *l = gather_leaf_at(g, i);
        const double share = area > 0 ? sqrt(l->area) * leaves / area : 1;
        const size_t wanted = (size_t)fmax(rays * fmin(fmax(share, rays_least), rays_most), least);

        if (l->terms == 0)
            continue;
        l->record_room = wanted > l->record_count ? wanted : l->record_count;
        count += l->record_room;
    }
    ok = reserve_store(g, count);
    count = 0;
    for (size_t i = 0; ok && i < g->leaves.count; i++) {
        gather_leaf *l = gather_leaf_at(g, i);
        const size_t before = l->first_record;

        if (l->terms == 0)
            continue;
        l->first_record = count;
        count += l->record_room;
        move_records(g, &old, before, l);
    }
    g->records.count = count;
    clear_store(g, &old);
    lcor_internal_free(g->allocator, g->field);
    g->field = lcor_internal_alloc(g->allocator, (g->slots + 1) * (size_t)g->channels *
                                                     GATHER_TERMS * sizeof *g->field);
    return ok && g->field;
}

/* The symmetric positive definite n x n matrix, inverted in place by Gauss and Jordan. */
static void invert(int n, double a[GATHER_TERMS][GATHER_TERMS])
{
    for (int p = 0; p < n; p++) {
        const double pivot = 1 / a[p][p];

        a[p][p] = 1;
        for (int k = 0; k < n; k++)
            a[p][k] *= pivot;
        for (int i = 0; i < n; i++) {
            const double factor = a[i][p];

            if (i == p)
                continue;
            a[i][p] = 0;
            for (int k = 0; k < n; k++)
                a[i][k] -= factor * a[p][k];
        }
    }
}

static void set_inverse(const gather *g, gather_leaf *l)
{
    double a[GATHER_TERMS][GATHER_TERMS] = {{0}};

    for (size_t i = 0; i < l->record_count; i++) {
        const gather_record *r = record_at(g, l->first_record + i);
        double f[GATHER_TERMS];

        basis((double)r->from[0], (double)r->from[1], f);
        for (int p = 0; p < l->terms; p++)
            for (int q = 0; q < l->terms; q++)
                a[p][q] += f[p] * f[q];
    }
    a[0][0] = fmax(a[0][0], 1);
    for (int p = 1; p < l->terms; p++)
        a[p][p] += ridge * a[0][0];
    invert(l->terms, a);
    for (int p = 0; p < GATHER_TERMS; p++)
        for (int q = 0; q < GATHER_TERMS; q++)
            l->inverse[p * GATHER_TERMS + q] = a[p][q];
}

/* How a leaf's rays are guided: NULL or `view`. */
static const guide_view *leaf_view(const gather *g, const gather_leaf *leaf, guide_view *view)
{
    gather_stand stand;
    double at[2];

    gather_leaf_stand(g, leaf, 0.5, 0.5, at, &stand);
    return guide_look(g, stand.x, stand.normal, g->mean, GUIDE_FINE, view) ? view : NULL;
}

/* Rays read the field from afar. By reciprocity a place is read as often as a ray from it gets that
 * far, and counts so much in the fit: what is hidden behind furniture must not darken what is
 * seen. */
static int is_read(const gather *g, const gather_leaf *l, const gather_stand *stand, uint32_t seed)
{
    uint32_t state = seed;
    double direction[3];
    lcor_ray ray;

    random_cosine(random_next(&state), random_next(&state), direction);
    vec_copy(stand->x, ray.origin);
    for (int k = 0; k < 3; k++)
        ray.direction[k] = direction[0] * stand->u[k] + direction[1] * stand->v[k] +
                           direction[2] * stand->normal[k];
    ray.t_min = g->touch;
    ray.t_max = gather_reach(l, g->effort.near);
    ray.skip = stand->surface;
    return !lcor_bvh_occluded(g->scene->bvh, &ray, NULL);
}

/* Ray `index` of a leaf, leaving at `at`. Returns 0 for a place that other rays do not come to. */
static int leaf_sample(const gather *g, size_t leaf, const guide_view *view, uint32_t index,
                       double at[2], gather_sample *out)
{
    const uint32_t seed = random_hash((uint32_t)leaf);
    double place[2];
    gather_stand stand;

    sobol_point(&g->sobol, index, seed, 2, 2, place);
    gather_leaf_stand(g, gather_leaf_at(g, leaf), place[0], place[1], at, &stand);
    if (!is_read(g, gather_leaf_at(g, leaf), &stand, random_hash(seed + 5 + index)))
        return 0;
    gather_sample_at(g, &stand, view, g->effort.near, index, seed, out);
    return 1;
}

/* Coordinates in the plane to the leaf's. */
static void normalise(const gather_leaf *l, const double at[2], float out[2])
{
    for (int k = 0; k < 2; k++)
        out[k] = (float)((at[k] - l->centre[k]) / l->half[k]);
}

static void record_task(void *arg, size_t i)
{
    gather *g = arg;
    gather_leaf *l = gather_leaf_at(g, i);
    const guide_view *guided;
    guide_view view;

    l->rays = 0;
    if (l->terms == 0)
        return;
    guided = leaf_view(g, l, &view);
    for (; l->record_count < l->record_room && l->tries < GATHER_TRIES * l->record_room;
         l->tries++) {
        const size_t record = l->first_record + l->record_count;
        const size_t value = record * (size_t)g->channels;
        gather_record *r = record_at(g, record);
        double at[2];
        gather_sample sample;

        l->rays++;
        if (!leaf_sample(g, i, guided, (uint32_t)l->tries, at, &sample))
            continue;
        l->record_count++;
        r->slot = gather_none;
        normalise(l, at, r->from);
        if (sample.leaf != gather_none) {
            r->slot = (uint32_t)gather_leaf_at(g, sample.leaf)->slot;
            normalise(gather_leaf_at(g, sample.leaf), sample.at, r->at);
        }
        for (int c = 0; c < g->channels; c++) {
            g->source[value + (size_t)c] = (float)sample.source[c];
            g->through[value + (size_t)c] = (float)sample.through[c];
        }
        l->rays += sample.rays;
    }
    l->terms = degree_terms(l);
    set_inverse(g, l);
}

/* ---- the linear system ---- */

typedef struct application {
    const gather *g;
    const double *in; /* or NULL: the right side, of sources alone */
    double *out;
} application;

/* What a ray found, but for its source: the part that depends on the field. */
static double passed_on(const gather *g, size_t record, const double *field, int channel)
{
    const gather_record *r = record_at(g, record);
    const size_t channels = (size_t)g->channels, c = (size_t)channel;

    if (r->slot == gather_none)
        return 0;
    return (double)g->through[record * channels + c] *
           polynomial(field + (r->slot * channels + c) * GATHER_TERMS, (double)r->at[0],
                      (double)r->at[1]);
}

static double source_of(const gather *g, size_t record, int channel)
{
    return (double)g->source[record * (size_t)g->channels + (size_t)channel];
}

/* Least squares over a leaf's rays. */
static void apply_task(void *arg, size_t i)
{
    const application *job = arg;
    const gather *g = job->g;
    const gather_leaf *l = gather_leaf_at(g, i);

    for (int c = 0; c < g->channels && l->terms > 0; c++) {
        double moment[GATHER_TERMS] = {0}, *out = job->out + coefficients_of(g, l, c);

        for (size_t k = l->first_record; k < l->first_record + l->record_count; k++) {
            const gather_record *r = record_at(g, k);
            const double irradiance = job->in ? passed_on(g, k, job->in, c) : source_of(g, k, c);
            double f[GATHER_TERMS];

            if (irradiance == 0)
                continue;
            basis((double)r->from[0], (double)r->from[1], f);
            for (int p = 0; p < l->terms; p++)
                moment[p] += f[p] * irradiance;
        }
        for (int p = 0; p < GATHER_TERMS; p++) {
            out[p] = 0;
            for (int q = 0; q < l->terms && p < l->terms; q++)
                out[p] += l->inverse[p * GATHER_TERMS + q] * moment[q];
        }
    }
}

void gather_apply(void *arg, const double *in, double *out)
{
    const gather *g = arg;
    application job = {g, in, out};

    engine_run(g->solution, g->leaves.count, apply_task, &job);
}

static int solve_system(gather *g)
{
    krylov k = {.n = g->slots * (size_t)g->channels * GATHER_TERMS,
                .map = gather_apply,
                .arg = g,
                .tolerance = solver_share * g->solution->options.tolerance,
                .iterations = ITERATIONS_MAX};
    double *right = lcor_internal_alloc(g->allocator, (k.n + 1) * sizeof *right);
    int ok;

    if (!right)
        return 0;
    gather_apply(g, NULL, right);
    ok = krylov_solve(&k, g->allocator, right, g->field);
    g->contraction = k.contraction;
    g->iterations = k.iterations;
    lcor_internal_free(g->allocator, right);
    return ok;
}

typedef struct residuals {
    const gather *g;
    double *const *groups;
} residuals;

/* Groups are runs of the sequence, each spread over the leaf and the hemisphere. A fit of p terms
 * to n rays leaves a part (n - p) / n of their variance. */
static void residual_task(void *arg, size_t i)
{
    const residuals *job = arg;
    const gather *g = job->g;
    const gather_leaf *l = gather_leaf_at(g, i);
    const size_t n = l->record_count;
    const double fitted =
        n > (size_t)l->terms ? sqrt((double)n / (double)(n - (size_t)l->terms)) : 1;

    for (int c = 0; c < g->channels && l->terms > 0; c++)
        for (size_t k = 0; k < GATHER_GROUPS; k++) {
            double *out = job->groups[k] + coefficients_of(g, l, c), sum = 0;
            const size_t begin = n * k / GATHER_GROUPS, end = n * (k + 1) / GATHER_GROUPS;

            for (size_t j = begin; j < end; j++) {
                const gather_record *r = record_at(g, l->first_record + j);
                double f[GATHER_TERMS];

                basis((double)r->from[0], (double)r->from[1], f);
                sum += source_of(g, l->first_record + j, c) +
                       passed_on(g, l->first_record + j, g->field, c);
                for (int p = 0; p < l->terms; p++)
                    sum -= g->field[coefficients_of(g, l, c) + (size_t)p] * f[p];
            }
            memset(out, 0, GATHER_TERMS * sizeof *out);
            out[0] = end > begin ? fitted * sum / (double)(end - begin) : 0;
        }
}

void gather_residuals(const gather *g, double *const groups[GATHER_GROUPS])
{
    residuals job = {g, groups};

    engine_run(g->solution, g->leaves.count, residual_task, &job);
}

/* The darkest of a few places: a leaf that reaches from the light into the dark is to be split. */
static void brightness_task(void *arg, size_t i)
{
    gather *g = arg;
    gather_leaf *l = gather_leaf_at(g, i);
    double least = g->mean;

    for (uint32_t k = 0; k < DARK_PLACES && l->terms > 0; k++) {
        double random[2], at[2], straight[GATHER_CHANNELS] = {0}, sum = 0;
        gather_stand stand;

        sobol_point(&g->sobol, k, random_hash((uint32_t)i), 0, 2, random);
        gather_leaf_stand(g, l, random[0], random[1], at, &stand);
        gather_straight(g, stand.x, stand.normal, stand.surface, straight);
        for (int c = 0; c < g->channels; c++)
            sum += straight[c] + evaluate(g, l, g->field, at, c);
        least = fmin(least, sum / g->channels);
    }
    l->brightness = fmax(least / g->mean, engine_dark);
}

int gather_find_dark(gather *g)
{
    return g->mean > 0 ? gather_each(g, g->leaves.count, brightness_task, g) : 1;
}

int gather_solve_field(gather *g)
{
    if (!plan_records(g) || !gather_each(g, g->leaves.count, record_task, g))
        return 0;
    for (size_t i = 0; i < g->leaves.count; i++)
        g->rays += gather_leaf_at(g, i)->rays;
    return solve_system(g);
}
