/* SPDX-License-Identifier: MIT */
#include "filter.h"

#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>

void filter_say(const char *level, const char *format, ...)
{
    /* One write per line: the threads' lines do not mix, and the scheduler reads line by line. */
    char line[512];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(line, sizeof line, format, arguments);
    va_end(arguments);
    for (char *c = line; *c; c++)
        if ((unsigned char)*c < ' ')
            *c = ' ';
    fprintf(stderr, "%s: %s\n", level, line);
}

static int digit(char c) { return c >= '0' && c <= '9' ? c - '0' : -1; }

bool filter_number(const char *text, double *out)
{
    const bool negative = *text == '-';
    uint64_t mantissa = 0;
    int exponent = 0, digits = 0;
    bool point = false;
    text += *text == '-' || *text == '+';
    for (; digit(*text) >= 0 || (*text == '.' && !point); text++) {
        if (*text == '.') {
            point = true;
        } else if (++digits > 300) {
            return false;
        } else if (mantissa < UINT64_C(100000000000000000)) { /* more is beyond a double */
            mantissa = 10 * mantissa + (uint64_t)digit(*text);
            exponent -= point;
        } else {
            exponent += !point;
        }
    }
    if (digits == 0)
        return false;
    if (*text == 'e' || *text == 'E') {
        const bool small = *++text == '-';
        int e = 0;
        text += *text == '-' || *text == '+';
        if (digit(*text) < 0)
            return false;
        for (; digit(*text) >= 0; text++)
            e = e < 1000 ? 10 * e + digit(*text) : e;
        exponent += small ? -e : e;
    }
    if (*text != '\0' || exponent > 308 || exponent < -308)
        return false;
    double power = 1.0; /* exact up to 10^22 */
    for (int i = exponent < 0 ? -exponent : exponent; i > 0; i--)
        power *= 10.0;
    const double x = exponent < 0 ? (double)mantissa / power : (double)mantissa * power;
    *out = negative ? -x : x;
    return true;
}
