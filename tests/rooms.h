/* SPDX-License-Identifier: MIT */
/* Scenes that several tests solve. */
#ifndef LCOR_TEST_ROOMS_H
#define LCOR_TEST_ROOMS_H

#include "room_quads.h"
#include "testing.h"

#include <lcor/radiosity.h>

static inline void must(lcor_status status, const lcor_error *err)
{
    if (status != LCOR_OK)
        fail_msg("%s: %s", lcor_status_name(status), err->text);
}

/* The six faces of a cube of the given edge, facing inward, in the order of room_names. */
static inline void add_room(lcor_scene *scene, double edge, const double rho[ROOM_FACES],
                            double emission, size_t patches)
{
    for (int f = 0; f < ROOM_FACES; f++) {
        lcor_surface look;
        lcor_error err;
        double corner[9];

        memset(&look, 0, sizeof look);
        for (int c = 0; c < 3; c++) {
            look.reflectance[c] = rho[f];
            look.emission[c] = emission;
        }
        look.patches[0] = look.patches[1] = patches;
        for (int k = 0; k < 9; k++)
            corner[k] = edge * room_quads[f][k];
        must(lcor_scene_add_quad(scene, corner, corner + 3, corner + 6, &look, NULL, &err), &err);
    }
}

static inline void add_lamp(lcor_scene *scene, double x, double y, double z, double intensity)
{
    lcor_light light;
    lcor_error err;

    memset(&light, 0, sizeof light);
    light.position[0] = x;
    light.position[1] = y;
    light.position[2] = z;
    light.intensity[0] = light.intensity[1] = light.intensity[2] = intensity;
    must(lcor_scene_add_light(scene, &light, NULL, &err), &err);
}

/* Top and sides of a box that stands on the floor, facing outward. */
static inline void add_box(lcor_scene *scene, const double low[3], const double high[3], double rho,
                           size_t patches)
{
    const double dx = high[0] - low[0], dy = high[1] - low[1], dz = high[2] - low[2];
    const double faces[5][9] = {{low[0], low[1], high[2], dx, 0, 0, 0, dy, 0},
                                {low[0], low[1], low[2], 0, 0, dz, 0, dy, 0},
                                {high[0], low[1], low[2], 0, dy, 0, 0, 0, dz},
                                {low[0], low[1], low[2], dx, 0, 0, 0, 0, dz},
                                {low[0], high[1], low[2], 0, 0, dz, dx, 0, 0}};

    for (int f = 0; f < 5; f++) {
        lcor_surface look;
        lcor_error err;

        memset(&look, 0, sizeof look);
        for (int c = 0; c < 3; c++)
            look.reflectance[c] = rho;
        look.patches[0] = look.patches[1] = patches;
        must(lcor_scene_add_quad(scene, faces[f], faces[f] + 3, faces[f] + 6, &look, NULL, &err),
             &err);
    }
}

static const double paper_rho[ROOM_FACES] = {0.3, 0.8, 0.5, 0.5, 0.5, 0.5};
static const double paper_box_low[3] = {0.45, 0.2, 0}, paper_box_high[3] = {0.75, 0.5, 0.4};

/* The room of the paper's Table 3, not yet committed. */
static inline lcor_scene *paper_room(size_t patches)
{
    lcor_scene *scene = NULL;
    lcor_error err;

    must(lcor_scene_new(NULL, &scene, &err), &err);
    add_room(scene, 1, paper_rho, 0, patches);
    add_lamp(scene, 0.3, 0.4, 0.7, 1);
    return scene;
}

static inline void commit(lcor_scene *scene)
{
    lcor_error err;

    must(lcor_scene_commit(scene, NULL, &err), &err);
}

static inline lcor_radiosity_options options_for(lcor_engine engine, double tolerance)
{
    lcor_radiosity_options options;

    memset(&options, 0, sizeof options);
    options.struct_size = sizeof options;
    options.tolerance = tolerance;
    options.engine = engine;
    return options;
}

static inline lcor_solution *solve_with(const lcor_scene *scene,
                                        const lcor_radiosity_options *options)
{
    lcor_solution *solution = NULL;
    lcor_error err;

    must(lcor_radiosity_solve(scene, options, &solution, &err), &err);
    return solution;
}

static inline lcor_solution *solve(const lcor_scene *scene, double tolerance, lcor_norm norm)
{
    lcor_radiosity_options options = options_for(LCOR_ENGINE_AUTO, tolerance);

    options.norm = norm;
    return solve_with(scene, &options);
}

/* How far a solution has come: times progress was reported, and the one that cancels. */
typedef struct canceller {
    int calls, at;
} canceller;

static inline int cancel_at(void *user, double done)
{
    canceller *c = user;

    (void)done;
    return ++c->calls == c->at;
}

static inline void check_cancelled(const lcor_scene *scene, lcor_radiosity_options options, int at)
{
    canceller c = {0, at};
    lcor_solution *solution = NULL;
    lcor_error err;

    options.progress.report = cancel_at;
    options.progress.user = &c;
    assert_int_equal(lcor_radiosity_solve(scene, &options, &solution, &err), LCOR_ERR_CANCELLED);
    assert_null(solution);
    assert_int_equal(c.calls, at);
}

/* All patches of the room's faces in the references' order. */
static inline void room_patches(const lcor_solution *solution, size_t n, lcor_value value,
                                double *total)
{
    double *own = malloc(n * n * sizeof *own);
    lcor_error err;

    assert_non_null(own);
    for (size_t f = 0; f < ROOM_FACES; f++) {
        must(lcor_solution_patches(solution, f, value, own, NULL, &err), &err);
        for (size_t i = 0; i < n; i++)
            for (size_t j = 0; j < n; j++)
                total[(f * n + i) * n + j] = room_swapped[f] ? own[j * n + i] : own[i * n + j];
    }
    free(own);
}

static inline int room_face_number(const char *name)
{
    for (int f = 0; f < ROOM_FACES; f++)
        if (strcmp(name, room_names[f]) == 0)
            return f;
    fail_msg("no face %s", name);
    return -1;
}

#endif
