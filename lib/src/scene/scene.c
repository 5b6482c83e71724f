/* SPDX-License-Identifier: MIT */
/* Building a scene and asking it. */
#include "base/internal.h"
#include "geometry/vec.h"
#include "scene/scene_internal.h"

#include <string.h>

lcor_status lcor_scene_new(const lcor_allocator *allocator, lcor_scene **out, lcor_error *err)
{
    lcor_allocator own;
    lcor_scene *scene;
    lcor_status status;

    if (!out)
        return lcor_internal_fail(err, LCOR_ERR_ARG, -1, "lcor_scene_new: out is NULL");
    status = lcor_internal_allocator(allocator, &own, err);
    if (status != LCOR_OK)
        return status;
    scene = lcor_internal_alloc(&own, sizeof *scene);
    if (!scene)
        return lcor_internal_fail(err, LCOR_ERR_NOMEM, -1, "no memory for a scene");
    memset(scene, 0, sizeof *scene);
    scene->allocator = own;
    *out = scene;
    return LCOR_OK;
}

void lcor_scene_free(lcor_scene *scene)
{
    if (!scene)
        return;
    lcor_bvh_free(scene->bvh);
    lcor_array_clear(&scene->allocator, &scene->surfaces);
    lcor_array_clear(&scene->allocator, &scene->lights);
    lcor_array_clear(&scene->allocator, &scene->corners);
    lcor_array_clear(&scene->allocator, &scene->sheets);
    lcor_array_clear(&scene->allocator, &scene->sheet_members);
    lcor_array_clear(&scene->allocator, &scene->shapes);
    lcor_array_clear(&scene->allocator, &scene->solids);
    lcor_array_clear(&scene->allocator, &scene->members);
    lcor_array_clear(&scene->allocator, &scene->planes);
    lcor_array_clear(&scene->allocator, &scene->edges);
    lcor_array_clear(&scene->allocator, &scene->blockers);
    lcor_internal_free(&scene->allocator, scene);
}

/* Corners are kept as given; shapes are judged by commit. */
static lcor_status add_surface(lcor_scene *scene, scene_shape shape, size_t n,
                               const double *corners, const lcor_surface *look, size_t *id,
                               lcor_error *err)
{
    scene_surface *surface;
    double *kept;

    if (!scene || !corners)
        return lcor_internal_fail(err, LCOR_ERR_ARG, -1, "surface: scene or corners are NULL");
    if (scene->committed)
        return lcor_internal_fail(err, LCOR_ERR_ARG, -1,
                                  "surface: the scene is committed, its shapes are fixed");
    if (n < 3)
        return lcor_internal_fail(err, LCOR_ERR_ARG, -1, "polygon: needs at least 3 corners");
    kept = lcor_array_reserve(&scene->allocator, &scene->corners, n, 3 * sizeof *kept);
    surface = lcor_array_reserve(&scene->allocator, &scene->surfaces, 1, sizeof *surface);
    if (!kept || !surface)
        return lcor_internal_fail(err, LCOR_ERR_NOMEM, -1, "no memory for a surface");
    memcpy(kept, corners, n * 3 * sizeof *kept);
    memset(surface, 0, sizeof *surface);
    surface->shape = shape;
    surface->first_corner = scene->corners.count;
    surface->corner_count = n;
    if (look)
        surface->look = *look;
    scene->corners.count += n;
    if (id)
        *id = scene->surfaces.count;
    scene->surfaces.count++;
    return LCOR_OK;
}

lcor_status lcor_scene_add_quad(lcor_scene *scene, const double origin[3], const double edge_u[3],
                                const double edge_v[3], const lcor_surface *surface, size_t *id,
                                lcor_error *err)
{
    double corners[12];

    if (!origin || !edge_u || !edge_v)
        return lcor_internal_fail(err, LCOR_ERR_ARG, -1, "quad: origin or an edge is NULL");
    for (int k = 0; k < 3; k++) {
        corners[k] = origin[k];
        corners[3 + k] = origin[k] + edge_u[k];
        corners[6 + k] = origin[k] + edge_u[k] + edge_v[k];
        corners[9 + k] = origin[k] + edge_v[k];
    }
    return add_surface(scene, SCENE_QUAD, 4, corners, surface, id, err);
}

lcor_status lcor_scene_add_triangle(lcor_scene *scene, const double a[3], const double b[3],
                                    const double c[3], const lcor_surface *surface, size_t *id,
                                    lcor_error *err)
{
    double corners[9];

    if (!a || !b || !c)
        return lcor_internal_fail(err, LCOR_ERR_ARG, -1, "triangle: a corner is NULL");
    vec_copy(a, corners);
    vec_copy(b, corners + 3);
    vec_copy(c, corners + 6);
    return add_surface(scene, SCENE_TRIANGLE, 3, corners, surface, id, err);
}

lcor_status lcor_scene_add_polygon(lcor_scene *scene, size_t n, const double *corners,
                                   const lcor_surface *surface, size_t *id, lcor_error *err)
{
    return add_surface(scene, SCENE_POLYGON, n, corners, surface, id, err);
}

lcor_status lcor_scene_add_light(lcor_scene *scene, const lcor_light *light, size_t *id,
                                 lcor_error *err)
{
    lcor_light *kept;

    if (!scene || !light)
        return lcor_internal_fail(err, LCOR_ERR_ARG, -1, "light: scene or light is NULL");
    if (scene->committed)
        return lcor_internal_fail(err, LCOR_ERR_ARG, -1,
                                  "light: the scene is committed; change one with set_light");
    kept = lcor_array_reserve(&scene->allocator, &scene->lights, 1, sizeof *kept);
    if (!kept)
        return lcor_internal_fail(err, LCOR_ERR_NOMEM, -1, "no memory for a light");
    *kept = *light;
    if (id)
        *id = scene->lights.count;
    scene->lights.count++;
    return LCOR_OK;
}

lcor_status lcor_scene_set_surface(lcor_scene *scene, size_t id, const lcor_surface *surface,
                                   lcor_error *err)
{
    static const lcor_surface none;
    const lcor_surface *look = surface ? surface : &none;

    if (!scene || id >= scene->surfaces.count)
        return lcor_internal_fail(err, LCOR_ERR_ARG, (long)id, "surface %lu: there is none",
                                  (unsigned long)id);
    if (scene->committed) {
        const lcor_status status = lcor_scene_check_look(look, id, err);

        if (status != LCOR_OK)
            return status;
    }
    ((scene_surface *)scene->surfaces.items)[id].look = *look;
    return LCOR_OK;
}

lcor_status lcor_scene_set_light(lcor_scene *scene, size_t id, const lcor_light *light,
                                 lcor_error *err)
{
    lcor_light *kept;

    if (!scene || !light || id >= scene->lights.count)
        return lcor_internal_fail(err, LCOR_ERR_ARG, (long)id, "light %lu: there is none",
                                  (unsigned long)id);
    kept = (lcor_light *)scene->lights.items + id;
    if (scene->committed) {
        const lcor_status status = lcor_scene_check_light(light, id, err);

        if (status != LCOR_OK)
            return status;
    }
    *kept = *light;
    if (scene->committed)
        (void)vec_normalize(kept->direction);
    return LCOR_OK;
}

size_t lcor_scene_surface_count(const lcor_scene *scene) { return scene->surfaces.count; }

size_t lcor_scene_light_count(const lcor_scene *scene) { return scene->lights.count; }

int lcor_scene_inside(const lcor_scene *scene, const double point[3])
{
    for (size_t i = 0; i < scene->surfaces.count; i++) {
        const scene_surface *s = scene_surface_at(scene, i);
        double d[3];

        vec_sub(point, s->origin, d);
        if (vec_dot(d, s->normal) < -SCENE_TOUCH * scene->diameter)
            return 0;
    }
    return 1;
}

uint32_t lcor_scene_surface_of(const lcor_scene *scene, const double normal[3], double point[3])
{
    const double reach = SCENE_REACH * scene->diameter;
    const scene_surface *surface;
    lcor_bvh_hit hit;
    lcor_ray ray;
    double d[3];

    vec_add_scaled(point, reach, normal, ray.origin);
    for (int k = 0; k < 3; k++)
        ray.direction[k] = -normal[k];
    ray.t_min = 0;
    ray.t_max = 2 * reach;
    ray.skip = LCOR_BVH_NONE;
    if (!lcor_bvh_closest(scene->bvh, &ray, &hit))
        return LCOR_BVH_NONE;
    surface = scene_surface_at(scene, hit.owner);
    if (fabs(vec_dot(normal, surface->normal)) < 1 - 1e-6)
        return LCOR_BVH_NONE;
    vec_sub(surface->origin, point, d);
    vec_add_scaled(point, vec_dot(d, surface->normal), surface->normal, point);
    return hit.owner;
}

int lcor_scene_blocked(const lcor_scene *scene, const double from[3], const double to[3],
                       uint32_t skip, uint32_t *cache)
{
    lcor_ray ray;
    double length;

    vec_copy(from, ray.origin);
    vec_sub(to, from, ray.direction);
    length = vec_length(ray.direction);
    if (!(length > 0))
        return 0;
    ray.t_min = SCENE_TOUCH * scene->diameter / length;
    ray.t_max = 1 - ray.t_min;
    ray.skip = skip;
    return lcor_bvh_occluded(scene->bvh, &ray, cache);
}

int lcor_scene_blocked_towards(const lcor_scene *scene, const double from[3],
                               const double direction[3], uint32_t skip, uint32_t *cache)
{
    lcor_ray ray;

    vec_copy(from, ray.origin);
    vec_copy(direction, ray.direction);
    ray.t_min = SCENE_TOUCH * scene->diameter / vec_length(direction);
    ray.t_max = (double)INFINITY;
    ray.skip = skip;
    return lcor_bvh_occluded(scene->bvh, &ray, cache);
}

int lcor_scene_intersect(const lcor_scene *scene, const double origin[3], const double direction[3],
                         double t_max, lcor_hit *hit)
{
    const scene_surface *surface;
    lcor_bvh_hit found;
    lcor_ray ray;

    vec_copy(origin, ray.origin);
    vec_copy(direction, ray.direction);
    ray.t_min = 0;
    ray.t_max = t_max;
    ray.skip = LCOR_BVH_NONE;
    if (!scene->committed || !(vec_dot(direction, direction) > 0) ||
        !lcor_bvh_closest(scene->bvh, &ray, &found))
        return 0;
    surface = scene_surface_at(scene, found.owner);
    hit->surface = found.owner;
    hit->t = found.t;
    hit->u = found.u;
    hit->v = found.v;
    hit->front = vec_dot(direction, surface->normal) < 0;
    if (surface->shape == SCENE_POLYGON) {
        double point[3];

        vec_add_scaled(origin, found.t, direction, point);
        lcor_scene_coordinates(surface, point, &hit->u, &hit->v);
    }
    return 1;
}
