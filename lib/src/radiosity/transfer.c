/* SPDX-License-Identifier: MIT */
#include "radiosity/transfer.h"

#include "geometry/factor.h"
#include "geometry/vec.h"
#include "geometry/visible.h"
#include "radiosity/direct.h"

#include <math.h>
#include <string.h>

enum { DEPTH_MAX = 64, CLIP_DEPTH_MAX = 24 };

static const double inv_pi = 0.31830988618379067154;

/* q of lines of half length `length`, given where the cell's centre lies from x: `du` along them,
 * `dv` across them in the plane, `dn` off the plane. The cell reaches `reach` to either side
 * across, shifted by `shear` a unit. On the line nearest to x the distance vanishes at a complex
 * point, foot
 * +- i height in units of the half length. */
static double line_ellipse(double length, double du, double dv, double dn, double reach,
                           double shear, double *distance2)
{
    const double move = dv > reach ? -reach : dv < -reach ? reach : -dv;
    const double re = fabs(du + move * shear) / length, across = dv + move;
    const double height2 = across * across + dn * dn, im2 = height2 / (length * length);
    const double a = 0.5 * (sqrt((re - 1) * (re - 1) + im2) + sqrt((re + 1) * (re + 1) + im2));
    const double out = re > 1 ? (re - 1) * length : 0;

    *distance2 = out * out + height2;
    return a > 1 ? a + sqrt(a * a - 1) : 1;
}

static double parallelogram_ellipse(const face *f, const cell *c, const double d[3], double q[2])
{
    const double half[2] = {0.5 * c->hs * f->length[0], 0.5 * c->ht * f->length[1]};
    const double sine = f->jacobian / (f->length[0] * f->length[1]), dn = vec_dot(d, f->normal);
    double distance2[2];

    for (int i = 0; i < 2; i++) {
        const double reach = half[1 - i] * sine, shear = (i == 0 ? 1 : -1) * f->cosine / sine;

        q[i] = line_ellipse(half[i], vec_dot(d, f->along[i]), vec_dot(d, f->across[i]), dn, reach,
                            shear, &distance2[i]);
    }
    return fmin(distance2[0], distance2[1]);
}

/* A trapezoid of a triangle: its middle lines stand for all lines. */
static double trapezoid_ellipse(const face *f, const cell *c, const double d[3], double q[2])
{
    double corners[4][3], half[2][3], distance2[2];

    face_cell_corners(f, c, corners);
    for (int k = 0; k < 3; k++) {
        half[0][k] = 0.25 * (corners[1][k] - corners[0][k] + corners[2][k] - corners[3][k]);
        half[1][k] = 0.25 * (corners[3][k] - corners[0][k] + corners[2][k] - corners[1][k]);
    }
    for (int i = 0; i < 2; i++) {
        double along[3], across[3], h;
        const double length = (vec_copy(half[i], along), vec_normalize(along));

        vec_cross(f->normal, along, across);
        h = vec_dot(half[1 - i], across);
        q[i] = line_ellipse(length, vec_dot(d, along), vec_dot(d, across), vec_dot(d, f->normal),
                            fabs(h), h != 0 ? vec_dot(half[1 - i], along) / h : 0, &distance2[i]);
    }
    return fmin(distance2[0], distance2[1]);
}

double transfer_ellipse(const double x[3], const face *f, const cell *c, double q[2])
{
    double centre[3], d[3];

    face_point(f, c->s0 + 0.5 * c->hs, c->t0 + 0.5 * c->ht, centre);
    vec_sub(centre, x, d);
    return f->triangle ? trapezoid_ellipse(f, c, d, q) : parallelogram_ellipse(f, c, d, q);
}

static double power8(double x)
{
    x *= x;
    x *= x;
    return x * x;
}

/* Irradiance at x, or from the light, per radiosity and area at y. */
static double kernel(const transfer *t, const face *f, const double y[3])
{
    double d[3], r2, cx, cy;

    if (t->light)
        return lcor_direct_unshadowed(t->light, y, f->normal);
    vec_sub(y, t->x, d);
    r2 = vec_dot(d, d);
    cx = vec_dot(d, t->normal);
    cy = -vec_dot(d, f->normal);
    return cx > 0 && cy > 0 ? inv_pi * cx * cy / (r2 * r2) : 0;
}

/* Gauss quadrature of an unobstructed cell of a parallelogram for a receiver: the inner loop. */
static void whole_parallelogram(const transfer *t, const face *f, const cell *c,
                                double weights[RULE_Q])
{
    double base[3], us[3], vs[3], cy, scale;

    for (int k = 0; k < 3; k++) {
        base[k] = f->origin[k] + c->s0 * f->u[k] + c->t0 * f->v[k] - t->x[k];
        us[k] = c->hs * f->u[k];
        vs[k] = c->ht * f->v[k];
    }
    cy = -vec_dot(base, f->normal);
    scale = cy > 0 ? face_cell_area(f, c) * inv_pi * cy : 0;
    for (int a = 0; a < RULE_P; a++) {
        const double px = base[0] + rule_x[a] * us[0], py = base[1] + rule_x[a] * us[1],
                     pz = base[2] + rule_x[a] * us[2], w = scale * rule_w[a];

        for (int b = 0; b < RULE_P; b++) {
            const double x = px + rule_x[b] * vs[0], y = py + rule_x[b] * vs[1],
                         z = pz + rule_x[b] * vs[2];
            const double r2 = x * x + y * y + z * z;
            const double cx = x * t->normal[0] + y * t->normal[1] + z * t->normal[2];

            weights[a * RULE_P + b] = w * rule_w[b] * (cx > 0 ? cx : 0) / (r2 * r2);
        }
    }
}

static void whole(const transfer *t, const face *f, const cell *c, double weights[RULE_Q])
{
    if (!t->light && !f->triangle) {
        whole_parallelogram(t, f, c, weights);
        return;
    }
    for (int a = 0; a < RULE_P; a++) {
        const double s = c->s0 + rule_x[a] * c->hs;
        const double w = f->jacobian * c->hs * c->ht * (f->triangle ? s : 1) * rule_w[a];

        for (int b = 0; b < RULE_P; b++) {
            double y[3];

            face_point(f, s, c->t0 + rule_x[b] * c->ht, y);
            weights[a * RULE_P + b] = w * rule_w[b] * kernel(t, f, y);
        }
    }
}

/* Adds the integral over a triangle inside the cell. */
static void add_triangle(const transfer *t, const face *f, const cell *c, const double p[3],
                         const double q[3], const double r[3], double weights[RULE_Q])
{
    double a[3], b[3], cross[3], area2;

    vec_sub(q, p, a);
    vec_sub(r, q, b);
    vec_cross(a, b, cross);
    area2 = vec_length(cross);
    for (int i = 0; i < RULE_P; i++)
        for (int j = 0; j < RULE_P; j++) {
            const double w = area2 * rule_x[i] * rule_w[i] * rule_w[j];
            double y[3], s, z, at_s[RULE_P], at_t[RULE_P], value;

            vec_plane_point(p, a, b, rule_x[i], rule_x[i] * rule_x[j], y);
            value = w * kernel(t, f, y);
            face_coordinates(f, y, &s, &z);
            rule_values((s - c->s0) / c->hs, at_s);
            rule_values((z - c->t0) / c->ht, at_t);
            for (int k = 0; k < RULE_Q; k++)
                weights[k] += value * at_s[k / RULE_P] * at_t[k % RULE_P];
        }
}

/* What the eye sees of the cell. 1: *set holds it; 0: too many pieces. */
static int visible_part(const transfer *t, const face *f, double (*corners)[3], visible_set *set)
{
    const double touch = SCENE_TOUCH * t->scene->diameter;
    visible_eye eye = {{0, 0, 0}, 0};

    (void)visible_start(set, 4, corners[0]);
    if (t->light && t->light->kind == LCOR_LIGHT_DIRECTIONAL) {
        eye.parallel = 1;
        vec_add_scaled(eye.at, -1, t->light->direction, eye.at);
    } else {
        vec_copy(t->light ? t->light->position : t->x, eye.at);
    }
    if (!t->light)
        visible_clip(set, t->x, t->normal);
    for (size_t i = 0; i < t->occluder_count && set->count > 0; i++) {
        const scene_surface *o = scene_surface_at(t->scene, t->occluders[i]);

        if (o->corner_count > 40)
            return 0;
        if (!visible_subtract(set, &eye, f->normal, o->corner_count, scene_corners(t->scene, o),
                              touch))
            return 0;
    }
    return 1;
}

static double set_factor(const transfer *t, const visible_set *set)
{
    double sum = 0;

    for (int i = 0; i < set->count; i++)
        sum += lcor_factor_point(t->x, t->normal, (size_t)set->pieces[i].n, set->pieces[i].p[0]);
    return sum;
}

/* Where the pieces are too many and the cell cannot be split any more: one ray decides. */
static int centre_blocked(const transfer *t, const face *f, const cell *c)
{
    double x[3];

    face_point(f, c->s0 + 0.5 * c->hs, c->t0 + 0.5 * c->ht, x);
    return t->light ? lcor_direct_shadowed(t->scene, t->light, x, f->surface, NULL)
                    : lcor_scene_blocked(t->scene, x, t->x, f->surface, NULL);
}

/* Weights of what is seen of a cell on which the kernel is smooth. Returns -1 if it should be split
 * after all, else the exact factor to a receiver. */
static double clipped_cell(const transfer *t, const face *f, const cell *c, int depth,
                           double weights[RULE_Q])
{
    double corners[4][3];
    visible_set set;

    face_cell_corners(f, c, corners);
    if (!visible_part(t, f, corners, &set)) {
        if (depth < CLIP_DEPTH_MAX)
            return -1;
        (void)visible_start(&set, centre_blocked(t, f, c) ? 0 : 4, corners[0]);
    }
    if (set.count == 1 && set.pieces[0].n == 4 &&
        memcmp(set.pieces[0].p, corners, sizeof corners) == 0) {
        whole(t, f, c, weights);
    } else {
        memset(weights, 0, RULE_Q * sizeof *weights);
        for (int i = 0; i < set.count; i++)
            for (int j = 1; j + 1 < set.pieces[i].n; j++)
                add_triangle(t, f, c, set.pieces[i].p[0], set.pieces[i].p[j],
                             set.pieces[i].p[j + 1], weights);
    }
    return t->light ? 0 : set_factor(t, &set);
}

/* Error of the rule on this cell along each axis. */
static void rule_error(const transfer *t, const face *f, const cell *c, double error[2])
{
    const double *x = t->light ? t->light->position : t->x;
    double q[2], d[3], distance2, height, bound = 1;

    error[0] = error[1] = 0;
    if (t->light && t->light->kind == LCOR_LIGHT_DIRECTIONAL)
        return;
    distance2 = transfer_ellipse(x, f, c, q);
    if (!t->light) {
        vec_sub(t->x, f->origin, d);
        height = vec_dot(d, f->normal);
        bound = face_cell_area(f, c) * height * inv_pi / (distance2 * sqrt(distance2) + 1e-300);
        bound = bound < 1 ? bound : 1;
    }
    error[0] = bound * power8(1 / q[0]);
    error[1] = bound * power8(1 / q[1]);
}

/* Virtual splitting: the sender keeps its nodes, but cells too near are halved, and the weights of
 * the halves are folded back onto the whole. */
static double near_cell(const transfer *t, const face *f, const cell *c, int clipped, int depth,
                        double weights[RULE_Q])
{
    double error[2], exact = -1;

    rule_error(t, f, c, error);
    if ((error[0] <= t->accuracy && error[1] <= t->accuracy) || depth >= DEPTH_MAX) {
        if (clipped) {
            exact = clipped_cell(t, f, c, depth, weights);
        } else {
            whole(t, f, c, weights);
            exact = 0;
        }
    }
    if (exact < 0) {
        const int axis = error[0] >= error[1] ? 0 : 1;
        double part[RULE_Q];
        cell half = *c;

        exact = 0;
        memset(weights, 0, RULE_Q * sizeof *weights);
        half.hs *= axis == 0 ? 0.5 : 1;
        half.ht *= axis == 1 ? 0.5 : 1;
        for (int i = 0; i < 2; i++) {
            half.s0 = c->s0 + (axis == 0 ? i * half.hs : 0);
            half.t0 = c->t0 + (axis == 1 ? i * half.ht : 0);
            exact += near_cell(t, f, &half, clipped, depth + 1, part);
            rule_fold(axis, i, part, weights);
        }
    }
    return exact;
}

/* -1 nothing of the cell is in front of x and facing it, 0 all of it is, 1 some. */
static int horizon(const transfer *t, const face *f, double (*corners)[3])
{
    int below = 0;
    double d[3];

    vec_sub(t->x, f->origin, d);
    if (vec_dot(d, f->normal) <= 0)
        return -1;
    for (int i = 0; i < 4; i++) {
        vec_sub(corners[i], t->x, d);
        below += vec_dot(d, t->normal) < 0;
    }
    return below == 4 ? -1 : below > 0;
}

double transfer_weights(const transfer *t, const face *f, const cell *c, double weights[RULE_Q])
{
    double corners[4][3], exact, sum = 0;
    int clipped = t->occluder_count > 0;

    if (!t->light) {
        int side;

        face_cell_corners(f, c, corners);
        side = horizon(t, f, corners);
        if (side < 0) {
            memset(weights, 0, RULE_Q * sizeof *weights);
            return 0;
        }
        clipped |= side;
    }
    exact = near_cell(t, f, c, clipped, 0, weights);
    if (!t->light && !clipped)
        exact = t->exact >= 0 ? t->exact : lcor_factor_point(t->x, t->normal, 4, corners[0]);
    for (int k = 0; k < RULE_Q; k++)
        sum += weights[k];
    if (t->light)
        return sum;
    if (sum > 0 && exact < 4 * sum)
        for (int k = 0; k < RULE_Q; k++)
            weights[k] *= exact / sum;
    return exact;
}

double transfer_factor(const transfer *t, const face *f, const cell *c)
{
    visible_set set;
    double corners[4][3];

    face_cell_corners(f, c, corners);
    if (horizon(t, f, corners) < 0)
        return 0;
    if (t->occluder_count == 0)
        return lcor_factor_point(t->x, t->normal, 4, corners[0]);
    if (!visible_part(t, f, corners, &set))
        return centre_blocked(t, f, c) ? 0 : lcor_factor_point(t->x, t->normal, 4, corners[0]);
    return set_factor(t, &set);
}

int transfer_factors(const transfer *t, const face *r, size_t n, double (*points)[3], const face *f,
                     const cell *c, double *factors)
{
    double corners[4][3], x[3][TRANSFER_POINTS], d[3];
    int clipped = t->occluder_count > 0;

    face_cell_corners(f, c, corners);
    for (int i = 0; i < 4; i++) {
        vec_sub(corners[i], r->origin, d);
        clipped |= vec_dot(d, r->normal) < 0;
    }
    if (clipped) {
        transfer at = *t;

        at.normal = r->normal;
        for (size_t i = 0; i < n; i++) {
            at.x = points[i];
            factors[i] = transfer_factor(&at, f, c);
        }
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
