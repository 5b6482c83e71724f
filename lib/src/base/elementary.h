/* SPDX-License-Identifier: MIT */
/* Elementary functions in double, the same bits from every compiler and C library: plain IEEE
 * additions, multiplications and divisions in a fixed order. Errors are the worst seen over the
 * whole range by tests/numeric/test_elementary.c. */
#ifndef LCOR_BASE_ELEMENTARY_H
#define LCOR_BASE_ELEMENTARY_H

/* Cube root, odd; within 1 ulp. Zeros, infinities and NaN come back as they are. */
double lcor_internal_cbrt(double x);

/* x = m 2^exponent with log2 m returned, -0.5..0.5, within 2.3e-16 absolute; x > 0 and finite. */
double lcor_internal_log2_parts(double x, int *exponent);

/* 2^x within 1.5 ulp; 0 and infinity beyond the range of double, NaN for NaN. */
double lcor_internal_exp2(double x);

/* x^t for x >= 0 and finite t > 0: within (1 + |t log2 x|) 5e-16 relative. */
double lcor_internal_pow(double x, double t);

#endif
