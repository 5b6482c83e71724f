/* SPDX-License-Identifier: MIT */
/* The hierarchy as bvh_build.c leaves it and bvh_trace.c walks it. */
#ifndef LCOR_GEOMETRY_BVH_INTERNAL_H
#define LCOR_GEOMETRY_BVH_INTERNAL_H

#include "geometry/bvh.h"

enum { BVH_WIDTH = 8, BVH_DEPTH_MAX = 72 };

/* child >= 0: a node; < 0: block ~child. Unused slots have empty boxes. */
typedef struct bvh_node {
    float lo[3][BVH_WIDTH], hi[3][BVH_WIDTH];
    int32_t child[BVH_WIDTH];
} bvh_node;

/* Eight primitives side by side. `slack` / |determinant| bounds how far the float u, v and t of a
 * hit may be from the true ones. */
typedef struct bvh_block {
    float origin[3][BVH_WIDTH], u[3][BVH_WIDTH], v[3][BVH_WIDTH];
    float sum_max[BVH_WIDTH]; /* largest u + v: 1 triangle, 2 parallelogram, -1 unused */
    float slack[BVH_WIDTH];
    uint32_t prim[BVH_WIDTH];
    uint32_t count;
} bvh_block;

struct lcor_bvh {
    lcor_allocator allocator;
    double centre[3], scale; /* (x - centre) scale lies in -1..1 */
    lcor_bvh_prim *prims;    /* in that frame */
    bvh_node *nodes;
    bvh_block *blocks;
    size_t prim_count, node_count, block_count;
};

#endif
