/* SPDX-License-Identifier: MIT */
/* The loops of the float path for one instruction set. Included by kernel.c with
 *   ISA(name)   the name with the set's suffix, ISA_NAME the set's name
 *   TARGET      the attribute that turns the set on, or nothing
 *   INT_ORDER   1 if the set compares integers as fast as floats: then gcc finds the instruction
 * All loops run over whole blocks, so their length is known, and use no operation whose result
 * could differ between sets: no fused multiply-add, no reciprocal estimates, no reordered sums. */

#define INNER static TARGET LCOR_INLINE
#define STAGE static TARGET LCOR_APART /* one copy: the code stays small */

#include "correct/kernel_arithmetic.h"

/* Samples of some planes as floats in 0..1. */
STAGE void ISA(widen)(lcor_sample type, const void *from, size_t planes, float *restrict to)
{
    if (type == LCOR_U8) {
        const uint8_t *restrict s = from;

        for (; planes > 0; planes--, s += LCOR_BLOCK, to += LCOR_BLOCK)
            EACH (j, LCOR_BLOCK)
                to[j] = (float)s[j] * (1.0f / 255.0f);
    } else {
        const uint16_t *restrict s = from;

        for (; planes > 0; planes--, s += LCOR_BLOCK, to += LCOR_BLOCK)
            EACH (j, LCOR_BLOCK)
                to[j] = (float)s[j] * (1.0f / 65535.0f);
    }
}

/* Floats, clamped, as samples; halves go up. */
STAGE void ISA(narrow)(lcor_sample type, const float *restrict from, size_t planes, void *to)
{
    if (type == LCOR_U8) {
        uint8_t *restrict d = to;

        for (; planes > 0; planes--, d += LCOR_BLOCK, from += LCOR_BLOCK)
            EACH (j, LCOR_BLOCK)
                d[j] = (uint8_t)(int32_t)(ISA(clamp)(from[j]) * 255.0f + 0.5f);
    } else {
        uint16_t *restrict d = to;

        for (; planes > 0; planes--, d += LCOR_BLOCK, from += LCOR_BLOCK)
            EACH (j, LCOR_BLOCK)
                d[j] = (uint16_t)(int32_t)(ISA(clamp)(from[j]) * 65535.0f + 0.5f);
    }
}

STAGE void ISA(separate)(const float *restrict s, lcor_block *restrict b)
{
    EACH (j, LCOR_BLOCK) {
        b->c[0][j] = s[3 * j];
        b->c[1][j] = s[3 * j + 1];
        b->c[2][j] = s[3 * j + 2];
    }
}

/* Clamped, since that costs nothing here. */
STAGE void ISA(interleave)(const lcor_block *restrict b, float *restrict d)
{
    EACH (j, LCOR_BLOCK) {
        d[3 * j] = ISA(clamp)(b->c[0][j]);
        d[3 * j + 1] = ISA(clamp)(b->c[1][j]);
        d[3 * j + 2] = ISA(clamp)(b->c[2][j]);
    }
}

STAGE void ISA(clamp_plane)(const float *restrict from, float *restrict to)
{
    EACH (j, LCOR_BLOCK)
        to[j] = ISA(clamp)(from[j]);
}

/* A transfer function, or its inverse, over a plane: a straight line up to a knee, then a power. */
STAGE void ISA(transfer)(const lcor_power *p, float *restrict c)
{
    const lcor_power q = *p;

    EACH (j, LCOR_BLOCK) {
        const float x = ISA(at_most)(ISA(at_least)(c[j], 0.0f), q.top);
        const float y = q.scale * ISA(pow)(x * q.in_scale + q.in_offset, q.exponent) + q.offset;

        c[j] = x > q.knee ? y : x * q.slope;
    }
}

/* T, and v of Ynew = clamp(v y + w), from float maps of a full block. */
STAGE void ISA(maps)(const lcor_plan *p, const float *restrict i, const float *restrict rho,
                     lcor_block *restrict b)
{
    const lcor_kernel_constants *k = &p->k;
    const float offset = k->offset;

    if (p->reading == LCOR_READING_TEXEL) {
        const float slope = k->slope_texel;

        EACH (j, LCOR_BLOCK)
            b->v[j] = ISA(at_most)(i[j] * slope, 1e30f);
    } else if (rho != NULL) {
        const float slope = k->slope, ratio = k->ratio;

        EACH (j, LCOR_BLOCK) {
            const float t = i[j] * rho[j] * slope + offset; /* eq 12 */

            b->t[j] = t;
            b->v[j] = t > 0.0f ? ISA(at_most)(t * ratio / rho[j], 1e30f) : 0.0f; /* rule S1 */
        }
    } else {
        const float slope = k->slope_rho, over_rho = k->over_rho;

        EACH (j, LCOR_BLOCK) {
            const float t = i[j] * slope + offset; /* eq 12 */

            b->t[j] = t;
            b->v[j] = ISA(at_most)(ISA(at_least)(t, 0.0f) * over_rho, 1e30f);
        }
    }
}

/* Is a value negative (or -0), NaN, infinite or 2^64 and more? */
STAGE int ISA(any_suspect)(const float *restrict x, size_t planes)
{
    uint32_t any = 0;

    for (; planes > 0; planes--, x += LCOR_BLOCK)
        EACH (j, LCOR_BLOCK) {
            const uint32_t u = (uint32_t)ISA(bits)(x[j]);

            any |= u | (u + 0x20800000u); /* the sign bit */
        }
    return any >> 31 != 0;
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

/* Linear RGB to X, Y, Z over white; Ynew. */
STAGE void ISA(lightness)(const lcor_kernel_constants *k, lcor_block *restrict b)
{
    const float x_r = k->m[0][0], x_g = k->m[0][1], x_b = k->m[0][2];
    const float y_r = k->m[1][0], y_g = k->m[1][1], y_b = k->m[1][2];
    const float z_r = k->m[2][0], z_g = k->m[2][1], z_b = k->m[2][2], w = k->w;

    EACH (j, LCOR_BLOCK) {
        const float r = b->c[0][j], g = b->c[1][j], bl = b->c[2][j];
        const float y = r * y_r + g * y_g + bl * y_b; /* eq 1 */
        const float t = b->v[j] * y + w;              /* eq 11; T itself where w is not 0 */

        b->c[0][j] = r * x_r + g * x_g + bl * x_b;
        b->c[1][j] = y;
        b->c[2][j] = r * z_r + g * z_g + bl * z_b;
        b->c[3][j] = b->y_new[j] = ISA(clamp)(t); /* rule S7 */
        b->t[j] = t;
    }
}

/* The same where fx, fy, fz of a converted texture are there already; they become 1 - f. */
STAGE void ISA(lightness_of_f)(const lcor_kernel_constants *k, lcor_block *restrict b)
{
    const float w = k->w;

    EACH (j, LCOR_BLOCK) {
        const float fy = b->c[1][j];
        const float t = b->v[j] * ISA(f_inverse)(fy) + w;

        b->c[0][j] = 1.0f - b->c[0][j];
        b->c[1][j] = 1.0f - fy;
        b->c[2][j] = 1.0f - b->c[2][j];
        b->c[3][j] = b->y_new[j] = ISA(clamp)(t);
        b->t[j] = t;
    }
}

/* 1 - f of eqs 2-4 over planes. */
STAGE void ISA(g)(float *restrict c, size_t planes)
{
    for (; planes > 0; planes--, c += LCOR_BLOCK)
        EACH (j, LCOR_BLOCK)
            c[j] = ISA(g_of)(c[j]);
}

/* k of eq 16, new chroma, and back to linear RGB, not yet clamped. */
STAGE void ISA(chroma)(const lcor_kernel_constants *k, lcor_block *restrict b)
{
    const float r_x = k->n[0][0], r_z = k->n[0][1], g_x = k->n[1][0], g_z = k->n[1][1];
    const float b_x = k->n[2][0], b_z = k->n[2][1];

    EACH (j, LCOR_BLOCK) {
        const float gx = b->c[0][j], gy = b->c[1][j], gz = b->c[2][j];
        const float gn = ISA(at_least)(b->c[3][j], 0.0f), fn = 1.0f - gn, y_new = b->y_new[j];
        /* Both branches of eq 16 are (h - gn) / (h - gy). White stays white: 0 < 1e-9 and k is 0,
         * whatever the texel; 1e-20 only keeps 0 / 0 away (rules S5, S6). */
        const float h = gn < ISA(at_least)(gy, 1e-9f) ? 0.0f : G_BLACK;
        const float chroma = (h - gn) / (h - gy - 1e-20f);
        const float dx = ISA(f_inverse)(fn + chroma * (gy - gx)) - y_new; /* eq 14 */
        const float dz = ISA(f_inverse)(fn + chroma * (gy - gz)) - y_new; /* eq 15 */

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

static const lcor_kernel ISA(kernel) = {
    ISA_NAME,         ISA(separate),       ISA(interleave),  ISA(widen),  ISA(narrow),
    ISA(clamp_plane), ISA(maps),           ISA(any_suspect), ISA(count),  ISA(transfer),
    ISA(lightness),   ISA(lightness_of_f), ISA(g),           ISA(chroma), ISA(find_outside)};

#undef INNER
#undef STAGE
#undef G_BLACK
