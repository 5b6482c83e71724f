/* SPDX-License-Identifier: MIT */
/* The tone curve: which device value shows which luminance, from a ramp of greys. */
#include "profile/internal.h"

#include "base/internal.h"

#include <math.h>
#include <stdlib.h>

/* A grey level and what it shows. Between knots the curve is a cubic in the square root of the
 * luminance, in which common devices are close to straight. */
typedef struct knot {
    double level;     /* device value 0..1 */
    double low, high; /* the lowest and highest level that share this knot */
    double luminance; /* relative to a perfect diffuser */
    double x;         /* square root of the luminance on a scale of 0 (black) to 1 (white) */
    double slope;     /* d level / d x */
    size_t weight;    /* number of levels that share it */
} knot;

/* Luminances closer than this are the same: their square roots could be the same double. */
#define RISE (1.0 + 1e-12)

static int is_grey(const lcor_profile_reading *r)
{
    return !r->rejected && (r->has & LCOR_HAS_RGB) && fabs(r->rgb[0] - r->rgb[1]) <= 0.005 &&
           fabs(r->rgb[1] - r->rgb[2]) <= 0.005;
}

static int by_level_then_luminance(const void *a, const void *b)
{
    const knot *const x = a, *const y = b;
    if (x->level != y->level)
        return x->level < y->level ? -1 : 1;
    return (x->luminance > y->luminance) - (x->luminance < y->luminance);
}

/* Every grey reading as a knot, then one knot a level with the median luminance. */
static size_t collect(const lcor_profile *profile, knot *knots)
{
    size_t n = 0, levels = 0;
    for (size_t i = 0; i < profile->count; i++)
        if (is_grey(&profile->readings[i]))
            knots[n++] =
                (knot){.level = profile->readings[i].rgb[0] / 255.0,
                       .luminance = pow(10.0, -lcor_internal_density(&profile->readings[i]))};
    qsort(knots, n, sizeof *knots, by_level_then_luminance);
    for (size_t from = 0, to; from < n; from = to) {
        for (to = from + 1; to < n && knots[to].level == knots[from].level;)
            to++;
        const size_t middle = from + (to - from) / 2;
        const double upper = knots[middle].luminance;
        const double lower = (to - from) % 2 ? upper : knots[middle - 1].luminance;
        knots[levels++] = (knot){.level = knots[from].level,
                                 .low = knots[from].level,
                                 .high = knots[from].level,
                                 .luminance = 0.5 * (lower + upper),
                                 .weight = 1};
    }
    return levels;
}

/* Levels that do not rise are pooled until all do (the least-squares monotone fit): a device never
 * gets darker with more light asked for, readings do. */
static size_t pool(knot *knots, size_t n)
{
    size_t kept = 0;
    for (size_t i = 0; i < n; i++) {
        knots[kept++] = knots[i];
        while (kept > 1 && knots[kept - 1].luminance <= knots[kept - 2].luminance * RISE) {
            const knot b = knots[--kept];
            knot *const a = &knots[kept - 1];
            const double wa = (double)a->weight, wb = (double)b.weight;
            a->luminance = (wa * a->luminance + wb * b.luminance) / (wa + wb);
            a->level = (wa * a->level + wb * b.level) / (wa + wb);
            a->high = b.high;
            a->weight += b.weight;
        }
    }
    return kept;
}

/* Slope at the end of a row of knots from its first two intervals: that of the parabola through
 * three knots, as far as the cubic stays monotone. */
static double end_slope(double h, double rise, double h_next, double rise_next)
{
    const double slope = ((2.0 * h + h_next) * rise - h * rise_next) / (h + h_next);
    return fmin(fmax(slope, 0.0), 3.0 * rise);
}

/* Slopes that keep the cubics monotone: Fritsch and Butland's weighted harmonic mean. */
static void set_slopes(knot *k, size_t n)
{
    double h = 0.0, rise = 0.0; /* of the interval before knot i */
    for (size_t i = 0; i + 1 < n; i++) {
        const double h_next = k[i + 1].x - k[i].x;
        const double rise_next = (k[i + 1].level - k[i].level) / h_next;
        if (i == 1)
            k[0].slope = end_slope(h, rise, h_next, rise_next);
        if (i > 0 && rise > 0.0 && rise_next > 0.0)
            k[i].slope =
                3.0 * (h + h_next) / ((2.0 * h_next + h) / rise + (h_next + 2.0 * h) / rise_next);
        if (i + 2 == n)
            k[n - 1].slope = i > 0 ? end_slope(h_next, rise_next, h, rise) : rise_next;
        h = h_next;
        rise = rise_next;
    }
    if (n == 2)
        k[0].slope = rise;
}

static double between(const knot *a, const knot *b, double x)
{
    const double h = b->x - a->x, t = (x - a->x) / h, s = 1.0 - t;
    return s * s * ((1.0 + 2.0 * t) * a->level + t * h * a->slope) +
           t * t * ((1.0 + 2.0 * s) * b->level - s * h * b->slope);
}

static void sample(const knot *knots, size_t levels, size_t n, float *out)
{
    float last = 0.0f;
    size_t at = 0;
    for (size_t i = 0; i < n; i++) {
        const double x = sqrt((double)i / (double)(n - 1));
        while (at + 2 < levels && knots[at + 1].x < x)
            at++;
        const float value = (float)between(&knots[at], &knots[at + 1], x);
        /* The cubics rise; only rounding could say otherwise. */
        last = value > 1.0f ? 1.0f : value > last ? value : last;
        out[i] = last;
    }
    out[0] = 0.0f;
    out[n - 1] = 1.0f;
}

static lcor_status fit(knot *knots, size_t levels, size_t *kept, lcor_error *err)
{
    if (levels < 3 || knots[0].level > 0.0 || knots[levels - 1].level < 1.0)
        return lcor_internal_fail(err, LCOR_ERR_DOMAIN, -1,
                                  "no grey ramp: it takes readings of black, white and at least "
                                  "one grey (R = G = B) between");
    *kept = pool(knots, levels);
    if (*kept < 2)
        return lcor_internal_fail(err, LCOR_ERR_DOMAIN, -1,
                                  "the grey ramp does not rise from black to white");
    knot *const first = &knots[0], *const last = &knots[*kept - 1];
    /* Levels that show no more than black, or no less than white: the curve skips them. */
    first->level = first->high;
    last->level = last->low;
    const double black = first->luminance, range = last->luminance - black;
    for (size_t i = 0; i < *kept; i++)
        knots[i].x = sqrt((knots[i].luminance - black) / range);
    set_slopes(knots, *kept);
    return LCOR_OK;
}

lcor_status lcor_profile_tone_curve(const lcor_profile *profile, size_t n, float *out,
                                    lcor_error *err)
{
    if (!profile || !out || n < 2)
        return lcor_internal_fail(err, LCOR_ERR_ARG, -1, "a tone curve needs 2 values or more");
    knot *knots = lcor_internal_alloc(&profile->allocator, (profile->count + 1) * sizeof *knots);
    if (!knots)
        return lcor_internal_fail(err, LCOR_ERR_NOMEM, -1, "no memory for the grey ramp");
    size_t kept = 0;
    const lcor_status status = fit(knots, collect(profile, knots), &kept, err);
    if (status == LCOR_OK)
        sample(knots, kept, n, out);
    lcor_internal_free(&profile->allocator, knots);
    return status;
}

size_t lcor_profile_grey_levels(const lcor_profile *profile)
{
    knot *knots =
        profile ? lcor_internal_alloc(&profile->allocator, (profile->count + 1) * sizeof *knots)
                : NULL;
    if (!knots)
        return 0;
    const size_t levels = collect(profile, knots);
    size_t between_ends = 0;
    for (size_t i = 0; i < levels; i++)
        between_ends += knots[i].level > 0.0 && knots[i].level < 1.0;
    lcor_internal_free(&profile->allocator, knots);
    return between_ends;
}
