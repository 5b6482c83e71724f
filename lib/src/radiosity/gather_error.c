/* SPDX-License-Identifier: MIT */
/* How far answers are from the truth: groups of the field's rays tell its noise, and answers are
 * compared with others to the same question. */
#include "radiosity/gather.h"

#include "base/internal.h"
#include "radiosity/krylov.h"
#include "radiosity/patch_light.h"

#include <math.h>
#include <string.h>

enum {
    ITERATIONS_MAX = 4,
    SURVEY_PLACES = 256,
    SURVEY_FEW = 64,
    SURVEY_SAMPLES = 16,
    CANDIDATES = 8
};

typedef struct verdict {
    int lit;
    double noise;                /* difference of two answers, relative */
    double group[GATHER_GROUPS]; /* what each group of the field's rays adds, relative */
    uint64_t rays;
} verdict;

typedef struct verification {
    gather *g;
    verdict *verdicts;
    double *const *groups; /* what they add to the field, or NULL */
    int patches;           /* averages over them instead of points */
    size_t by_area;        /* places; those after them are where it is dark */
} verification;

static double mean_of(const gather *g, const double *values)
{
    double sum = 0;

    for (int c = 0; c < g->channels; c++)
        sum += values[c] / g->channels;
    return sum;
}

/* A place drawn by area, and what is direct there. */
static void ask_point(const gather *g, uint32_t i, uint32_t seed, gather_query *q, double *direct)
{
    double random[2];
    gather_stand stand;

    sobol_point(&g->sobol, i, seed, 0, 2, random);
    (void)gather_place(g, random[0], random[1], &stand);
    gather_query_point(g, stand.x, stand.normal, stand.surface, q);
    light_at(&g->solution->lights, stand.x, stand.normal, stand.surface, direct);
}

/* A place drawn by area over irradiance, one of some drawn by area [Talbot et al. 2005]. */
static void ask_dark(const gather *g, uint32_t i, gather_query *q, double *direct)
{
    uint32_t state = random_hash(i);
    double sum = 0;

    for (uint32_t k = 0; k < CANDIDATES; k++) {
        double light[GATHER_CHANNELS], straight[GATHER_CHANNELS], weight;
        gather_query candidate;

        ask_point(g, i * CANDIDATES + k, 100, &candidate, light);
        memcpy(straight, light, sizeof straight);
        emitters_at(&g->emitters, candidate.stand.x, candidate.stand.normal,
                    candidate.stand.surface, straight);
        weight = 1 / gather_expected(g, &candidate.stand, straight);
        sum += weight;
        if (random_next(&state) * sum > weight)
            continue;
        *q = candidate;
        memcpy(direct, light, sizeof light);
    }
}

/* A patch of a surface drawn by area, and about what is direct there. */
static void ask_patch(const gather *g, uint32_t i, gather_query *q, double *direct)
{
    const scene_surface *s;
    double random[3];
    gather_stand stand;
    size_t count, index;

    sobol_point(&g->sobol, i, 98, 0, 3, random);
    (void)gather_place(g, random[0], random[1], &stand);
    s = scene_surface_at(g->scene, stand.surface);
    count = lcor_scene_patches_of(s);
    index = (size_t)(random[2] * (double)count);
    gather_query_patch(g, stand.surface, LCOR_VALUE_AVERAGE, index < count ? index : count - 1, q);
    if (s->shape == SCENE_QUAD)
        light_at(&g->solution->lights, q->stand.x, q->stand.normal, stand.surface, direct);
    else
        patch_light(&g->solution->lights, stand.surface, LCOR_VALUE_AVERAGE, index, 1,
                    g->solution->options.tolerance, direct);
}

static void verify_task(void *arg, size_t i)
{
    const verification *job = arg;
    const gather *g = job->g;
    verdict *v = &job->verdicts[i];
    double first[GATHER_CHANNELS], second[GATHER_CHANNELS], scale;
    gather_query q;

    memset(v, 0, sizeof *v);
    if (job->patches)
        ask_patch(g, (uint32_t)i, &q, first);
    else if (i < job->by_area)
        ask_point(g, (uint32_t)i, 99, &q, first);
    else
        ask_dark(g, (uint32_t)(i - job->by_area), &q, first);
    memcpy(second, first, sizeof second);
    q.stop *= q.share_effort ? 2 : sqrt(2); /* half the usual effort for each */
    q.groups = job->groups;
    v->rays = gather_answer(g, &q, first, job->groups ? v->group : NULL);
    q.groups = NULL;
    q.seed = random_hash(q.seed + 77);
    v->rays += gather_answer(g, &q, second, NULL);
    v->lit = mean_of(g, first) + mean_of(g, second) > 0;
    scale = fmax(0.5 * (mean_of(g, first) + mean_of(g, second)), engine_dark * g->mean);
    v->noise = v->lit ? (mean_of(g, first) - mean_of(g, second)) / scale : 0;
    for (int k = 0; k < GATHER_GROUPS; k++)
        v->group[k] /= v->lit ? scale : 1;
}

/* Squared error of an answer of the usual effort, by the difference of two with half of it. */
static double square_of_answer(const verdict *v) { return 0.25 * v->noise * v->noise; }

/* And due to the field, by the spread of what its groups add. */
static double square_of_field(const verdict *v)
{
    double sum = 0, square = 0;

    for (int k = 0; k < GATHER_GROUPS; k++) {
        sum += v->group[k];
        square += v->group[k] * v->group[k];
    }
    return (square - sum * sum / GATHER_GROUPS) / (GATHER_GROUPS * (GATHER_GROUPS - 1));
}

double gather_upper_end(size_t count) { return 1 + 1 / sqrt((double)count); }

void gather_sum_errors(gather_errors *e, size_t count)
{
    e->rms = sqrt(e->noise * e->noise + e->field * e->field) * gather_upper_end(count);
}

static void summarise(const verdict *verdicts, size_t n, gather_errors *out)
{
    double noise = 0, field = 0, count = 0;
    verdict all = {0, 0, {0}, 0};

    memset(out, 0, sizeof *out);
    for (size_t i = 0; i < n; i++) {
        const verdict *v = &verdicts[i];
        if (!v->lit)
            continue;
        count++;
        noise += square_of_answer(v);
        field += square_of_field(v);
        for (int k = 0; k < GATHER_GROUPS; k++)
            all.group[k] += v->group[k];
        out->max = fmax(out->max, sqrt(square_of_answer(v) + square_of_field(v)));
    }
    if (!(count > 0))
        return;
    out->noise = sqrt(noise / count);
    out->field = sqrt(field / count);
    out->bias = sqrt(square_of_field(&all)) / count;
    gather_sum_errors(out, (size_t)count);
}

/* ---- the field ---- */

/* A place, what is there by the field, and what groups of rays add to that. */
typedef struct survey_place {
    uint32_t leaf;
    double at[2], value;
    verdict verdict;
} survey_place;

typedef struct survey {
    const gather *g;
    survey_place places[SURVEY_PLACES];
} survey;

static double mean_of_field(const gather *g, const survey_place *p, const double *field)
{
    double values[GATHER_CHANNELS];

    for (int c = 0; c < g->channels; c++)
        values[c] = gather_field_at(g, field, p->leaf, p->at, c);
    return mean_of(g, values);
}

static void survey_task(void *arg, size_t i)
{
    survey *job = arg;
    const gather *g = job->g;
    survey_place *p = &job->places[i];
    double total[GATHER_CHANNELS];
    gather_query q;

    memset(p, 0, sizeof *p);
    ask_point(g, (uint32_t)i, 7, &q, total);
    p->leaf = gather_leaf_at_stand(g, &q.stand, p->at);
    if (p->leaf == gather_none) {
        q.stop = 1;
        q.samples = SURVEY_SAMPLES;
        q.seed = (uint32_t)i;
        p->verdict.rays = gather_answer(g, &q, total, NULL);
    } else {
        emitters_at(&g->emitters, q.stand.x, q.stand.normal, q.stand.surface, total);
    }
    p->value = mean_of(g, total);
    if (p->leaf != gather_none)
        p->value += fmax(mean_of_field(g, p, g->field), 0);
}

static int look_around(gather *g, survey *job, size_t n)
{
    int ok;

    job->g = g;
    ok = gather_each(g, n, survey_task, job);
    g->mean = 0;
    for (size_t i = 0; ok && i < n; i++)
        g->mean += job->places[i].value / (double)n;
    return ok;
}

int gather_survey(gather *g)
{
    survey *job = lcor_internal_alloc(g->allocator, sizeof *job);
    const int ok = job && look_around(g, job, SURVEY_FEW);
    uint64_t rays = 0;

    for (size_t i = 0; ok && i < SURVEY_FEW; i++)
        rays += job->places[i].verdict.rays;
    g->rays += rays;
    g->rays_per_sample = (double)(rays + 1) / (SURVEY_FEW * SURVEY_SAMPLES);
    lcor_internal_free(g->allocator, job);
    return ok;
}

/* What each group of rays alone would add to the field: e = r + K e, where r is what the group's
 * rays of a leaf say more than the field does. Rays of one leaf are independent of another's, and
 * groups nearly so, hence the spread of the e is that of the field [Quenouille 1956]. Answers do
 * not read it where they are: they err by K e. */
static int find_group_errors(gather *g, survey *job)
{
    const size_t n = g->slots * (size_t)g->channels * GATHER_TERMS;
    double *error = lcor_internal_alloc(g->allocator, (n + 1) * sizeof *error);
    int ok = error != NULL;

    if (ok)
        gather_residuals(g, g->groups);
    for (int k = 0; ok && k < GATHER_GROUPS; k++) {
        krylov solver = {
            .n = n, .map = gather_apply, .arg = g, .tolerance = 0.1, .iterations = ITERATIONS_MAX};

        ok = krylov_solve(&solver, g->allocator, g->groups[k], error);
        for (int i = 0; ok && i < SURVEY_PLACES; i++) {
            survey_place *p = &job->places[i];

            if (p->leaf != gather_none)
                p->verdict.group[k] =
                    (mean_of_field(g, p, error) - mean_of_field(g, p, g->groups[k])) /
                    fmax(p->value, engine_dark * g->mean);
        }
        memcpy(g->groups[k], error, n * sizeof *error);
    }
    lcor_internal_free(g->allocator, error);
    return ok;
}

static int reserve_groups(gather *g)
{
    const size_t values = g->slots * (size_t)g->channels * GATHER_TERMS + 1;

    lcor_internal_free(g->allocator, g->groups[0]);
    g->groups[0] = lcor_internal_alloc(g->allocator, GATHER_GROUPS * values * sizeof *g->groups[0]);
    for (size_t k = 1; g->groups[0] && k < GATHER_GROUPS; k++)
        g->groups[k] = g->groups[0] + k * values;
    return g->groups[0] != NULL;
}

int gather_judge_field(gather *g, gather_errors *out)
{
    survey *job = lcor_internal_alloc(g->allocator, sizeof *job);
    const int ok =
        job && reserve_groups(g) && look_around(g, job, SURVEY_PLACES) && find_group_errors(g, job);

    if (ok) {
        verdict verdicts[SURVEY_PLACES];

        for (int i = 0; i < SURVEY_PLACES; i++) {
            verdicts[i] = job->places[i].verdict;
            verdicts[i].lit = job->places[i].leaf != gather_none && job->places[i].value > 0;
        }
        summarise(verdicts, SURVEY_PLACES, out);
    }
    lcor_internal_free(g->allocator, job);
    return ok;
}

/* ---- answers ---- */

/* Answers and judges places or patches, and `dark` more places where it is dark for their largest
 * error. */
static int verify(gather *g, double *const *groups, int patches, size_t dark, gather_errors *out)
{
    const size_t n = g->places;
    verdict *verdicts = lcor_internal_alloc(g->allocator, (n + dark) * sizeof *verdicts);
    verification job = {g, verdicts, groups, patches, n};
    const int ok = verdicts && gather_each(g, n + dark, verify_task, &job);
    gather_errors worst;

    if (ok) {
        summarise(verdicts, n, out);
        summarise(verdicts + n, dark, &worst);
        out->max = fmax(out->max, worst.max);
    }
    for (size_t i = 0; ok && i < n + dark; i++)
        g->rays += verdicts[i].rays;
    lcor_internal_free(g->allocator, verdicts);
    return ok;
}

int gather_estimate(gather *g, gather_errors *out)
{
    const size_t dark =
        g->solution->options.norm == LCOR_NORM_MAX && g->mean > 0 ? g->places / 2 : 0;

    return verify(g, g->groups[0] ? g->groups : NULL, 0, dark, out);
}

int gather_patch_noise(gather *g, double *noise)
{
    gather_errors errors;
    const int ok = verify(g, NULL, 1, 0, &errors);

    *noise = ok ? errors.noise : 0;
    return ok;
}
