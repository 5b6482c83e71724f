/* SPDX-License-Identifier: MIT */
#include "pack.h"

#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#define PIXELS_MAX 128 /* in a run or a stretch */
#define ROWS_MAX   256 /* equal rows */

/* A run takes no more bytes than its pixels, and between two stretches of less than PIXELS_MAX lies
 * a run: one byte for every two pixels is added at the most. */
size_t pack_row_max(size_t pixels, size_t pixel_bytes)
{
    return 1 + pixels * pixel_bytes + (pixels + 1) / 2;
}

/* Does a pixel equal the next one? Eight bytes are read at once; the pixel's are set in `mask`. */
static inline bool goes_on(const unsigned char *p, size_t pixel_bytes, uint64_t mask)
{
    uint64_t here, next; /* PACK_SLACK bytes */
    memcpy(&here, p, sizeof here);
    memcpy(&next, p + pixel_bytes, sizeof next);
    return ((here ^ next) & mask) == 0;
}

/* Of n pairs of neighbours, how many at the beginning are equal, or are not. */
static inline size_t count(const unsigned char *p, size_t n, size_t pixel_bytes, uint64_t mask,
                           bool equal)
{
    size_t i = 0;
    for (; i < n && goes_on(p, pixel_bytes, mask) == equal; i++)
        p += pixel_bytes;
    return i;
}

static unsigned char *pack_row(const unsigned char *p, size_t pixels, size_t pixel_bytes,
                               unsigned char *to)
{
    uint64_t mask = 0;
    memset(&mask, 0xff, pixel_bytes);
    for (size_t n; pixels > 0; pixels -= n, p += n * pixel_bytes) {
        const size_t most = pixels < PIXELS_MAX ? pixels : PIXELS_MAX;
        n = count(p, most - 1, pixel_bytes, mask, false);
        if (n == most - 1) /* nor does the last one begin a run */
            n = most;
        if (n > 1) {
            *to++ = (unsigned char)(257 - n);
            memcpy(to, p, n * pixel_bytes);
            to += n * pixel_bytes;
        } else { /* one pixel alone is a run of one */
            if (n == 0)
                n = 1 + count(p, most - 1, pixel_bytes, mask, true);
            *to++ = (unsigned char)(n - 1);
            memcpy(to, p, PACK_SLACK);
            to += pixel_bytes;
        }
    }
    return to;
}

size_t pack_rows(const unsigned char *pixels, size_t rows, size_t row_pixels, size_t pixel_bytes,
                 unsigned char *to)
{
    const size_t row_bytes = row_pixels * pixel_bytes;
    unsigned char *const begin = to;
    for (size_t y = 0, n; y < rows; y += n, pixels += n * row_bytes) {
        const size_t most = rows - y < ROWS_MAX ? rows - y : ROWS_MAX;
        for (n = 1; n < most && memcmp(pixels, pixels + n * row_bytes, row_bytes) == 0;)
            n++;
        *to++ = (unsigned char)(n - 1);
        to = pack_row(pixels, row_pixels, pixel_bytes, to);
    }
    return (size_t)(to - begin);
}

/* One row; returns where its bytes end, or NULL if they do not make a row. */
static const unsigned char *unpack_row(const unsigned char *p, const unsigned char *end,
                                       size_t pixels, size_t pixel_bytes, unsigned char *to)
{
    while (pixels > 0) {
        if (p == end)
            return NULL;
        const bool is_run = *p < PIXELS_MAX;
        const size_t n = is_run ? *p + 1u : 257u - *p;
        const size_t bytes = (is_run ? 1 : n) * pixel_bytes;
        p++;
        if (n > pixels || bytes > (size_t)(end - p))
            return NULL;
        if (is_run) {
            uint64_t pixel;
            memcpy(&pixel, p, sizeof pixel);
            for (size_t i = 0; i < n; i++)
                memcpy(to + i * pixel_bytes, &pixel, sizeof pixel);
        } else {
            memcpy(to, p, bytes);
        }
        p += bytes;
        to += n * pixel_bytes;
        pixels -= n;
    }
    return p;
}

bool unpack_rows(const unsigned char *packed, size_t size, size_t rows, size_t row_pixels,
                 size_t pixel_bytes, unsigned char *pixels)
{
    const unsigned char *p = packed, *const end = packed + size;
    const size_t row_bytes = row_pixels * pixel_bytes;
    while (rows > 0) {
        const size_t n = p < end ? *p++ + 1u : 0;
        if (n == 0 || n > rows)
            return false;
        p = unpack_row(p, end, row_pixels, pixel_bytes, pixels);
        if (!p)
            return false;
        for (size_t i = 1; i < n; i++)
            memcpy(pixels + i * row_bytes, pixels, row_bytes);
        pixels += n * row_bytes;
        rows -= n;
    }
    return p == end;
}
