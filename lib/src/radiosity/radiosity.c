/* SPDX-License-Identifier: MIT */
/* The face of the solver: options, choice of the engine, evaluation, report. */
#include "base/internal.h"
#include "geometry/vec.h"
#include "radiosity/engine.h"
#include "radiosity/gather_random.h"
#include "radiosity/patch_light.h"

#include <math.h>
#include <string.h>

static double seconds_since(clock_t start) { return (double)(clock() - start) / CLOCKS_PER_SEC; }

int engine_over_limit(const lcor_solution *s, uint64_t bytes)
{
    return (s->options.max_seconds > 0 && seconds_since(s->start) > s->options.max_seconds) ||
           (s->options.max_bytes > 0 && bytes > s->options.max_bytes);
}

int engine_progress(lcor_solution *s, double done)
{
    const lcor_progress *progress = &s->options.progress;

    s->done = fmax(s->done, done);
    return progress->report && progress->report(progress->user, s->done) != 0;
}

void engine_run(const lcor_solution *s, size_t n, void (*task)(void *arg, size_t i), void *arg)
{
    const lcor_parallel *parallel = &s->options.parallel;

    if (parallel->run && n > 1)
        parallel->run(parallel->user, n, task, arg);
    else
        for (size_t i = 0; i < n; i++)
            task(arg, i);
}

static int grey(const double v[3]) { return v[0] == v[1] && v[1] == v[2]; }

static int channels_needed(const lcor_scene *scene, int wanted)
{
    if (wanted != 0)
        return wanted;
    for (size_t i = 0; i < scene->lights.count; i++)
        if (!grey(scene_light_at(scene, i)->intensity))
            return 3;
    for (size_t i = 0; i < scene->surfaces.count; i++)
        if (!grey(scene_surface_at(scene, i)->look.emission))
            return 3;
    return 1;
}

static lcor_status check_options(lcor_radiosity_options *o, lcor_error *err)
{
    static const double bt709[3] = {0.2126, 0.7152, 0.0722};
    const double sum = o->luminance[0] + o->luminance[1] + o->luminance[2];

    if (o->tolerance == 0)
        o->tolerance = 0.01;
    if (!(o->tolerance >= 1e-5 && o->tolerance <= 1))
        return lcor_internal_fail(err, LCOR_ERR_DOMAIN, -1,
                                  "radiosity: tolerance must be 1e-5 .. 1");
    if (o->channels != 0 && o->channels != 1 && o->channels != 3)
        return lcor_internal_fail(err, LCOR_ERR_ARG, -1, "radiosity: channels must be 0, 1 or 3");
    if (o->engine < LCOR_ENGINE_AUTO || o->engine > LCOR_ENGINE_PATHS)
        return lcor_internal_fail(err, LCOR_ERR_ARG, -1, "radiosity: there is no such engine");
    if (o->norm != LCOR_NORM_RMS && o->norm != LCOR_NORM_MAX)
        return lcor_internal_fail(err, LCOR_ERR_ARG, -1, "radiosity: unknown norm");
    if (!(sum >= 0) || !isfinite(sum) || !(o->max_seconds >= 0))
        return lcor_internal_fail(err, LCOR_ERR_DOMAIN, -1,
                                  "radiosity: luminance weights and max_seconds must be >= 0");
    for (int c = 0; c < 3; c++)
        o->luminance[c] = sum > 0 ? o->luminance[c] / sum : bt709[c];
    return LCOR_OK;
}

/* The cheapest one, unless the caller knows better. */
static const engine *choose_engine(lcor_solution *s)
{
    lcor_radiosity_report *r = &s->report;

    switch (s->options.engine) {
    case LCOR_ENGINE_LINKS: return &engine_links;
    case LCOR_ENGINE_GATHER: return &engine_gather;
    case LCOR_ENGINE_PATHS: return &engine_paths;
    case LCOR_ENGINE_AUTO: break;
    }
    engine_costs(s->scene, &s->options, r);
    if (r->paths_seconds < fmin(r->links_seconds, r->gather_seconds))
        return &engine_paths;
    return r->links_seconds <= r->gather_seconds ? &engine_links : &engine_gather;
}

const char *lcor_reason_text(lcor_reason reason)
{
    switch (reason) {
    case LCOR_REASON_ASKED: return "asked for";
    case LCOR_REASON_COST: return "estimated to take less time";
    case LCOR_REASON_CONVEX: return "convex scene, nothing hides anything";
    case LCOR_REASON_CLUTTER: return "surfaces may hide others";
    case LCOR_REASON_GREY: return "all light is grey";
    case LCOR_REASON_COLOURED: return "some light has a colour";
    }
    return "unknown";
}

static void give_reasons(lcor_solution *s)
{
    lcor_radiosity_report *r = &s->report;

    r->engine_reason = s->options.engine == LCOR_ENGINE_AUTO ? LCOR_REASON_COST : LCOR_REASON_ASKED;
    r->visibility_reason = s->scene->convex ? LCOR_REASON_CONVEX : LCOR_REASON_CLUTTER;
    r->channels_reason = s->options.channels != 0 ? LCOR_REASON_ASKED
                         : r->channels == 1       ? LCOR_REASON_GREY
                                                  : LCOR_REASON_COLOURED;
}

/* What is known of each light once the channels are. */
static void set_lights(lcor_solution *s)
{
    light_set *set = &s->lights;

    for (size_t i = 0; i < s->scene->lights.count; i++) {
        const lcor_light *light = scene_light_at(s->scene, i);

        set->open[i] = (unsigned char)light_is_open(s->scene, light);
        set->power[i] = 0;
        for (int c = 0; c < set->channels; c++)
            set->power[i] += light_channel(set, light->intensity, c);
    }
}

/* Channels and what depends on them, then the engine's own structures. */
static lcor_status prepare(lcor_solution *s, lcor_error *err)
{
    s->report.channels = channels_needed(s->scene, s->options.channels);
    s->report.engine = s->engine->id;
    s->lights.channels = s->report.channels;
    set_lights(s);
    give_reasons(s);
    return s->engine->prepare(s, err);
}

static lcor_status solve(lcor_solution *s, lcor_error *err)
{
    const lcor_status status = s->engine->solve(s, err);

    if (status == LCOR_OK) {
        s->report.seconds = seconds_since(s->start);
        (void)engine_progress(s, 1);
    }
    return status;
}

lcor_status lcor_radiosity_solve(const lcor_scene *scene, const lcor_radiosity_options *options,
                                 lcor_solution **out, lcor_error *err)
{
    lcor_radiosity_options o;
    lcor_allocator own;
    lcor_solution *s;
    lcor_status status;

    if (!scene || !out || (options && options->struct_size == 0))
        return lcor_internal_fail(err, LCOR_ERR_ARG, -1,
                                  "radiosity: scene or out is NULL, or struct_size unset");
    if (!scene->committed)
        return lcor_internal_fail(err, LCOR_ERR_ARG, -1,
                                  "radiosity: the scene is not committed (lcor_scene_commit)");
    memset(&o, 0, sizeof o);
    if (options)
        memcpy(&o, options, options->struct_size < sizeof o ? options->struct_size : sizeof o);
    status = check_options(&o, err);
    if (status == LCOR_OK)
        status = lcor_internal_allocator(&o.allocator, &own, err);
    if (status != LCOR_OK)
        return status;
    s = lcor_internal_alloc(&own, sizeof *s);
    if (!s)
        return lcor_internal_fail(err, LCOR_ERR_NOMEM, -1, "no memory for a solution");
    memset(s, 0, sizeof *s);
    s->start = clock();
    s->allocator = own;
    s->scene = scene;
    s->options = o;
    s->engine = choose_engine(s);
    s->lights.scene = scene;
    memcpy(s->lights.luminance, o.luminance, sizeof s->lights.luminance);
    s->lights.open = lcor_internal_alloc(&own, scene->lights.count);
    s->lights.power = lcor_internal_alloc(&own, scene->lights.count * sizeof *s->lights.power);
    if (!s->lights.open || !s->lights.power) {
        lcor_solution_free(s);
        return lcor_internal_fail(err, LCOR_ERR_NOMEM, -1, "no memory for lights");
    }
    status = prepare(s, err);
    if (status == LCOR_OK)
        status = solve(s, err);
    if (status == LCOR_OK)
        *out = s;
    else
        lcor_solution_free(s);
    return status;
}

lcor_status lcor_solution_update(lcor_solution *s, lcor_error *err)
{
    lcor_status status;

    if (!s)
        return lcor_internal_fail(err, LCOR_ERR_ARG, -1, "update: solution is NULL");
    s->start = clock();
    s->done = 0;
    if (channels_needed(s->scene, s->options.channels) == s->report.channels) {
        set_lights(s);
        status = s->engine->relight(s, err);
    } else {
        s->engine->release(s);
        status = prepare(s, err);
    }
    return status == LCOR_OK ? solve(s, err) : status;
}

void lcor_solution_free(lcor_solution *s)
{
    if (!s)
        return;
    s->engine->release(s);
    lcor_internal_free(&s->allocator, s->lights.open);
    lcor_internal_free(&s->allocator, s->lights.power);
    lcor_internal_free(&s->allocator, s);
}

const lcor_radiosity_report *lcor_solution_report(const lcor_solution *s) { return &s->report; }

void lcor_solution_direct_at(const lcor_solution *s, const double x[3], const double normal[3],
                             uint32_t skip, double *irradiance)
{
    light_at(&s->lights, x, normal, skip, irradiance);
}

/* Patches are evaluated a few rows at a time, `direct` first where both are wanted. */
typedef struct patch_job {
    const lcor_solution *s;
    size_t surface, count, step;
    lcor_value value;
    double *total, *direct;
} patch_job;

static void patch_task(void *arg, size_t chunk)
{
    const patch_job *job = arg;
    const size_t channels = (size_t)job->s->report.channels, first = chunk * job->step;
    const size_t n = job->count - first < job->step ? job->count - first : job->step;
    const double accuracy = 0.005 * job->s->options.tolerance;
    double *total = job->total ? job->total + channels * first : NULL;
    double *direct = job->direct ? job->direct + channels * first : total;

    patch_light(&job->s->lights, job->surface, job->value, first, n, accuracy, direct);
    if (!total)
        return;
    if (total != direct)
        memcpy(total, direct, n * channels * sizeof *total);
    job->s->engine->patches(job->s, job->surface, job->value, first, n, total);
}

lcor_status lcor_solution_patches(const lcor_solution *s, size_t surface, lcor_value value,
                                  double *total, double *direct, lcor_error *err)
{
    patch_job job = {s, surface, 0, 0, value, total, direct};
    const scene_surface *f;

    if (!s || surface >= s->scene->surfaces.count)
        return lcor_internal_fail(err, LCOR_ERR_ARG, (long)surface, "surface %lu: there is none",
                                  (unsigned long)surface);
    if (!total && !direct)
        return LCOR_OK;
    f = scene_surface_at(s->scene, surface);
    job.count = lcor_scene_patches_of(f);
    job.step = s->engine->patches_per_task;
    if (f->shape == SCENE_QUAD) { /* whole rows */
        const size_t row = f->look.patches[1] ? f->look.patches[1] : 1;

        job.step = row * ((job.step + row - 1) / row);
    }
    engine_run(s, (job.count + job.step - 1) / job.step, patch_task, &job);
    return LCOR_OK;
}

typedef struct point_job {
    const lcor_solution *s;
    size_t n;
    const double *points, *normals;
    double *total, *direct;
} point_job;

/* An engine takes finite numbers only, and a direction from a normal. */
static lcor_status check_places(size_t n, const double *points, const double *normals,
                                lcor_error *err)
{
    for (size_t i = 0; i < n; i++) {
        const double *x = points + 3 * i, *d = normals + 3 * i;

        if (!isfinite(x[0]) || !isfinite(x[1]) || !isfinite(x[2]))
            return lcor_internal_fail(err, LCOR_ERR_DOMAIN, (long)i, "at: point %lu is not finite",
                                      (unsigned long)i);
        if (!isfinite(d[0]) || !isfinite(d[1]) || !isfinite(d[2]) ||
            !(d[0] != 0 || d[1] != 0 || d[2] != 0))
            return lcor_internal_fail(err, LCOR_ERR_DOMAIN, (long)i,
                                      "at: normal %lu has no direction", (unsigned long)i);
    }
    return LCOR_OK;
}

static void point_task(void *arg, size_t chunk)
{
    const point_job *job = arg;
    const lcor_solution *s = job->s;
    const size_t channels = (size_t)s->report.channels, step = s->engine->points_per_task;

    for (size_t i = chunk * step; i < job->n && i < (chunk + 1) * step; i++) {
        const uint32_t seed = random_seed_at(job->points + 3 * i);
        double x[3], normal[3], direct[3];
        uint32_t surface;

        vec_copy(job->points + 3 * i, x);
        vec_copy(job->normals + 3 * i, normal);
        (void)vec_normalize(normal);
        surface = lcor_scene_surface_of(s->scene, normal, x);
        light_at(&s->lights, x, normal, surface, direct);
        if (job->direct)
            memcpy(job->direct + channels * i, direct, channels * sizeof *direct);
        if (job->total) {
            memcpy(job->total + channels * i, direct, channels * sizeof *direct);
            s->engine->point(s, x, normal, surface, seed, job->total + channels * i);
        }
    }
}

lcor_status lcor_solution_at(const lcor_solution *s, size_t n, const double *points,
                             const double *normals, double *total, double *direct, lcor_error *err)
{
    point_job job = {s, n, points, normals, total, direct};
    lcor_status status;
    size_t step;

    if (!s || (n > 0 && (!points || !normals)))
        return lcor_internal_fail(err, LCOR_ERR_ARG, -1,
                                  "at: solution, points or normals are NULL");
    status = check_places(n, points, normals, err);
    if (status != LCOR_OK)
        return status;
    step = s->engine->points_per_task;
    engine_run(s, (n + step - 1) / step, point_task, &job);
    return LCOR_OK;
}
