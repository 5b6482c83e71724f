/* SPDX-License-Identifier: MIT */
/* The header of a CGATS.17 text: keywords and the data format. */
#include "profile/reader.h"

#include "base/internal.h"
#include "profile/number.h"

#include <string.h>

const char *const lcor_internal_columns[COLUMNS] = {
    "RGB_R", "RGB_G", "RGB_B", "CMYK_C",        "CMYK_M",    "CMYK_Y",     "CMYK_K",
    "XYZ_X", "XYZ_Y", "XYZ_Z", "D_RED",         "D_GREEN",   "D_BLUE",     "D_VIS",
    "LAB_L", "LAB_A", "LAB_B", "LCOR_REJECTED", "SAMPLE_ID", "SAMPLE_NAME"};

/* Columns that come together or not at all, and what they make of a reading. */
static const struct {
    int first, count;
    unsigned has;
} groups[] = {{RGB_R, 3, LCOR_HAS_RGB},
              {CMYK_C, 4, LCOR_HAS_CMYK},
              {XYZ_X, 3, LCOR_HAS_XYZ},
              {D_RED, 3, LCOR_HAS_COLOUR_DENSITY},
              {D_VIS, 1, LCOR_HAS_VISUAL}};

lcor_status lcor_internal_bad(const reader *r, const char *what)
{
    return lcor_internal_fail(r->err, LCOR_ERR_FORMAT, r->text.line, "line %ld: %s", r->text.line,
                              what);
}

lcor_status lcor_internal_bad_word(const reader *r, cgats_word word, const char *what)
{
    return lcor_internal_fail(r->err, LCOR_ERR_FORMAT, r->text.line, "line %ld: '%.*s' %s",
                              r->text.line, (int)(word.n < 40 ? word.n : 40), word.text, what);
}

lcor_status lcor_internal_bad_bytes(const reader *r)
{
    return lcor_internal_bad(
        r, "a quote without its end, or a NUL byte; is the file text in ASCII or UTF-8?");
}

/* The value of a header line: the quoted word, or all that is left. */
static lcor_status header_value(reader *r, cgats_word *value)
{
    cgats_text at = r->text;
    cgats_word word = {.text = r->text.at};
    const cgats_next next = lcor_internal_cgats_next(&at, &word);
    if (next == CGATS_BAD)
        return lcor_internal_bad_bytes(r);
    if (next == CGATS_WORD && word.quoted) {
        r->text = at;
        *value = word;
    } else {
        *value = lcor_internal_cgats_rest(&r->text);
    }
    return LCOR_OK;
}

static lcor_status header_number(reader *r, double *number)
{
    cgats_word value = {0};
    const lcor_status status = header_value(r, &value);
    if (status != LCOR_OK)
        return status;
    size_t n = 0; /* what follows the number is a remark */
    while (n < value.n && value.text[n] != ' ' && value.text[n] != '\t')
        n++;
    if (!lcor_internal_number_parse(value.text, n, number, NULL) || *number < 0.0)
        return lcor_internal_bad_word(r, value, "is not the number this keyword needs");
    return LCOR_OK;
}

static lcor_status own_keyword(reader *r, cgats_word name)
{
    double version = 0.0;
    if (lcor_internal_cgats_is(name, "LCOR_CONTRAST"))
        return header_number(r, &r->contrast);
    if (lcor_internal_cgats_is(name, "LCOR_CONTRAST_U95"))
        return header_number(r, &r->contrast_u95);
    if (lcor_internal_cgats_is(name, "LCOR_RESOLUTION"))
        return header_number(r, &r->resolution);
    if (lcor_internal_cgats_is(name, "LCOR_BLACK")) {
        cgats_word value = {0};
        const lcor_status status = header_value(r, &value);
        if (status != LCOR_OK)
            return status;
        value.quoted = 0;
        const int is_darkest = lcor_internal_cgats_is(value, "DARKEST");
        if (!is_darkest && !lcor_internal_cgats_is(value, "FULL"))
            return lcor_internal_bad_word(r, value, "is neither FULL nor DARKEST");
        r->profile->black = is_darkest ? LCOR_BLACK_DARKEST : LCOR_BLACK_FULL;
        return LCOR_OK;
    }
    if (!lcor_internal_cgats_is(name, "LCOR_PROFILE_VERSION"))
        return LCOR_OK;
    r->own = 1;
    const lcor_status status = header_number(r, &version);
    if (status == LCOR_OK && version != (double)LCOR_PROFILE_FORMAT_VERSION)
        return lcor_internal_bad(
            r, "this profile was written by another version of lcor; this one reads "
               "LCOR_PROFILE_VERSION 1");
    return status;
}

/* Keep a keyword of the text as provenance, if it is one. */
static lcor_status keep_keyword(reader *r, cgats_word name)
{
    cgats_word value = {0};
    const lcor_status status = header_value(r, &value);
    if (status != LCOR_OK)
        return status;
    if (value.n == 0 || !lcor_internal_keyword_name_ok(name.text, name.n))
        return LCOR_OK; /* such as the first line, CGATS.17 */
    if (r->profile->keyword_count == LCOR_PROFILE_MAX_KEYWORDS)
        return lcor_internal_bad(r, "too many keywords");
    return lcor_internal_profile_keep(r->profile, name.text, name.n, value.text, value.n, r->err);
}

static lcor_status add_column(reader *r, cgats_word word)
{
    r->fields++;
    for (int i = 0; i < COLUMNS; i++) {
        if (!lcor_internal_cgats_is(word, lcor_internal_columns[i]))
            continue;
        if (r->field[i])
            return lcor_internal_bad_word(r, word, "stands twice in the data format");
        r->field[i] = r->fields;
    }
    return LCOR_OK;
}

/* Names up to END_DATA_FORMAT; where that is missing, up to a line that cannot be one of names. */
static lcor_status read_format(reader *r)
{
    if (r->fields > 0)
        return lcor_internal_bad(r, "a second BEGIN_DATA_FORMAT");
    cgats_text line_start = r->text;
    for (;;) {
        cgats_word word;
        switch (lcor_internal_cgats_next(&r->text, &word)) {
        case CGATS_BAD: return lcor_internal_bad_bytes(r);
        case CGATS_END: return lcor_internal_bad(r, "the text ends inside its data format");
        case CGATS_LINE_END: line_start = r->text; break;
        case CGATS_WORD:
            if (lcor_internal_cgats_is(word, "END_DATA_FORMAT"))
                return LCOR_OK;
            if (word.quoted || lcor_internal_cgats_is(word, "BEGIN_DATA") ||
                lcor_internal_cgats_is(word, "NUMBER_OF_SETS") ||
                lcor_internal_cgats_is(word, "KEYWORD")) {
                r->text = line_start;
                return LCOR_OK;
            }
            const lcor_status status = add_column(r, word);
            if (status != LCOR_OK)
                return status;
        }
    }
}

/* Step over the rest of the line. */
static void skip_line(reader *r)
{
    (void)lcor_internal_cgats_rest(&r->text);
    while (r->text.at < r->text.end && *r->text.at != '\n' && *r->text.at != '\r')
        r->text.at++;
}

static lcor_status header_line(reader *r, cgats_word name)
{
    double ignored;
    lcor_status status = LCOR_OK;
    if (lcor_internal_cgats_is(name, "NUMBER_OF_SETS"))
        status = header_number(r, &r->declared_sets);
    else if (lcor_internal_cgats_is(name, "NUMBER_OF_FIELDS"))
        status = header_number(r, &ignored); /* the names and the rows must agree instead */
    else if (name.n > 5 && !name.quoted && memcmp(name.text, "LCOR_", 5) == 0)
        status = own_keyword(r, name);
    else if (!lcor_internal_cgats_is(name, "KEYWORD") && !name.quoted)
        status = keep_keyword(r, name);
    skip_line(r);
    return status;
}

/* How many of the columns first..first+count-1 there are. */
static int columns_there(const reader *r, int first, int count)
{
    int found = 0;
    for (int i = first; i < first + count; i++)
        found += r->field[i] != 0;
    return found;
}

static lcor_status check_columns(reader *r)
{
    if (r->fields == 0)
        return lcor_internal_bad(r, "BEGIN_DATA without a data format before it");
    for (size_t g = 0; g < sizeof groups / sizeof groups[0]; g++) {
        const int found = columns_there(r, groups[g].first, groups[g].count);
        if (found == groups[g].count)
            r->has |= groups[g].has;
        else if (found > 0)
            return lcor_internal_fail(r->err, LCOR_ERR_FORMAT, r->text.line,
                                      "line %ld: of the columns %s to %s some are missing",
                                      r->text.line, lcor_internal_columns[groups[g].first],
                                      lcor_internal_columns[groups[g].first + groups[g].count - 1]);
    }
    if (!(r->has & (LCOR_HAS_RGB | LCOR_HAS_CMYK)))
        return lcor_internal_bad(
            r, "no columns RGB_R RGB_G RGB_B or CMYK_C CMYK_M CMYK_Y CMYK_K: which patch is "
               "black cannot be told");
    if (r->has & (LCOR_HAS_VISUAL | LCOR_HAS_XYZ))
        return LCOR_OK;
    if (columns_there(r, LAB_L, 3) != 3)
        return lcor_internal_bad(
            r, "no column D_VIS, no XYZ_X XYZ_Y XYZ_Z and no LAB_L LAB_A LAB_B: export the "
               "measurements with one of them");
    r->has |= LCOR_HAS_XYZ;
    r->from_lab = 1;
    return LCOR_OK;
}

lcor_status lcor_internal_read_header(reader *r)
{
    for (;;) {
        cgats_word word;
        lcor_status status = LCOR_OK;
        switch (lcor_internal_cgats_next(&r->text, &word)) {
        case CGATS_BAD: return lcor_internal_bad_bytes(r);
        case CGATS_END:
            return lcor_internal_bad(r,
                                     "no BEGIN_DATA: this is not CGATS text, or it is cut short");
        case CGATS_LINE_END: break;
        case CGATS_WORD:
            if (lcor_internal_cgats_is(word, "BEGIN_DATA"))
                return check_columns(r);
            status = lcor_internal_cgats_is(word, "BEGIN_DATA_FORMAT") ? read_format(r)
                                                                       : header_line(r, word);
        }
        if (status != LCOR_OK)
            return status;
    }
}
