/* SPDX-License-Identifier: MIT */
/* Irradiance by path tracing, simple and slow: an independent judge of the solver. Every ray is
 * compared with every surface, every path is independent of the others, and each mean comes with
 * its standard error. It shares no code with the library, only the definition of its lights. */
#ifndef LCOR_TEST_PATH_TRACER_H
#define LCOR_TEST_PATH_TRACER_H

#include "testing.h"

#include <lcor/scene.h>

enum { TRACER_SURFACES = 80, TRACER_LIGHTS = 4, TRACER_NONE = -1 };

typedef struct tracer_surface {
    double origin[3], u[3], v[3]; /* parallelogram, or the triangle of origin, +u, +v */
    double normal[3], area;
    int triangle, two_sided;
    double rho[3], emission[3];
} tracer_surface;

typedef struct tracer_scene {
    tracer_surface surfaces[TRACER_SURFACES];
    lcor_light lights[TRACER_LIGHTS];
    int surface_count, light_count;
} tracer_scene;

/* Mean and sum of squared deviations, value by value (Welford). */
typedef struct tracer_mean {
    double mean, squares;
    long n;
} tracer_mean;

static inline void tracer_mean_add(tracer_mean *m, double x)
{
    const double d = x - m->mean;

    m->n++;
    m->mean += d / (double)m->n;
    m->squares += d * (x - m->mean);
}

static inline double tracer_standard_error(const tracer_mean *m)
{
    return sqrt(m->squares / (double)(m->n - 1) / (double)m->n);
}

static inline double tracer_dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline void tracer_cross(const double a[3], const double b[3], double out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

/* Adds a surface and returns it, dark and one-sided. */
static inline tracer_surface *tracer_add(tracer_scene *scene, const double origin[3],
                                         const double u[3], const double v[3], int triangle)
{
    tracer_surface *s = &scene->surfaces[scene->surface_count++];
    double length;

    assert_true(scene->surface_count <= TRACER_SURFACES);
    memset(s, 0, sizeof *s);
    memcpy(s->origin, origin, sizeof s->origin);
    memcpy(s->u, u, sizeof s->u);
    memcpy(s->v, v, sizeof s->v);
    s->triangle = triangle;
    tracer_cross(u, v, s->normal);
    length = sqrt(tracer_dot(s->normal, s->normal));
    s->area = triangle ? length / 2 : length;
    for (int k = 0; k < 3; k++)
        s->normal[k] /= length;
    return s;
}

/* Where the ray meets the surface's inside, or a negative number. */
static inline double tracer_meet(const tracer_surface *s, const double x[3], const double d[3])
{
    const double towards = tracer_dot(s->normal, d);
    double p[3], c[3], t, a, b, whole;

    for (int k = 0; k < 3; k++)
        p[k] = s->origin[k] - x[k];
    t = tracer_dot(s->normal, p) / towards;
    if (!(t > 0) || !isfinite(t))
        return -1;
    for (int k = 0; k < 3; k++)
        p[k] = t * d[k] - p[k];
    tracer_cross(s->u, s->v, c);
    whole = tracer_dot(c, s->normal);
    tracer_cross(p, s->v, c);
    a = tracer_dot(c, s->normal) / whole;
    tracer_cross(s->u, p, c);
    b = tracer_dot(c, s->normal) / whole;
    return a < 0 || b < 0 || a > 1 || b > 1 || (s->triangle && a + b > 1) ? -1 : t;
}

/* The nearest surface that x + t d meets within (0, *t), or TRACER_NONE. A flat surface never
 * meets a ray that starts on it: that one is `skip`. */
static inline int tracer_nearest(const tracer_scene *scene, const double x[3], const double d[3],
                                 int skip, double *t)
{
    int found = TRACER_NONE;

    for (int i = 0; i < scene->surface_count; i++)
        if (i != skip) {
            const double at = tracer_meet(&scene->surfaces[i], x, d);

            if (at > 0 && at < *t) {
                *t = at;
                found = i;
            }
        }
    return found;
}

/* Irradiance by one light before shadows, per intensity: KHR_lights_punctual. *to leads to the
 * light, *far is how much of it. */
static inline double tracer_light(const lcor_light *light, const double x[3], const double n[3],
                                  double to[3], double *far)
{
    double r2, r, cosine, value;

    if (light->kind == LCOR_LIGHT_DIRECTIONAL) {
        r = sqrt(tracer_dot(light->direction, light->direction));
        for (int k = 0; k < 3; k++)
            to[k] = -light->direction[k] / r;
        *far = HUGE_VAL;
        return fmax(0, tracer_dot(to, n));
    }
    for (int k = 0; k < 3; k++)
        to[k] = light->position[k] - x[k];
    *far = 1;
    r2 = tracer_dot(to, to);
    r = sqrt(r2);
    cosine = tracer_dot(to, n) / r;
    if (!(cosine > 0))
        return 0;
    value = cosine / r2;
    if (light->range > 0)
        value *= fmax(0, fmin(1, 1 - pow(r / light->range, 4)));
    if (light->kind == LCOR_LIGHT_SPOT) {
        const double inner = cos(light->inner_cone), outer = cos(light->outer_cone);
        const double along = -tracer_dot(to, light->direction) /
                             (r * sqrt(tracer_dot(light->direction, light->direction)));
        const double ramp = fmax(0, fmin(1, (along - outer) / fmax(0.001, inner - outer)));

        value *= ramp * ramp;
    }
    return value;
}

/* Irradiance by the lights without area at x on surface `on`. */
static inline void tracer_direct(const tracer_scene *scene, const double x[3], const double n[3],
                                 int on, double out[3])
{
    memset(out, 0, 3 * sizeof *out);
    for (int i = 0; i < scene->light_count; i++) {
        double to[3], far;
        const double value = tracer_light(&scene->lights[i], x, n, to, &far);

        if (value > 0 && tracer_nearest(scene, x, to, on, &far) == TRACER_NONE)
            for (int c = 0; c < 3; c++)
                out[c] += value * scene->lights[i].intensity[c];
    }
}

/* A direction about n, its density proportional to the cosine. */
static inline void tracer_cosine(const double n[3], uint64_t *state, double d[3])
{
    const double phi = 2 * acos(-1) * random_unit(state), r2 = random_unit(state), r = sqrt(r2);
    const double helper[3] = {fabs(n[0]) < 0.5, fabs(n[0]) >= 0.5, 0};
    double a[3], b[3], length;

    tracer_cross(n, helper, a);
    length = sqrt(tracer_dot(a, a));
    for (int k = 0; k < 3; k++)
        a[k] /= length;
    tracer_cross(n, a, b);
    for (int k = 0; k < 3; k++)
        d[k] = r * cos(phi) * a[k] + r * sin(phi) * b[k] + sqrt(1 - r2) * n[k];
}

/* Adds what one path from x brings of everything but the straight light of the lights. */
static inline void tracer_path(const tracer_scene *scene, const double start[3],
                               const double normal[3], int on, uint64_t *state, double sum[3])
{
    double x[3], n[3], weight[3] = {1, 1, 1};

    memcpy(x, start, sizeof x);
    memcpy(n, normal, sizeof n);
    for (int bounce = 0;; bounce++) {
        const tracer_surface *s;
        double d[3], direct[3], t = HUGE_VAL, alive = 0;
        int back;

        tracer_cosine(n, state, d);
        on = tracer_nearest(scene, x, d, on, &t);
        if (on == TRACER_NONE)
            return;
        s = &scene->surfaces[on];
        back = tracer_dot(d, s->normal) > 0;
        if (back && !s->two_sided)
            return;
        for (int k = 0; k < 3; k++) {
            x[k] += t * d[k];
            n[k] = back ? -s->normal[k] : s->normal[k];
        }
        tracer_direct(scene, x, n, on, direct);
        for (int c = 0; c < 3; c++) {
            sum[c] += weight[c] * (s->emission[c] + s->rho[c] * direct[c]);
            weight[c] *= s->rho[c];
            alive = fmax(alive, s->rho[c]);
        }
        if (alive == 0)
            return;
        if (bounce >= 2) { /* Russian roulette keeps the mean */
            if (random_unit(state) >= alive)
                return;
            for (int c = 0; c < 3; c++)
                weight[c] /= alive;
        }
    }
}

/* Point a along u, b along v of the surface. */
static inline void tracer_point(const tracer_surface *s, double a, double b, double x[3])
{
    for (int k = 0; k < 3; k++)
        x[k] = s->origin[k] + a * s->u[k] + b * s->v[k];
}

/* A point of the surface, all equally likely. */
static inline void tracer_random_point(const tracer_surface *s, uint64_t *state, double x[3])
{
    const double a = random_unit(state), b = random_unit(state);
    const int fold = s->triangle && a + b > 1;

    tracer_point(s, fold ? 1 - a : a, fold ? 1 - b : b, x);
}

/* The same scene for the library, committed. Every surface gets n x n patches. */
static inline lcor_scene *tracer_library_scene(const tracer_scene *scene, size_t n)
{
    lcor_scene *out = NULL;
    lcor_error err = {0};
    int status = lcor_scene_new(NULL, &out, &err);

    for (int i = 0; i < scene->surface_count && status == LCOR_OK; i++) {
        const tracer_surface *s = &scene->surfaces[i];
        lcor_surface look;
        double b[3], c[3];

        memset(&look, 0, sizeof look);
        memcpy(look.reflectance, s->rho, sizeof look.reflectance);
        memcpy(look.emission, s->emission, sizeof look.emission);
        look.patches[0] = look.patches[1] = n;
        look.two_sided = s->two_sided;
        tracer_point(s, 1, 0, b);
        tracer_point(s, 0, 1, c);
        status = s->triangle ? lcor_scene_add_triangle(out, s->origin, b, c, &look, NULL, &err)
                             : lcor_scene_add_quad(out, s->origin, s->u, s->v, &look, NULL, &err);
    }
    for (int i = 0; i < scene->light_count && status == LCOR_OK; i++)
        status = lcor_scene_add_light(out, &scene->lights[i], NULL, &err);
    if (status == LCOR_OK)
        status = lcor_scene_commit(out, NULL, &err);
    if (status != LCOR_OK)
        fail_msg("%s", err.text);
    return out;
}

#endif
