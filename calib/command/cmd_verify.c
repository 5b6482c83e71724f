/* SPDX-License-Identifier: MIT */
/* `lccal verify`: is the device still what its profile says? */
#include "command/profile_file.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

static const char help[] =
    "lccal verify PROFILE --against OTHER [--tolerance D] [--max-age DAYS]\n"
    "lccal verify PROFILE --port PORT [--instrument NAME] [--readings N] [--timeout S] [--yes]\n"
    "lccal verify PROFILE --max-age DAYS\n"
    "\n"
    "  Compares a profile with a newer one, or with a measurement made now.\n"
    "\n"
    "  --against OTHER     the profile to compare with\n"
    "  --port PORT         measure white and black now and compare with that\n"
    "  --tolerance D       largest difference of D_min and of D_max [0.03]\n"
    "  --max-age DAYS      a profile older than this fails\n"
    "  --json, --quiet, --help, --version\n"
    "\n"
    "  Exit code 0: within tolerance; 8: not, too old, or not to be compared (other status,\n"
    "  geometry or kind of reading).\n";

typedef struct verify_options {
    const char *against;
    double tolerance, max_age; /* HUGE_VAL: any age */
    lccal_measure_options measure;
} verify_options;

#define DAY 86400.0

/* The verdict is one event: what was compared, then the exit code, and why it is not 0. */
static int verify_age(json *verdict, const lcor_profile *profile, const char *path, double max_age)
{
    const double created = profile_created(profile);
    if (max_age >= HUGE_VAL)
        return LCCAL_OK;
    if (created < 0.0)
        return lccal_fail_as(verdict, LCCAL_VERIFY_FAILED,
                             "'%s': its age is not known (no CREATED date that can be read)", path);
    const double days = ((double)time(NULL) - created) / DAY;
    char text[32], limit[32];
    lccal_format_number(text, sizeof text, days, 1);
    lccal_format_number(limit, sizeof limit, max_age, 1);
    json_number(verdict, "age_days", days, 2);
    if (days < -1.0) /* less may be a matter of time zones */
        return lccal_fail_as(verdict, LCCAL_VERIFY_FAILED,
                             "'%s' is from the future by this machine's clock (%s days old); set "
                             "the clock, or measure again",
                             path, text);
    if (days > max_age)
        return lccal_fail_as(verdict, LCCAL_VERIFY_FAILED,
                             "'%s' is %s days old, more than %s; measure again", path, text, limit);
    lccal_say("%s days old", text);
    return LCCAL_OK;
}

static unsigned quantity(const lcor_profile *profile)
{
    lcor_profile_reading r;
    if (lcor_profile_reading_get(profile, 0, &r, NULL) != LCOR_OK)
        return 0;
    return r.has & LCOR_HAS_VISUAL ? LCOR_HAS_VISUAL : LCOR_HAS_XYZ;
}

static const char *or_empty(const char *text) { return text ? text : ""; }

/* Densities of another status, geometry or backing differ without anything having changed. */
static int comparable(json *verdict, const lcor_profile *a, const lcor_profile *b)
{
    static const char *const must[] = {"MEASUREMENT_SOURCE", "MEASUREMENT_GEOMETRY",
                                       "SAMPLE_BACKING"};
    static const char *const may[] = {"INSTRUMENTATION", "MATERIAL", "PRINT_CONDITIONS"};
    if (quantity(a) != quantity(b))
        return lccal_fail_as(verdict, LCCAL_VERIFY_FAILED,
                             "one profile holds densities, the other luminances; "
                             "they cannot be compared");
    if (lcor_profile_black_get(a) != lcor_profile_black_get(b))
        return lccal_fail_as(verdict, LCCAL_VERIFY_FAILED,
                             "the profiles take different patches for black; they "
                             "cannot be compared");
    for (size_t i = 0; i < sizeof must / sizeof must[0]; i++) {
        const char *x = or_empty(lcor_profile_keyword(a, must[i]));
        const char *y = or_empty(lcor_profile_keyword(b, must[i]));
        if (*x && *y && strcmp(x, y) != 0)
            return lccal_fail_as(verdict, LCCAL_VERIFY_FAILED,
                                 "%s is '%s' in one and '%s' in the other; they cannot be compared",
                                 must[i], x, y);
    }
    for (size_t i = 0; i < sizeof may / sizeof may[0]; i++) {
        const char *x = or_empty(lcor_profile_keyword(a, may[i]));
        const char *y = or_empty(lcor_profile_keyword(b, may[i]));
        if (*x && *y && strcmp(x, y) != 0)
            lccal_warn("%s differs: '%s' and '%s'", may[i], x, y);
    }
    return LCCAL_OK;
}

/* Densities of displays mean something as a difference only: then only that is compared. */
static int compare(json *verdict, const lcor_profile *old, const lcor_profile *new,
                   double tolerance)
{
    lcor_profile_result a, b;
    int status = profile_evaluate(old, &a);
    if (status == LCCAL_OK)
        status = profile_evaluate(new, &b);
    if (status != LCCAL_OK)
        return status;
    const bool density = quantity(old) == LCOR_HAS_VISUAL;
    const double d_min = density ? b.d_min - a.d_min : 0.0;
    const double d_max = density ? b.d_max - a.d_max : log10(b.contrast / a.contrast);
    const double then = profile_created(old), now = profile_created(new);
    const double days = then < 0.0 || now < 0.0 ? HUGE_VAL : (now - then) / DAY; /* null in JSON */
    char x[32], y[32], c[80], d[80], t[32];
    lccal_format_number(x, sizeof x, d_min, 3);
    lccal_format_number(y, sizeof y, d_max, 3);
    lccal_format_number(t, sizeof t, tolerance, 3);
    profile_contrast_text(&a, c, sizeof c);
    profile_contrast_text(&b, d, sizeof d);
    json_number(verdict, "d_min_change", d_min, 4);
    json_number(verdict, "d_max_change", d_max, 4);
    json_number(verdict, "contrast_before", a.contrast, 4);
    json_number(verdict, "contrast_now", b.contrast, 4);
    json_number(verdict, "days_between", days, 2);
    json_number(verdict, "tolerance", tolerance, 4);
    if (fabs(d_min) > tolerance || fabs(d_max) > tolerance)
        return lccal_fail_as(
            verdict, LCCAL_VERIFY_FAILED,
            "the device has changed: D_min by %s, D_max by %s (tolerance %s), contrast "
            "%s -> %s; make a new profile",
            x, y, t, c, d);
    lccal_say("within %s D: D_min changed by %s, D_max by %s, contrast %s -> %s", t, x, y, c, d);
    return LCCAL_OK;
}

static int run(const char *path, const verify_options *o)
{
    lcor_profile *profile = NULL, *other = NULL;
    json verdict = lccal_event("verify");
    int status = profile_load(path, &profile);
    if (status == LCCAL_OK)
        status = verify_age(&verdict, profile, path, o->max_age);
    if (status == LCCAL_OK && o->against)
        status = profile_load(o->against, &other);
    else if (status == LCCAL_OK && o->measure.port)
        status = lccal_measure(&o->measure, &other);
    if (status == LCCAL_OK && other)
        status = comparable(&verdict, profile, other);
    if (status == LCCAL_OK && other)
        status = compare(&verdict, profile, other, o->tolerance);
    if (status == LCCAL_OK) {
        json_number(&verdict, "code", LCCAL_OK, 0);
        lccal_event_end(&verdict);
    }
    lccal_event_drop(&verdict);
    lcor_profile_free(other);
    lcor_profile_free(profile);
    return status;
}

int cmd_verify(int argc, char **argv)
{
    verify_options o = {
        .tolerance = 0.03, .max_age = HUGE_VAL, .measure = {.readings = 5, .timeout = 120.0}};
    const lccal_option options[] = {
        {"--against", NULL, LCCAL_TEXT, &o.against},
        {"--tolerance", NULL, LCCAL_NUMBER, &o.tolerance},
        {"--max-age", NULL, LCCAL_NUMBER, &o.max_age},
        {"--port", NULL, LCCAL_TEXT, &o.measure.port},
        {"--instrument", NULL, LCCAL_TEXT, &o.measure.instrument},
        {"--readings", NULL, LCCAL_COUNT, &o.measure.readings},
        {"--timeout", NULL, LCCAL_NUMBER, &o.measure.timeout},
        {"--yes", NULL, LCCAL_FLAG, &o.measure.yes},
    };
    const int parsed =
        lccal_parse_options(&argc, argv, options, sizeof options / sizeof options[0], help);
    if (parsed != LCCAL_OK)
        return parsed < 0 ? LCCAL_OK : parsed;
    if (argc != 2)
        return lccal_fail(LCCAL_USAGE, "verify wants one profile; --help explains");
    if (o.against && o.measure.port)
        return lccal_fail(LCCAL_USAGE, "--against and --port exclude each other");
    if (!o.against && !o.measure.port && o.max_age >= HUGE_VAL)
        return lccal_fail(LCCAL_USAGE, "verify compares with --against OTHER or --port PORT, or "
                                       "checks --max-age DAYS");
    if (!(o.tolerance > 0.0) || !(o.max_age > 0.0))
        return lccal_fail(LCCAL_USAGE, "--tolerance and --max-age want a number greater than 0");
    if (o.measure.readings > 1000 || !(o.measure.timeout > 0.0) || o.measure.timeout > DAY)
        return lccal_fail(LCCAL_USAGE, "--readings wants 1 to 1000, --timeout seconds up to a day");
    return run(argv[1], &o);
}
