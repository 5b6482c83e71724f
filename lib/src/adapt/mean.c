/* SPDX-License-Identifier: MIT */
/* The mean of section 4.3 and rule S3 of docs/MODEL.md, from exact sums.
 *
 * With l = log2 r, weights w of sum W and G(t) = sum of w max(l - t, 0):
 *   literal   t = max l - 8 log2 10,            log2 mean = t + G(t) / W
 *   adaptive  G(t) = W log2 10,                 log2 mean = t + log2 10
 * G is known exactly but for the bin that holds t. */
#include <lcor/adapt.h>

#include "base/elementary.h"
#include "base/internal.h"

#include <float.h>
#include <math.h>
#include <string.h>

#define LOG2_10  3.3219280948873623
#define BIAS     1088 /* makes l + BIAS positive for every double r > 0 */
#define ONE_BITS 52   /* fixed-point l has this many fraction bits */

static const double HEAVIEST = 16777216.0;           /* 2^24 */
static const double UNIT = 1.0 / 4503599627370496.0; /* 2^-52 */

static void add128(uint64_t sum[2], uint64_t lo, uint64_t hi)
{
    sum[0] += lo;
    sum[1] += hi + (sum[0] < lo);
}

static void mul64(uint64_t a, uint64_t b, uint64_t *lo, uint64_t *hi)
{
    const uint64_t mask = 0xFFFFFFFFu;
    const uint64_t p00 = (a & mask) * (b & mask), p01 = (a & mask) * (b >> 32);
    const uint64_t p10 = (a >> 32) * (b & mask), p11 = (a >> 32) * (b >> 32);
    const uint64_t mid = (p00 >> 32) + (p01 & mask) + (p10 & mask);

    *lo = (mid << 32) | (p00 & mask);
    *hi = p11 + (p01 >> 32) + (p10 >> 32) + (mid >> 32);
}

/* weight times position, in the unit of moments: 2^-72 2^-52 -> 2^-60 */
static LCOR_APART void moment_of(const uint64_t weight[2], uint64_t l, uint64_t out[2])
{
    uint64_t lo, hi;

    mul64(weight[0], l, &lo, &hi);
    out[0] = hi;
    out[1] = 0;
    mul64(weight[1], l, &lo, &hi);
    add128(out, lo, hi);
}

static LCOR_APART void add_sum(lcor_mean_sum *into, const lcor_mean_sum *from)
{
    add128(into->weight, from->weight[0], from->weight[1]);
    add128(into->moment, from->moment[0], from->moment[1]);
}

static int is_empty(const lcor_mean_sum *s) { return (s->weight[0] | s->weight[1]) == 0; }

static LCOR_APART double weight_as_double(const uint64_t weight[2])
{
    return (double)weight[1] * (1.0 / 256.0) + (double)weight[0] * (1.0 / 256.0) * 0x1p-64;
}

/* Sum of w (l - origin), signed and without cancellation. */
static LCOR_APART double moment_about(const lcor_mean_sum *s, uint64_t origin)
{
    uint64_t m[2], a[2], b[2];
    int negative;

    moment_of(s->weight, origin, m);
    negative = s->moment[1] < m[1] || (s->moment[1] == m[1] && s->moment[0] < m[0]);
    memcpy(a, negative ? m : s->moment, sizeof a);
    memcpy(b, negative ? s->moment : m, sizeof b);
    b[1] = a[1] - b[1] - (a[0] < b[0]);
    b[0] = a[0] - b[0];
    {
        const double d = (double)b[1] * 16.0 + (double)b[0] * 0x1p-60;

        return negative ? -d : d;
    }
}

void lcor_mean_init(lcor_mean *mean)
{
    memset(mean, 0, sizeof *mean);
    mean->shift = ONE_BITS - 3;
}

/* Move the bins of the first pass up so that `l` falls into the first of them. */
static void raise_top(lcor_mean *mean, uint64_t l)
{
    const uint64_t top = ((l >> mean->shift) + 1) << mean->shift;
    const uint64_t steps = (top - mean->top) >> mean->shift;
    const size_t d = steps < LCOR_MEAN_BINS ? (size_t)steps : LCOR_MEAN_BINS;

    for (size_t i = LCOR_MEAN_BINS - d; i < LCOR_MEAN_BINS; i++)
        add_sum(&mean->below, &mean->bins[i]);
    memmove(mean->bins + d, mean->bins, (LCOR_MEAN_BINS - d) * sizeof mean->bins[0]);
    memset(mean->bins, 0, d * sizeof mean->bins[0]);
    mean->top = top;
}

/* The bin of position l, `below` in the first pass, or NULL: counted in an earlier pass. */
static lcor_mean_sum *bin_of(lcor_mean *mean, uint64_t l)
{
    uint64_t i;

    if (l >= mean->top) {
        if (mean->pass > 0)
            return NULL;
        raise_top(mean, l);
    }
    i = (mean->top - 1 - l) >> mean->shift;
    if (i < LCOR_MEAN_BINS)
        return &mean->bins[i];
    return mean->pass == 0 ? &mean->below : NULL;
}

/* A weight in its unit of 2^-72. */
static LCOR_INLINE void weight_of(double w, uint64_t weight[2])
{
    weight[1] = (uint64_t)(w * 256.0);
    weight[0] = (uint64_t)((w * 256.0 - (double)weight[1]) * 0x1p64);
}

void lcor_mean_add(lcor_mean *mean, size_t n, const double *r, const double *weights)
{
    uint64_t weight[2] = {0, 256}; /* of 1 */

    for (size_t i = 0; i < n; i++) {
        const double w = weights != NULL ? weights[i] : 1.0;
        uint64_t moment[2], l;
        int e;
        lcor_mean_sum *bin;

        if (!(r[i] >= 0.0 && r[i] <= DBL_MAX && w >= 0.0 && w <= HEAVIEST)) {
            mean->rejected += mean->pass == 0;
            continue;
        }
        if (weights != NULL)
            weight_of(w, weight);
        if ((weight[0] | weight[1]) == 0)
            continue;
        if (r[i] == 0.0) {
            if (mean->pass == 0)
                add128(mean->zeros, weight[0], weight[1]);
            continue;
        }
        l = (uint64_t)(int64_t)(lcor_internal_log2_parts(r[i], &e) * 0x1p52 +
                                0x1p52); /* 0.5..1.5 */
        l += (uint64_t)(BIAS - 1 + e) << ONE_BITS;
        if (l > mean->largest)
            mean->largest = l;
        bin = bin_of(mean, l);
        if (bin == NULL)
            continue;
        add128(bin->weight, weight[0], weight[1]);
        if (weights == NULL) { /* what moment_of gives for a weight of 1 */
            moment[0] = l << 8;
            moment[1] = l >> 56;
        } else {
            moment_of(weight, l, moment);
        }
        add128(bin->moment, moment[0], moment[1]);
    }
}

lcor_status lcor_mean_merge(lcor_mean *into, const lcor_mean *from, lcor_error *err)
{
    uint64_t d;

    if (into->pass != from->pass ||
        (into->pass > 0 && (into->top != from->top || into->shift != from->shift)))
        return lcor_internal_fail(err, LCOR_ERR_ARG, -1,
                                  "means of different passes: merge copies of one refined mean");
    if (from->largest > into->largest)
        into->largest = from->largest;
    if (into->pass == 0) {
        into->rejected += from->rejected;
        add128(into->zeros, from->zeros[0], from->zeros[1]);
        add_sum(&into->below, &from->below);
        if (from->top == 0) /* nothing but zeros */
            return LCOR_OK;
        if (from->top > into->top)
            raise_top(into, from->top - 1);
    }
    d = (into->top - from->top) >> into->shift;
    for (size_t i = 0; i < LCOR_MEAN_BINS; i++)
        add_sum(d + i < LCOR_MEAN_BINS ? &into->bins[d + i] : &into->below, &from->bins[i]);
    return LCOR_OK;
}

/* Where t lies: sums of all above a range of positions (in octaves from `origin`), and its own. */
typedef struct place {
    uint64_t origin;
    double lo, hi;
    lcor_mean_sum above, own;
    size_t bin; /* LCOR_MEAN_BINS: the range below the bins */
    double total, t_literal;
} place;

/* What a bin adds to G(t), lo <= t <= hi, if its values lie as far apart as they can (the chord of
 * a convex curve), all at their mean (its tangents), or evenly about their mean. */
typedef enum spread { SPREAD_NONE, SPREAD_EVEN, SPREAD_FULL } spread;

static LCOR_COLD double own_part(const place *at, spread how, double t)
{
    const double w = weight_as_double(at->own.weight);
    const double m = is_empty(&at->own) ? 0.0 : moment_about(&at->own, at->origin) / w;
    const double d = fmin(m - at->lo, at->hi - m);

    if (w == 0.0)
        return 0.0;
    switch (how) {
    case SPREAD_FULL: return w * (m - at->lo) * (at->hi - t) / (at->hi - at->lo);
    case SPREAD_EVEN:
        if (fabs(m - t) < d)
            return w * (m + d - t) * (m + d - t) / (4.0 * d);
        break;
    case SPREAD_NONE: break;
    }
    return w * fmax(m - t, 0.0);
}

static LCOR_APART double g_at(const place *at, spread how, double t)
{
    return moment_about(&at->above, at->origin) - t * weight_as_double(at->above.weight) +
           own_part(at, how, t);
}

/* Is t in or above the range of `at`? */
static int reached(const place *at, lcor_mean_method method)
{
    if (method == LCOR_MEAN_LITERAL)
        return at->t_literal >= at->lo;
    return g_at(at, SPREAD_NONE, at->lo) >= at->total * LOG2_10;
}

static LCOR_COLD void find_place(const lcor_mean *mean, lcor_mean_method method, place *at)
{
    const double width = ldexp(1.0, mean->shift - ONE_BITS);
    lcor_mean_sum all = mean->above;

    memset(at, 0, sizeof *at);
    at->origin = mean->top;
    add_sum(&all, &mean->below);
    for (size_t i = 0; i < LCOR_MEAN_BINS; i++)
        add_sum(&all, &mean->bins[i]);
    add128(all.weight, mean->zeros[0], mean->zeros[1]);
    at->total = weight_as_double(all.weight);
    at->t_literal = -8.0 * LOG2_10 - (double)(mean->top - mean->largest) * UNIT;
    if (mean->largest > mean->top)
        at->t_literal = -8.0 * LOG2_10 + (double)(mean->largest - mean->top) * UNIT;

    at->above = mean->above;
    for (at->bin = 0; at->bin < LCOR_MEAN_BINS; at->bin++) {
        at->hi = -(double)at->bin * width;
        at->lo = at->hi - width;
        at->own = mean->bins[at->bin];
        if (reached(at, method))
            return;
        add_sum(&at->above, &at->own);
    }
    at->hi = at->lo;
    at->lo = -(double)mean->top * UNIT;
    at->own = mean->below;
    if (!reached(at, method)) { /* every value lies above t */
        add_sum(&at->above, &at->own);
        memset(&at->own, 0, sizeof at->own);
    }
}

/* log2 of the mean from at->origin, if the bin in doubt is spread as told */
static LCOR_APART double log2_mean(const place *at, lcor_mean_method method, spread how)
{
    const double target = at->total * LOG2_10;
    double lo = at->lo, hi = at->hi;

    if (method == LCOR_MEAN_LITERAL)
        return at->t_literal + g_at(at, how, at->t_literal) / at->total;
    if (is_empty(&at->own))
        return (moment_about(&at->above, at->origin) - target) /
                   weight_as_double(at->above.weight) +
               LOG2_10;
    for (int i = 0; i < 64; i++) { /* G falls with t */
        const double t = 0.5 * (lo + hi);

        if (g_at(at, how, t) >= target)
            lo = t;
        else
            hi = t;
    }
    return lo + LOG2_10;
}

LCOR_COLD lcor_status lcor_mean_get(const lcor_mean *mean, lcor_mean_method method, double *r_mean,
                                    lcor_error *err)
{
    const uint64_t fraction = (UINT64_C(1) << ONE_BITS) - 1;
    place at;
    double x;

    if (method != LCOR_MEAN_ADAPTIVE && method != LCOR_MEAN_LITERAL)
        return lcor_internal_fail(err, LCOR_ERR_ARG, -1, "unknown mean %d", (int)method);
    if (mean->pass > 0 && mean->method != (int)method)
        return lcor_internal_fail(err, LCOR_ERR_ARG, -1,
                                  "this mean was refined for the other method");
    if (mean->largest == 0) {
        if ((mean->zeros[0] | mean->zeros[1]) == 0)
            return lcor_internal_fail(err, LCOR_ERR_DOMAIN, -1,
                                      "no valid value of weight > 0: there is no mean");
        *r_mean = 0.0;
        return LCOR_OK;
    }
    find_place(mean, method, &at);
    x = log2_mean(&at, method, SPREAD_EVEN) + (double)(at.origin & fraction) * UNIT;
    *r_mean = ldexp(lcor_internal_exp2(x), (int)(at.origin >> ONE_BITS) - BIAS);
    return LCOR_OK;
}

LCOR_COLD double lcor_mean_error(const lcor_mean *mean, lcor_mean_method method)
{
    place at;
    double x;

    if (mean->largest == 0)
        return 0.0;
    find_place(mean, method, &at);
    if (is_empty(&at.own))
        return 0.0;
    x = log2_mean(&at, method, SPREAD_EVEN);
    return 0.69314718055994531 *
           fmax(log2_mean(&at, method, SPREAD_FULL) - x, x - log2_mean(&at, method, SPREAD_NONE));
}

LCOR_COLD void lcor_mean_refine(lcor_mean *mean, lcor_mean_method method)
{
    lcor_mean_sum below;
    place at;

    if (mean->largest == 0)
        return;
    find_place(mean, method, &at);
    memset(&below, 0, sizeof below);
    if (at.bin < LCOR_MEAN_BINS) {
        below = mean->below;
        for (size_t i = at.bin + 1; i < LCOR_MEAN_BINS; i++)
            add_sum(&below, &mean->bins[i]);
        mean->top -= (uint64_t)at.bin << mean->shift;
        mean->shift = mean->shift > 9 ? mean->shift - 9 : 0; /* 512 bins out of one */
    } else {
        mean->top -= (uint64_t)LCOR_MEAN_BINS << mean->shift;
        while (mean->shift < 63 - 9 && mean->top >> mean->shift >= LCOR_MEAN_BINS)
            mean->shift++;
    }
    mean->above = at.above;
    mean->below = below;
    memset(mean->bins, 0, sizeof mean->bins);
    mean->pass++;
    mean->method = (int)method;
}

LCOR_COLD lcor_status lcor_geometric_mean(size_t n, const double *r, const double *weights,
                                          lcor_mean_method method, double *r_mean, lcor_error *err)
{
    lcor_mean mean;

    if (n > 0 && r == NULL)
        return lcor_internal_fail(err, LCOR_ERR_ARG, -1, "r is NULL");
    lcor_mean_init(&mean);
    lcor_mean_add(&mean, n, r, weights);
    for (int pass = 1; pass < 8 && lcor_mean_error(&mean, method) > 1e-15; pass++) {
        lcor_mean_refine(&mean, method);
        lcor_mean_add(&mean, n, r, weights);
    }
    return lcor_mean_get(&mean, method, r_mean, err);
}
