/* SPDX-License-Identifier: MIT */
#include "command/export.h"

#include <string.h>

enum { DECIMALS = 9 }; /* all that a profile holds of densities */

static void put_list(json *j, const char *key, const double *values, int n)
{
    json_open(j, key, '[');
    for (int i = 0; i < n; i++)
        json_number(j, NULL, values[i], DECIMALS);
    json_close(j, ']');
}

void json_profile(json *j, const lcor_profile *profile, const lcor_profile_result *r)
{
    const bool darkest = lcor_profile_black_get(profile) == LCOR_BLACK_DARKEST;
    json_number(j, "contrast", r->contrast, DECIMALS);
    json_number(j, "contrast_u95", r->contrast_u95, DECIMALS);
    json_number(j, "d_min", r->d_min, DECIMALS);
    json_number(j, "d_max", r->d_max, DECIMALS);
    json_number(j, "u_min", r->u_min, DECIMALS);
    json_number(j, "u_max", r->u_max, DECIMALS);
    json_number(j, "n_min", (double)r->n_min, 0);
    json_number(j, "n_max", (double)r->n_max, 0);
    json_number(j, "resolution", lcor_profile_resolution(profile), DECIMALS);
    json_text(j, "black", darkest ? "darkest" : "full");
    json_open(j, "keywords", '{');
    for (size_t i = 0; i < lcor_profile_keyword_count(profile); i++) {
        const char *name = lcor_profile_keyword_name(profile, i);
        json_text(j, name, lcor_profile_keyword(profile, name));
    }
    json_close(j, '}');
}

static void put_reading(json *j, const lcor_profile_reading *r)
{
    json_open(j, NULL, '{');
    json_text(j, "id", r->id);
    json_text(j, "name", r->name);
    if (r->has & LCOR_HAS_RGB)
        put_list(j, "rgb", r->rgb, 3);
    if (r->has & LCOR_HAS_CMYK)
        put_list(j, "cmyk", r->cmyk, 4);
    if (r->has & LCOR_HAS_COLOUR_DENSITY)
        put_list(j, "density_rgb", r->density, 3);
    if (r->has & LCOR_HAS_VISUAL)
        json_number(j, "density", r->density[3], DECIMALS);
    if (r->has & LCOR_HAS_XYZ)
        put_list(j, "xyz", r->xyz, 3);
    json_bool(j, "rejected", r->rejected != 0);
    json_close(j, '}');
}

void json_readings(json *j, const lcor_profile *profile)
{
    lcor_profile_reading r;
    json_open(j, "readings", '[');
    for (size_t i = 0; lcor_profile_reading_get(profile, i, &r, NULL) == LCOR_OK; i++)
        put_reading(j, &r);
    json_close(j, ']');
}

void export_json(const lcor_profile *profile, const lcor_profile_result *result, buffer *out)
{
    json j = {.out = *out};
    json_open(&j, NULL, '{');
    json_profile(&j, profile, result);
    json_readings(&j, profile);
    json_close(&j, '}');
    buffer_text(&j.out, "\n");
    *out = j.out;
}

/* A cell; names hold no quotes. */
static void csv_text(buffer *out, const char *text)
{
    const char *quote = strpbrk(text, ",;\t #") || !*text ? "\"" : "";
    buffer_text(out, quote);
    buffer_text(out, text);
    buffer_text(out, quote);
}

static void csv_numbers(buffer *out, bool wanted, const double *values, int n)
{
    for (int i = 0; wanted && i < n; i++) {
        buffer_text(out, ",");
        buffer_number(out, values[i], DECIMALS);
    }
}

void export_csv(const lcor_profile *profile, buffer *out)
{
    lcor_profile_reading r;
    const unsigned has = lcor_profile_reading_get(profile, 0, &r, NULL) == LCOR_OK ? r.has : 0;
    buffer_text(out, "SAMPLE_ID,SAMPLE_NAME");
    buffer_text(out, has & LCOR_HAS_RGB ? ",RGB_R,RGB_G,RGB_B" : "");
    buffer_text(out, has & LCOR_HAS_CMYK ? ",CMYK_C,CMYK_M,CMYK_Y,CMYK_K" : "");
    buffer_text(out, has & LCOR_HAS_COLOUR_DENSITY ? ",D_RED,D_GREEN,D_BLUE" : "");
    buffer_text(out, has & LCOR_HAS_VISUAL ? ",D_VIS" : "");
    buffer_text(out, has & LCOR_HAS_XYZ ? ",XYZ_X,XYZ_Y,XYZ_Z" : "");
    buffer_text(out, ",LCOR_REJECTED\n");
    for (size_t i = 0; lcor_profile_reading_get(profile, i, &r, NULL) == LCOR_OK; i++) {
        csv_text(out, r.id);
        buffer_text(out, ",");
        csv_text(out, r.name);
        csv_numbers(out, has & LCOR_HAS_RGB, r.rgb, 3);
        csv_numbers(out, has & LCOR_HAS_CMYK, r.cmyk, 4);
        csv_numbers(out, has & LCOR_HAS_COLOUR_DENSITY, r.density, 3);
        csv_numbers(out, has & LCOR_HAS_VISUAL, r.density + 3, 1);
        csv_numbers(out, has & LCOR_HAS_XYZ, r.xyz, 3);
        buffer_text(out, r.rejected ? ",1\n" : ",0\n");
    }
}
