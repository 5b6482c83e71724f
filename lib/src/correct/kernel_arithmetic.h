/* SPDX-License-Identifier: MIT */
/* Arithmetic on one pixel's floats, for kernel_template.h: see there. */

INNER int32_t ISA(bits)(float x)
{
    int32_t i;

    memcpy(&i, &x, sizeof i);
    return i;
}

INNER float ISA(from_bits)(int32_t i)
{
    float x;

    memcpy(&x, &i, sizeof x);
    return x;
}

/* The larger or smaller of x and a limit >= 0. Floats order as their bits do there, and of integers
 * every compiler makes one instruction, where the set has it, and no jump. SSE2 has it for floats
 * alone, and gcc makes it of such a choice only if the limit is a variable. */
#if POOR
static const volatile limits ISA(limits) = LIMITS;
#else
static const limits ISA(limits) = LIMITS;
#endif

INNER float ISA(at_least)(float x, float limit)
{
#if POOR
    return x > limit ? x : limit;
#else
    const int32_t a = ISA(bits)(x), b = ISA(bits)(limit);

    return ISA(from_bits)(a > b ? a : b);
#endif
}

INNER float ISA(at_most)(float x, float limit)
{
#if POOR
    return x < limit ? x : limit;
#else
    const int32_t a = ISA(bits)(x), b = ISA(bits)(limit);

    return ISA(from_bits)(a < b ? a : b);
#endif
}

INNER float ISA(clamp)(float x, float zero, float one)
{
    return ISA(at_most)(ISA(at_least)(x, zero), one);
}

/* 1 - f(t) with f of eqs 2-4 (CIE 1976): eq 16 divides by that, and float holds more of its digits
 * near white than of f's.
 *
 * The cube root of m >= 2^-100: z ~ m^(-1/3) within 3.5 % from a third of the exponent; c0 = m z^2
 * and e = c0 z - 1 give c0 (1 + e)^(-2/3), a minimax polynomial for |e| < 0.1022 as the product of
 * two, which do not wait for each other. Rounding of c0 comes back through e and is damped to a
 * third, so that no Newton step and no division are needed.
 * The straight line below (6/29)^3 is the cube root's tangent there, so both parts are
 * cbrt(m) + slope (t - m) with m = max(t, (6/29)^3), and no choice is left.
 * Worst error 9.1e-8 for t in 0..1, 1.4e-7 relative to f beyond (tests/numeric/test_kernel.c). */
INNER float ISA(inverse_root)(float m)
{
    return ISA(from_bits)((int32_t)((float)ISA(bits)(m) * -0.333333333f) + 1419899955);
}

/* c0, e and the line of 1 - f */
INNER float ISA(g_of)(float c0, float e, float line)
{
    const float p = ((e - 1.81083119f) * e + 1.26196909f) *
                    ((e * 0.42873171f + 0.317821026f) * e + 0.528274953f);

    return (1.0f - c0) - (line - (c0 * e) * p);
}

#define G_BLACK 0.862068951f /* of 0 as the line above rounds it: 25/29 */

/* The inverse of f; the slope is 108/841 to an ulp, chosen so that 1 - G_BLACK gives exactly 0. */
INNER float ISA(f_inverse)(float v, float knee)
{
    const float m = ISA(at_least)(v, knee);

    return m * m * m + (v - m) * 0.128418565f;
}

/* x^t for 0 <= x < 2^64 in two steps; worst error 5e-7 + 2e-7 t relative where the result is
 * > 1e-6. First t log2 x, where x is at least LIMITS.tiny ... */
INNER float ISA(log_power)(float x, float t)
{
    const int32_t i = ISA(bits)(x);
    const int32_t e = (i - 0x3F3504F3) >> 23; /* mantissa in sqrt(1/2)..sqrt(2) */
    const float a = ISA(from_bits)(i - e * 0x800000);
    const float s = (a - 1.0f) / (a + 1.0f), z = s * s;
    const float l = s * (2.88539004f + z * (0.961798847f + z * (0.57671386f + z * 0.431748331f)));

    return t * (float)e + t * l;
}

/* ... then 2^y: the nearest integer goes to the exponent, the rest through a polynomial. */
INNER float ISA(exp2)(float y)
{
    const float h = ISA(from_bits)(ISA(bits)(y + 12582912.0f));
    const float r = y - (h - 12582912.0f);
    const float p =
        1.0f + r * (0.693147182f +
                    r * (0.240226477f +
                         r * (0.0555033237f +
                              r * (0.00961843692f + r * (0.0013398875f + r * 0.000153533605f)))));
    const int32_t n = ISA(bits)(h) - ISA(bits)(12582912.0f);

    return ISA(from_bits)(ISA(bits)(p) + (n < -120 ? -120 : n > 126 ? 126 : n) * 0x800000);
}
