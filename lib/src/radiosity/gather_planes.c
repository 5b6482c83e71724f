/* SPDX-License-Identifier: MIT */
/* Coplanar surfaces that share a corner become one plane with two sides. */
#include "radiosity/gather.h"

#include "base/internal.h"
#include "geometry/vec.h"

#include <stdlib.h>
#include <string.h>

/* Corners within this part of the scene's diameter are one; planes may differ by a little more. */
static const double same_corner = 2e-6, same_plane = 1e-5, same_normal = 1e-7;

typedef struct corner_key {
    int64_t cell[3];
    uint32_t surface;
} corner_key;

static int compare_corners(const void *a, const void *b)
{
    const corner_key *p = a, *q = b;

    for (int k = 0; k < 3; k++)
        if (p->cell[k] != q->cell[k])
            return p->cell[k] < q->cell[k] ? -1 : 1;
    return p->surface < q->surface ? -1 : p->surface > q->surface;
}

static int same_cell(const corner_key *a, const corner_key *b)
{
    return a->cell[0] == b->cell[0] && a->cell[1] == b->cell[1] && a->cell[2] == b->cell[2];
}

/* Union-find over plane_of: the representative of a surface's plane. */
static uint32_t find(uint32_t *parent, uint32_t i)
{
    while (parent[i] != i) {
        parent[i] = parent[parent[i]];
        i = parent[i];
    }
    return i;
}

static int coplanar(const lcor_scene *scene, const scene_surface *a, const scene_surface *b)
{
    const double *p = scene_corners(scene, b);

    if (fabs(vec_dot(a->normal, b->normal)) < 1 - same_normal)
        return 0;
    for (size_t i = 0; i < b->corner_count; i++) {
        double d[3];

        vec_sub(p + 3 * i, a->origin, d);
        if (fabs(vec_dot(d, a->normal)) > same_plane * scene->diameter)
            return 0;
    }
    return 1;
}

/* Joins coplanar surfaces among those with a corner in one cell. */
static void join_cell(const gather *g, const corner_key *keys, size_t count)
{
    for (size_t i = 0; i < count; i++)
        for (size_t j = i + 1; j < count; j++) {
            const uint32_t a = keys[i].surface, b = keys[j].surface;

            if (find(g->plane_of, a) != find(g->plane_of, b) &&
                coplanar(g->scene, scene_surface_at(g->scene, a), scene_surface_at(g->scene, b)))
                g->plane_of[find(g->plane_of, a)] = find(g->plane_of, b);
        }
}

static int join(gather *g)
{
    const lcor_scene *scene = g->scene;
    const double cell = same_corner * scene->diameter;
    const double *low = scene->corners.items;
    corner_key *keys = lcor_internal_alloc(g->allocator, scene->corners.count * sizeof *keys);
    size_t count = 0;

    if (!keys)
        return 0;
    for (size_t s = 0; s < scene->surfaces.count; s++) {
        const scene_surface *f = scene_surface_at(scene, s);
        const double *p = scene_corners(scene, f);

        g->plane_of[s] = (uint32_t)s;
        for (size_t i = 0; i < f->corner_count; i++, count++) {
            for (size_t k = 0; k < 3; k++)
                keys[count].cell[k] = (int64_t)floor((p[3 * i + k] - low[k]) / cell + 0.5);
            keys[count].surface = (uint32_t)s;
        }
    }
    qsort(keys, count, sizeof *keys, compare_corners);
    for (size_t i = 0, end; i < count; i = end) {
        for (end = i + 1; end < count && same_cell(&keys[i], &keys[end]);)
            end++;
        join_cell(g, keys + i, end - i);
    }
    lcor_internal_free(g->allocator, keys);
    return 1;
}

/* Coordinates along the longest edge of the plane's largest surface, so that rooms get leaves
 * parallel to their walls. */
static void set_frame(const gather *g, gather_plane *p)
{
    const uint32_t *members = (const uint32_t *)g->members.items + p->first;
    const scene_surface *largest = scene_surface_at(g->scene, members[0]);
    double longest = 0;

    for (size_t i = 1; i < p->count; i++)
        if (scene_surface_at(g->scene, members[i])->area > largest->area)
            largest = scene_surface_at(g->scene, members[i]);
    vec_copy(largest->origin, p->origin);
    vec_copy(largest->normal, p->normal);
    for (size_t i = 0; i < largest->corner_count; i++) {
        const double *corner = scene_corners(g->scene, largest);
        double before[3], edge[3], square, score;
        const size_t n = largest->corner_count;

        vec_sub(corner + 3 * ((i + 1) % n), corner + 3 * i, edge);
        vec_sub(corner + 3 * i, corner + 3 * ((i + n - 1) % n), before);
        square = vec_dot(edge, edge);
        /* The legs of a right-angled triangle rather than its long side. */
        score = square *
                (fabs(vec_dot(edge, before)) < 1e-3 * vec_length(before) * sqrt(square) ? 4 : 1);
        if (score > longest * 1.0001) {
            longest = score;
            vec_copy(edge, p->u);
        }
    }
    vec_add_scaled(p->u, -vec_dot(p->u, p->normal), p->normal, p->u);
    (void)vec_normalize(p->u);
    vec_cross(p->normal, p->u, p->v);
}

/* Numbers the planes in the order of their first surfaces. */
static int number_planes(gather *g)
{
    const size_t n = g->scene->surfaces.count;
    uint32_t *number = lcor_internal_alloc(g->allocator, n * sizeof *number);
    uint32_t *members = lcor_array_reserve(g->allocator, &g->members, n, sizeof *members);
    gather_plane *planes;
    size_t count = 0, at = 0;

    if (!number || !members) {
        lcor_internal_free(g->allocator, number);
        return 0;
    }
    for (size_t s = 0; s < n; s++)
        g->plane_of[s] = find(g->plane_of, (uint32_t)s);
    for (size_t s = 0; s < n; s++)
        number[s] = gather_none;
    for (size_t s = 0; s < n; s++)
        if (number[g->plane_of[s]] == gather_none)
            number[g->plane_of[s]] = (uint32_t)count++;
    for (size_t s = 0; s < n; s++)
        g->plane_of[s] = number[g->plane_of[s]];
    lcor_internal_free(g->allocator, number);
    planes = lcor_array_reserve(g->allocator, &g->planes, count, sizeof *planes);
    if (!planes)
        return 0;
    g->planes.count = count;
    g->members.count = n;
    memset(planes, 0, count * sizeof *planes);
    for (size_t s = 0; s < n; s++)
        planes[g->plane_of[s]].count++;
    for (size_t i = 0; i < count; i++) {
        planes[i].first = at;
        at += planes[i].count;
        planes[i].count = 0;
    }
    for (size_t s = 0; s < n; s++) {
        gather_plane *p = &planes[g->plane_of[s]];

        members[p->first + p->count++] = (uint32_t)s;
    }
    return 1;
}

static int make_sides(gather *g)
{
    g->sides = lcor_internal_alloc(g->allocator, 2 * g->planes.count * sizeof *g->sides);
    if (!g->sides)
        return 0;
    for (size_t i = 0; i < 2 * g->planes.count; i++)
        g->sides[i] = (gather_side){-1, 0, 0};
    for (size_t s = 0; s < g->scene->surfaces.count; s++) {
        const scene_surface *f = scene_surface_at(g->scene, s);
        const gather_plane *p = gather_plane_at(g, g->plane_of[s]);

        g->facing[s] = vec_dot(f->normal, p->normal) > 0 ? 1 : -1;
        g->sides[gather_side_of(g, (uint32_t)s, 0)].reflects += f->area;
        if (f->look.two_sided)
            g->sides[gather_side_of(g, (uint32_t)s, 1)].reflects += f->area;
    }
    return 1;
}

int gather_find_planes(gather *g)
{
    const size_t n = g->scene->surfaces.count;

    g->plane_of = lcor_internal_alloc(g->allocator, n * sizeof *g->plane_of);
    g->facing = lcor_internal_alloc(g->allocator, n * sizeof *g->facing);
    if (!g->plane_of || !g->facing || !join(g) || !number_planes(g))
        return 0;
    for (size_t i = 0; i < g->planes.count; i++)
        set_frame(g, gather_plane_at(g, i));
    return make_sides(g);
}

uint32_t gather_side_of(const gather *g, uint32_t surface, int back)
{
    const int towards = (g->facing[surface] > 0) != (back != 0);

    return 2 * g->plane_of[surface] + (towards ? 0 : 1);
}

void gather_to_plane(const gather_plane *p, const double x[3], double at[2])
{
    double d[3];

    vec_sub(x, p->origin, d);
    at[0] = vec_dot(d, p->u);
    at[1] = vec_dot(d, p->v);
}

void gather_stand_on(const gather *g, uint32_t surface, int back, gather_stand *stand)
{
    const scene_surface *f = scene_surface_at(g->scene, surface);

    for (int k = 0; k < 3; k++)
        stand->normal[k] = back ? -f->normal[k] : f->normal[k];
    vec_copy(gather_plane_at(g, g->plane_of[surface])->u, stand->u);
    vec_cross(stand->normal, stand->u, stand->v);
    stand->surface = surface;
}
