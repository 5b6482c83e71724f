/* SPDX-License-Identifier: MIT */
/* The pixels that stand for a page in the mean of r. A page of up to 2^18 pixels is taken whole. Of
 * larger ones every row gives one pixel of each of equal stretches, at a place drawn anew for each,
 * so that no pattern of the page falls in with theirs: the mean of ln r has a standard error of a
 * five-hundredth of the deviation within those stretches. */
#ifndef RASTERTOLCOR_SAMPLE_H
#define RASTERTOLCOR_SAMPLE_H

#include "raster.h"

#define SAMPLE_PIXELS ((size_t)1 << 18)

typedef struct row_sample {
    const raster_format *format;
    size_t count;          /* pixels of a row: its width, or fewer */
    size_t *x;             /* where they lie, in order */
    unsigned char *texels; /* interleaved RGB, 0 = black */
} row_sample;

/* One per thread. False: no memory. */
bool row_sample_open(row_sample *sample, const raster_format *format);
void row_sample_close(row_sample *sample);
/* The same x for a row y whenever it is asked for. */
void row_sample_place(row_sample *sample, size_t y);
/* The texels of a row at x. */
void row_sample_take(row_sample *sample, const unsigned char *row);

#endif
