/* SPDX-License-Identifier: MIT */
/* Steps of the float path that no instruction set makes faster: odd layouts, tables, odd numbers.
 */
#include "correct/internal.h"
#include "correct/sample.h"

#include <float.h>
#include <math.h>
#include <string.h>

void lcor_internal_load_strided(const lcor_row_job *job, size_t at, size_t m, lcor_block *b)
{
    const lcor_plan *p = job->plan;

    if (m < LCOR_BLOCK)
        memset(b->c, 0, sizeof b->c);
    for (size_t k = 0; k < 3; k++) {
        const size_t first = at * p->in.pixel_step + k * p->in.channel_step;

        for (size_t j = 0; j < m; j++) {
            const size_t i = first + j * p->in.pixel_step;

            if (p->decode_table != NULL)
                b->c[k][j] = p->decode_table[((const uint8_t *)job->texels)[i]];
            else if (p->in_type == LCOR_F32)
                b->c[k][j] = ((const float *)job->texels)[i];
            else if (p->in_type == LCOR_U8)
                b->c[k][j] = (float)((const uint8_t *)job->texels)[i] * (1.0f / 255.0f);
            else
                b->c[k][j] = (float)((const uint16_t *)job->texels)[i] * (1.0f / 65535.0f);
        }
    }
}

static int valid(double x) { return x >= 0.0 && x <= DBL_MAX; }

void lcor_internal_load_maps(const lcor_row_job *job, size_t at, size_t m, lcor_block *b)
{
    const lcor_plan *p = job->plan;

    memset(b->v, 0, sizeof b->v);
    memset(b->t, 0, sizeof b->t);
    for (size_t j = 0; j < m; j++) {
        const double i = lcor_internal_load_sample(job->illuminance, p->map_type, at + j);
        const double rho =
            job->rho != NULL ? lcor_internal_load_sample(job->rho, p->map_type, at + j) : p->rho;
        double t, v;

        if (!valid(i) || !valid(rho)) {
            b->c[0][j] = NAN; /* found by the check of the planes */
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
}

/* Rule S10: what is bad becomes black; what is merely huge, huge but harmless. Returns how many
 * pixels were bad. */
size_t lcor_internal_replace_bad(const lcor_row_job *job, size_t at, size_t m, lcor_block *b)
{
    const lcor_plan *p = job->plan;
    const float huge = job->f != NULL ? 2097152.0f : 18446744073709551616.0f;
    size_t bad = 0;

    for (size_t j = 0; j < m; j++) {
        int good =
            valid(lcor_internal_load_sample(job->illuminance, p->map_type, at + j)) &&
            (job->rho == NULL || valid(lcor_internal_load_sample(job->rho, p->map_type, at + j)));

        for (size_t k = 0; k < 3; k++)
            good = good && b->c[k][j] >= 0.0f && b->c[k][j] <= FLT_MAX;
        for (size_t k = 0; k < 3; k++)
            b->c[k][j] = good ? fminf(b->c[k][j], huge) : 0.0f;
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

static void store(const lcor_plan *p, void *out, size_t i, float x)
{
    const float v = x > 0.0f ? (x < 1.0f ? x : 1.0f) : 0.0f;

    if (p->out_type == LCOR_F32)
        ((float *)out)[i] = v;
    else if (p->out_type == LCOR_U8)
        ((uint8_t *)out)[i] = (uint8_t)(v * 255.0f + 0.5f);
    else
        ((uint16_t *)out)[i] = (uint16_t)(v * 65535.0f + 0.5f);
}

void lcor_internal_store_strided(const lcor_row_job *job, size_t at, size_t m, const lcor_block *b)
{
    const lcor_layout l = job->plan->out;

    for (size_t j = 0; j < m; j++)
        for (size_t k = 0; k < 3; k++)
            store(job->plan, job->out, (at + j) * l.pixel_step + k * l.channel_step, b->c[k][j]);
}
