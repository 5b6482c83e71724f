/* SPDX-License-Identifier: MIT */
/* The device's contrast and the adaptation curve of eq 8. */
#include <lcor/adapt.h>

#include "base/elementary.h"
#include "base/internal.h"

#include <float.h>
#include <math.h>

LCOR_COLD lcor_status lcor_contrast_from_density(double d_max, double d_min, double *contrast,
                                                 lcor_error *err)
{
    double c;

    if (!isfinite(d_max) || !isfinite(d_min))
        return lcor_internal_fail(err, LCOR_ERR_DOMAIN, -1, "densities must be finite");
    if (d_max <= d_min)
        return lcor_internal_fail(err, LCOR_ERR_DOMAIN, -1,
                                  "the largest density must exceed the smallest");
    c = lcor_internal_exp2((d_max - d_min) * 3.3219280948873623); /* 10^x, log2 10 */
    if (!(c > 1.0 && c <= DBL_MAX))
        return lcor_internal_fail(err, LCOR_ERR_DOMAIN, -1,
                                  "densities are too close, or too far apart, to give a contrast");
    *contrast = c;
    return LCOR_OK;
}

double lcor_contrast_u95(double contrast, double u_d_max, double u_d_min)
{
    return 1.96 * contrast * 2.3025850929940457 * hypot(u_d_max, u_d_min); /* ln 10 */
}

static LCOR_COLD lcor_status check_curve(double j_mean, double j_min, double j_max, double exponent,
                                         lcor_error *err)
{
    if (!(j_mean > 0.0 && j_mean <= DBL_MAX))
        return lcor_internal_fail(err, LCOR_ERR_DOMAIN, -1, "j_mean must be finite and > 0");
    if (!(j_min >= 0.0 && j_max > j_min && j_max <= DBL_MAX))
        return lcor_internal_fail(err, LCOR_ERR_DOMAIN, -1,
                                  "j_min must be >= 0 and j_max finite and larger");
    if (!(exponent >= 0.0 && exponent <= DBL_MAX))
        return lcor_internal_fail(err, LCOR_ERR_DOMAIN, -1, "exponent must be finite and >= 0");
    return LCOR_OK;
}

lcor_status lcor_adapt(double j, double j_mean, double j_min, double j_max, double exponent,
                       double *h, lcor_error *err)
{
    const double centre = 0.5 * j_min + 0.5 * j_max;
    const lcor_status status = check_curve(j_mean, j_min, j_max, exponent, err);
    double v;

    if (status != LCOR_OK)
        return status;
    if (!(j >= 0.0))
        return lcor_internal_fail(err, LCOR_ERR_DOMAIN, -1, "j must be >= 0");
    v = exponent > 0.0 ? centre * lcor_internal_pow(j / j_mean, exponent) : centre; /* eq 8 */
    *h = fmin(fmax(v, j_min), j_max);
    return LCOR_OK;
}

lcor_status lcor_adapt_range(double j_mean, double j_min, double j_max, double exponent, double *j1,
                             double *j2, lcor_error *err)
{
    const double centre = 0.5 * j_min + 0.5 * j_max;
    const lcor_status status = check_curve(j_mean, j_min, j_max, exponent, err);

    if (status != LCOR_OK)
        return status;
    if (exponent > 0.0) {
        /* 1/t overflows for a tiny exponent; any finite number that large gives the same ends */
        const double t = fmin(1.0 / exponent, DBL_MAX);

        *j1 = j_mean * lcor_internal_pow(j_min / centre, t);
        *j2 = j_mean * lcor_internal_pow(j_max / centre, t);
    } else {
        *j1 = 0.0;
        *j2 = HUGE_VAL;
    }
    return LCOR_OK;
}

lcor_status lcor_adapt_inverse(double h, double j_mean, double j_min, double j_max, double exponent,
                               double *j, lcor_error *err)
{
    const double centre = 0.5 * j_min + 0.5 * j_max;
    const lcor_status status = check_curve(j_mean, j_min, j_max, exponent, err);

    if (status != LCOR_OK)
        return status;
    if (!(exponent > 0.0))
        return lcor_internal_fail(err, LCOR_ERR_DOMAIN, -1,
                                  "exponent 0 shows every luminance alike: it has no inverse");
    if (!(h >= j_min && h <= j_max))
        return lcor_internal_fail(err, LCOR_ERR_DOMAIN, -1, "h must lie in j_min..j_max");
    *j = j_mean * lcor_internal_pow(h / centre, fmin(1.0 / exponent, DBL_MAX));
    return LCOR_OK;
}
