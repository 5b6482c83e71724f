/* SPDX-License-Identifier: MIT */
/* Rule S9 on the float path: the few pixels that leave the gamut, gathered over blocks so that the
 * search for their chroma runs on many at a time. One copy for all instruction sets. */
#include "correct/internal.h"

#include <string.h>

/* How far the colour with chroma times s is outside 0..1; <= 0 inside. In double: where the way
 * from grey only grazes a face of the cube, s feels every rounding error. */
static double excess_at(const double n[9], const lcor_outside *q, size_t j, double s)
{
    const double knee = 6.0 / 29.0, line = 108.0 / 841.0;
    const double fx = (double)q->fn[j] + s * (double)q->kx[j], y = (double)q->y[j];
    const double fz = (double)q->fn[j] + s * (double)q->kz[j];
    const double ax = fx > knee ? fx : knee, az = fz > knee ? fz : knee;
    const double x = ax * ax * ax + (fx - ax) * line, z = az * az * az + (fz - az) * line;
    const double r = n[0] * x + n[2] * z + n[1] * y;
    const double g = n[3] * x + n[5] * z + n[4] * y;
    const double b = n[6] * x + n[8] * z + n[7] * y;
    const double hi = r > g ? r : g, lo = r < g ? r : g;
    const double top = (hi > b ? hi : b) - 1.0, bottom = 0.0 - (lo < b ? lo : b);

    return top > bottom ? top : bottom;
}

/* The largest s in 0..1 that fits, by regula falsi (Illinois) from s = 0, which is grey and fits,
 * and s = 1, which does not. Fourteen steps leave at most 3e-8 in RGB (a million random colours;
 * ten leave 1e-3 in four of them). */
static void fit(const double n[9], const lcor_outside *q, double lo[LCOR_GATHERED])
{
    double hi[LCOR_GATHERED], g_lo[LCOR_GATHERED], g_hi[LCOR_GATHERED];
    double side[LCOR_GATHERED]; /* which end moved last */

    for (size_t j = 0; j < LCOR_GATHERED; j++) {
        lo[j] = side[j] = 0.0;
        hi[j] = 1.0;
        g_lo[j] = excess_at(n, q, j, 0.0);
        g_hi[j] = excess_at(n, q, j, 1.0);
    }
    for (int i = 0; i < 14; i++)
        for (size_t j = 0; j < LCOR_GATHERED; j++) {
            const double d = g_hi[j] - g_lo[j];
            const double s = lo[j] - (hi[j] - lo[j]) * (g_lo[j] / (d > 1e-30 ? d : 1e-30));
            const double e = excess_at(n, q, j, s);

            /* an end that stays twice counts half */
            g_lo[j] = e > 0.0 ? g_lo[j] * (side[j] > 0.0 ? 0.5 : 1.0) : e;
            g_hi[j] = e > 0.0 ? e : g_hi[j] * (side[j] < 0.0 ? 0.5 : 1.0);
            lo[j] = e > 0.0 ? lo[j] : s;
            hi[j] = e > 0.0 ? s : hi[j];
            side[j] = e > 0.0 ? 1.0 : -1.0;
        }
}

static float f_inverse(float v)
{
    const float m = v > 0.206896558f ? v : 0.206896558f; /* as in kernel_arithmetic.h */

    return m * m * m + (v - m) * 0.128418565f;
}

void lcor_internal_flush(const lcor_row_job *job, lcor_outside *q)
{
    const float *n = job->plan->k.n;
    float LCOR_ALIGNED c[3][LCOR_BLOCK];
    double s[LCOR_GATHERED];

    if (q->count == 0)
        return;
    fit(job->plan->rgb_from_f, q, s);
    memset(c, 0, sizeof c);
    for (size_t j = 0; j < q->count; j++) {
        const float x = f_inverse(q->fn[j] + (float)s[j] * q->kx[j]);
        const float z = f_inverse(q->fn[j] + (float)s[j] * q->kz[j]);

        for (int k = 0; k < 3; k++)
            c[k][j] = n[3 * k] * x + n[3 * k + 2] * z + n[3 * k + 1] * q->y[j];
    }
    lcor_internal_to_device(job->plan, c[0], c[1], c[2]);
    for (size_t j = 0; j < q->count; j++)
        lcor_internal_store_strided(job, q->at[j], 1, &c[0][j], &c[1][j], &c[2][j]);
    q->count = 0;
}

void lcor_internal_gather(const lcor_row_job *job, size_t at, size_t m, const lcor_block *b,
                          const uint8_t *flags, lcor_outside *q)
{
    for (size_t j = 0; j < m; j++) {
        if (j % 8 == 0) {
            uint64_t eight;

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
        if (++q->count == LCOR_GATHERED)
            lcor_internal_flush(job, q);
    }
}
