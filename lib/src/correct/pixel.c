/* SPDX-License-Identifier: MIT */
/* The reference in double: what of it is one pixel at a time. */
#include "correct/lanes.h"
#include "correct/sample.h"

#include "base/elementary.h"
#include "base/internal.h"
#include "colour/internal.h"

#include <float.h>
#include <math.h>

double lcor_internal_display(double q, double exponent, double gain)
{
    /* eq 12 times rho: ((q^t (c+1)/2 - 1) / (c-1), written so that nothing cancels near q = 1 */
    return 0.5 + ((exponent == 1.0 ? q : lcor_internal_pow(q, exponent)) - 1.0) * gain;
}

LCOR_COLD double lcor_internal_chroma_factor(double y, double y_new)
{
    double f[2] = {y, y_new};

    for (int i = 0; i < 2; i++)
        f[i] = lcor_internal_f_cie(f[i]);
    return lcor_lane_chroma(f[0], f[1]);
}

/* 0..top; 0 for NaN */
static double clamped(double x, double top) { return x > 0.0 ? (x < top ? x : top) : 0.0; }

static int valid(double x) { return x >= 0.0 && x <= DBL_MAX; }

/* Samples to linear values. */
static void to_linear(const lcor_plan *p, double *c)
{
    enum { N = 3 * LCOR_LANES };
    const double unit = lcor_internal_unit(p->in_type);

    for (int j = 0; j < N; j++)
        c[j] /= unit;
    if (p->colour.transfer == LCOR_TRANSFER_SRGB)
        for (int j = 0; j < N; j++)
            c[j] = lcor_internal_from_srgb(c[j]);
    else if (p->colour.transfer != LCOR_TRANSFER_LINEAR)
        for (int j = 0; j < N; j++)
            c[j] = lcor_transfer_to_linear(&p->colour, c[j]);
}

void lcor_internal_lanes_to_f(const lcor_plan *p, lcor_lanes *l)
{
    if (p->decode_table == NULL) /* load_lanes did not look them up */
        to_linear(p, l->c[0]);
    p->kernel.lanes_to_f(p, l);
}

/* A texel that is f already. */
static LCOR_COLD void check_f(lcor_lightness lightness, lcor_lanes *l, size_t j)
{
    l->good[j] = 1.0;
    for (int i = 0; i < 3; i++)
        if (!isfinite(l->c[i][j]))
            l->good[j] = l->c[0][j] = l->c[1][j] = l->c[2][j] = 0.0;
    l->y[j] = clamped(lcor_internal_f_inverse(lightness, l->c[1][j]), DBL_MAX);
}

/* T of eq 12, and Ynew. */
static void set_luminance(const lcor_plan *p, lcor_lanes *l, size_t j)
{
    const double rho = l->rho[j], y_real = l->y[j] * p->rho_ratio; /* section 5.2 */
    const double r =
        l->illuminance[j] * (p->reading == LCOR_READING_TEXEL ? y_real : rho); /* 3.1 */
    double t = lcor_internal_display(p->r_mean > 0.0 ? r / p->r_mean : 0.0, p->exponent, p->gain);

    l->t[j] = t;
    t = clamped(t, DBL_MAX); /* rules S1, S4 */
    if (p->reading == LCOR_READING_PATCH && t > 0.0)
        t *= rho > 0.0 ? y_real / rho : 1.0; /* eq 11; rule S2 */
    l->y_new[j] = clamped(t, 1.0);           /* rule S7 */
    if (p->colour.lightness == LCOR_LIGHTNESS_PAPER)
        l->k[j] = lcor_internal_chroma_factor(l->y[j], l->y_new[j]);
}

void lcor_internal_correct_lanes(const lcor_row_job *job, lcor_lanes *l)
{
    const lcor_plan *p = job->plan;

    if (job->texels != NULL)
        lcor_internal_lanes_to_f(p, l);
    for (size_t j = 0; j < LCOR_LANES; j++) {
        if (job->texels == NULL)
            check_f(p->colour.lightness, l, j);
        if (!valid(l->illuminance[j]) || !valid(l->rho[j]))
            l->good[j] = 0.0;
        l->t[j] = l->y_new[j] = l->k[j] = 0.0;
        if (l->good[j] != 0.0)
            set_luminance(p, l, j);
    }
    p->kernel.lanes_to_rgb(p, l);
    for (int i = 0; i < 3; i++)
        for (size_t j = 0; j < LCOR_LANES; j++) { /* black and white stay, whatever the rounding */
            const double y = l->y_new[j];

            l->c[i][j] = y > 0.0 && y < 1.0 ? clamped(l->c[i][j], 1.0) : y;
        }
}
