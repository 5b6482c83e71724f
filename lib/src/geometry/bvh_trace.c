/* SPDX-License-Identifier: MIT */
#include "base/cpu.h"
#include "base/internal.h"
#include "geometry/bvh_internal.h"
#include "geometry/vec.h"

#include <float.h>
#include <math.h>
#include <string.h>

#ifdef LCOR_HAVE_X86
#include <immintrin.h>
#endif

enum { STACK_MAX = (BVH_WIDTH - 1) * BVH_DEPTH_MAX + BVH_WIDTH };

/* Rays through a shared edge must meet one of the two primitives. */
static const double edge_slack = 1e-12;

/* Allowance of float distances, relative and in units of the frame. */
static const double far_part = 16 * (double)FLT_EPSILON, far_add = 64 * (double)FLT_EPSILON;

/* `in` and `out` are where a node's slabs begin by which the ray enters and leaves, axis by axis.
 */
typedef struct float_ray {
    float o[3], d[3], inverse[3];
    size_t in[3], out[3];
} float_ray;

/* A ray in the frame of the hierarchy, its direction's largest component 1. */
struct bvh_walker {
    const lcor_bvh *bvh;
    double origin[3], direction[3];
    double t_min, t_max;  /* along the scaled direction; t_max shrinks to the best hit */
    double factor, shift; /* walker's t = factor * ray's t - shift */
    float_ray ray;
    float before, from, below, far; /* before < t_min < from, below < t_max < far */
    float begin;                    /* `before`, but not below 0 */
    uint32_t skip;
    uint32_t pending; /* a sure hit, nearer than t_max, whose exact place is not yet known */
    int found;
    lcor_bvh_hit hit;
};

typedef struct bvh_walker walker;

static void set_far(walker *w)
{
    const double slack = fabs(w->t_max) * far_part + far_add;

    w->far = w->t_max + slack < (double)FLT_MAX ? (float)(w->t_max + slack) : FLT_MAX;
    w->below = w->t_max - slack < (double)FLT_MAX ? (float)(w->t_max - slack) : FLT_MAX;
}

/* Returns 0 if there is nothing to meet. */
static int start(walker *w, const lcor_bvh *bvh, const lcor_ray *ray)
{
    double largest = 0, inverse, over, distance2, slack;

    w->bvh = bvh;
    w->skip = ray->skip;
    w->found = 0;
    w->pending = LCOR_BVH_NONE;
    for (int k = 0; k < 3; k++) {
        w->origin[k] = (ray->origin[k] - bvh->centre[k]) * bvh->scale;
        w->direction[k] = ray->direction[k] * bvh->scale;
        largest = fabs(w->direction[k]) > largest ? fabs(w->direction[k]) : largest;
    }
    inverse = 1 / largest;
    for (int k = 0; k < 3; k++)
        w->direction[k] *= inverse;
    /* From far away, start near the scene, so that float coordinates stay small. */
    w->shift = 0;
    distance2 = vec_dot(w->origin, w->origin);
    if (distance2 > 16) {
        over = -vec_dot(w->origin, w->direction) / vec_dot(w->direction, w->direction) - 4;
        w->shift = over > 0 ? over : 0;
        vec_add_scaled(w->origin, w->shift, w->direction, w->origin);
    }
    w->factor = largest;
    w->t_min = ray->t_min * largest - w->shift;
    w->t_max = ray->t_max * largest - w->shift;
    for (int k = 0; k < 3; k++) {
        const float d = (float)w->direction[k];

        w->ray.o[k] = (float)w->origin[k];
        w->ray.d[k] = d;
        w->ray.inverse[k] = 1 / (fabsf(d) > 1e-12f ? d : copysignf(1e-12f, d));
        w->ray.in[k] = BVH_WIDTH * (2 * (size_t)k + (w->ray.inverse[k] < 0)); /* also of -0 */
        w->ray.out[k] = w->ray.in[k] ^ BVH_WIDTH;
    }
    slack = fabs(w->t_min) * far_part + far_add;
    w->before = (float)(w->t_min - slack);
    w->from = (float)(w->t_min + slack);
    w->begin = w->before > 0 ? w->before : 0;
    set_far(w);
    return bvh->node_count > 0 && w->t_min < w->t_max;
}

/* Decides in double whether primitive `index` is the nearest hit so far: first by t, since what the
 * float test leaves in doubt is most often the ray's own beginning. */
static int meet(walker *w, uint32_t index)
{
    const bvh_exact *p = &w->bvh->exact[index];
    double a[3], b[3], s[3], det, inverse, u, v, t;

    vec_sub(w->origin, p->origin, s);
    vec_cross(w->direction, p->edge_v, a);
    vec_cross(s, p->edge_u, b);
    det = vec_dot(p->edge_u, a);
    if (det == 0)
        return 0;
    inverse = 1 / det;
    t = vec_dot(p->edge_v, b) * inverse;
    if (!(t > w->t_min && t < w->t_max))
        return 0;
    u = vec_dot(s, a) * inverse;
    v = vec_dot(w->direction, b) * inverse;
    if (!(u >= -edge_slack && u <= 1 + edge_slack && v >= -edge_slack &&
          (p->parallelogram ? v : u + v) <= 1 + edge_slack))
        return 0;
    w->t_max = t;
    set_far(w);
    w->found = 1;
    w->hit = (lcor_bvh_hit){t, u, v, p->prim, p->owner};
    return 1;
}

/* Finds the exact place of a hit that is pending. */
static void settle(walker *w)
{
    if (w->pending != LCOR_BVH_NONE)
        (void)meet(w, w->pending);
    w->pending = LCOR_BVH_NONE;
}

/* What the float test knows of a block's primitives: t, how far within the edges it is met, and how
 * wrong either may be. */
typedef struct candidates {
    float t[BVH_BLOCK], depth[BVH_BLOCK], slack[BVH_BLOCK];
} candidates;

/* Whether it is met without doubt, and nearer than anything so far. */
static inline int is_sure(const walker *w, const candidates *c, unsigned i)
{
    const float doubt = 2 * c->slack[i];

    return c->depth[i] > doubt && c->t[i] > w->from + doubt && c->t[i] < w->below - doubt;
}

static inline void prefetch(const void *p)
{
#if defined(__GNUC__)
    __builtin_prefetch(p);
#else
    (void)p;
#endif
}

/* A child that waits, below the bits of how far away its box is: those of a float that is not
 * negative are in its order. */
typedef uint64_t entry;

static inline entry entry_of(const bvh_node *node, const float *near, unsigned i)
{
    uint32_t bits;

    memcpy(&bits, &near[i], sizeof bits);
    return (entry)bits << 32 | (uint32_t)node->child[i];
}

static inline int32_t entry_child(entry e) { return (int32_t)(uint32_t)e; }

static inline float entry_near(entry e)
{
    const uint32_t bits = (uint32_t)(e >> 32);
    float near;

    memcpy(&near, &bits, sizeof near);
    return near;
}

/* The nearer first. */
static inline void sort_entries(entry *a, entry *b)
{
    const entry least = *a < *b ? *a : *b, most = *a < *b ? *b : *a;

    *a = least;
    *b = most;
}

static inline unsigned lowest_bit(unsigned x)
{
#if defined(__GNUC__)
    return (unsigned)__builtin_ctz(x);
#else
    unsigned i = 0;

    for (; !(x & 1); x >>= 1)
        i++;
    return i;
#endif
}

/* One bit for each of n integers that is -1; the others are 0. */
#ifdef LCOR_HAVE_X86
static inline unsigned mask4_base(const int32_t *x)
{
    return (unsigned)_mm_movemask_ps(_mm_castsi128_ps(_mm_loadu_si128((const __m128i *)x)));
}

static inline unsigned mask8_base(const int32_t *x)
{
    return mask4_base(x) | mask4_base(x + 4) << 4;
}

static inline __attribute__((target("avx2"))) unsigned mask8_avx2(const int32_t *x)
{
    return (unsigned)_mm256_movemask_ps(
        _mm256_castsi256_ps(_mm256_loadu_si256((const __m256i *)x)));
}
#else
static inline unsigned mask4_base(const int32_t *x)
{
    unsigned bits = 0;

    for (unsigned i = 0; i < 4; i++)
        bits |= (unsigned)(x[i] != 0) << i;
    return bits;
}

static inline unsigned mask8_base(const int32_t *x)
{
    return mask4_base(x) | mask4_base(x + 4) << 4;
}
#endif

#define ISA(name) name##_base
#define TARGET
#define MASK8 mask8_base
#include "geometry/bvh_walk_template.h"
#undef ISA
#undef TARGET
#undef MASK8

#ifdef LCOR_HAVE_X86
#define ISA(name) name##_avx2
#define TARGET    __attribute__((target("avx2")))
#define MASK8     mask8_avx2
#include "geometry/bvh_walk_template.h"
#undef ISA
#undef TARGET
#undef MASK8
#endif

static const bvh_walk set_base = {"base", closest_base, occluded_base};
#ifdef LCOR_HAVE_X86
static const bvh_walk set_avx2 = {"avx2", closest_avx2, occluded_avx2};
#endif

const bvh_walk *bvh_walk_at(size_t index)
{
    const bvh_walk *found[2];
    size_t count = 0;

#ifdef LCOR_HAVE_X86
    if (lcor_internal_cpu().avx2)
        found[count++] = &set_avx2;
#endif
    found[count++] = &set_base;
    return index < count ? found[index] : NULL;
}

int lcor_bvh_closest(const lcor_bvh *bvh, const lcor_ray *ray, lcor_bvh_hit *hit)
{
    walker w;

    if (!start(&w, bvh, ray))
        return 0;
    bvh->walk->closest(&w);
    if (!w.found)
        return 0;
    *hit = w.hit;
    hit->t = (hit->t + w.shift) / w.factor;
    return 1;
}

int lcor_bvh_occluded(const lcor_bvh *bvh, const lcor_ray *ray, uint32_t *cache)
{
    uint32_t block = cache ? *cache : LCOR_BVH_NONE;
    walker w;

    if (!start(&w, bvh, ray))
        return 0;
    block = bvh->walk->occluded(&w, block);
    if (block != LCOR_BVH_NONE && cache)
        *cache = block;
    return block != LCOR_BVH_NONE;
}
