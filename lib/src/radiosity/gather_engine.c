/* SPDX-License-Identifier: MIT */
/* Engine `gather` behind the solver's face: what a tolerance takes, and the loop around it. */
#include "base/internal.h"
#include "geometry/vec.h"
#include "radiosity/engine.h"
#include "radiosity/gather.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { ROUNDS_MAX = 8, PASSES_MAX = 5, SLICE = 128 };

/* Places that the error is estimated from; fewer where few are asked for. */
enum { PLACES = 64, PLACES_LEAST = 16 };

/* Leaves wanted, and rays of one on average, at a tolerance of 1 %. */
static const double leaves_wanted = 400, rays_wanted = 100, rays_most = 4096;
/* Rays a second, before any have been traced. */
static const double rate_guess = 3e5;
/* Samples that an answer may take, and those it may always take. */
static const double samples_most = 1 << 18, samples_least = 128;
/* An answer's part of the tolerance at first, where effort is shared and where not, and what is
 * aimed at in the end. */
static const double stop_shared = 1.7, stop_alone = 0.85, aim = 0.75;
/* Paths are noisier the more is asked for: at a shared effort their answers' part is that at this
 * tolerance, and less below in proportion. */
static const double paths_usual = 0.02;
/* Their averages over patches, of the stop of answers at points: nobody asks how they err. */
static const double paths_patch_stop = 0.5;
/* The laxest stop of an answer in the end, of the tolerance. */
static const double stop_most = 0.9;
/* What `stop` alone can improve noise by, without looking again. */
static const double reach = 0.5;
/* Answers are not pursued further than this, and when a limit is met, than that. */
static const double stop_least = 5e-4, stop_hurried = 0.01;
/* Noise goes with this power of `stop` where effort is shared: as many samples are taken as err by
 * stop sqrt(n), and n of them err by n^-1/2, or less. */
static const double shared_power = 0.5;
/* What all answers may err alike by the field they share: this part of the tolerance, and not more
 * than so much; and what of that is aimed at, since it is estimated. */
static const double bias_share = 0.2, bias_most = 0.002, bias_aim = 0.8;
/* Rays of a sample that ends in the field, about: to a target, on to the next surface, and from
 * there. */
static const double rays_to_field = 4;

/* A part of the tasks. */
typedef struct slice {
    void (*task)(void *arg, size_t i);
    void *arg;
    size_t first;
} slice;

static void slice_task(void *arg, size_t i)
{
    const slice *part = arg;

    part->task(part->arg, part->first + i);
}

int gather_each(gather *g, size_t n, void (*task)(void *arg, size_t i), void *arg)
{
    lcor_solution *s = g->solution;

    for (slice part = {task, arg, 0}; part.first < n && !g->cancelled; part.first += SLICE) {
        engine_run(s, n - part.first < SLICE ? n - part.first : SLICE, slice_task, &part);
        g->hurry |= engine_over_limit(s, gather_bytes(g));
        g->cancelled |= engine_progress(s, s->done + 0.01 * (1 - s->done));
    }
    return !g->cancelled;
}

static double seconds_spent(const lcor_solution *s)
{
    return (double)(clock() - s->start) / CLOCKS_PER_SEC;
}

static double seconds_left(const lcor_solution *s)
{
    return s->options.max_seconds > 0 ? fmax(s->options.max_seconds - seconds_spent(s), 0)
                                      : HUGE_VAL;
}

double gather_rays_left(const gather *g)
{
    const double spent = seconds_spent(g->solution);
    const double rate = g->rays > 1000 && spent > 0.001 ? (double)g->rays / spent : rate_guess;

    return seconds_left(g->solution) * rate;
}

uint64_t gather_bytes(const gather *g)
{
    return g->planes.capacity * sizeof(gather_plane) + g->prims.capacity * sizeof(gather_prim) +
           g->nodes.capacity * sizeof(gather_node) + g->leaves.capacity * sizeof(gather_leaf) +
           g->pieces.capacity * sizeof(gather_piece) +
           g->records.capacity * (sizeof(gather_record) + 2 * (size_t)g->channels * sizeof(float)) +
           g->slots * (size_t)g->channels * GATHER_TERMS * sizeof(double) * 10;
}

/* Returns 0 without memory. */
static int set_looks(gather *g)
{
    const light_set *lights = &g->solution->lights;

    if (!emitters_find(&g->emitters, g->allocator, lights))
        return 0;
    g->dark = 1;
    for (size_t i = 0; i < g->scene->lights.count; i++)
        for (int c = 0; c < g->channels; c++)
            if (light_channel(lights, scene_light_at(g->scene, i)->intensity, c) > 0)
                g->dark = 0;
    for (size_t i = 0; i < g->scene->surfaces.count; i++) {
        const lcor_surface *look = &scene_surface_at(g->scene, i)->look;

        for (int c = 0; c < g->channels; c++) {
            g->reflectance[i * (size_t)g->channels + (size_t)c] =
                light_channel(lights, look->reflectance, c);
            g->emission[i * (size_t)g->channels + (size_t)c] =
                g->emitters.exact ? 0 : light_channel(lights, look->emission, c);
            if (light_channel(lights, look->emission, c) > 0)
                g->dark = 0;
        }
    }
    return 1;
}

static lcor_status no_memory(lcor_error *err)
{
    return lcor_internal_fail(err, LCOR_ERR_NOMEM, -1, "radiosity: no memory for the gathering");
}

static lcor_status prepare(lcor_solution *s, lcor_error *err)
{
    const size_t values = s->scene->surfaces.count * (size_t)s->report.channels;
    gather *g = lcor_internal_alloc(&s->allocator, sizeof *g);

    s->state = g;
    if (!g)
        return no_memory(err);
    memset(g, 0, sizeof *g);
    g->solution = s;
    g->scene = s->scene;
    g->allocator = &s->allocator;
    g->channels = s->report.channels;
    g->touch = SCENE_TOUCH * s->scene->diameter;
    sobol_init(&g->sobol);
    g->reflectance = lcor_internal_alloc(g->allocator, values * sizeof *g->reflectance);
    g->emission = lcor_internal_alloc(g->allocator, values * sizeof *g->emission);
    if (!g->reflectance || !g->emission || !gather_list_prims(g) || !gather_find_planes(g) ||
        !set_looks(g))
        return no_memory(err);
    return LCOR_OK;
}

static void release(lcor_solution *s)
{
    gather *g = s->state;

    if (!g)
        return;
    guide_clear(g);
    emitters_clear(&g->emitters, g->allocator);
    lcor_array_clear(g->allocator, &g->planes);
    lcor_array_clear(g->allocator, &g->members);
    lcor_array_clear(g->allocator, &g->prims);
    lcor_array_clear(g->allocator, &g->nodes);
    lcor_array_clear(g->allocator, &g->leaves);
    lcor_array_clear(g->allocator, &g->pieces);
    lcor_array_clear(g->allocator, &g->records);
    lcor_internal_free(g->allocator, g->reflectance);
    lcor_internal_free(g->allocator, g->emission);
    lcor_internal_free(g->allocator, g->plane_of);
    lcor_internal_free(g->allocator, g->facing);
    lcor_internal_free(g->allocator, g->sides);
    lcor_internal_free(g->allocator, g->source);
    lcor_internal_free(g->allocator, g->through);
    lcor_internal_free(g->allocator, g->field);
    lcor_internal_free(g->allocator, g->groups[0]);
    lcor_internal_free(g->allocator, g);
    s->state = NULL;
}

/* Whether rays end in a field; else they all go on as paths. */
static int has_field(const gather *g) { return g->solution->engine->id == LCOR_ENGINE_GATHER; }

/* An estimate of the error must not take longer than what it is of; the largest error takes all
 * places there are. */
size_t engine_paths_places(const lcor_radiosity_options *options)
{
    if (options->norm == LCOR_NORM_MAX || options->points == 0 || options->points > PLACES)
        return PLACES;
    return options->points < PLACES_LEAST ? PLACES_LEAST : (size_t)options->points;
}

static void set_effort(gather *g, double tolerance)
{
    g->places = has_field(g) ? PLACES : engine_paths_places(&g->solution->options);
    g->rays_per_sample = rays_to_field;
    g->effort.share = g->solution->options.norm == LCOR_NORM_RMS;
    g->effort.leaf_size = tolerance >= 0.008 && g->effort.share ? 1 : 1.5;
    g->effort.rays = fmin(fmax(rays_wanted * 0.01 / tolerance, 16), 2048);
    g->effort.near = 0.5;
    g->effort.leaves = (size_t)(leaves_wanted * 0.01 / tolerance);
    g->effort.stop = (g->effort.share ? stop_shared : stop_alone) * tolerance;
    if (g->effort.share && !has_field(g))
        g->effort.stop *= fmin(tolerance / paths_usual, 1);
    g->effort.stop = fmax(g->effort.stop, stop_least);
}

static double bias_allowed(const lcor_solution *s)
{
    return fmin(bias_share * s->options.tolerance, bias_most);
}

static double wanted_error(const lcor_solution *s, const gather_errors *e)
{
    return s->options.norm == LCOR_NORM_MAX ? 2 * e->max : e->rms;
}

static int is_met(const lcor_solution *s, const gather_errors *e)
{
    return wanted_error(s, e) <= s->options.tolerance && e->bias <= bias_allowed(s);
}

static void describe(lcor_solution *s)
{
    const gather *g = s->state;
    size_t fields = 0;

    if (!has_field(g)) {
        (void)snprintf(s->report.models, sizeof s->report.models,
                       "paths; %lu surfaces; %d bright places; %d channel%s",
                       (unsigned long)g->scene->surfaces.count, g->guide.targets[GUIDE_FINE].count,
                       g->channels, g->channels == 1 ? "" : "s");
        return;
    }
    for (size_t i = 0; i < 2 * g->planes.count; i++)
        fields += g->sides[i].root >= 0;
    (void)snprintf(s->report.models, sizeof s->report.models,
                   "final gathering; %lu surfaces in %lu planes, fields on %lu sides; %d bright "
                   "places; %d channel%s",
                   (unsigned long)g->scene->surfaces.count, (unsigned long)g->planes.count,
                   (unsigned long)fields, g->guide.targets[GUIDE_FINE].count, g->channels,
                   g->channels == 1 ? "" : "s");
}

/* The root mean square of the error that leaves the promised one, of the worst place or by the
 * sample's upper end, within the tolerance. */
static double rms_wanted(const lcor_solution *s, const gather_errors *e)
{
    const double rms = sqrt(e->noise * e->noise + e->field * e->field);

    return aim * s->options.tolerance * fmin(rms / fmax(wanted_error(s, e), 1e-9), 1);
}

/* Noise that leaves room for the field's own error. */
static double noise_wanted(double field, double rms)
{
    return sqrt(fmax(rms * rms - field * field, 0.25 * rms * rms));
}

/* Lowers `stop` so that *noise becomes `wanted`, or comes as near as one step may go. */
static void tighten(const gather *g, double wanted, double *stop, double *noise)
{
    const double ratio = fmin(fmax(wanted / fmax(*noise, 1e-9), 0.3), 1), before = *stop;
    const double power = g->effort.share ? shared_power : 1;

    *stop = fmax(stop_least, before * pow(ratio, 1 / power));
    *noise *= pow(*stop / before, power);
}

/* Whether answers may take what they need: where limits hold, `stop` promises nothing. */
static int is_free(const gather *g) { return !g->hurry && g->effort.samples >= samples_most; }

/* Answers are made as accurate as asked for by one step, and no answer's own `stop` is laxer than
 * the request: most are then better, where that takes little. */
static void settle_stop(const gather *g, double wanted, double *stop, double *noise)
{
    const double most = stop_most * g->solution->options.tolerance;

    if (is_free(g))
        tighten(g, fmin(wanted, *noise * pow(fmin(most / *stop, 1), shared_power)), stop, noise);
}

static int is_coarse(const gather_errors *e, double rms) { return e->field > 0.6 * rms; }

/* More of what the error came from. Returns whether the field must be made anew. */
static int strive(gather *g, const gather_errors *e)
{
    const double rms = rms_wanted(g->solution, e);
    const double bias = e->bias / bias_allowed(g->solution);
    const int coarse = is_coarse(e, rms);
    double field = e->field, noise = e->noise;

    if (coarse) {
        gather_forget_records(g); /* they were traced for another `near` */
        g->effort.rays *= 2;
        g->effort.near *= 1.5;
        g->effort.leaf_size *= 0.75;
        field *= 0.5;
    } else if (bias > 1) {
        g->effort.rays *= fmin(fmax(bias * bias, 1.5), 4);
    }
    tighten(g, noise_wanted(field, rms), &g->effort.stop, &noise);
    return coarse || bias > 1;
}

/* Whether the request can be met by the field there is and a `stop` not far from the last. */
static int is_near(const gather *g, const gather_errors *e)
{
    const double rms = rms_wanted(g->solution, e);

    return is_free(g) && !is_coarse(e, rms) && e->bias <= bias_allowed(g->solution) &&
           reach * e->noise <= noise_wanted(e->field, rms);
}

/* Answers are made as accurate as asked for, and no more; averages over patches, whose rays differ
 * by place too, take more than answers at points. */
static int settle(gather *g, gather_errors *e)
{
    const double wanted = noise_wanted(e->field, rms_wanted(g->solution, e));
    const double asked = g->effort.stop;
    double noise = 0;

    settle_stop(g, wanted, &g->effort.stop, &e->noise);
    g->effort.patch_stop = fmin(asked, 2 * g->effort.stop);
    if (has_field(g)) {
        if (!gather_patch_noise(g, &noise))
            return 0;
        settle_stop(g, wanted, &g->effort.patch_stop, &noise);
        e->noise = fmax(e->noise, noise);
    } else {
        g->effort.patch_stop = paths_patch_stop * g->effort.stop;
    }
    gather_sum_errors(e, g->places);
    return 1;
}

/* A first field of few rays, to see where leaves must be finer for a promise that holds
 * everywhere. */
static int find_dark(gather *g)
{
    gather_errors e;

    return gather_grow(g) && gather_solve_field(g) && gather_judge_field(g, &e) &&
           gather_find_dark(g);
}

/* A field that is not wrong all over: as many more rays as that takes. What it errs here and there,
 * answers must tell. */
static int make_field(gather *g)
{
    const double wanted = bias_aim * bias_allowed(g->solution);
    const size_t leaves = g->leaves.count;
    gather_errors e;

    if (!gather_grow(g))
        return 0;
    if (g->leaves.count != leaves) /* records know leaves by number */
        gather_forget_records(g);
    for (int pass = 0;; pass++) {
        if (!gather_solve_field(g) || !gather_judge_field(g, &e))
            return 0;
        if (e.bias <= wanted || pass == PASSES_MAX || g->hurry || g->effort.rays >= rays_most)
            return 1;
        g->effort.rays *= fmin(fmax(pow(e.bias / wanted, 1.5), 1.5), 3);
    }
}

/* One round: a field, unless there is one, and how far its answers are from the truth. Returns 0
 * without memory or when cancelled. */
static int attempt(gather *g, int new_field, gather_errors *errors)
{
    if (new_field && !make_field(g))
        return 0;
    /* Half of the time left for the places of the estimate, each answered twice. */
    g->effort.samples =
        fmin(fmax(0.5 * gather_rays_left(g) / (2 * (double)g->places * g->rays_per_sample),
                  samples_least),
             samples_most);
    if (g->hurry)
        g->effort.stop = fmax(g->effort.stop, stop_hurried);
    g->effort.patch_stop = g->effort.stop;
    return gather_estimate(g, errors);
}

static void report_errors(lcor_solution *s, const gather_errors *errors)
{
    const gather *g = s->state;

    s->report.error_rms = errors->rms;
    s->report.error_max = errors->max;
    s->report.iterations = g->iterations;
    s->report.elements = g->slots;
    s->report.rays = g->rays;
    if (gather_bytes(g) > s->report.bytes)
        s->report.bytes = gather_bytes(g);
}

static lcor_status solve(lcor_solution *s, lcor_error *err)
{
    gather *g = s->state;
    gather_errors errors = {0}, last;
    gather_effort effort;
    int new_field = has_field(g);

    g->cancelled = g->hurry = 0;
    set_effort(g, s->options.tolerance);
    gather_forget_records(g);
    effort = g->effort;
    if (!guide_build(g))
        return no_memory(err);
    g->mean = g->guide.mean;
    if (has_field(g) ? s->options.norm == LCOR_NORM_MAX && !find_dark(g) : !gather_survey(g))
        goto stopped;
    for (int round = 0; round < ROUNDS_MAX; round++) {
        const double begun = seconds_spent(s);

        last = errors;
        if (!attempt(g, new_field, &errors))
            goto stopped;
        if (g->hurry && round > 0 && !new_field &&
            wanted_error(s, &errors) > wanted_error(s, &last)) {
            errors = last; /* what could not be done in time is no better */
            g->effort = effort;
        }
        s->report.converged = is_met(s, &errors);
        if (s->options.norm == LCOR_NORM_RMS && (s->report.converged || is_near(g, &errors))) {
            if (!settle(g, &errors))
                goto stopped;
            s->report.converged = is_met(s, &errors);
        }
        report_errors(s, &errors);
        if (s->report.converged || g->hurry)
            break;
        effort = g->effort;
        new_field = strive(g, &errors);
        if (!new_field && !(g->effort.stop < effort.stop))
            break; /* there is no more to ask for */
        /* What cannot be ended is not begun: finer takes longer than what it is to improve. */
        if (seconds_left(s) < (new_field ? 4 : 2) * (seconds_spent(s) - begun)) {
            g->effort = effort;
            break;
        }
    }
    describe(s);
    return LCOR_OK;

stopped:
    return g->cancelled ? lcor_internal_fail(err, LCOR_ERR_CANCELLED, -1, "radiosity: cancelled")
                        : no_memory(err);
}

static lcor_status relight(lcor_solution *s, lcor_error *err)
{
    return set_looks(s->state) ? LCOR_OK : no_memory(err);
}

static void patches(const lcor_solution *s, size_t surface, lcor_value value, size_t first,
                    size_t count, double *total)
{
    for (size_t i = 0; i < count; i++) {
        gather_query q;

        gather_query_patch(s->state, surface, value, first + i, &q);
        (void)gather_answer(s->state, &q, total + i * (size_t)s->report.channels, NULL);
    }
}

static void point(const lcor_solution *s, const double x[3], const double normal[3],
                  uint32_t surface, uint32_t seed, double *total)
{
    gather_query q;

    gather_query_point(s->state, x, normal, surface, &q);
    q.seed = seed;
    (void)gather_answer(s->state, &q, total, NULL);
}

static double estimate(const lcor_solution *s, const double x[3], const double normal[3],
                       uint32_t surface, uint32_t samples, uint32_t seed, double *total)
{
    double variance = 0;
    gather_query q;

    gather_query_point(s->state, x, normal, surface, &q);
    q.stop = 0;
    q.share_effort = 0;
    q.samples = samples;
    q.seed = random_hash(q.seed + seed);
    q.variance = &variance;
    (void)gather_answer(s->state, &q, total, NULL);
    return variance;
}

static void emitted(const lcor_solution *s, const double x[3], const double normal[3],
                    uint32_t surface, double *total)
{
    const gather *g = s->state;

    emitters_at(&g->emitters, x, normal, surface, total);
}

const engine engine_gather = {
    LCOR_ENGINE_GATHER, 4, 4, prepare, release, solve, relight, patches, point, estimate, emitted};

/* The same without a field: what paths find is all there is. */
const engine engine_paths = {LCOR_ENGINE_PATHS, 1,       1,     prepare,  release, solve,
                             relight,           patches, point, estimate, emitted};
