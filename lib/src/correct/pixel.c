/* SPDX-License-Identifier: MIT */
/* The correction of one pixel in double: what every faster path is measured against. */
#include "correct/internal.h"

#include "base/elementary.h"
#include "colour/internal.h"

#include <float.h>
#include <math.h>

double lcor_internal_display(double q, double exponent, double gain)
{
    /* eq 12 times rho: ((q^t (c+1)/2 - 1) / (c-1), written so that nothing cancels near q = 1 */
    return 0.5 + (lcor_internal_pow(q, exponent) - 1.0) * gain;
}

double lcor_internal_chroma_factor(double y, double y_new)
{
    const double black = 4.0 / 29.0; /* f where L* = 0 */
    const double fy = lcor_internal_f(LCOR_LIGHTNESS_CIE, y);
    const double fn = lcor_internal_f(LCOR_LIGHTNESS_CIE, y_new);

    if (fn > fy)
        return (1.0 - fn) / (1.0 - fy); /* eq 16 */
    return fy > black ? (fn - black) / (fy - black) : 1.0;
}

/* RGB of chroma scaled by s: the pixel's f is (fn + s kx, fn, fn + s kz). */
static void rgb_at(const lcor_plan *p, double y_new, double fn, double kx, double kz, double s,
                   double rgb[3])
{
    const double xyz[3] = {lcor_internal_f_inverse(p->colour.lightness, fn + s * kx), y_new,
                           lcor_internal_f_inverse(p->colour.lightness, fn + s * kz)};

    lcor_internal_mat3_apply(p->rgb_from_f, xyz, rgb);
}

/* > 0 if outside 0..1 */
static double excess(const double rgb[3])
{
    return fmax(fmax(fmax(rgb[0], rgb[1]), rgb[2]) - 1.0, -fmin(fmin(rgb[0], rgb[1]), rgb[2]));
}

/* Rule S9: the largest s in 0..1 that fits; s = 0 is grey and always does. */
static void fit_gamut(const lcor_plan *p, double y_new, double fn, double kx, double kz,
                      double rgb[3])
{
    double lo = 0.0, hi = 1.0;

    for (int i = 0; i < 54; i++) {
        const double s = 0.5 * (lo + hi);

        rgb_at(p, y_new, fn, kx, kz, s, rgb);
        if (excess(rgb) > 0.0)
            hi = s;
        else
            lo = s;
    }
    rgb_at(p, y_new, fn, kx, kz, lo, rgb);
}

static int valid(double x) { return x >= 0.0 && x <= DBL_MAX; }

static unsigned bad_pixel(double out[3])
{
    out[0] = out[1] = out[2] = 0.0;
    return LCOR_PIXEL_BAD;
}

unsigned lcor_internal_correct_pixel(const lcor_plan *p, const double rgb[3], double illuminance,
                                     double rho, double out[3])
{
    /* RGB a rounding error outside the cube is not worth a change of chroma */
    const double slack = 1e-14;
    const lcor_lightness kind = p->colour.lightness;
    unsigned flags = 0;
    double xyz[3], y, r, q, t, y_new, fx, fy, fz, fn, k;

    if (!valid(rgb[0]) || !valid(rgb[1]) || !valid(rgb[2]) || !valid(illuminance) || !valid(rho))
        return bad_pixel(out);
    lcor_internal_mat3_apply(p->f_from_rgb, rgb, xyz);      /* eq 1 over the white of eqs 2-4 */
    if (!valid(xyz[0]) || !valid(xyz[1]) || !valid(xyz[2])) /* overflow, or odd custom primaries */
        return bad_pixel(out);

    y = xyz[1] * p->rho_ratio;                                      /* section 5.2 */
    r = illuminance * (p->reading == LCOR_READING_TEXEL ? y : rho); /* section 3.1 */
    q = p->r_mean > 0.0 ? r / p->r_mean : 0.0;
    t = lcor_internal_display(q, p->exponent, p->gain);
    flags |= t < 0.0 ? LCOR_PIXEL_LOW : 0u;
    flags |= t > 1.0 ? LCOR_PIXEL_HIGH : 0u;
    t = fmin(fmax(t, 0.0), DBL_MAX); /* rules S1, S4 */
    if (p->reading == LCOR_READING_PATCH)
        t *= rho > 0.0 ? y / rho : 1.0; /* eq 11; rule S2 */
    y_new = fmin(t, 1.0);               /* rule S7 */

    fx = lcor_internal_f(kind, xyz[0]);
    fy = lcor_internal_f(kind, xyz[1]);
    fz = lcor_internal_f(kind, xyz[2]);
    fn = lcor_internal_f(kind, y_new); /* eq 13b */
    k = lcor_internal_chroma_factor(xyz[1], y_new);
    rgb_at(p, y_new, fn, k * (fx - fy), k * (fz - fy), 1.0, out); /* eqs 14, 15 */
    if (excess(out) > slack) {
        flags |= LCOR_PIXEL_OUTSIDE;
        if (p->gamut == LCOR_GAMUT_KEEP_HUE)
            fit_gamut(p, y_new, fn, k * (fx - fy), k * (fz - fy), out);
    }
    for (int i = 0; i < 3; i++)
        out[i] = fmin(fmax(out[i], 0.0), 1.0);
    return flags;
}
