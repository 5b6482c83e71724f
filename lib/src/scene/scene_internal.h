/* SPDX-License-Identifier: MIT */
/* A scene as the engines see it. Everything below is filled by lcor_scene_commit and constant
 * afterwards, except the looks and lights that lcor_scene_set_* change. */
#ifndef LCOR_SCENE_INTERNAL_H
#define LCOR_SCENE_INTERNAL_H

#include "base/array.h"
#include "geometry/bvh.h"

#include <lcor/scene.h>

#include <stdint.h>

typedef enum scene_shape { SCENE_QUAD, SCENE_TRIANGLE, SCENE_POLYGON } scene_shape;

typedef struct scene_surface {
    scene_shape shape;
    double origin[3], edge_u[3], edge_v[3]; /* polygon: corner 0 and the edges to 1 and 2 */
    double normal[3];                       /* of length 1, on the facing side */
    double area;
    size_t first_corner, corner_count; /* in lcor_scene.corners, counted in points */
    lcor_surface look;
} scene_surface;

struct lcor_scene {
    lcor_allocator allocator;
    lcor_array surfaces; /* scene_surface */
    lcor_array lights;   /* lcor_light, directions of length 1 after commit */
    lcor_array corners;  /* double[3] */
    int committed;
    lcor_bvh *bvh;   /* owners are surface numbers */
    double diameter; /* of the bounding box */
    int convex;      /* no surface has anything behind it: nothing hides anything */
};

/* Distance below which a ray's end counts as lying on a surface, as part of scene->diameter. */
#define SCENE_TOUCH 1e-9

static inline const scene_surface *scene_surface_at(const lcor_scene *scene, size_t i)
{
    return (const scene_surface *)scene->surfaces.items + i;
}

static inline const lcor_light *scene_light_at(const lcor_scene *scene, size_t i)
{
    return (const lcor_light *)scene->lights.items + i;
}

static inline const double *scene_corners(const lcor_scene *scene, const scene_surface *surface)
{
    return (const double *)scene->corners.items + 3 * surface->first_corner;
}

/* The checks of commit, one item each; `where` of the error is its number. */
lcor_status lcor_scene_check_look(const lcor_surface *look, size_t id, lcor_error *err);
lcor_status lcor_scene_check_light(const lcor_light *light, size_t id, lcor_error *err);

/* Whether the point lies on the facing side or on the plane of every surface. In a convex scene
 * nothing then hides it from any surface. */
int lcor_scene_inside(const lcor_scene *scene, const double point[3]);

/* Whether anything stands between two points of the scene, each on a surface or free. Surface
 * `skip` (or LCOR_BVH_NONE) is looked through. `cache` as in lcor_bvh_occluded. */
int lcor_scene_blocked(const lcor_scene *scene, const double from[3], const double to[3],
                       uint32_t skip, uint32_t *cache);
/* The same towards a direction, without end. */
int lcor_scene_blocked_towards(const lcor_scene *scene, const double from[3],
                               const double direction[3], uint32_t skip, uint32_t *cache);

/* Corners of patch `index` as a parallelogram (corner_count 4) or triangle (3) in the surface's
 * edge coordinates: point = origin + s edge_u + t edge_v. Triangular patches of a polygon are
 * counted fan triangle by fan triangle. */
typedef struct scene_patch {
    double s[4], t[4];
    int corner_count;
} scene_patch;

size_t lcor_scene_patches_of(const scene_surface *surface); /* 0: does not fit size_t */
void lcor_scene_patch(const lcor_scene *scene, const scene_surface *surface, size_t index,
                      scene_patch *out);
size_t lcor_scene_patch_grid(const scene_surface *surface); /* n of a triangle or polygon */

/* Edge coordinates of the point's projection onto the surface's plane. */
void lcor_scene_coordinates(const scene_surface *surface, const double point[3], double *s,
                            double *t);

#endif
