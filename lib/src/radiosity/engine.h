/* SPDX-License-Identifier: MIT */
/* What an engine gives the solver's face, and what it gets from there. */
#ifndef LCOR_RADIOSITY_ENGINE_H
#define LCOR_RADIOSITY_ENGINE_H

#include "radiosity/direct.h"

#include <lcor/radiosity.h>

#include <time.h>

/* An engine's calls get the solution, whose `state` is the engine's own. Indirect irradiance is
 * added to `total`, which holds the direct one. */
typedef struct engine {
    lcor_engine id;
    size_t points_per_task, patches_per_task;
    lcor_status (*prepare)(lcor_solution *s, lcor_error *err);
    void (*release)(lcor_solution *s); /* after prepare, even one that failed */
    /* Solves to options.tolerance and fills the report; again after each relight. */
    lcor_status (*solve)(lcor_solution *s, lcor_error *err);
    lcor_status (*relight)(lcor_solution *s, lcor_error *err); /* lights or looks have changed */
    /* Patches first..first+count-1 of a surface, of a quad whole rows. */
    void (*patches)(const lcor_solution *s, size_t surface, lcor_value value, size_t first,
                    size_t count, double *total);
    /* At a point on a surface, or free of any (LCOR_BVH_NONE). Points with seeds of their own err
     * independently of each other, unlike neighbouring patches: the mean of many is then much
     * closer than each, and the rms over some tells that over all. */
    void (*point)(const lcor_solution *s, const double x[3], const double normal[3],
                  uint32_t surface, uint32_t seed, double *total);
    /* The same by so many samples, 128 or more, whatever the tolerance, so that the mean of many is
     * without bias; each seed errs otherwise. Returns the variance, mean of the channels. NULL
     * where answers have no noise. */
    double (*estimate)(const lcor_solution *s, const double x[3], const double normal[3],
                       uint32_t surface, uint32_t samples, uint32_t seed, double *total);
    /* Adds the part of the indirect irradiance that has none: light straight from emitters. */
    void (*emitted)(const lcor_solution *s, const double x[3], const double normal[3],
                    uint32_t surface, double *total);
} engine;

struct lcor_solution {
    lcor_allocator allocator;
    const lcor_scene *scene;
    lcor_radiosity_options options;
    lcor_radiosity_report report;
    light_set lights;
    const engine *engine;
    void *state;
    clock_t start;
    double done; /* last progress reported */
};

/* Errors are relative to the irradiance, or to this part of the scene's mean where it is dark. */
static const double engine_dark = 0.02;

extern const engine engine_links, engine_gather, engine_paths;

/* choose.c: sets links_seconds, gather_seconds and paths_seconds of the report. */
void engine_costs(const lcor_scene *scene, const lcor_radiosity_options *options,
                  lcor_radiosity_report *report);

/* gather_engine.c: places from which the error of paths is estimated, each answered about once. */
size_t engine_paths_places(const lcor_radiosity_options *options);

/* Whether max_seconds have passed, or `bytes` are more than max_bytes. */
int engine_over_limit(const lcor_solution *s, uint64_t bytes);

/* Reports progress, never less than before; returns nonzero if the caller wants to stop. */
int engine_progress(lcor_solution *s, double done);

/* Through the caller's threads. */
void engine_run(const lcor_solution *s, size_t n, void (*task)(void *arg, size_t i), void *arg);

#endif
