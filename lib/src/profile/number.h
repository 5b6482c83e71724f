/* SPDX-License-Identifier: MIT */
/* Numbers of a text, in C notation whatever the locale. */
#ifndef LCOR_PROFILE_NUMBER_H
#define LCOR_PROFILE_NUMBER_H

#include <stddef.h>

/* Enough for any number number_format writes, with its NUL. */
#define LCOR_NUMBER_SIZE 32
/* More than any instrument or program gives. */
#define LCOR_NUMBER_DIGITS 9

/* [+-] digits [. digits] [e [+-] digits], all of text[0..n-1]; returns 0 for anything else, and for
 * a value too large for a double. Exact to half a unit in the last place for up to 15 digits,
 * to a few units for more. `*decimals` (may be NULL): digits after the point less the exponent. */
int lcor_internal_number_parse(const char *text, size_t n, double *value, int *decimals);

/* The shortest text that stands for `value` (finite) rounded to `wanted` significant digits, 1 to
 * LCOR_NUMBER_DIGITS. Parsing it and formatting that again gives the same text. Returns its length.
 */
size_t lcor_internal_number_format(double value, int wanted, char buffer[LCOR_NUMBER_SIZE]);

/* What reading gives after writing `value` with LCOR_NUMBER_DIGITS. */
double lcor_internal_number_round(double value);

#endif
