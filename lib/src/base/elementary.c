/* SPDX-License-Identifier: MIT */
#include "base/elementary.h"

#include <float.h>
#include <math.h>
#include <stdint.h>
#include <string.h>

double lcor_internal_cbrt(double x)
{
    double a = fabs(x), scale = 1.0, y;

    if (!(a > 0.0) || a > DBL_MAX)
        return x;
    if (a < DBL_MIN) {             /* the exponent trick needs a normal number */
        a *= 18014398509481984.0;  /* 2^54 */
        scale = 3.814697265625e-6; /* 2^-18 */
    }
    y = lcor_internal_cbrt_normal(a) * scale;
    return x < 0.0 ? -y : y;
}

double lcor_internal_log2_parts(double x, int *exponent)
{
    int e = 0;
    uint64_t u;
    double m, s, z, z2, z4, p;

    if (x < DBL_MIN) {
        x *= 18014398509481984.0; /* 2^54 */
        e = -54;
    }
    u = lcor_internal_bits(x);
    e += (int)(u >> 52) - 1023;
    m = lcor_internal_from_bits((u & UINT64_C(0xFFFFFFFFFFFFF)) | UINT64_C(0x3FF0000000000000));
    if (m > 1.4142135623730951) {
        m *= 0.5;
        e++;
    }
    *exponent = e;
    s = (m - 1.0) / (m + 1.0); /* log2 m = 2/ln 2 artanh s, |s| < 0.172 */
    z = s * s;
    /* 1/3 + z/5 + ... + z^10/23 in pairs, which do not wait for each other */
    z2 = z * z;
    z4 = z2 * z2;
    p = (1.0 / 19 + z * (1.0 / 21)) + z2 * (1.0 / 23);
    p = ((1.0 / 11 + z * (1.0 / 13)) + z2 * (1.0 / 15 + z * (1.0 / 17))) + z4 * p;
    p = ((1.0 / 3 + z * (1.0 / 5)) + z2 * (1.0 / 7 + z * (1.0 / 9))) + z4 * p;
    return 2.8853900817779268 * (s + s * (z * p));
}

double lcor_internal_exp2(double x)
{
    double n, y, y2, y4, p;

    if (!(x < 1025.0)) /* also NaN */
        return x * HUGE_VAL;
    if (x < -1080.0)
        return 0.0;
    n = floor(x + 0.5);
    y = (x - n) * 0.69314718055994531; /* |y| < 0.347 */
    /* 1 + y (1 + y/2! + ... + y^12/13!) in pairs, which do not wait for each other */
    y2 = y * y;
    y4 = y2 * y2;
    p = (1.0 / 362880 + y * (1.0 / 3628800)) + y2 * (1.0 / 39916800 + y * (1.0 / 479001600));
    p = ((1.0 / 120 + y * (1.0 / 720)) + y2 * (1.0 / 5040 + y * (1.0 / 40320))) +
        y4 * (p + y4 * (1.0 / 6227020800.0));
    p = 1.0 + y * (((1.0 + y * (1.0 / 2)) + y2 * (1.0 / 6 + y * (1.0 / 24))) + y4 * p);
    /* two steps, so that results of -1022 and less, or 1024, round and overflow as they should */
    p *= lcor_internal_from_bits((uint64_t)(1023 + (int)n / 2) << 52);
    return p * lcor_internal_from_bits((uint64_t)(1023 + (int)n - (int)n / 2) << 52);
}

double lcor_internal_pow(double x, double t)
{
    int e;
    double f;

    if (t == 1.0 || x == 0.0 || x > DBL_MAX)
        return x;
    f = lcor_internal_log2_parts(x, &e);
    return lcor_internal_exp2(t * (double)e + t * f);
}
