/* SPDX-License-Identifier: MIT */
/* Numbers in C notation, whatever the locale. */
#ifndef LCCAL_NUMBER_H
#define LCCAL_NUMBER_H

#include <stdbool.h>
#include <stddef.h>

/* [+-] digits [. digits], the whole of text[0..n-1], at most 15 digits; no exponent, no nan, no
 * hexadecimal. */
bool lccal_parse_number(const char *text, size_t n, double *out);

/* Fixed-point text of a finite |value| < 1e12 with 0..9 decimals; never "-0.00". Returns buffer. */
const char *lccal_format_number(char *buffer, size_t capacity, double value, int decimals);

#endif
