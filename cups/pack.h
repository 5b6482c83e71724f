/* SPDX-License-Identifier: MIT */
/* Rows as compressed CUPS and PWG raster hold them (PWG 5102.4): how often a row comes, then runs
 * of one pixel and stretches of different ones. libcups would do it on the thread that writes; here
 * each thread packs the rows that it corrected. */
#ifndef RASTERTOLCOR_PACK_H
#define RASTERTOLCOR_PACK_H

#include <stdbool.h>
#include <stddef.h>

/* Bytes behind the last row that are read, and in `to` behind the last one that counts. */
#define PACK_SLACK 8

/* The most bytes that a row of so many pixels can become. */
size_t pack_row_max(size_t pixels, size_t pixel_bytes);
/* Packs `rows` rows of pixels of at most PACK_SLACK bytes. Returns the number of bytes in `to`. */
size_t pack_rows(const unsigned char *pixels, size_t rows, size_t row_pixels, size_t pixel_bytes,
                 unsigned char *to);
/* Those rows again. Reads PACK_SLACK bytes behind `packed` and writes as many behind the last row.
 * False if the `size` bytes are not what rows become. */
bool unpack_rows(const unsigned char *packed, size_t size, size_t rows, size_t row_pixels,
                 size_t pixel_bytes, unsigned char *pixels);

#endif
