/* SPDX-License-Identifier: MIT */
/* Commit: judges every item, then builds what the engines need. */
#include "base/internal.h"
#include "geometry/factor.h"
#include "geometry/vec.h"
#include "scene/scene_internal.h"

#include <math.h>

static const double half_pi = 1.57079632679489661923;

/* Corners may leave the plane by this part of the polygon's size. */
static const double planar_slack = 1e-6;

/* Twice the area over the longest edge squared, below which a shape counts as without area. */
static const double flat_limit = 1e-12;

static int all_finite(const double *x, size_t n)
{
    for (size_t i = 0; i < n; i++)
        if (!isfinite(x[i]))
            return 0;
    return 1;
}

lcor_status lcor_scene_check_look(const lcor_surface *look, size_t id, lcor_error *err)
{
    const long where = (long)id;
    const unsigned long n = (unsigned long)id;

    for (int c = 0; c < 3; c++) {
        if (!(look->reflectance[c] >= 0 && look->reflectance[c] < 1))
            return lcor_internal_fail(err, LCOR_ERR_DOMAIN, where,
                                      "surface %lu: reflectance must be 0 <= rho < 1", n);
        if (!(look->emission[c] >= 0 && isfinite(look->emission[c])))
            return lcor_internal_fail(err, LCOR_ERR_DOMAIN, where,
                                      "surface %lu: emission must be finite and >= 0", n);
    }
    if (look->patches[0] > 100000 || look->patches[1] > 100000)
        return lcor_internal_fail(err, LCOR_ERR_DOMAIN, where,
                                  "surface %lu: more than 100000 patches along an edge", n);
    return LCOR_OK;
}

lcor_status lcor_scene_check_light(const lcor_light *light, size_t id, lcor_error *err)
{
    const long where = (long)id;
    const unsigned long n = (unsigned long)id;

    switch (light->kind) {
    case LCOR_LIGHT_POINT:
    case LCOR_LIGHT_SPOT:
        if (!all_finite(light->position, 3))
            return lcor_internal_fail(err, LCOR_ERR_DOMAIN, where,
                                      "light %lu: position is not finite", n);
        if (!(light->range >= 0) || !isfinite(light->range))
            return lcor_internal_fail(err, LCOR_ERR_DOMAIN, where,
                                      "light %lu: range must be finite and >= 0", n);
        break;
    case LCOR_LIGHT_DIRECTIONAL: break;
    default: return lcor_internal_fail(err, LCOR_ERR_DOMAIN, where, "light %lu: unknown kind", n);
    }
    if (light->kind != LCOR_LIGHT_POINT &&
        (!all_finite(light->direction, 3) || !(vec_dot(light->direction, light->direction) > 0)))
        return lcor_internal_fail(err, LCOR_ERR_DOMAIN, where,
                                  "light %lu: direction must be finite and not zero", n);
    if (light->kind == LCOR_LIGHT_SPOT &&
        !(light->inner_cone >= 0 && light->inner_cone < light->outer_cone &&
          light->outer_cone <= half_pi))
        return lcor_internal_fail(err, LCOR_ERR_DOMAIN, where,
                                  "light %lu: cones must be 0 <= inner < outer <= pi/2", n);
    for (int c = 0; c < 3; c++)
        if (!(light->intensity[c] >= 0 && isfinite(light->intensity[c])))
            return lcor_internal_fail(err, LCOR_ERR_DOMAIN, where,
                                      "light %lu: intensity must be finite and >= 0", n);
    return LCOR_OK;
}

/* Newell's sum around corner 0: twice the area along the normal. */
static double polygon_normal(const double *p, size_t n, double normal[3])
{
    double longest2 = 0, length;

    normal[0] = normal[1] = normal[2] = 0;
    for (size_t i = 1; i + 1 < n; i++) {
        double a[3], b[3], c[3];

        vec_sub(p + 3 * i, p, a);
        vec_sub(p + 3 * (i + 1), p, b);
        vec_cross(a, b, c);
        vec_add_scaled(normal, 1, c, normal);
        longest2 = fmax(longest2, fmax(vec_dot(a, a), vec_dot(b, b)));
    }
    length = vec_normalize(normal);
    return length > flat_limit * longest2 ? length / 2 : 0;
}

static lcor_status check_shape(lcor_scene *scene, size_t id, lcor_error *err)
{
    scene_surface *s = (scene_surface *)scene->surfaces.items + id;
    const double *p = scene_corners(scene, s);
    const size_t n = s->corner_count;
    const unsigned long number = (unsigned long)id;
    double size = 0, cross[3];

    if (!all_finite(p, 3 * n))
        return lcor_internal_fail(err, LCOR_ERR_DOMAIN, (long)id,
                                  "surface %lu: a corner is not finite", number);
    if (n >= LCOR_CLIP_MAX)
        return lcor_internal_fail(err, LCOR_ERR_DOMAIN, (long)id,
                                  "surface %lu: more than %d corners; cut the polygon", number,
                                  LCOR_CLIP_MAX - 1);
    s->area = polygon_normal(p, n, s->normal);
    if (!(s->area > 0) || !isfinite(s->area))
        return lcor_internal_fail(err, LCOR_ERR_DOMAIN, (long)id, "surface %lu: has no area",
                                  number);
    for (size_t i = 0; i < n; i++) {
        double d[3];

        vec_sub(p + 3 * i, p, d);
        size = fmax(size, vec_length(d));
    }
    for (size_t i = 0; i < n; i++) {
        double d[3], a[3], b[3], c[3];

        vec_sub(p + 3 * i, p, d);
        if (fabs(vec_dot(d, s->normal)) > planar_slack * size)
            return lcor_internal_fail(err, LCOR_ERR_DOMAIN, (long)id,
                                      "surface %lu: corner %lu is not in the plane of the others",
                                      number, (unsigned long)i);
        vec_sub(p + 3 * ((i + 1) % n), p + 3 * i, a);
        vec_sub(p + 3 * ((i + 2) % n), p + 3 * ((i + 1) % n), b);
        vec_cross(a, b, c);
        if (vec_dot(c, s->normal) < -planar_slack * size * size)
            return lcor_internal_fail(err, LCOR_ERR_DOMAIN, (long)id,
                                      "surface %lu: not convex at corner %lu", number,
                                      (unsigned long)((i + 1) % n));
    }
    vec_copy(p, s->origin);
    vec_sub(p + 3, p, s->edge_u);
    vec_sub(s->shape == SCENE_QUAD ? p + 9 : p + 6, p, s->edge_v);
    vec_cross(s->edge_u, s->edge_v, cross);
    if (!(vec_length(cross) > flat_limit * size * size))
        return lcor_internal_fail(err, LCOR_ERR_DOMAIN, (long)id,
                                  "surface %lu: the first three corners lie on a line; start the "
                                  "polygon at another corner",
                                  number);
    return LCOR_OK;
}

static lcor_status check_all(lcor_scene *scene, lcor_error *err)
{
    if (scene->surfaces.count == 0)
        return lcor_internal_fail(err, LCOR_ERR_DOMAIN, -1, "the scene has no surface");
    if (scene->surfaces.count >= LCOR_BVH_NONE)
        return lcor_internal_fail(err, LCOR_ERR_DOMAIN, -1, "the scene has too many surfaces");
    for (size_t i = 0; i < scene->surfaces.count; i++) {
        lcor_status status = check_shape(scene, i, err);

        if (status == LCOR_OK)
            status = lcor_scene_check_look(&scene_surface_at(scene, i)->look, i, err);
        if (status != LCOR_OK)
            return status;
    }
    for (size_t i = 0; i < scene->lights.count; i++) {
        const lcor_status status = lcor_scene_check_light(scene_light_at(scene, i), i, err);

        if (status != LCOR_OK)
            return status;
    }
    return LCOR_OK;
}

/* Largest extent of the scene, its box's diagonal. */
static double diameter_of(const lcor_scene *scene)
{
    const double *p = scene->corners.items;
    double lo[3], hi[3], d[3];

    vec_copy(p, lo);
    vec_copy(p, hi);
    for (size_t i = 0; i < scene->corners.count; i++)
        for (int k = 0; k < 3; k++) {
            lo[k] = fmin(lo[k], p[3 * i + (size_t)k]);
            hi[k] = fmax(hi[k], p[3 * i + (size_t)k]);
        }
    vec_sub(hi, lo, d);
    return vec_length(d);
}

static lcor_status build_rays(lcor_scene *scene, const lcor_parallel *parallel, lcor_error *err)
{
    size_t count = 0, at = 0;
    lcor_bvh_prim *prims;
    lcor_status status;

    for (size_t i = 0; i < scene->surfaces.count; i++) {
        const scene_surface *s = scene_surface_at(scene, i);

        count += s->shape == SCENE_POLYGON ? s->corner_count - 2 : 1;
    }
    prims = lcor_internal_alloc(&scene->allocator, count * sizeof *prims);
    if (!prims)
        return lcor_internal_fail(err, LCOR_ERR_NOMEM, -1, "no memory for the ray structure");
    for (size_t i = 0; i < scene->surfaces.count; i++) {
        const scene_surface *s = scene_surface_at(scene, i);
        const double *p = scene_corners(scene, s);
        const size_t fan = s->shape == SCENE_POLYGON ? s->corner_count - 2 : 1;

        for (size_t j = 0; j < fan; j++) {
            lcor_bvh_prim *prim = &prims[at++];

            vec_copy(p, prim->origin);
            vec_copy(s->edge_u, prim->edge_u);
            vec_copy(s->edge_v, prim->edge_v);
            if (s->shape == SCENE_POLYGON) {
                vec_sub(p + 3 * (j + 1), p, prim->edge_u);
                vec_sub(p + 3 * (j + 2), p, prim->edge_v);
            }
            prim->owner = (uint32_t)i;
            prim->parallelogram = s->shape == SCENE_QUAD;
        }
    }
    status = lcor_bvh_new(count, prims, &scene->allocator, parallel, &scene->bvh, err);
    lcor_internal_free(&scene->allocator, prims);
    return status;
}

lcor_status lcor_scene_commit(lcor_scene *scene, const lcor_parallel *parallel, lcor_error *err)
{
    lcor_status status;
    size_t corners;

    if (!scene)
        return lcor_internal_fail(err, LCOR_ERR_ARG, -1, "commit: scene is NULL");
    if (scene->committed)
        return lcor_internal_fail(err, LCOR_ERR_ARG, -1, "commit: the scene is committed already");
    status = check_all(scene, err);
    if (status != LCOR_OK)
        return status;
    status = build_rays(scene, parallel, err);
    if (status != LCOR_OK)
        return status;
    for (size_t i = 0; i < scene->lights.count; i++)
        (void)vec_normalize(((lcor_light *)scene->lights.items)[i].direction);
    scene->factor_points = lcor_factor_points_at(0);
    scene->cpu = lcor_internal_cpu();
    scene->diameter = diameter_of(scene);
    corners = scene->corners.count;
    if (!lcor_scene_find_convex(scene) || !lcor_scene_find_sheets(scene) ||
        !lcor_scene_find_solids(scene)) {
        scene->corners.count = corners; /* without the sheets' */
        lcor_bvh_free(scene->bvh);
        scene->bvh = NULL;
        return lcor_internal_fail(err, LCOR_ERR_NOMEM, -1,
                                  "no memory to look at the scene as a whole");
    }
    scene->committed = 1;
    return LCOR_OK;
}
