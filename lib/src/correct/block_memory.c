/* SPDX-License-Identifier: MIT */
/* Blocks between memory and float: every type and layout of samples, odd maps, bad numbers, tone
 * curves. What no instruction set makes faster is here, once. */
#include "correct/internal.h"
#include "correct/sample.h"

#include <float.h>
#include <math.h>
#include <string.h>

int lcor_internal_is_interleaved(lcor_layout l) { return l.pixel_step == 3 && l.channel_step == 1; }

/* copy[3 j + k] = value of sample s, for channel k of pixel j */
#define LOAD(type, value)                                                                          \
    for (size_t k = 0; k < 3; k++)                                                                 \
        for (size_t j = 0; j < m; j++) {                                                           \
            const type s =                                                                         \
                ((const type *)job->texels)[(at + j) * l.pixel_step + k * l.channel_step];         \
            copy[3 * j + k] = (value);                                                             \
        }

void lcor_internal_load_texels(const lcor_row_job *job, size_t at, size_t m, float *copy)
{
    const lcor_plan *p = job->plan;
    const lcor_layout l = p->in;

    if (m < LCOR_BLOCK)
        memset(copy, 0, 3 * LCOR_BLOCK * sizeof *copy);
    if (job->f != NULL) {
        for (size_t k = 0; k < 3; k++)
            memcpy(copy + k * LCOR_BLOCK, job->f + k * job->plane + at, m * sizeof *copy);
    } else if (p->decode_table != NULL) {
        LOAD(uint8_t, p->decode_table[s])
    } else if (p->in_type == LCOR_F32) {
        LOAD(float, s)
    } else if (m == LCOR_BLOCK && lcor_internal_is_interleaved(l)) {
        p->kernel->widen(p->in_type,
                         (const char *)job->texels + 3 * at * lcor_internal_sample_size(p->in_type),
                         copy);
    } else if (p->in_type == LCOR_U8) {
        LOAD(uint8_t, (float)s)
    } else {
        LOAD(uint16_t, (float)s)
    }
}

static int valid(double x) { return x >= 0.0 && x <= DBL_MAX; }

int lcor_internal_load_maps(const lcor_row_job *job, size_t at, size_t m, lcor_block *b)
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
size_t lcor_internal_replace_bad(const lcor_row_job *job, size_t at, size_t m, float *copy,
                                 lcor_block *b)
{
    const lcor_plan *p = job->plan;
    const float huge = job->f != NULL ? 2097152.0f : 18446744073709551616.0f;
    const size_t pixel_step = job->f != NULL ? 1 : 3, step = job->f != NULL ? LCOR_BLOCK : 1;
    size_t bad = 0;

    for (size_t j = 0; j < m; j++) {
        float *c = copy + j * pixel_step;
        int good =
            valid(lcor_internal_load_sample(job->illuminance, p->map_type, at + j)) &&
            (job->rho == NULL || valid(lcor_internal_load_sample(job->rho, p->map_type, at + j)));

        for (size_t k = 0; k < 3; k++)
            good = good && c[k * step] >= 0.0f && c[k * step] <= FLT_MAX;
        for (size_t k = 0; k < 3; k++)
            c[k * step] = good ? fminf(c[k * step], huge) : 0.0f;
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

static void apply_tone(const lcor_plan *plan, float *values)
{
    const float last = (float)(plan->tone_size - 1);

    for (size_t j = 0; j < LCOR_BLOCK; j++) {
        const float x = fminf(fmaxf(values[j], 0.0f), 1.0f) * last;
        const size_t i = x < last ? (size_t)x : plan->tone_size - 2;
        const float s = x - (float)i;

        values[j] = plan->tone[i] * (1.0f - s) + plan->tone[i + 1] * s;
    }
}

void lcor_internal_to_device(const lcor_plan *plan, float c[][LCOR_BLOCK])
{
    for (int k = 0; k < 3; k++)
        if (plan->tone != NULL)
            apply_tone(plan, c[k]);
        else if (plan->colour.transfer != LCOR_TRANSFER_LINEAR)
            plan->kernel->transfer(&plan->k.encode, c[k]);
}

/* d[j step] = value of c, clamped, for each pixel j of a plane */
#define STORE(type, value)                                                                         \
    for (size_t j = 0; j < m; j++) {                                                               \
        const float c = from[j] > 0.0f ? (from[j] < 1.0f ? from[j] : 1.0f) : 0.0f;                 \
        ((type *)to)[j * step] = (type)(value);                                                    \
    }

static void store_plane(lcor_sample type, const float *from, size_t m, void *to, size_t step)
{
    if (type == LCOR_F32) {
        STORE(float, c)
    } else if (type == LCOR_U8) {
        STORE(uint8_t, c * 255.0f + 0.5f)
    } else {
        STORE(uint16_t, c * 65535.0f + 0.5f)
    }
}

void lcor_internal_store_pixels(const lcor_row_job *job, size_t at, size_t m, lcor_block *b)
{
    const lcor_plan *p = job->plan;
    const lcor_layout l = p->out;
    const size_t size = lcor_internal_sample_size(p->out_type);
    char *to = (char *)job->out + at * l.pixel_step * size;
    float LCOR_ALIGNED pixels[3 * LCOR_BLOCK];

    if (m < LCOR_BLOCK || !lcor_internal_is_interleaved(l)) {
        for (size_t k = 0; k < 3; k++, to += l.channel_step * size)
            store_plane(p->out_type, b->c[k], m, to, l.pixel_step);
    } else if (p->out_type == LCOR_F32) {
        p->kernel->interleave(b, (float *)(void *)to);
    } else {
        p->kernel->interleave(b, pixels);
        p->kernel->narrow(p->out_type, pixels, to);
    }
}
