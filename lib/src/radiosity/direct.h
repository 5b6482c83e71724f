/* SPDX-License-Identifier: MIT */
/* Light that arrives straight from lights without area. */
#ifndef LCOR_RADIOSITY_DIRECT_H
#define LCOR_RADIOSITY_DIRECT_H

#include "scene/scene_internal.h"

#include <lcor/radiosity.h>

/* Irradiance of light `index` at x facing along `normal`, for intensity 1 and without shadow; 0
 * where the light is behind. */
double lcor_direct_unshadowed(const lcor_light *light, const double x[3], const double normal[3]);

/* Whether something stands between x and the light; `skip` is the surface x lies on, or
 * LCOR_BVH_NONE. */
int lcor_direct_shadowed(const lcor_scene *scene, const lcor_light *light, const double x[3],
                         uint32_t skip, uint32_t *cache);

/* The lights of a scene as the engines use them. */
typedef struct light_set {
    const lcor_scene *scene;
    int channels;
    double luminance[3]; /* weights of the channels where there is one */
    unsigned char *open; /* per light: nothing in the scene stands in its way */
    double *power;       /* per light: sum of its intensity in the channels */
} light_set;

/* `rgb` in channel c of 1 or 3. */
double light_channel(const light_set *set, const double rgb[3], int c);

/* Whether nothing can hide the light from surfaces that face it. */
int light_is_open(const lcor_scene *scene, const lcor_light *light);

/* Whether the light stands inside one of the scene's solids. */
int light_in_solid(const lcor_scene *scene, const lcor_light *light);

/* Irradiance at x, all lights with their shadows: `channels` values. */
void light_at(const light_set *set, const double x[3], const double normal[3], uint32_t skip,
              double *out);

/* The same on average over `random` of 0..1, by one shadow ray at most: of the lights that
 * something might hide, one stands for all, each with a chance of its share. With `strongest` the
 * one that would give most has a ray of its own. */
void light_by_chance(const light_set *set, const double x[3], const double normal[3], uint32_t skip,
                     int strongest, double random, double *out);

/* Direct irradiance at x, all lights, with shadows: report.channels values. Starts no parallel
 * work, so tasks may call it. */
void lcor_solution_direct_at(const lcor_solution *solution, const double x[3],
                             const double normal[3], uint32_t skip, double *irradiance);

#endif
