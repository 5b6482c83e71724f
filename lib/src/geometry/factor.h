/* SPDX-License-Identifier: MIT */
/* Exact form factors from a differential element to polygons (Lambert 1760). */
#ifndef LCOR_GEOMETRY_FACTOR_H
#define LCOR_GEOMETRY_FACTOR_H

#include <stddef.h>

enum { LCOR_CLIP_MAX = 64 }; /* corners a clipped polygon may have */

/* Part of the hemisphere over (x, normal), weighted by the cosine, that the convex polygon covers:
 * 0..1, the same for either winding. What lies below x's plane is clipped away. n + 1 corners at
 * most LCOR_CLIP_MAX. */
double lcor_factor_point(const double x[3], const double normal[3], size_t n,
                         const double *corners);

/* The same for n points of one plane and a quadrilateral wholly on its upper side, many at once. */
typedef void lcor_factor_points(size_t n, const double *x, const double *y, const double *z,
                                const double normal[3], const double corners[4][3],
                                double *factors);

/* For the instruction sets that this build has and the machine can run, best first; NULL after the
 * last. All give the same bits. */
lcor_factor_points *lcor_factor_points_at(size_t index);

/* Cuts a convex polygon by the half-space (p - x) . normal >= 0; returns the corners left. `out`
 * has room for n + 1. */
size_t lcor_clip_polygon(const double x[3], const double normal[3], size_t n, const double *corners,
                         double *out);

#endif
