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
    for (size_t c = 0; c < 3; c++) {
        const size_t at = i * p->in.pixel_step + c * p->in.channel_step;

        if (p->decode_table != NULL) {
            rgb[c] = p->decode_table[((const uint8_t *)texels)[at]];
            continue;
        }
        rgb[c] = lcor_internal_load_sample(texels, p->in_type, at);
        if (p->colour.transfer != LCOR_TRANSFER_LINEAR)
            rgb[c] = lcor_transfer_to_linear(&p->colour, rgb[c]);
    }
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

static void load_texel(const lcor_plan *p, const void *texels, size_t i, lcor_lanes *lanes,
                       size_t lane)
{
    double rgb[3];

    load_linear(p, texels, i, rgb);
    for (int k = 0; k < 3; k++)
        lanes->c[k][lane] = rgb[k];
}

void lcor_internal_load_lane(const lcor_row_job *job, size_t i, lcor_lanes *lanes, size_t lane)
{
    const lcor_plan *p = job->plan;

    if (job->texels != NULL)
        load_texel(p, job->texels, i, lanes, lane);
    else
        for (size_t k = 0; k < 3; k++)
            lanes->c[k][lane] = (double)job->f[k * job->plane + i];
    lanes->illuminance[lane] = map_at(p, job->illuminance, i, 0.0);
    lanes->rho[lane] = map_at(p, job->rho, i, p->rho);
}

/* Any row through the reference. */
static void correct_row_in_double(const lcor_row_job *job)
{
    lcor_lanes lanes;

    memset(&lanes, 0, sizeof lanes);
    for (size_t at = 0; at < job->n; at += LCOR_LANES) {
        const size_t m = job->n - at < LCOR_LANES ? job->n - at : LCOR_LANES;

        for (size_t j = 0; j < m; j++)
            lcor_internal_load_lane(job, at + j, &lanes, j);
        lcor_internal_correct_lanes(job, &lanes);
        for (size_t j = 0; j < m; j++) {
            const double rgb[3] = {lanes.c[0][j], lanes.c[1][j], lanes.c[2][j]};

            store_encoded(job->plan, job->out, at + j, rgb);
            if (job->stats != NULL && lanes.flags[j] != 0)
                count(job->stats, job->row, at + j, lanes.flags[j]);
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

        for (size_t j = 0; j < m; j++)
            load_texel(plan, texels, at + j, &lanes, j);
        plan->kernel->lanes_to_f(plan, &lanes);
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
