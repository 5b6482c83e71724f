/* SPDX-License-Identifier: MIT */
/* Makes tests/data/reference/gather_SCENE.csv: irradiance at points and of whole triangles of a
 * scene of bench/scenes.c by path tracing. It shares the ray structure with the library, and
 * nothing else.
 *
 *   reference_gather SCENE BATCHES > gather_SCENE.csv
 *
 * Every value is the mean of BATCHES independent batches of 64 x 64 paths, whose first directions
 * are stratified; sigma is the standard error of that mean. Points and triangles are drawn by
 * area, on the facing side. */
#include "scenes.h"

#include "scene/scene_internal.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { STRATA = 64, POINTS = 200, TRIANGLES = 100 };

static const double two_pi = 6.283185307179586;

typedef struct place {
    double x[3], n[3];
    uint32_t on;
} place;

static double direct(const bench_scene *scene, const lcor_scene *rays, const place *at,
                     uint32_t *cache)
{
    double sum = 0;

    for (size_t i = 0; i < scene->light_count; i++) {
        const lcor_light *light = &scene->lights[i];
        lcor_ray ray;
        double r2 = 0, cosine = 0, value, along = 0;

        memcpy(ray.origin, at->x, sizeof ray.origin);
        for (int k = 0; k < 3; k++) {
            ray.direction[k] = light->position[k] - at->x[k];
            r2 += ray.direction[k] * ray.direction[k];
            cosine += ray.direction[k] * at->n[k];
            along -= ray.direction[k] * light->direction[k];
        }
        if (cosine <= 0)
            continue;
        value = light->intensity[0] * cosine / (r2 * sqrt(r2));
        if (light->kind == LCOR_LIGHT_SPOT) { /* its direction has length 1 */
            const double inner = cos(light->inner_cone), outer = cos(light->outer_cone);
            const double ramp = fmax(0, fmin(1, (along / sqrt(r2) - outer) / (inner - outer)));

            value *= ramp * ramp;
        }
        ray.t_min = 0;
        ray.t_max = 1;
        ray.skip = at->on;
        if (value > 0 && !lcor_bvh_occluded(rays->bvh, &ray, &cache[i]))
            sum += value;
    }
    return sum;
}

/* The cosine-weighted direction of (a, b) in the unit square about n. */
static void direction(const double n[3], double a, double b, double d[3])
{
    const int k = fabs(n[0]) > 0.5 ? 0 : fabs(n[1]) > 0.5 ? 1 : 2;
    const double r = sqrt(a), up = sqrt(1 - a), p = r * cos(two_pi * b), q = r * sin(two_pi * b);
    double s[3] = {0, 0, 0}, t[3], length;

    s[k] = -n[(k + 1) % 3];
    s[(k + 1) % 3] = n[k];
    length = sqrt(s[k] * s[k] + s[(k + 1) % 3] * s[(k + 1) % 3]);
    for (int j = 0; j < 3; j++)
        s[j] /= length;
    for (int j = 0; j < 3; j++)
        t[j] = n[(j + 1) % 3] * s[(j + 2) % 3] - n[(j + 2) % 3] * s[(j + 1) % 3];
    for (int j = 0; j < 3; j++)
        d[j] = p * s[j] + q * t[j] + up * n[j];
}

/* Indirect irradiance along one path whose first direction is d. */
static double path(const bench_scene *scene, const lcor_scene *rays, place at, const double d[3],
                   uint64_t *state, uint32_t *cache)
{
    double weight = 1, sum = 0, towards[3];

    memcpy(towards, d, sizeof towards);
    for (int bounce = 0;; bounce++) {
        lcor_bvh_hit hit;
        lcor_ray ray;
        double u[3], v[3], side = 0;

        memcpy(ray.origin, at.x, sizeof ray.origin);
        memcpy(ray.direction, towards, sizeof ray.direction);
        ray.t_min = 0;
        ray.t_max = HUGE_VAL;
        ray.skip = at.on;
        if (!lcor_bvh_closest(rays->bvh, &ray, &hit))
            return sum;
        at.on = hit.owner;
        (void)bench_triangle(scene->corners[hit.owner], u, v, at.n);
        for (int k = 0; k < 3; k++) {
            at.x[k] += hit.t * towards[k];
            side += towards[k] * at.n[k];
        }
        for (int k = 0; k < 3 && side > 0; k++)
            at.n[k] = -at.n[k];
        weight *= scene->rho[hit.owner];
        sum += weight * direct(scene, rays, &at, cache);
        if (bounce >= 2) {
            if (bench_random(state) >= 0.6)
                return sum;
            weight /= 0.6;
        }
        direction(at.n, bench_random(state), bench_random(state), towards);
    }
}

static void spread(const double corners[9], double a, double b, double x[3])
{
    const double r = sqrt(a), s = 1 - r, t = r * b;

    for (int k = 0; k < 3; k++)
        x[k] = s * corners[k] + t * corners[3 + k] + (1 - s - t) * corners[6 + k];
}

/* Mean of one batch. Over a triangle the starts are stratified too, paired with directions at
 * random. */
static double batch(const bench_scene *scene, const lcor_scene *rays, const place *at, int whole,
                    uint64_t *state, uint32_t *cache)
{
    static int pair[STRATA * STRATA];
    double sum = 0;

    for (int i = 0; i < STRATA * STRATA; i++) {
        const int j = (int)((i + 1) * bench_random(state));

        pair[i] = pair[j];
        pair[j] = i;
    }
    for (int i = 0; i < STRATA * STRATA; i++) {
        const double a = ((double)(i / STRATA) + bench_random(state)) / STRATA;
        const double b = ((double)(i % STRATA) + bench_random(state)) / STRATA;
        place start = *at;
        double d[3];

        if (whole) {
            const double s = ((double)(pair[i] / STRATA) + bench_random(state)) / STRATA;
            const double t = ((double)(pair[i] % STRATA) + bench_random(state)) / STRATA;

            spread(scene->corners[at->on], s, t, start.x);
        }
        direction(at->n, a, b, d);
        if (whole)
            sum += direct(scene, rays, &start, cache);
        sum += path(scene, rays, start, d, state, cache);
    }
    return sum / (STRATA * STRATA) + (whole ? 0 : direct(scene, rays, at, cache));
}

int main(int argc, char **argv)
{
    const int batches = argc > 2 ? atoi(argv[2]) : 0;
    uint32_t cache[BENCH_LIGHTS];
    uint64_t state = 424242, places = 171717; /* the places do not depend on the batches */
    bench_scene scene;
    lcor_scene *rays;

    if (batches < 2 || !bench_scene_named(&scene, argv[1])) {
        fprintf(stderr, "usage: reference_gather room|hall|box BATCHES\n");
        return 2;
    }
    rays = bench_library_scene(&scene);
    for (int i = 0; i < BENCH_LIGHTS; i++)
        cache[i] = LCOR_BVH_NONE;
    printf("kind,triangle,x,y,z,nx,ny,nz,E,sigma\n");
    for (int i = 0; i < POINTS + TRIANGLES; i++) {
        double mean = 0, squares = 0;
        place at;

        at.on = (uint32_t)bench_random_point(&scene, &places, at.x, at.n);
        for (int k = 0; k < batches; k++) { /* Welford */
            const double e = batch(&scene, rays, &at, i >= POINTS, &state, cache);
            const double off = e - mean;

            mean += off / (k + 1);
            squares += off * (e - mean);
        }
        printf("%s,%u,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.8g,%.3g\n", i < POINTS ? "point" : "triangle",
               at.on, at.x[0], at.x[1], at.x[2], at.n[0], at.n[1], at.n[2], mean,
               sqrt(squares / (batches - 1) / batches));
        fflush(stdout);
    }
    lcor_scene_free(rays);
    bench_scene_free(&scene);
    return 0;
}
