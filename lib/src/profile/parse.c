/* SPDX-License-Identifier: MIT */
/* CGATS.17 text -> profile. Two passes over the rows: the first finds the scales the columns are in
 * and every mistake, the second takes the readings. */
#include "profile/reader.h"

#include "base/internal.h"
#include "profile/number.h"

#include <math.h>
#include <string.h>

static lcor_status read_field(reader *r, size_t place, cgats_word word, data_row *out)
{
    for (int i = 0; i < COLUMNS; i++) {
        if (r->field[i] != place)
            continue;
        if (i == ID) {
            out->id = word;
        } else if (i == NAME) {
            out->name = word;
        } else {
            int decimals = 0;
            if (memchr(word.text, ',', word.n))
                return lcor_internal_bad_word(r, word, "has a comma: numbers need a decimal point");
            if (!lcor_internal_number_parse(word.text, word.n, &out->value[i], &decimals))
                return lcor_internal_bad_word(r, word, "is not a number");
            if (decimals > r->decimals[i])
                r->decimals[i] = decimals;
            if (out->value[i] > r->largest[i])
                r->largest[i] = out->value[i];
        }
    }
    return LCOR_OK;
}

/* The next row; *more becomes 0 at END_DATA. */
static lcor_status read_row(reader *r, data_row *out, int *more)
{
    size_t place = 0;
    *out = (data_row){.line = r->text.line};
    for (;;) {
        cgats_word word;
        lcor_status status = LCOR_OK;
        switch (lcor_internal_cgats_next(&r->text, &word)) {
        case CGATS_BAD: return lcor_internal_bad_bytes(r);
        case CGATS_END: return lcor_internal_bad(r, "no END_DATA: the text is cut short");
        case CGATS_LINE_END:
            if (place == r->fields)
                return LCOR_OK;
            if (place > 0)
                return lcor_internal_fail(r->err, LCOR_ERR_FORMAT, out->line,
                                          "line %ld: %lu fields, the data format has %lu",
                                          out->line, (unsigned long)place,
                                          (unsigned long)r->fields);
            out->line = r->text.line;
            break;
        case CGATS_WORD:
            if (place == 0 && lcor_internal_cgats_is(word, "END_DATA")) {
                *more = 0;
                return LCOR_OK;
            }
            if (++place > r->fields)
                return lcor_internal_fail(r->err, LCOR_ERR_FORMAT, r->text.line,
                                          "line %ld: more fields than the data format's %lu",
                                          r->text.line, (unsigned long)r->fields);
            status = read_field(r, place, word, out);
        }
        if (status != LCOR_OK)
            return status;
    }
}

static lcor_status check_row(reader *r, const data_row *row)
{
    for (int i = D_RED; i <= D_VIS; i++)
        if (r->field[i] && !(row->value[i] >= -1.0 && row->value[i] <= 8.0))
            return lcor_internal_fail(r->err, LCOR_ERR_FORMAT, row->line,
                                      "line %ld: the value of %s is no density (-1 to 8); are the "
                                      "columns labelled rightly?",
                                      row->line, lcor_internal_columns[i]);
    for (int i = RGB_R; i <= CMYK_K; i++)
        if (r->field[i] && !(row->value[i] >= 0.0))
            return lcor_internal_fail(r->err, LCOR_ERR_FORMAT, row->line,
                                      "line %ld: the value of %s is negative", row->line,
                                      lcor_internal_columns[i]);
    if (r->from_lab && !(row->value[LAB_L] > 0.0 && row->value[LAB_L] <= 110.0))
        return lcor_internal_fail(r->err, LCOR_ERR_FORMAT, row->line,
                                  "line %ld: the value of LAB_L is no lightness (0 to 100)",
                                  row->line);
    if (r->field[XYZ_Y] && !(row->value[XYZ_Y] > 0.0 && row->value[XYZ_Y] < 1e9))
        return lcor_internal_fail(r->err, LCOR_ERR_FORMAT, row->line,
                                  "line %ld: the value of XYZ_Y is not greater than 0; are the "
                                  "columns labelled rightly?",
                                  row->line);
    return LCOR_OK;
}

/* First pass: every row is read and checked. */
static lcor_status survey_rows(reader *r)
{
    for (int more = 1; more;) {
        data_row row;
        lcor_status status = read_row(r, &row, &more);
        if (status == LCOR_OK && more) {
            status = check_row(r, &row);
            r->sets++;
        }
        if (status != LCOR_OK)
            return status;
    }
    if (r->sets == 0)
        return lcor_internal_bad(r, "the text holds no readings");
    if (r->own && r->declared_sets >= 0.0 && r->declared_sets != (double)r->sets)
        return lcor_internal_bad(
            r, "the number of readings is not what NUMBER_OF_SETS says: the profile was cut "
               "or edited");
    return LCOR_OK;
}

/* What full drive is called in columns first..first+count-1: the largest value must be one of the
 * customary ones. */
static double full_scale(const reader *r, int first, int count, const double *known, size_t n)
{
    double largest = 0.0;
    for (int i = 0; i < count; i++)
        largest = r->largest[first + i] > largest ? r->largest[first + i] : largest;
    for (size_t i = 0; i < n; i++)
        if (fabs(largest - known[i]) <= 2e-5 * known[i])
            return known[i];
    return 0.0;
}

static lcor_status find_scales(reader *r)
{
    static const double rgb[] = {255.0, 100.0, 1.0, 65535.0, 1023.0, 4095.0};
    static const double cmyk[] = {100.0, 255.0, 1.0};
    double full_rgb = 255.0, full_cmyk = 100.0, xyz = 1.0;
    if (!r->own && (r->has & LCOR_HAS_RGB))
        full_rgb = full_scale(r, RGB_R, 3, rgb, sizeof rgb / sizeof rgb[0]);
    if (!r->own && (r->has & LCOR_HAS_CMYK))
        full_cmyk = full_scale(r, CMYK_C, 4, cmyk, sizeof cmyk / sizeof cmyk[0]);
    if (full_rgb == 0.0)
        return lcor_internal_bad(r, "the largest RGB value is none of 255, 100, 1, 65535: no white "
                                    "patch, or an unknown scale");
    if (full_cmyk == 0.0)
        return lcor_internal_bad(r,
                                 "the largest CMYK value is none of 100, 255, 1: no solid patch, "
                                 "or an unknown scale");
    const char *class = lcor_profile_keyword(r->profile, "DEVICE_CLASS");
    if (!r->own && r->largest[XYZ_Y] <= 1.5 && !(class && strcmp(class, "DISPLAY") == 0))
        xyz = 100.0; /* Y of print in 0..1 */
    for (int i = 0; i < NUMBERS; i++)
        r->scale[i] = i <= RGB_B    ? 255.0 / full_rgb
                      : i <= CMYK_K ? 100.0 / full_cmyk
                      : i <= XYZ_Z  ? xyz
                                    : 1.0;
    return LCOR_OK;
}

/* XYZ of D50 in percent from L*a*b* (CIE 15). */
static void xyz_from_lab(const double *lab, double *xyz)
{
    static const double white[] = {96.42, 100.0, 82.49};
    const double fy = (lab[0] + 16.0) / 116.0;
    const double f[] = {fy + lab[1] / 500.0, fy, fy - lab[2] / 200.0};
    for (int i = 0; i < 3; i++)
        xyz[i] = white[i] *
                 (f[i] > 6.0 / 29.0 ? f[i] * f[i] * f[i] : (f[i] - 4.0 / 29.0) * 108.0 / 841.0);
}

/* Where a text gives both Y and L*, a column with a wrong label shows. */
static lcor_status check_lightness(reader *r, const data_row *row, const lcor_profile_reading *p)
{
    double xyz[3];
    xyz_from_lab(row->value + LAB_L, xyz);
    if (!r->field[LAB_L] || !(p->has & LCOR_HAS_XYZ) ||
        !(lcor_internal_is_white(p) || lcor_internal_is_full_black(p)) ||
        fabs(p->xyz[1] - xyz[1]) <= 0.01 * xyz[1] + 0.2)
        return LCOR_OK;
    return lcor_internal_fail(r->err, LCOR_ERR_FORMAT, row->line,
                              "line %ld: XYZ_Y and LAB_L contradict each other; are the columns "
                              "labelled rightly?",
                              row->line);
}

static lcor_status take_row(reader *r, const data_row *row)
{
    lcor_profile_reading reading = {.has = r->has, .rejected = row->value[REJECTED] != 0.0};
    double v[NUMBERS];
    for (int i = 0; i < NUMBERS; i++) {
        v[i] = row->value[i] * r->scale[i];
        if (i <= RGB_B && v[i] > 255.0)
            v[i] = 255.0; /* within the tolerance of full_scale */
        if (i >= CMYK_C && i <= CMYK_K && v[i] > 100.0)
            v[i] = 100.0;
    }
    memcpy(reading.rgb, v + RGB_R, sizeof reading.rgb);
    memcpy(reading.cmyk, v + CMYK_C, sizeof reading.cmyk);
    memcpy(reading.xyz, v + XYZ_X, sizeof reading.xyz);
    memcpy(reading.density, v + D_RED, sizeof reading.density);
    if (r->from_lab)
        xyz_from_lab(row->value + LAB_L, reading.xyz);
    const lcor_status status = check_lightness(r, row, &reading);
    if (status != LCOR_OK)
        return status;
    return lcor_internal_profile_add(r->profile, &reading, row->id.text, row->id.n, row->name.text,
                                     row->name.n, r->err);
}

/* Second pass over the rows behind `start`. */
static lcor_status take_rows(reader *r, cgats_text start)
{
    r->text = start;
    for (int more = 1; more;) {
        data_row row;
        lcor_status status = read_row(r, &row, &more);
        if (status == LCOR_OK && more)
            status = take_row(r, &row);
        if (status != LCOR_OK)
            return status;
    }
    return LCOR_OK;
}

/* The step that the digits of the text show, in density or Y; of L* as Y of the darkest patch,
 * which is what decides the contrast. */
static double shown_step(const reader *r)
{
    const int column = r->has & LCOR_HAS_VISUAL ? D_VIS : r->from_lab ? LAB_L : XYZ_Y;
    double step = r->scale[column];
    for (int i = 0; i < r->decimals[column] && i < 9; i++)
        step /= 10.0;
    if (!r->from_lab)
        return step;
    double darkest = 100.0;
    for (size_t i = 0; i < r->profile->count; i++)
        darkest = fmin(darkest, r->profile->readings[i].xyz[1]);
    const double f = cbrt(darkest / 100.0);
    return step * 300.0 / 116.0 * f * f;
}

static lcor_status finish(reader *r)
{
    const double step = r->resolution >= 0.0 ? r->resolution : r->own ? 0.0 : shown_step(r);
    lcor_status status = lcor_profile_resolution_set(r->profile, step, r->err);
    if (status == LCOR_OK)
        status = r->own ? LCOR_OK : lcor_internal_check_plausible(r);
    return status == LCOR_OK ? lcor_internal_check_contrast(r) : status;
}

static lcor_status read_text(reader *r)
{
    lcor_status status = lcor_internal_read_header(r);
    const cgats_text rows = r->text;
    if (status == LCOR_OK)
        status = survey_rows(r);
    if (status == LCOR_OK)
        status = find_scales(r);
    if (status == LCOR_OK)
        status = take_rows(r, rows);
    return status == LCOR_OK ? finish(r) : status;
}

lcor_status lcor_profile_import(const char *text, size_t size, lcor_profile_black black,
                                const lcor_allocator *allocator, lcor_profile **out,
                                lcor_error *err)
{
    if (!text || !out || (black != LCOR_BLACK_FULL && black != LCOR_BLACK_DARKEST))
        return lcor_internal_fail(err, LCOR_ERR_ARG, -1,
                                  "no text, no place for the profile, or no "
                                  "such choice of black");
    if (size >= 2 && (memcmp(text, "\xFF\xFE", 2) == 0 || memcmp(text, "\xFE\xFF", 2) == 0))
        return lcor_internal_fail(err, LCOR_ERR_FORMAT, 1,
                                  "line 1: the text is UTF-16; save it as UTF-8 or ASCII");
    lcor_profile *profile;
    lcor_status status = lcor_profile_new(allocator, &profile, err);
    if (status != LCOR_OK)
        return status;
    profile->black = black;
    reader r = {.text = lcor_internal_cgats_open(text, size),
                .profile = profile,
                .err = err,
                .declared_sets = -1.0,
                .contrast = -1.0,
                .contrast_u95 = -1.0,
                .resolution = -1.0};
    status = read_text(&r);
    if (status != LCOR_OK)
        lcor_profile_free(profile);
    else
        *out = profile;
    return status;
}

lcor_status lcor_profile_parse(const char *text, size_t size, const lcor_allocator *allocator,
                               lcor_profile **out, lcor_error *err)
{
    return lcor_profile_import(text, size, LCOR_BLACK_FULL, allocator, out, err);
}
