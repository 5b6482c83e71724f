/* SPDX-License-Identifier: MIT */
/* What the readings say about the device: white, black, contrast and how well it is known. */
#include "profile/internal.h"

#include "base/internal.h"

#include <lcor/adapt.h>

#include <math.h>
#include <stdlib.h>

#define LN10 2.302585092994046

static int all_near(const double *values, int n, double wanted)
{
    for (int i = 0; i < n; i++)
        if (!(fabs(values[i] - wanted) <= 0.005))
            return 0;
    return 1;
}

int lcor_internal_is_white(const lcor_profile_reading *r)
{
    return ((r->has & LCOR_HAS_RGB) && all_near(r->rgb, 3, 255.0)) ||
           ((r->has & LCOR_HAS_CMYK) && all_near(r->cmyk, 4, 0.0));
}

int lcor_internal_is_full_black(const lcor_profile_reading *r)
{
    return ((r->has & LCOR_HAS_RGB) && all_near(r->rgb, 3, 0.0)) ||
           ((r->has & LCOR_HAS_CMYK) && all_near(r->cmyk, 3, 0.0) &&
            all_near(r->cmyk + 3, 1, 100.0));
}

double lcor_internal_density(const lcor_profile_reading *r)
{
    return r->has & LCOR_HAS_VISUAL ? r->density[3] : -log10(r->xyz[1] / 100.0);
}

static int same_device_values(const lcor_profile_reading *a, const lcor_profile_reading *b)
{
    for (int i = 0; i < 3; i++)
        if ((a->has & LCOR_HAS_RGB) && fabs(a->rgb[i] - b->rgb[i]) > 0.005)
            return 0;
    for (int i = 0; i < 4; i++)
        if ((a->has & LCOR_HAS_CMYK) && fabs(a->cmyk[i] - b->cmyk[i]) > 0.005)
            return 0;
    return 1;
}

/* The first reading of a patch that counts; NULL: there is none. */
static const lcor_profile_reading *find(const lcor_profile *profile,
                                        int (*is_wanted)(const lcor_profile_reading *r))
{
    for (size_t i = 0; i < profile->count; i++)
        if (!profile->readings[i].rejected && is_wanted(&profile->readings[i]))
            return &profile->readings[i];
    return NULL;
}

static const lcor_profile_reading *find_darkest(const lcor_profile *profile)
{
    const lcor_profile_reading *found = NULL;
    for (size_t i = 0; i < profile->count; i++) {
        const lcor_profile_reading *r = &profile->readings[i];
        if (!r->rejected && (!found || lcor_internal_density(r) > lcor_internal_density(found)))
            found = r;
    }
    return found;
}

static int by_value(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

typedef struct patch_statistics {
    size_t n;
    double median;
    double noise;    /* variance of the median from the spread of the readings */
    double rounding; /* variance of the median from the resolution */
} patch_statistics;

/* Variance of the median of n normal readings over that of one of them. */
static double median_variance(size_t n)
{
    /* n = 2..10: order statistics of the normal distribution; beyond, its expansion in 1/n, within
     * 1.1 % there. */
    static const double exact[] = {0.5,    0.4487, 0.2982, 0.2868, 0.2147,
                                   0.2104, 0.1682, 0.1661, 0.1383};
    if (n <= 10)
        return exact[n - 2];
    const double m = (double)n;
    return 1.5707963267948966 / (m + (n % 2 ? 0.5707963267948966 : 1.3));
}

/* `sorted` are the densities of one patch, `step` the resolution there.
 *
 * Readings are rounded, and rounding is monotone: the median of rounded readings is the median of
 * the readings, rounded. So its error is that of the median of the noise plus one rounding, uniform
 * over a step (variance step^2/12). The spread seen holds both (Sheppard's correction). */
static patch_statistics describe(const double *sorted, size_t n, double step)
{
    patch_statistics patch = {.n = n, .median = 0.5 * (sorted[(n - 1) / 2] + sorted[n / 2])};
    if (n < 2)
        return patch;
    double mean = 0.0, squares = 0.0;
    for (size_t i = 0; i < n; i++)
        mean += sorted[i] / (double)n;
    for (size_t i = 0; i < n; i++)
        squares += (sorted[i] - mean) * (sorted[i] - mean);
    patch.rounding = step * step / 12.0;
    const double spread = squares / (double)(n - 1) - patch.rounding;
    patch.noise = spread > 0.0 ? spread * median_variance(n) : 0.0;
    return patch;
}

/* Two-sided 95 % quantile of Student's t: tables up to 5 degrees of freedom, linear in between over
 * 1/freedom; beyond, the expansion about the normal one. Within 0.2 %. */
double lcor_internal_student95(double freedom)
{
    static const double table[] = {12.7062, 4.30265, 3.18245, 2.77645, 2.57058};
    if (freedom < 5.0) {
        const double f = freedom > 1.0 ? freedom : 1.0;
        const int i = (int)f;
        const double w = (1.0 / i - 1.0 / f) / (1.0 / i - 1.0 / (i + 1));
        return table[i - 1] + w * (table[i] - table[i - 1]);
    }
    const double z = 1.959963985, g = 1.0 / freedom, z3 = z * z * z, z5 = z3 * z * z;
    return z + g * ((z3 + z) / 4.0 +
                    g * ((5.0 * z5 + 16.0 * z3 + 3.0 * z) / 96.0 +
                         g * (3.0 * z5 * z * z + 19.0 * z5 + 17.0 * z3 - 15.0 * z) / 384.0));
}

/* Statistics of the readings of the same patch as `like`. */
static patch_statistics gather(const lcor_profile *profile, const lcor_profile_reading *like,
                               double *scratch)
{
    size_t n = 0;
    const double step = like->has & LCOR_HAS_VISUAL ? profile->resolution
                                                    : profile->resolution / like->xyz[1] / LN10;
    for (size_t i = 0; i < profile->count; i++) {
        const lcor_profile_reading *r = &profile->readings[i];
        if (!r->rejected && same_device_values(r, like))
            scratch[n++] = lcor_internal_density(r);
    }
    qsort(scratch, n, sizeof *scratch, by_value);
    return describe(scratch, n, step);
}

/* Standard deviations that hold the difference of two medians with 95 %: Student's t with the
 * degrees of freedom of Welch and Satterthwaite; the rounding is known, so it has no end of them.
 */
static double coverage_factor(patch_statistics a, patch_statistics b)
{
    const double total = a.noise + a.rounding + b.noise + b.rounding;
    const double estimated =
        a.noise * a.noise / (double)(a.n - 1) + b.noise * b.noise / (double)(b.n - 1);
    return lcor_internal_student95(estimated > 0.0 ? total * total / estimated : HUGE_VAL);
}

static lcor_status combine(patch_statistics white, patch_statistics black, lcor_profile_result *out,
                           lcor_error *err)
{
    lcor_profile_result result = {.d_min = white.median,
                                  .d_max = black.median,
                                  .u_min = sqrt(white.noise + white.rounding),
                                  .u_max = sqrt(black.noise + black.rounding),
                                  .n_min = white.n,
                                  .n_max = black.n};
    const lcor_status status =
        lcor_contrast_from_density(black.median, white.median, &result.contrast, err);
    if (status != LCOR_OK)
        return status;
    if (white.n > 1 && black.n > 1) /* one reading does not know its spread */
        result.contrast_u95 = result.contrast * LN10 * coverage_factor(white, black) *
                              sqrt(result.u_min * result.u_min + result.u_max * result.u_max);
    *out = result;
    return LCOR_OK;
}

lcor_status lcor_profile_evaluate(const lcor_profile *profile, lcor_profile_result *out,
                                  lcor_error *err)
{
    if (!profile || !out)
        return lcor_internal_fail(err, LCOR_ERR_ARG, -1, "profile or result is NULL");
    const lcor_profile_reading *white = find(profile, lcor_internal_is_white);
    const lcor_profile_reading *black = profile->black == LCOR_BLACK_DARKEST
                                            ? find_darkest(profile)
                                            : find(profile, lcor_internal_is_full_black);
    if (!white)
        return lcor_internal_fail(err, LCOR_ERR_DOMAIN, -1,
                                  "no reading of white (RGB 255 255 255, or CMYK 0 0 0 0)");
    if (!black)
        return lcor_internal_fail(err, LCOR_ERR_DOMAIN, -1,
                                  "no reading of black (RGB 0 0 0, or K 100 %% alone)");
    double *scratch = lcor_internal_alloc(&profile->allocator, profile->count * sizeof *scratch);
    if (!scratch)
        return lcor_internal_fail(err, LCOR_ERR_NOMEM, -1, "no memory to sort the readings");
    const patch_statistics white_statistics = gather(profile, white, scratch);
    const patch_statistics black_statistics = gather(profile, black, scratch);
    lcor_internal_free(&profile->allocator, scratch);
    return combine(white_statistics, black_statistics, out, err);
}

double lcor_profile_contrast(const lcor_profile *profile)
{
    lcor_profile_result result = {.contrast = 0.0};
    (void)lcor_profile_evaluate(profile, &result, NULL);
    return result.contrast;
}

double lcor_profile_contrast_u95(const lcor_profile *profile)
{
    lcor_profile_result result = {.contrast_u95 = 0.0};
    (void)lcor_profile_evaluate(profile, &result, NULL);
    return result.contrast_u95;
}
