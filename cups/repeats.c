/* SPDX-License-Identifier: MIT */
#include "repeats.h"

#include <stdlib.h>
#include <string.h>

#define SLACK   8  /* bytes after a row that are read along with its last pixels */
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
    r->before = calloc(1, 3 * width + SLACK);
    r->after = malloc(3 * width + SLACK);
    r->texels = malloc(3 * width + SLACK);
    r->light = malloc(width * sizeof *r->light);
    r->run = malloc(width * sizeof *r->run);
    r->stretch_end = malloc((width + 1) * sizeof *r->stretch_end);
    return r->before && r->after && r->texels && r->light && r->run && r->stretch_end;
}

void repeats_close(repeats *r)
{
    free(r->before);
    free(r->after);
    free(r->texels);
    free(r->light);
    free(r->run);
    free(r->stretch_end);
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

/* How many of n pixels, the first one included, have its colour. Two are compared at once. */
static size_t run_length(const unsigned char *p, size_t n)
{
    uint64_t one = 0, two = 0; /* the bytes of so many pixels */
    memset(&one, 0xff, 3);
    memset(&two, 0xff, 6);
    for (size_t length = 1; length < n; p += 6, length += 2) {
        uint64_t here, next;
        memcpy(&here, p, sizeof here);
        memcpy(&next, p + 3, sizeof next);
        if ((here ^ next) & one)
            return length;
        if ((here ^ next) & two)
            return length + 1 < n ? length + 1 : n;
    }
    return n;
}

/* The runs of the row that are not in `before` or were there under other light. */
static void find_runs(repeats *r, const unsigned char *row, const float *light, bool other_light)
{
    size_t x = 0;
    r->runs = 0;
    for (size_t i = 0; i < r->stretches; i++) {
        const size_t end = r->stretch_end[i];
        if (!other_light && memcmp(row + 3 * x, r->before + 3 * x, 3 * (end - x)) == 0)
            x = end;
        for (size_t n; x < end; x += n) {
            n = run_length(row + 3 * x, end - x);
            memcpy(r->texels + 3 * r->runs, row + 3 * x, 3);
            r->light[r->runs] = light[x];
            r->run[r->runs++] = (repeats_run){(uint32_t)x, (uint32_t)n};
        }
    }
}

/* Puts the runs, which are corrected now, in their places. */
static void fill_runs(repeats *r)
{
    for (size_t i = 0; i < r->runs; i++) {
        unsigned char *to = r->after + 3 * (size_t)r->run[i].first;
        uint32_t pixel;
        memcpy(&pixel, r->texels + 3 * i, sizeof pixel);
        for (uint32_t n = r->run[i].length; n > 1; n--, to += 3)
            memcpy(to, &pixel, sizeof pixel);
        memcpy(to, &pixel, 3);
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
