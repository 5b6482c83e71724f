/* SPDX-License-Identifier: MIT */
/* Engine `links` behind the solver's face: the tolerance loop and its limits. */
#include "base/internal.h"
#include "radiosity/engine.h"
#include "radiosity/evaluate.h"
#include "radiosity/links.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { ROUNDS_MAX = 12, ITERATIONS_MAX = 50 };

/* Every face is a candidate sender of every other one. */
static const size_t faces_max = 2000;

/* Parts of the tolerance: what one link may err (of a tolerance of 1 %, and less of a smaller one),
 * what the near field and the solver may. */
static const double link_share = 1, hidden_share = 0.16, near_share = 2, solver_share = 0.03;

/* Below it two nodes a patch are not enough along edges. */
static const double fine_tolerance = 5e-4;

/* What a round that missed may change at most and at least. */
static const double tighten_most = 0.1, tighten_least = 0.6;

/* Rounds in a row that may bring less than this before the elements are taken to be too large, as
 * in a gap far narrower than a patch. */
enum { STALE_MAX = 2 };
static const double progress_least = 0.9;

/* A sample that misses by less than that may have met a rare place: a larger one, which costs less
 * than another round, decides. */
static const double near_miss = 2;
enum { LARGER = 4 };

/* How much worse than the worst of the sampled points the worst patch may be. */
static const double unseen = 2;

static uint64_t bytes_held(const links *l)
{
    const size_t values = RULE_Q * (size_t)l->channels;

    return l->faces.capacity * sizeof(face) + l->elements.capacity * sizeof(links_element) +
           l->list.capacity * sizeof(links_link) + l->blocks.capacity * sizeof(links_block) +
           l->factors.capacity * RULE_Q * sizeof(double) +
           (l->occluders.capacity + l->scratch.capacity) * sizeof(uint32_t) +
           (l->irradiance.capacity + l->radiosity.capacity + l->source.capacity) * sizeof(double) *
               values +
           l->deviation.capacity * sizeof(float) * values +
           l->mean.capacity * (size_t)l->channels * sizeof(links_mean) +
           l->work.capacity * sizeof(double) + l->basis_bytes;
}

static double wanted_error(const lcor_solution *s, const links_errors *e)
{
    return s->options.norm == LCOR_NORM_MAX ? unseen * e->max : e->rms;
}

static size_t sample_count(const lcor_solution *s)
{
    if (s->options.norm == LCOR_NORM_MAX)
        return 512;
    return s->options.tolerance >= 5e-3 ? 64 : 192;
}

/* Reports progress, a little more each time as the end is not known; minds the limits. */
static void poll(links *l)
{
    lcor_solution *s = (lcor_solution *)l->poll_arg;
    const uint64_t wanted = (l->list.count - l->blocks.count) * sizeof(links_block);

    l->hurry |= engine_over_limit(s, bytes_held(l) + wanted);
    l->cancelled |= engine_progress(s, s->done + 0.002 * (1 - s->done));
}

static lcor_status prepare(lcor_solution *s, lcor_error *err)
{
    links *l = lcor_internal_alloc(&s->allocator, sizeof *l);

    s->state = l;
    if (!l)
        return lcor_internal_fail(err, LCOR_ERR_NOMEM, -1, "radiosity: no memory for elements");
    memset(l, 0, sizeof *l);
    l->scene = s->scene;
    l->allocator = s->allocator;
    l->parallel = s->options.parallel;
    l->share = s->options.norm == LCOR_NORM_RMS;
    l->lights = &s->lights;
    l->channels = s->report.channels;
    l->poll = poll;
    l->poll_arg = s;
    if (!links_init(l))
        return lcor_internal_fail(err, LCOR_ERR_NOMEM, -1, "radiosity: no memory for elements");
    if (l->faces.count > faces_max)
        return lcor_internal_fail(err, LCOR_ERR_DOMAIN, -1,
                                  "radiosity: %lu faces are too many for engine links (%lu)",
                                  (unsigned long)l->faces.count, (unsigned long)faces_max);
    face_count_merged(l->scene, l->sides, &s->report.surfaces_merged, &s->report.merged_into);
    return LCOR_OK;
}

static void release(lcor_solution *s)
{
    if (s->state)
        links_clear((links *)s->state);
    lcor_internal_free(&s->allocator, s->state);
    s->state = NULL;
}

static void describe(lcor_solution *s)
{
    const lcor_scene *scene = s->scene;
    const links *l = (const links *)s->state;
    size_t open = 0, partial = 0;
    char merged[64] = "";

    for (size_t i = 0; i < scene->lights.count; i++)
        open += s->lights.open[i];
    for (size_t i = 0; i < l->list.count; i++)
        partial += ((const links_link *)l->list.items)[i].occluder_count > 0;
    if (s->report.surfaces_merged > 0)
        (void)snprintf(merged, sizeof merged, "%lu coplanar surfaces merged into %lu; ",
                       (unsigned long)s->report.surfaces_merged,
                       (unsigned long)s->report.merged_into);
    (void)snprintf(
        s->report.models, sizeof s->report.models,
        "links of order %d; %s%s; %lu of %lu links clipped; shadows of %lu of %lu lights; "
        "%d channel%s",
        RULE_P, merged, scene->convex ? "convex, no visibility tests" : "exact visibility",
        (unsigned long)partial, (unsigned long)l->list.count,
        (unsigned long)(scene->lights.count - open), (unsigned long)scene->lights.count,
        s->report.channels, s->report.channels == 1 ? "" : "s");
}

static int estimate(const lcor_solution *s, links_errors *errors)
{
    links *l = (links *)s->state;
    double wanted;

    if (!links_estimate(l, sample_count(s), errors))
        return 0;
    wanted = wanted_error(s, errors);
    return s->options.norm == LCOR_NORM_MAX || wanted <= s->options.tolerance ||
           wanted > near_miss * s->options.tolerance ||
           links_estimate(l, LARGER * sample_count(s), errors);
}

/* Refine, solve, measure; tighten until the estimate is within the tolerance. */
static lcor_status solve(lcor_solution *s, lcor_error *err)
{
    const double tolerance = s->options.tolerance;
    links *l = (links *)s->state;
    double best = HUGE_VAL;
    int stale = 0;

    l->eps =
        (s->scene->convex ? link_share : hidden_share) * tolerance * pow(tolerance / 0.01, 0.3);
    l->accuracy = near_share * tolerance;
    l->finest = tolerance >= fine_tolerance ? 1 : 0.5;
    l->hurry = l->cancelled = 0;
    for (int round = 0; round < ROUNDS_MAX; round++) {
        links_errors errors;

        if (!links_refine(l) || !links_fill(l))
            goto stopped;
        links_set_source(l);
        if (!links_solve(l, solver_share * tolerance, ITERATIONS_MAX) || !estimate(s, &errors))
            goto stopped;
        s->report.error_rms = errors.rms;
        s->report.error_max = errors.max;
        s->report.energy_defect = l->energy_defect;
        s->report.iterations = l->iterations;
        s->report.links = l->list.count;
        s->report.elements = l->elements.count;
        s->report.pairs_apart = l->pairs_apart;
        s->report.pairs_open = l->pairs_open;
        s->report.pairs_tested = l->pairs_tested;
        if (bytes_held(l) > s->report.bytes)
            s->report.bytes = bytes_held(l);
        s->report.converged = wanted_error(s, &errors) <= tolerance;
        stale = wanted_error(s, &errors) > progress_least * best ? stale + 1 : 0;
        best = fmin(best, wanted_error(s, &errors));
        if (s->report.converged || l->hurry || stale == STALE_MAX)
            break;
        l->eps *=
            fmax(tighten_most, fmin(tighten_least, 0.7 * tolerance / wanted_error(s, &errors)));
        if (round % 2 == 1) /* elements first, then smaller ones: the latter cost more */
            l->finest *= 0.5;
    }
    describe(s);
    return LCOR_OK;

stopped:
    if (l->cancelled)
        return lcor_internal_fail(err, LCOR_ERR_CANCELLED, -1, "radiosity: cancelled");
    return lcor_internal_fail(err, LCOR_ERR_NOMEM, -1, "radiosity: no memory for the links");
}

static lcor_status relight(lcor_solution *s, lcor_error *err)
{
    links *l = (links *)s->state;

    if (!face_still_holds(l->scene, l->sides)) {
        release(s);
        return prepare(s, err);
    }
    return links_relight(l) ? LCOR_OK
                            : lcor_internal_fail(err, LCOR_ERR_NOMEM, -1, "update: no memory");
}

static void patches(const lcor_solution *s, size_t surface, lcor_value value, size_t first,
                    size_t count, double *total)
{
    links_patches((const links *)s->state, surface, value, first, count, total);
}

static void point(const lcor_solution *s, const double x[3], const double normal[3],
                  uint32_t surface, uint32_t seed, double *total)
{
    const links *l = (const links *)s->state;
    double indirect[3];

    (void)seed; /* no noise */
    links_point(l, x, normal, surface, l->accuracy, indirect);
    for (int c = 0; c < l->channels; c++)
        total[c] += indirect[c];
}

const engine engine_links = {LCOR_ENGINE_LINKS, 64,      512,   prepare, release, solve,
                             relight,           patches, point, NULL,    NULL};
