/* SPDX-License-Identifier: MIT */
/* The loops of the float path for one instruction set. Included by kernel.c with
 *   ISA(name)   the name with the set's suffix
 *   TARGET      the attribute that turns the set on, or nothing
 *   INT_ORDER   1 if the set compares integers as fast as floats: then gcc finds the instruction
 * All loops run over whole blocks, so their length is known, and use no operation whose result
 * could differ between sets: no fused multiply-add, no reciprocal estimates, no reordered sums. */

#define INNER static TARGET LCOR_INLINE

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

/* The larger or smaller of x and a constant c >= 0. Floats order as their bits do there. */
INNER float ISA(at_least)(float x, float c)
{
#if INT_ORDER
    const int32_t a = ISA(bits)(x), b = ISA(bits)(c);

    return ISA(from_bits)(a > b ? a : b);
#else
    return x > c ? x : c;
#endif
}

INNER float ISA(at_most)(float x, float c)
{
#if INT_ORDER
    const int32_t a = ISA(bits)(x), b = ISA(bits)(c);

    return ISA(from_bits)(a < b ? a : b);
#else
    return x < c ? x : c;
#endif
}

INNER float ISA(clamp)(float x) { return ISA(at_most)(ISA(at_least)(x, 0.0f), 1.0f); }

/* Cube root of x >= 2^-100: worst relative error 1.4e-7 (tests/numeric/test_kernel.c), exact for 1.
 * z ~ x^(-1/3) within 3.5 % from a third of the exponent; y0 = x z^2 and e = 1 - y0 z give
 * y = y0 (1 - e)^(-2/3), a minimax polynomial for |e| < 0.1022. Rounding of y0 comes back through
 * e and is damped to a third, so that no Newton step and no division are needed. */
INNER float ISA(cbrt)(float x)
{
    const float z =
        ISA(from_bits)(1419899955 - (int32_t)((float)ISA(bits)(x) * 0.333333333f));
    const float y = x * z * z;
    const float e = 1.0f - y * z;
    const float p =
        0.6666666865f +
        e * (0.5555365086f + e * (0.4938009381f + e * (0.4585397243f + e * 0.4287317097f)));

    return y + y * (e * p);
}

/* f of eqs 2-4 (CIE 1976). The straight line is the cube root's tangent at (6/29)^3, so both parts
 * are cbrt(m) + slope (t - m) with m = max(t, (6/29)^3), and no choice is left. */
INNER float ISA(f)(float t)
{
    const float m = ISA(at_least)(t, 0.00885645207f);

    return ISA(cbrt)(m) + (t - m) * 7.78703703f; /* 841/108 */
}

#define F_BLACK 0.137931049f /* f(0) as the line above rounds it: 4/29 */

/* Its inverse; the slope is 108/841 to an ulp, chosen so that F_BLACK comes back as exactly 0. */
INNER float ISA(f_inverse)(float v)
{
    const float m = ISA(at_least)(v, 0.206896558f); /* 6/29 */

    return m * m * m + (v - m) * 0.128418565f;
}

/* x^t for 0 <= x < 2^64; worst error 5e-7 + 2e-7 t relative where the result is > 1e-6. */
INNER float ISA(pow)(float x, float t)
{
    const int32_t i = ISA(bits)(ISA(at_least)(x, 1e-30f));
    const int32_t e = (i - 0x3F3504F3) >> 23; /* mantissa in sqrt(1/2)..sqrt(2) */
    const float   a = ISA(from_bits)(i - e * 0x800000);
    const float   s = (a - 1.0f) / (a + 1.0f), z = s * s;
    const float   l = s * (2.88539008f + z * (0.961796694f + z * (0.57707802f + z * 0.4342f)));
    const float   y = t * (float)e + t * l;
    /* 2^y: the nearest integer goes to the exponent, the rest through a polynomial */
    const float   h = ISA(from_bits)(ISA(bits)(y + 12582912.0f));
    const float   r = y - (h - 12582912.0f);
    const float   p =
        1.0f + r * (0.693147180f +
                    r * (0.240226507f +
                         r * (0.0555041087f +
                              r * (0.00961812911f + r * (0.00133335581f + r * 0.000154035304f)))));
    const int32_t n = ISA(bits)(h) - ISA(bits)(12582912.0f);

    return x > 0.0f ? ISA(from_bits)(ISA(bits)(p) + (n < -120 ? -120 : n > 126 ? 126 : n) * 0x800000) : 0.0f;
}

/* n samples as floats in 0..1 */
static TARGET void ISA(widen)(lcor_sample type, const void *from, size_t n, float *restrict to)
{
    if (type == LCOR_U8) {
        const uint8_t *restrict s = from;

        for (size_t j = 0; j < n; j++)
            to[j] = (float)s[j] * (1.0f / 255.0f);
    } else if (type == LCOR_U16) {
        const uint16_t *restrict s = from;

        for (size_t j = 0; j < n; j++)
            to[j] = (float)s[j] * (1.0f / 65535.0f);
    } else {
        memcpy(to, from, n * sizeof *to);
    }
}

/* n floats, clamped, as samples; halves up */
static TARGET void ISA(narrow)(lcor_sample type, const float *restrict from, size_t n, void *to)
{
    if (type == LCOR_U8) {
        uint8_t *restrict d = to;

        for (size_t j = 0; j < n; j++)
            d[j] = (uint8_t)(int32_t)(ISA(clamp)(from[j]) * 255.0f + 0.5f);
    } else if (type == LCOR_U16) {
        uint16_t *restrict d = to;

        for (size_t j = 0; j < n; j++)
            d[j] = (uint16_t)(int32_t)(ISA(clamp)(from[j]) * 65535.0f + 0.5f);
    } else {
        float *restrict d = to;

        for (size_t j = 0; j < n; j++)
            d[j] = ISA(clamp)(from[j]);
    }
}

/* A full block of interleaved or planar samples. */
static TARGET void ISA(load)(const lcor_row_job *job, size_t at, lcor_block *restrict b)
{
    const lcor_plan  *p = job->plan;
    const lcor_sample type = p->in_type;
    const size_t      size = lcor_internal_sample_size(type);
    const char       *from = (const char *)job->texels + at * p->in.pixel_step * size;

    if (p->in.pixel_step == 3) {
        float LCOR_ALIGNED mixed[3 * LCOR_BLOCK];
        const float       *s = (const float *)(const void *)from;

        if (type != LCOR_F32) {
            ISA(widen)(type, from, 3 * LCOR_BLOCK, mixed);
            s = mixed;
        }
        for (size_t j = 0; j < LCOR_BLOCK; j++) {
            b->c[0][j] = s[3 * j];
            b->c[1][j] = s[3 * j + 1];
            b->c[2][j] = s[3 * j + 2];
        }
    } else {
        for (size_t k = 0; k < 3; k++)
            ISA(widen)(type, from + k * p->in.channel_step * size, LCOR_BLOCK, b->c[k]);
    }
}

/* Stored to linear. */
static TARGET void ISA(decode)(const lcor_plan *plan, lcor_block *restrict b)
{
    float *restrict c = b->c[0];
    const float g = plan->k.gamma;

    if (plan->colour.transfer == LCOR_TRANSFER_SRGB) {
        for (size_t j = 0; j < 3 * LCOR_BLOCK; j++) {
            const float p = ISA(pow)((c[j] + 0.055f) * (1.0f / 1.055f), 2.4f);

            c[j] = c[j] > 0.04045f ? p : c[j] * (1.0f / 12.92f);
        }
    } else {
        for (size_t j = 0; j < 3 * LCOR_BLOCK; j++)
            c[j] = ISA(pow)(c[j], g);
    }
}

/* Clamped linear to stored. */
static TARGET void ISA(encode)(const lcor_plan *plan, float *restrict c)
{
    const float g = plan->k.over_gamma;

    if (plan->colour.transfer == LCOR_TRANSFER_SRGB) {
        for (size_t j = 0; j < LCOR_BLOCK; j++) {
            const float x = ISA(clamp)(c[j]);
            const float p = 1.055f * ISA(pow)(x, 1.0f / 2.4f) - 0.055f;

            c[j] = x > 0.0031308f ? p : x * 12.92f;
        }
    } else {
        for (size_t j = 0; j < LCOR_BLOCK; j++)
            c[j] = ISA(pow)(ISA(clamp)(c[j]), g);
    }
}

/* T, and v of Ynew = clamp(v y + w), from float maps of a full block. */
static TARGET void ISA(maps)(const lcor_row_job *job, size_t at, lcor_block *restrict b)
{
    const lcor_kernel_constants *k = &job->plan->k;
    const float *restrict i = (const float *)job->illuminance + at;
    const float offset = k->offset;

    if (job->plan->reading == LCOR_READING_TEXEL) {
        const float slope = k->slope_texel;

        for (size_t j = 0; j < LCOR_BLOCK; j++)
            b->v[j] = ISA(at_most)(i[j] * slope, 1e30f);
    } else if (job->rho != NULL) {
        const float *restrict rho = (const float *)job->rho + at;
        const float slope = k->slope, ratio = k->ratio;

        for (size_t j = 0; j < LCOR_BLOCK; j++) {
            const float t = i[j] * rho[j] * slope + offset; /* eq 12 */

            b->fn[j] = t;
            b->v[j] = t > 0.0f ? ISA(at_most)(t * ratio / rho[j], 1e30f) : 0.0f; /* rule S1 */
        }
    } else {
        const float slope = k->slope_rho, over_rho = k->over_rho;

        for (size_t j = 0; j < LCOR_BLOCK; j++) {
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

static TARGET int ISA(any_suspect)(const float *restrict x, size_t n)
{
    int32_t any = 0;

    for (size_t j = 0; j < n; j++)
        any |= ISA(suspect)(x[j]);
    return any < 0;
}

/* J < J1 and J > J2 of eq 8 */
static TARGET void ISA(count)(const float *restrict t, size_t m, lcor_row_stats *stats)
{
    uint32_t low = 0, high = 0;

    for (size_t j = 0; j < m; j++) {
        low += t[j] < 0.0f;
        high += t[j] > 1.0f;
    }
    stats->clipped_low += low;
    stats->clipped_high += high;
}

/* T where it depends on the texel's own y; from_f: the planes hold f already */
static TARGET void ISA(display)(const lcor_kernel_constants *k, int from_f, lcor_block *restrict b)
{
    const float w = k->w, m3 = k->m[3], m4 = k->m[4], m5 = k->m[5];

    if (from_f) {
        for (size_t j = 0; j < LCOR_BLOCK; j++)
            b->fn[j] = b->v[j] * ISA(f_inverse)(b->c[1][j]) + w;
    } else {
        for (size_t j = 0; j < LCOR_BLOCK; j++)
            b->fn[j] = b->v[j] * (b->c[0][j] * m3 + b->c[1][j] * m4 + b->c[2][j] * m5) + w;
    }
}

/* Linear RGB to fx, fy, fz; Ynew and its f. */
static TARGET void ISA(lightness)(const lcor_kernel_constants *k, lcor_block *restrict b)
{
    const float m0 = k->m[0], m1 = k->m[1], m2 = k->m[2], m3 = k->m[3], m4 = k->m[4];
    const float m5 = k->m[5], m6 = k->m[6], m7 = k->m[7], m8 = k->m[8], w = k->w;

    for (size_t j = 0; j < LCOR_BLOCK; j++) {
        const float r = b->c[0][j], g = b->c[1][j], bl = b->c[2][j];
        const float x = r * m0 + g * m1 + bl * m2; /* eq 1 */
        const float y = r * m3 + g * m4 + bl * m5;
        const float z = r * m6 + g * m7 + bl * m8;
        const float y_new = ISA(clamp)(b->v[j] * y + w); /* eq 11, rule S7 */

        b->c[0][j] = ISA(f)(x);
        b->c[1][j] = ISA(f)(y);
        b->c[2][j] = ISA(f)(z);
        b->v[j] = y_new;
        b->fn[j] = ISA(f)(y_new); /* eq 13b */
    }
}

/* The same from fx, fy, fz of a converted texture. */
static TARGET void ISA(lightness_of_f)(const lcor_kernel_constants *k, lcor_block *restrict b)
{
    const float w = k->w;

    for (size_t j = 0; j < LCOR_BLOCK; j++) {
        const float y_new = ISA(clamp)(b->v[j] * ISA(f_inverse)(b->c[1][j]) + w);

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
static TARGET void ISA(chroma)(const lcor_kernel_constants *k, lcor_block *restrict b)
{
    float n[9];

    memcpy(n, k->n, sizeof n);
    for (size_t j = 0; j < LCOR_BLOCK; j++) {
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

/* How far outside 0..1 a colour is; <= 0 inside. */
INNER float ISA(excess)(float r, float g, float b)
{
    const float hi = r > g ? r : g, lo = r < g ? r : g;
    const float top = (hi > b ? hi : b) - 1.0f, bottom = 0.0f - (lo < b ? lo : b);

    return top > bottom ? top : bottom;
}

/* Flags of the pixels that left 0..1 by more than rounding, and their number. */
static TARGET uint32_t ISA(find_outside)(const lcor_block *restrict b, uint8_t *restrict flags)
{
    uint32_t count = 0;

    for (size_t j = 0; j < LCOR_BLOCK; j++) {
        const uint32_t out = ISA(excess)(b->c[0][j], b->c[1][j], b->c[2][j]) > 1e-6f;

        flags[j] = (uint8_t)out;
        count += out;
    }
    return count;
}

/* Rule S9 for all gathered pixels: the largest s in 0..1 such that chroma times s fits, by
 * regula falsi (Illinois) from s = 0, which is grey and fits, and s = 1, which does not. */
static TARGET void ISA(fit)(const lcor_kernel_constants *k, lcor_outside *restrict q)
{
    float LCOR_ALIGNED lo[LCOR_BLOCK], hi[LCOR_BLOCK], g_lo[LCOR_BLOCK], g_hi[LCOR_BLOCK];
    float n[9];

    memcpy(n, k->n, sizeof n);
    for (size_t j = 0; j < LCOR_BLOCK; j++) {
        float r, g, b;

        ISA(rgb)(n, q->fn[j] + q->kx[j], q->y[j], q->fn[j] + q->kz[j], &r, &g, &b);
        lo[j] = 0.0f;
        hi[j] = 1.0f;
        g_lo[j] = ISA(excess)(q->y[j], q->y[j], q->y[j]);
        g_hi[j] = ISA(excess)(r, g, b);
    }
    for (int i = 0; i < 10; i++)
        for (size_t j = 0; j < LCOR_BLOCK; j++) {
            const float d = g_hi[j] - g_lo[j];
            const float s = lo[j] - (hi[j] - lo[j]) * (g_lo[j] / (d > 1e-30f ? d : 1e-30f));
            float       r, g, b, e;

            ISA(rgb)(n, q->fn[j] + s * q->kx[j], q->y[j], q->fn[j] + s * q->kz[j], &r, &g, &b);
            e = ISA(excess)(r, g, b);
            /* the end that stays counts half next time */
            g_lo[j] = e > 0.0f ? g_lo[j] * 0.5f : e;
            g_hi[j] = e > 0.0f ? e : g_hi[j] * 0.5f;
            lo[j] = e > 0.0f ? lo[j] : s;
            hi[j] = e > 0.0f ? s : hi[j];
        }
    for (size_t j = 0; j < LCOR_BLOCK; j++)
        ISA(rgb)(n, q->fn[j] + lo[j] * q->kx[j], q->y[j], q->fn[j] + lo[j] * q->kz[j], &q->kx[j],
                 &q->kz[j], &q->fn[j]);
}

/* Linear RGB, clamped here, to what the device takes. */
static TARGET void ISA(to_device)(const lcor_plan *plan, float *restrict r, float *restrict g,
                                  float *restrict b)
{
    float *planes[3] = { r, g, b };

    for (int i = 0; i < 3; i++)
        if (plan->tone != NULL)
            lcor_internal_apply_tone(plan, planes[i]);
        else if (plan->colour.transfer != LCOR_TRANSFER_LINEAR)
            ISA(encode)(plan, planes[i]);
}

static TARGET void ISA(store)(const lcor_row_job *job, size_t at, const lcor_block *restrict b)
{
    const lcor_plan  *p = job->plan;
    const lcor_sample type = p->out_type;
    const size_t      size = lcor_internal_sample_size(type);
    char             *to = (char *)job->out + at * p->out.pixel_step * size;

    if (p->out.pixel_step == 3) {
        float LCOR_ALIGNED mixed[3 * LCOR_BLOCK];
        float             *d = type == LCOR_F32 ? (float *)(void *)to : mixed;

        for (size_t j = 0; j < LCOR_BLOCK; j++) {
            d[3 * j] = ISA(clamp)(b->c[0][j]);
            d[3 * j + 1] = ISA(clamp)(b->c[1][j]);
            d[3 * j + 2] = ISA(clamp)(b->c[2][j]);
        }
        if (type != LCOR_F32)
            ISA(narrow)(type, mixed, 3 * LCOR_BLOCK, to);
    } else {
        for (size_t k = 0; k < 3; k++)
            ISA(narrow)(type, b->c[k], LCOR_BLOCK, to + k * p->out.channel_step * size);
    }
}

static TARGET void ISA(flush)(const lcor_row_job *job, lcor_outside *restrict q)
{
    if (q->count == 0)
        return;
    ISA(fit)(&job->plan->k, q);
    ISA(to_device)(job->plan, q->kx, q->kz, q->fn);
    lcor_internal_store_scattered(job, q);
    q->count = 0;
}

/* After the block is stored: its pixels marked in `flags` are stored again once fitted. */
static TARGET void ISA(gather)(const lcor_row_job *job, size_t at, size_t m,
                               const lcor_block *restrict b, const uint8_t *restrict flags,
                               lcor_outside *restrict q)
{
    for (size_t j = 0; j < m; j++) {
        uint64_t eight;

        if (j % 8 == 0) {
            memcpy(&eight, flags + j, sizeof eight);
            if (eight == 0) {
                j += 7;
                continue;
            }
        }
        if (!flags[j])
            continue;
        q->kx[q->count] = b->kx[j];
        q->kz[q->count] = b->kz[j];
        q->fn[q->count] = b->fn[j];
        q->y[q->count] = b->v[j];
        q->at[q->count] = at + j;
        if (++q->count == LCOR_BLOCK)
            ISA(flush)(job, q);
    }
}

/* Is the row made of whole pixels, or of planes, without gaps? */
INNER int ISA(dense)(lcor_layout l)
{
    return l.pixel_step == 1 || (l.pixel_step == 3 && l.channel_step == 1);
}

/* Read the pixels of block `at` into b. Returns 1 if some may be bad. */
static TARGET int ISA(fill)(const lcor_row_job *job, size_t at, size_t m, lcor_block *restrict b)
{
    const lcor_plan *p = job->plan;
    const int        whole = m == LCOR_BLOCK;

    if (job->f != NULL) {
        if (!whole)
            memset(b->c, 0, sizeof b->c);
        for (size_t k = 0; k < 3; k++)
            memcpy(b->c[k], job->f + k * job->plane + at, m * sizeof b->c[k][0]);
    } else if (whole && p->decode_table == NULL && ISA(dense)(p->in)) {
        ISA(load)(job, at, b);
    } else {
        lcor_internal_load_strided(job, at, m, b);
    }
    if (whole && p->float_maps) {
        ISA(maps)(job, at, b);
        if (ISA(any_suspect)((const float *)job->illuminance + at, m) ||
            (job->rho != NULL && ISA(any_suspect)((const float *)job->rho + at, m)))
            return 1;
    } else {
        lcor_internal_load_maps(job, at, m, b);
    }
    return ISA(any_suspect)(b->c[0], 3 * LCOR_BLOCK);
}

static TARGET void ISA(count_display)(const lcor_row_job *job, size_t m, size_t bad,
                                      lcor_block *restrict b)
{
    if (job->plan->reading == LCOR_READING_TEXEL)
        ISA(display)(&job->plan->k, job->f != NULL, b);
    ISA(count)(b->fn, m, job->stats);
    if (job->plan->reading == LCOR_READING_TEXEL && job->plan->k.w < 0.0f)
        job->stats->clipped_low -= bad; /* they stand there as black */
}

static TARGET void ISA(row)(const lcor_row_job *job)
{
    const lcor_plan *p = job->plan;
    const int        keep_hue = p->gamut == LCOR_GAMUT_KEEP_HUE;
    lcor_block       b;
    lcor_outside     q;
    uint8_t          flags[LCOR_BLOCK];

    memset(&q, 0, sizeof q);
    for (size_t at = 0; at < job->n; at += LCOR_BLOCK) {
        const size_t m = job->n - at < LCOR_BLOCK ? job->n - at : LCOR_BLOCK;
        size_t       bad = 0;
        uint32_t     outside = 0;

        lcor_internal_prefetch(job, at + 2 * LCOR_BLOCK);
        if (ISA(fill)(job, at, m, &b))
            bad = lcor_internal_replace_bad(job, at, m, &b);
        if (job->f == NULL && p->decode_table == NULL && p->colour.transfer != LCOR_TRANSFER_LINEAR)
            ISA(decode)(p, &b);
        if (job->stats != NULL)
            ISA(count_display)(job, m, bad, &b);
        if (job->f != NULL)
            ISA(lightness_of_f)(&p->k, &b);
        else
            ISA(lightness)(&p->k, &b);
        ISA(chroma)(&p->k, &b);
        if (keep_hue || job->stats != NULL)
            outside = ISA(find_outside)(&b, flags);
        if (job->stats != NULL)
            job->stats->out_of_gamut += outside;
        ISA(to_device)(p, b.c[0], b.c[1], b.c[2]);
        if (m == LCOR_BLOCK && ISA(dense)(p->out))
            ISA(store)(job, at, &b);
        else
            lcor_internal_store_strided(job, at, m, b.c[0], b.c[1], b.c[2]);
        if (keep_hue && outside != 0)
            ISA(gather)(job, at, m, &b, flags, &q);
    }
    ISA(flush)(job, &q);
    if (job->stats != NULL)
        job->stats->pixels += job->n;
}

static TARGET void ISA(cube_root)(const float x[LCOR_BLOCK], float y[LCOR_BLOCK])
{
    for (size_t j = 0; j < LCOR_BLOCK; j++)
        y[j] = ISA(cbrt)(x[j]);
}

#undef INNER
#undef F_BLACK
