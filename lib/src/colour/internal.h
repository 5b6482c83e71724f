/* SPDX-License-Identifier: MIT */
#ifndef LCOR_COLOUR_INTERNAL_H
#define LCOR_COLOUR_INTERNAL_H

#include "base/elementary.h"

#include <lcor/colour.h>

/* f of eqs 2-4 (CIE 1976), without a jump, so that several go side by side. */
static LCOR_INLINE double lcor_internal_f_cie(double t)
{
    const double knee = 216.0 / 24389.0, root = lcor_internal_cbrt_normal(t > knee ? t : knee);

    return t > knee ? root : t * (841.0 / 108.0) + 4.0 / 29.0;
}

/* The same in the kind of lightness asked for. */
static inline double lcor_internal_f(lcor_lightness lightness, double t)
{
    return lightness == LCOR_LIGHTNESS_PAPER ? lcor_internal_cbrt(t) : lcor_internal_f_cie(t);
}

/* Its inverse. */
static inline double lcor_internal_f_inverse(lcor_lightness lightness, double f)
{
    if (lightness == LCOR_LIGHTNESS_PAPER || f > 6.0 / 29.0)
        return f * f * f;
    return (f - 4.0 / 29.0) * (108.0 / 841.0);
}

/* Linear value of what sRGB stores, without a jump. */
static LCOR_INLINE double lcor_internal_from_srgb(double stored)
{
    const double knee = 0.04045, u = ((stored > knee ? stored : knee) + 0.055) / 1.055;
    const double v = u * lcor_internal_inverse_fifth_root(u);

    return stored > knee ? v * v * v : stored / 12.92; /* u^2.4 = u^3 u^(-3/5) */
}

/* out = m in, m row-major 3x3; in may be out. */
static inline void lcor_internal_mat3_apply(const double m[9], const double in[3], double out[3])
{
    const double a = in[0], b = in[1], c = in[2];

    for (size_t i = 0; i < 3; i++)
        out[i] = m[3 * i] * a + m[3 * i + 1] * b + m[3 * i + 2] * c;
}

#endif
