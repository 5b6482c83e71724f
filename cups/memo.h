/* SPDX-License-Identifier: MIT */
/* Corrected colours of a page in even light: what comes out of a pixel then depends on its colour
 * alone, and printed pages repeat their colours. */
#ifndef RASTERTOLCOR_MEMO_H
#define RASTERTOLCOR_MEMO_H

#include <lcor/correct.h>

#include <stddef.h>
#include <stdint.h>

#define MEMO_BITS    14
#define MEMO_PENDING 256

/* For one plan; one per thread. Zero-initialise. */
typedef struct memo {
    uint64_t entries[1 << MEMO_BITS];        /* colour + 1 in the upper half, corrected below */
    unsigned char pending[3 * MEMO_PENDING]; /* colours that no entry holds ... */
    size_t at[MEMO_PENDING];                 /* ... and their pixels */
    size_t poor_rows;                        /* in succession, of mostly new colours */
    size_t plain_rows; /* still to be corrected without looking: too many colours */
} memo;

/* lcor_correct_row in place on interleaved RGB of 8 bits, the same bytes. `light`: width
 * values, all the same. */
void memo_correct_row(memo *m, const lcor_plan *plan, size_t width, unsigned char *row,
                      const float *light);

#endif
