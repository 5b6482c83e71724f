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

static double chroma_factor(double fy, double fn)
{
    const double black = 4.0 / 29.0; /* f where L* = 0 */

    if (fn > fy)
        return (1.0 - fn) / (1.0 - fy); /* eq 16 */
    return fy > black ? (fn - black) / (fy - black) : 1.0;
}

double lcor_internal_chroma_factor(double y, double y_new)
{
    return chroma_factor(lcor_internal_f(LCOR_LIGHTNESS_CIE, y),
                         lcor_internal_f(LCOR_LIGHTNESS_CIE, y_new));
}

/* A corrected colour: its f is (fn + s kx, fn, fn + s kz), with s = 1 until rule S9. */
typedef struct corrected {
    double y, fn, kx, kz;
} corrected;

static void rgb_at(const lcor_plan *p, const corrected *c, double s, double rgb[3])
{
    const double xyz[3] = {lcor_internal_f_inverse(p->colour.lightness, c->fn + s * c->kx), c->y,
                           lcor_internal_f_inverse(p->colour.lightness, c->fn + s * c->kz)};

    lcor_internal_mat3_apply(p->rgb_from_f, xyz, rgb);
}

/* How far RGB is outside 0..1, <= 0 inside, and how fast that grows with s. */
static double excess_at(const lcor_plan *p, const corrected *c, double s, double *slope)
{
    const double *n = p->rgb_from_f;
    const double dx = c->kx * lcor_internal_f_inverse_slope(p->colour.lightness, c->fn + s * c->kx);
    const double dz = c->kz * lcor_internal_f_inverse_slope(p->colour.lightness, c->fn + s * c->kz);
    double rgb[3], worst = -1.0;

    rgb_at(p, c, s, rgb);
    for (int i = 0; i < 3; i++) {
        const double over = rgb[i] > 0.5 ? rgb[i] - 1.0 : -rgb[i];

        if (over > worst) {
            const double d = n[3 * i] * dx + n[3 * i + 2] * dz;

            worst = over;
            *slope = rgb[i] > 0.5 ? d : -d;
        }
    }
    return worst;
}

/* Rule S9: the largest s in 0..1 that fits, between 0, which is grey and fits, and 1, which does
 * not: Newton's method on the channel that is farthest outside, bisection where that leaves the
 * interval. */
static double fit_gamut(const lcor_plan *p, const corrected *c)
{
    double lo = 0.0, hi = 1.0, s = 1.0, step = 1.0;

    for (int i = 0; i < 64 && fabs(step) > 1e-9; i++) { /* the step after it is below 1e-16 */
        double slope = 0.0;
        const double over = excess_at(p, c, s, &slope);
        double next = s - over / slope;

        if (over > 0.0)
            hi = s;
        else
            lo = s;
        if (!(next >= lo && next <= hi))
            next = 0.5 * (lo + hi);
        step = next - s;
        s = next;
    }
    return s;
}

/* > 0 if outside 0..1 */
static double excess(const double rgb[3])
{
    return fmax(fmax(fmax(rgb[0], rgb[1]), rgb[2]) - 1.0, -fmin(fmin(rgb[0], rgb[1]), rgb[2]));
}

static int valid(double x) { return x >= 0.0 && x <= DBL_MAX; }

static unsigned bad_pixel(double out[3])
{
    out[0] = out[1] = out[2] = 0.0;
    return LCOR_PIXEL_BAD;
}

/* The correction proper, from f and y of the texel. */
static unsigned correct_f(const lcor_plan *p, const double f[3], double y, double illuminance,
                          double rho, double out[3])
{
    /* RGB a rounding error outside the cube is not worth a change of chroma */
    const double slack = 1e-14;
    const double y_real = y * p->rho_ratio; /* section 5.2 */
    const double r = illuminance * (p->reading == LCOR_READING_TEXEL ? y_real : rho); /* 3.1 */
    const double q = p->r_mean > 0.0 ? r / p->r_mean : 0.0;
    double t = lcor_internal_display(q, p->exponent, p->gain);
    unsigned flags = (t < 0.0 ? LCOR_PIXEL_LOW : 0u) | (t > 1.0 ? LCOR_PIXEL_HIGH : 0u);
    corrected c;
    double k;

    t = fmin(fmax(t, 0.0), DBL_MAX); /* rules S1, S4 */
    if (p->reading == LCOR_READING_PATCH && t > 0.0)
        t *= rho > 0.0 ? y_real / rho : 1.0; /* eq 11; rule S2 */
    c.y = fmin(t, 1.0);                      /* rule S7 */

    if (c.y == 1.0) { /* white, whatever the rounding of the matrices */
        out[0] = out[1] = out[2] = 1.0;
        return flags;
    }

    c.fn = lcor_internal_f(p->colour.lightness, c.y); /* eq 13b */
    k = p->colour.lightness == LCOR_LIGHTNESS_CIE ? chroma_factor(f[1], c.fn)
                                                  : lcor_internal_chroma_factor(y, c.y);
    c.kx = k * (f[0] - f[1]); /* eq 14 */
    c.kz = k * (f[2] - f[1]); /* eq 15 */
    rgb_at(p, &c, 1.0, out);
    if (excess(out) > slack) {
        flags |= LCOR_PIXEL_OUTSIDE;
        if (p->gamut == LCOR_GAMUT_KEEP_HUE)
            rgb_at(p, &c, fit_gamut(p, &c), out);
    }
    for (int i = 0; i < 3; i++)
        out[i] = fmin(fmax(out[i], 0.0), 1.0);
    return flags;
}

int lcor_internal_texel_f(const lcor_plan *p, const double rgb[3], double f[3], double *y)
{
    double xyz[3];

    if (!valid(rgb[0]) || !valid(rgb[1]) || !valid(rgb[2]))
        return 0;
    lcor_internal_mat3_apply(p->f_from_rgb, rgb, xyz); /* eq 1 over the white of eqs 2-4 */
    if (!isfinite(xyz[0]) || !isfinite(xyz[1]) || !isfinite(xyz[2]))
        return 0;
    for (int i = 0; i < 3; i++)
        f[i] = lcor_internal_f(p->colour.lightness, xyz[i]);
    *y = fmax(xyz[1], 0.0);
    return 1;
}

unsigned lcor_internal_correct_pixel(const lcor_plan *p, const double rgb[3], double illuminance,
                                     double rho, double out[3])
{
    double f[3], y;

    if (!valid(illuminance) || !valid(rho) || !lcor_internal_texel_f(p, rgb, f, &y))
        return bad_pixel(out);
    return correct_f(p, f, y, illuminance, rho, out);
}

unsigned lcor_internal_correct_texel_f(const lcor_plan *p, const double f[3], double illuminance,
                                       double rho, double out[3])
{
    if (!valid(illuminance) || !valid(rho) || !isfinite(f[0]) || !isfinite(f[1]) || !isfinite(f[2]))
        return bad_pixel(out);
    return correct_f(p, f, fmax(lcor_internal_f_inverse(p->colour.lightness, f[1]), 0.0),
                     illuminance, rho, out);
}
