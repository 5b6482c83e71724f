/* SPDX-License-Identifier: MIT */
/** @file
 *  Adaptation: the mean of the virtual reflectance r, the device's contrast from densities, and
 *  the curve of eq 8.
 *
 *  | call                          | may run at the same time as          |
 *  |-------------------------------|--------------------------------------|
 *  | lcor_mean_* on one lcor_mean  | calls on other lcor_mean             |
 *  | everything else here (pure)   | anything                             | */
#ifndef LCOR_ADAPT_H
#define LCOR_ADAPT_H

#include <lcor/status.h>

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** How zeros and near-zeros among r are treated (section 4.3; rule S3 of docs/MODEL.md). */
typedef enum lcor_mean_method {
    LCOR_MEAN_ADAPTIVE = 0, /**< ln m = mean(max(ln r, ln m - ln 10)): a dark corner cannot rule */
    LCOR_MEAN_LITERAL = 1   /**< geometric mean of max(r, 1e-8 * largest r) */
} lcor_mean_method;

/** Contrast of a device from two densities of one print.
 *
 *  c = 10^(d_max - d_min)
 *  Errors: LCOR_ERR_DOMAIN not finite, or d_max <= d_min. */
LCOR_API lcor_status lcor_contrast_from_density(double d_max, double d_min, double *contrast,
                                                lcor_error *err);

/** Half-width of the interval of c that holds it with 95 % (expanded uncertainty), from the
 *  standard uncertainties of the two densities: 1.96 c ln 10 sqrt(u_max^2 + u_min^2). */
LCOR_API double lcor_contrast_u95(double contrast, double u_d_max, double u_d_min);

/** Display luminance H of scene luminance J, and the ends of the displayable range (eq 8).
 *
 *  H = J_cen (J / j_mean)^exponent clipped to j_min..j_max, J_cen = (j_min + j_max) / 2; monotone.
 *  J1, J2 are the scene luminances shown as j_min and j_max (0 and infinity for exponent 0).
 *  Errors: LCOR_ERR_DOMAIN j < 0, j_mean <= 0, j_min < 0, j_max <= j_min, exponent < 0, NaN. */
LCOR_API lcor_status lcor_adapt(double j, double j_mean, double j_min, double j_max,
                                double exponent, double *h, lcor_error *err);
LCOR_API lcor_status lcor_adapt_range(double j_mean, double j_min, double j_max, double exponent,
                                      double *j1, double *j2, lcor_error *err);
/** Inverse of lcor_adapt for h in j_min..j_max and exponent > 0. */
LCOR_API lcor_status lcor_adapt_inverse(double h, double j_mean, double j_min, double j_max,
                                        double exponent, double *j, lcor_error *err);

/** Sums over the values of one range of log2 r, in exact fixed point (low word first). */
typedef struct lcor_mean_sum {
    uint64_t weight[2]; /**< unit 2^-72 */
    uint64_t moment[2]; /**< of weight times log2 r + 1088, unit 2^-60 */
} lcor_mean_sum;

#define LCOR_MEAN_BINS 512

/** Running mean of ln r (section 4.3): a plain value of 16 KiB that may be copied and kept one per
 *  thread. All sums are integers, so the bits of the result depend neither on the order of the
 *  values nor on how they were split between calls or means.
 *
 *  Both methods compare ln r with a bound that is known only at the end, so values are kept as sums
 *  in bins of 1/8 octave below the largest. What falls into the bin of the bound leaves a doubt,
 *  which lcor_mean_error bounds: below 0.02 always, about 1e-5 for photographs. It does not matter
 *  on 8-bit devices; lcor_mean_refine and a second pass over the same values make it 512 times
 *  smaller or more, and so on down to rounding. Fields are for the calls below. */
typedef struct lcor_mean {
    uint64_t rejected;          /**< values left out: NaN, infinite, negative, bad weight */
    uint64_t zeros[2];          /**< weight of r = 0 */
    uint64_t top;               /**< upper end of the bins, log2 r + 1088 in unit 2^-52; 0: none */
    uint64_t largest;           /**< of all r, same unit */
    int shift;                  /**< log2 of a bin's width in that unit */
    int pass;                   /**< 0, 1, 2... */
    int method;                 /**< of the latest refinement */
    lcor_mean_sum above, below; /**< what lies outside the bins */
    lcor_mean_sum bins[LCOR_MEAN_BINS]; /**< from the top downwards */
} lcor_mean;

LCOR_API void lcor_mean_init(lcor_mean *mean);
/** Add n values of r with weights (NULL: all 1; a gaze, area or coverage map, 0..2^24, resolved to
 *  2^-72). NaN, infinite and negative values or weights are counted in `rejected` and left out. */
LCOR_API void lcor_mean_add(lcor_mean *mean, size_t n, const double *r, const double *weights);
/** Errors: LCOR_ERR_ARG after lcor_mean_refine, when the two are not copies of one refined mean. */
LCOR_API lcor_status lcor_mean_merge(lcor_mean *into, const lcor_mean *from, lcor_error *err);
/** The mean so far; 0 when every value was 0 (all black).
 *  Errors: LCOR_ERR_DOMAIN nothing added; LCOR_ERR_ARG refined for the other method. */
LCOR_API lcor_status lcor_mean_get(const lcor_mean *mean, lcor_mean_method method, double *r_mean,
                                   lcor_error *err);
/** Bound of the relative error of lcor_mean_get that a further pass would reduce; 0: only rounding
 *  (some 1e-15) is left. */
LCOR_API double lcor_mean_error(const lcor_mean *mean, lcor_mean_method method);
/** Begin a further pass: narrows the bins to the one in doubt. Add all the same values again
 *  (several threads: copy the refined mean, add, merge), then ask lcor_mean_get again. */
LCOR_API void lcor_mean_refine(lcor_mean *mean, lcor_mean_method method);
/** The mean of one array, to rounding: as many passes as it takes, seldom more than two.
 *  Stack: 17 KiB.  Errors: LCOR_ERR_DOMAIN no valid value of weight > 0. */
LCOR_API lcor_status lcor_geometric_mean(size_t n, const double *r, const double *weights,
                                         lcor_mean_method method, double *r_mean, lcor_error *err);

#ifdef __cplusplus
}
#endif

#endif
