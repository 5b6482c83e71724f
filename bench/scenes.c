/* SPDX-License-Identifier: MIT */
#include "scenes.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void fail(const char *what)
{
    fprintf(stderr, "bench: %s\n", what);
    exit(1);
}

double bench_random(uint64_t *state)
{
    *state ^= *state >> 12;
    *state ^= *state << 25;
    *state ^= *state >> 27;
    return (double)((*state * 2685821657736338717u) >> 11) * (1.0 / 9007199254740992.0);
}

double bench_triangle(const double corners[9], double u[3], double v[3], double n[3])
{
    double length;

    for (int k = 0; k < 3; k++) {
        u[k] = corners[3 + k] - corners[k];
        v[k] = corners[6 + k] - corners[k];
    }
    n[0] = u[1] * v[2] - u[2] * v[1];
    n[1] = u[2] * v[0] - u[0] * v[2];
    n[2] = u[0] * v[1] - u[1] * v[0];
    length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    for (int k = 0; k < 3 && length > 0; k++)
        n[k] /= length;
    return length / 2;
}

static void start(bench_scene *scene)
{
    memset(scene, 0, sizeof *scene);
    scene->random = 88172645463325252u;
}

static void triangle(bench_scene *scene, const double a[3], const double b[3], const double c[3],
                     double rho)
{
    double corners[9], u[3], v[3], n[3], area;

    memcpy(corners, a, 3 * sizeof *a);
    memcpy(corners + 3, b, 3 * sizeof *b);
    memcpy(corners + 6, c, 3 * sizeof *c);
    area = bench_triangle(corners, u, v, n);
    if (!(area > 0)) {
        scene->dropped++;
        return;
    }
    if (scene->count == scene->capacity) {
        scene->capacity = scene->capacity ? 2 * scene->capacity : 1024;
        scene->corners = realloc(scene->corners, scene->capacity * sizeof *scene->corners);
        scene->rho = realloc(scene->rho, scene->capacity * sizeof *scene->rho);
        scene->area_to = realloc(scene->area_to, scene->capacity * sizeof *scene->area_to);
        if (!scene->corners || !scene->rho || !scene->area_to)
            fail("no memory for a scene");
    }
    memcpy(scene->corners[scene->count], corners, sizeof corners);
    scene->rho[scene->count] = rho;
    scene->area_to[scene->count] = area + (scene->count ? scene->area_to[scene->count - 1] : 0);
    scene->count++;
}

/* The faces of `mask` (bottom, top, x low, x high, y low, y high) of a box, two triangles each,
 * seen from outside or from inside. `turn` rotates it about the vertical through its middle. */
static void box(bench_scene *scene, const double low[3], const double high[3], double turn,
                int inside, unsigned mask, double rho)
{
    static const int faces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 4, 6, 2},
                                    {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}};
    const double mx = 0.5 * (low[0] + high[0]), my = 0.5 * (low[1] + high[1]);
    double p[8][3];

    for (int i = 0; i < 8; i++) {
        const double x = (i & 1 ? high[0] : low[0]) - mx, y = (i & 2 ? high[1] : low[1]) - my;

        p[i][0] = mx + cos(turn) * x - sin(turn) * y;
        p[i][1] = my + sin(turn) * x + cos(turn) * y;
        p[i][2] = i & 4 ? high[2] : low[2];
    }
    for (int f = 0; f < 6; f++) {
        const int *c = faces[f];

        if (!(mask >> f & 1))
            continue;
        if (inside) {
            triangle(scene, p[c[0]], p[c[2]], p[c[1]], rho);
            triangle(scene, p[c[0]], p[c[3]], p[c[2]], rho);
        } else {
            triangle(scene, p[c[0]], p[c[1]], p[c[2]], rho);
            triangle(scene, p[c[0]], p[c[2]], p[c[3]], rho);
        }
    }
}

static void block(bench_scene *scene, double x, double y, double z, double dx, double dy, double dz,
                  double rho)
{
    const double low[3] = {x, y, z}, high[3] = {x + dx, y + dy, z + dz};

    box(scene, low, high, 0, 0, 63, rho);
}

static void lamp(bench_scene *scene, double x, double y, double z, double intensity)
{
    lcor_light *light = &scene->lights[scene->light_count++];

    memset(light, 0, sizeof *light);
    light->position[0] = x;
    light->position[1] = y;
    light->position[2] = z;
    for (int c = 0; c < 3; c++)
        light->intensity[c] = intensity;
}

static void shell(bench_scene *scene, double x, double y, double z, double walls)
{
    const double low[3] = {0, 0, 0}, high[3] = {x, y, z};

    box(scene, low, high, 0, 1, 1, 0.3);
    box(scene, low, high, 0, 1, 2, 0.8);
    box(scene, low, high, 0, 1, 60, walls);
}

/* Things stand a millimetre apart, so that no two faces share a place. */
static const double gap = 0.001, thick = 0.02;

static void table(bench_scene *scene, double x, double y, double dx, double dy)
{
    const double leg = 0.05, high = 0.72;

    block(scene, x, y, high, dx, dy, 0.03, 0.45);
    for (int i = 0; i < 4; i++)
        block(scene, x + (i & 1 ? dx - leg : 0), y + (i & 2 ? dy - leg : 0), gap, leg, leg,
              high - 2 * gap, 0.4);
}

static void chair(bench_scene *scene, double x, double y)
{
    const double leg = 0.035, seat = 0.45, side = 0.42;

    block(scene, x, y, seat, side, side, thick, 0.5);
    block(scene, x, y, seat + thick + gap, side, thick, 0.45, 0.5);
    for (int i = 0; i < 4; i++)
        block(scene, x + (i & 1 ? side - leg : 0), y + (i & 2 ? side - leg : 0), gap, leg, leg,
              seat - 2 * gap, 0.35);
}

/* A row of books between x and x + width on a board: of random thickness, height and colour. Every
 * tenth brings a triangle without area, as files do. */
static void books(bench_scene *scene, double x, double y, double z, double width, double height,
                  double depth, size_t count)
{
    const double step = width / (double)count;

    for (size_t i = 0; i < count; i++) {
        const double a = x + (double)i * step,
                     d = step * (0.7 + 0.25 * bench_random(&scene->random));
        const double h = height * (0.6 + 0.35 * bench_random(&scene->random));
        const double in = depth * (0.65 + 0.3 * bench_random(&scene->random));
        const double edge[3] = {a, y, z}, end[3] = {a, y, z + h};

        block(scene, a, y + depth - in, z, d, in - gap, h,
              0.1 + 0.6 * bench_random(&scene->random));
        if (i % 10 == 9)
            triangle(scene, edge, end, end, 0.5);
    }
}

/* Back, sides and boards along the wall y = far, open to the room, with `count` books in it. */
static void shelf(bench_scene *scene, double x, double far, double width, size_t rows, size_t count)
{
    const double depth = 0.3, high = 2.1, y = far - depth - gap;
    const double pitch = (high - thick) / (double)rows;

    block(scene, x, y, gap, thick, depth, high, 0.5);
    block(scene, x + width - thick, y, gap, thick, depth, high, 0.5);
    for (size_t r = 0; r <= rows; r++)
        block(scene, x + thick + gap, y, gap + (double)r * pitch, width - 2 * (thick + gap), depth,
              fmin(thick, 0.2 * pitch), 0.5);
    for (size_t r = 0; r < rows; r++) {
        const size_t here = count * (r + 1) / rows - count * r / rows;

        if (here > 0)
            books(scene, x + thick + 2 * gap, y,
                  2 * gap + (double)r * pitch + fmin(thick, 0.2 * pitch),
                  width - 2 * thick - 4 * gap, pitch - fmin(thick, 0.2 * pitch) - 2 * gap, depth,
                  here);
    }
}

void bench_furnished_room(bench_scene *scene, size_t triangles)
{
    enum { SHELVES = 3, PER_BOX = 12 };
    size_t rows = 3, boxes, fixed;

    start(scene);
    shell(scene, 5, 4, 2.6, 0.6);
    table(scene, 1.4, 1.2, 1.6, 0.9);
    table(scene, 0.1, 3.2, 1, 0.6);
    for (int i = 0; i < 4; i++)
        chair(scene, 1.5 + 0.8 * (i % 2) + 0.2 * (i / 2), i < 2 ? 0.7 : 2.2);
    /* Rows of about forty books; boards are boxes too. */
    boxes = (triangles - scene->count) / PER_BOX;
    while (SHELVES * (rows + 3) + SHELVES * rows * 40 < boxes)
        rows++;
    fixed = SHELVES * (rows + 3);
    boxes = boxes > fixed ? boxes - fixed : 0;
    for (size_t i = 0; i < SHELVES; i++)
        shelf(scene, 1.15 + 1.28 * (double)i, 4 - gap, 1.25, rows,
              boxes * (i + 1) / SHELVES - boxes * i / SHELVES);
    lamp(scene, 2.3, 1.8, 2.2, 100);
    lamp(scene, 0.5, 3.4, 1.2, 25);
}

void bench_hall(bench_scene *scene)
{
    start(scene);
    shell(scene, 20, 10, 5, 0.5);
    for (int i = 0; i < 14; i++) /* columns, then benches between them */
        block(scene, 2.5 + 2.3 * (i % 7), i < 7 ? 2.5 : 7, gap, 0.5, 0.5, 5 - 2 * gap, 0.6);
    for (int i = 0; i < 15; i++)
        block(scene, 3.3 + 2.8 * (i % 5), 3.8 + 0.9 * (i / 5), gap, 1.5, 0.4, 0.45, 0.4);
    for (int i = 0; i < 4; i++)
        lamp(scene, 4 + 4 * i, i % 2 ? 4 : 6, 4.2, 300);
}

void bench_open_box(bench_scene *scene)
{
    const double zero[3] = {0, 0, 0}, one[3] = {1, 1, 1};
    const double low[2][3] = {{0.15, 0.5, gap}, {0.55, 0.2, gap}};
    const double high[2][3] = {{0.45, 0.8, 0.6}, {0.85, 0.5, 0.3}};
    lcor_light *spot;

    start(scene);
    box(scene, zero, one, 0, 1, 63 - 16, 0.7);
    for (int i = 0; i < 2; i++)
        box(scene, low[i], high[i], i ? -0.3 : 0.3, 0, 63, 0.7);
    lamp(scene, 0.5, 0.5, 0.6, 5);
    spot = &scene->lights[0];
    spot->kind = LCOR_LIGHT_SPOT;
    spot->direction[2] = 1;
    spot->inner_cone = 0.3;
    spot->outer_cone = 0.5;
}

int bench_scene_named(bench_scene *scene, const char *name)
{
    if (strcmp(name, "hall") == 0)
        bench_hall(scene);
    else if (strcmp(name, "box") == 0)
        bench_open_box(scene);
    else if (strncmp(name, "room", 4) == 0 && (name[4] == '\0' || atol(name + 4) >= 1000))
        bench_furnished_room(scene, name[4] ? (size_t)atol(name + 4) : 6000);
    else
        return 0;
    return 1;
}

void bench_scene_free(bench_scene *scene)
{
    free(scene->corners);
    free(scene->rho);
    free(scene->area_to);
}

lcor_scene *bench_library_scene(const bench_scene *scene)
{
    lcor_scene *out = NULL;
    lcor_surface look;
    lcor_error err = {LCOR_OK, -1, ""};
    lcor_status status = lcor_scene_new(NULL, &out, &err);

    memset(&look, 0, sizeof look);
    look.two_sided = 1;
    for (size_t i = 0; i < scene->count && status == LCOR_OK; i++) {
        const double *c = scene->corners[i];

        for (int k = 0; k < 3; k++)
            look.reflectance[k] = scene->rho[i];
        status = lcor_scene_add_triangle(out, c, c + 3, c + 6, &look, NULL, &err);
    }
    for (size_t i = 0; i < scene->light_count && status == LCOR_OK; i++)
        status = lcor_scene_add_light(out, &scene->lights[i], NULL, &err);
    if (status == LCOR_OK)
        status = lcor_scene_commit(out, NULL, &err);
    if (status != LCOR_OK)
        fail(err.text);
    return out;
}

size_t bench_random_point(const bench_scene *scene, uint64_t *state, double x[3], double n[3])
{
    const double at = scene->area_to[scene->count - 1] * bench_random(state);
    size_t i = 0, last = scene->count - 1;
    double a, b, u[3], v[3];

    while (i < last) {
        const size_t middle = i + (last - i) / 2;

        if (scene->area_to[middle] > at)
            last = middle;
        else
            i = middle + 1;
    }
    (void)bench_triangle(scene->corners[i], u, v, n);
    a = bench_random(state);
    b = bench_random(state);
    if (a + b > 1) {
        a = 1 - a;
        b = 1 - b;
    }
    for (int k = 0; k < 3; k++)
        x[k] = scene->corners[i][k] + a * u[k] + b * v[k];
    return i;
}
