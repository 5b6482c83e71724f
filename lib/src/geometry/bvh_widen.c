/* SPDX-License-Identifier: MIT */
/* From the binary tree to nodes of eight children and blocks of four primitives. Which binary nodes
 * become wide ones, and which leaves, is found by dynamic programming: Ylitie, Karras and Laine,
 * "Efficient incoherent ray traversal on GPUs through compressed wide BVHs" (2017), section 3.1. */
#include "base/internal.h"
#include "geometry/bvh_binary.h"
#include "geometry/vec.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* Rounding allowance of boxes: a few ulp of the largest coordinate, which is 1. */
static const float box_slack = 12 * FLT_EPSILON;

/* The same for the products of the float test: origins lie within 6, edges are at most 2 sqrt 3. */
static const double product_slack = 64 * (double)FLT_EPSILON;

/* More than any primitive has in the frame. */
static const float scene_area = 16;

/* What testing a block of primitives costs, in tests of a node. */
static const float block_cost = 2.5F;

/* What its memory costs besides, as a share of a test of all nodes: too little to part what many
 * rays meet, enough to fill the blocks that few do. */
static const float memory_cost = 1;

static size_t left_of(size_t at) { return at + 1; }

static size_t right_of(const bvh_binary *tree, size_t at)
{
    return at + 2 * (size_t)tree->nodes[at].left;
}

/* A plan: bit 0 tells that the node is a leaf. Bits 3 k.. tell how it is served by k + 1 slots of a
 * wide node: its left child by one more than they say and its right child by the rest, or,
 * ONE_SLOT, by one of them as well. */
enum { LEAF = 1, ONE_SLOT = 7 };

static int is_leaf(const bvh_binary *tree, size_t at) { return (int)(tree->nodes[at].plan & LEAF); }

static unsigned left_slots(const bvh_binary *tree, size_t at, unsigned k)
{
    return tree->nodes[at].plan >> 3 * k & 7;
}

static float primitive_area(const lcor_bvh *bvh, const bvh_binary *tree, uint32_t item)
{
    double normal[3];
    bvh_exact p;

    bvh_to_frame(bvh, tree->prims, tree->items[item].prim, &p);
    vec_cross(p.edge_u, p.edge_v, normal);
    return (float)(vec_length(normal) * (p.parallelogram ? 1 : 0.5));
}

/* The cheapest ways to serve a node by two slots or more, from the costs of its children. */
static uint32_t share_slots(const float left[BVH_WIDTH], const float right[BVH_WIDTH],
                            float cost[BVH_WIDTH])
{
    uint32_t plan = 0;

    for (unsigned k = 1; k < BVH_WIDTH; k++) {
        unsigned best = 0;

        for (unsigned j = 1; j < k; j++)
            if (left[j] + right[k - 1 - j] < left[best] + right[k - 1 - best])
                best = j;
        cost[k] = left[best] + right[k - 1 - best];
        plan |= best << 3 * k;
    }
    return plan;
}

/* Plans a subtree: cost[k] is what a ray has to pay for it, by the surface area heuristic, in at
 * most k + 1 slots of a wide node. */
static void make_plan(const lcor_bvh *bvh, bvh_binary *tree, size_t at, float cost[BVH_WIDTH])
{
    bvh_binary_node *node = &tree->nodes[at];
    const float memory = memory_cost * bvh_box_area(&tree->nodes[0].bounds) / (float)tree->count;
    const float test = bvh_box_area(&node->bounds) + memory;
    const float as_leaf = node->count <= BVH_BLOCK ? block_cost * test : FLT_MAX;
    float left[BVH_WIDTH], right[BVH_WIDTH];

    if (node->left == 0) {
        node->area = primitive_area(bvh, tree, node->first);
        node->plan = ~UINT32_C(0);
        for (int k = 0; k < BVH_WIDTH; k++)
            cost[k] = as_leaf;
        return;
    }
    make_plan(bvh, tree, left_of(at), left);
    make_plan(bvh, tree, right_of(tree, at), right);
    node->area = tree->nodes[left_of(at)].area + tree->nodes[right_of(tree, at)].area;
    node->plan = share_slots(left, right, cost);
    cost[0] = test + cost[BVH_WIDTH - 1];
    if (as_leaf <= cost[0]) {
        cost[0] = as_leaf;
        node->plan |= LEAF;
    }
    for (unsigned k = 1; k < BVH_WIDTH; k++)
        if (cost[0] < cost[k]) {
            cost[k] = cost[0];
            node->plan |= (unsigned)ONE_SLOT << 3 * k;
        }
}

/* Appends to child[] the nodes that serve a subtree in k + 1 slots. */
static void open_slots(const bvh_binary *tree, size_t at, unsigned k, size_t *child, int *count)
{
    const unsigned left = k > 0 ? left_slots(tree, at, k) : ONE_SLOT;

    if (left == ONE_SLOT) {
        child[(*count)++] = at;
    } else {
        open_slots(tree, left_of(at), left, child, count);
        open_slots(tree, right_of(tree, at), k - 1 - left, child, count);
    }
}

/* Mean area of the primitives below, leaves above all nodes. */
static float blocking(const bvh_binary *tree, size_t at)
{
    const bvh_binary_node *node = &tree->nodes[at];

    return node->area / (float)node->count + (is_leaf(tree, at) ? scene_area : 0);
}

/* The children of the wide node that a node becomes, which is a leaf only as the root of all. An
 * occlusion ray takes the last child first: that shall be the one that ends it soonest. */
static int find_children(const bvh_binary *tree, size_t at, size_t child[BVH_WIDTH])
{
    int count = 0;

    open_slots(tree, at, is_leaf(tree, at) ? 0 : BVH_WIDTH - 1, child, &count);
    for (int i = 1; i < count; i++) {
        const size_t moved = child[i];
        int to = i;

        for (; to > 0 && blocking(tree, child[to - 1]) > blocking(tree, moved); to--)
            child[to] = child[to - 1];
        child[to] = moved;
    }
    return count;
}

/* Adds up the wide nodes and the blocks of a subtree. */
static void count_wide(const bvh_binary *tree, size_t at, size_t *nodes, size_t *blocks)
{
    size_t child[BVH_WIDTH];
    const int count = find_children(tree, at, child);

    ++*nodes;
    for (int i = 0; i < count; i++)
        if (is_leaf(tree, child[i]))
            ++*blocks;
        else
            count_wide(tree, child[i], nodes, blocks);
}

/* Returns the block's child code. */
static int32_t fill_block(lcor_bvh *bvh, const bvh_binary *tree, const bvh_binary_node *leaf)
{
    bvh_block *block = &bvh->blocks[bvh->block_count];

    memset(block, 0, sizeof *block);
    block->first = leaf->first;
    block->used = (1u << leaf->count) - 1;
    for (uint32_t i = 0; i < leaf->count; i++) {
        bvh_exact *p = &bvh->exact[leaf->first + i];
        float slack;

        bvh_to_frame(bvh, tree->prims, tree->items[leaf->first + i].prim, p);
        for (int k = 0; k < 3; k++) {
            block->origin[k][i] = (float)p->origin[k];
            block->u[k][i] = (float)p->edge_u[k];
            block->v[k][i] = (float)p->edge_v[k];
        }
        slack = (float)(product_slack * fmax(vec_length(p->edge_u), vec_length(p->edge_v)));
        block->slack[i] = p->parallelogram ? -slack : slack;
        block->owner[i] = p->owner;
    }
    return ~(int32_t)bvh->block_count++;
}

/* Makes the wide node of a subtree and all below it. Returns its child code. */
static int32_t fill_node(lcor_bvh *bvh, const bvh_binary *tree, size_t at)
{
    const size_t me = bvh->node_count++;
    bvh_node *node = &bvh->nodes[me];
    size_t child[BVH_WIDTH];
    const int count = find_children(tree, at, child);

    for (int k = 0; k < 3; k++)
        for (int i = 0; i < BVH_WIDTH; i++) {
            float *lo = &node->slab[2 * k * BVH_WIDTH + i], *hi = lo + BVH_WIDTH;
            const bvh_box *bounds = i < count ? &tree->nodes[child[i]].bounds : NULL;

            *lo = bounds ? bounds->lo[k] - box_slack : FLT_MAX;
            *hi = bounds ? bounds->hi[k] + box_slack : -FLT_MAX;
        }
    memset(node->child, 0, sizeof node->child);
    for (int i = 0; i < count; i++)
        node->child[i] = is_leaf(tree, child[i]) ? fill_block(bvh, tree, &tree->nodes[child[i]])
                                                 : fill_node(bvh, tree, child[i]);
    return (int32_t)me;
}

int bvh_widen(lcor_bvh *bvh, bvh_binary *tree)
{
    size_t nodes = 0, blocks = 0;
    float cost[BVH_WIDTH];
    void *line;

    make_plan(bvh, tree, 0, cost);
    count_wide(tree, 0, &nodes, &blocks);
    bvh->exact = lcor_internal_alloc(&bvh->allocator, tree->count * sizeof *bvh->exact);
    bvh->memory = lcor_internal_alloc(&bvh->allocator, nodes * sizeof *bvh->nodes +
                                                           blocks * sizeof *bvh->blocks + BVH_LINE);
    if (!bvh->exact || !bvh->memory)
        return 0;
    line = (char *)bvh->memory + (BVH_LINE - (uintptr_t)bvh->memory % BVH_LINE) % BVH_LINE;
    bvh->nodes = line;
    bvh->blocks = (bvh_block *)(bvh->nodes + nodes);
    bvh->exact_count = tree->count;
    (void)fill_node(bvh, tree, 0);
    return 1;
}
