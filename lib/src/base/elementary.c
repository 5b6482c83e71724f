/* SPDX-License-Identifier: MIT */
#include "base/elementary.h"

#include <float.h>
#include <math.h>
#include <stdint.h>
#include <string.h>

static uint64_t bits_of(double x)
{
    uint64_t u;

    memcpy(&u, &x, sizeof u);
    return u;
}

static double from_bits(uint64_t u)
{
    double x;

    memcpy(&x, &u, sizeof x);
    return x;
}

double lcor_internal_cbrt(double x)
{
    double a = fabs(x), scale = 1.0, z, y, e;

    if (!(a > 0.0) || a > DBL_MAX)
        return x;
    if (a < DBL_MIN) {             /* subnormal: the exponent trick below needs a normal one */
        a *= 18014398509481984.0;  /* 2^54 */
        scale = 3.814697265625e-6; /* 2^-18 */
    }
    /* z ~ a^(-1/3) within 3.5 % from a third of the exponent; the constant is 4/3 of the bias,
     * tuned. Then twice the first terms of (1 - e)^(-1/3) and (1 - e)^(-2/3), no division. */
    z = from_bits(UINT64_C(0x553EF0FF289DD796) - bits_of(a) / 3);
    e = 1.0 - a * z * z * z;
    z += z * (e * (1.0 / 3 + e * (2.0 / 9 + e * (14.0 / 81)))); /* now within 2e-5 */
    z = from_bits(bits_of(z) & ~UINT64_C(0x7FFFFFF));           /* 26 bits: its square is exact */
    y = a * (z * z);
    e = 1.0 - y * z;
    y += y * (e * (2.0 / 3 + e * (5.0 / 9 + e * (40.0 / 81))));
    return x < 0.0 ? -y * scale : y * scale;
}

double lcor_internal_log2_parts(double x, int *exponent)
{
    int e = 0;
    uint64_t u;
    double m, s, z, p;

    if (x < DBL_MIN) {
        x *= 18014398509481984.0; /* 2^54 */
        e = -54;
    }
    u = bits_of(x);
    e += (int)(u >> 52) - 1023;
    m = from_bits((u & UINT64_C(0xFFFFFFFFFFFFF)) | UINT64_C(0x3FF0000000000000));
    if (m > 1.4142135623730951) {
        m *= 0.5;
        e++;
    }
    *exponent = e;
    s = (m - 1.0) / (m + 1.0); /* log2 m = 2/ln 2 artanh s, |s| < 0.172 */
    z = s * s;
    p = 1.0 / 23;
    for (int k = 21; k >= 3; k -= 2)
        p = p * z + 1.0 / k;
    return 2.8853900817779268 * (s + s * (z * p));
}

double lcor_internal_exp2(double x)
{
    double n, y, p;

    if (!(x < 1025.0)) /* also NaN */
        return x * HUGE_VAL;
    if (x < -1080.0)
        return 0.0;
    n = floor(x + 0.5);
    y = (x - n) * 0.69314718055994531; /* |y| < 0.347 */
    p = 1.0;
    for (int k = 13; k >= 1; k--)
        p = 1.0 + p * y / k;
    /* two steps, so that results of -1022 and less, or 1024, round and overflow as they should */
    p *= from_bits((uint64_t)(1023 + (int)n / 2) << 52);
    return p * from_bits((uint64_t)(1023 + (int)n - (int)n / 2) << 52);
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
