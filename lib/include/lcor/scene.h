/* SPDX-License-Identifier: MIT */
/** @file
 *  Scenes of planar diffuse surfaces and lights. Build, commit, then solve or view.
 *
 *  Light has three channels. Grey scenes give three equal numbers and are solved as one.
 *
 *  | call                          | may run at the same time as              |
 *  |-------------------------------|------------------------------------------|
 *  | calls on const lcor_scene     | any const calls on the same scene        |
 *  | calls on non-const lcor_scene | calls on other scenes                    | */
#ifndef LCOR_SCENE_H
#define LCOR_SCENE_H

#include <lcor/alloc.h>
#include <lcor/parallel.h>
#include <lcor/status.h>

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct lcor_scene lcor_scene;

LCOR_API lcor_status lcor_scene_new(const lcor_allocator *allocator, lcor_scene **out,
                                    lcor_error *err);
LCOR_API void lcor_scene_free(lcor_scene *scene);

/** How a surface meets light. Zero it and set what differs; NULL where taken means all zeros. */
typedef struct lcor_surface {
    double reflectance[3]; /**< rho [1], 0 <= rho < 1 */
    double emission[3];    /**< emitted flux per area (exitance), >= 0 */
    size_t patches[2];     /**< grid along u and v for results; 0 = 1. It does not steer accuracy */
    int two_sided;         /**< reflects and emits on both sides; else the back only blocks light */
} lcor_surface;

/** Add a parallelogram origin + s edge_u + t edge_v, facing edge_u x edge_v; a triangle facing
 *  (b-a) x (c-a); a convex planar polygon of n >= 3 corners facing its right-hand normal.
 *  `*id` (may be NULL) gets the surface's number, counted from 0 in order of adding. Shapes are
 *  judged by lcor_scene_commit. */
LCOR_API lcor_status lcor_scene_add_quad(lcor_scene *scene, const double origin[3],
                                         const double edge_u[3], const double edge_v[3],
                                         const lcor_surface *surface, size_t *id, lcor_error *err);
LCOR_API lcor_status lcor_scene_add_triangle(lcor_scene *scene, const double a[3],
                                             const double b[3], const double c[3],
                                             const lcor_surface *surface, size_t *id,
                                             lcor_error *err);
LCOR_API lcor_status lcor_scene_add_polygon(lcor_scene *scene, size_t n, const double *corners,
                                            const lcor_surface *surface, size_t *id,
                                            lcor_error *err);

typedef enum lcor_light_kind {
    LCOR_LIGHT_POINT = 0,
    LCOR_LIGHT_SPOT = 1,       /**< KHR_lights_punctual's angular fall-off */
    LCOR_LIGHT_DIRECTIONAL = 2 /**< intensity is the illuminance on a facing surface */
} lcor_light_kind;

/** A light without area. Zero it and set what differs. */
typedef struct lcor_light {
    lcor_light_kind kind;
    double position[3];            /**< point, spot */
    double direction[3];           /**< spot, directional: where the light goes; any length > 0 */
    double intensity[3];           /**< flux per steradian (point, spot) or illuminance, >= 0 */
    double inner_cone, outer_cone; /**< spot, radians, 0 <= inner < outer <= pi/2 */
    double range;                  /**< point, spot: KHR_lights_punctual's window; 0 = unlimited */
} lcor_light;

LCOR_API lcor_status lcor_scene_add_light(lcor_scene *scene, const lcor_light *light, size_t *id,
                                          lcor_error *err);

/** Change what light meets, keep the shapes: allowed before and after commit. */
LCOR_API lcor_status lcor_scene_set_surface(lcor_scene *scene, size_t id,
                                            const lcor_surface *surface, lcor_error *err);
LCOR_API lcor_status lcor_scene_set_light(lcor_scene *scene, size_t id, const lcor_light *light,
                                          lcor_error *err);

/** Validate everything, build the ray structure, merge coplanar pieces that look alike and make
 *  up a parallelogram (their numbers and patches stay), classify the scene (convex, channels).
 *
 *  Errors: LCOR_ERR_DOMAIN names the first bad item in err->text and err->where (a number that is
 *  not finite, not planar, not convex, without area, rho outside 0 <= rho < 1, no surface);
 *  LCOR_ERR_NOMEM; LCOR_ERR_ARG already committed. The scene stays uncommitted on failure. */
LCOR_API lcor_status lcor_scene_commit(lcor_scene *scene, const lcor_parallel *parallel,
                                       lcor_error *err);

LCOR_API size_t lcor_scene_surface_count(const lcor_scene *scene);
LCOR_API size_t lcor_scene_light_count(const lcor_scene *scene);
/** Patch grid of a surface. A quad has patches[0] * patches[1], patch [i, j] at i * patches[1] + j.
 *  A triangle has n * n triangles, n the larger of the two; row i, between i/n and (i+1)/n along
 *  (b-a), holds 2 (n - i) - 1 of them, upright and inverted in turn. A polygon has n * n in each
 *  triangle of its fan from the first corner. */
LCOR_API lcor_status lcor_scene_patch_count(const lcor_scene *scene, size_t surface, size_t *count,
                                            lcor_error *err);
/** Centres (3 numbers each), areas and facing normal in the order of lcor_solution_patches; each
 *  may be NULL. Errors: LCOR_ERR_ARG no such surface, scene not committed. */
LCOR_API lcor_status lcor_scene_patch_geometry(const lcor_scene *scene, size_t surface,
                                               double *centres, double *areas, double normal[3],
                                               lcor_error *err);

/** First hit of a ray on a committed scene.
 *
 *  @param t_max  in units of `direction`; INFINITY for none
 *  @retval 1 hit: *surface, *t, (u, v) along the surface's edges (quad: 0..1 each; triangle and
 *            polygon: along (b-a) and (c-a)) and *front (1 = the facing side); 0 none. */
typedef struct lcor_hit {
    size_t surface;
    double t, u, v;
    int front;
} lcor_hit;
LCOR_API int lcor_scene_intersect(const lcor_scene *scene, const double origin[3],
                                  const double direction[3], double t_max, lcor_hit *hit);

#ifdef __cplusplus
}
#endif

#endif
