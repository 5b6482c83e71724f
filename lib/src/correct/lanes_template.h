/* SPDX-License-Identifier: MIT */
/* The correction in double for one instruction set, included by kernel.c as kernel_template.h is.
 * Every lane goes all ways; what it does not need is chosen away. */

STAGE void ISA(f_of)(lcor_lightness lightness, double *restrict t)
{
    if (lightness == LCOR_LIGHTNESS_CIE) {
        EACH (j, LCOR_LANES)
            t[j] = lcor_internal_f_cie(t[j]);
    } else {
        for (int j = 0; j < LCOR_LANES; j++)
            t[j] = lcor_internal_cbrt(t[j]);
    }
}

/* Linear RGB to f and Y over white. What is bad (rule S10) becomes black. */
STAGE void ISA(lanes_to_f)(const lcor_plan *p, lcor_lanes *restrict l)
{
    const double *m = p->f_from_rgb;
    const double x_r = m[0], x_g = m[1], x_b = m[2], y_r = m[3], y_g = m[4], y_b = m[5];
    const double z_r = m[6], z_g = m[7], z_b = m[8];

    EACH (j, LCOR_LANES) {
        const double r = l->c[0][j], g = l->c[1][j], b = l->c[2][j];
        const double x = x_r * r + x_g * g + x_b * b; /* eq 1 over the white of eqs 2-4 */
        const double y = y_r * r + y_g * g + y_b * b;
        const double z = z_r * r + z_g * g + z_b * b;
        const int good = (r >= 0.0) & (g >= 0.0) & (b >= 0.0) & (fabs(x) <= DBL_MAX) &
                         (fabs(y) <= DBL_MAX) & (fabs(z) <= DBL_MAX);

        l->good[j] = good ? 1.0 : 0.0;
        l->c[0][j] = good ? x : 0.0;
        l->c[1][j] = good ? y : 0.0;
        l->c[2][j] = good ? z : 0.0;
        l->y[j] = good && y > 0.0 ? y : 0.0;
    }
    for (int i = 0; i < 3; i++)
        ISA(f_of)(p->colour.lightness, l->c[i]);
}

/* Corrected colours on their way to RGB: their f is (fn + s kx, fn, fn + s kz). */
typedef struct ISA(chromas) {
    double fn[LCOR_LANES], kx[LCOR_LANES], kz[LCOR_LANES];
    double s[LCOR_LANES]; /* of rule S9 */
    double knee;          /* of f */
    /* The face of the RGB cube that a colour is farthest beyond: the row of its channel in the
     * matrix, and where the channel must go. step: the last one of s, 0 for colours inside. */
    double n_x[LCOR_LANES], n_z[LCOR_LANES], bound[LCOR_LANES], step[LCOR_LANES];
} ISA(chromas);

/* New lightness and chroma. */
INNER void ISA(new_chromas)(const lcor_plan *p, const lcor_lanes *restrict l,
                            ISA(chromas) *restrict w)
{
    const int is_cie = p->colour.lightness == LCOR_LIGHTNESS_CIE;

    w->knee = is_cie ? 6.0 / 29.0 : -HUGE_VAL;
    memcpy(w->fn, l->y_new, sizeof w->fn);
    ISA(f_of)(p->colour.lightness, w->fn); /* eq 13b */
    EACH (j, LCOR_LANES) {
        const double k = is_cie ? lcor_lane_chroma(l->c[1][j], w->fn[j]) : l->k[j]; /* eq 16 */

        w->kx[j] = k * (l->c[0][j] - l->c[1][j]); /* eq 14 */
        w->kz[j] = k * (l->c[2][j] - l->c[1][j]); /* eq 15 */
        w->s[j] = 1.0;
    }
}

/* RGB, and the faces it is beyond; not 0 if there are any. */
STAGE int ISA(to_rgb)(const double *n, lcor_lanes *restrict l, ISA(chromas) *restrict w)
{
    const double r_x = n[0], r_z = n[2], g_x = n[3], g_z = n[5], b_x = n[6], b_z = n[8];
    const double knee = w->knee;
    int any = 0;

    EACH (j, LCOR_LANES) {
        const double y = l->y_new[j];
        const double dx = lcor_lane_t(knee, w->fn[j] + w->s[j] * w->kx[j]) - y;
        const double dz = lcor_lane_t(knee, w->fn[j] + w->s[j] * w->kz[j]) - y;
        /* rows of the matrix sum to 1: in this form grey stays grey */
        const double r = y + (r_x * dx + r_z * dz);
        const double g = y + (g_x * dx + g_z * dz);
        const double b = y + (b_x * dx + b_z * dz);
        const int to_g = lcor_lane_excess(g) > lcor_lane_excess(r);
        const double v = to_g ? g : r, v_x = to_g ? g_x : r_x, v_z = to_g ? g_z : r_z;
        const int to_b = lcor_lane_excess(b) > lcor_lane_excess(v);
        const double worst = to_b ? b : v;

        l->c[0][j] = r;
        l->c[1][j] = g;
        l->c[2][j] = b;
        w->n_x[j] = to_b ? b_x : v_x;
        w->n_z[j] = to_b ? b_z : v_z;
        w->bound[j] = worst > 0.5 ? 1.0 : 0.0;
        w->step[j] = lcor_lane_excess(worst) > 0.0 ? 1.0 : 0.0;
    }
    for (int j = 0; j < LCOR_LANES; j++)
        any |= w->step[j] != 0.0;
    return any;
}

/* Where below s, which is beyond it, a colour comes back to its face: Halley's method on what is a
 * cubic where both f are above the knee, and bisection where that leaves the interval. Grey, s = 0,
 * is inside. After a step of 1e-5 the next one would be below 1e-15. */
STAGE void ISA(enter)(const lcor_lanes *restrict l, ISA(chromas) *restrict w)
{
    const double knee = w->knee;
    double low[LCOR_LANES] = {0.0}, high[LCOR_LANES];
    int any = 1;

    memcpy(high, w->s, sizeof high);
    for (int k = 0; k < 64 && any; k++) {
        EACH (j, LCOR_LANES) {
            const double s = w->s[j], y = l->y_new[j], kx = w->kx[j], kz = w->kz[j];
            const double n_x = w->n_x[j], n_z = w->n_z[j], bound = w->bound[j];
            const double fx = w->fn[j] + s * kx, fz = w->fn[j] + s * kz;
            const double dx = lcor_lane_t(knee, fx) - y, dz = lcor_lane_t(knee, fz) - y;
            const double over = y + (n_x * dx + n_z * dz) - bound;
            const double slope =
                n_x * (kx * lcor_lane_t_slope(knee, fx)) + n_z * (kz * lcor_lane_t_slope(knee, fz));
            const double bend = n_x * (kx * kx * lcor_lane_t_bend(knee, fx)) +
                                n_z * (kz * kz * lcor_lane_t_bend(knee, fz));
            const double divisor = slope * slope - 0.5 * over * bend;
            const double halley = s - over * slope / (divisor != 0.0 ? divisor : 1.0);
            const int beyond = over * (bound - 0.5) > 0.0;
            const double lo = beyond ? low[j] : s, hi = beyond ? s : high[j];
            const int fits = (halley >= lo) & (halley <= hi);
            const double next = fits ? halley : 0.5 * (lo + hi);

            low[j] = lo;
            high[j] = hi;
            w->step[j] = fabs(w->step[j]) > 1e-5 ? next - s : 0.0;
            w->s[j] = s + w->step[j];
        }
        any = 0;
        for (int j = 0; j < LCOR_LANES; j++)
            any |= fabs(w->step[j]) > 1e-5;
    }
}

/* The new colours as RGB by the plan's gamut rule, still to be clamped, and which left the gamut.
 */
STAGE void ISA(lanes_to_rgb)(const lcor_plan *p, lcor_lanes *restrict l)
{
    ISA(chromas) w;
    int any;

    ISA(new_chromas)(p, l, &w);
    any = ISA(to_rgb)(p->rgb_from_f, l, &w);
    memcpy(l->outside, w.step, sizeof l->outside);
    if (p->gamut == LCOR_GAMUT_KEEP_HUE)
        for (int faces = 0; faces < 6 && any; faces++) { /* rule S9, face after face */
            ISA(enter)(l, &w);
            any = ISA(to_rgb)(p->rgb_from_f, l, &w);
        }
}
