/* SPDX-License-Identifier: MIT */
/* The lines densitometers print. Letters overlap (R is reflection for one maker and red for
 * another), so the preset says which forms to expect, and forms are tried from the narrowest to the
 * widest. Anything doubtful is no reading: the user presses again, but no density is invented. */
#include "instrument/generic-line/line.h"
#include "number.h"

#include <math.h>
#include <string.h>

enum { TEXT_MAX = 256, FEWEST_DECIMALS = 2 };

static bool is_digit(char c) { return c >= '0' && c <= '9'; }

/* Printable characters of a line without the spaces around them. NULs are padding; any other byte
 * means that the line was damaged. */
static bool clean(const uint8_t *bytes, size_t n, char *text, size_t *length)
{
    size_t used = 0;
    for (size_t i = 0; i < n; i++) {
        if (bytes[i] == '\0' || (bytes[i] == ' ' && used == 0))
            continue;
        if (bytes[i] < 0x20 || bytes[i] > 0x7E || used + 1 >= TEXT_MAX)
            return false;
        text[used++] = (char)bytes[i];
    }
    while (used > 0 && text[used - 1] == ' ')
        used--;
    text[used] = '\0';
    *length = used;
    return used > 0;
}

/* The number at text, as the format writes numbers. Returns its length, 0 for none. `step` gets the
 * value of its last digit. */
static size_t number_at(const line_format *format, const char *text, double *value, double *step)
{
    size_t i = text[0] == '-' || text[0] == '+';
    size_t whole = 0, decimals = 0;
    while (is_digit(text[i + whole]))
        whole++;
    size_t length = i + whole;
    if (text[length] == '.' && is_digit(text[length + 1])) {
        while (is_digit(text[length + 1 + decimals]))
            decimals++;
        length += 1 + decimals;
    }
    if (!lccal_parse_number(text, length, value))
        return 0;
    *step = pow(10.0, -(double)decimals);
    if (decimals > 0)
        return format->decimals != DECIMALS_IMPLIED && decimals >= FEWEST_DECIMALS && whole > 0
                   ? length
                   : 0;
    if (format->decimals == DECIMALS_WRITTEN || whole != 3)
        return 0;
    *value /= 100.0; /* 137: the point after the first digit is implied */
    *step = 0.01;
    return length;
}

/* What a form makes of a line. A form that knows the line and refuses it keeps the wider forms
 * after it from taking a number out of it that is no density. */
typedef enum match { MATCH_NONE, MATCH_REFUSED, MATCH_READING } match;

/* T+1.53D, R-0.05D, T+.278D; Z (zone) and % (dot area) are no densities, 0+....D is stand-by. */
static match parse_signed(const line_format *format, const char *text, size_t n, reading *out)
{
    if (n != 7 || !strchr("RT0", text[0]) || (text[1] != '+' && text[1] != '-') ||
        strspn(text + 2, "0123456789.") != 4 || !strchr("DZ%", text[6]))
        return MATCH_NONE;
    const char *point = memchr(text + 2, '.', 4);
    if (text[0] == '0' || text[6] != 'D' || !point || !lccal_parse_number(text + 1, 5, &out->value))
        return MATCH_REFUSED;
    out->step = pow(10.0, -(double)(text + 5 - point));
    out->kind = text[0] == 'R' ? READING_REFLECTION : READING_TRANSMISSION;
    return format->mode == 0 || format->mode == text[0] ? MATCH_READING : MATCH_REFUSED;
}

/* DenAA +1.47, 0.00, 0.00, 0.00, 0.00: filter A (white), B red, C green, D blue; then A absolute or
 * R relative, where the first number is the difference to a reference and no density. */
static match parse_tobias(const line_format *format, const char *text, reading *out)
{
    if (strncmp(text, "Den", 3) != 0 || !text[3] || !strchr("ABCD", text[3]) || !text[4] ||
        !strchr("AR", text[4]))
        return MATCH_NONE;
    const char *at = text + 5 + strspn(text + 5, " ");
    const size_t n = number_at(format, at, &out->value, &out->step);
    const bool whole = n > 0 && (at[n] == ',' || at[n] == '\0');
    return whole && text[3] == 'A' && text[4] == 'A' ? MATCH_READING : MATCH_REFUSED;
}

/* One of the values of a line of fields. */
static bool take_field(const line_format *format, char letter, double value, double step,
                       bool seen[4], reading *out)
{
    static const char filters[3][3] = {"CR", "MG", "YB"}; /* C and R both name the red filter */
    if (strchr(format->visual, letter)) {
        if (seen[3])
            return false;
        seen[3] = true;
        out->value = value;
        out->step = step;
        if (letter >= 'a') /* Advanced Technet: a small letter is transmission */
            out->kind = READING_TRANSMISSION;
        return true;
    }
    char capital = letter;
    if (letter >= 'a')
        capital = (char)(letter - 'a' + 'A');
    for (int i = 0; i < 3; i++) {
        if (strchr(filters[i], capital)) {
            seen[i] = true;
            out->density[i] = value;
        }
    }
    return true;
}

/* V1.37 C0.05 M0.06 Y0.07: letter, density, separators. */
static match parse_fields(const line_format *format, const char *text, reading *out)
{
    bool seen[4] = {false, false, false, false};
    while (*text) {
        double value, step;
        const char letter = *text;
        if (!strchr("VRGBCMYKPvrgbcmyp", letter))
            return MATCH_NONE;
        text += text[1] == ' ' ? 2 : 1;
        const size_t n = number_at(format, text, &value, &step);
        if (n == 0 || (text[n] && text[n] != ' ' && text[n] != ','))
            return MATCH_NONE;
        if (!take_field(format, letter, value, step, seen, out))
            return MATCH_REFUSED;
        text += n;
        text += strspn(text, " ,");
    }
    out->has_colour = seen[0] && seen[1] && seen[2];
    return seen[3] ? MATCH_READING : MATCH_REFUSED;
}

static match parse_plain(const line_format *format, const char *text, reading *out)
{
    const size_t n = number_at(format, text, &out->value, &out->step);
    return n > 0 && text[n] == '\0' ? MATCH_READING : MATCH_NONE;
}

/* The first number of a line nobody knows. Lines of a Printalyzer that are no readings must not
 * pass for one: replies start with two capitals and a space, log lines with a letter and a slash.
 */
static match parse_any(const line_format *format, const char *text, reading *out)
{
    if ((strchr("SGI", text[0]) && text[1] && strchr("SMCD", text[1]) && text[2] == ' ') ||
        (strchr("AEWIDV", text[0]) && text[1] == '/'))
        return MATCH_REFUSED;
    const char *at = text;
    while (*at && !is_digit(*at))
        at++;
    if (at > text && at[-1] == '.')
        return MATCH_REFUSED;
    if (at > text && (at[-1] == '-' || at[-1] == '+'))
        at--;
    const size_t n = number_at(format, at, &out->value, &out->step);
    return n > 0 && at[n] != '.' && !is_digit(at[n]) && at[n] != '%' ? MATCH_READING
                                                                     : MATCH_REFUSED;
}

static match parse_text(const line_format *format, const char *text, size_t n, reading *out)
{
    match m = MATCH_NONE;
    if (format->forms & FORM_SIGNED)
        m = parse_signed(format, text, n, out);
    if (m == MATCH_NONE && (format->forms & FORM_TOBIAS))
        m = parse_tobias(format, text, out);
    if (m == MATCH_NONE && (format->forms & FORM_FIELDS))
        m = parse_fields(format, text, out);
    if (m == MATCH_NONE && (format->forms & FORM_NUMBER))
        m = parse_plain(format, text, out);
    if (m == MATCH_NONE && (format->forms & FORM_ANY))
        m = parse_any(format, text, out);
    return m;
}

parse_result line_parse(const line_format *format, const uint8_t *bytes, size_t n, size_t *used,
                        reading *out)
{
    size_t start, length;
    char text[TEXT_MAX] = "";
    const parse_result line = line_split(bytes, n, &start, &length, used);
    if (line != PARSE_OK)
        return line;
    memset(out, 0, sizeof *out);
    if (!clean(bytes + start, length, text, &length))
        return PARSE_BAD;
    out->kind = format->mode == 'T' ? READING_TRANSMISSION : READING_REFLECTION;
    if (parse_text(format, text, length, out) != MATCH_READING)
        return PARSE_BAD;
    out->value *= format->scale;
    out->step *= format->scale;
    for (int i = 0; i < 3; i++)
        out->density[i] *= format->scale;
    return out->value >= format->lowest && out->value <= format->highest ? PARSE_OK : PARSE_BAD;
}
