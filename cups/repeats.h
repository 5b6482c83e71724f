/* SPDX-License-Identifier: MIT */
/* Rows in which what repeats is computed once: a run of pixels of one colour under the same light,
 * and a row that is like the one before. Pages are full of them: paper, letters, photographs that a
 * renderer enlarged. */
#ifndef RASTERTOLCOR_REPEATS_H
#define RASTERTOLCOR_REPEATS_H

#include <lcor/correct.h>

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* One per thread. */
typedef struct repeats {
    size_t width;
    unsigned char *before, *after; /* the row computed last, as it came and as it went out */
    size_t drawn;                  /* and its light */
    bool known;                    /* there is such a row */
    size_t *stretch_end;           /* of stretches of one light and of no great length */
    size_t stretches;
    size_t *changed; /* those that are other than in the row before */
    size_t changes;
    unsigned char *texels; /* of each run in them: the colour ... */
    float *light;          /* ... and the light */
    size_t runs;
    uint32_t *run_of;  /* of each pixel in them: its run */
    size_t poor_rows;  /* in succession, in which hardly anything repeats */
    size_t plain_rows; /* still to be corrected without looking */
} repeats;

/* For rows of 8-bit interleaved RGB. False: no memory. */
bool repeats_open(repeats *r, size_t width);
void repeats_close(repeats *r);
/* Before another plan. */
void repeats_forget(repeats *r);
/* lcor_correct_row in place, the same bytes; one byte after the row must be readable. `drawn` is
 * another number whenever `light` is other than in the call before. The pixels computed are those
 * that `stats` counts. */
void repeats_correct_row(repeats *r, const lcor_plan *plan, size_t y, unsigned char *row,
                         const float *light, size_t drawn, lcor_row_stats *stats);

#endif
