/* SPDX-License-Identifier: MIT */
/* Rule S9 on the float path: the few pixels that leave the gamut, gathered over blocks so that the
 * search for their chroma runs on many at a time. One copy for all instruction sets. */
#include "correct/internal.h"

#include "base/internal.h"

#include <math.h>
#include <string.h>

/* As in kernel_arithmetic.h. */
static inline float f_inverse(float v)
{
    const float m = v > 0.206896558f ? v : 0.206896558f;

    return m * m * m + (v - m) * 0.128418565f;
}

/* How far the colour with chroma times s is outside 0..1; <= 0 inside. */
static inline float excess_at(const float n[9], float fn, float y, float kx, float kz, float s)
{
    const float x = f_inverse(fn + s * kx), z = f_inverse(fn + s * kz);
    const float r = n[0] * x + n[2] * z + n[1] * y;
    const float g = n[3] * x + n[5] * z + n[4] * y;
    const float b = n[6] * x + n[8] * z + n[7] * y;
    const float hi = r > g ? r : g, lo = r < g ? r : g;
    const float top = (hi > b ? hi : b) - 1.0f, bottom = 0.0f - (lo < b ? lo : b);

    return top > bottom ? top : bottom;
}

/* mask (all bits or none) ? a : b, which compilers leave as it is instead of making it a jump */
static inline float pick(int32_t mask, float a, float b)
{
    int32_t i, j;

    memcpy(&i, &a, sizeof i);
    memcpy(&j, &b, sizeof j);
    i = (i & mask) | (j & ~mask);
    memcpy(&a, &i, sizeof a);
    return a;
}

/* Regula falsi (Illinois) between s = 0, which is grey and fits, and s = 1, which does not. */
typedef struct search {
    float LCOR_ALIGNED lo[LCOR_GATHERED], hi[LCOR_GATHERED]; /* lo fits, hi does not */
    float LCOR_ALIGNED g_lo[LCOR_GATHERED], g_hi[LCOR_GATHERED];
    float LCOR_ALIGNED side[LCOR_GATHERED]; /* which end moved last; 2: found */
} search;

/* Returns how many pixels are still searching. A pixel that is found stays as it is, so that it
 * does not depend on which others are gathered with it. */
static LCOR_APART int step(const float n_[9], const lcor_outside *restrict q, search *restrict t)
{
    const float n[9] = {n_[0], n_[1], n_[2], n_[3], n_[4], n_[5], n_[6], n_[7], n_[8]};
    int searching = 0;

    for (int j = 0; j < LCOR_GATHERED; j++) {
        const float lo = t->lo[j], hi = t->hi[j], g_lo = t->g_lo[j], g_hi = t->g_hi[j];
        const float side = t->side[j];
        const float s = lo - (hi - lo) * (g_lo / (g_hi - g_lo + 1e-30f));
        const float e = excess_at(n, q->fn[j], q->y[j], q->kx[j], q->kz[j], s);
        const int32_t out = -(e > 0.0f), found = -(side > 1.5f);
        const float new_lo = pick(out, lo, s), new_hi = pick(out, s, hi);
        /* good enough: the colour at lo touches the cube, or nothing is left between the ends */
        const float half = 5e-8f * q->y[j]; /* dark colours are small in every respect */
        const int32_t touches = -(fabsf(e + half) <= half), narrow = -(new_hi - new_lo < 1e-7f);
        const int32_t done = found | touches | narrow;

        t->lo[j] = pick(found, lo, new_lo);
        t->hi[j] = new_hi;
        /* an end that stays twice counts half */
        t->g_lo[j] = pick(out, pick(-(side > 0.0f), 0.5f, 1.0f) * g_lo, e);
        t->g_hi[j] = pick(out, e, pick(-(side < 0.0f), 0.5f, 1.0f) * g_hi);
        t->side[j] = pick(done, 2.0f, pick(out, 1.0f, -1.0f));
        searching += 1 + done;
    }
    return searching;
}

static void fit(const float n[9], const lcor_outside *q, search *t)
{
    for (size_t j = 0; j < LCOR_GATHERED; j++) {
        t->lo[j] = 0.0f;
        t->hi[j] = 1.0f;
        t->g_lo[j] = excess_at(n, q->fn[j], q->y[j], q->kx[j], q->kz[j], 0.0f);
        t->g_hi[j] = excess_at(n, q->fn[j], q->y[j], q->kx[j], q->kz[j], 1.0f);
        t->side[j] = j < q->count ? 0.0f : 2.0f;
    }
    for (int i = 0; i < 24 && step(n, q, t) > 0; i++)
        continue;
}

void lcor_internal_flush(const lcor_row_job *job, lcor_outside *q)
{
    const float *n = job->plan->k.n;
    float LCOR_ALIGNED c[3][LCOR_BLOCK];
    search t;

    if (q->count == 0)
        return;
    fit(n, q, &t);
    memset(c, 0, sizeof c);
    for (size_t j = 0; j < q->count; j++) {
        const float x = f_inverse(q->fn[j] + t.lo[j] * q->kx[j]);
        const float z = f_inverse(q->fn[j] + t.lo[j] * q->kz[j]);

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
