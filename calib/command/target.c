/* SPDX-License-Identifier: MIT */
#include "command/target.h"

#include <math.h>

#define PATCH  22.0 /* mm; wider than the foot of hand-held densitometers' aperture plates */
#define MARGIN 15.0
#define PITCH  (PATCH + 3.0)
#define LINE   0.25 /* mm, of frames */
#define DOT    0.5  /* mm, of figures */

enum { BLACK = 0, WHITE = 255, MARK = 128 };

/* No brackets or backslashes: they would have to be escaped in PDF. */
const char *const target_instructions[] = {
    "Print at 100 % with all colour management off: no profile, no 'printer manages colours', no",
    "automatic enhancement. Use paper, quality and ink settings of the real work. Let the print "
    "dry, an",
    "inkjet print for a day, and lay it on the backing that --backing names. Then: lccal --port "
    "PORT",
    NULL};

static void add(target *t, double x, double y, double width, double height, int level)
{
    if (t->count < TARGET_RECTANGLES)
        t->rectangles[t->count++] = (rectangle){x, y, width, height, level};
}

/* Figures of 3 by 5 dots. Each row is three bits, the first row in the highest. */
static void add_figure(target *t, double x, double y, int figure)
{
    static const unsigned short dots[] = {075557, 026227, 071747, 071717, 055711,
                                          074717, 074757, 071111, 075757, 075717};
    for (int row = 0; row < 5; row++)
        for (int column = 0; column < 3; column++)
            if (dots[figure] >> (14 - 3 * row - column) & 1)
                add(t, x + column * DOT, y + row * DOT, DOT, DOT, MARK);
}

static void add_number(target *t, double x, double y, int number)
{
    int place = number > 99 ? 100 : number > 9 ? 10 : 1;
    for (int i = 0; place > 0; i++, place /= 10)
        add_figure(t, x + 4.0 * DOT * i, y, number / place % 10);
}

static void add_patch(target *t, double x, double y, int level)
{
    if (level == WHITE) { /* bare paper in a frame */
        add(t, x, y, PATCH, LINE, MARK);
        add(t, x, y + PATCH - LINE, PATCH, LINE, MARK);
        add(t, x, y, LINE, PATCH, MARK);
        add(t, x + PATCH - LINE, y, LINE, PATCH, MARK);
    } else {
        add(t, x, y, PATCH, PATCH, level);
    }
    add_number(t, x, y + PATCH + 1.0, level);
}

void target_lay_out(target *t, double width, double height, int steps)
{
    t->width = width;
    t->height = height;
    t->count = 0;
    /* Foot: room for the instructions. */
    const double across = (width - 2.0 * MARGIN - 2.0 * PITCH + 3.0) / 2.0;
    const double down = (height - 2.0 * MARGIN - PATCH - 25.0) / 2.0;
    for (int row = 0; row < 3; row++)
        for (int column = 0; column < 3; column++) {
            const double x = MARGIN + column * across, y = MARGIN + row * down;
            add_patch(t, x, y, WHITE);
            add_patch(t, x + PITCH, y, BLACK);
        }
    /* Greys: two rows of seven above the middle, two below. */
    const double pitch = (width - 2.0 * MARGIN - PATCH) / 6.0;
    for (int i = 1; i <= steps; i++) {
        const int row = (i - 1) / 7, column = (i - 1) % 7, band = row / 2;
        const double gap = (down - 3.0 * (PATCH + 5.0)) / 3.0;
        const double y = MARGIN + band * down + (1 + row % 2) * (PATCH + 5.0 + gap);
        add_patch(t, MARGIN + column * pitch, y, (int)floor(255.0 * i / (steps + 1) + 0.5));
    }
}
