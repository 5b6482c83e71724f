/* SPDX-License-Identifier: MIT */
/* Engine `gather` behind the solver's face: what a tolerance takes, and the loop around it. */
#include "base/internal.h"
#include "geometry/vec.h"
#include "radiosity/engine.h"
#include "radiosity/gather.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { ROUNDS_MAX = 5, SLICE = 256, SAMPLE = 48, MEAN_PLACES = 512 };

/* Leaves wanted at a tolerance of 1 %. */
static const double leaves_wanted = 100;

int gather_each(gather *g, size_t n, void (*task)(void *arg, size_t i), void *arg)
{
    lcor_solution *s = g->solution;

    engine_run(s, n, task, arg);
    (void)SLICE;
    g->hurry |= engine_over_limit(s, gather_bytes(g));
    g->cancelled |= engine_progress(s, s->done + 0.02 * (1 - s->done));
    return !g->cancelled;
}

uint64_t gather_bytes(const gather *g)
{
    return g->planes.capacity * sizeof(gather_plane) + g->prims.capacity * sizeof(gather_prim) +
           g->nodes.capacity * sizeof(gather_node) + g->leaves.capacity * sizeof(gather_leaf) +
           g->pieces.capacity * sizeof(gather_piece) +
           g->records.capacity * (sizeof(gather_record) + 2 * (size_t)g->channels * sizeof(float)) +
           g->slots * (size_t)g->channels * GATHER_TERMS * sizeof(double) * 10;
}

static void set_looks(gather *g)
{
    const light_set *lights = &g->solution->lights;

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
                light_channel(lights, look->emission, c);
            if (light_channel(lights, look->emission, c) > 0)
                g->dark = 0;
        }
    }
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
    if (!g->reflectance || !g->emission || !gather_list_prims(g) || !gather_find_planes(g))
        return no_memory(err);
    set_looks(g);
    return LCOR_OK;
}

static void release(lcor_solution *s)
{
    gather *g = s->state;

    if (!g)
        return;
    guide_clear(g);
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
    lcor_internal_free(g->allocator, g);
    s->state = NULL;
}

/* Mean irradiance over all that gets some, from the direct light and the field. */
static void set_mean(gather *g)
{
    double sum = 0, count = 0;

    for (uint32_t i = 0; i < MEAN_PLACES; i++) {
        double random[2], at[2], direct[GATHER_CHANNELS], here = 0;
        gather_stand stand;
        uint32_t side, leaf;

        sobol_point(&g->sobol, i, 7, 2, random);
        (void)gather_place(g, random[0], random[1], &stand);
        light_at(&g->solution->lights, stand.x, stand.normal, stand.surface, direct);
        side = gather_side_of(g, stand.surface, 0);
        gather_to_plane(gather_plane_at(g, side / 2), stand.x, at);
        leaf = gather_leaf_of(g, side, at);
        for (int c = 0; c < g->channels; c++)
            here += direct[c] / g->channels +
                    (leaf == gather_none ? 0 : gather_field_at(g, leaf, at, c) / g->channels);
        sum += fmax(here, 0);
        count += here > 0;
    }
    if (count > 0)
        g->mean = sum / count;
}

static void set_effort(gather *g, double tolerance)
{
    g->effort.leaf_size = tolerance >= 0.008 ? 2 : 1.5;
    g->effort.rays = fmin(fmax(64 * pow(0.01 / tolerance, 1.0), 16), 1024);
    g->effort.near = 0.5;
    g->effort.leaves = (size_t)(leaves_wanted * 0.01 / tolerance);
    g->effort.stop = tolerance;
}

static double wanted_error(const lcor_solution *s, const gather_errors *e)
{
    return s->options.norm == LCOR_NORM_MAX ? 2 * e->max : e->rms;
}

static void describe(lcor_solution *s)
{
    const gather *g = s->state;
    size_t fields = 0;

    for (size_t i = 0; i < 2 * g->planes.count; i++)
        fields += g->sides[i].root >= 0;
    (void)snprintf(s->report.models, sizeof s->report.models,
                   "final gathering; %lu surfaces in %lu planes, fields on %lu sides; %d bright "
                   "places; %d channel%s",
                   (unsigned long)g->scene->surfaces.count, (unsigned long)g->planes.count,
                   (unsigned long)fields, g->guide.count, g->channels, g->channels == 1 ? "" : "s");
}

/* More of what the error came from. */
static void strive(gather *g, const gather_errors *e, double tolerance)
{
    if (e->noise > 0.6 * tolerance)
        g->effort.stop *= fmax(0.3, 0.5 * tolerance / e->noise);
    if (e->field > 0.5 * tolerance) {
        g->effort.rays *= 2;
        g->effort.near *= 1.5;
        g->effort.leaf_size *= 0.75;
    }
}

static lcor_status solve(lcor_solution *s, lcor_error *err)
{
    gather *g = s->state;

    g->cancelled = g->hurry = 0;
    set_effort(g, s->options.tolerance);
    if (!guide_build(g))
        return no_memory(err);
    g->mean = g->guide.mean;
    for (int round = 0; round < ROUNDS_MAX; round++) {
        gather_errors errors;

        if (!gather_grow(g) || !gather_solve_field(g))
            goto stopped;
        set_mean(g);
        if (!gather_estimate(g, SAMPLE, &errors))
            goto stopped;
        s->report.error_rms = errors.rms;
        s->report.error_max = errors.max;
        s->report.iterations = g->iterations;
        s->report.elements = g->slots;
        s->report.rays = g->rays;
        if (gather_bytes(g) > s->report.bytes)
            s->report.bytes = gather_bytes(g);
        s->report.converged = wanted_error(s, &errors) <= s->options.tolerance;
        if (s->report.converged || g->hurry)
            break;
        strive(g, &errors, s->options.tolerance);
    }
    describe(s);
    return LCOR_OK;

stopped:
    return g->cancelled ? lcor_internal_fail(err, LCOR_ERR_CANCELLED, -1, "radiosity: cancelled")
                        : no_memory(err);
}

static lcor_status relight(lcor_solution *s, lcor_error *err)
{
    (void)err;
    set_looks(s->state);
    return LCOR_OK;
}

static void patches(const lcor_solution *s, size_t surface, lcor_value value, size_t first,
                    size_t count, double *total)
{
    for (size_t i = 0; i < count; i++)
        gather_patch(s->state, surface, value, first + i, total + i * (size_t)s->report.channels);
}

static void point(const lcor_solution *s, const double x[3], const double normal[3], double *total)
{
    gather_query q;

    gather_query_point(s->state, x, normal, &q);
    (void)gather_answer(s->state, &q, total, NULL);
}

const engine engine_gather = {
    LCOR_ENGINE_GATHER, 4, 4, prepare, release, solve, relight, patches, point};
