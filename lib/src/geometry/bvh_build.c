/* SPDX-License-Identifier: MIT */
/* Binary tree by the surface area heuristic with 32 bins, then collapsed to eight children. */
#include "base/internal.h"
#include "geometry/bvh_internal.h"
#include "geometry/vec.h"

#include <float.h>
#include <string.h>

enum { BINS = 32, TASKS_MAX = 64, PARALLEL_MIN = 4096, SAH_DEPTH_MAX = BVH_DEPTH_MAX - 32 };

/* Rounding allowance of boxes: a few ulp of the largest coordinate, which is 1. */
static const float box_slack = 12 * FLT_EPSILON;

/* The same for the products of the float test: origins lie within 6, edges are at most 2 sqrt 3. */
static const double product_slack = 64 * (double)FLT_EPSILON;

/* More than any primitive has in the frame. */
static const double scene_area = 16;

typedef struct box {
    float lo[3], hi[3];
} box;

typedef struct item {
    box bounds;
    float centre[3];
    uint32_t at; /* in builder.exact */
} item;

/* left < 0: leaf of items first..first+count-1. A subtree of k items owns 2k - 1 nodes in a row,
 * so subtrees are built side by side into one array. */
typedef struct binary_node {
    box bounds;
    int64_t left, right;
    uint32_t first, count;
} binary_node;

typedef struct subtree {
    size_t node, first, count;
    int depth;
} subtree;

typedef struct builder {
    bvh_exact *exact;
    item *items;
    binary_node *nodes;
    subtree tasks[TASKS_MAX];
    size_t task_count, task_size;
} builder;

static const box empty_box = {{FLT_MAX, FLT_MAX, FLT_MAX}, {-FLT_MAX, -FLT_MAX, -FLT_MAX}};

static void box_add(box *a, const box *b)
{
    for (int k = 0; k < 3; k++) {
        a->lo[k] = b->lo[k] < a->lo[k] ? b->lo[k] : a->lo[k];
        a->hi[k] = b->hi[k] > a->hi[k] ? b->hi[k] : a->hi[k];
    }
}

static float box_area(const box *b)
{
    const float x = b->hi[0] - b->lo[0], y = b->hi[1] - b->lo[1], z = b->hi[2] - b->lo[2];

    return x * y + y * z + z * x;
}

static int bin_of(float centre, float lo, float scale)
{
    const float bin = (centre - lo) * scale; /* of a width near FLT_MIN, scale is infinite */

    return !(bin >= 1.0F) ? 0 : bin >= (float)BINS ? BINS - 1 : (int)bin;
}

typedef struct split {
    float cost;
    int axis, bin; /* axis -1: none found */
    float lo, scale;
} split;

/* Best of the 31 planes along one axis. */
static void try_axis(const item *items, size_t count, int axis, float lo, float hi, split *best)
{
    const float scale = (float)BINS / (hi - lo);
    size_t number[BINS] = {0}, right_number[BINS], n = 0;
    box bounds[BINS], run = empty_box;
    float right_area[BINS];

    for (int b = 0; b < BINS; b++)
        bounds[b] = empty_box;
    for (size_t i = 0; i < count; i++) {
        const int b = bin_of(items[i].centre[axis], lo, scale);

        number[b]++;
        box_add(&bounds[b], &items[i].bounds);
    }
    for (int b = BINS - 1; b > 0; b--) {
        n += number[b];
        box_add(&run, &bounds[b]);
        right_number[b] = n;
        right_area[b] = n ? box_area(&run) : 0;
    }
    run = empty_box;
    n = 0;
    for (int b = 0; b < BINS - 1; b++) {
        float cost;

        n += number[b];
        box_add(&run, &bounds[b]);
        if (n == 0 || right_number[b + 1] == 0)
            continue;
        cost = box_area(&run) * (float)n + right_area[b + 1] * (float)right_number[b + 1];
        if (cost < best->cost)
            *best = (split){cost, axis, b, lo, scale};
    }
}

static split best_split(const item *items, size_t count)
{
    split best = {FLT_MAX, -1, 0, 0, 0};
    float lo[3], hi[3];

    memcpy(lo, items[0].centre, sizeof lo);
    memcpy(hi, items[0].centre, sizeof hi);
    for (size_t i = 1; i < count; i++)
        for (int k = 0; k < 3; k++) {
            lo[k] = items[i].centre[k] < lo[k] ? items[i].centre[k] : lo[k];
            hi[k] = items[i].centre[k] > hi[k] ? items[i].centre[k] : hi[k];
        }
    for (int k = 0; k < 3; k++)
        if (hi[k] > lo[k])
            try_axis(items, count, k, lo[k], hi[k], &best);
    return best;
}

/* Moves the items left of the split to the front and returns how many there are. */
static size_t partition(item *items, size_t count, const split *s)
{
    size_t i = 0, j = count;

    while (i < j) {
        if (bin_of(items[i].centre[s->axis], s->lo, s->scale) <= s->bin) {
            i++;
        } else {
            const item moved = items[--j];

            items[j] = items[i];
            items[i] = moved;
        }
    }
    return i;
}

static int is_leaf(const binary_node *node, const split *s)
{
    if (node->count <= 2)
        return 1;
    /* A block tests its primitives for about 0.6 of a node each. */
    return node->count <= BVH_BLOCK &&
           (s->axis < 0 || s->cost >= box_area(&node->bounds) * 0.6f * (float)node->count);
}

/* With `defer`, subtrees small enough are put on the task list instead of being built. Equal
 * centres, and whatever is left at SAH_DEPTH_MAX, are halved by count: that bounds the depth. */
static void build(builder *b, size_t at, size_t first, size_t count, int depth, int defer)
{
    for (;;) {
        binary_node *node = &b->nodes[at];
        split s = {FLT_MAX, -1, 0, 0, 0};
        size_t left;

        if (defer && count <= b->task_size && b->task_count < TASKS_MAX) {
            b->tasks[b->task_count++] = (subtree){at, first, count, depth};
            return;
        }
        node->bounds = empty_box;
        for (size_t i = first; i < first + count; i++)
            box_add(&node->bounds, &b->items[i].bounds);
        node->first = (uint32_t)first;
        node->count = (uint32_t)count;
        node->left = node->right = -1;
        if (count > 2)
            s = best_split(b->items + first, count);
        if (is_leaf(node, &s))
            return;
        left = s.axis < 0 || depth > SAH_DEPTH_MAX ? count / 2
                                                   : partition(b->items + first, count, &s);
        node->left = (int64_t)(at + 1);
        node->right = (int64_t)(at + 2 * left);
        depth++;
        /* The shorter side recurs, the longer one loops. */
        if (left < count - left) {
            const size_t right_at = at + 2 * left;

            build(b, at + 1, first, left, depth, defer);
            at = right_at;
            first += left;
            count -= left;
        } else {
            build(b, at + 2 * left, first + left, count - left, depth, defer);
            at = at + 1;
            count = left;
        }
    }
}

static void build_task(void *arg, size_t i)
{
    builder *b = arg;

    build(b, b->tasks[i].node, b->tasks[i].first, b->tasks[i].count, b->tasks[i].depth, 0);
}

static void fill_block(lcor_bvh *bvh, const builder *b, const binary_node *leaf)
{
    bvh_block *block = &bvh->blocks[bvh->block_count++];

    memset(block, 0, sizeof *block);
    block->first = (uint32_t)bvh->exact_count;
    block->used = (1u << leaf->count) - 1;
    for (uint32_t i = 0; i < leaf->count; i++) {
        const bvh_exact *p = &b->exact[b->items[leaf->first + i].at];
        float slack;

        for (int k = 0; k < 3; k++) {
            block->origin[k][i] = (float)p->origin[k];
            block->u[k][i] = (float)p->edge_u[k];
            block->v[k][i] = (float)p->edge_v[k];
        }
        slack = (float)(product_slack * fmax(vec_length(p->edge_u), vec_length(p->edge_v)));
        block->slack[i] = p->parallelogram ? -slack : slack;
        block->owner[i] = p->owner;
        bvh->exact[bvh->exact_count++] = *p;
    }
}

/* Mean area of the primitives below, blocks above all nodes. */
static double blocking(const builder *b, size_t at)
{
    const binary_node *node = &b->nodes[at];
    double sum = 0;

    for (uint32_t i = 0; i < node->count; i++) {
        const bvh_exact *p = &b->exact[b->items[node->first + i].at];
        double normal[3];

        vec_cross(p->edge_u, p->edge_v, normal);
        sum += vec_length(normal) * (p->parallelogram ? 1 : 0.5);
    }
    return sum / node->count + (node->left < 0 ? scene_area : 0);
}

/* An occlusion ray takes the last child first: that shall be the one that ends it soonest. */
static void order_children(const builder *b, size_t *child, int count)
{
    double value[BVH_WIDTH];

    for (int i = 0; i < count; i++) {
        const size_t moved = child[i];
        const double v = blocking(b, moved);
        int at = i;

        for (; at > 0 && value[at - 1] > v; at--) {
            child[at] = child[at - 1];
            value[at] = value[at - 1];
        }
        child[at] = moved;
        value[at] = v;
    }
}

/* Turns the binary subtree into wide nodes: the child of largest area is opened until eight are
 * there. Returns the child code. */
static int32_t collapse(lcor_bvh *bvh, const builder *b, size_t at, float pad)
{
    size_t child[BVH_WIDTH];
    int count = 1;
    size_t me;
    bvh_node *node;

    if (b->nodes[at].left < 0 && bvh->node_count > 0) {
        fill_block(bvh, b, &b->nodes[at]);
        return ~(int32_t)(bvh->block_count - 1);
    }
    me = bvh->node_count++;
    child[0] = at;
    while (count < BVH_WIDTH) {
        int open = -1;
        float area = -1;

        for (int i = 0; i < count; i++) {
            const binary_node *n = &b->nodes[child[i]];

            if (n->left >= 0 && box_area(&n->bounds) > area) {
                area = box_area(&n->bounds);
                open = i;
            }
        }
        if (open < 0)
            break;
        child[count++] = (size_t)b->nodes[child[open]].right;
        child[open] = (size_t)b->nodes[child[open]].left;
    }
    order_children(b, child, count);
    node = &bvh->nodes[me];
    for (int i = 0; i < BVH_WIDTH; i++) {
        const box *bounds = i < count ? &b->nodes[child[i]].bounds : &empty_box;

        for (size_t k = 0; k < 3; k++) {
            node->slab[2 * k * BVH_WIDTH + (size_t)i] = i < count ? bounds->lo[k] - pad : FLT_MAX;
            node->slab[(2 * k + 1) * BVH_WIDTH + (size_t)i] =
                i < count ? bounds->hi[k] + pad : -FLT_MAX;
        }
        node->child[i] = 0;
    }
    for (int i = 0; i < count; i++)
        node->child[i] = collapse(bvh, b, child[i], pad);
    return (int32_t)me;
}

/* Finds the frame in which all coordinates lie in -1..1. */
static void find_frame(lcor_bvh *bvh, size_t n, const lcor_bvh_prim *prims)
{
    double lo[3] = {DBL_MAX, DBL_MAX, DBL_MAX}, hi[3] = {-DBL_MAX, -DBL_MAX, -DBL_MAX};
    double extent = 0;

    for (size_t i = 0; i < n; i++)
        for (int corner = 0; corner < 4; corner++)
            for (int k = 0; k < 3; k++) {
                const double x = prims[i].origin[k] + (corner & 1 ? prims[i].edge_u[k] : 0) +
                                 (corner & 2 ? prims[i].edge_v[k] : 0);

                lo[k] = fmin(lo[k], x);
                hi[k] = fmax(hi[k], x);
            }
    for (int k = 0; k < 3 && n > 0; k++) {
        bvh->centre[k] = 0.5 * lo[k] + 0.5 * hi[k];
        extent = fmax(extent, 0.5 * (hi[k] - lo[k]));
    }
    bvh->scale = extent > 0 ? 1 / extent : 1;
}

/* Takes the primitives that have area into the frame; returns how many. */
static size_t load(const lcor_bvh *bvh, size_t n, const lcor_bvh_prim *prims, builder *b)
{
    size_t used = 0;

    for (size_t i = 0; i < n; i++) {
        bvh_exact *p = &b->exact[used];
        item *it = &b->items[used];
        double normal[3];

        for (int k = 0; k < 3; k++) {
            p->origin[k] = (prims[i].origin[k] - bvh->centre[k]) * bvh->scale;
            p->edge_u[k] = prims[i].edge_u[k] * bvh->scale;
            p->edge_v[k] = prims[i].edge_v[k] * bvh->scale;
        }
        p->prim = (uint32_t)i;
        p->owner = prims[i].owner;
        p->parallelogram = prims[i].parallelogram;
        vec_cross(p->edge_u, p->edge_v, normal);
        if (!(vec_length(normal) > 0))
            continue;
        for (int k = 0; k < 3; k++) {
            const double o = p->origin[k], u = o + p->edge_u[k], v = o + p->edge_v[k];
            const double far = p->parallelogram ? u + p->edge_v[k] : o;

            it->bounds.lo[k] = (float)fmin(fmin(o, u), fmin(v, far));
            it->bounds.hi[k] = (float)fmax(fmax(o, u), fmax(v, far));
            it->centre[k] = 0.5f * it->bounds.lo[k] + 0.5f * it->bounds.hi[k];
        }
        it->at = (uint32_t)used++;
    }
    return used;
}

static size_t count_leaves(const binary_node *nodes, size_t at)
{
    return nodes[at].left < 0 ? 1
                              : count_leaves(nodes, (size_t)nodes[at].left) +
                                    count_leaves(nodes, (size_t)nodes[at].right);
}

/* Returns 0 if there is no memory. */
static int build_tree(lcor_bvh *bvh, builder *b, size_t used, const lcor_parallel *parallel)
{
    size_t leaves;
    void *line;

    b->task_size = used / 16;
    build(b, 0, 0, used, 0, used >= PARALLEL_MIN);
    if (parallel && parallel->run && b->task_count > 1)
        parallel->run(parallel->user, b->task_count, build_task, b);
    else
        for (size_t i = 0; i < b->task_count; i++)
            build_task(b, i);
    leaves = count_leaves(b->nodes, 0); /* a wide node has two children or is the root */
    bvh->exact = lcor_internal_alloc(&bvh->allocator, used * sizeof *bvh->exact);
    bvh->memory = lcor_internal_alloc(
        &bvh->allocator, leaves * (sizeof *bvh->nodes + sizeof *bvh->blocks) + BVH_LINE);
    if (!bvh->exact || !bvh->memory)
        return 0;
    line = (char *)bvh->memory + (BVH_LINE - (uintptr_t)bvh->memory % BVH_LINE) % BVH_LINE;
    bvh->nodes = line;
    bvh->blocks = (bvh_block *)(bvh->nodes + leaves);
    (void)collapse(bvh, b, 0, box_slack);
    return 1;
}

lcor_status lcor_bvh_new(size_t n, const lcor_bvh_prim *prims, const lcor_allocator *allocator,
                         const lcor_parallel *parallel, lcor_bvh **out, lcor_error *err)
{
    lcor_bvh *bvh = NULL;
    builder b = {0};

    if (n >= INT32_MAX / 4)
        return lcor_internal_fail(err, LCOR_ERR_NOMEM, -1, "too many primitives in the scene");
    bvh = lcor_internal_alloc(allocator, sizeof *bvh);
    if (!bvh)
        goto no_memory;
    memset(bvh, 0, sizeof *bvh);
    bvh->allocator = *allocator;
    bvh->walk = bvh_walk_at(0);
    b.exact = lcor_internal_alloc(allocator, (n + 1) * sizeof *b.exact);
    b.items = lcor_internal_alloc(allocator, (n + 1) * sizeof *b.items);
    b.nodes = lcor_internal_alloc(allocator, (2 * n + 1) * sizeof *b.nodes);
    if (!b.exact || !b.items || !b.nodes)
        goto no_memory;
    find_frame(bvh, n, prims);
    n = load(bvh, n, prims, &b);
    if (n > 0 && !build_tree(bvh, &b, n, parallel))
        goto no_memory;
    lcor_internal_free(allocator, b.exact);
    lcor_internal_free(allocator, b.items);
    lcor_internal_free(allocator, b.nodes);
    *out = bvh;
    return LCOR_OK;

no_memory:
    lcor_internal_free(allocator, b.exact);
    lcor_internal_free(allocator, b.items);
    lcor_internal_free(allocator, b.nodes);
    lcor_bvh_free(bvh);
    return lcor_internal_fail(err, LCOR_ERR_NOMEM, -1, "no memory for the ray structure");
}

void lcor_bvh_free(lcor_bvh *bvh)
{
    if (!bvh)
        return;
    lcor_internal_free(&bvh->allocator, bvh->exact);
    lcor_internal_free(&bvh->allocator, bvh->memory);
    lcor_internal_free(&bvh->allocator, bvh);
}

size_t lcor_bvh_bytes(const lcor_bvh *bvh)
{
    return sizeof *bvh + bvh->exact_count * sizeof *bvh->exact +
           bvh->node_count * sizeof *bvh->nodes + bvh->block_count * sizeof *bvh->blocks;
}
