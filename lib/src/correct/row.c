/* SPDX-License-Identifier: MIT */
/* Rows: samples in and out of any type and layout around the kernels. */
#include "correct/lanes.h"
#include "correct/sample.h"

#include "base/internal.h"
#include "colour/internal.h"

#include <math.h>
#include <string.h>

/* The device's answer to linear 0..1: its tone curve, or the transfer function. */
static double encode(const lcor_plan *p, double linear)
{
    double x, i;

    if (p->tone == NULL)
        return lcor_transfer_from_linear(&p->colour, linear);
    x = linear * (double)(p->tone_size - 1);
    i = fmin(floor(x), (double)(p->tone_size - 2));
    x -= i;
    return (double)p->tone[(size_t)i] * (1.0 - x) + (double)p->tone[(size_t)i + 1] * x;
}

static void load_linear(const lcor_plan *p, const void *texels, size_t i, double rgb[3])
{
    const size_t at = i * p->in.pixel_step, step = p->in.channel_step;

    if (p->decode_table != NULL) {
        for (size_t c = 0; c < 3; c++)
            rgb[c] = p->decode_table[((const uint8_t *)texels)[at + c * step]];
        return;
    }
    for (size_t c = 0; c < 3; c++)
        rgb[c] = lcor_internal_load_sample(texels, p->in_type, at + c * step);
    for (size_t c = 0; p->colour.transfer != LCOR_TRANSFER_LINEAR && c < 3; c++)
        rgb[c] = lcor_transfer_to_linear(&p->colour, rgb[c]);
}

static void store_encoded(const lcor_plan *p, void *out, size_t i, const double rgb[3])
{
    for (size_t c = 0; c < 3; c++)
        lcor_internal_store_sample(
            out, p->out_type, i * p->out.pixel_step + c * p->out.channel_step, encode(p, rgb[c]));
}

static LCOR_APART double map_at(const lcor_plan *p, const void *map, size_t i, double otherwise)
{
    return map != NULL ? lcor_internal_load_sample(map, p->map_type, i) : otherwise;
}

static void count(lcor_row_stats *stats, size_t row, size_t pixel, unsigned flags)
{
    if ((flags & LCOR_PIXEL_BAD) && stats->non_finite++ == 0) {
        stats->first_bad_row = row;
        stats->first_bad_pixel = pixel;
    }
    stats->clipped_low += (flags & LCOR_PIXEL_LOW) != 0;
    stats->clipped_high += (flags & LCOR_PIXEL_HIGH) != 0;
    stats->out_of_gamut += (flags & LCOR_PIXEL_OUTSIDE) != 0;
}

void lcor_plan_reflectance_row(const lcor_plan *plan, size_t n, const void *texels,
                               const void *illuminance, const void *rho, double *r)
{
    const double *m = plan->f_from_rgb;

    for (size_t i = 0; i < n; i++) {
        double reflectance = map_at(plan, rho, i, plan->rho);

        if (plan->reading == LCOR_READING_TEXEL) {
            double rgb[3];

            load_linear(plan, texels, i, rgb);
            reflectance = (m[3] * rgb[0] + m[4] * rgb[1] + m[5] * rgb[2]) * plan->rho_ratio;
        }
        r[i] = map_at(plan, illuminance, i, 0.0) * reflectance;
        if (!(r[i] >= 0.0 && isfinite(r[i])))
            r[i] = 0.0;
    }
}

#define GATHER(type)                                                                               \
    for (size_t i = 0; i < count; i++)                                                             \
        to[i] = (double)((const type *)from)[(at + list[i]) * step];

static LCOR_APART void gather(lcor_sample type, const void *from, size_t at, size_t step,
                              const uint8_t *list, size_t count, double *to)
{
    switch (type) {
    case LCOR_F32: GATHER(float) break;
    case LCOR_F64: GATHER(double) break;
    case LCOR_U8: GATHER(uint8_t) break;
    case LCOR_U16: GATHER(uint16_t) break;
    }
}

static LCOR_APART void gather_texels(const lcor_plan *p, const void *texels, size_t at,
                                     const uint8_t *list, size_t count, lcor_lanes *lanes,
                                     size_t first)
{
    const size_t size = lcor_internal_sample_size(p->in_type);

    for (size_t k = 0; k < 3; k++) {
        double *to = lanes->c[k] + first;

        gather(p->in_type, (const char *)texels + k * p->in.channel_step * size, at,
               p->in.pixel_step, list, count, to);
        for (size_t i = 0; p->decode_table != NULL && i < count; i++)
            to[i] = p->decode_table[(size_t)to[i]];
    }
}

LCOR_COLD void lcor_internal_load_lanes(const lcor_row_job *job, size_t at, const uint8_t *list,
                                        size_t count, lcor_lanes *lanes, size_t first)
{
    const lcor_plan *p = job->plan;

    if (job->texels != NULL)
        gather_texels(p, job->texels, at, list, count, lanes, first);
    else
        for (size_t k = 0; k < 3; k++)
            gather(LCOR_F32, job->f + k * job->plane, at, 1, list, count, lanes->c[k] + first);
    gather(p->map_type, job->illuminance, at, 1, list, count, lanes->illuminance + first);
    if (job->rho != NULL)
        gather(p->map_type, job->rho, at, 1, list, count, lanes->rho + first);
    else
        for (size_t i = first; i < first + count; i++)
            lanes->rho[i] = p->rho;
}

static const uint8_t in_order[16] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};

static unsigned flags_of(const lcor_lanes *l, size_t j)
{
    if (l->good[j] == 0.0)
        return LCOR_PIXEL_BAD;
    return (l->t[j] < 0.0 ? LCOR_PIXEL_LOW : 0u) | (l->t[j] > 1.0 ? LCOR_PIXEL_HIGH : 0u) |
           (l->outside[j] != 0.0 ? LCOR_PIXEL_OUTSIDE : 0u);
}

/* Any row through the reference. */
static void correct_row_in_double(const lcor_row_job *job)
{
    lcor_lanes lanes;

    memset(&lanes, 0, sizeof lanes);
    for (size_t at = 0; at < job->n; at += LCOR_LANES) {
        const size_t m = job->n - at < LCOR_LANES ? job->n - at : LCOR_LANES;

        lcor_internal_load_lanes(job, at, in_order, m, &lanes, 0);
        lcor_internal_correct_lanes(job, &lanes);
        for (size_t j = 0; j < m; j++) {
            const double rgb[3] = {lanes.c[0][j], lanes.c[1][j], lanes.c[2][j]};

            store_encoded(job->plan, job->out, at + j, rgb);
            if (job->stats != NULL)
                count(job->stats, job->row, at + j, flags_of(&lanes, j));
        }
    }
    if (job->stats != NULL)
        job->stats->pixels += job->n;
}

static void correct(const lcor_row_job *job)
{
    if (job->plan->in_double)
        correct_row_in_double(job);
    else
        lcor_internal_correct_blocks(job);
}

void lcor_correct_row(const lcor_plan *plan, size_t row, size_t n, const void *texels,
                      const void *illuminance, const void *rho, void *out, lcor_row_stats *stats)
{
    const lcor_row_job job = {plan, row, n, texels, NULL, 0, illuminance, rho, out, stats};

    correct(&job);
}

void lcor_correct_texture_row(const lcor_plan *plan, size_t row, size_t n, const float *f,
                              size_t plane, const void *illuminance, const void *rho, void *out,
                              lcor_row_stats *stats)
{
    const lcor_row_job job = {plan, row, n, NULL, f, plane, illuminance, rho, out, stats};

    correct(&job);
}

LCOR_COLD void lcor_plan_texture_row(const lcor_plan *plan, size_t n, const void *texels, float *f,
                                     size_t plane)
{
    lcor_lanes lanes;

    memset(&lanes, 0, sizeof lanes);
    for (size_t at = 0; at < n; at += LCOR_LANES) {
        const size_t m = n - at < LCOR_LANES ? n - at : LCOR_LANES;

        gather_texels(plan, texels, at, in_order, m, &lanes, 0);
        lcor_internal_lanes_to_f(plan, &lanes);
        for (size_t k = 0; k < 3; k++)
            for (size_t j = 0; j < m; j++)
                f[k * plane + at + j] = lanes.good[j] != 0.0 ? (float)lanes.c[k][j] : NAN;
    }
}

LCOR_COLD void lcor_conventional_row(const lcor_plan *plan, size_t row, size_t n,
                                     const void *texels, const void *illuminance, const void *rho,
                                     void *out, lcor_row_stats *stats)
{
    for (size_t i = 0; i < n; i++) {
        const double light = map_at(plan, illuminance, i, 0.0) * map_at(plan, rho, i, plan->rho);
        double rgb[3];
        unsigned flags = 0;

        load_linear(plan, texels, i, rgb);
        for (int c = 0; c < 3; c++) {
            const double v = rgb[c] * light; /* eq 19 */

            if (!(v >= 0.0 && isfinite(v)))
                flags |= LCOR_PIXEL_BAD;
            else if (v > 1.0)
                flags |= LCOR_PIXEL_OUTSIDE;
            rgb[c] = fmin(v, 1.0);
        }
        if (flags & LCOR_PIXEL_BAD) {
            flags = LCOR_PIXEL_BAD;
            memset(rgb, 0, sizeof rgb);
        }
        store_encoded(plan, out, i, rgb);
        if (stats != NULL && flags != 0)
            count(stats, row, i, flags);
    }
    if (stats != NULL)
        stats->pixels += n;
}
