/* SPDX-License-Identifier: MIT */
/* The binary tree from which the hierarchy is made: bvh_build.c grows it, bvh_widen.c gives it
 * eight children a node. */
#ifndef LCOR_GEOMETRY_BVH_BINARY_H
#define LCOR_GEOMETRY_BVH_BINARY_H

#include "geometry/bvh_internal.h"

typedef struct bvh_box {
    float lo[3], hi[3];
} bvh_box;

/* What splits sort by: the centre of the box, and the longest of its edges. */
enum { BVH_KEYS = 4, BVH_KEY_SIZE = 3 };

typedef struct bvh_item {
    bvh_box bounds;
    float key[BVH_KEYS];
    uint32_t prim;
} bvh_item;

/* Items first..first+count-1, of which the left child has the first `left`; 0 in a leaf, which has
 * one item. A subtree of k items owns 2k - 1 nodes in a row: its root, its left subtree, its right
 * one. */
typedef struct bvh_binary_node {
    bvh_box bounds;
    uint32_t first, count, left;
    uint32_t plan; /* of bvh_widen.c */
    float area;    /* of the primitives, likewise */
} bvh_binary_node;

typedef struct bvh_binary {
    const lcor_bvh_prim *prims;
    bvh_item *items;
    bvh_binary_node *nodes;
    size_t count; /* of items */
} bvh_binary;

static inline float bvh_box_area(const bvh_box *b)
{
    const float x = b->hi[0] - b->lo[0], y = b->hi[1] - b->lo[1], z = b->hi[2] - b->lo[2];

    return x * y + y * z + z * x;
}

/* A primitive in the frame of the hierarchy. */
void bvh_to_frame(const lcor_bvh *bvh, const lcor_bvh_prim *prims, uint32_t prim, bvh_exact *out);

/* Fills nodes, blocks and exact primitives from a tree that is not empty. Returns 0 if there is no
 * memory. */
int bvh_widen(lcor_bvh *bvh, bvh_binary *tree);

#endif
