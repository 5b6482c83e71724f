/* SPDX-License-Identifier: MIT */
#include "geometry/visible.h"

#include "geometry/vec.h"

#include <string.h>

enum { OCCLUDER_CORNERS = 44 };

/* A cone with its tip in the eye: the planes through the eye and the occluder's edges. */
typedef struct cone {
    int n;
    double point[OCCLUDER_CORNERS][3], inward[OCCLUDER_CORNERS][3];
} cone;

int visible_start(visible_set *set, size_t n, const double *corners)
{
    if (n > VISIBLE_CORNERS)
        return 0;
    set->count = 1;
    set->pieces[0].n = (int)n;
    memcpy(set->pieces[0].p, corners, n * sizeof set->pieces[0].p[0]);
    return 1;
}

/* Cuts a polygon in two by a plane; either result may be NULL. Returns 0 if one gets too long. */
static int cut(const visible_piece *whole, const double x[3], const double normal[3],
               visible_piece *in, visible_piece *out)
{
    double height[VISIBLE_CORNERS];

    for (int i = 0; i < whole->n; i++) {
        double d[3];

        vec_sub(whole->p[i], x, d);
        height[i] = vec_dot(d, normal);
    }
    in->n = out->n = 0;
    for (int i = 0; i < whole->n; i++) {
        const int j = i + 1 < whole->n ? i + 1 : 0;
        const double *a = whole->p[i], *b = whole->p[j];

        if (in->n + 2 > VISIBLE_CORNERS || out->n + 2 > VISIBLE_CORNERS)
            return 0;
        if (height[i] >= 0)
            vec_copy(a, in->p[in->n++]);
        if (height[i] <= 0)
            vec_copy(a, out->p[out->n++]);
        if ((height[i] > 0 && height[j] < 0) || (height[i] < 0 && height[j] > 0)) {
            const double t = height[i] / (height[i] - height[j]);
            double c[3];

            for (int k = 0; k < 3; k++)
                c[k] = a[k] + t * (b[k] - a[k]);
            vec_copy(c, in->p[in->n++]);
            vec_copy(c, out->p[out->n++]);
        }
    }
    return 1;
}

void visible_clip(visible_set *set, const double x[3], const double normal[3])
{
    int kept = 0;

    for (int i = 0; i < set->count; i++) {
        visible_piece in, out;

        if (cut(&set->pieces[i], x, normal, &in, &out)) {
            if (in.n < 3)
                continue;
            set->pieces[kept++] = in;
        } else if (kept++ != i) {
            set->pieces[kept - 1] = set->pieces[i];
        }
    }
    set->count = kept;
}

static int clip_heights(int n, double (*p)[3], double *height, double sign, double limit)
{
    double q[OCCLUDER_CORNERS][3], h[OCCLUDER_CORNERS];
    int m = 0;

    for (int i = 0; i < n && m + 2 <= OCCLUDER_CORNERS; i++) {
        const int j = i + 1 < n ? i + 1 : 0;
        const double a = sign * (height[i] - limit), b = sign * (height[j] - limit);

        if (a >= 0) {
            h[m] = height[i];
            vec_copy(p[i], q[m++]);
        }
        if ((a > 0 && b < 0) || (a < 0 && b > 0)) {
            for (int k = 0; k < 3; k++)
                q[m][k] = p[i][k] + a / (a - b) * (p[j][k] - p[i][k]);
            h[m++] = limit;
        }
    }
    memcpy(p, q, (size_t)m * sizeof q[0]);
    memcpy(height, h, (size_t)m * sizeof h[0]);
    return m;
}

/* The cone over that part of the occluder that lies between target plane and eye; 0 if none. */
static int make_cone(cone *c, const visible_eye *eye, const double target[3],
                     const double normal[3], size_t n, const double *occluder, double touch)
{
    double p[OCCLUDER_CORNERS][3], height[OCCLUDER_CORNERS], middle[3] = {0}, d[3];
    int m = (int)n, low = 0, high = 0;
    double eye_height = 0;

    if (n + 2 > OCCLUDER_CORNERS)
        return 0;
    if (!eye->parallel) {
        vec_sub(eye->at, target, d);
        eye_height = vec_dot(d, normal);
    }
    for (int i = 0; i < m; i++) {
        vec_copy(occluder + 3 * i, p[i]);
        vec_sub(p[i], target, d);
        height[i] = vec_dot(d, normal);
        low |= height[i] < touch;
        high |= !eye->parallel && height[i] > eye_height - touch;
    }
    if (low)
        m = clip_heights(m, p, height, 1, touch);
    if (high)
        m = clip_heights(m, p, height, -1, eye_height - touch);
    if (m < 3)
        return 0;
    for (int i = 0; i < m; i++)
        vec_add_scaled(middle, 1.0 / m, p[i], middle);
    c->n = 0;
    for (int i = 0; i < m; i++) {
        double edge[3], towards[3], inward[3], depth;

        vec_sub(p[i + 1 < m ? i + 1 : 0], p[i], edge);
        if (eye->parallel)
            vec_copy(eye->at, towards);
        else
            vec_sub(eye->at, p[i], towards);
        vec_cross(towards, edge, inward);
        if (!(vec_normalize(inward) > 0))
            continue;
        vec_sub(middle, p[i], d);
        depth = vec_dot(d, inward);
        if (fabs(depth) <= 1e-3 * touch)
            return 0; /* seen edge-on */
        if (depth < 0)
            for (int k = 0; k < 3; k++)
                inward[k] = -inward[k];
        vec_copy(p[i], c->point[c->n]);
        vec_copy(inward, c->inward[c->n++]);
    }
    return c->n >= 3;
}

/* Whether a plane of the cone has the whole piece on its outer side. */
static int apart(const visible_piece *piece, const cone *c)
{
    for (int e = 0; e < c->n; e++) {
        int inside = 0;

        for (int i = 0; i < piece->n && !inside; i++) {
            double d[3];

            vec_sub(piece->p[i], c->point[e], d);
            inside = vec_dot(d, c->inward[e]) > 0;
        }
        if (!inside)
            return 1;
    }
    return 0;
}

int visible_subtract(visible_set *set, const visible_eye *eye, const double target_normal[3],
                     size_t n, const double *occluder, double touch)
{
    visible_set result;
    cone c;

    if (set->count == 0 ||
        !make_cone(&c, eye, set->pieces[0].p[0], target_normal, n, occluder, touch))
        return 1;
    result.count = 0;
    for (int i = 0; i < set->count; i++) {
        visible_piece rest = set->pieces[i];

        if (result.count + c.n + 1 > VISIBLE_PIECES)
            return 0;
        if (apart(&rest, &c)) {
            result.pieces[result.count++] = rest;
            continue;
        }
        for (int e = 0; e < c.n && rest.n >= 3; e++) {
            visible_piece in, *out = &result.pieces[result.count];

            if (!cut(&rest, c.point[e], c.inward[e], &in, out))
                return 0;
            if (out->n >= 3)
                result.count++;
            rest = in;
        }
    }
    set->count = result.count;
    memcpy(set->pieces, result.pieces, (size_t)result.count * sizeof result.pieces[0]);
    return 1;
}
