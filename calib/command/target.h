/* SPDX-License-Identifier: MIT */
/* The chart that is printed and measured: grey rectangles on a page. */
#ifndef LCCAL_TARGET_H
#define LCCAL_TARGET_H

#include "buffer.h"

typedef struct rectangle {
    double x, y, width, height; /* mm from the upper left corner of the page */
    int level;                  /* R = G = B, 0..255 */
} rectangle;

enum { TARGET_RECTANGLES = 2048, TARGET_STEPS_MAX = 28 };

typedef struct target {
    double width, height; /* of the page, mm */
    rectangle rectangles[TARGET_RECTANGLES];
    size_t count;
} target;

/* White and black at nine positions of the page, the grey levels round(255 i / (steps + 1))
 * between, each with its level in figures below it. */
void target_lay_out(target *t, double width, double height, int steps);

/* What the person who prints it must do; lines, the last one NULL. */
extern const char *const target_instructions[];

/* 16-bit RGB without a colour profile; false when memory is short or libtiff was not built in. */
bool target_tiff(const target *t, double dpi, buffer *out);
/* PDF 1.4 in DeviceRGB, with the instructions at the foot of the page. */
void target_pdf(const target *t, buffer *out);

#endif
