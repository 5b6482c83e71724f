/* SPDX-License-Identifier: MIT */
/* Seeded scenes of everything the solver takes: rooms closed or with walls missing, boxes on the
 * floor, screens seen from both sides, dark occluders, area emitters, every kind of light. */
#ifndef LCOR_TEST_RANDOM_SCENES_H
#define LCOR_TEST_RANDOM_SCENES_H

#include "path_tracer.h"

static inline double random_within(uint64_t *state, double low, double high)
{
    return low + (high - low) * random_unit(state);
}

static inline int random_below(uint64_t *state, int n) { return (int)(n * random_unit(state)); }

static inline void random_look(tracer_surface *s, int coloured, uint64_t *state)
{
    const double grey = random_within(state, 0.2, 0.85);

    for (int c = 0; c < 3; c++)
        s->rho[c] = coloured ? random_within(state, 0.1, 0.85) : grey;
}

/* The six faces of low..high, seen from inside or, without the bottom, from outside; `keep` has a
 * bit for each: bottom, top, then the sides. Inside faces may be cut into two triangles. */
static inline void random_cuboid(tracer_scene *scene, const double low[3], const double high[3],
                                 int inside, unsigned keep, int coloured, uint64_t *state)
{
    const double e[3][3] = {
        {high[0] - low[0], 0, 0}, {0, high[1] - low[1], 0}, {0, 0, high[2] - low[2]}};
    static const int axes[6] = {2, 2, 0, 0, 1, 1};

    for (int f = 0; f < 6; f++) {
        const int axis = axes[f], far = f % 2;
        const int swap = far == inside; /* edges a x b point along +axis; flip where needed */
        const double *a = e[(axis + 1 + swap) % 3], *b = e[(axis + 2 - swap) % 3];
        double corner[3], opposite[3], minus_a[3], minus_b[3];
        tracer_surface *s;
        int cut;

        if (!(keep >> f & 1))
            continue;
        memcpy(corner, low, sizeof corner);
        corner[axis] = far ? high[axis] : low[axis];
        for (int k = 0; k < 3; k++) {
            opposite[k] = corner[k] + a[k] + b[k];
            minus_a[k] = -a[k];
            minus_b[k] = -b[k];
        }
        cut = inside && random_unit(state) < 0.2;
        s = tracer_add(scene, corner, a, b, cut);
        random_look(s, coloured, state);
        if (cut)
            memcpy(tracer_add(scene, opposite, minus_a, minus_b, 1)->rho, s->rho, sizeof s->rho);
    }
}

/* A flat thing in mid-air: quad or triangle, one- or two-sided, or black. */
static inline void random_screen(tracer_scene *scene, const double size[3], int coloured,
                                 uint64_t *state)
{
    double o[3], u[3], v[3];
    tracer_surface *s;

    for (int k = 0; k < 3; k++) {
        o[k] = size[k] * random_within(state, 0.3, 0.7);
        u[k] = size[k] * random_within(state, -0.28, 0.28);
        v[k] = size[k] * random_within(state, -0.28, 0.28);
    }
    s = tracer_add(scene, o, u, v, random_unit(state) < 0.5);
    if (!s->triangle) /* centred, so that it stays inside */
        for (int k = 0; k < 3; k++)
            s->origin[k] -= 0.5 * (u[k] + v[k]);
    s->two_sided = random_unit(state) < 0.6;
    if (random_unit(state) < 0.7)
        random_look(s, coloured, state);
}

/* A panel below the ceiling, shining down, or a two-sided one that stands in the room. */
static inline void random_emitter(tracer_scene *scene, const double size[3], int coloured,
                                  uint64_t *state)
{
    const int standing = random_unit(state) < 0.3;
    double o[3] = {0, 0, size[2] * (standing ? 0.5 : 0.95)}, u[3] = {0, 0, 0}, v[3] = {0, 0, 0};
    tracer_surface *s;

    for (int k = 0; k < 2; k++)
        o[k] = size[k] * random_within(state, 0.15, 0.45);
    v[0] = size[0] * random_within(state, 0.2, 0.4);
    if (standing)
        u[2] = -size[2] * random_within(state, 0.1, 0.3);
    else
        u[1] = size[1] * random_within(state, 0.2, 0.4);
    s = tracer_add(scene, o, u, v, random_unit(state) < 0.3);
    s->two_sided = standing;
    random_look(s, coloured, state);
    for (int c = 0; c < 3; c++)
        s->emission[c] = coloured ? random_within(state, 1, 8) : 4;
}

static inline void random_light(tracer_scene *scene, const double size[3], int coloured,
                                uint64_t *state)
{
    lcor_light *light = &scene->lights[scene->light_count++];

    memset(light, 0, sizeof *light);
    light->kind = (lcor_light_kind)random_below(state, 3);
    for (int k = 0; k < 3; k++) {
        light->position[k] = size[k] * random_within(state, 0.2, 0.8);
        light->direction[k] = random_within(state, -1, k == 2 ? -0.2 : 1);
        light->intensity[k] = coloured ? random_within(state, 0.3, 3) : 2;
    }
    if (light->kind == LCOR_LIGHT_SPOT) {
        light->inner_cone = random_within(state, 0, 0.5);
        light->outer_cone = light->inner_cone + random_within(state, 0.2, 1);
    }
    if (random_unit(state) < 0.3)
        light->range = 2 * size[0];
}

/* Turns everything about a random axis: nothing stays aligned. */
static inline void random_turn(tracer_scene *scene, uint64_t *state)
{
    double axis[3], length, sine, cosine;
    double *vectors[3 * TRACER_SURFACES + TRACER_SURFACES + 2 * TRACER_LIGHTS];
    int n = 0;

    for (int k = 0; k < 3; k++)
        axis[k] = random_within(state, -1, 1);
    length = sqrt(tracer_dot(axis, axis));
    sine = sin(2 * length);
    cosine = cos(2 * length);
    for (int k = 0; k < 3; k++)
        axis[k] /= length;
    for (int i = 0; i < scene->surface_count; i++) {
        vectors[n++] = scene->surfaces[i].origin;
        vectors[n++] = scene->surfaces[i].u;
        vectors[n++] = scene->surfaces[i].v;
        vectors[n++] = scene->surfaces[i].normal;
    }
    for (int i = 0; i < scene->light_count; i++) {
        vectors[n++] = scene->lights[i].position;
        vectors[n++] = scene->lights[i].direction;
    }
    for (int i = 0; i < n; i++) { /* Rodrigues */
        const double along = tracer_dot(axis, vectors[i]) * (1 - cosine);
        double across[3];

        tracer_cross(axis, vectors[i], across);
        for (int k = 0; k < 3; k++)
            vectors[i][k] = cosine * vectors[i][k] + sine * across[k] + along * axis[k];
    }
}

/* Every other scene is closed, every fifth coloured, every third turned. */
static inline void random_scene(tracer_scene *scene, int number)
{
    uint64_t state = 0x9E3779B97F4A7C15u * (uint64_t)(number + 1);
    const int coloured = number % 5 == 4, boxes = 1 + random_below(&state, 3);
    const unsigned walls = number % 2 ? 63u : 1u + 4u * (unsigned)random_below(&state, 16);
    const double zero[3] = {0, 0, 0};
    double size[3];

    memset(scene, 0, sizeof *scene);
    for (int k = 0; k < 3; k++)
        size[k] = random_within(&state, 1, 3);
    random_cuboid(scene, zero, size, 1, walls, coloured, &state);
    for (int i = 0; i < boxes; i++) { /* each in its own strip of the floor */
        double low[3] = {0, 0, 0}, high[3];

        for (int k = 0; k < 3; k++) {
            const double cell = k == 0 ? size[k] / boxes : size[k];

            low[k] = k == 2 ? 0 : cell * random_within(&state, 0.1, 0.4) + (k == 0 ? i * cell : 0);
            high[k] = low[k] + cell * random_within(&state, 0.2, 0.5);
        }
        random_cuboid(scene, low, high, 0, 62u, coloured, &state);
    }
    for (int i = random_below(&state, 3); i >= 0; i--)
        random_screen(scene, size, coloured, &state);
    if (number % 3 != 1)
        random_emitter(scene, size, coloured, &state);
    for (int i = number % 3 ? 1 + random_below(&state, 2) : random_below(&state, 2); i > 0; i--)
        random_light(scene, size, coloured, &state);
    if (number % 3 == 2)
        random_turn(scene, &state);
}

#endif
