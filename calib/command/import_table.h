/* SPDX-License-Identifier: MIT */
/* Tables of other programs (CSV, tab-separated text) as CGATS text. */
#ifndef LCCAL_IMPORT_TABLE_H
#define LCCAL_IMPORT_TABLE_H

#include "buffer.h"

/* Does the text hold a CGATS data section? */
bool import_is_cgats(const char *text, size_t size);

/* A table (a line of names, then rows; comma, semicolon or tab between; quotes as in CSV; # starts
 * a comment line) as CGATS text with the same line numbers. Names are those of CGATS or what people
 * write: R G B, C M Y K, X Y Z, D or density, L* a* b*, patch. A table that says white and black
 * in its column of names needs no R G B.
 *
 * false: no table; `problem` says where and why. */
bool import_table(const char *text, size_t size, buffer *cgats, char *problem, size_t capacity);

#endif
