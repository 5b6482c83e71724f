/* SPDX-License-Identifier: MIT */
#include "command/export.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

enum {
    CURVE_ENTRIES = 4096,
    LEVELS = 16385, /* luminances at which the tone curve is looked up */
    HEADER = 128,
    TAGS = 5
};

/* D50, the white of the profile connection space */
static const double d50[] = {0.9642, 1.0, 0.8249};

static void put_fixed(buffer *out, double value) /* s15Fixed16Number */
{
    buffer_u32(out, (uint32_t)floor(value * 65536.0 + 0.5));
}

static void put_xyz(buffer *out, double y)
{
    buffer_bytes(out, "XYZ \0\0\0\0", 8);
    for (int i = 0; i < 3; i++)
        put_fixed(out, d50[i] * y);
}

static void put_description(buffer *out, const char *text)
{
    const size_t n = strlen(text) + 1;
    static const char no_other_language[4 + 4 + 2 + 1 + 67] = {0};
    buffer_bytes(out, "desc\0\0\0\0", 8);
    buffer_u32(out, (uint32_t)n);
    buffer_bytes(out, text, n);
    buffer_bytes(out, no_other_language, sizeof no_other_language);
}

static void put_copyright(buffer *out)
{
    static const char text[] = "No copyright. Measured with lccal.";
    buffer_bytes(out, "text\0\0\0\0", 8);
    buffer_bytes(out, text, sizeof text);
}

/* Luminance relative to white of each device value: eq 10's range from 1/c to 1, shaped by the
 * inverse of the tone curve. */
static void put_curve(const lcor_profile *profile, double contrast, buffer *out)
{
    static float value_of[LEVELS]; /* device value that shows each of LEVELS luminances */
    if (lcor_profile_tone_curve(profile, LEVELS, value_of, NULL) != LCOR_OK)
        for (size_t i = 0; i < LEVELS; i++)
            value_of[i] = (float)((double)i / (LEVELS - 1));
    buffer_bytes(out, "curv\0\0\0\0", 8);
    buffer_u32(out, CURVE_ENTRIES);
    size_t above = 1; /* first luminance whose device value reaches v */
    for (size_t i = 0; i < CURVE_ENTRIES; i++) {
        const double v = (double)i / (CURVE_ENTRIES - 1);
        while (above < LEVELS - 1 && (double)value_of[above] < v)
            above++;
        const double low = (double)value_of[above - 1], high = (double)value_of[above];
        const double part = high > low ? (v - low) / (high - low) : 1.0;
        const double shown =
            ((double)(above - 1) + fmin(fmax(part, 0.0), 1.0)) / (double)(LEVELS - 1);
        const double y = 1.0 / contrast + (1.0 - 1.0 / contrast) * shown;
        buffer_u16(out, (uint32_t)floor(65535.0 * y + 0.5));
    }
}

static void put_header(const lcor_profile *profile, size_t size, buffer *out)
{
    static const char zeros[48] = {0};
    const double created = profile_created(profile);
    const time_t when = created >= 0.0 ? (time_t)created : time(NULL);
    const struct tm *utc = gmtime(&when);
    buffer_u32(out, (uint32_t)size);
    buffer_u32(out, 0);          /* no preferred colour management module */
    buffer_u32(out, 0x02400000); /* version 2.4 */
    buffer_text(out, profile_is_display(profile) ? "mntr" : "prtr");
    buffer_text(out, "GRAYXYZ ");
    buffer_u16(out, (uint32_t)(utc ? utc->tm_year + 1900 : 2000));
    buffer_u16(out, (uint32_t)(utc ? utc->tm_mon + 1 : 1));
    buffer_u16(out, (uint32_t)(utc ? utc->tm_mday : 1));
    buffer_u16(out, (uint32_t)(utc ? utc->tm_hour : 0));
    buffer_u16(out, (uint32_t)(utc ? utc->tm_min : 0));
    buffer_u16(out, (uint32_t)(utc ? utc->tm_sec : 0));
    buffer_text(out, "acsp");
    buffer_bytes(out, zeros, 24); /* platform, flags, manufacturer, model, attributes */
    buffer_u32(out, 1);           /* media-relative colorimetric */
    for (int i = 0; i < 3; i++)
        put_fixed(out, d50[i]);
    buffer_bytes(out, zeros, 48); /* creator, profile ID, reserved */
}

typedef struct tag {
    const char *name;
    buffer data;
} tag;

static void assemble(const lcor_profile *profile, tag *tags, buffer *out)
{
    size_t offset = HEADER + 4 + 12 * TAGS;
    for (size_t i = 0; i < TAGS; i++) {
        while (tags[i].data.size % 4 != 0)
            buffer_bytes(&tags[i].data, "", 1);
        offset += tags[i].data.size;
        out->failed = out->failed || tags[i].data.failed;
    }
    put_header(profile, offset, out);
    buffer_u32(out, TAGS);
    offset = HEADER + 4 + 12 * TAGS;
    for (size_t i = 0; i < TAGS; i++) {
        buffer_text(out, tags[i].name);
        buffer_u32(out, (uint32_t)offset);
        buffer_u32(out, (uint32_t)tags[i].data.size);
        offset += tags[i].data.size;
    }
    for (size_t i = 0; i < TAGS; i++)
        buffer_bytes(out, tags[i].data.bytes, tags[i].data.size);
}

void export_icc(const lcor_profile *profile, const lcor_profile_result *r, buffer *out)
{
    tag tags[TAGS] = {
        {.name = "desc"}, {.name = "cprt"}, {.name = "wtpt"}, {.name = "bkpt"}, {.name = "kTRC"}};
    char contrast[32], text[64];
    /* The densities of displays mean something as a difference only: their white is 1. */
    const double white = profile_is_display(profile) ? 1.0 : fmin(pow(10.0, -r->d_min), 1.0);
    lccal_format_number(contrast, sizeof contrast, r->contrast, 4);
    snprintf(text, sizeof text, "lcor device, contrast %s", contrast);
    put_description(&tags[0].data, text);
    put_copyright(&tags[1].data);
    put_xyz(&tags[2].data, white);
    put_xyz(&tags[3].data, white / r->contrast);
    put_curve(profile, r->contrast, &tags[4].data);
    assemble(profile, tags, out);
    for (size_t i = 0; i < TAGS; i++)
        buffer_free(&tags[i].data);
}
