/* SPDX-License-Identifier: MIT */
/* The hierarchy as bvh_build.c leaves it and bvh_trace.c walks it. */
#ifndef LCOR_GEOMETRY_BVH_INTERNAL_H
#define LCOR_GEOMETRY_BVH_INTERNAL_H

#include "geometry/bvh.h"

enum { BVH_WIDTH = 8, BVH_BLOCK = 4, BVH_DEPTH_MAX = 72 };

/* Nodes fill four cache lines, blocks three. */
enum { BVH_LINE = 64 };

/* child >= 0: a node; < 0: block ~child. Unused slots have empty boxes. */
typedef struct bvh_node {
    float slab[6 * BVH_WIDTH]; /* of the boxes: x low, x high, y low... */
    int32_t child[BVH_WIDTH], unused[BVH_WIDTH];
} bvh_node;

/* Up to four primitives side by side, number `first` and on. `slack` / |determinant| bounds how far
 * the float u, v and t of a hit may be from the true ones; it is negative for parallelograms. */
typedef struct bvh_block {
    float origin[3][BVH_BLOCK], u[3][BVH_BLOCK], v[3][BVH_BLOCK], slack[BVH_BLOCK];
    uint32_t owner[BVH_BLOCK], first, used; /* used: a bit for each primitive there is */
    uint32_t unused[2];
} bvh_block;

/* A primitive in the frame of the hierarchy, in the order of the blocks. */
typedef struct bvh_exact {
    double origin[3], edge_u[3], edge_v[3];
    uint32_t prim, owner;
    int parallelogram;
} bvh_exact;

/* The walk for one instruction set. */
typedef struct bvh_walker bvh_walker;
typedef struct bvh_walk {
    const char *name;
    void (*closest)(bvh_walker *w);
    uint32_t (*occluded)(bvh_walker *w, uint32_t first);
} bvh_walk;

/* Those that this build has and the machine can run, best first; NULL after the last. */
const bvh_walk *bvh_walk_at(size_t index);

struct lcor_bvh {
    const bvh_walk *walk;
    lcor_allocator allocator;
    double centre[3], scale; /* (x - centre) scale lies in -1..1 */
    bvh_exact *exact;
    void *memory; /* of nodes and blocks, which start at a cache line */
    bvh_node *nodes;
    bvh_block *blocks;
    size_t exact_count, node_count, block_count;
};

#endif
