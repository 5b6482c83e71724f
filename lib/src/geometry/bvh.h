/* SPDX-License-Identifier: MIT */
/* Rays against flat primitives: a bounding volume hierarchy with eight children a node and blocks
 * of four primitives. Boxes and a first test are in float, with a bound on their error; what that
 * leaves open, and where a hit lies, is decided in double, so that results do not depend on the
 * size of the scene or its place in space, nor on the processor's vector instructions. */
#ifndef LCOR_GEOMETRY_BVH_H
#define LCOR_GEOMETRY_BVH_H

#include <lcor/alloc.h>
#include <lcor/parallel.h>
#include <lcor/status.h>

#include <stddef.h>
#include <stdint.h>

/* Parallelogram origin + [0, 1] u + [0, 1] v, or the triangle of it with u + v <= 1. */
typedef struct lcor_bvh_prim {
    double origin[3], edge_u[3], edge_v[3];
    uint32_t owner; /* number reported by hits and compared with a ray's `skip` */
    int parallelogram;
} lcor_bvh_prim;

typedef struct lcor_bvh lcor_bvh;

enum { LCOR_BVH_NONE = UINT32_MAX / 2 }; /* no owner, no prim */

/* Points origin + t direction with t_min < t < t_max. Primitives of owner `skip` are not met: a
 * flat surface never hides itself. */
typedef struct lcor_ray {
    double origin[3], direction[3];
    double t_min, t_max;
    uint32_t skip;
} lcor_ray;

typedef struct lcor_bvh_hit {
    double t, u, v; /* along the primitive's edges */
    uint32_t prim, owner;
} lcor_bvh_hit;

/* Copies the primitives. Primitives without area are never hit. */
lcor_status lcor_bvh_new(size_t n, const lcor_bvh_prim *prims, const lcor_allocator *allocator,
                         const lcor_parallel *parallel, lcor_bvh **out, lcor_error *err);
void lcor_bvh_free(lcor_bvh *bvh);
size_t lcor_bvh_bytes(const lcor_bvh *bvh);

/* Nearest hit: returns 1 and fills *hit, or 0. */
int lcor_bvh_closest(const lcor_bvh *bvh, const lcor_ray *ray, lcor_bvh_hit *hit);

/* Whether anything is met. `cache` (may be NULL; start it at LCOR_BVH_NONE) remembers the blocker
 * of the last call and tries it first; the answer does not depend on it. */
int lcor_bvh_occluded(const lcor_bvh *bvh, const lcor_ray *ray, uint32_t *cache);

#endif
