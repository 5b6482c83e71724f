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

/* Samples of one or three planes as floats in 0..1. */
STAGE void ISA(widen)(lcor_sample type, const void *from, size_t planes, float *restrict to)
{
    if (type == LCOR_F32) {
        memcpy(to, from, planes * LCOR_BLOCK * sizeof *to);
    } else if (type == LCOR_U8) {
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

/* Floats, clamped, as samples; halves up. */
STAGE void ISA(narrow)(lcor_sample type, const float *restrict from, size_t planes, void *to)
{
    if (type == LCOR_F32) {
        float *restrict d = to;

        for (; planes > 0; planes--, d += LCOR_BLOCK, from += LCOR_BLOCK)
            EACH (j, LCOR_BLOCK)
                d[j] = ISA(clamp)(from[j]);
    } else if (type == LCOR_U8) {
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

/* A full block of interleaved or planar samples. */
STAGE void ISA(load)(const lcor_row_job *job, size_t at, lcor_block *restrict b)
{
    const lcor_plan *p = job->plan;
    const lcor_sample type = p->in_type;
    const size_t size = lcor_internal_sample_size(type);
    const char *from = (const char *)job->texels + at * p->in.pixel_step * size;

    if (p->in.pixel_step == 3) {
        float LCOR_ALIGNED mixed[3 * LCOR_BLOCK];
        const float *s = (const float *)(const void *)from;

        if (type != LCOR_F32) {
            ISA(widen)(type, from, 3, mixed);
            s = mixed;
        }
        EACH (j, LCOR_BLOCK) {
            b->c[0][j] = s[3 * j];
            b->c[1][j] = s[3 * j + 1];
            b->c[2][j] = s[3 * j + 2];
        }
    } else {
        for (size_t k = 0; k < 3; k++)
            ISA(widen)(type, from + k * p->in.channel_step * size, 1, b->c[k]);
    }
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

            b->fn[j] = t;
            b->v[j] = t > 0.0f ? ISA(at_most)(t * ratio / rho[j], 1e30f) : 0.0f; /* rule S1 */
        }
    } else {
        const float slope = k->slope_rho, over_rho = k->over_rho;

        EACH (j, LCOR_BLOCK) {
            const float t = i[j] * slope + offset; /* eq 12 */

            b->fn[j] = t;
            b->v[j] = ISA(at_most)(ISA(at_least)(t, 0.0f) * over_rho, 1e30f);
        }
    }
}

/* The sign bit is set if a value is negative (or -0), NaN, infinite or 2^64 and more. */
INNER int32_t ISA(suspect)(float x)
{
    const uint32_t u = (uint32_t)ISA(bits)(x);

    return (int32_t)(u | (u + 0x20800000u));
}

STAGE int ISA(any_suspect)(const float *restrict x, size_t planes)
{
    int32_t any = 0;

    for (; planes > 0; planes--, x += LCOR_BLOCK)
        EACH (j, LCOR_BLOCK)
            any |= ISA(suspect)(x[j]);
    return any < 0;
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

/* Linear RGB to fx, fy, fz; Ynew and its f. */
STAGE void ISA(lightness)(const lcor_kernel_constants *k, lcor_block *restrict b)
{
    const float m0 = k->m[0], m1 = k->m[1], m2 = k->m[2], m3 = k->m[3], m4 = k->m[4];
    const float m5 = k->m[5], m6 = k->m[6], m7 = k->m[7], m8 = k->m[8], w = k->w;

    EACH (j, LCOR_BLOCK) {
        const float r = b->c[0][j], g = b->c[1][j], bl = b->c[2][j];
        const float x = r * m0 + g * m1 + bl * m2; /* eq 1 */
        const float y = r * m3 + g * m4 + bl * m5;
        const float z = r * m6 + g * m7 + bl * m8;
        const float t = b->v[j] * y + w;   /* eq 11; T itself where w is not 0 */
        const float y_new = ISA(clamp)(t); /* rule S7 */

        b->c[0][j] = ISA(f)(x);
        b->c[1][j] = ISA(f)(y);
        b->c[2][j] = ISA(f)(z);
        b->kx[j] = t;
        b->v[j] = y_new;
        b->fn[j] = ISA(f)(y_new); /* eq 13b */
    }
}

/* The same from fx, fy, fz of a converted texture. */
STAGE void ISA(lightness_of_f)(const lcor_kernel_constants *k, lcor_block *restrict b)
{
    const float w = k->w;

    EACH (j, LCOR_BLOCK) {
        const float t = b->v[j] * ISA(f_inverse)(b->c[1][j]) + w;
        const float y_new = ISA(clamp)(t);

        b->kx[j] = t;
        b->v[j] = y_new;
        b->fn[j] = ISA(f)(y_new);
    }
}

INNER void ISA(rgb)(const float *n, float fx, float y, float fz, float *r, float *g, float *b)
{
    const float x = ISA(f_inverse)(fx), z = ISA(f_inverse)(fz);

    *r = n[0] * x + n[2] * z + n[1] * y;
    *g = n[3] * x + n[5] * z + n[4] * y;
    *b = n[6] * x + n[8] * z + n[7] * y;
}

/* k of eq 16, new chroma, and back to linear RGB, not yet clamped. */
STAGE void ISA(chroma)(const lcor_kernel_constants *k, lcor_block *restrict b)
{
    float n[9];

    memcpy(n, k->n, sizeof n);
    EACH (j, LCOR_BLOCK) {
        const float fx = b->c[0][j], fy = b->c[1][j], fz = b->c[2][j], fn = b->fn[j];
        /* both branches are (h - fn) / (h - fy); 1e-10 only keeps 0 / 0 away (rules S5, S6) */
        const float h = fn > fy ? 1.0f : F_BLACK;
        const float chroma = (h - fn) / (h - fy - 1e-10f); /* eq 16 */
        const float kx = chroma * (fx - fy);               /* eq 14 */
        const float kz = chroma * (fz - fy);               /* eq 15 */

        b->kx[j] = kx;
        b->kz[j] = kz;
        ISA(rgb)(n, fn + kx, b->v[j], fn + kz, &b->c[0][j], &b->c[1][j], &b->c[2][j]);
    }
}

/* The sign bit is set if x left 0..1 by more than rounding, which near 0 is the smaller the darker
 * the colour. */
INNER uint32_t ISA(is_outside)(float x, float slack)
{
    return (uint32_t)(ISA(bits)(x + slack) | ISA(bits)(1.0000002f - x));
}

STAGE void ISA(find_outside)(const lcor_block *restrict b, uint8_t *restrict flags)
{
    EACH (j, LCOR_BLOCK) {
        const float slack = b->v[j] * 2e-7f + 1e-8f;

        flags[j] =
            (uint8_t)((ISA(is_outside)(b->c[0][j], slack) | ISA(is_outside)(b->c[1][j], slack) |
                       ISA(is_outside)(b->c[2][j], slack)) >>
                      31);
    }
}

STAGE void ISA(store)(const lcor_row_job *job, size_t at, const lcor_block *restrict b)
{
    const lcor_plan *p = job->plan;
    const lcor_sample type = p->out_type;
    const size_t size = lcor_internal_sample_size(type);
    char *to = (char *)job->out + at * p->out.pixel_step * size;

    if (p->out.pixel_step == 3) {
        float LCOR_ALIGNED mixed[3 * LCOR_BLOCK];
        float *d = type == LCOR_F32 ? (float *)(void *)to : mixed;

        EACH (j, LCOR_BLOCK) {
            d[3 * j] = ISA(clamp)(b->c[0][j]);
            d[3 * j + 1] = ISA(clamp)(b->c[1][j]);
            d[3 * j + 2] = ISA(clamp)(b->c[2][j]);
        }
        if (type != LCOR_F32)
            ISA(narrow)(type, mixed, 3, to);
    } else {
        for (size_t k = 0; k < 3; k++)
            ISA(narrow)(type, b->c[k], 1, to + k * p->out.channel_step * size);
    }
}

STAGE void ISA(cube_root)(const float x[LCOR_BLOCK], float y[LCOR_BLOCK])
{
    EACH (j, LCOR_BLOCK)
        y[j] = ISA(cbrt)(x[j]);
}

static const lcor_kernel ISA(kernel) = {ISA_NAME,      ISA(load),         ISA(store),
                                        ISA(maps),     ISA(any_suspect),  ISA(count),
                                        ISA(transfer), ISA(lightness),    ISA(lightness_of_f),
                                        ISA(chroma),   ISA(find_outside), ISA(cube_root)};

#undef INNER
#undef STAGE
#undef F_BLACK
