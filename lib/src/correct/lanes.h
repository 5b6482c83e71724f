/* SPDX-License-Identifier: MIT */
/* The correction in double: what every faster path is measured against. A few pixels go side by
 * side in vectors, and since one alone is a long chain of operations that wait for each other. */
#ifndef LCOR_CORRECT_LANES_H
#define LCOR_CORRECT_LANES_H

#include "correct/internal.h"

#include "base/internal.h"

#include <math.h>
#include <stddef.h>

/* Pixels side by side. Zeros are black ones and do no harm. */
struct lcor_lanes {
    double c[3][LCOR_LANES]; /* samples or f of the texel; at the end RGB in 0..1 */
    double illuminance[LCOR_LANES], rho[LCOR_LANES];
    double good[LCOR_LANES];    /* 0: the pixel is bad (rule S10), and goes on as black */
    double y[LCOR_LANES];       /* Y of the texel over white's */
    double t[LCOR_LANES];       /* T, not clamped */
    double y_new[LCOR_LANES];   /* Ynew, 0..1 */
    double k[LCOR_LANES];       /* of eq 16, where the lightness is the paper's */
    double outside[LCOR_LANES]; /* not 0: RGB left 0..1 before the gamut rule */
};

/* Pixels at + list[0], at + list[1]... of a row into the lanes from `first` on. */
void lcor_internal_load_lanes(const lcor_row_job *job, size_t at, const uint8_t *list, size_t count,
                              lcor_lanes *lanes, size_t first);
/* f and Y of loaded texels; the correction of all lanes. */
void lcor_internal_lanes_to_f(const lcor_plan *plan, lcor_lanes *lanes);
void lcor_internal_correct_lanes(const lcor_row_job *job, lcor_lanes *lanes);

/* k of eq 16 from f: both its branches are (h - fn) / (h - fy). A black texel has no chroma. */
static LCOR_INLINE double lcor_lane_chroma(double fy, double fn)
{
    const double black = 4.0 / 29.0, h = fn > fy ? 1.0 : black; /* f where L* = 0 */
    const int defined = (fn > fy) | (fy > black);

    return defined ? (h - fn) / (defined ? h - fy : 1.0) : 1.0;
}

/* How far a channel is outside 0..1; RGB a rounding error outside is not worth a change of chroma.
 */
static LCOR_INLINE double lcor_lane_excess(double v) { return fabs(v - 0.5) - (0.5 + 1e-14); }

/* The inverse of f. Its straight line below the knee is the cube's tangent there. */
static LCOR_INLINE double lcor_lane_t(double knee, double f)
{
    const double m = f > knee ? f : knee;

    return m * m * m + (f - m) * (108.0 / 841.0);
}

/* Its first and second derivative. */
static LCOR_INLINE double lcor_lane_t_slope(double knee, double f)
{
    const double m = f > knee ? f : knee;

    return 3.0 * m * m;
}

static LCOR_INLINE double lcor_lane_t_bend(double knee, double f)
{
    return f > knee ? 6.0 * f : 0.0;
}

#endif
