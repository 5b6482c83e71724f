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

/* 0..top; 0 for NaN */
static double clamped(double x, double top) { return x > 0.0 ? (x < top ? x : top) : 0.0; }

static int valid(double x) { return x >= 0.0 && x <= DBL_MAX; }

/* A corrected colour: its f is (fn + s kx, fn, fn + s kz), with s = 1 until rule S9. */
typedef struct corrected {
    double y, fn, kx, kz;
} corrected;

/* RGB from X and Z over white. Rows of the matrix sum to 1, so grey stays grey. */
static double channel(const lcor_plan *p, const corrected *c, int i, double x, double z)
{
    return c->y + (p->rgb_from_f[3 * i] * (x - c->y) + p->rgb_from_f[3 * i + 2] * (z - c->y));
}

static void rgb_at(const lcor_plan *p, const corrected *c, double s, double rgb[3])
{
    const double x = lcor_internal_f_inverse(p->colour.lightness, c->fn + s * c->kx);
    const double z = lcor_internal_f_inverse(p->colour.lightness, c->fn + s * c->kz);

    for (int i = 0; i < 3; i++)
        rgb[i] = channel(p, c, i, x, z);
}

/* How far a channel is outside 0..1; RGB a rounding error outside is not worth a change of chroma.
 */
static double excess(double v) { return fabs(v - 0.5) - (0.5 + 1e-14); }

/* The channel that is farthest outside. */
static int worst(const double rgb[3])
{
    const int i = excess(rgb[1]) > excess(rgb[0]) ? 1 : 0;

    return excess(rgb[2]) > excess(rgb[i]) ? 2 : i;
}

/* Where below s, which is outside, channel i comes back to 0 or to 1: Halley's method on what is a
 * cubic where both f are above the knee, and bisection where that leaves the interval. Grey, s = 0,
 * is inside. */
static double enter(const lcor_plan *p, const corrected *c, int i, double bound, double s)
{
    const lcor_lightness lightness = p->colour.lightness;
    const double n_x = p->rgb_from_f[3 * i], n_z = p->rgb_from_f[3 * i + 2], sign = bound - 0.5;
    double lo = 0.0, hi = s, step = 1.0;

    for (int k = 0; k < 64 && fabs(step) > 1e-5; k++) { /* the step after it is below 1e-15 */
        const double fx = c->fn + s * c->kx, fz = c->fn + s * c->kz;
        const double over = channel(p, c, i, lcor_internal_f_inverse(lightness, fx),
                                    lcor_internal_f_inverse(lightness, fz)) -
                            bound;
        const double slope = n_x * (c->kx * lcor_internal_f_inverse_slope(lightness, fx)) +
                             n_z * (c->kz * lcor_internal_f_inverse_slope(lightness, fz));
        const double bend = n_x * (c->kx * c->kx * lcor_internal_f_inverse_bend(lightness, fx)) +
                            n_z * (c->kz * c->kz * lcor_internal_f_inverse_bend(lightness, fz));
        double next = s - over * slope / (slope * slope - 0.5 * over * bend);

        if (over * sign > 0.0)
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

/* Rule S9: the largest s in 0..1 that fits, face by face of the cube. */
static void fit_gamut(const lcor_plan *p, const corrected *c, double rgb[3])
{
    double s = 1.0;

    for (int faces = 0; faces < 6; faces++) {
        const int i = worst(rgb);

        if (excess(rgb[i]) <= 0.0)
            return;
        s = enter(p, c, i, rgb[i] > 0.5 ? 1.0 : 0.0, s);
        rgb_at(p, c, s, rgb);
    }
}

static unsigned bad_pixel(double out[3])
{
    out[0] = out[1] = out[2] = 0.0;
    return LCOR_PIXEL_BAD;
}

/* The correction proper, from f and y of the texel. */
static unsigned correct_f(const lcor_plan *p, const double f[3], double y, double illuminance,
                          double rho, double out[3])
{
    const double y_real = y * p->rho_ratio; /* section 5.2 */
    const double r = illuminance * (p->reading == LCOR_READING_TEXEL ? y_real : rho); /* 3.1 */
    const double q = p->r_mean > 0.0 ? r / p->r_mean : 0.0;
    double t = lcor_internal_display(q, p->exponent, p->gain);
    unsigned flags = (t < 0.0 ? LCOR_PIXEL_LOW : 0u) | (t > 1.0 ? LCOR_PIXEL_HIGH : 0u);
    corrected c;
    double k;

    t = clamped(t, DBL_MAX); /* rules S1, S4 */
    if (p->reading == LCOR_READING_PATCH && t > 0.0)
        t *= rho > 0.0 ? y_real / rho : 1.0; /* eq 11; rule S2 */
    c.y = clamped(t, 1.0);                   /* rule S7 */

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
    if (excess(out[worst(out)]) > 0.0) {
        flags |= LCOR_PIXEL_OUTSIDE;
        if (p->gamut == LCOR_GAMUT_KEEP_HUE)
            fit_gamut(p, &c, out);
    }
    for (int i = 0; i < 3; i++)
        out[i] = clamped(out[i], 1.0);
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
    *y = clamped(xyz[1], DBL_MAX);
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
    return correct_f(p, f, clamped(lcor_internal_f_inverse(p->colour.lightness, f[1]), DBL_MAX),
                     illuminance, rho, out);
}
