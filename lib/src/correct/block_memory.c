/* SPDX-License-Identifier: MIT */
/* Blocks between memory and float: every type and layout of samples, odd maps, bad numbers, tone
 * curves. What no instruction set makes faster is here, once. */
#include "correct/internal.h"
#include "correct/sample.h"

#include "base/internal.h"

#include <float.h>
#include <math.h>
#include <string.h>

int lcor_internal_is_interleaved(lcor_layout l) { return l.pixel_step == 3 && l.channel_step == 1; }

/* to[j] = value of sample s of pixel j */
#define LOAD(type, value)                                                                          \
    for (size_t j = 0; j < m; j++) {                                                               \
        const type s = ((const type *)from)[j * step];                                             \
                                                                                                   \
        to[j] = (value);                                                                           \
    }

static LCOR_APART void load_plane(const lcor_plan *p, const void *from, size_t step, size_t m,
                                  float *to)
{
    if (p->in_type == LCOR_F32) {
        LOAD(float, s)
    } else if (step == 1 && m == LCOR_BLOCK) {
        p->kernel.widen(p->in_type, 1, from, to);
    } else if (p->in_type == LCOR_U8) {
        LOAD(uint8_t, (float)s)
    } else {
        LOAD(uint16_t, (float)s)
    }
    for (size_t j = m; j < LCOR_BLOCK; j++)
        to[j] = 0.0f;
}

/* All three channels of a pixel at once: looking up one after the other is mostly counting. */
static void decode_bytes(const lcor_plan *p, const char *from, size_t m, lcor_block *b)
{
    const float *table = p->decode_floats;

    if (m < LCOR_BLOCK)
        memset(b->c, 0, 3 * sizeof b->c[0]);
    for (size_t j = 0; j < m; j++, from += p->in.pixel_step)
        for (size_t k = 0; k < 3; k++)
            b->c[k][j] = table[((const uint8_t *)from)[k * p->in.channel_step]];
}

void lcor_internal_load_texels(const lcor_row_job *job, size_t at, size_t m, lcor_block *b)
{
    const lcor_layout l = job->plan->in;
    const size_t size = lcor_internal_sample_size(job->plan->in_type);
    const char *from = (const char *)job->texels + at * l.pixel_step * size;

    if (job->plan->decode_table != NULL) {
        decode_bytes(job->plan, from, m, b);
        return;
    }
    for (size_t k = 0; k < 3; k++, from += l.channel_step * size)
        load_plane(job->plan, from, l.pixel_step, m, b->c[k]);
}

LCOR_COLD void lcor_internal_load_f(const lcor_row_job *job, size_t at, size_t m,
                                    float f[][LCOR_BLOCK])
{
    memset(f, 0, 3 * sizeof *f);
    for (size_t k = 0; k < 3; k++)
        memcpy(f[k], job->f + k * job->plane + at, m * sizeof(float));
}

static int valid(double x) { return x >= 0.0 && x <= DBL_MAX; }

LCOR_COLD int lcor_internal_load_maps(const lcor_row_job *job, size_t at, size_t m, lcor_block *b)
{
    const lcor_plan *p = job->plan;
    int suspect = 0;

    memset(b->v, 0, sizeof b->v);
    memset(b->t, 0, sizeof b->t);
    for (size_t j = 0; j < m; j++) {
        const double i = lcor_internal_load_sample(job->illuminance, p->map_type, at + j);
        const double rho =
            job->rho != NULL ? lcor_internal_load_sample(job->rho, p->map_type, at + j) : p->rho;
        double t, v;

        if (!valid(i) || !valid(rho)) {
            suspect = 1;
        } else if (p->reading == LCOR_READING_TEXEL) {
            v = p->r_mean > 0.0 ? i / p->r_mean * (p->gain * p->rho_ratio) : 0.0;
            b->v[j] = (float)fmin(v, 1e30);
        } else {
            t = lcor_internal_display(p->r_mean > 0.0 ? i * rho / p->r_mean : 0.0, p->exponent,
                                      p->gain);
            v = fmin(fmax(t, 0.0), DBL_MAX) * p->rho_ratio;
            b->t[j] = (float)fmin(fmax(t, -1e30), 1e30);
            b->v[j] = v > 0.0 ? (float)fmin(v / rho, 1e30) : 0.0f;
        }
    }
    return suspect;
}

/* What is bad becomes black; what is merely huge, huge but harmless. */
LCOR_COLD size_t lcor_internal_replace_bad(const lcor_row_job *job, size_t at, size_t m,
                                           float c[][LCOR_BLOCK], lcor_block *b)
{
    const lcor_plan *p = job->plan;
    const float huge = job->f != NULL ? 2097152.0f : 18446744073709551616.0f;
    size_t bad = 0;

    for (size_t j = 0; j < m; j++) {
        int good =
            valid(lcor_internal_load_sample(job->illuminance, p->map_type, at + j)) &&
            (job->rho == NULL || valid(lcor_internal_load_sample(job->rho, p->map_type, at + j)));

        for (size_t k = 0; k < 3; k++)
            good = good && c[k][j] >= 0.0f && c[k][j] <= FLT_MAX;
        for (size_t k = 0; k < 3; k++)
            c[k][j] = good ? fminf(c[k][j], huge) : 0.0f;
        if (good)
            continue;
        b->v[j] = 0.0f;
        b->t[j] = 0.5f; /* neither below J1 nor above J2 */
        bad++;
        if (job->stats != NULL && job->stats->non_finite++ == 0) {
            job->stats->first_bad_row = job->row;
            job->stats->first_bad_pixel = at + j;
        }
    }
    return bad;
}

/* 0..1; 0 for NaN */
static float clamped(float x) { return x > 0.0f ? (x < 1.0f ? x : 1.0f) : 0.0f; }

static void apply_tone(const lcor_plan *plan, float *values)
{
    const float last = (float)(plan->tone_size - 1);

    for (size_t j = 0; j < LCOR_BLOCK; j++) {
        const float x = clamped(values[j]) * last;
        const size_t i = x < last ? (size_t)x : plan->tone_size - 2;
        const float s = x - (float)i;

        values[j] = plan->tone[i] * (1.0f - s) + plan->tone[i + 1] * s;
    }
}

void lcor_internal_to_device(const lcor_plan *plan, float values[LCOR_BLOCK])
{
    if (plan->tone != NULL)
        apply_tone(plan, values);
    else if (plan->colour.transfer == LCOR_TRANSFER_SRGB)
        plan->kernel.to_srgb(values);
    else if (plan->colour.transfer != LCOR_TRANSFER_LINEAR)
        plan->kernel.power(&plan->k.encode, values);
}

/* to[j step] = from[j], m samples */
#define SCATTER(type)                                                                              \
    for (size_t j = 0; j < m; j++)                                                                 \
        ((type *)to)[j * step] = ((const type *)from)[j];

static LCOR_APART void scatter(lcor_sample type, const void *from, size_t m, void *to, size_t step)
{
    if (step == 1) {
        memcpy(to, from, m * lcor_internal_sample_size(type));
    } else if (type == LCOR_F32) {
        SCATTER(float)
    } else if (type == LCOR_U8) {
        SCATTER(uint8_t)
    } else {
        SCATTER(uint16_t)
    }
}

/* Values of 0..1 as the samples that go out: `values` themselves, or in `codes`. */
static LCOR_APART const void *as_samples(const lcor_plan *p, const float *values,
                                         uint16_t codes[LCOR_BLOCK])
{
    if (p->out_type == LCOR_F32)
        return values;
    p->kernel.narrow(p->out_type, 1, values, codes);
    return codes;
}

void lcor_internal_store_pixels(const lcor_row_job *job, size_t at, size_t m, lcor_block *b)
{
    const lcor_plan *p = job->plan;
    const lcor_layout l = p->out;
    const size_t size = lcor_internal_sample_size(p->out_type);
    char *to = (char *)job->out + at * l.pixel_step * size;
    uint16_t LCOR_ALIGNED codes[LCOR_BLOCK];
    float LCOR_ALIGNED pixels[3 * LCOR_BLOCK];

    if (m < LCOR_BLOCK || !lcor_internal_is_interleaved(l)) {
        p->kernel.clamp_planes(b->c[0]);
        for (size_t k = 0; k < 3; k++, to += l.channel_step * size)
            scatter(p->out_type, as_samples(p, b->c[k], codes), m, to, l.pixel_step);
    } else if (p->out_type == LCOR_F32) {
        p->kernel.interleave(b, (float *)(void *)to);
    } else if (p->out_type == LCOR_U8) {
        p->kernel.interleave_bytes(b, (uint8_t *)to);
    } else {
        p->kernel.interleave(b, pixels);
        p->kernel.narrow(p->out_type, 3, pixels, to);
    }
}

void lcor_internal_store_apart(const lcor_row_job *job, size_t count, const size_t *at,
                               float values[LCOR_BLOCK])
{
    const lcor_plan *p = job->plan;
    const size_t size = lcor_internal_sample_size(p->out_type);
    uint16_t LCOR_ALIGNED codes[LCOR_BLOCK];
    const char *from;

    for (size_t j = 0; j < 3 * count; j++)
        values[j] = clamped(values[j]);
    from = as_samples(p, values, codes);
    for (size_t i = 0; i < count; i++, from += 3 * size)
        scatter(p->out_type, from, 3, (char *)job->out + at[i] * p->out.pixel_step * size,
                p->out.channel_step);
}
