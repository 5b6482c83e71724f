/* SPDX-License-Identifier: MIT */
/* How far answers are from the truth: the field's balance is tried with rays of its own, and
 * answers are compared with others to the same question. */
#include "radiosity/gather.h"

#include "base/internal.h"
#include "radiosity/krylov.h"

#include <math.h>
#include <string.h>

enum { TRIES_LEAST = 16, HALVES = 2, ITERATIONS_MAX = 8 };

/* Rays that try a leaf, of those that made it. */
static const double tries_share = 0.5;
static const double dark_share = 0.02;

/* The residual r = S + K F - F of the field F, mean over each leaf and the channels, by fresh rays.
 * Their halves are independent, so products of what follows from them have no noise of their own
 * on average. */
typedef struct residual {
    gather *g;
    double *half[HALVES]; /* coefficients a leaf and channel: the constant one is set */
} residual;

static void residual_task(void *arg, size_t i)
{
    const residual *job = arg;
    const gather *g = job->g;
    gather_leaf *l = gather_leaf_at(g, i);
    const size_t tries = (size_t)fmax(TRIES_LEAST, tries_share * (double)l->record_count) & ~1u;
    const size_t values = (size_t)g->channels * GATHER_TERMS;
    double used[HALVES] = {0};
    guide_view view;
    const guide_view *guided;

    l->rays = 0;
    if (l->terms == 0)
        return;
    guided = gather_leaf_view(g, l, &view);
    for (size_t k = 0; used[0] + used[1] < (double)tries && k < GATHER_TRIES * tries; k++) {
        double *sum = job->half[k % HALVES] + l->slot * values, at[2];
        gather_sample sample;

        l->rays++;
        if (!gather_leaf_sample(g, i, guided, (uint32_t)(k / HALVES), 1 + (uint32_t)(k % HALVES),
                                at, &sample))
            continue;
        used[k % HALVES]++;
        for (int c = 0; c < g->channels; c++)
            sum[c * GATHER_TERMS] += gather_sample_value(g, &sample, g->field, c) -
                                     gather_field_at(g, (uint32_t)i, at, c);
        l->rays += sample.rays;
    }
    for (int h = 0; h < HALVES; h++)
        for (size_t c = 0; c < values && used[h] > 0; c++)
            job->half[h][l->slot * values + c] /= used[h];
}

/* The field's error e = r + K e for each half, in place of the residual. */
static int find_field_error(gather *g, double *const half[HALVES])
{
    const size_t n = g->slots * (size_t)g->channels * GATHER_TERMS;
    residual job = {g, {half[0], half[1]}};
    double *error;
    int ok = gather_each(g, g->leaves.count, residual_task, &job);

    for (size_t i = 0; i < g->leaves.count; i++)
        g->rays += gather_leaf_at(g, i)->rays;
    error = lcor_internal_alloc(g->allocator, (n + 1) * sizeof *error);
    for (int h = 0; ok && error && h < HALVES; h++) {
        krylov k = {
            .n = n, .map = gather_apply, .arg = g, .tolerance = 0.05, .iterations = ITERATIONS_MAX};

        ok = krylov_solve(&k, g->allocator, half[h], error);
        memcpy(half[h], error, n * sizeof *error);
    }
    lcor_internal_free(g->allocator, error);
    return ok && error != NULL;
}

typedef struct verdict {
    int lit;
    double noise;        /* difference of two answers */
    double bias[HALVES]; /* of both, due to the field; all relative */
    uint64_t rays;
} verdict;

typedef struct verification {
    gather *g;
    verdict *verdicts;
    double *const *half;
} verification;

static double mean_of(const gather *g, const double *values)
{
    double sum = 0;

    for (int c = 0; c < g->channels; c++)
        sum += values[c] / g->channels;
    return sum;
}

static void verify_task(void *arg, size_t i)
{
    const verification *job = arg;
    const gather *g = job->g;
    verdict *v = &job->verdicts[i];
    double random[2], direct[GATHER_CHANNELS], first[GATHER_CHANNELS], second[GATHER_CHANNELS];
    double scale;
    gather_stand stand;
    gather_query q;

    memset(v, 0, sizeof *v);
    sobol_point(&g->sobol, (uint32_t)i, 99, 0, 2, random);
    (void)gather_place(g, random[0], random[1], &stand);
    gather_query_point(g, stand.x, stand.normal, stand.surface, &q);
    light_at(&g->solution->lights, stand.x, stand.normal, stand.surface, direct);
    memcpy(first, direct, sizeof first);
    memcpy(second, direct, sizeof second);
    q.stop *= q.share_effort ? 2 : sqrt(2); /* half the usual effort for each */
    q.errors = job->half;
    v->rays = gather_answer(g, &q, first, v->bias);
    q.errors = NULL;
    q.seed = random_hash(q.seed + 77);
    v->rays += gather_answer(g, &q, second, NULL);
    v->lit = mean_of(g, first) + mean_of(g, second) > 0;
    scale = fmax(0.5 * (mean_of(g, first) + mean_of(g, second)), dark_share * g->mean);
    v->noise = v->lit ? (mean_of(g, first) - mean_of(g, second)) / scale : 0;
    for (int h = 0; h < HALVES; h++)
        v->bias[h] /= v->lit ? scale : 1;
}

/* Squared error of an answer of the usual effort, by the difference of two with half of it. */
static double square_of_answer(const verdict *v) { return 0.25 * v->noise * v->noise; }

double gather_upper_end(size_t count) { return 1 + 1 / sqrt((double)count); }

void gather_sum_errors(gather_errors *e, size_t count)
{
    e->rms = sqrt(e->noise * e->noise + e->field * e->field) * gather_upper_end(count);
}

static void summarise(const verdict *verdicts, size_t n, gather_errors *out)
{
    double noise = 0, square = 0, count = 0;

    memset(out, 0, sizeof *out);
    for (size_t i = 0; i < n; i++) {
        const verdict *v = &verdicts[i];
        const double bias = 0.5 * (v->bias[0] + v->bias[1]);

        if (!v->lit)
            continue;
        count++;
        noise += square_of_answer(v);
        square += v->bias[0] * v->bias[1];
        out->bias += bias;
        out->max = fmax(out->max, sqrt(square_of_answer(v) + bias * bias));
    }
    if (!(count > 0))
        return;
    out->bias /= count;
    out->noise = sqrt(noise / count);
    out->field = sqrt(fmax(square / count, 0));
    gather_sum_errors(out, (size_t)count);
}

int gather_estimate(gather *g, size_t n, gather_errors *out)
{
    const size_t values = g->slots * (size_t)g->channels * GATHER_TERMS + 1;
    double *half[HALVES], *room = lcor_internal_alloc(g->allocator, HALVES * values * sizeof *room);
    verdict *verdicts = lcor_internal_alloc(g->allocator, n * sizeof *verdicts);
    verification job = {g, verdicts, half};
    int ok = room && verdicts;

    if (ok) {
        memset(room, 0, HALVES * values * sizeof *room);
        for (size_t h = 0; h < HALVES; h++)
            half[h] = room + h * values;
        ok = find_field_error(g, half) && gather_each(g, n, verify_task, &job);
    }
    if (ok)
        summarise(verdicts, n, out);
    for (size_t i = 0; ok && i < n; i++)
        g->rays += verdicts[i].rays;
    lcor_internal_free(g->allocator, room);
    lcor_internal_free(g->allocator, verdicts);
    return ok;
}
