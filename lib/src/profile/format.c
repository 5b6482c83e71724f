/* SPDX-License-Identifier: MIT */
/* Profile -> CGATS.17 text. */
#include "profile/internal.h"

#include "base/internal.h"
#include "profile/number.h"

#include <string.h>

#define DERIVED_DIGITS 6 /* more than any densitometer is worth */

typedef struct writer {
    char *buffer;
    size_t capacity, size; /* size counts on past capacity */
} writer;

static void put(writer *w, const char *text)
{
    for (; *text; text++, w->size++)
        if (w->size + 1 < w->capacity)
            w->buffer[w->size] = *text;
}

static void put_digits(writer *w, double value, int digits)
{
    char text[LCOR_NUMBER_SIZE];
    lcor_internal_number_format(value, digits, text);
    put(w, text);
}

static void put_number(writer *w, double value) { put_digits(w, value, LCOR_NUMBER_DIGITS); }

static void put_own(writer *w, const char *name, double value, int digits)
{
    put(w, "KEYWORD \"");
    put(w, name);
    put(w, "\"\n");
    put(w, name);
    put(w, " \"");
    put_digits(w, value, digits);
    put(w, "\"\n");
}

/* Keywords CGATS.17 knows; others are declared by a KEYWORD line. */
static int is_standard(const char *name)
{
    static const char *const standard[] = {
        "ORIGINATOR",      "FILE_DESCRIPTOR",        "DESCRIPTOR",         "CREATED",
        "INSTRUMENTATION", "MANUFACTURER",           "PROD_DATE",          "SERIAL",
        "MATERIAL",        "SAMPLE_BACKING",         "MEASUREMENT_SOURCE", "PRINT_CONDITIONS",
        "CHISQ_DOF",       "COMPUTATIONAL_PARAMETER"};
    for (size_t i = 0; i < sizeof standard / sizeof standard[0]; i++)
        if (strcmp(name, standard[i]) == 0)
            return 1;
    return 0;
}

static void put_header(writer *w, const lcor_profile *p, const lcor_profile_result *result)
{
    put(w, "CGATS.17\n\n");
    for (size_t i = 0; i < p->keyword_count; i++) {
        const profile_keyword *k = &p->keywords[i];
        if (!is_standard(k->name)) {
            put(w, "KEYWORD \"");
            put(w, k->name);
            put(w, "\"\n");
        }
        put(w, k->name);
        put(w, " \"");
        put(w, k->value);
        put(w, "\"\n");
    }
    put_own(w, "LCOR_PROFILE_VERSION", LCOR_PROFILE_FORMAT_VERSION, 1);
    put(w, "KEYWORD \"LCOR_BLACK\"\nLCOR_BLACK \"");
    put(w, p->black == LCOR_BLACK_DARKEST ? "DARKEST\"\n" : "FULL\"\n");
    put_own(w, "LCOR_RESOLUTION", p->resolution, LCOR_NUMBER_DIGITS);
    put_own(w, "LCOR_CONTRAST", result->contrast, DERIVED_DIGITS);
    put_own(w, "LCOR_CONTRAST_U95", result->contrast_u95, DERIVED_DIGITS);
}

static void put_columns(writer *w, unsigned has)
{
    static const struct {
        unsigned flag;
        const char *names;
        double fields;
    } groups[] = {{LCOR_HAS_RGB, " RGB_R RGB_G RGB_B", 3},
                  {LCOR_HAS_CMYK, " CMYK_C CMYK_M CMYK_Y CMYK_K", 4},
                  {LCOR_HAS_COLOUR_DENSITY, " D_RED D_GREEN D_BLUE", 3},
                  {LCOR_HAS_VISUAL, " D_VIS", 1},
                  {LCOR_HAS_XYZ, " XYZ_X XYZ_Y XYZ_Z", 3}};
    double fields = 3;
    for (size_t i = 0; i < sizeof groups / sizeof groups[0]; i++)
        fields += has & groups[i].flag ? groups[i].fields : 0;
    put(w, "\nKEYWORD \"LCOR_REJECTED\"\nNUMBER_OF_FIELDS ");
    put_number(w, fields);
    put(w, "\nBEGIN_DATA_FORMAT\nSAMPLE_ID SAMPLE_NAME");
    for (size_t i = 0; i < sizeof groups / sizeof groups[0]; i++)
        if (has & groups[i].flag)
            put(w, groups[i].names);
    put(w, " LCOR_REJECTED\nEND_DATA_FORMAT\n");
}

static void put_numbers(writer *w, const double *values, int n)
{
    for (int i = 0; i < n; i++) {
        put(w, "\t");
        put_number(w, values[i]);
    }
}

static void put_reading(writer *w, const lcor_profile_reading *r)
{
    put(w, "\"");
    put(w, r->id);
    put(w, "\"\t\"");
    put(w, r->name);
    put(w, "\"");
    if (r->has & LCOR_HAS_RGB)
        put_numbers(w, r->rgb, 3);
    if (r->has & LCOR_HAS_CMYK)
        put_numbers(w, r->cmyk, 4);
    if (r->has & LCOR_HAS_COLOUR_DENSITY)
        put_numbers(w, r->density, 3);
    if (r->has & LCOR_HAS_VISUAL)
        put_numbers(w, r->density + 3, 1);
    if (r->has & LCOR_HAS_XYZ)
        put_numbers(w, r->xyz, 3);
    put(w, r->rejected ? "\t1\n" : "\t0\n");
}

lcor_status lcor_profile_format(const lcor_profile *profile, char *buffer, size_t capacity,
                                size_t *size, lcor_error *err)
{
    if (!profile || (!buffer && capacity > 0))
        return lcor_internal_fail(err, LCOR_ERR_ARG, -1, "profile or buffer is NULL");
    lcor_profile_result result;
    const lcor_status status = lcor_profile_evaluate(profile, &result, err);
    if (status != LCOR_OK)
        return status;
    writer w = {.buffer = buffer, .capacity = capacity};
    put_header(&w, profile, &result);
    put_columns(&w, profile->readings[0].has);
    put(&w, "NUMBER_OF_SETS ");
    put_number(&w, (double)profile->count);
    put(&w, "\nBEGIN_DATA\n");
    for (size_t i = 0; i < profile->count; i++)
        put_reading(&w, &profile->readings[i]);
    put(&w, "END_DATA\n");
    if (capacity > 0)
        buffer[w.size < capacity ? w.size : capacity - 1] = '\0';
    if (size)
        *size = w.size;
    return LCOR_OK;
}
