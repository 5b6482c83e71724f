/* SPDX-License-Identifier: MIT */
/* The walk through the hierarchy for one instruction set. Included by bvh_trace.c with
 *   ISA(name)  the name with the set's suffix
 *   TARGET     the attribute that turns the set on, or nothing
 *   MASK8(x)   one bit for each of eight integers at x that is -1; the others are 0
 * The loops over children and primitives are written for compilers to vectorise. Their results have
 * the same bits in every set, and what they let through is decided by meet() in double anyway. */

#define INNER static TARGET LCOR_INLINE

/* The float test of a block: bits of those the ray may meet. No true hit fails it. */
INNER unsigned ISA(test)(const walker *w, const float_ray *r, const bvh_block *block, candidates *c)
{
    const float ox = r->o[0], oy = r->o[1], oz = r->o[2];
    const float dx = r->d[0], dy = r->d[1], dz = r->d[2], before = w->before, far = w->far;
    int32_t pass[BVH_BLOCK];

    for (int i = 0; i < BVH_BLOCK; i++) {
        const float ux = block->u[0][i], uy = block->u[1][i], uz = block->u[2][i];
        const float vx = block->v[0][i], vy = block->v[1][i], vz = block->v[2][i];
        const float ax = dy * vz - dz * vy, ay = dz * vx - dx * vz, az = dx * vy - dy * vx;
        const float det = ux * ax + uy * ay + uz * az;
        const float inv = 1.0f / (det < 0 || det > 0 ? det : FLT_MIN);
        const float sx = ox - block->origin[0][i], sy = oy - block->origin[1][i],
                    sz = oz - block->origin[2][i];
        const float bx = sy * uz - sz * uy, by = sz * ux - sx * uz, bz = sx * uy - sy * ux;
        const float u = (sx * ax + sy * ay + sz * az) * inv;
        const float v = (dx * bx + dy * by + dz * bz) * inv;
        const float t = (vx * bx + vy * by + vz * bz) * inv;
        const float bound = block->slack[i], most = bound < 0 ? 2.0f : 1.0f;
        const float slack = 1e-6f + (bound < 0 ? -bound : bound) * (inv < 0 ? -inv : inv);
        /* How deep inside: u, v >= 0, u, v <= 1, u + v <= most. */
        const float low = u < v ? u : v, high = 1 - (u < v ? v : u);
        const float rest = most - (u + v);
        const float edge = low < high ? low : high, depth = edge < rest ? edge : rest;

        /* Written so that a NaN or infinity of a grazing ray passes on to the exact test. */
        pass[i] = -(!(depth < -slack) & !(t > far + slack) & !(t < before - slack));
        c->t[i] = t;
        c->slack[i] = slack;
        c->depth[i] = depth;
    }
    return mask4_base(pass) & block->used;
}

/* Whether the ray meets any of the block. */
INNER int ISA(any)(walker *w, const float_ray *r, const bvh_block *block)
{
    candidates c;

    for (unsigned left = ISA(test)(w, r, block, &c); left != 0; left &= left - 1) {
        const unsigned i = lowest_bit(left);

        if (block->owner[i] == w->skip)
            continue;
        if (is_sure(w, &c, i) || meet(w, block->first + i))
            return 1;
    }
    return 0;
}

/* Keeps the nearest hit. */
INNER void ISA(nearest)(walker *w, const float_ray *r, const bvh_block *block)
{
    candidates c;

    for (unsigned left = ISA(test)(w, r, block, &c); left != 0; left &= left - 1) {
        const unsigned i = lowest_bit(left);

        if (block->owner[i] == w->skip)
            continue;
        if (is_sure(w, &c, i)) {
            w->pending = block->first + i;
            w->far = c.t[i] + c.slack[i];
            w->below = c.t[i] - c.slack[i];
            prefetch(&w->bvh->exact[w->pending]);
        } else if (!(c.t[i] > w->far + c.slack[i])) {
            settle(w);
            (void)meet(w, block->first + i);
        }
    }
}

/* Bits of the children whose boxes the ray meets between `begin` and `far`, and how far away they
 * are. A ray leaves a surface through boxes that end there: those its beginning spares it. */
INNER unsigned ISA(children)(const float_ray *r, float begin, float far, const bvh_node *node,
                             float near[BVH_WIDTH])
{
    const float *x_in = node->slab + r->in[0], *x_out = node->slab + r->out[0];
    const float *y_in = node->slab + r->in[1], *y_out = node->slab + r->out[1];
    const float *z_in = node->slab + r->in[2], *z_out = node->slab + r->out[2];
    const float ox = r->o[0], oy = r->o[1], oz = r->o[2];
    const float ix = r->inverse[0], iy = r->inverse[1], iz = r->inverse[2];
    int32_t hit[BVH_WIDTH];

    for (int i = 0; i < BVH_WIDTH; i++) {
        const float x0 = (x_in[i] - ox) * ix, x1 = (x_out[i] - ox) * ix;
        const float y0 = (y_in[i] - oy) * iy, y1 = (y_out[i] - oy) * iy;
        const float z0 = (z_in[i] - oz) * iz, z1 = (z_out[i] - oz) * iz;
        float a = x0 > y0 ? x0 : y0, b = x1 < y1 ? x1 : y1;

        a = a > z0 ? a : z0;
        b = b < z1 ? b : z1;
        a = a > begin ? a : begin;
        b = b < far ? b : far;
        near[i] = a;
        hit[i] = -(a <= b);
    }
    return MASK8(hit);
}

/* Goes on to the nearest child and stacks the others, the nearer on top. `left` is not empty. How
 * many there are can be told in advance, their order cannot: so that is found without branches. */
INNER int32_t ISA(descend)(const bvh_node *node, unsigned left, const float near[BVH_WIDTH],
                           entry *stack, int *top)
{
    const int bottom = *top;
    entry next = entry_of(node, near, lowest_bit(left));

    for (left &= left - 1; left != 0; left &= left - 1) {
        entry other = entry_of(node, near, lowest_bit(left));

        sort_entries(&next, &other);
        for (int at = bottom; at < *top; at++)
            sort_entries(&other, &stack[at]);
        stack[(*top)++] = other;
    }
    return entry_child(next);
}

static TARGET void ISA(closest)(walker *w)
{
    const float_ray *r = &w->ray;
    entry stack[STACK_MAX];
    int32_t child = 0;
    int top = 0;

    for (;;) {
        if (child >= 0) {
            const bvh_node *node = &w->bvh->nodes[child];
            float near[BVH_WIDTH];
            const unsigned left = ISA(children)(r, w->begin, w->far, node, near);

            if (left != 0) {
                child = ISA(descend)(node, left, near, stack, &top);
                continue;
            }
        } else {
            ISA(nearest)(w, r, &w->bvh->blocks[~child]);
        }
        do {
            if (top == 0) {
                settle(w);
                return;
            }
            child = entry_child(stack[--top]);
        } while (entry_near(stack[top]) > w->far);
    }
}

/* Children lie in a node in the order that finds a hit soonest. Returns the block that was met, or
 * LCOR_BVH_NONE. */
static TARGET uint32_t ISA(occluded)(walker *w, uint32_t first)
{
    const float_ray *r = &w->ray;
    int32_t stack[STACK_MAX];
    int top = 0;

    if (first < w->bvh->block_count && ISA(any)(w, r, &w->bvh->blocks[first]))
        return first;
    stack[top++] = 0;
    while (top > 0) {
        const int32_t child = stack[--top];

        if (child >= 0) {
            const bvh_node *node = &w->bvh->nodes[child];
            float near[BVH_WIDTH];
            unsigned left = ISA(children)(r, w->begin, w->far, node, near);

            for (; left != 0; left &= left - 1)
                stack[top++] = node->child[lowest_bit(left)];
        } else if (ISA(any)(w, r, &w->bvh->blocks[~child])) {
            return (uint32_t)~child;
        }
    }
    return LCOR_BVH_NONE;
}

#undef INNER
