/* SPDX-License-Identifier: MIT */
/* `lccal show`: what a profile, or measurements of another program, say. */
#include "command/export.h"

#include <stdio.h>
#include <string.h>

static const char help[] =
    "lccal show PROFILE [--readings]\n"
    "\n"
    "  Contrast and densities with their uncertainty, provenance and patches of a profile or of\n"
    "  another program's .ti3 or CGATS text.\n"
    "\n"
    "  --readings          every reading, rejected ones marked\n"
    "  --json              one object with all of that\n"
    "  --quiet, --help, --version\n";

static void number(buffer *out, const char *name, double value, int decimals)
{
    buffer_text(out, name);
    buffer_number(out, value, decimals);
}

static void put_patch(buffer *out, const char *name, double value, size_t readings, double u)
{
    number(out, name, value, 4);
    number(out, "  from ", (double)readings, 0);
    buffer_text(out, readings == 1 ? " reading" : " readings");
    if (u > 0.0)
        number(out, ", standard uncertainty of its density ", u, 4);
    buffer_text(out, "\n");
}

static void put_summary(buffer *out, const lcor_profile *profile, const lcor_profile_result *r)
{
    char text[80];
    const bool display = profile_is_display(profile);
    const bool darkest = lcor_profile_black_get(profile) == LCOR_BLACK_DARKEST;
    buffer_text(out, "contrast        ");
    buffer_text(out, profile_contrast_text(r, text, sizeof text));
    buffer_text(out, r->contrast_u95 > 0.0 ? " (95 %)\n" : " (uncertainty not known)\n");
    put_patch(out, display ? "J_max (cd/m2)   " : "D_min (white)   ",
              display ? profile_luminance(r->d_min) : r->d_min, r->n_min, r->u_min);
    put_patch(out, display ? "J_min (cd/m2)   " : "D_max (black)   ",
              display ? profile_luminance(r->d_max) : r->d_max, r->n_max, r->u_max);
    buffer_text(out, darkest ? "black           the darkest patch"
                             : "black           full drive (R = G = B = 0, or K 100 %)");
    number(out, "\nresolution      ", lcor_profile_resolution(profile), 6);
    number(out, "\ngrey levels     ", (double)lcor_profile_grey_levels(profile), 0);
    number(out, "\nreadings        ", (double)lcor_profile_count(profile), 0);
    buffer_text(out, "\n");
}

static void put_keywords(buffer *out, const lcor_profile *profile)
{
    for (size_t i = 0; i < lcor_profile_keyword_count(profile); i++) {
        const char *name = lcor_profile_keyword_name(profile, i);
        buffer_text(out, name);
        buffer_text(out, ": ");
        buffer_text(out, lcor_profile_keyword(profile, name));
        buffer_text(out, "\n");
    }
}

static void put_values(buffer *out, const char *name, const double *values, int n)
{
    buffer_text(out, name);
    for (int i = 0; i < n; i++) {
        buffer_text(out, " ");
        buffer_number(out, values[i], 6);
    }
}

static void put_readings(buffer *out, const lcor_profile *profile)
{
    lcor_profile_reading r;
    for (size_t i = 0; lcor_profile_reading_get(profile, i, &r, NULL) == LCOR_OK; i++) {
        buffer_text(out, r.id);
        if (r.name[0]) {
            buffer_text(out, " ");
            buffer_text(out, r.name);
        }
        if (r.has & LCOR_HAS_RGB)
            put_values(out, "  RGB", r.rgb, 3);
        if (r.has & LCOR_HAS_CMYK)
            put_values(out, "  CMYK", r.cmyk, 4);
        if (r.has & LCOR_HAS_VISUAL)
            put_values(out, "  D", r.density + 3, 1);
        if (r.has & LCOR_HAS_COLOUR_DENSITY)
            put_values(out, "  D RGB", r.density, 3);
        if (r.has & LCOR_HAS_XYZ)
            put_values(out, "  XYZ", r.xyz, 3);
        buffer_text(out, r.rejected ? "  rejected\n" : "\n");
    }
}

static void tell_event(const lcor_profile *profile, const lcor_profile_result *r, const char *path,
                       bool readings)
{
    json event = lccal_event("profile");
    json_text(&event, "path", path);
    json_profile(&event, profile, r);
    json_number(&event, "grey_levels", (double)lcor_profile_grey_levels(profile), 0);
    json_number(&event, "count", (double)lcor_profile_count(profile), 0);
    if (readings)
        json_readings(&event, profile);
    lccal_event_end(&event);
}

int cmd_show(int argc, char **argv)
{
    bool readings = false;
    lcor_profile *profile = NULL;
    lcor_profile_result result;
    const lccal_option options[] = {{"--readings", NULL, LCCAL_FLAG, &readings}};
    int status = lccal_parse_options(&argc, argv, options, 1, help);
    if (status != LCCAL_OK)
        return status < 0 ? LCCAL_OK : status;
    if (argc != 2)
        return lccal_fail(LCCAL_USAGE, "show wants one profile; --help explains");
    status = profile_load(argv[1], &profile);
    if (status == LCCAL_OK)
        status = profile_evaluate(profile, &result);
    if (status == LCCAL_OK && lccal_json()) {
        tell_event(profile, &result, argv[1], readings);
    } else if (status == LCCAL_OK) {
        buffer out = {0};
        put_summary(&out, profile, &result);
        put_keywords(&out, profile);
        if (readings)
            put_readings(&out, profile);
        if (out.failed)
            status = lccal_fail(LCCAL_FAILED, "out of memory");
        else
            fwrite(out.bytes, 1, out.size, stdout);
        buffer_free(&out);
    }
    lcor_profile_free(profile);
    return status;
}
