/* SPDX-License-Identifier: MIT */
/* Scenes of triangles that the benches solve, made by rule: a furnished room of any number of
 * triangles, a hall with columns, an open box with one bright patch. Lengths are metres. */
#ifndef LCOR_BENCH_SCENES_H
#define LCOR_BENCH_SCENES_H

#include <lcor/scene.h>

#include <stdint.h>

enum { BENCH_LIGHTS = 8 };

typedef struct bench_scene {
    size_t count, capacity, dropped; /* triangles; dropped: those without area */
    double (*corners)[9];
    double *rho;
    double *area_to; /* of all triangles up to and with this one */
    lcor_light lights[BENCH_LIGHTS];
    size_t light_count;
    uint64_t random;
} bench_scene;

/* Shelves full of books, tables and chairs in a closed room; about `triangles` of them, 1000 or
 * more. The more, the finer the books. */
void bench_furnished_room(bench_scene *scene, size_t triangles);
/* 360 triangles: two rows of columns under four lamps. */
void bench_hall(bench_scene *scene);
/* 34 triangles: a box without front, two blocks in it, and a spotlight on a tenth of the
 * ceiling, by which alone everything is lit. */
void bench_open_box(bench_scene *scene);
/* By name: "room", "hall", "box", "room1000" and so on. Returns 0 if there is none such. */
int bench_scene_named(bench_scene *scene, const char *name);
void bench_scene_free(bench_scene *scene);

/* The same for the library, committed; every triangle seen from both sides, one patch each. */
lcor_scene *bench_library_scene(const bench_scene *scene);

/* A triangle, all equally likely by area, and a point of it; the normal is its facing one. */
size_t bench_random_point(const bench_scene *scene, uint64_t *state, double x[3], double n[3]);

/* xorshift64*, 0 <= x < 1 */
double bench_random(uint64_t *state);

/* Edges from the first corner and the facing normal of length 1; returns the area. */
double bench_triangle(const double corners[9], double u[3], double v[3], double n[3]);

#endif
