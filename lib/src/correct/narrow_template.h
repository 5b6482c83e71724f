/* SPDX-License-Identifier: MIT */
/* Loops of the float path that AVX-512 takes from AVX2: wider vectors gain little there, and code
 * is large. See kernel_template.h. */

/* T, and v of Ynew = clamp(v y + w). */
STAGE int ISA(maps)(const lcor_plan *p, const float *restrict i, const float *restrict rho,
                    lcor_block *restrict b)
{
    const lcor_kernel_constants *k = &p->k;
    const float offset = k->offset, huge = ISA(limits).huge, zero = ISA(limits).zero;
    uint32_t worst = 0;

    if (p->reading == LCOR_READING_TEXEL) {
        const float slope = k->slope_texel;

        EACH (j, LCOR_BLOCK) {
            b->v[j] = ISA(at_most)(i[j] * slope, huge);
            worst = ISA(larger)(worst, ISA(doubt)(i[j]));
        }
    } else if (rho != NULL) {
        const float slope = k->slope, ratio = k->ratio;

        EACH (j, LCOR_BLOCK) {
            const float t = i[j] * rho[j] * slope + offset; /* eq 12 */

            b->t[j] = t;
            b->v[j] = t > 0.0f ? ISA(at_most)(t * ratio / rho[j], huge) : 0.0f; /* rule S1 */
            worst = ISA(larger)(worst, ISA(larger)(ISA(doubt)(i[j]), ISA(doubt)(rho[j])));
        }
    } else {
        const float slope = k->slope_rho, over_rho = k->over_rho;

        EACH (j, LCOR_BLOCK) {
            const float t = i[j] * slope + offset; /* eq 12 */

            b->t[j] = t;
            b->v[j] = ISA(at_most)(ISA(at_least)(t, zero) * over_rho, huge);
            worst = ISA(larger)(worst, ISA(doubt)(i[j]));
        }
    }
    return ISA(is_suspect)(worst);
}

/* Pixels of three bytes, each moved at once with the byte after it, to words and back. Words split
 * into planes by shifts, where three bytes take a processor without byte shuffles many steps. */
INNER unsigned ISA(shift_of_byte)(int i)
{
    const uint32_t word = 0x00010203;
    uint8_t first;

    memcpy(&first, &word, 1);
    return 8u * (unsigned)(first == 0 ? 3 - i : i); /* the highest byte is first, or last */
}

STAGE void ISA(bytes_to_words)(const uint8_t *restrict rgb, uint32_t *restrict words)
{
    const size_t last = LCOR_BLOCK - 1;

    MOVE_EACH (j, last)
        memcpy(&words[j], rgb + 3 * j, 4);
    memcpy(&words[last], rgb + 3 * last, 3);
}

/* lightness of RGB that lies in the planes b->c. */
STAGE int ISA(lightness_of_planes)(const lcor_kernel_constants *k, lcor_block *restrict b)
{
    const lcor_kernel_constants q = *k;
    const float zero = ISA(limits).zero, one = ISA(limits).one;
    uint32_t worst = 0;

    EACH (j, LCOR_BLOCK)
        worst =
            ISA(larger)(worst, ISA(light)(&q, zero, one, b->c[0][j], b->c[1][j], b->c[2][j], j, b));
    return ISA(is_suspect)(worst);
}

/* lightness of codes, which cannot be bad. */
STAGE void ISA(lightness_of_bytes)(const lcor_kernel_constants *k, const uint8_t *restrict rgb,
                                   lcor_block *restrict b)
{
    const lcor_kernel_constants q = *k;
    const float zero = ISA(limits).zero, one = ISA(limits).one;
    uint32_t LCOR_ALIGNED words[LCOR_BLOCK];

    ISA(bytes_to_words)(rgb, words);
    EACH (j, LCOR_BLOCK) {
        float c[3];

        for (int i = 0; i < 3; i++)
            c[i] = (float)(int32_t)(words[j] >> ISA(shift_of_byte)(i) & 255);
        ISA(light)(&q, zero, one, c[0], c[1], c[2], j, b);
    }
}

STAGE void ISA(widen)(lcor_sample type, size_t blocks, const void *restrict from,
                      float *restrict to)
{
    for (size_t i = 0; i < blocks; i++, to += LCOR_BLOCK) {
        if (type == LCOR_U8) {
            const uint8_t *s = (const uint8_t *)from + i * LCOR_BLOCK;

            EACH (j, LCOR_BLOCK)
                to[j] = (float)s[j];
        } else {
            const uint16_t *s = (const uint16_t *)from + i * LCOR_BLOCK;

            EACH (j, LCOR_BLOCK)
                to[j] = (float)s[j];
        }
    }
}

/* Where fx, fy, fz of a converted texture are there already: 1 - f; Y, Ynew. */
STAGE int ISA(lightness_of_f)(const lcor_kernel_constants *k, const float *restrict f, size_t plane,
                              lcor_block *restrict b)
{
    const float *restrict f_x = f, *restrict f_y = f + plane, *restrict f_z = f + 2 * plane;
    const float w = k->w, zero = ISA(limits).zero, one = ISA(limits).one, knee = ISA(limits).f_knee;
    uint32_t worst = 0;

    EACH (j, LCOR_BLOCK) {
        const float fx = f_x[j], fy = f_y[j], fz = f_z[j], y = ISA(f_inverse)(fy, knee);

        b->g[0][j] = 1.0f - fx;
        b->g[1][j] = 1.0f - fy;
        b->g[2][j] = 1.0f - fz;
        b->c[1][j] = y;
        b->c[3][j] = ISA(clamp)(b->v[j] * y + w, zero, one);
        worst = ISA(larger)(worst, ISA(doubt_of_three)(fx, fy, fz));
    }
    return ISA(is_suspect)(worst);
}

/* J < J1 and J > J2 of eq 8 */
STAGE void ISA(count)(const lcor_kernel_constants *k, const lcor_block *restrict b,
                      lcor_row_stats *stats)
{
    const float w = k->w;
    uint32_t low = 0, high = 0;

    EACH (j, LCOR_BLOCK) {
        const float t = w < 0.0f ? b->v[j] * b->c[1][j] + w : b->t[j];

        low += t < 0.0f;
        high += t > 1.0f;
    }
    stats->clipped_low += low;
    stats->clipped_high += high;
}

/* Marks the pixels that left 0..1 or are so near its faces that float cannot tell, or not
 * accurately enough. Near black and white everything is small, and they themselves are inside. */
STAGE void ISA(find_outside)(const lcor_kernel_constants *k, const lcor_block *restrict b,
                             int32_t *restrict outside)
{
    const float dark = k->dark;

    EACH (j, LCOR_BLOCK) {
        const float y = b->c[3][j], low = y * dark, high = 1.0f - (1.0f - y) * 4e-6f;
        const float r = b->c[0][j], g = b->c[1][j], bl = b->c[2][j];

        outside[j] = (ISA(bits)(r - low) | ISA(bits)(g - low) | ISA(bits)(bl - low) |
                      ISA(bits)(high - r) | ISA(bits)(high - g) | ISA(bits)(high - bl)) &
                     INT32_MIN;
    }
}

/* RGB clamped to 0..1, as pixels. */
STAGE void ISA(interleave)(lcor_block *restrict b, float *restrict to)
{
    const float zero = ISA(limits).zero, one = ISA(limits).one;

#if POOR
    EACH (j, LCOR_BLOCK)
        for (size_t i = 0; i < 3; i++)
            b->c[i][j] = ISA(clamp)(b->c[i][j], zero, one);
    EACH (j, LCOR_BLOCK)
        for (size_t i = 0; i < 3; i++)
            to[3 * j + i] = b->c[i][j];
#else
    EACH (j, LCOR_BLOCK) {
        to[3 * j] = ISA(clamp)(b->c[0][j], zero, one);
        to[3 * j + 1] = ISA(clamp)(b->c[1][j], zero, one);
        to[3 * j + 2] = ISA(clamp)(b->c[2][j], zero, one);
    }
#endif
}

/* RGB clamped to 0..1, as pixels of three bytes. */
STAGE void ISA(interleave_bytes)(const lcor_block *restrict b, uint8_t *restrict to)
{
    const float zero = ISA(limits).zero, one = ISA(limits).one;
    const size_t last = LCOR_BLOCK - 1;
    uint32_t LCOR_ALIGNED words[LCOR_BLOCK];

    EACH (j, LCOR_BLOCK) {
        uint32_t word = 0;

        for (int i = 0; i < 3; i++)
            word |= (uint32_t)(int32_t)(ISA(clamp)(b->c[i][j], zero, one) * 255.0f + 0.5f)
                    << ISA(shift_of_byte)(i);
        words[j] = word;
    }
    MOVE_EACH (j, last)
        memcpy(to + 3 * j, &words[j], 4);
    memcpy(to + 3 * last, &words[last], 3);
}

STAGE int ISA(power)(const lcor_power *p, float *restrict c)
{
    const lcor_power q = *p;
    const float zero = ISA(limits).zero, tiny = ISA(limits).tiny;
    float LCOR_ALIGNED y[LCOR_BLOCK];
    uint32_t worst = 0;

    EACH (j, LCOR_BLOCK) {
        const float x = ISA(at_most)(ISA(at_least)(c[j], zero), q.top);

        worst = ISA(larger)(worst, ISA(doubt)(c[j]));
        y[j] = ISA(log_power)(ISA(at_least)(x * q.scale, tiny), q.exponent);
        c[j] = x;
    }
    EACH (j, LCOR_BLOCK)
        c[j] = c[j] > 0.0f ? ISA(exp2)(y[j]) : 0.0f;
    return ISA(is_suspect)(worst);
}

/* u^2.4 of u = scale x + offset above the knee: z ~ u^(-1/5) within 3.2 % from a fifth of the
 * exponent, then (u z)^3 and a polynomial for (1 + e)^(-3/5) - 1. Worst error 5.3e-7 relative;
 * white is 1 exactly. */
STAGE int ISA(from_srgb)(const lcor_srgb *s, float *restrict c)
{
    const lcor_srgb q = *s;
    const float zero = ISA(limits).zero;
    float LCOR_ALIGNED cube[LCOR_BLOCK], e[LCOR_BLOCK];
    uint32_t worst = 0;

    EACH (j, LCOR_BLOCK) {
        const float x = ISA(at_most)(ISA(at_least)(c[j], zero), q.top), u = x * q.scale + q.offset;
        const float z = ISA(from_bits)((int32_t)((float)ISA(bits)(u) * -0.2f) + 1277937859);
        const float uz = u * z, z2 = z * z;

        worst = ISA(larger)(worst, ISA(doubt)(c[j]));
        c[j] = x;
        cube[j] = uz * uz * uz;
        e[j] = uz * (z2 * z2) - 1.0f;
    }
    EACH (j, LCOR_BLOCK) {
        const float x = c[j], d = e[j], d2 = d * d;
        const float p = (5.28047117e-09f + d * -0.600000441f) +
                        d2 * ((0.479995131f + d * -0.415856332f) +
                              d2 * ((0.374995768f + d * -0.356765449f) + d2 * 0.308746547f));

        c[j] = x > q.knee ? cube[j] + cube[j] * p : x * q.slope;
    }
    return ISA(is_suspect)(worst);
}

/* Above the knee 1.055 x^(1/2.4) - 0.055, as 1.055 w^(5/6) - 0.055 of w = sqrt(x): z ~ w^(-1/6)
 * within 3.3 % from a sixth of the exponent, then w z and a polynomial for 1.055 (1 + e)^(-1/6)
 * - 1. Worst error 1.4e-7; white is 1 exactly. */
STAGE void ISA(to_srgb)(float *restrict c)
{
    const float zero = ISA(limits).zero, one = ISA(limits).one;
    float LCOR_ALIGNED wz[LCOR_BLOCK], e[LCOR_BLOCK];

    EACH (j, LCOR_BLOCK) {
        const float x = ISA(clamp)(c[j], zero, one), w = sqrtf(x);
        const float z = ISA(from_bits)((int32_t)((float)ISA(bits)(w) * -0.166666667f) + 1242448085);
        const float z2 = z * z;

        c[j] = x;
        wz[j] = w * z;
        e[j] = w * z * z * (z2 * z2) - 1.0f;
    }
    EACH (j, LCOR_BLOCK) {
        const float x = c[j], d = e[j], d2 = d * d;
        const float p =
            (0.0550000453f + d * -0.175833478f) +
            d2 * ((0.102544735f + d * -0.0740711727f) + d2 * (0.0607042245f + d * -0.0495214898f));

        c[j] = x > 0.0031308f ? wz[j] + (wz[j] * p - 0.055f) : x * 12.92f;
    }
}

STAGE void ISA(clamp_planes)(float *restrict c)
{
    const float zero = ISA(limits).zero, one = ISA(limits).one;

    EACH (j, 3 * LCOR_BLOCK)
        c[j] = ISA(clamp)(c[j], zero, one);
}

/* 0..1 to codes; halves go up. */
STAGE void ISA(narrow)(lcor_sample type, size_t blocks, const float *restrict from,
                       void *restrict to)
{
    for (size_t i = 0; i < blocks; i++, from += LCOR_BLOCK) {
        if (type == LCOR_U8) {
            uint8_t *d = (uint8_t *)to + i * LCOR_BLOCK;

            EACH (j, LCOR_BLOCK)
                d[j] = (uint8_t)(int32_t)(from[j] * 255.0f + 0.5f);
        } else {
            uint16_t *d = (uint16_t *)to + i * LCOR_BLOCK;

            EACH (j, LCOR_BLOCK)
                d[j] = (uint16_t)(int32_t)(from[j] * 65535.0f + 0.5f);
        }
    }
}
