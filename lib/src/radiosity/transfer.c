/* SPDX-License-Identifier: MIT */
#include "radiosity/transfer.h"

#include "geometry/factor.h"
#include "geometry/vec.h"

#include <math.h>
#include <string.h>

enum { DEPTH_MAX = 64, CLIP_DEPTH_MAX = 8 };

static const double inv_pi = 0.31830988618379067154;

/* Seen from x, a line of the cell whose half is `e` is nearest where 1/r^2 has a pole at re +- i im
 * half lengths from its middle; of all lines parallel to it, the half of which across is `o`, the
 * nearest counts. `d`: from x to the cell's centre, in the plane; `height` off it. */
typedef struct pole {
    double re, im2, distance2;
} pole;

static pole find_pole(const double e[2], const double o[2], const double d[2], double height)
{
    const double length2 = e[0] * e[0] + e[1] * e[1], inv = 1 / length2;
    const double h = (e[0] * o[1] - e[1] * o[0]) * inv, reach = fabs(h);
    const double along = (d[0] * e[0] + d[1] * e[1]) * inv;
    const double across = (e[0] * d[1] - e[1] * d[0]) * inv;
    const double move = across > reach ? -reach : across < -reach ? reach : -across;
    const double shear = (o[0] * e[0] + o[1] * e[1]) * inv, rest = across + move;
    pole p;
    double out;

    p.re = fabs(along + (shear != 0 ? move * shear / h : 0));
    p.im2 = rest * rest + height * height * inv;
    out = p.re > 1 ? p.re - 1 : 0;
    p.distance2 = (out * out + p.im2) * length2;
    return p;
}

/* The cell's poles for either axis; of a triangle's trapezoids the middle lines stand for all.
 * Returns its area. */
static double find_poles(const transfer_frame *g, const face *f, const cell *c, pole p[2])
{
    const double s = c->s0 + 0.5 * c->hs, t = c->t0 + 0.5 * c->ht;
    const double line = f->line * (f->triangle ? s : 1);
    const double first[2] = {0.5 * c->hs * (f->u_along + (f->triangle ? t * f->line : 0)),
                             0.5 * c->hs * f->u_across};
    const double second[2] = {0.5 * c->ht * line, 0};
    const double d[2] = {s * f->u_along + t * line - g->along, s * f->u_across - g->across};

    p[0] = find_pole(first, second, d, g->height);
    p[1] = find_pole(second, first, d, g->height);
    return 4 * fabs(first[1] * second[0]);
}

static void set_frame(transfer_frame *g, const double x[3], const face *f)
{
    double d[3];

    vec_sub(x, f->origin, d);
    g->along = vec_dot(d, f->along);
    g->across = vec_dot(d, f->across);
    g->height = vec_dot(d, f->normal);
}

double transfer_ellipse(const double x[3], const face *f, const cell *c, double q[2])
{
    transfer_frame g;
    pole p[2];

    set_frame(&g, x, f);
    (void)find_poles(&g, f, c, p);
    for (int i = 0; i < 2; i++) {
        const double re = p[i].re, im2 = p[i].im2;
        const double a = 0.5 * (sqrt((re - 1) * (re - 1) + im2) + sqrt((re + 1) * (re + 1) + im2));

        q[i] = a > 1 ? a + sqrt(a * a - 1) : 1;
    }
    return fmin(p[0].distance2, p[1].distance2);
}

/* Whether x is so many of the cell's radii from its centre that the rule is accurate anyway. */
static int is_distant(const transfer *t, const cell *c)
{
    const transfer_frame *g = &t->frame;
    const face *f = t->f;
    const double s = c->s0 + 0.5 * c->hs, line = f->line * (f->triangle ? c->s0 + c->hs : 1);
    const double z = c->t0 + 0.5 * c->ht, mid = f->line * (f->triangle ? s : 1);
    const double along = s * f->u_along + z * mid - g->along;
    const double across = s * f->u_across - g->across;
    const double u = f->u_along + (f->triangle ? z * f->line : 0);
    const double radius = c->hs * sqrt(u * u + f->u_across * f->u_across) + c->ht * line;

    return along * along + across * across + g->height * g->height >
           0.25 * radius * radius * t->distant;
}

/* Whether the rule on this cell is as accurate as wanted; else *axis is the one to halve. Its error
 * is the form factor times q^-2p. The pole lies outside the ellipse of parameter Q, half axes A and
 * sqrt(A^2 - 1), if re^2 / A^2 + im^2 / (A^2 - 1) >= 1; with X = Q^2, A^2 = (X + 2 + 1/X) / 4. */
static int is_far(const transfer *t, const cell *c, int *axis)
{
    pole p[2];
    double area, d2, bound, x, a2, b2, out[2];

    if (is_distant(t, c))
        return 1;
    area = find_poles(&t->frame, t->f, c, p);
    d2 = p[0].distance2 < p[1].distance2 ? p[0].distance2 : p[1].distance2;
    bound = area * t->frame.height * inv_pi / (d2 * sqrt(d2) + 1e-300);
    bound = bound < 1 ? bound : 1;
    if (bound <= t->accuracy)
        return 1;
    x = sqrt(sqrt(bound / t->accuracy));
    a2 = 0.25 * (x + 1 / x) + 0.5;
    b2 = a2 - 1;
    for (int i = 0; i < 2; i++)
        out[i] = p[i].re * p[i].re * b2 + p[i].im2 * a2;
    if (out[0] >= a2 * b2 && out[1] >= a2 * b2)
        return 1;
    *axis = out[1] < 0.999 * out[0] ? 1 : 0; /* in what is symmetric, not by rounding */
    return 0;
}

/* Gauss quadrature of a cell that is seen as a whole: the inner loop. Lengths are in units of the
 * cell's size, so that floats suffice whatever the scene's unit. On the line of node a, the point
 * of node b lies at p[a] + r[a] x_b along it, its squared distance from x but for that is q[a], its
 * height above x's plane n[a] + m[a] x_b; all of these are linear in s or squares. */
static void whole(const transfer *t, const cell *c, float weights[RULE_Q])
{
    static const float at[RULE_P] = {0.0694318442F, 0.3300094782F, 0.6699905218F, 0.9305681558F};
    static const float w[RULE_P] = {0.1739274226F, 0.3260725774F, 0.3260725774F, 0.1739274226F};
    const transfer_frame *g = &t->frame;
    const face *f = t->f;
    const double tip = f->triangle ? 1 : 0; /* lines shrink towards s = 0 */
    const double size = c->hs * (fabs(f->u_along) + fabs(f->u_across)) + c->ht * f->line;
    const double unit = 1 / size, line = f->line * unit, height = g->height * unit;
    const double begin = tip != 0 ? c->s0 : 1,
                 grow = tip * c->hs; /* length of lines: at s0, more */
    const double p1 = c->hs * (f->u_along * unit + tip * c->t0 * line);
    const double p0 = (c->s0 * f->u_along - g->along) * unit + begin * c->t0 * line;
    const double q0 = (c->s0 * f->u_across - g->across) * unit, q1 = c->hs * f->u_across * unit;
    const double step = c->ht * line,
                 k = f->jacobian * c->hs * c->ht * unit * unit * height * inv_pi;
    const float fp0 = (float)p0, fp1 = (float)p1, fq0 = (float)q0, fq1 = (float)q1;
    const float fr0 = (float)(begin * step), fr1 = (float)(grow * step),
                h2 = (float)(height * height);
    const float fn0 = (float)(g->n_along * p0 + g->n_across * q0 - g->n_height * height);
    const float fn1 = (float)(g->n_along * p1 + g->n_across * q1), na = (float)g->n_along;
    const float fk0 = (float)(k * begin), fk1 = (float)(k * grow);
    float p[RULE_P], q[RULE_P], r[RULE_P], n[RULE_P], m[RULE_P], scale[RULE_P];

    for (int a = 0; a < RULE_P; a++) {
        const float across = fq0 + fq1 * at[a];

        p[a] = fp0 + fp1 * at[a];
        r[a] = fr0 + fr1 * at[a];
        q[a] = across * across + h2;
        n[a] = fn0 + fn1 * at[a];
        m[a] = na * r[a];
        scale[a] = (fk0 + fk1 * at[a]) * w[a];
    }
    for (int a = 0; a < RULE_P; a++)
        for (int b = 0; b < RULE_P; b++) {
            const float along = p[a] + r[a] * at[b], r2 = along * along + q[a];
            const float cosine = n[a] + m[a] * at[b];

            weights[a * RULE_P + b] = scale[a] * w[b] * (cosine > 0 ? cosine : 0) / (r2 * r2);
        }
}

/* Adds `sign` times the integral over a triangle inside the cell. */
static void add_triangle(const transfer *t, const cell *c, double sign, const double p[3],
                         const double q[3], const double r[3], float weights[RULE_Q])
{
    const face *f = t->f;
    double a[3], b[3], cross[3], area2;

    vec_sub(q, p, a);
    vec_sub(r, q, b);
    vec_cross(a, b, cross);
    area2 = sign * vec_length(cross) * t->frame.height * inv_pi;
    for (int i = 0; i < RULE_P; i++)
        for (int j = 0; j < RULE_P; j++) {
            double y[3], d[3], s, z, at_s[RULE_P], at_t[RULE_P], r2, cosine, value;

            vec_plane_point(p, a, b, rule_x[i], rule_x[i] * rule_x[j], y);
            vec_sub(y, t->x, d);
            r2 = vec_dot(d, d);
            cosine = vec_dot(d, t->normal);
            if (!(cosine > 0))
                continue;
            value = area2 * rule_x[i] * rule_w[i] * rule_w[j] * cosine / (r2 * r2);
            face_coordinates(f, y, &s, &z);
            rule_values((s - c->s0) / c->hs, at_s);
            rule_values((z - c->t0) / c->ht, at_t);
            for (int k = 0; k < RULE_Q; k++)
                weights[k] += (float)(value * at_s[k / RULE_P] * at_t[k % RULE_P]);
        }
}

static double set_factor(const transfer *t, const visible_set *set)
{
    double sum = 0;

    for (int i = 0; i < set->count; i++)
        sum += set->pieces[i].sign *
               lcor_factor_point(t->x, t->normal, (size_t)set->pieces[i].n, set->pieces[i].p[0]);
    return fmax(sum, 0);
}

/* Weights of what is seen of a cell on which the kernel is smooth. Returns -1 if it should be split
 * after all, else the exact factor. */
static double clipped_cell(const transfer *t, const cell *c, int depth, float weights[RULE_Q])
{
    double corners[4][3];
    visible_set set;

    face_cell_corners(t->f, c, corners);
    if (!sight_cell(&t->sight, corners, t->x, t->normal, &set)) {
        if (depth < CLIP_DEPTH_MAX)
            return -1;
        (void)visible_start(&set, sight_centre_blocked(&t->sight, c) ? 0 : 4, corners[0]);
    }
    memset(weights, 0, RULE_Q * sizeof *weights);
    for (int i = 0; i < set.count; i++) {
        const visible_piece *piece = &set.pieces[i];

        if (i == 0 && piece->n == 4 && memcmp(piece->p, corners, sizeof corners) == 0)
            whole(t, c, weights);
        else
            for (int j = 1; j + 1 < piece->n; j++)
                add_triangle(t, c, piece->sign, piece->p[0], piece->p[j], piece->p[j + 1], weights);
    }
    return set_factor(t, &set);
}

/* Virtual splitting: the sender keeps its nodes, but cells too near are halved, and the weights of
 * the halves are folded back onto the whole. */
static double near_cell(const transfer *t, const cell *c, int clipped, int depth,
                        float weights[RULE_Q])
{
    double exact = -1;
    int axis = depth % 2;

    if (depth >= DEPTH_MAX || is_far(t, c, &axis)) {
        if (clipped)
            exact = clipped_cell(t, c, depth, weights);
        else
            exact = (whole(t, c, weights), 0);
    }
    if (exact < 0) {
        float part[RULE_Q];
        cell half = *c;

        exact = 0;
        memset(weights, 0, RULE_Q * sizeof *weights);
        half.hs *= axis == 0 ? 0.5 : 1;
        half.ht *= axis == 1 ? 0.5 : 1;
        for (int i = 0; i < 2; i++) {
            half.s0 = c->s0 + (axis == 0 ? i * half.hs : 0);
            half.t0 = c->t0 + (axis == 1 ? i * half.ht : 0);
            exact += near_cell(t, &half, clipped, depth + 1, part);
            rule_fold_float(axis, i, part, weights);
        }
    }
    return exact;
}

void transfer_aim(transfer *t, const lcor_scene *scene, const double x[3], const double normal[3],
                  const face *f, const uint32_t *blockers, size_t count, double accuracy)
{
    visible_eye eye = {{0, 0, 0}, 0};
    double q;

    t->x = x;
    t->normal = normal;
    t->f = f;
    t->accuracy = accuracy;
    q = sqrt(sqrt(sqrt(1 / accuracy)));
    t->distant = (1 + 0.5 * (q - 1 / q)) * (1 + 0.5 * (q - 1 / q));
    set_frame(&t->frame, x, f);
    t->frame.n_along = vec_dot(normal, f->along);
    t->frame.n_across = vec_dot(normal, f->across);
    t->frame.n_height = vec_dot(normal, f->normal);
    vec_copy(x, eye.at);
    sight_aim(&t->sight, scene, &eye, f, blockers, count);
}

/* -1 nothing of the cell is in front of x and facing it, 0 all of it is, 1 some. */
static int horizon(const transfer *t, double (*corners)[3])
{
    const double touch = SCENE_TOUCH * t->sight.scene->diameter;
    int below = 0, above = 0;
    double d[3], h;

    if (t->frame.height <= 0)
        return -1;
    for (int i = 0; i < 4; i++) {
        vec_sub(corners[i], t->x, d);
        h = vec_dot(d, t->normal);
        below |= h < -touch;
        above |= h > touch;
    }
    return above ? below : -1;
}

double transfer_weights(const transfer *t, const cell *c, double known, float weights[RULE_Q])
{
    const int hidden = t->sight.count > 0 || t->sight.crowded;
    double corners[4][3], exact;
    float sum = 0;
    int side = t->frame.height > 0 ? 0 : -1;

    if (known < 0 && side == 0) {
        face_cell_corners(t->f, c, corners);
        side = horizon(t, corners);
    }
    if (side < 0) {
        memset(weights, 0, RULE_Q * sizeof *weights);
        return 0;
    }
    exact = near_cell(t, c, hidden || side, 0, weights);
    if (known >= 0)
        exact = known;
    else if (!hidden && !side)
        exact = lcor_factor_point(t->x, t->normal, 4, corners[0]);
    for (int k = 0; k < RULE_Q; k++)
        sum += weights[k];
    if (sum > 0 && exact < 4 * (double)sum) {
        const float scale = (float)(exact / (double)sum);

        for (int k = 0; k < RULE_Q; k++)
            weights[k] *= scale;
    }
    return exact;
}

double transfer_factor(const transfer *t, const cell *c)
{
    visible_set set;
    double corners[4][3];

    face_cell_corners(t->f, c, corners);
    if (horizon(t, corners) < 0)
        return 0;
    if (t->sight.count == 0 && !t->sight.crowded)
        return lcor_factor_point(t->x, t->normal, 4, corners[0]);
    if (!sight_cell(&t->sight, corners, t->x, t->normal, &set))
        return sight_centre_blocked(&t->sight, c)
                   ? 0
                   : lcor_factor_point(t->x, t->normal, 4, corners[0]);
    return set_factor(t, &set);
}

int transfer_factors(const lcor_scene *scene, const face *r, size_t n, double (*points)[3],
                     const face *f, const cell *c, double *factors)
{
    const double touch = SCENE_TOUCH * scene->diameter;
    double corners[4][3], x[3][TRANSFER_POINTS], d[3];

    face_cell_corners(f, c, corners);
    for (int i = 0; i < 4; i++) {
        vec_sub(corners[i], r->origin, d);
        if (vec_dot(d, r->normal) < -touch)
            return 0;
    }
    for (size_t i = 0; i < n; i++)
        for (int k = 0; k < 3; k++)
            x[k][i] = points[i][k];
    lcor_factor_points(n, x[0], x[1], x[2], r->normal, (const double(*)[3])corners, factors);
    for (size_t i = 0; i < n; i++) {
        vec_sub(points[i], f->origin, d);
        if (vec_dot(d, f->normal) <= 0)
            factors[i] = 0;
    }
    return 1;
}
