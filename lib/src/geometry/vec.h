/* SPDX-License-Identifier: MIT */
/* Three-vectors as plain arrays. */
#ifndef LCOR_GEOMETRY_VEC_H
#define LCOR_GEOMETRY_VEC_H

#include <math.h>

static inline double vec_dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline double vec_length(const double a[3]) { return sqrt(vec_dot(a, a)); }

static inline void vec_sub(const double a[3], const double b[3], double out[3])
{
    out[0] = a[0] - b[0];
    out[1] = a[1] - b[1];
    out[2] = a[2] - b[2];
}

static inline void vec_copy(const double a[3], double out[3])
{
    out[0] = a[0];
    out[1] = a[1];
    out[2] = a[2];
}

/* out = a + s b */
static inline void vec_add_scaled(const double a[3], double s, const double b[3], double out[3])
{
    out[0] = a[0] + s * b[0];
    out[1] = a[1] + s * b[1];
    out[2] = a[2] + s * b[2];
}

static inline void vec_cross(const double a[3], const double b[3], double out[3])
{
    const double x = a[1] * b[2] - a[2] * b[1], y = a[2] * b[0] - a[0] * b[2];

    out[2] = a[0] * b[1] - a[1] * b[0];
    out[0] = x;
    out[1] = y;
}

/* Scales a to length 1 and returns its old length; a zero vector stays. */
static inline double vec_normalize(double a[3])
{
    double largest = fabs(a[0]), length;

    for (int k = 1; k < 3; k++) /* not by fmax, which few compilers inline */
        largest = fabs(a[k]) > largest ? fabs(a[k]) : largest;
    if (!(largest > 0))
        return 0;
    for (int k = 0; k < 3; k++)
        a[k] /= largest;
    length = vec_length(a);
    for (int k = 0; k < 3; k++)
        a[k] /= length;
    return length * largest;
}

/* u and v: any orthonormal frame around a unit vector. */
static inline void vec_frame(const double normal[3], double u[3], double v[3])
{
    double axis[3] = {0, 0, 0};

    axis[fabs(normal[0]) < 0.7 ? 0 : 1] = 1;
    vec_cross(normal, axis, u);
    (void)vec_normalize(u);
    vec_cross(normal, u, v);
}

/* origin + s edge_u + t edge_v */
static inline void vec_plane_point(const double origin[3], const double edge_u[3],
                                   const double edge_v[3], double s, double t, double out[3])
{
    for (int k = 0; k < 3; k++)
        out[k] = origin[k] + s * edge_u[k] + t * edge_v[k];
}

#endif
