/* SPDX-License-Identifier: MIT */
#include "radiosity/transfer.h"

#include "base/internal.h"
#include "geometry/factor.h"
#include "geometry/vec.h"

#include <math.h>
#include <string.h>

enum { DEPTH_MAX = 64, CLIP_DEPTH_MAX = 8, LANES = TRANSFER_LANES };

static const double inv_pi = 0.31830988618379067154;

typedef unsigned lanes; /* bit i: point i */

/* A cell as the points see it, in units of its size, so that floats suffice whatever the scene's
 * unit. */
typedef struct cell_view {
    double unit;                       /* 1 / size */
    float first[2], second;            /* halves of its middle lines: along and across, and along */
    float along[LANES], across[LANES]; /* from the points to its centre, in its plane */
    float height[LANES];               /* of the points above its plane, at least 0 */
    float cosine[LANES];               /* of the centre's direction, times its distance */
} cell_view;

static LCOR_INLINE void set_view(const transfer_frame *g, const face *f, const cell *c,
                                 cell_view *v)
{
    const double s = c->s0 + 0.5 * c->hs, t = c->t0 + 0.5 * c->ht;
    const double line = f->line * (f->triangle ? s : 1);
    const double first = c->hs * (f->u_along + (f->triangle ? t * f->line : 0));
    const double across = c->hs * f->u_across, second = c->ht * line;
    const double unit = 1 / (fabs(first) + fabs(across) + second);

    v->unit = unit;
    v->first[0] = (float)(0.5 * first * unit);
    v->first[1] = (float)(0.5 * across * unit);
    v->second = (float)(0.5 * second * unit);
    for (int i = 0; i < LANES; i++) {
        const double x = (s * f->u_along + t * line - g->along[i]) * unit;
        const double y = (s * f->u_across - g->across[i]) * unit, z = g->height[i] * unit;

        v->along[i] = (float)x;
        v->across[i] = (float)y;
        v->height[i] = (float)(z > 0 ? z : 0);
        v->cosine[i] = (float)(g->n_along * x + g->n_across * y - g->n_height * z);
    }
}

/* Seen from a point, a line of the cell is nearest where 1/r^2 has a pole at re +- i im half
 * lengths from its middle; of all lines parallel to it, the nearest counts. Of a triangle's
 * trapezoids the middle lines stand for all. First all points for the first axis, then for the
 * second: long loops become SIMD. */
typedef struct poles {
    float re2[2 * LANES], im2[2 * LANES], distance2[2 * LANES], height[2 * LANES];
} poles;

static LCOR_INLINE void find_poles(const cell_view *v, poles *p)
{
    const float half[2][2] = {{v->first[0], v->first[1]}, {v->second, 0}};
    float x[2 * LANES], y[2 * LANES], *z = p->height, e0[2 * LANES], e1[2 * LANES];
    float length2[2 * LANES], reach[2 * LANES], slope[2 * LANES];

    for (int axis = 0; axis < 2; axis++) {
        const float *e = half[axis], *o = half[1 - axis];
        const float squared = e[0] * e[0] + e[1] * e[1], turn = e[0] * o[1] - e[1] * o[0];
        const float shear = o[0] * e[0] + o[1] * e[1];

        for (int i = 0; i < LANES; i++) {
            const int k = axis * LANES + i;

            x[k] = v->along[i];
            y[k] = v->across[i];
            z[k] = v->height[i];
            e0[k] = e[0] / squared;
            e1[k] = e[1] / squared;
            length2[k] = squared;
            reach[k] = fabsf(turn) / squared;
            slope[k] = shear != 0 ? shear / turn : 0;
        }
    }
    for (int k = 0; k < 2 * LANES; k++) {
        const float along = x[k] * e0[k] + y[k] * e1[k], across = y[k] * e0[k] - x[k] * e1[k];
        const float low = across < reach[k] ? across : reach[k];
        const float move = low > -reach[k] ? -low : reach[k];
        const float rest = across + move, re = fabsf(along + move * slope[k]);
        const float out = re > 1 ? re - 1 : 0;

        p->re2[k] = re * re;
        p->im2[k] = rest * rest + z[k] * z[k] / length2[k];
        p->distance2[k] = (out * out + p->im2[k]) * length2[k];
    }
}

static void set_lane(transfer_frame *g, int lane, const double x[3], const face *f)
{
    double d[3];

    vec_sub(x, f->origin, d);
    g->along[lane] = vec_dot(d, f->along);
    g->across[lane] = vec_dot(d, f->across);
    g->height[lane] = vec_dot(d, f->normal);
}

/* One point in all lanes. */
static void set_frame(transfer_frame *g, const double x[3], const face *f)
{
    set_lane(g, 0, x, f);
    for (int i = 1; i < LANES; i++) {
        g->along[i] = g->along[0];
        g->across[i] = g->across[0];
        g->height[i] = g->height[0];
    }
}

/* The poles that the points of a frame, on either side, see on a cell. Returns its unit. */
static double poles_of(transfer_frame *g, const face *f, const cell *c, poles *p)
{
    cell_view v;

    g->n_along = g->n_across = g->n_height = 0;
    for (int i = 0; i < LANES; i++)
        g->height[i] = fabs(g->height[i]);
    set_view(g, f, c, &v);
    find_poles(&v, p);
    return v.unit;
}

static double ellipse_through(const poles *p, size_t k)
{
    const double re = sqrt((double)p->re2[k]), im2 = (double)p->im2[k];
    const double a = 0.5 * (sqrt((re - 1) * (re - 1) + im2) + sqrt((re + 1) * (re + 1) + im2));

    return a > 1 ? a + sqrt(a * a - 1) : 1;
}

double transfer_ellipse(const double x[3], const face *f, const cell *c, double q[2])
{
    transfer_frame g;
    double unit;
    poles p;

    set_frame(&g, x, f);
    unit = poles_of(&g, f, c, &p);
    q[0] = ellipse_through(&p, 0);
    q[1] = ellipse_through(&p, LANES);
    return (double)fminf(p.distance2[0], p.distance2[LANES]) / (unit * unit);
}

void transfer_ellipses(double (*x)[3], const face *f, const cell *c, double *q, double *distance2)
{
    transfer_frame g;
    double unit;
    poles p;

    for (int i = 0; i < LANES; i++)
        set_lane(&g, i, x[i], f);
    unit = poles_of(&g, f, c, &p);
    for (size_t i = 0; i < LANES; i++) {
        q[i] = fmin(ellipse_through(&p, i), ellipse_through(&p, LANES + i));
        distance2[i] = (double)fminf(p.distance2[i], p.distance2[LANES + i]) / (unit * unit);
    }
}

/* Whether all points are so many of the cell's radii from its centre that the rule is accurate. */
static LCOR_INLINE int all_distant(const transfer *t, const cell_view *v)
{
    const float radius = sqrtf(v->first[0] * v->first[0] + v->first[1] * v->first[1]) + v->second;
    const float limit = radius * radius * (float)t->distant;
    int distant = 1;

    for (int i = 0; i < LANES; i++)
        distant &=
            v->along[i] * v->along[i] + v->across[i] * v->across[i] + v->height[i] * v->height[i] >
            limit;
    return distant;
}

/* The points for which the rule on this cell is as accurate as wanted; for the others *axis is the
 * one to halve. The error is the form factor times q^-2p. The pole lies outside the ellipse of
 * parameter Q, half axes A and sqrt(A^2 - 1), if re^2 / A^2 + im^2 / (A^2 - 1) >= 1; with X = Q^2,
 * A^2 = (X + 2 + 1/X) / 4. */
static LCOR_INLINE lanes find_far(const transfer *t, const cell_view *v, lanes points, int *axis)
{
    const float area = 4 * fabsf(v->first[1] * v->second) * (float)inv_pi;
    const float wanted = 1 / (float)t->accuracy;
    float missing[2 * LANES], most[2] = {0, 0};
    lanes far = 0;
    poles p;

    if (all_distant(t, v))
        return points;
    find_poles(v, &p);
    for (int k = 0; k < 2 * LANES; k++) {
        const float d2 = p.distance2[k] + 1e-20F;
        const float bound = area * p.height[k] / (d2 * sqrtf(d2));
        const float worse = (bound < 1 ? bound : 1) * wanted;
        const float x = sqrtf(sqrtf(worse > 1 ? worse : 1));
        const float a2 = 0.25F * (x + 1 / x) + 0.5F, b2 = a2 - 1;

        missing[k] = a2 * b2 - p.re2[k] * b2 - p.im2[k] * a2;
    }
    for (int i = 0; i < LANES; i++) {
        const float m0 = missing[i], m1 = missing[LANES + i];

        if (!(points & 1U << i))
            continue;
        far |= m0 <= 0 && m1 <= 0 ? 1U << i : 0;
        most[0] = m0 > most[0] ? m0 : most[0];
        most[1] = m1 > most[1] ? m1 : most[1];
    }
    if (far != points)
        *axis = most[1] > 1.001F * most[0] ? 1 : 0; /* in what is symmetric, not by rounding */
    return far;
}

/* clang-format off */
#define ROWS(a, b, c, d) {a, a, a, a, b, b, b, b, c, c, c, c, d, d, d, d}
#define COLUMNS(a, b, c, d) {a, b, c, d, a, b, c, d, a, b, c, d, a, b, c, d}
/* clang-format on */
static const float node_s[RULE_Q] =
    ROWS(0.0694318442F, 0.3300094782F, 0.6699905218F, 0.9305681558F);
static const float node_t[RULE_Q] =
    COLUMNS(0.0694318442F, 0.3300094782F, 0.6699905218F, 0.9305681558F);
static const float node_ws[RULE_Q] =
    ROWS(0.1739274226F, 0.3260725774F, 0.3260725774F, 0.1739274226F);
static const float node_wt[RULE_Q] =
    COLUMNS(0.1739274226F, 0.3260725774F, 0.3260725774F, 0.1739274226F);

/* Gauss quadrature of a cell that is seen as a whole, but for the height over pi: the inner loop.
 */
static LCOR_INLINE void whole(const transfer *t, const cell *c, const cell_view *v, lanes points,
                              float weights[][RULE_Q])
{
    const face *f = t->f;
    const float na = (float)t->frame.n_along, nc = (float)t->frame.n_across;
    const float scale = (float)(f->jacobian * c->hs * c->ht * v->unit * v->unit * v->unit);
    const float line = (float)(c->ht * f->line * v->unit), u0 = v->first[0], u1 = v->first[1];
    const float begin = f->triangle ? (float)c->s0 : 1, grow = f->triangle ? (float)c->hs : 0;
    float x[RULE_Q], y[RULE_Q], rise[RULE_Q], share[RULE_Q]; /* nodes, from the centre */

    for (int k = 0; k < RULE_Q; k++) {
        const float offset = 2 * node_s[k] - 1, shrink = begin + grow * node_s[k];

        x[k] = offset * u0 + (node_t[k] - 0.5F) * line * shrink;
        y[k] = offset * u1;
        rise[k] = na * x[k] + nc * y[k];
        share[k] = scale * shrink * node_ws[k] * node_wt[k];
    }
    for (int i = 0; i < LANES; i++) {
        const float along = v->along[i], across = v->across[i], cosine = v->cosine[i];
        const float height2 = v->height[i] * v->height[i];
        float *out = weights[i];

        if (!(points & 1U << i))
            continue;
        for (int k = 0; k < RULE_Q; k++) {
            const float dx = along + x[k], dy = across + y[k], r2 = dx * dx + dy * dy + height2;
            const float rises = cosine + rise[k];

            out[k] = share[k] * (rises > 0 ? rises : 0) / (r2 * r2);
        }
    }
}

/* Values of the polynomials along one axis at x, those at one place together. */
static LCOR_INLINE void node_values(const float x[RULE_Q], float values[RULE_Q][RULE_P])
{
    static const float outer = 7.42054007F, inner = 18.7954494F; /* 1 / products of distances */

    for (int k = 0; k < RULE_Q; k++) {
        const float d0 = x[k] - node_t[0], d1 = x[k] - node_t[1];
        const float d2 = x[k] - node_t[2], d3 = x[k] - node_t[3];

        values[k][0] = -outer * d1 * d2 * d3;
        values[k][1] = inner * d0 * d2 * d3;
        values[k][2] = -inner * d0 * d1 * d3;
        values[k][3] = outer * d0 * d1 * d2;
    }
}

/* Adds `sign` times the integral over a triangle p + s (a + t b) inside the cell, but for the
 * height over pi. */
static LCOR_INLINE void add_triangle(const transfer *t, const cell *c, double sign,
                                     const double p[3], const double q[3], const double r[3],
                                     float weights[][RULE_Q])
{
    const face *f = t->f;
    double a[3], b[3], d[3], o[3], cross[3], first[3], second[3], area2;
    float x[RULE_Q], y[RULE_Q], value[RULE_Q], at_s[RULE_Q][RULE_P], at_t[RULE_Q][RULE_P];

    vec_sub(q, p, a);
    vec_sub(r, q, b);
    vec_sub(p, t->x, d);
    vec_sub(p, f->origin, o);
    vec_cross(a, b, cross);
    area2 = sign * vec_length(cross);
    first[0] = vec_dot(o, f->dual_u);
    first[1] = vec_dot(a, f->dual_u);
    first[2] = vec_dot(b, f->dual_u);
    second[0] = vec_dot(o, f->dual_v);
    second[1] = vec_dot(a, f->dual_v);
    second[2] = vec_dot(b, f->dual_v);
    for (int k = 0; k < RULE_Q; k++) {
        const double s = (double)node_s[k], z = s * (double)node_t[k];
        const double dx = d[0] + s * a[0] + z * b[0], dy = d[1] + s * a[1] + z * b[1],
                     dz = d[2] + s * a[2] + z * b[2], r2 = dx * dx + dy * dy + dz * dz;
        const double cosine = dx * t->normal[0] + dy * t->normal[1] + dz * t->normal[2];
        const double u = first[0] + s * first[1] + z * first[2];
        const double v = second[0] + s * second[1] + z * second[2], sum = u + v;
        const double along = f->triangle ? sum : u;
        /* Rounding leaves little of u and v at the triangle's tip: their ratio stays in 0..1. */
        const double across = !f->triangle ? v : v >= sum ? 1 : v > 0 ? v / sum : 0;

        x[k] = (float)((along - c->s0) / c->hs);
        y[k] = (float)((across - c->t0) / c->ht);
        value[k] = (float)(area2 * s * (double)(node_ws[k] * node_wt[k]) *
                           (cosine > 0 ? cosine : 0) / (r2 * r2));
    }
    node_values(x, at_s);
    node_values(y, at_t);
    for (size_t i = 0; i < RULE_P; i++) { /* four sums at a time become one vector */
        float *out = weights[0] + i * RULE_P, s0 = 0, s1 = 0, s2 = 0, s3 = 0;

        for (int k = 0; k < RULE_Q; k++) {
            const float part = value[k] * at_s[k][i];

            s0 += part * at_t[k][0];
            s1 += part * at_t[k][1];
            s2 += part * at_t[k][2];
            s3 += part * at_t[k][3];
        }
        out[0] += s0;
        out[1] += s1;
        out[2] += s2;
        out[3] += s3;
    }
}

/* Weights of what the only point sees of a cell on which the kernel is smooth. Returns 0 if it
 * should be split after all. */
static LCOR_INLINE int clipped_cell(const transfer *t, const cell *c, const cell_view *v, int depth,
                                    float weights[][RULE_Q])
{
    double corners[4][3];
    visible_set set;

    face_cell_corners(t->f, c, corners);
    if (!sight_cell(&t->sight, corners, t->x, t->normal, SIGHT_SMALLER, &set)) {
        if (depth < CLIP_DEPTH_MAX)
            return 0;
        (void)visible_start(&set, sight_centre_blocked(&t->sight, c) ? 0 : 4, corners[0]);
    }
    memset(weights, 0, sizeof *weights);
    for (int i = 0; i < set.count; i++) {
        const visible_piece *piece = &set.pieces[i];

        if (i == 0 && visible_is(piece, 4, corners[0]))
            whole(t, c, v, 1, weights);
        else
            for (int j = 1; j + 1 < piece->n; j++)
                add_triangle(t, c, piece->sign, piece->p[0], piece->p[j], piece->p[j + 1], weights);
    }
    return 1;
}

typedef void near_field(const transfer *t, const cell *c, lanes points, int clipped, int depth,
                        float weights[][RULE_Q]);

/* Virtual splitting: the sender keeps its nodes, but cells too near for some points are halved for
 * these, and the weights of the halves are folded back onto the whole. */
static LCOR_INLINE void near_cell(const transfer *t, const cell *c, lanes points, int clipped,
                                  int depth, float weights[][RULE_Q], near_field *of_half)
{
    float part[LANES][RULE_Q];
    cell half = *c;
    cell_view v;
    lanes far;
    int axis = depth % 2;

    set_view(&t->frame, t->f, c, &v);
    far = depth >= DEPTH_MAX ? points : find_far(t, &v, points, &axis);
    if (far && clipped)
        far = clipped_cell(t, c, &v, depth, weights) ? far : 0;
    else if (far)
        whole(t, c, &v, far, weights);
    points &= ~far;
    if (!points)
        return;
    for (int k = 0; k < LANES; k++)
        if (points & 1U << k)
            memset(weights[k], 0, sizeof weights[k]);
    half.hs *= axis == 0 ? 0.5 : 1;
    half.ht *= axis == 1 ? 0.5 : 1;
    for (int i = 0; i < 2; i++) {
        half.s0 = c->s0 + (axis == 0 ? i * half.hs : 0);
        half.t0 = c->t0 + (axis == 1 ? i * half.ht : 0);
        of_half(t, &half, points, clipped, depth + 1, part);
        for (int k = 0; k < LANES; k++)
            if (points & 1U << k)
                rule_fold_float(axis, i, part[k], weights[k]);
    }
}

static void near_base(const transfer *t, const cell *c, lanes points, int clipped, int depth,
                      float weights[][RULE_Q])
{
    near_cell(t, c, points, clipped, depth, weights, near_base);
}

#ifdef LCOR_HAVE_X86
static __attribute__((target("avx2"))) void near_avx2(const transfer *t, const cell *c,
                                                      lanes points, int clipped, int depth,
                                                      float weights[][RULE_Q])
{
    near_cell(t, c, points, clipped, depth, weights, near_avx2);
}
#endif

/* The fastest for this machine; all give the same bits. */
static near_field *near_for(lcor_cpu cpu)
{
#ifdef LCOR_HAVE_X86
    if (cpu.avx2)
        return near_avx2;
#endif
    (void)cpu;
    return near_base;
}

/* What does not depend on the points' number; the frame's lanes are the caller's. */
static void set_target(transfer *t, const double normal[3], const face *f, double accuracy)
{
    const double q = sqrt(sqrt(sqrt(1 / accuracy)));

    t->normal = normal;
    t->f = f;
    t->accuracy = accuracy;
    t->distant = (1 + 0.5 * (q - 1 / q)) * (1 + 0.5 * (q - 1 / q));
    t->frame.n_along = vec_dot(normal, f->along);
    t->frame.n_across = vec_dot(normal, f->across);
    t->frame.n_height = vec_dot(normal, f->normal);
}

void transfer_target(transfer *t, const lcor_scene *scene, const double normal[3], const face *f,
                     const uint32_t *blockers, size_t count, double accuracy)
{
    set_target(t, normal, f, accuracy);
    sight_target(&t->sight, scene, f, blockers, count);
}

void transfer_aim(transfer *t, const double x[3])
{
    visible_eye eye = {{0, 0, 0}, 0};

    t->x = x;
    set_frame(&t->frame, x, t->f);
    vec_copy(x, eye.at);
    sight_aim(&t->sight, &eye);
}

/* Scales a point's weights, known but for the height over pi, to its exact factor. Behind the face
 * it gets nothing. */
static void scale_row(double height, double exact, float weights[RULE_Q])
{
    const double factor = height > 0 ? height * inv_pi : 0;
    float sums[4] = {0, 0, 0, 0}, sum, scale; /* four at a time become one vector */

    for (int k = 0; k < RULE_Q; k += 4)
        for (int i = 0; i < 4; i++)
            sums[i] += weights[k + i];
    sum = (sums[0] + sums[1]) + (sums[2] + sums[3]);
    scale = (float)(sum > 0 && exact < 4 * (double)sum * factor ? exact / (double)sum : factor);
    for (int k = 0; k < RULE_Q; k++)
        weights[k] *= scale;
}

/* Whether a cell reaches below the horizon that points of a plane have. */
static int is_cut(const transfer *t, const double x[3], double (*corners)[3])
{
    const double lowest = vec_dot(x, t->normal) - SCENE_TOUCH * t->sight.scene->diameter;
    int below = 0;

    for (int i = 0; i < 4; i++)
        below |= vec_dot(corners[i], t->normal) < lowest;
    return below;
}

int transfer_is_open(const transfer *t, const double x[3], const cell *c)
{
    double corners[4][3];

    face_cell_corners(t->f, c, corners);
    return t->sight.blocker_count == 0 && !is_cut(t, x, corners);
}

void transfer_weights(const transfer *t, const cell *c, double exact, float weights[RULE_Q])
{
    float rows[1][RULE_Q];
    double corners[4][3];
    int clipped;

    if (!(exact > 0)) {
        memset(weights, 0, RULE_Q * sizeof *weights);
        return;
    }
    face_cell_corners(t->f, c, corners);
    clipped = is_cut(t, t->x, corners) || !sight_clear(&t->sight, corners);
    near_for(t->sight.scene->cpu)(t, c, 1, clipped, 0, rows);
    scale_row(t->frame.height[0], exact, rows[0]);
    memcpy(weights, rows, sizeof rows);
}

void transfer_open(const lcor_scene *scene, double (*x)[3], const double normal[3], const face *f,
                   const cell *c, double accuracy, const double *exact, float (*weights)[RULE_Q])
{
    transfer t;

    set_target(&t, normal, f, accuracy);
    for (int i = 0; i < LANES; i++)
        set_lane(&t.frame, i, x[i], f);
    near_for(scene->cpu)(&t, c, (1U << LANES) - 1, 0, 0, weights);
    for (int i = 0; i < LANES; i++)
        scale_row(t.frame.height[i], exact[i], weights[i]);
}

/* Exact form factor of what is seen of a cell; `all` is that of all of it if it is known and no
 * horizon cuts it, else negative. */
static double seen_factor(const transfer *t, const cell *c, double all, int depth)
{
    visible_set set;
    double corners[4][3], sum = 0;

    face_cell_corners(t->f, c, corners);
    if (!sight_cell(&t->sight, corners, t->x, all < 0 ? t->normal : NULL, 1, &set)) {
        if (depth < CLIP_DEPTH_MAX) {
            cell half = *c;

            half.hs *= depth % 2 == 0 ? 0.5 : 1;
            half.ht *= depth % 2 == 1 ? 0.5 : 1;
            sum = seen_factor(t, &half, -1, depth + 1);
            half.s0 += depth % 2 == 0 ? half.hs : 0;
            half.t0 += depth % 2 == 1 ? half.ht : 0;
            return sum + seen_factor(t, &half, -1, depth + 1);
        }
        (void)visible_start(&set, sight_centre_blocked(&t->sight, c) ? 0 : 4, corners[0]);
    }
    for (int i = 0; i < set.count; i++) {
        const visible_piece *piece = &set.pieces[i];

        if (i == 0 && all >= 0 && visible_is(piece, 4, corners[0]))
            sum += all;
        else
            sum += piece->sign * lcor_factor_point(t->x, t->normal, (size_t)piece->n, piece->p[0]);
    }
    return fmax(sum, 0);
}

double transfer_factor(const transfer *t, const cell *c)
{
    return t->frame.height[0] > 0 ? seen_factor(t, c, -1, 0) : 0;
}

void transfer_factors(transfer *t, size_t n, double (*points)[3], const cell *c, double *factors)
{
    const lcor_scene *scene = t->sight.scene;
    double corners[4][3], x[3][TRANSFER_POINTS], d[3];
    int cut;

    face_cell_corners(t->f, c, corners);
    cut = is_cut(t, points[0], corners);
    for (size_t i = 0; i < n; i++)
        for (int k = 0; k < 3; k++)
            x[k][i] = points[i][k];
    if (!cut)
        scene->factor_points(n, x[0], x[1], x[2], t->normal, (const double(*)[3])corners, factors);
    for (size_t i = 0; i < n; i++) {
        vec_sub(points[i], t->f->origin, d);
        if (!(vec_dot(d, t->f->normal) > 0)) {
            factors[i] = 0;
        } else if (cut || t->sight.blocker_count > 0) {
            transfer_aim(t, points[i]);
            factors[i] = seen_factor(t, c, cut ? -1 : factors[i], 0);
        }
    }
}
