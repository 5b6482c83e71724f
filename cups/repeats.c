/* SPDX-License-Identifier: MIT */
#include "repeats.h"

#include <stdlib.h>
#include <string.h>

#define SLACK   1  /* a pixel of three bytes is moved with the byte after it */
#define STRETCH 32 /* pixels at most */
/* Where pixels hardly repeat, looking is slower: after two rows in succession with more runs than
 * half their pixels, the next ones are corrected plainly. One such row alone may be the first of
 * two alike: a photograph that was enlarged twice. */
#define RUN_WORTH  2
#define POOR_ROWS  2
#define PLAIN_ROWS 62

bool repeats_open(repeats *r, size_t width)
{
    memset(r, 0, sizeof *r);
    r->width = width;
    r->before = malloc(3 * width);
    r->after = malloc(3 * width);
    r->texels = malloc(3 * width + SLACK);
    r->light = malloc(width * sizeof *r->light);
    r->run_of = malloc(width * sizeof *r->run_of);
    r->stretch_end = malloc(width * sizeof *r->stretch_end);
    r->changed = malloc(width * sizeof *r->changed);
    return r->before && r->after && r->texels && r->light && r->run_of && r->stretch_end &&
           r->changed;
}

void repeats_close(repeats *r)
{
    free(r->before);
    free(r->after);
    free(r->texels);
    free(r->light);
    free(r->run_of);
    free(r->stretch_end);
    free(r->changed);
    memset(r, 0, sizeof *r);
}

void repeats_forget(repeats *r) { r->known = false; }

/* Cuts the row where light changes, or else every STRETCH pixels. */
static void find_stretches(repeats *r, const float *light)
{
    size_t begin = 0;
    r->stretches = 0;
    for (size_t x = 1; x <= r->width; x++) {
        if (x == r->width || light[x] != light[x - 1] || x - begin == STRETCH)
            r->stretch_end[r->stretches++] = begin = x;
    }
}

/* The runs of the stretches that are not in `before` or were there under other light. Most runs of
 * a photograph are short, so a pixel that goes on with one takes the same way as one that does not.
 */
static void find_runs(repeats *r, const unsigned char *row, const float *light, bool other_light)
{
    uint32_t mask = 0, runs = 0;
    memset(&mask, 0xff, 3);
    r->changes = 0;
    for (size_t i = 0, x = 0; i < r->stretches; i++) {
        const size_t begin = x, end = r->stretch_end[i];
        if (!other_light && memcmp(row + 3 * x, r->before + 3 * x, 3 * (end - x)) == 0) {
            x = end;
            continue;
        }
        r->changed[r->changes++] = i;
        for (uint32_t last = 0; x < end; x++) {
            uint32_t pixel;
            memcpy(&pixel, row + 3 * x, sizeof pixel);
            pixel &= mask;
            runs += (x == begin) | (pixel != last);
            last = pixel;
            memcpy(r->texels + 3 * (size_t)(runs - 1), &pixel, sizeof pixel);
            r->light[runs - 1] = light[x];
            r->run_of[x] = runs - 1;
        }
    }
    r->runs = runs;
}

/* Puts the runs, which are corrected now, in their places. */
static void fill_runs(repeats *r)
{
    for (size_t i = 0; i < r->changes; i++) {
        const size_t stretch = r->changed[i], last = r->stretch_end[stretch] - 1;
        for (size_t x = stretch > 0 ? r->stretch_end[stretch - 1] : 0; x < last; x++)
            memcpy(r->after + 3 * x, r->texels + 3 * (size_t)r->run_of[x], 4);
        memcpy(r->after + 3 * last, r->texels + 3 * (size_t)r->run_of[last], 3);
    }
}

void repeats_correct_row(repeats *r, const lcor_plan *plan, size_t y, unsigned char *row,
                         const float *light, size_t drawn, lcor_row_stats *stats)
{
    const size_t bytes = 3 * r->width;
    const bool other_light = !r->known || drawn != r->drawn;
    if (r->plain_rows > 0) {
        r->plain_rows--;
        lcor_correct_row(plan, y, r->width, row, light, NULL, row, stats);
        return;
    }
    if (other_light)
        find_stretches(r, light);
    if (!other_light && memcmp(row, r->before, bytes) == 0) {
        r->poor_rows = 0;
    } else {
        find_runs(r, row, light, other_light);
        lcor_correct_row(plan, y, r->runs, r->texels, r->light, NULL, r->texels, stats);
        fill_runs(r);
        memcpy(r->before, row, bytes);
        r->known = true;
        r->drawn = drawn;
        r->poor_rows = r->runs * RUN_WORTH > r->width ? r->poor_rows + 1 : 0;
    }
    memcpy(row, r->after, bytes);
    if (r->poor_rows == POOR_ROWS) {
        r->poor_rows = 0;
        r->plain_rows = PLAIN_ROWS;
    }
}
