/* SPDX-License-Identifier: MIT */
#include "profile/number.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

#define EXPONENT_CAP 400 /* beyond this a double is infinite or 0 in any case */

/* x * 10^e. Powers up to 22 are exact in a double, so one division or multiplication rounds once.
 */
static double scale10(double x, int e)
{
    static const double exact[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                   1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                   1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
    for (; e > 22; e -= 22)
        x *= exact[22];
    for (; e < -22; e += 22)
        x /= exact[22];
    return e < 0 ? x / exact[-e] : x * exact[e];
}

static int is_digit(char c) { return c >= '0' && c <= '9'; }

/* [+-] digits at *text; advances it. Returns 0 without a digit. */
static int parse_exponent(const char **text, const char *end, int *exponent)
{
    const char *p = *text;
    const int negative = p < end && *p == '-';
    if (p < end && (*p == '-' || *p == '+'))
        p++;
    if (p == end || !is_digit(*p))
        return 0;
    int e = 0;
    for (; p < end && is_digit(*p); p++)
        if (e < 10 * EXPONENT_CAP)
            e = 10 * e + (*p - '0');
    *text = p;
    *exponent = negative ? -e : e;
    return 1;
}

int lcor_internal_number_parse(const char *text, size_t n, double *value, int *decimals)
{
    const char *p = text, *const end = text + n;
    const int negative = p < end && *p == '-';
    if (p < end && (*p == '-' || *p == '+'))
        p++;
    uint64_t mantissa = 0;
    int places = 0, dropped = 0, seen = 0, point = 0;
    for (; p < end && (is_digit(*p) || (*p == '.' && !point)); p++) {
        if (*p == '.') {
            point = 1;
            continue;
        }
        seen = 1;
        /* Leading zeros are free; the 18 digits that follow fit 64 bits; later ones are beyond a
         * double and only move the point. */
        if (mantissa < UINT64_C(100000000000000000)) {
            mantissa = 10 * mantissa + (uint64_t)(*p - '0');
            places += point && places < EXPONENT_CAP;
        } else {
            dropped += !point && dropped < EXPONENT_CAP;
        }
    }
    int exponent = 0;
    if (!seen)
        return 0;
    if (p < end && (*p == 'e' || *p == 'E')) {
        p++;
        if (!parse_exponent(&p, end, &exponent))
            return 0;
    }
    if (p != end)
        return 0;
    const double x = mantissa == 0 ? 0.0 : scale10((double)mantissa, exponent + dropped - places);
    if (!isfinite(x))
        return 0;
    *value = negative ? -x : x;
    if (decimals)
        *decimals = places - exponent;
    return 1;
}

/* x > 0 as `wanted` decimal digits and the power of ten of the first; returns how many there are
 * without the zeros at the end. */
static int significant_digits(double x, int wanted, char digits[LCOR_NUMBER_DIGITS], int *power)
{
    const double limit = scale10(1.0, wanted);
    int e = (int)floor(log10(x));
    /* log10 may be one off next to a power of ten, and rounding may carry into a new digit. */
    double scaled = floor(scale10(x, wanted - 1 - e) + 0.5);
    if (scaled < limit / 10.0)
        scaled = floor(scale10(x, wanted - 1 - --e) + 0.5);
    if (scaled >= limit)
        scaled = floor(scale10(x, wanted - 1 - ++e) + 0.5);
    uint64_t left = (uint64_t)scaled;
    for (int i = wanted - 1; i >= 0; i--, left /= 10)
        digits[i] = (char)('0' + left % 10);
    int count = wanted;
    while (count > 1 && digits[count - 1] == '0')
        count--;
    *power = e;
    return count;
}

static size_t put_integer(char *out, int value)
{
    char reversed[12];
    size_t n = 0, written = 0;
    for (int left = value < 0 ? -value : value; left > 0 || n == 0; left /= 10)
        reversed[n++] = (char)('0' + left % 10);
    if (value < 0)
        out[written++] = '-';
    while (n > 0)
        out[written++] = reversed[--n];
    return written;
}

size_t lcor_internal_number_format(double value, int wanted, char buffer[LCOR_NUMBER_SIZE])
{
    char digits[LCOR_NUMBER_DIGITS];
    int power = 0;
    size_t n = 0;
    if (value == 0.0 || !isfinite(value)) {
        memcpy(buffer, "0", 2);
        return 1;
    }
    const int count = significant_digits(fabs(value), wanted, digits, &power);
    if (value < 0.0)
        buffer[n++] = '-';
    if (power < -6 || power > 12) { /* d.ddde+-x */
        buffer[n++] = digits[0];
        if (count > 1)
            buffer[n++] = '.';
        for (int i = 1; i < count; i++)
            buffer[n++] = digits[i];
        buffer[n++] = 'e';
        n += put_integer(buffer + n, power);
    } else {
        if (power < 0)
            buffer[n++] = '0';
        for (int place = power < 0 ? -1 : power; place >= 0 || power - place < count; place--) {
            const int i = power - place; /* which digit stands at 10^place */
            if (place == -1)
                buffer[n++] = '.';
            buffer[n] = '0';
            if (i >= 0 && i < count)
                buffer[n] = digits[i];
            n++;
        }
    }
    buffer[n] = '\0';
    return n;
}

double lcor_internal_number_round(double value)
{
    char text[LCOR_NUMBER_SIZE];
    double rounded = 0.0;
    const size_t n = lcor_internal_number_format(value, LCOR_NUMBER_DIGITS, text);
    (void)lcor_internal_number_parse(text, n, &rounded, NULL);
    return rounded;
}
