/* SPDX-License-Identifier: MIT */
#include "command/export.h"

#include <string.h>

enum { DECIMALS = 9 }; /* all that a profile holds of densities */

static void put_string(buffer *out, const char *text)
{
    static const char hex[] = "0123456789abcdef";
    buffer_text(out, "\"");
    for (const char *s = text; *s; s++) {
        const unsigned char c = (unsigned char)*s;
        const char escaped[] = {'\\', 'u', '0', '0', hex[c >> 4], hex[c & 15]};
        if (c < 0x20 || c == '"' || c == '\\')
            buffer_bytes(out, escaped, sizeof escaped);
        else
            buffer_bytes(out, s, 1);
    }
    buffer_text(out, "\"");
}

static void put_number(buffer *out, const char *key, double value)
{
    buffer_text(out, key);
    buffer_number(out, value, DECIMALS);
}

static void put_list(buffer *out, const char *key, const double *values, int n)
{
    buffer_text(out, key);
    for (int i = 0; i < n; i++)
        put_number(out, i ? ", " : "[", values[i]);
    buffer_text(out, "]");
}

static void json_reading(buffer *out, const lcor_profile_reading *r)
{
    buffer_text(out, "    {\"id\": ");
    put_string(out, r->id);
    buffer_text(out, ", \"name\": ");
    put_string(out, r->name);
    if (r->has & LCOR_HAS_RGB)
        put_list(out, ", \"rgb\": ", r->rgb, 3);
    if (r->has & LCOR_HAS_CMYK)
        put_list(out, ", \"cmyk\": ", r->cmyk, 4);
    if (r->has & LCOR_HAS_COLOUR_DENSITY)
        put_list(out, ", \"density_rgb\": ", r->density, 3);
    if (r->has & LCOR_HAS_VISUAL)
        put_number(out, ", \"density\": ", r->density[3]);
    if (r->has & LCOR_HAS_XYZ)
        put_list(out, ", \"xyz\": ", r->xyz, 3);
    buffer_text(out, r->rejected ? ", \"rejected\": true}" : ", \"rejected\": false}");
}

void export_json(const lcor_profile *profile, const lcor_profile_result *r, buffer *out)
{
    put_number(out, "{\n  \"contrast\": ", r->contrast);
    put_number(out, ",\n  \"contrast_u95\": ", r->contrast_u95);
    put_number(out, ",\n  \"d_min\": ", r->d_min);
    put_number(out, ",\n  \"d_max\": ", r->d_max);
    put_number(out, ",\n  \"u_min\": ", r->u_min);
    put_number(out, ",\n  \"u_max\": ", r->u_max);
    put_number(out, ",\n  \"n_min\": ", (double)r->n_min);
    put_number(out, ",\n  \"n_max\": ", (double)r->n_max);
    put_number(out, ",\n  \"resolution\": ", lcor_profile_resolution(profile));
    buffer_text(out, lcor_profile_black_get(profile) == LCOR_BLACK_DARKEST
                         ? ",\n  \"black\": \"darkest\",\n  \"keywords\": {"
                         : ",\n  \"black\": \"full\",\n  \"keywords\": {");
    for (size_t i = 0; i < lcor_profile_keyword_count(profile); i++) {
        const char *name = lcor_profile_keyword_name(profile, i);
        buffer_text(out, i ? ",\n    " : "\n    ");
        put_string(out, name);
        buffer_text(out, ": ");
        put_string(out, lcor_profile_keyword(profile, name));
    }
    buffer_text(out, "\n  },\n  \"readings\": [\n");
    lcor_profile_reading reading;
    for (size_t i = 0; lcor_profile_reading_get(profile, i, &reading, NULL) == LCOR_OK; i++) {
        buffer_text(out, i ? ",\n" : "");
        json_reading(out, &reading);
    }
    buffer_text(out, "\n  ]\n}\n");
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
    for (int i = 0; wanted && i < n; i++)
        put_number(out, ",", values[i]);
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
