/* SPDX-License-Identifier: MIT */
#include "number.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

bool lccal_parse_number(const char *text, size_t n, double *out)
{
    size_t i = 0;
    const bool negative = n > 0 && text[0] == '-';
    if (n > 0 && (text[0] == '-' || text[0] == '+'))
        i = 1;
    /* 15 digits are exact in a double, and so is the power of ten that scales them. */
    double mantissa = 0.0, scale = 1.0;
    int digits = 0;
    bool point = false;
    for (; i < n; i++) {
        if (text[i] == '.' && !point) {
            point = true;
            continue;
        }
        if (text[i] < '0' || text[i] > '9')
            return false;
        if (++digits > 15)
            return false;
        mantissa = 10.0 * mantissa + (text[i] - '0');
        if (point)
            scale *= 10.0;
    }
    if (digits == 0)
        return false;
    *out = negative ? -mantissa / scale : mantissa / scale;
    return true;
}

const char *lccal_format_number(char *buffer, size_t capacity, double value, int decimals)
{
    static const double powers[] = {1.0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9};
    char reversed[48];
    size_t n = 0;
    /* Past 2^53 steps of the last place a double has no more digits to give. */
    while (decimals > 0 && fabs(value) * powers[decimals] >= 9007199254740992.0)
        decimals--;
    const double rounded = floor(fabs(value) * powers[decimals] + 0.5);
    uint64_t digits = (uint64_t)rounded;
    const bool negative = value < 0.0 && digits > 0;
    for (int place = 0; digits > 0 || place <= decimals; place++) {
        if (place == decimals && decimals > 0)
            reversed[n++] = '.';
        reversed[n++] = (char)('0' + digits % 10);
        digits /= 10;
    }
    if (negative)
        reversed[n++] = '-';
    size_t written = 0;
    while (n > 0 && written + 1 < capacity)
        buffer[written++] = reversed[--n];
    if (capacity > 0)
        buffer[written] = '\0';
    return buffer;
}
