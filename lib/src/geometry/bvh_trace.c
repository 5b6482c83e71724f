/* SPDX-License-Identifier: MIT */
#include "geometry/bvh_internal.h"
#include "geometry/vec.h"

#include <float.h>
#include <math.h>

enum { STACK_MAX = (BVH_WIDTH - 1) * BVH_DEPTH_MAX + BVH_WIDTH };

/* Rays through a shared edge must meet one of the two primitives. */
static const double edge_slack = 1e-12;

/* Allowance of the float distance, relative and in units of the frame. */
static const float far_factor = 1.0f + 16 * FLT_EPSILON, far_add = 64 * FLT_EPSILON;

/* A ray in the frame of the hierarchy, its direction's largest component 1. */
typedef struct walker {
    const lcor_bvh *bvh;
    double origin[3], direction[3];
    double t_min, t_max; /* along the scaled direction; t_max shrinks to the best hit */
    float o[3], d[3], inverse[3], far;
    uint32_t skip;
    int found;
    lcor_bvh_hit hit;
} walker;

static void set_far(walker *w)
{
    const double far = w->t_max * (double)far_factor + (double)far_add;

    w->far = far < (double)FLT_MAX ? (float)far : FLT_MAX;
}

/* Returns the factor from the ray's t to the walker's and the shift between them. */
static void start(walker *w, const lcor_bvh *bvh, const lcor_ray *ray, double *factor,
                  double *shift)
{
    double largest = 0, length2, middle;

    w->bvh = bvh;
    w->skip = ray->skip;
    w->found = 0;
    for (int k = 0; k < 3; k++) {
        w->origin[k] = (ray->origin[k] - bvh->centre[k]) * bvh->scale;
        w->direction[k] = ray->direction[k] * bvh->scale;
        largest = fmax(largest, fabs(w->direction[k]));
    }
    *factor = largest;
    for (int k = 0; k < 3; k++)
        w->direction[k] /= largest;
    /* From far away, start near the scene, so that float coordinates stay small. */
    length2 = vec_dot(w->direction, w->direction);
    middle = -vec_dot(w->origin, w->direction) / length2;
    *shift = vec_dot(w->origin, w->origin) > 16 && middle > 4 ? middle - 4 : 0;
    vec_add_scaled(w->origin, *shift, w->direction, w->origin);
    w->t_min = ray->t_min * largest - *shift;
    w->t_max = ray->t_max * largest - *shift;
    for (int k = 0; k < 3; k++) {
        const double d = w->direction[k];

        w->o[k] = (float)w->origin[k];
        w->d[k] = (float)d;
        w->inverse[k] = (float)(1 / (fabs(d) > 1e-12 ? d : copysign(1e-12, d)));
    }
    set_far(w);
}

/* Decides in double whether primitive `index` is the nearest hit so far. */
static int meet(walker *w, uint32_t index)
{
    const lcor_bvh_prim *p = &w->bvh->prims[index];
    double a[3], b[3], s[3], det, u, v, t;

    if (p->owner == w->skip)
        return 0;
    vec_cross(w->direction, p->edge_v, a);
    det = vec_dot(p->edge_u, a);
    if (det == 0)
        return 0;
    vec_sub(w->origin, p->origin, s);
    u = vec_dot(s, a) / det;
    if (u < -edge_slack || u > 1 + edge_slack)
        return 0;
    vec_cross(s, p->edge_u, b);
    v = vec_dot(w->direction, b) / det;
    if (v < -edge_slack || (p->parallelogram ? v : u + v) > 1 + edge_slack)
        return 0;
    t = vec_dot(p->edge_v, b) / det;
    if (!(t > w->t_min && t < w->t_max))
        return 0;
    w->t_max = t;
    set_far(w);
    w->found = 1;
    w->hit = (lcor_bvh_hit){t, u, v, index, p->owner};
    return 1;
}

/* The float test of eight primitives: no true hit fails it. */
static int meet_block(walker *w, const bvh_block *block)
{
    int pass[BVH_WIDTH], any = 0, met = 0;

    for (int i = 0; i < BVH_WIDTH; i++) {
        const float ux = block->u[0][i], uy = block->u[1][i], uz = block->u[2][i];
        const float vx = block->v[0][i], vy = block->v[1][i], vz = block->v[2][i];
        const float ax = w->d[1] * vz - w->d[2] * vy, ay = w->d[2] * vx - w->d[0] * vz,
                    az = w->d[0] * vy - w->d[1] * vx;
        const float det = ux * ax + uy * ay + uz * az;
        const float inv = 1.0f / (det < 0 || det > 0 ? det : FLT_MIN);
        const float sx = w->o[0] - block->origin[0][i], sy = w->o[1] - block->origin[1][i],
                    sz = w->o[2] - block->origin[2][i];
        const float bx = sy * uz - sz * uy, by = sz * ux - sx * uz, bz = sx * uy - sy * ux;
        const float u = (sx * ax + sy * ay + sz * az) * inv;
        const float v = (w->d[0] * bx + w->d[1] * by + w->d[2] * bz) * inv;
        const float t = (vx * bx + vy * by + vz * bz) * inv;
        const float slack = 1e-6f + block->slack[i] * (inv < 0 ? -inv : inv);

        /* Written so that a NaN or infinity of a grazing ray passes on to the exact test. */
        pass[i] = !(u < -slack) & !(v < -slack) & !(u > 1 + slack) & !(v > 1 + slack) &
                  !(u + v > block->sum_max[i] + slack) & !(t > w->far + slack) & !(t < -slack);
    }
    for (int i = 0; i < BVH_WIDTH; i++)
        any |= pass[i];
    if (!any)
        return 0;
    for (uint32_t i = 0; i < block->count; i++)
        if (pass[i])
            met |= meet(w, block->prim[i]);
    return met;
}

typedef struct entry {
    int32_t child;
    float near;
} entry;

/* Pushes the children whose boxes the ray meets, the nearest on top. */
static int push_children(const walker *w, const bvh_node *node, entry *stack, int top)
{
    const float *lo[3], *hi[3];
    float near[BVH_WIDTH];
    int hit[BVH_WIDTH];
    const int bottom = top;

    for (int k = 0; k < 3; k++) {
        lo[k] = w->inverse[k] < 0 ? node->hi[k] : node->lo[k];
        hi[k] = w->inverse[k] < 0 ? node->lo[k] : node->hi[k];
    }
    for (int i = 0; i < BVH_WIDTH; i++) {
        const float x0 = (lo[0][i] - w->o[0]) * w->inverse[0];
        const float y0 = (lo[1][i] - w->o[1]) * w->inverse[1];
        const float z0 = (lo[2][i] - w->o[2]) * w->inverse[2];
        const float x1 = (hi[0][i] - w->o[0]) * w->inverse[0];
        const float y1 = (hi[1][i] - w->o[1]) * w->inverse[1];
        const float z1 = (hi[2][i] - w->o[2]) * w->inverse[2];
        float a = x0 > y0 ? x0 : y0, b = x1 < y1 ? x1 : y1;

        a = a > z0 ? a : z0;
        b = b < z1 ? b : z1;
        a = a > 0 ? a : 0;
        b = b < w->far ? b : w->far;
        near[i] = a;
        hit[i] = a <= b;
    }
    for (int i = 0; i < BVH_WIDTH; i++)
        if (hit[i]) {
            int at = top++;

            for (; at > bottom && stack[at - 1].near < near[i]; at--)
                stack[at] = stack[at - 1];
            stack[at] = (entry){node->child[i], near[i]};
        }
    return top;
}

/* Walks the tree; with `any` the first hit ends it and *block says where. */
static void walk(walker *w, int any, uint32_t *block)
{
    entry stack[STACK_MAX];
    int top = 1;

    if (w->bvh->node_count == 0 || !(w->t_min < w->t_max))
        return;
    stack[0] = (entry){0, 0};
    while (top > 0) {
        const entry next = stack[--top];

        if (next.near > w->far)
            continue;
        if (next.child >= 0) {
            top = push_children(w, &w->bvh->nodes[next.child], stack, top);
        } else if (meet_block(w, &w->bvh->blocks[~next.child]) && any) {
            *block = (uint32_t)~next.child;
            return;
        }
    }
}

int lcor_bvh_closest(const lcor_bvh *bvh, const lcor_ray *ray, lcor_bvh_hit *hit)
{
    walker w;
    double factor, shift;

    start(&w, bvh, ray, &factor, &shift);
    walk(&w, 0, NULL);
    if (!w.found)
        return 0;
    *hit = w.hit;
    hit->t = (hit->t + shift) / factor;
    return 1;
}

int lcor_bvh_occluded(const lcor_bvh *bvh, const lcor_ray *ray, uint32_t *cache)
{
    walker w;
    double factor, shift;
    uint32_t block = LCOR_BVH_NONE;

    start(&w, bvh, ray, &factor, &shift);
    if (cache && *cache < bvh->block_count && meet_block(&w, &bvh->blocks[*cache]))
        return 1;
    walk(&w, 1, &block);
    if (w.found && cache)
        *cache = block;
    return w.found;
}
