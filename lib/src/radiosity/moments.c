/* SPDX-License-Identifier: MIT */
#include "radiosity/moments.h"

#include "geometry/vec.h"
#include "radiosity/direct.h"
#include "radiosity/transfer.h"

#include <math.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

enum { DEPTH_MAX = 64, CLIP_DEPTH_MAX = 8 };

/* Kinks are not resolved further than this. */
static const double kink_accuracy_least = 1e-5;
/* The rule's error on a cell across a kink is about this part of the kink's own. */
static const double kink_felt = 0.04;

static double power8(double x)
{
    x *= x;
    x *= x;
    return x * x;
}

static void whole(const moments *m, const cell *c, double out[RULE_Q])
{
    const face *f = m->f;

    for (int a = 0; a < RULE_P; a++) {
        const double s = c->s0 + rule_x[a] * c->hs;
        const double w = f->jacobian * c->hs * c->ht * (f->triangle ? s : 1) * rule_w[a];

        for (int b = 0; b < RULE_P; b++) {
            double y[3];

            face_point(f, s, c->t0 + rule_x[b] * c->ht, y);
            out[a * RULE_P + b] = w * rule_w[b] * lcor_direct_unshadowed(m->light, y, f->normal);
        }
    }
}

/* Adds `sign` times the integral over a triangle inside the cell. */
static void add_triangle(const moments *m, const cell *c, double sign, const double p[3],
                         const double q[3], const double r[3], double out[RULE_Q])
{
    double a[3], b[3], cross[3], area2;

    vec_sub(q, p, a);
    vec_sub(r, q, b);
    vec_cross(a, b, cross);
    area2 = sign * vec_length(cross);
    for (int i = 0; i < RULE_P; i++)
        for (int j = 0; j < RULE_P; j++) {
            double y[3], s, z, at_s[RULE_P], at_t[RULE_P], value;

            vec_plane_point(p, a, b, rule_x[i], rule_x[i] * rule_x[j], y);
            value = area2 * rule_x[i] * rule_w[i] * rule_w[j] *
                    lcor_direct_unshadowed(m->light, y, m->f->normal);
            face_coordinates(m->f, y, &s, &z);
            rule_values((s - c->s0) / c->hs, at_s);
            rule_values((z - c->t0) / c->ht, at_t);
            for (int k = 0; k < RULE_Q; k++)
                out[k] += value * at_s[k / RULE_P] * at_t[k % RULE_P];
        }
}

/* Moments of what is seen of a cell on which the light is smooth; 0 if it should be split. */
static int clipped_cell(const moments *m, const cell *c, int depth, double out[RULE_Q])
{
    double corners[4][3];
    visible_set set;

    face_cell_corners(m->f, c, corners);
    if (!sight_cell(&m->sight, corners, NULL, NULL, SIGHT_SMALLER, &set)) {
        if (depth < CLIP_DEPTH_MAX)
            return 0;
        (void)visible_start(&set, sight_centre_blocked(&m->sight, c) ? 0 : 4, corners[0]);
    }
    memset(out, 0, RULE_Q * sizeof *out);
    for (int i = 0; i < set.count; i++) {
        const visible_piece *piece = &set.pieces[i];

        if (i == 0 && visible_is(piece, 4, corners[0]))
            whole(m, c, out);
        else
            for (int j = 1; j + 1 < piece->n; j++)
                add_triangle(m, c, piece->sign, piece->p[0], piece->p[j], piece->p[j + 1], out);
    }
    return 1;
}

/* Whether a cell from `at - spread` to `at + spread` reaches over a kink that the rule feels: one
 * at the end of a ramp from 0 to 1 of the given width, in a light as wide as `whole`. */
static int feels_kink(const moments *m, double at, double spread, double kink, double width,
                      double whole)
{
    const double jump = 2 * spread < width ? 2 * spread / width : 1;
    const double share = 2 * spread < whole ? 2 * spread / whole : 1;

    return fabs(at - kink) < spread &&
           kink_felt * jump * share > fmax(m->accuracy, kink_accuracy_least);
}

/* Where a spotlight's cones or the end of a light's range cross the cell, its irradiance is no
 * polynomial. */
static int is_kinked(const moments *m, const cell *c)
{
    const lcor_light *light = m->light;
    double corners[4][3], centre[3] = {0, 0, 0}, to[3], radius = 0, distance, spread, angle;

    if (light->kind != LCOR_LIGHT_SPOT && !(light->range > 0))
        return 0;
    face_cell_corners(m->f, c, corners);
    for (int i = 0; i < 4; i++)
        vec_add_scaled(centre, 0.25, corners[i], centre);
    for (int i = 0; i < 4; i++) {
        vec_sub(corners[i], centre, to);
        radius = fmax(radius, vec_length(to));
    }
    vec_sub(centre, light->position, to);
    distance = vec_normalize(to);
    if (light->range > 0 &&
        feels_kink(m, distance, radius, light->range, 0.25 * light->range, light->range))
        return 1;
    if (light->kind != LCOR_LIGHT_SPOT)
        return 0;
    spread = distance > radius ? asin(radius / distance) : pi;
    angle = acos(fmin(fmax(vec_dot(to, light->direction), -1), 1));
    return feels_kink(m, angle, spread, light->inner_cone, light->outer_cone - light->inner_cone,
                      light->outer_cone) ||
           feels_kink(m, angle, spread, light->outer_cone, light->outer_cone - light->inner_cone,
                      light->outer_cone);
}

/* Whether the rule on this cell is accurate; else *axis is the one to halve. */
static int is_smooth(const moments *m, const cell *c, int *axis)
{
    double q[2];

    if (m->light->kind == LCOR_LIGHT_DIRECTIONAL)
        return 1;
    (void)transfer_ellipse(m->light->position, m->f, c, q);
    if (power8(q[0]) * m->accuracy >= 1 && power8(q[1]) * m->accuracy >= 1)
        return !is_kinked(m, c);
    *axis = q[1] < 0.999 * q[0] ? 1 : 0;
    return 0;
}

static void near_cell(const moments *m, const cell *c, int depth, double out[RULE_Q])
{
    int axis = depth % 2;
    double part[RULE_Q];
    cell half = *c;

    if (depth >= DEPTH_MAX || is_smooth(m, c, &axis)) {
        if (m->sight.count > 0 || m->sight.crowded) {
            if (clipped_cell(m, c, depth, out))
                return;
        } else {
            whole(m, c, out);
            return;
        }
    }
    memset(out, 0, RULE_Q * sizeof *out);
    half.hs *= axis == 0 ? 0.5 : 1;
    half.ht *= axis == 1 ? 0.5 : 1;
    for (int i = 0; i < 2; i++) {
        half.s0 = c->s0 + (axis == 0 ? i * half.hs : 0);
        half.t0 = c->t0 + (axis == 1 ? i * half.ht : 0);
        near_cell(m, &half, depth + 1, part);
        rule_fold(axis, i, part, out);
    }
}

void moments_aim(moments *m, const lcor_scene *scene, const lcor_light *light, const face *f,
                 const uint32_t *blockers, size_t count, double accuracy)
{
    visible_eye eye;

    m->light = light;
    m->f = f;
    m->accuracy = accuracy;
    sight_eye_of(light, &eye);
    sight_target(&m->sight, scene, f, blockers, count);
    sight_aim(&m->sight, &eye);
}

double moments_of(const moments *m, const cell *c, double out[RULE_Q])
{
    double sum = 0;

    near_cell(m, c, 0, out);
    for (int k = 0; k < RULE_Q; k++)
        sum += out[k];
    return sum;
}
