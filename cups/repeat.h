/* SPDX-License-Identifier: MIT */
/* Pixels that come again row after row under a light map: paper, letters, pictures enlarged to the
 * resolution of the printer. Light hardly changes from row to row, nor does what they become, so
 * the first and the last of such rows are computed without rounding, and those between lie on a
 * straight line. Where the line is too near the middle of two bytes to tell, pixels are computed
 * one by one: what comes out is the bytes that lcor_correct_row gives.
 *
 * Over so small a step of light colour bends little: by less than d^2 / 100 codes where it changes
 * by d codes. But it has corners: where it leaves the gamut, where light is beyond what the device
 * shows, and where pixels turn from darker to lighter (eq 16). Rows in light that comes across one
 * of them are computed one by one, too. */
#ifndef RASTERTOLCOR_REPEAT_H
#define RASTERTOLCOR_REPEAT_H

#include "illuminance.h"
#include "pipeline.h"

#include <lcor/correct.h>

#include <stdbool.h>
#include <stddef.h>

/* One per thread. */
typedef struct repeat repeat;

/* For pages of so many columns, in bands of at most so many rows. NULL: no memory. */
repeat *repeat_open(size_t width, size_t rows);
void repeat_close(repeat *r);
/* Before the first band. Both plans: interleaved RGB of 8 bits, sRGB, patch reading, CIE lightness,
 * no tone curve; `unrounded` has float output, and both are otherwise the same. `stats` is added
 * to. */
void repeat_use(repeat *r, const lcor_plan *plan, const lcor_plan *unrounded,
                lcor_row_stats *stats);
/* Correct a band in place. False if the map could not be read. */
bool repeat_correct(repeat *r, illuminance_rows *light, const pipeline_band *band);

#endif
