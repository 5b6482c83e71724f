/* SPDX-License-Identifier: MIT */
/* Hidden surfaces against an independent ray caster: every polygon is tried for every ray, in the
 * plainest way, and nothing of the library is used but the camera's ray. */
#include "testing.h"

#include <lcor/view.h>

enum { QUADS = 40, TRIANGLES = 40, PIXELS = 10000, CAMERAS = 5, CULLED = 4 };

typedef struct polygon {
    size_t count;
    double p[5][3];
    double u[3], v[3];
} polygon;

typedef struct world {
    polygon faces[QUADS + TRIANGLES + 8];
    size_t count;
    lcor_scene *scene;
} world;

typedef struct caster_hit {
    long face;           /* -1: none */
    double t, u, v, gap; /* gap: how much farther the next face is */
} caster_hit;

static double dot(const double *a, const double *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const double *a, const double *b, double *c)
{
    c[0] = a[1] * b[2] - a[2] * b[1];
    c[1] = a[2] * b[0] - a[0] * b[2];
    c[2] = a[0] * b[1] - a[1] * b[0];
}

static int cast_one(const polygon *f, const double *o, const double *d, int cull, double *t,
                    double *u, double *v)
{
    double n[3], from[3], x[3], w[3], uu, uv, vv, wu, wv, det;

    cross(f->u, f->v, n);
    if (dot(n, d) == 0 || (cull && dot(n, d) > 0))
        return 0;
    for (int k = 0; k < 3; k++)
        from[k] = f->p[0][k] - o[k];
    *t = dot(n, from) / dot(n, d);
    if (!(*t > 0))
        return 0;
    for (int k = 0; k < 3; k++)
        x[k] = o[k] + *t * d[k];
    for (size_t i = 0; i < f->count; i++) {
        const double *a = f->p[i], *b = f->p[(i + 1) % f->count];
        double edge[3], to[3], side[3];

        for (int k = 0; k < 3; k++) {
            edge[k] = b[k] - a[k];
            to[k] = x[k] - a[k];
        }
        cross(edge, to, side);
        if (dot(side, n) < 0)
            return 0;
    }
    /* normal equations of x - p0 = u e_u + v e_v */
    for (int k = 0; k < 3; k++)
        w[k] = x[k] - f->p[0][k];
    uu = dot(f->u, f->u), uv = dot(f->u, f->v), vv = dot(f->v, f->v);
    wu = dot(w, f->u), wv = dot(w, f->v);
    det = uu * vv - uv * uv;
    *u = (wu * vv - wv * uv) / det;
    *v = (wv * uu - wu * uv) / det;
    return 1;
}

static caster_hit cast(const world *w, const double *o, const double *d, int cull)
{
    caster_hit best = {-1, HUGE_VAL, 0, 0, HUGE_VAL};

    for (size_t i = 0; i < w->count; i++) {
        double t, u, v;

        if (!cast_one(&w->faces[i], o, d, cull, &t, &u, &v))
            continue;
        if (t < best.t) {
            best.gap = best.t - t;
            best.face = (long)i, best.t = t, best.u = u, best.v = v;
        } else {
            best.gap = fmin(best.gap, t - best.t);
        }
    }
    return best;
}

static void add(world *w, const double *o, const double *u, const double *v, int quad)
{
    polygon *f = &w->faces[w->count++];
    const lcor_surface look = {.reflectance = {0.5, 0.5, 0.5}};

    f->count = quad ? 4 : 3;
    for (int k = 0; k < 3; k++) {
        f->u[k] = u[k];
        f->v[k] = v[k];
        f->p[0][k] = o[k];
        f->p[1][k] = o[k] + u[k];
        f->p[2][k] = quad ? o[k] + u[k] + v[k] : o[k] + v[k];
        f->p[3][k] = o[k] + v[k];
    }
    if (quad)
        assert_int_equal(lcor_scene_add_quad(w->scene, o, u, v, &look, NULL, NULL), LCOR_OK);
    else
        assert_int_equal(
            lcor_scene_add_triangle(w->scene, f->p[0], f->p[1], f->p[2], &look, NULL, NULL),
            LCOR_OK);
}

/* A room -5..5 with quads and triangles, many of them cutting through each other. */
static void make_world(world *w)
{
    uint64_t seed = 1;

    w->count = 0;
    assert_int_equal(lcor_scene_new(NULL, &w->scene, NULL), LCOR_OK);
    for (int axis = 0; axis < 3; axis++)
        for (int side = -1; side <= 1; side += 2) {
            double o[3] = {-5, -5, -5}, u[3] = {0}, v[3] = {0};

            o[axis] = 5.0 * side;
            u[(axis + (side < 0 ? 1 : 2)) % 3] = 10;
            v[(axis + (side < 0 ? 2 : 1)) % 3] = 10;
            add(w, o, u, v, 1);
        }
    for (int i = 0; i < QUADS + TRIANGLES; i++) {
        double o[3], u[3], v[3];

        for (int k = 0; k < 3; k++) {
            o[k] = 8 * random_unit(&seed) - 4;
            u[k] = 3 * random_unit(&seed) - 1.5;
            v[k] = 3 * random_unit(&seed) - 1.5;
        }
        add(w, o, u, v, i < QUADS);
    }
    assert_int_equal(lcor_scene_commit(w->scene, NULL, NULL), LCOR_OK);
}

static lcor_camera camera_number(int i)
{
    static const lcor_camera cameras[CAMERAS] = {
        {{0, 0, 0}, {0, 0, -1}, {0, 1, 0}, 1.2, 0, 0, 0, 320, 240},
        {{4, 4.5, 4}, {-1, -1.1, -0.9}, {0, 1, 0}, 0.7, 0, 0, 0, 311, 253},
        {{-4.9, -4.9, 3}, {2, 0.3, -0.1}, {0, 0, 1}, 2.2, 0, 0, 0, 400, 100},
        {{1, 2, 4.5}, {0.1, -0.2, -1}, {1, 1, 0}, 0, 7, 0, 0, 200, 300},
        {{14, 9, 17}, {-14, -9, -17}, {0, 1, 0}, 0.6, 0, 0, 0, 320, 240},
    };
    return cameras[i];
}

static lcor_view *new_view(const world *w, const lcor_camera *camera, int lines, int cull)
{
    unsigned char flags[QUADS + TRIANGLES + 8];
    const lcor_view_options options = {
        .struct_size = sizeof options, .lines = lines, .cull_back = cull ? flags : NULL};
    lcor_view *view = NULL;

    memset(flags, 1, sizeof flags);
    assert_int_equal(lcor_view_new(w->scene, camera, &options, &view, NULL), LCOR_OK);
    return view;
}

/* The fragment of `face` in pixel (x, y), or NULL. */
static const lcor_span *span_of(const lcor_view *view, size_t x, size_t y, long face,
                                double *covered)
{
    size_t count;
    const lcor_span *spans = lcor_view_row(view, y, &count), *found = NULL;

    *covered = 0;
    for (size_t i = 0; i < count; i++)
        if (spans[i].x0 <= x && x < spans[i].x1) {
            *covered += (double)spans[i].coverage;
            if ((long)spans[i].surface == face)
                found = &spans[i];
        }
    return found;
}

/* du and dv against differences of u and v over a thousandth of a pixel. */
static void check_derivatives(const lcor_view *view, size_t y, lcor_span at, size_t x,
                              const lcor_place *place)
{
    for (int k = 0; k < 2; k++) {
        lcor_place next;
        double step;

        at.at[0] = at.at[1] = 0.5F;
        at.at[k] = 0.501F;
        step = (double)at.at[k] - 0.5;
        lcor_view_places(view, y, &at, x, 1, &next);
        check_near((next.uv[0] - place->uv[0]) / step, place->du[k],
                   1e-5 + 0.02 * fabs(place->du[k]), "du");
        check_near((next.uv[1] - place->uv[1]) / step, place->dv[k],
                   1e-5 + 0.02 * fabs(place->dv[k]), "dv");
    }
}

static void check_pixel(const world *w, const lcor_view *view, const lcor_camera *camera, size_t x,
                        size_t y, int cull, int *compared)
{
    double origin[3], direction[3], covered, ahead;
    lcor_span at;
    const lcor_span *span;
    lcor_place place;
    caster_hit hit;

    /* a line of the view runs through the row's middle when their number is odd */
    lcor_camera_ray(camera, (double)x + 0.5, (double)y + 0.5, origin, direction);
    hit = cast(w, origin, direction, cull);
    if (hit.face < 0)
        return;
    span = span_of(view, x, y, hit.face, &covered);
    if (hit.gap < 1e-6)
        return; /* two faces at one place: either may be seen */
    assert_non_null(span);
    assert_true(covered <= 1 + 1e-5);
    at = *span;
    at.at[0] = at.at[1] = 0.5F; /* the ray's place, whatever part of the pixel is covered */
    lcor_view_places(view, y, &at, x, 1, &place);
    ahead = hit.t * (dot(direction, camera->forward) / sqrt(dot(camera->forward, camera->forward)));
    check_near(place.uv[0], hit.u, 1e-8, "u");
    check_near(place.uv[1], hit.v, 1e-8, "v");
    check_near(place.depth, ahead, 1e-8 * ahead, "depth");
    check_derivatives(view, y, at, x, &place);
    (*compared)++;
}

static void view_agrees_with_an_independent_ray_caster(void **state)
{
    world w;
    uint64_t seed = 7;
    int compared = 0;

    (void)state;
    make_world(&w);
    for (int i = 0; i < CAMERAS; i++) {
        const lcor_camera camera = camera_number(i);
        lcor_view *view;

        view = new_view(&w, &camera, 3, i == CULLED);
        for (int k = 0; k < PIXELS / CAMERAS; k++) {
            const size_t x = (size_t)(random_unit(&seed) * (double)camera.size_x);
            const size_t y = (size_t)(random_unit(&seed) * (double)camera.size_y);

            check_pixel(&w, view, &camera, x, y, i == CULLED, &compared);
        }
        lcor_view_free(view);
    }
    assert_true(compared > PIXELS * 8 / 10);
    lcor_scene_free(w.scene);
}

/* The share of each surface in small pictures, by coverage and by many rays. */
static void coverage_agrees_with_many_rays_a_pixel(void **state)
{
    enum { RAYS = 24 };
    world w;

    (void)state;
    make_world(&w);
    for (int i = 0; i < CAMERAS; i++) {
        lcor_camera camera = camera_number(i);
        lcor_view *view;
        double worst = 0;

        camera.size_x = 12;
        camera.size_y = 9;
        view = new_view(&w, &camera, 32, i == CULLED);
        for (size_t y = 0; y < camera.size_y; y++)
            for (size_t x = 0; x < camera.size_x; x++) {
                double seen[QUADS + TRIANGLES + 8] = {0};

                for (int r = 0; r < RAYS * RAYS; r++) {
                    double o[3], d[3];
                    caster_hit hit;

                    lcor_camera_ray(&camera, (double)x + (r % RAYS + 0.5) / RAYS,
                                    (double)y + (r / RAYS + 0.5) / RAYS, o, d);
                    hit = cast(&w, o, d, i == CULLED);
                    if (hit.face >= 0)
                        seen[hit.face] += 1.0 / (RAYS * RAYS);
                }
                for (size_t face = 0; face < w.count; face++) {
                    double covered;
                    const lcor_span *span = span_of(view, x, y, (long)face, &covered);

                    worst = fmax(worst, fabs(seen[face] - (span ? (double)span->coverage : 0)));
                }
            }
        lcor_view_free(view);
        check_near(worst, 0, 1.5 / RAYS, "coverage"); /* an edge along the rays */
    }
    lcor_scene_free(w.scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(view_agrees_with_an_independent_ray_caster),
        cmocka_unit_test(coverage_agrees_with_many_rays_a_pixel),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
