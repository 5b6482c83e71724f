/* SPDX-License-Identifier: MIT */
/* Elementary functions in double, the same bits from every compiler and C library: plain IEEE
 * additions, multiplications and divisions in a fixed order. Errors are the worst seen over the
 * whole range by tests/numeric/test_elementary.c. */
#ifndef LCOR_BASE_ELEMENTARY_H
#define LCOR_BASE_ELEMENTARY_H

#include "base/internal.h"

#include <stdint.h>
#include <string.h>

static LCOR_INLINE uint64_t lcor_internal_bits(double x)
{
    uint64_t u;

    memcpy(&u, &x, sizeof u);
    return u;
}

static LCOR_INLINE double lcor_internal_from_bits(uint64_t u)
{
    double x;

    memcpy(&x, &u, sizeof x);
    return x;
}

/* Cube root of a normal number > 0; within 1 ulp. Inline, so that several overlap. */
static LCOR_INLINE double lcor_internal_cbrt_normal(double a)
{
    /* z ~ a^(-1/3) within 3.5 % from a third of the exponent; the constant is 4/3 of the bias,
     * tuned. Then twice the first terms of (1 - e)^(-1/3) and (1 - e)^(-2/3), no division. A third
     * of the upper half of the bits will do, and vector units have that product. */
    const uint64_t third = (lcor_internal_bits(a) >> 32) * UINT64_C(0x55555555);
    double z = lcor_internal_from_bits(UINT64_C(0x553EF0FF289DD796) - third);
    double e = 1.0 - a * z * z * z, y;

    z += z * (e * (1.0 / 3 + e * (2.0 / 9 + e * (14.0 / 81))));                /* now within 2e-5 */
    z = lcor_internal_from_bits(lcor_internal_bits(z) & ~UINT64_C(0x7FFFFFF)); /* z z is exact */
    y = a * (z * z);
    e = 1.0 - y * z;
    return y + y * (e * (2.0 / 3 + e * (5.0 / 9 + e * (40.0 / 81))));
}

/* a^(-1/5) of a normal number > 0; within 5 ulp. As above, with (1 - e)^(-1/5). */
static LCOR_INLINE double lcor_internal_inverse_fifth_root(double a)
{
    const uint64_t fifth = (lcor_internal_bits(a) >> 32) * UINT64_C(0x33333333);
    double z = lcor_internal_from_bits(UINT64_C(0x4CB8AC4B93333000) - fifth);

    for (int i = 0; i < 2; i++) {
        const double z2 = z * z, e = 1.0 - a * z * (z2 * z2);

        z += z * (e * (1.0 / 5 + e * (3.0 / 25 + e * (11.0 / 125)))); /* 3.2 %, 5e-5, rounding */
    }
    return z;
}

/* Cube root, odd; within 1 ulp. Zeros, infinities and NaN come back as they are. */
double lcor_internal_cbrt(double x);

/* x = m 2^exponent with log2 m returned, -0.5..0.5, within 2.3e-16 absolute; x > 0 and finite. */
double lcor_internal_log2_parts(double x, int *exponent);

/* 2^x within 1.5 ulp; 0 and infinity beyond the range of double, NaN for NaN. */
double lcor_internal_exp2(double x);

/* x^t for x >= 0 and finite t > 0: within (1 + |t log2 x|) 5e-16 relative. */
double lcor_internal_pow(double x, double t);

#endif
