/* SPDX-License-Identifier: MIT */
#include "radiosity/direct.h"

#include "geometry/vec.h"

#include <math.h>

/* KHR_lights_punctual: squared linear ramp between the cosines of the two cones. */
static double spot_factor(const lcor_light *light, double cosine)
{
    const double inner = cos(light->inner_cone), outer = cos(light->outer_cone);
    const double ramp = (cosine - outer) / fmax(0.001, inner - outer);
    const double part = ramp < 0 ? 0 : ramp > 1 ? 1 : ramp;

    return part * part;
}

/* KHR_lights_punctual: window that brings the light to zero at its range. */
static double range_factor(const lcor_light *light, double distance)
{
    double q;

    if (!(light->range > 0))
        return 1;
    q = distance / light->range;
    return q < 1 ? 1 - q * q * q * q : 0;
}

double lcor_direct_unshadowed(const lcor_light *light, const double x[3], const double normal[3])
{
    double to[3], square, distance, height, value;

    if (light->kind == LCOR_LIGHT_DIRECTIONAL)
        return fmax(0, -vec_dot(light->direction, normal));
    vec_sub(light->position, x, to);
    height = vec_dot(to, normal);
    if (!(height > 0))
        return 0;
    square = vec_dot(to, to);
    distance = sqrt(square);
    value = height / (square * distance) * range_factor(light, distance);
    if (light->kind == LCOR_LIGHT_SPOT)
        value *= spot_factor(light, -vec_dot(to, light->direction) / distance);
    return value;
}

int lcor_direct_shadowed(const lcor_scene *scene, const lcor_light *light, const double x[3],
                         uint32_t skip, uint32_t *cache)
{
    if (light->kind == LCOR_LIGHT_DIRECTIONAL) {
        const double towards[3] = {-light->direction[0], -light->direction[1],
                                   -light->direction[2]};

        return lcor_scene_blocked_towards(scene, x, towards, skip, cache);
    }
    return lcor_scene_blocked(scene, x, light->position, skip, cache);
}

double light_channel(const light_set *set, const double rgb[3], int c)
{
    return set->channels == 3 ? rgb[c] : vec_dot(rgb, set->luminance);
}

int light_is_open(const lcor_scene *scene, const lcor_light *light)
{
    return scene->convex && light->kind != LCOR_LIGHT_DIRECTIONAL &&
           lcor_scene_inside(scene, light->position);
}

int light_in_solid(const lcor_scene *scene, const lcor_light *light)
{
    return light->kind != LCOR_LIGHT_DIRECTIONAL && lcor_scene_in_solid(scene, light->position);
}

/* out += factor times the light's intensity */
static void add_light(const light_set *set, const lcor_light *light, double factor, double *out)
{
    for (int c = 0; c < set->channels; c++)
        out[c] += factor * light_channel(set, light->intensity, c);
}

void light_at(const light_set *set, const double x[3], const double normal[3], uint32_t skip,
              double *out)
{
    for (int c = 0; c < set->channels; c++)
        out[c] = 0;
    for (size_t i = 0; i < set->scene->lights.count; i++) {
        const lcor_light *light = scene_light_at(set->scene, i);
        const double value = lcor_direct_unshadowed(light, x, normal);

        if (value > 0 && (set->open[i] || !lcor_direct_shadowed(set->scene, light, x, skip, NULL)))
            add_light(set, light, value, out);
    }
}

/* One light of those that were offered, each with a chance of its share of their power. */
typedef struct choice {
    const lcor_light *light;
    double value, power, all; /* value, power: of the chosen one; all: power of those offered */
    double random;            /* of 0..1, whatever was chosen */
} choice;

static void offer(choice *c, const lcor_light *light, double value, double power)
{
    c->all += power;
    if (c->random * c->all < power || !(c->all > power)) {
        c->light = light;
        c->value = value;
        c->power = power;
        c->random *= c->all / power;
    } else {
        c->random = (c->random * c->all - power) / (c->all - power);
    }
}

void light_by_chance(const light_set *set, const double x[3], const double normal[3], uint32_t skip,
                     int strongest, double random, double *out)
{
    choice chosen = {NULL, 0, 0, 0, random}, most = {NULL, 0, 0, 0, 0};

    for (int c = 0; c < set->channels; c++)
        out[c] = 0;
    for (size_t i = 0; i < set->scene->lights.count; i++) {
        const lcor_light *light = scene_light_at(set->scene, i);
        const double value = lcor_direct_unshadowed(light, x, normal);
        choice now = {light, value, 0, 0, 0};

        if (!(value > 0))
            continue;
        if (set->open[i]) {
            add_light(set, light, value, out);
            continue;
        }
        now.power = value * set->power[i];
        if (strongest && now.power > most.power) {
            const choice weaker = most;

            most = now;
            now = weaker;
        }
        if (now.power > 0)
            offer(&chosen, now.light, now.value, now.power);
    }
    if (most.light && !lcor_direct_shadowed(set->scene, most.light, x, skip, NULL))
        add_light(set, most.light, most.value, out);
    if (chosen.light && !lcor_direct_shadowed(set->scene, chosen.light, x, skip, NULL))
        add_light(set, chosen.light, chosen.value * chosen.all / chosen.power, out);
}
