/* SPDX-License-Identifier: MIT */
/* The face of the solver: options, the tolerance loop, evaluation, report. */
#include "base/internal.h"
#include "radiosity/evaluate.h"
#include "radiosity/patch_light.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

enum { ROUNDS_MAX = 12, ITERATIONS_MAX = 50, POINTS = 64, ROWS_VALUES = 512 };

/* Every face is a candidate sender of every other one. */
static const size_t faces_max = 2000;

/* Parts of the tolerance: what one link may err (of a tolerance of 1 %, and less of a smaller one),
 * what the near field and the solver may. */
static const double link_share = 1, near_share = 1, solver_share = 0.01;

/* What a round that missed may change at most and at least. */
static const double tighten_most = 0.1, tighten_least = 0.6;

struct lcor_solution {
    lcor_allocator allocator;
    const lcor_scene *scene;
    lcor_radiosity_options options;
    lcor_radiosity_report report;
    light_set lights;
    links links;
    clock_t start;
    double done; /* last progress reported */
};

static double seconds_since(clock_t start) { return (double)(clock() - start) / CLOCKS_PER_SEC; }

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

static uint64_t bytes_held(const links *l)
{
    return l->faces.capacity * sizeof(face) + l->elements.capacity * sizeof(links_element) +
           l->list.capacity * sizeof(links_link) + l->blocks.capacity * sizeof(links_block) +
           (l->occluders.capacity + l->scratch.capacity) * sizeof(uint32_t) +
           (l->irradiance.capacity + l->radiosity.capacity + l->source.capacity) * sizeof(double) *
               RULE_Q * (size_t)l->channels +
           l->krylov.capacity * sizeof(double);
}

/* How much worse than the worst of the sampled points the worst patch may be. */
static const double unseen = 2;

static double wanted_error(const lcor_solution *s, const links_errors *e)
{
    return s->options.norm == LCOR_NORM_MAX ? unseen * e->max : e->rms;
}

static size_t sample_count(const lcor_solution *s)
{
    if (s->options.norm == LCOR_NORM_MAX)
        return 512;
    return s->options.tolerance >= 5e-3 ? 64 : 256;
}

static int over_limit(const lcor_solution *s)
{
    return (s->options.max_seconds > 0 && seconds_since(s->start) > s->options.max_seconds) ||
           (s->options.max_bytes > 0 && bytes_held(&s->links) > s->options.max_bytes);
}

/* Reports progress, a little more each time as the end is not known; minds the limits. */
static void poll(links *l)
{
    lcor_solution *s = (lcor_solution *)l->poll_arg;

    s->done += 0.002 * (1 - s->done);
    l->hurry |=
        over_limit(s) || (s->options.max_bytes > 0 &&
                          bytes_held(l) + (l->list.count - l->blocks.count) * sizeof(links_block) >
                              s->options.max_bytes);
    l->cancelled |= s->options.progress.report &&
                    s->options.progress.report(s->options.progress.user, s->done) != 0;
}

/* Refine, solve, measure; tighten until the estimate is within the tolerance. */
static lcor_status run_rounds(lcor_solution *s, lcor_error *err)
{
    const double tolerance = s->options.tolerance;
    links *l = &s->links;

    l->eps = link_share * tolerance * pow(tolerance / 0.01, 0.3);
    l->accuracy = near_share * tolerance;
    l->finest = 1;
    l->hurry = l->cancelled = 0;
    for (int round = 0; round < ROUNDS_MAX; round++) {
        links_errors errors;

        if (!links_refine(l) || !links_fill(l))
            goto stopped;
        links_set_source(l);
        if (!links_solve(l, solver_share * tolerance, ITERATIONS_MAX) ||
            !links_estimate(l, sample_count(s), &errors))
            goto stopped;
        s->report.error_rms = errors.rms;
        s->report.error_max = errors.max;
        s->report.energy_defect = l->energy_defect;
        s->report.iterations = l->iterations;
        s->report.links = l->list.count;
        s->report.elements = l->elements.count;
        if (bytes_held(l) > s->report.bytes)
            s->report.bytes = bytes_held(l);
        s->report.converged = wanted_error(s, &errors) <= tolerance;
        if (s->report.converged || l->hurry)
            break;
        l->eps *=
            fmax(tighten_most, fmin(tighten_least, 0.7 * tolerance / wanted_error(s, &errors)));
        l->finest *= 0.5;
    }
    s->report.seconds = seconds_since(s->start);
    if (s->options.progress.report)
        (void)s->options.progress.report(s->options.progress.user, 1);
    return LCOR_OK;

stopped:
    if (l->cancelled)
        return lcor_internal_fail(err, LCOR_ERR_CANCELLED, -1, "radiosity: cancelled");
    return lcor_internal_fail(err, LCOR_ERR_NOMEM, -1, "radiosity: no memory for the links");
}

static void describe(lcor_solution *s)
{
    const lcor_scene *scene = s->scene;
    size_t open = 0, partial = 0;

    for (size_t i = 0; i < scene->lights.count; i++)
        open += s->lights.open[i];
    for (size_t i = 0; i < s->links.list.count; i++)
        partial += ((const links_link *)s->links.list.items)[i].occluder_count > 0;
    (void)snprintf(s->report.models, sizeof s->report.models,
                   "links of order %d; %s; %lu of %lu links clipped; shadows of %lu of %lu lights; "
                   "%d channel%s",
                   RULE_P, scene->convex ? "convex, no visibility tests" : "exact visibility",
                   (unsigned long)partial, (unsigned long)s->links.list.count,
                   (unsigned long)(scene->lights.count - open), (unsigned long)scene->lights.count,
                   s->report.channels, s->report.channels == 1 ? "" : "s");
}

static void open_lights(lcor_solution *s)
{
    for (size_t i = 0; i < s->scene->lights.count; i++)
        s->lights.open[i] = (unsigned char)light_is_open(s->scene, scene_light_at(s->scene, i));
}

static lcor_status prepare(lcor_solution *s, lcor_error *err)
{
    links *l = &s->links;

    s->report.channels = channels_needed(s->scene, s->options.channels);
    s->report.engine = LCOR_ENGINE_LINKS;
    s->lights.scene = s->scene;
    s->lights.channels = s->report.channels;
    memcpy(s->lights.luminance, s->options.luminance, sizeof s->lights.luminance);
    open_lights(s);
    l->scene = s->scene;
    l->allocator = s->allocator;
    l->parallel = s->options.parallel;
    l->share_power = s->options.norm == LCOR_NORM_RMS ? 0.5 : 0;
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
    return LCOR_OK;
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
    if (o->engine != LCOR_ENGINE_AUTO && o->engine != LCOR_ENGINE_LINKS)
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
    s->lights.open = lcor_internal_alloc(&own, scene->lights.count);
    status = s->lights.open ? prepare(s, err)
                            : lcor_internal_fail(err, LCOR_ERR_NOMEM, -1, "no memory for lights");
    if (status == LCOR_OK)
        status = run_rounds(s, err);
    if (status != LCOR_OK) {
        lcor_solution_free(s);
        return status;
    }
    describe(s);
    *out = s;
    return LCOR_OK;
}

lcor_status lcor_solution_update(lcor_solution *s, lcor_error *err)
{
    lcor_status status;

    if (!s)
        return lcor_internal_fail(err, LCOR_ERR_ARG, -1, "update: solution is NULL");
    s->start = clock();
    s->done = 0;
    open_lights(s);
    if (channels_needed(s->scene, s->options.channels) != s->report.channels) {
        links_clear(&s->links);
        memset(&s->links, 0, sizeof s->links);
        status = prepare(s, err);
        if (status != LCOR_OK)
            return status;
    } else if (!links_relight(&s->links)) {
        return lcor_internal_fail(err, LCOR_ERR_NOMEM, -1, "update: no memory");
    }
    status = run_rounds(s, err);
    describe(s);
    return status;
}

void lcor_solution_free(lcor_solution *s)
{
    if (!s)
        return;
    links_clear(&s->links);
    lcor_internal_free(&s->allocator, s->lights.open);
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
    const double accuracy = 0.001 * job->s->options.tolerance;
    double *total = job->total ? job->total + channels * first : NULL;
    double *direct = job->direct ? job->direct + channels * first : total;

    patch_light(&job->s->lights, job->surface, job->value, first, n, accuracy, direct);
    if (!total)
        return;
    if (total != direct)
        memcpy(total, direct, n * channels * sizeof *total);
    links_patches(&job->s->links, job->surface, job->value, first, n, total);
}

lcor_status lcor_solution_patches(const lcor_solution *s, size_t surface, lcor_value value,
                                  double *total, double *direct, lcor_error *err)
{
    patch_job job = {s, surface, 0, ROWS_VALUES, value, total, direct};
    const scene_surface *f;

    if (!s || surface >= s->scene->surfaces.count)
        return lcor_internal_fail(err, LCOR_ERR_ARG, (long)surface, "surface %lu: there is none",
                                  (unsigned long)surface);
    if (!total && !direct)
        return LCOR_OK;
    f = scene_surface_at(s->scene, surface);
    job.count = lcor_scene_patches_of(f);
    if (f->shape == SCENE_QUAD) { /* whole rows */
        const size_t row = f->look.patches[1] ? f->look.patches[1] : 1;

        job.step = row * ((ROWS_VALUES + row - 1) / row);
    }
    links_run(&s->links, (job.count + job.step - 1) / job.step, patch_task, &job);
    return LCOR_OK;
}

typedef struct point_job {
    const lcor_solution *s;
    size_t n;
    const double *points, *normals;
    double *total, *direct;
} point_job;

static void point_task(void *arg, size_t chunk)
{
    const point_job *job = arg;
    const size_t channels = (size_t)job->s->report.channels;

    for (size_t i = chunk * POINTS; i < job->n && i < (chunk + 1) * POINTS; i++) {
        const double *x = job->points + 3 * i, *normal = job->normals + 3 * i;
        double direct[3], indirect[3];

        light_at(&job->s->lights, x, normal, LCOR_BVH_NONE, direct);
        if (job->total)
            links_point(&job->s->links, x, normal, job->s->links.accuracy, indirect);
        for (size_t c = 0; c < channels; c++) {
            if (job->direct)
                job->direct[channels * i + c] = direct[c];
            if (job->total)
                job->total[channels * i + c] = direct[c] + indirect[c];
        }
    }
}

lcor_status lcor_solution_at(const lcor_solution *s, size_t n, const double *points,
                             const double *normals, double *total, double *direct, lcor_error *err)
{
    point_job job = {s, n, points, normals, total, direct};

    if (!s || (n > 0 && (!points || !normals)))
        return lcor_internal_fail(err, LCOR_ERR_ARG, -1,
                                  "at: solution, points or normals are NULL");
    links_run(&s->links, (n + POINTS - 1) / POINTS, point_task, &job);
    return LCOR_OK;
}
