/* SPDX-License-Identifier: MIT */
/* Does a text that could be read make sense? Better no value than a wrong one. */
#include "profile/reader.h"

#include "base/internal.h"

#include <math.h>
#include <string.h>

static lcor_status senseless(const reader *r, const char *what)
{
    return lcor_internal_fail(r->err, LCOR_ERR_FORMAT, -1, "%s", what);
}

/* White is a white, and nothing is lighter. */
static lcor_status check_white(const reader *r)
{
    double white = HUGE_VAL;
    for (size_t i = 0; i < r->profile->count; i++) {
        const lcor_profile_reading *p = &r->profile->readings[i];
        if (!lcor_internal_is_white(p))
            continue;
        white = fmin(white, lcor_internal_density(p));
        const double x = p->xyz[0], y = p->xyz[1], z = p->xyz[2];
        if ((p->has & LCOR_HAS_XYZ) && !(x > 0.5 * y && x < 2.0 * y && z > 0.2 * y && z < 3.0 * y))
            return senseless(
                r, "XYZ of the white patch is no white: are the columns labelled rightly?");
    }
    for (size_t i = 0; i < r->profile->count; i++)
        if (white < HUGE_VAL && lcor_internal_density(&r->profile->readings[i]) < white - 0.03)
            return senseless(r, "a patch is lighter than white: are the columns labelled rightly?");
    return LCOR_OK;
}

static const lcor_profile_reading *first_white(const lcor_profile *profile)
{
    for (size_t i = 0; i < profile->count; i++)
        if (lcor_internal_is_white(&profile->readings[i]))
            return &profile->readings[i];
    return NULL;
}

/* Is value / y within `factor` of white_value / white_y? */
static int alike(double value, double y, double white_value, double white_y, double factor)
{
    return value * white_y * factor >= white_value * y &&
           value * white_y <= white_value * y * factor;
}

/* Black has no strong colour: else it is a cyan or yellow whose column was taken for K. */
static lcor_status check_black(const reader *r)
{
    const char *class = lcor_profile_keyword(r->profile, "DEVICE_CLASS");
    const lcor_profile_reading *white = first_white(r->profile);
    if (!white || (class && strcmp(class, "DISPLAY") == 0))
        return LCOR_OK; /* displays leak colour where they should be dark */
    for (size_t i = 0; i < r->profile->count; i++) {
        const lcor_profile_reading *p = &r->profile->readings[i];
        const double *d = p->density;
        if (!lcor_internal_is_full_black(p))
            continue;
        /* below 0.3 % the last digit and stray light decide */
        if ((p->has & LCOR_HAS_XYZ) && p->xyz[1] >= 0.3 &&
            !(alike(p->xyz[0], p->xyz[1], white->xyz[0], white->xyz[1], 1.6) &&
              alike(p->xyz[2], p->xyz[1], white->xyz[2], white->xyz[1], 1.8)))
            return senseless(r, "XYZ of the black patch is a strong colour: are the columns "
                                "labelled rightly?");
        const double most = fmax(d[0], fmax(d[1], d[2])), least = fmin(d[0], fmin(d[1], d[2]));
        if ((p->has & LCOR_HAS_COLOUR_DENSITY) && most - least > 0.5 * most)
            return senseless(r, "the densities of the black patch are those of a strong colour: "
                                "are the columns labelled rightly?");
    }
    return LCOR_OK;
}

/* Visual density less -log10(Y/100) of white and of black: the same, whatever density is relative
 * to. */
static lcor_status check_density_against_y(const reader *r)
{
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (size_t i = 0; i < r->profile->count; i++) {
        const lcor_profile_reading *p = &r->profile->readings[i];
        if (!lcor_internal_is_white(p) && !lcor_internal_is_full_black(p))
            continue;
        const double offset = p->density[3] + log10(p->xyz[1] / 100.0);
        low = fmin(low, offset);
        high = fmax(high, offset);
    }
    return high - low <= 0.15 ? LCOR_OK
                              : senseless(r, "D_VIS and XYZ_Y tell different contrasts: are the "
                                             "columns labelled rightly?");
}

lcor_status lcor_internal_check_plausible(const reader *r)
{
    const unsigned both = LCOR_HAS_VISUAL | LCOR_HAS_XYZ;
    if (r->profile->black == LCOR_BLACK_DARKEST && r->declared_sets > (double)r->sets)
        return senseless(r, "fewer readings than NUMBER_OF_SETS says, the darkest may be missing: "
                            "use the whole file, or black k");
    lcor_status status = check_white(r);
    if (status == LCOR_OK)
        status = check_black(r);
    return status == LCOR_OK && (r->has & both) == both ? check_density_against_y(r) : status;
}

static int differs(double stated, double computed, double tolerance)
{
    return stated >= 0.0 && !(fabs(stated - computed) <= tolerance * computed);
}

lcor_status lcor_internal_check_contrast(const reader *r)
{
    lcor_profile_result result;
    lcor_error why;
    switch (lcor_profile_evaluate(r->profile, &result, &why)) {
    case LCOR_OK: break;
    case LCOR_ERR_NOMEM: return lcor_internal_fail(r->err, LCOR_ERR_NOMEM, -1, "%s", why.text);
    case LCOR_ERR_ARG:
    case LCOR_ERR_DOMAIN:
    case LCOR_ERR_CANCELLED:
    case LCOR_ERR_FORMAT: return senseless(r, why.text);
    }
    /* Six digits are written, so only an edit differs by more. */
    if (differs(r->contrast, result.contrast, 1e-5) ||
        differs(r->contrast_u95, result.contrast_u95, 1e-5))
        return senseless(r, "LCOR_CONTRAST is not what the readings give: the profile was edited; "
                            "remove the LCOR_CONTRAST lines to take the readings");
    return LCOR_OK;
}
