/* SPDX-License-Identifier: MIT */
/* Binary tree by the surface area heuristic, over 32 bins of each key. Rooms have a few walls
 * around many small things; splits by size take these apart, which no plane can. */
#include "base/internal.h"
#include "geometry/bvh_binary.h"
#include "geometry/vec.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum { BINS = 32, TASKS_MAX = 64, PARALLEL_MIN = 4096, SAH_DEPTH_MAX = BVH_DEPTH_MAX - 32 };

typedef bvh_box box;
typedef bvh_item item;
typedef bvh_binary_node binary_node;

typedef struct subtree {
    size_t node, first, count;
    int depth;
} subtree;

typedef struct builder {
    bvh_binary tree;
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

static int bin_of(float key, float lo, float scale)
{
    const float bin = (key - lo) * scale; /* of a width near FLT_MIN, scale is infinite */

    return !(bin >= 1.0F) ? 0 : bin >= (float)BINS ? BINS - 1 : (int)bin;
}

typedef struct split {
    float cost;
    int key, bin; /* key -1: none found */
    float lo, scale;
} split;

/* Best of the 31 splits by one key. */
static void try_key(const item *items, size_t count, int key, float lo, float hi, split *best)
{
    const float scale = (float)BINS / (hi - lo);
    size_t number[BINS] = {0}, right_number[BINS], n = 0;
    box bounds[BINS], run = empty_box;
    float right_area[BINS];

    for (int b = 0; b < BINS; b++)
        bounds[b] = empty_box;
    for (size_t i = 0; i < count; i++) {
        const int b = bin_of(items[i].key[key], lo, scale);

        number[b]++;
        box_add(&bounds[b], &items[i].bounds);
    }
    for (int b = BINS - 1; b > 0; b--) {
        n += number[b];
        box_add(&run, &bounds[b]);
        right_number[b] = n;
        right_area[b] = n ? bvh_box_area(&run) : 0;
    }
    run = empty_box;
    n = 0;
    for (int b = 0; b < BINS - 1; b++) {
        float cost;

        n += number[b];
        box_add(&run, &bounds[b]);
        if (n == 0 || right_number[b + 1] == 0)
            continue;
        cost = bvh_box_area(&run) * (float)n + right_area[b + 1] * (float)right_number[b + 1];
        if (cost < best->cost)
            *best = (split){cost, key, b, lo, scale};
    }
}

static split best_split(const item *items, size_t count)
{
    split best = {FLT_MAX, -1, 0, 0, 0};
    float lo[BVH_KEYS], hi[BVH_KEYS];

    memcpy(lo, items[0].key, sizeof lo);
    memcpy(hi, items[0].key, sizeof hi);
    for (size_t i = 1; i < count; i++)
        for (int k = 0; k < BVH_KEYS; k++) {
            lo[k] = items[i].key[k] < lo[k] ? items[i].key[k] : lo[k];
            hi[k] = items[i].key[k] > hi[k] ? items[i].key[k] : hi[k];
        }
    for (int k = 0; k < BVH_KEYS; k++)
        if (hi[k] > lo[k])
            try_key(items, count, k, lo[k], hi[k], &best);
    return best;
}

/* Moves the items left of the split to the front and returns how many there are. */
static size_t partition(item *items, size_t count, const split *s)
{
    size_t i = 0, j = count;

    while (i < j) {
        if (bin_of(items[i].key[s->key], s->lo, s->scale) <= s->bin) {
            i++;
        } else {
            const item moved = items[--j];

            items[j] = items[i];
            items[i] = moved;
        }
    }
    return i;
}

/* With `defer`, subtrees small enough are put on the task list instead of being built. Equal
 * centres, and whatever is left at SAH_DEPTH_MAX, are halved by count: that bounds the depth. */
static void build(builder *b, size_t at, size_t first, size_t count, int depth, int defer)
{
    for (;;) {
        binary_node *node = &b->tree.nodes[at];
        split s = {FLT_MAX, -1, 0, 0, 0};
        size_t left;

        if (defer && count <= b->task_size && b->task_count < TASKS_MAX) {
            b->tasks[b->task_count++] = (subtree){at, first, count, depth};
            return;
        }
        node->bounds = empty_box;
        for (size_t i = first; i < first + count; i++)
            box_add(&node->bounds, &b->tree.items[i].bounds);
        node->first = (uint32_t)first;
        node->count = (uint32_t)count;
        node->left = 0;
        if (count == 1)
            return;
        if (count > 2)
            s = best_split(b->tree.items + first, count);
        left = s.key < 0 || depth > SAH_DEPTH_MAX ? count / 2
                                                  : partition(b->tree.items + first, count, &s);
        node->left = (uint32_t)left;
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

void bvh_to_frame(const lcor_bvh *bvh, const lcor_bvh_prim *prims, uint32_t prim, bvh_exact *out)
{
    const lcor_bvh_prim *p = &prims[prim];

    for (int k = 0; k < 3; k++) {
        out->origin[k] = (p->origin[k] - bvh->centre[k]) * bvh->scale;
        out->edge_u[k] = p->edge_u[k] * bvh->scale;
        out->edge_v[k] = p->edge_v[k] * bvh->scale;
    }
    out->prim = prim;
    out->owner = p->owner;
    out->parallelogram = p->parallelogram;
}

/* Makes items of the primitives that have area. */
static void load(const lcor_bvh *bvh, size_t n, bvh_binary *tree)
{
    tree->count = 0;
    for (size_t i = 0; i < n; i++) {
        item *it = &tree->items[tree->count];
        double normal[3];
        bvh_exact p;

        bvh_to_frame(bvh, tree->prims, (uint32_t)i, &p);
        vec_cross(p.edge_u, p.edge_v, normal);
        if (!(vec_length(normal) > 0))
            continue;
        it->prim = p.prim;
        it->key[BVH_KEY_SIZE] = 0;
        for (int k = 0; k < 3; k++) {
            const double o = p.origin[k], u = o + p.edge_u[k], v = o + p.edge_v[k];
            const double far = p.parallelogram ? u + p.edge_v[k] : o;
            const float lo = (float)fmin(fmin(o, u), fmin(v, far));
            const float hi = (float)fmax(fmax(o, u), fmax(v, far));

            it->bounds.lo[k] = lo;
            it->bounds.hi[k] = hi;
            it->key[k] = 0.5F * lo + 0.5F * hi;
            it->key[BVH_KEY_SIZE] = fmaxf(it->key[BVH_KEY_SIZE], hi - lo);
        }
        tree->count++;
    }
}

static void build_all(builder *b, const lcor_parallel *parallel)
{
    const size_t count = b->tree.count;

    b->task_size = count / 16;
    build(b, 0, 0, count, 0, count >= PARALLEL_MIN);
    if (parallel && parallel->run && b->task_count > 1)
        parallel->run(parallel->user, b->task_count, build_task, b);
    else
        for (size_t i = 0; i < b->task_count; i++)
            build_task(b, i);
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
    b.tree.prims = prims;
    b.tree.items = lcor_internal_alloc(allocator, (n + 1) * sizeof *b.tree.items);
    b.tree.nodes = lcor_internal_alloc(allocator, (2 * n + 1) * sizeof *b.tree.nodes);
    if (!b.tree.items || !b.tree.nodes)
        goto no_memory;
    find_frame(bvh, n, prims);
    load(bvh, n, &b.tree);
    if (b.tree.count > 0) {
        build_all(&b, parallel);
        if (!bvh_widen(bvh, &b.tree))
            goto no_memory;
    }
    lcor_internal_free(allocator, b.tree.items);
    lcor_internal_free(allocator, b.tree.nodes);
    *out = bvh;
    return LCOR_OK;

no_memory:
    lcor_internal_free(allocator, b.tree.items);
    lcor_internal_free(allocator, b.tree.nodes);
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
