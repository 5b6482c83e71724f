/* SPDX-License-Identifier: MIT */
/* The loops of the float path for one instruction set. Included by kernel.c with
 *   ISA(name)   the name with the set's suffix, ISA_NAME the set's name
 *   TARGET      the attribute that turns the set on, or nothing
 *   POOR        1 for SSE2: gcc finds no shuffles there between three planes and pixels, which then
 *               get loops of their own, and no instruction for the larger of two unsigned integers
 * All loops run over whole blocks, so their length is known, and use no operation whose result
 * could differ between sets: no fused multiply-add, no reciprocal estimates, no reordered sums. */

#define INNER static TARGET LCOR_INLINE
#define STAGE static TARGET LCOR_APART /* one copy: the code stays small */

#include "correct/kernel_arithmetic.h"

/* Is a value negative (or -0), NaN, infinite or 2^64 and more? Such are large as unsigned integers:
 * a loop keeps the largest, and asks at its end. */
INNER uint32_t ISA(doubt)(float x)
{
    const uint32_t u = (uint32_t)ISA(bits)(x);

    return POOR ? u | (u + 0x20800000u) : u;
}

INNER uint32_t ISA(larger)(uint32_t a, uint32_t b) { return POOR ? a | b : a > b ? a : b; }

INNER uint32_t ISA(doubt_of_three)(float x, float y, float z)
{
    return ISA(larger)(ISA(larger)(ISA(doubt)(x), ISA(doubt)(y)), ISA(doubt)(z));
}

INNER int ISA(is_suspect)(uint32_t worst) { return worst >= (POOR ? 0x80000000u : 0x5F800000u); }

/* T, and v of Ynew = clamp(v y + w). */
STAGE int ISA(maps)(const lcor_plan *p, const float *restrict i, const float *restrict rho,
                    lcor_block *restrict b)
{
    const lcor_kernel_constants *k = &p->k;
    const float offset = k->offset;
    uint32_t worst = 0;

    if (p->reading == LCOR_READING_TEXEL) {
        const float slope = k->slope_texel;

        EACH (j, LCOR_BLOCK) {
            b->v[j] = ISA(at_most)(i[j] * slope, 1e30f);
            worst = ISA(larger)(worst, ISA(doubt)(i[j]));
        }
    } else if (rho != NULL) {
        const float slope = k->slope, ratio = k->ratio;

        EACH (j, LCOR_BLOCK) {
            const float t = i[j] * rho[j] * slope + offset; /* eq 12 */

            b->t[j] = t;
            b->v[j] = t > 0.0f ? ISA(at_most)(t * ratio / rho[j], 1e30f) : 0.0f; /* rule S1 */
            worst = ISA(larger)(worst, ISA(larger)(ISA(doubt)(i[j]), ISA(doubt)(rho[j])));
        }
    } else {
        const float slope = k->slope_rho, over_rho = k->over_rho;

        EACH (j, LCOR_BLOCK) {
            const float t = i[j] * slope + offset; /* eq 12 */

            b->t[j] = t;
            b->v[j] = ISA(at_most)(ISA(at_least)(t, 0.0f) * over_rho, 1e30f);
            worst = ISA(larger)(worst, ISA(doubt)(i[j]));
        }
    }
    return ISA(is_suspect)(worst);
}

STAGE void ISA(widen)(lcor_sample type, const void *from, float *restrict to)
{
    if (type == LCOR_U8) {
        const uint8_t *restrict s = from;

        EACH (j, 3 * LCOR_BLOCK)
            to[j] = (float)s[j];
    } else {
        const uint16_t *restrict s = from;

        EACH (j, 3 * LCOR_BLOCK)
            to[j] = (float)s[j];
    }
}

/* A transfer function, or its inverse: a straight line up to a knee, then a power. */
STAGE int ISA(transfer)(const lcor_power *p, float *restrict c)
{
    const lcor_power q = *p;
    uint32_t worst = 0;

    EACH (j, LCOR_BLOCK) {
        const float x = ISA(at_most)(ISA(at_least)(c[j], 0.0f), q.top);
        const float y = q.scale * ISA(pow)(x * q.in_scale + q.in_offset, q.exponent) + q.offset;

        worst = ISA(larger)(worst, ISA(doubt)(c[j]));
        c[j] = x > q.knee ? y : x * q.slope;
    }
    return ISA(is_suspect)(worst);
}

/* J < J1 and J > J2 of eq 8 */
STAGE void ISA(count)(const float *restrict t, lcor_row_stats *stats)
{
    uint32_t low = 0, high = 0;

    EACH (j, LCOR_BLOCK) {
        low += t[j] < 0.0f;
        high += t[j] > 1.0f;
    }
    stats->clipped_low += low;
    stats->clipped_high += high;
}

#if POOR
#define CHANNEL(k) split[k][j]
#else
#define CHANNEL(k) rgb[3 * j + (k)]
#endif

/* Linear RGB to X, Y, Z over white; Ynew. */
STAGE int ISA(lightness)(const lcor_kernel_constants *k, const float *restrict rgb,
                         lcor_block *restrict b)
{
    const float x_r = k->m[0][0], x_g = k->m[0][1], x_b = k->m[0][2];
    const float y_r = k->m[1][0], y_g = k->m[1][1], y_b = k->m[1][2];
    const float z_r = k->m[2][0], z_g = k->m[2][1], z_b = k->m[2][2], w = k->w;
    uint32_t worst = 0;
#if POOR
    float LCOR_ALIGNED split[3][LCOR_BLOCK];

    EACH (j, LCOR_BLOCK)
        for (int i = 0; i < 3; i++)
            split[i][j] = rgb[3 * j + (size_t)i];
#endif
    EACH (j, LCOR_BLOCK) {
        const float r = CHANNEL(0), g = CHANNEL(1), bl = CHANNEL(2);
        const float y = r * y_r + g * y_g + bl * y_b; /* eq 1 */
        const float t = b->v[j] * y + w;              /* eq 11; T itself where w is not 0 */

        b->c[0][j] = r * x_r + g * x_g + bl * x_b;
        b->c[1][j] = y;
        b->c[2][j] = r * z_r + g * z_g + bl * z_b;
        b->c[3][j] = b->y_new[j] = ISA(clamp)(t); /* rule S7 */
        b->t[j] = w < 0.0f ? t : b->t[j];
        worst = ISA(larger)(worst, ISA(doubt_of_three)(r, g, bl));
    }
    return ISA(is_suspect)(worst);
}

/* The same where fx, fy, fz of a converted texture are there already; they become 1 - f. */
STAGE int ISA(lightness_of_f)(const lcor_kernel_constants *k, const float *restrict f, size_t plane,
                              lcor_block *restrict b)
{
    const float *restrict f_x = f, *restrict f_y = f + plane, *restrict f_z = f + 2 * plane;
    const float w = k->w;
    uint32_t worst = 0;

    EACH (j, LCOR_BLOCK) {
        const float fx = f_x[j], fy = f_y[j], fz = f_z[j];
        const float t = b->v[j] * ISA(f_inverse)(fy) + w;

        b->c[0][j] = 1.0f - fx;
        b->c[1][j] = 1.0f - fy;
        b->c[2][j] = 1.0f - fz;
        b->c[3][j] = b->y_new[j] = ISA(clamp)(t);
        b->t[j] = w < 0.0f ? t : b->t[j];
        worst = ISA(larger)(worst, ISA(doubt_of_three)(fx, fy, fz));
    }
    return ISA(is_suspect)(worst);
}

/* 1 - f of eqs 2-4 over planes. Two loops, since a processor looks ahead over so many instructions
 * only: of two short chains of them it overlaps more than of a long one. So below. */
STAGE void ISA(g)(float *restrict c, size_t planes)
{
    for (; planes > 0; planes--, c += LCOR_BLOCK) {
        float LCOR_ALIGNED c0[LCOR_BLOCK], e[LCOR_BLOCK];

        EACH (j, LCOR_BLOCK) {
            const float m = ISA(above_knee)(c[j]);
            const float z = ISA(inverse_root)(m);
            const float root = m * z * z;

            c0[j] = root;
            e[j] = 1.0f - root * z;
            c[j] = (c[j] - m) * 7.78703703f; /* 841/108 */
        }
        EACH (j, LCOR_BLOCK)
            c[j] = ISA(g_of)(c0[j], e[j], c[j]);
    }
}

/* k of eq 16, new chroma, and back to linear RGB, not yet clamped. */
STAGE void ISA(chroma)(const lcor_kernel_constants *k, lcor_block *restrict b)
{
    const float r_x = k->n[0][0], r_z = k->n[0][1], g_x = k->n[1][0], g_z = k->n[1][1];
    const float b_x = k->n[2][0], b_z = k->n[2][1];

    EACH (j, LCOR_BLOCK) {
        const float gy = b->c[1][j], gn = ISA(at_least)(b->c[3][j], 0.0f);
        /* Both branches of eq 16 are (h - gn) / (h - gy). White stays white: 0 < 1e-9 and k is 0,
         * whatever the texel; 1e-20 only keeps 0 / 0 away (rules S5, S6). */
        const float h = gn < ISA(at_least)(gy, 1e-9f) ? 0.0f : G_BLACK;
        const float chroma = (h - gn) / (h - gy - 1e-20f);

        b->c[0][j] = (1.0f - gn) + chroma * (gy - b->c[0][j]); /* eq 14 */
        b->c[2][j] = (1.0f - gn) + chroma * (gy - b->c[2][j]); /* eq 15 */
    }
    EACH (j, LCOR_BLOCK) {
        const float y_new = b->y_new[j];
        const float dx = ISA(f_inverse)(b->c[0][j]) - y_new;
        const float dz = ISA(f_inverse)(b->c[2][j]) - y_new;

        b->c[0][j] = y_new + (r_x * dx + r_z * dz);
        b->c[1][j] = y_new + (g_x * dx + g_z * dz);
        b->c[2][j] = y_new + (b_x * dx + b_z * dz);
    }
}

/* Marks the pixels that left 0..1 or are so near its faces that float cannot tell. Near black and
 * white everything is small, and they themselves are inside. */
STAGE void ISA(find_outside)(const lcor_block *restrict b, int32_t *restrict outside)
{
    EACH (j, LCOR_BLOCK) {
        const float y = b->y_new[j], low = y * 4e-6f, high = 1.0f - (1.0f - y) * 4e-6f;
        const float r = b->c[0][j], g = b->c[1][j], bl = b->c[2][j];

        outside[j] = (ISA(bits)(r - low) | ISA(bits)(g - low) | ISA(bits)(bl - low) |
                      ISA(bits)(high - r) | ISA(bits)(high - g) | ISA(bits)(high - bl)) &
                     INT32_MIN;
    }
}

/* RGB clamped to 0..1, as pixels. */
STAGE void ISA(interleave)(lcor_block *restrict b, float *restrict to)
{
#if POOR
    for (int i = 0; i < 3; i++)
        EACH (j, LCOR_BLOCK)
            b->c[i][j] = ISA(clamp)(b->c[i][j]);
    EACH (j, LCOR_BLOCK)
        for (int i = 0; i < 3; i++)
            to[3 * j + (size_t)i] = b->c[i][j];
#else
    EACH (j, LCOR_BLOCK) {
        to[3 * j] = ISA(clamp)(b->c[0][j]);
        to[3 * j + 1] = ISA(clamp)(b->c[1][j]);
        to[3 * j + 2] = ISA(clamp)(b->c[2][j]);
    }
#endif
}

/* 0..1 to codes; halves go up. */
STAGE void ISA(narrow)(lcor_sample type, const float *restrict from, void *to)
{
    if (type == LCOR_U8) {
        uint8_t *restrict d = to;

        EACH (j, 3 * LCOR_BLOCK)
            d[j] = (uint8_t)(int32_t)(from[j] * 255.0f + 0.5f);
    } else {
        uint16_t *restrict d = to;

        EACH (j, 3 * LCOR_BLOCK)
            d[j] = (uint16_t)(int32_t)(from[j] * 65535.0f + 0.5f);
    }
}

static const lcor_kernel ISA(kernel) = {
    ISA_NAME,   ISA(maps), ISA(widen),  ISA(transfer),     ISA(lightness),  ISA(lightness_of_f),
    ISA(count), ISA(g),    ISA(chroma), ISA(find_outside), ISA(interleave), ISA(narrow)};

#undef INNER
#undef CHANNEL
#undef STAGE
#undef G_BLACK
