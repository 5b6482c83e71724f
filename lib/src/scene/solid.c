/* SPDX-License-Identifier: MIT */
/* Solids: shapes that share edges and enclose a convex body. A straight way past it crosses two
 * of its sides or none, so one side may be missing, as under a box on a floor, and the body still
 * hides all that its hull covers. One outline is cheaper to clip against than every side. */
#include "base/internal.h"
#include "geometry/vec.h"
#include "scene/scene_internal.h"

#include <string.h>

/* Every pair of shapes is looked at. */
static const size_t shapes_max = 600;

typedef struct search {
    lcor_scene *scene;
    double touch;
    const uint32_t *member; /* of the group that is judged */
    size_t count;
} search;

static uint32_t shape_id(const lcor_scene *scene, size_t i)
{
    return ((const uint32_t *)scene->shapes.items)[i];
}

static int same(const search *s, const double a[3], const double b[3])
{
    double d[3];

    vec_sub(a, b, d);
    return vec_dot(d, d) <= s->touch * s->touch;
}

/* Whether surface b has an edge with ends p and q. */
static int has_edge(const search *s, const scene_surface *b, const double p[3], const double q[3])
{
    const double *c = scene_corners(s->scene, b);

    for (size_t i = 0; i < b->corner_count; i++) {
        const double *d = c + 3 * i, *e = c + 3 * ((i + 1) % b->corner_count);

        if ((same(s, p, d) && same(s, q, e)) || (same(s, p, e) && same(s, q, d)))
            return 1;
    }
    return 0;
}

static int share_edge(const search *s, const scene_surface *a, const scene_surface *b)
{
    const double *p = scene_corners(s->scene, a);

    for (size_t i = 0; i < a->corner_count; i++)
        if (has_edge(s, b, p + 3 * i, p + 3 * ((i + 1) % a->corner_count)))
            return 1;
    return 0;
}

/* How far the surface's corners reach before the plane (sign 1) or behind it (-1). */
static double reach(const search *s, const scene_surface *a, const scene_plane *plane, double sign)
{
    const double *p = scene_corners(s->scene, a);
    double most = -HUGE_VAL;

    for (size_t i = 0; i < a->corner_count; i++) {
        double d[3];

        vec_sub(p + 3 * i, plane->point, d);
        most = fmax(most, sign * vec_dot(d, plane->normal));
    }
    return most;
}

static double group_reach(const search *s, const scene_plane *plane, double sign)
{
    double most = -HUGE_VAL;

    for (size_t i = 0; i < s->count; i++)
        most = fmax(most, reach(s, scene_shape_at(s->scene, s->member[i]), plane, sign));
    return most;
}

/* All edges of the members, each once, into the scene's; side[1] is the number of members where no
 * other member has the edge. Returns how many there are, -1 without memory. */
static long list_edges(const search *s)
{
    lcor_scene *scene = s->scene;
    scene_edge *edge;
    size_t most = 0;
    long count = 0;

    for (size_t i = 0; i < s->count; i++)
        most += scene_shape_at(scene, s->member[i])->corner_count;
    edge = lcor_array_reserve(&scene->allocator, &scene->edges, most, sizeof *edge);
    if (!edge)
        return -1;
    for (size_t i = 0; i < s->count; i++) {
        const scene_surface *a = scene_shape_at(scene, s->member[i]);
        const double *p = scene_corners(scene, a);

        for (size_t k = 0; k < a->corner_count; k++) {
            const double *q = p + 3 * k, *r = p + 3 * ((k + 1) % a->corner_count);
            size_t other = 0;

            while (other < s->count &&
                   (other == i || !has_edge(s, scene_shape_at(scene, s->member[other]), q, r)))
                other++;
            if (other < i)
                continue; /* listed already */
            vec_copy(q, edge[count].p);
            vec_copy(r, edge[count].q);
            edge[count].side[0] = i;
            edge[count++].side[1] = other;
        }
    }
    return count;
}

/* The plane of the edges that one member alone has. 1: *plane is it, or with *open 0 there are
 * none; 0: they lie in no plane. */
static int missing_side(const search *s, const scene_edge *edges, long count, scene_plane *plane,
                        int *open)
{
    const scene_edge *first = NULL;

    *open = 0;
    for (long i = 0; i < count; i++) {
        double d[3], e[3];

        if (edges[i].side[1] < s->count)
            continue;
        if (!first) {
            first = &edges[i];
            continue;
        }
        vec_sub(first->q, first->p, d);
        for (int end = 0; end < 2 && !*open; end++) {
            vec_sub(end ? edges[i].q : edges[i].p, first->p, e);
            vec_cross(d, e, plane->normal);
            *open = vec_length(plane->normal) > s->touch * vec_length(d);
        }
    }
    if (!*open)
        return first == NULL;
    (void)vec_normalize(plane->normal);
    vec_copy(first->p, plane->point);
    if (group_reach(s, plane, 1) > s->touch)
        for (int k = 0; k < 3; k++)
            plane->normal[k] = -plane->normal[k];
    for (long i = 0; i < count; i++) {
        double d[3], e[3];

        vec_sub(edges[i].p, plane->point, d);
        vec_sub(edges[i].q, plane->point, e);
        if (edges[i].side[1] == s->count && (fabs(vec_dot(d, plane->normal)) > s->touch ||
                                             fabs(vec_dot(e, plane->normal)) > s->touch))
            return 0;
    }
    return 1;
}

static scene_plane plane_of(const scene_surface *surface)
{
    scene_plane plane;

    vec_copy(surface->origin, plane.point);
    vec_copy(surface->normal, plane.normal);
    return plane;
}

/* Whether a shape lies outside one of the planes. */
static int is_outside(const search *s, uint32_t shape, const scene_plane *planes, size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (reach(s, scene_shape_at(s->scene, shape), &planes[i], -1) <= s->touch)
            return 1;
    return 0;
}

/* Whether the group is a solid with nothing inside; appends its planes. -1 without memory. */
static int judge(const search *s, const unsigned char *in_group)
{
    lcor_scene *scene = s->scene;
    scene_plane *planes =
        lcor_array_reserve(&scene->allocator, &scene->planes, s->count + 1, sizeof *planes);
    const long edges = list_edges(s);
    double depth = 0;
    size_t count = 0;
    int open;

    if (!planes || edges < 0)
        return -1;
    for (size_t i = 0; i < s->count; i++) {
        const scene_plane plane = plane_of(scene_shape_at(scene, s->member[i]));

        if (group_reach(s, &plane, 1) > s->touch)
            return 0;
        depth = fmax(depth, group_reach(s, &plane, -1));
        planes[count++] = plane;
    }
    if (depth <= s->touch ||
        !missing_side(s, (const scene_edge *)scene->edges.items + scene->edges.count, edges,
                      &planes[count], &open))
        return 0;
    count += (size_t)open;
    if (open && (group_reach(s, &planes[count - 1], 1) > s->touch ||
                 group_reach(s, &planes[count - 1], -1) <= s->touch))
        return 0;
    for (size_t j = 0; j < scene->shapes.count; j++)
        if (!in_group[j] && !is_outside(s, shape_id(scene, j), planes, count))
            return 0;
    scene->planes.count += count;
    scene->edges.count += (size_t)edges;
    return 1;
}

/* Fills the members with all shapes that hang together with the `seed`th by edges. */
static int gather(search *s, uint32_t *members, size_t seed, unsigned char *in_group)
{
    const lcor_scene *scene = s->scene;

    s->member = members;
    s->count = 1;
    members[0] = shape_id(scene, seed);
    in_group[seed] = 1;
    for (size_t i = 0; i < s->count; i++)
        for (size_t j = 0; j < scene->shapes.count; j++)
            if (!in_group[j] && share_edge(s, scene_shape_at(scene, members[i]),
                                           scene_shape_at(scene, shape_id(scene, j)))) {
                members[s->count++] = shape_id(scene, j);
                in_group[j] = 1;
            }
    return s->count > 3 && s->count < SCENE_SOLID_SIDES;
}

/* The mean of the edges' ends. */
static void set_middle(const lcor_scene *scene, scene_solid *solid)
{
    const scene_edge *edges = (const scene_edge *)scene->edges.items + solid->first_edge;
    const double share = 0.5 / (double)solid->edge_count;

    for (size_t i = 0; i < solid->edge_count; i++) {
        vec_add_scaled(solid->middle, share, edges[i].p, solid->middle);
        vec_add_scaled(solid->middle, share, edges[i].q, solid->middle);
    }
}

/* One flag a shape: seen before, in the group at hand, in a solid. */
static int find(search *s, unsigned char *seen, unsigned char *in_group, unsigned char *in_solid,
                uint32_t *group)
{
    lcor_scene *scene = s->scene;
    const size_t n = scene->shapes.count;

    for (size_t i = 0; i < n; i++) {
        const size_t first_plane = scene->planes.count, first_edge = scene->edges.count;
        scene_solid *solid;
        uint32_t *members;
        int good;

        if (seen[i])
            continue;
        memset(in_group, 0, n);
        good = gather(s, group, i, in_group);
        for (size_t j = 0; j < n; j++)
            seen[j] |= in_group[j];
        good = good ? judge(s, in_group) : 0;
        if (good < 0)
            return 0;
        if (!good)
            continue;
        solid = lcor_array_reserve(&scene->allocator, &scene->solids, 1, sizeof *solid);
        members = lcor_array_reserve(&scene->allocator, &scene->members, s->count, sizeof *members);
        if (!solid || !members)
            return 0;
        memcpy(members, group, s->count * sizeof *members);
        for (size_t j = 0; j < n; j++)
            in_solid[j] |= in_group[j];
        *solid = (scene_solid){scene->members.count,
                               s->count,
                               first_plane,
                               scene->planes.count - first_plane,
                               first_edge,
                               scene->edges.count - first_edge,
                               {0, 0, 0}};
        set_middle(scene, solid);
        scene->members.count += s->count;
        scene->solids.count++;
    }
    return 1;
}

static int list_blockers(lcor_scene *scene, const unsigned char *in_solid)
{
    const size_t n = scene->shapes.count, solids = scene->solids.count;
    const size_t first_solid = scene->surfaces.count + scene->sheets.count;
    uint32_t *out =
        lcor_array_reserve(&scene->allocator, &scene->blockers, n + solids, sizeof *out);

    if (!out)
        return 0;
    for (size_t i = 0; i < n; i++)
        if (!in_solid[i])
            out[scene->blockers.count++] = shape_id(scene, i);
    for (size_t i = 0; i < solids; i++)
        out[scene->blockers.count++] = (uint32_t)(first_solid + i);
    return 1;
}

int lcor_scene_find_solids(lcor_scene *scene)
{
    const size_t n = scene->shapes.count;
    search s = {scene, SCENE_TOUCH * scene->diameter, NULL, 0};
    unsigned char *flags = lcor_internal_alloc(&scene->allocator, 3 * n);
    uint32_t *group = lcor_internal_alloc(&scene->allocator, n * sizeof *group);
    int good = flags && group;

    scene->solids.count = scene->members.count = 0;
    scene->planes.count = scene->edges.count = scene->blockers.count = 0;
    if (good)
        memset(flags, 0, 3 * n);
    if (good && !scene->convex && n <= shapes_max)
        good = find(&s, flags, flags + n, flags + 2 * n, group);
    good = good && list_blockers(scene, flags + 2 * n);
    lcor_internal_free(&scene->allocator, flags);
    lcor_internal_free(&scene->allocator, group);
    return good;
}

int lcor_scene_in_solid(const lcor_scene *scene, const double point[3])
{
    const scene_plane *planes = scene->planes.items;

    for (size_t i = 0; i < scene->solids.count; i++) {
        const scene_solid *solid = (const scene_solid *)scene->solids.items + i;
        int inside = 1;

        for (size_t k = 0; k < solid->plane_count && inside; k++) {
            double d[3];

            vec_sub(point, planes[solid->first_plane + k].point, d);
            inside = vec_dot(d, planes[solid->first_plane + k].normal) < 0;
        }
        if (inside)
            return 1;
    }
    return 0;
}
