/* SPDX-License-Identifier: MIT */
#include "repeat.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#define PART     ((size_t)128) /* columns looked at together */
#define ROWS_MIN 4             /* fewer are not worth it */
#define ROWS_MAX 32            /* light changes too much over more */
#define OTHERS   8             /* one sample in so many of a row may differ from the first row's */
#define CHUNK    64            /* samples compared before the next look at how many differ */
#define CHANGE   0.004f /* of light between the first and the last row: half a code of white */

/* Codes in fixed point. */
#define FRACTION 16
#define ONE      (1 << FRACTION)
#define STEEP    (ONE / 2) /* change of a pixel; more might bend */
/* About the middle between two codes. Float rows are within a hundredth of the exact ones where the
 * transfer function is steepest, at black (docs/MODEL.md, "Accuracy"). */
#define MARGIN (ONE / 64)

struct repeat {
    size_t width, parts; /* of a row */
    float *light;        /* of a band */
    unsigned char *done; /* parts of its rows that are corrected */
    const lcor_plan *plan, *unrounded;
    lcor_row_stats *stats;
    float turn; /* light that leaves grey as it is */
    /* Pixels to be computed one by one. */
    size_t waiting;
    unsigned char texels[3 * PART];
    float waiting_light[PART];
    unsigned char *to[PART];
};

/* Part of some rows, and the light on them. */
typedef struct columns {
    size_t count; /* at most PART */
    unsigned char *pixels;
    size_t row_bytes;
    const float *light;
    size_t light_step; /* floats from row to row */
} columns;

repeat *repeat_open(size_t width, size_t rows)
{
    repeat *r = calloc(1, sizeof *r);
    if (!r)
        return NULL;
    r->width = width;
    r->parts = (width - 1) / PART + 1;
    r->light = malloc(rows * width * sizeof *r->light);
    r->done = malloc(rows * r->parts);
    if (r->light && r->done)
        return r;
    repeat_close(r);
    return NULL;
}

void repeat_close(repeat *r)
{
    if (!r)
        return;
    free(r->light);
    free(r->done);
    free(r);
}

/* Light and 8-bit grey in, float grey out. */
static float grey_under(const lcor_plan *unrounded, float light)
{
    static const unsigned char grey[3] = {128, 128, 128};
    float out[3];
    lcor_correct_row(unrounded, 0, 1, grey, &light, NULL, out, NULL);
    return out[1];
}

void repeat_use(repeat *r, const lcor_plan *plan, const lcor_plan *unrounded, lcor_row_stats *stats)
{
    float low = 1e-30f, high = 1e30f;
    r->plan = plan;
    r->unrounded = unrounded;
    r->stats = stats;
    while (high > low * 1.000001f) {
        const float middle = sqrtf(low) * sqrtf(high);
        if (grey_under(unrounded, middle) > 128.0f / 255.0f)
            high = middle;
        else
            low = middle;
    }
    r->turn = high;
}

/* Does light change little from row a to row b, and make all pixels darker, or all lighter? */
static bool is_calm(const repeat *r, size_t n, const float *a, const float *b)
{
    const float low = r->turn * 0.9999f, high = r->turn * 1.0001f;
    int darker = 1, lighter = 1, little = 1;
    for (size_t i = 0; i < n; i++) {
        darker &= (a[i] < low) & (b[i] < low);
        lighter &= (a[i] > high) & (b[i] > high);
        little &= fabsf(b[i] - a[i]) <= CHANGE * a[i];
    }
    return little && (darker || lighter);
}

/* Do enough samples of two rows agree? Pixels that differ here and there do no harm. */
static bool are_alike(const unsigned char *a, const unsigned char *b, size_t bytes)
{
    size_t others = 0;
    if (memcmp(a, b, bytes) == 0)
        return true;
    for (size_t at = 0; at < bytes && others <= bytes / OTHERS; at += CHUNK) {
        const size_t end = bytes - at < CHUNK ? bytes : at + CHUNK;
        for (size_t i = at; i < end; i++)
            others += a[i] != b[i];
    }
    return others <= bytes / OTHERS;
}

/* How many of `rows` rows repeat from the first one, row y of the page, on; 0 if too few. */
static size_t find_repeats(const repeat *r, const illuminance_rows *light, size_t y,
                           const columns *c, size_t rows)
{
    size_t n = 1;
    while (n < rows && are_alike(c->pixels, c->pixels + n * c->row_bytes, 3 * c->count))
        n++;
    if (n >= ROWS_MIN)
        n = illuminance_straight(light, y, n);
    while (n >= ROWS_MIN && !is_calm(r, c->count, c->light, c->light + (n - 1) * c->light_step))
        n /= 2;
    return n >= ROWS_MIN ? n : 0;
}

/* The first row's colours as fixed-point codes plus one half, under the light of a row. False if
 * some pixel is not shown as it should be. */
static bool compute(const repeat *r, const columns *c, size_t row, int32_t *codes)
{
    float colours[3 * PART];
    const size_t bytes = 3 * c->count;
    lcor_row_stats stats = {0};
    lcor_correct_row(r->unrounded, row, c->count, c->pixels, c->light + row * c->light_step, NULL,
                     colours, &stats);
    for (size_t i = 0; i < bytes; i++)
        codes[i] = (int32_t)((colours[i] * 255.0f + 0.5f) * (float)ONE);
    return stats.clipped_low + stats.clipped_high + stats.out_of_gamut + stats.non_finite == 0;
}

static void correct_waiting(repeat *r)
{
    lcor_correct_row(r->plan, 0, r->waiting, r->texels, r->waiting_light, NULL, r->texels,
                     r->stats);
    for (size_t i = 0; i < r->waiting; i++)
        memcpy(r->to[i], r->texels + 3 * i, 3);
    r->waiting = 0;
}

static void wait(repeat *r, const unsigned char *texel, float light, unsigned char *to)
{
    memcpy(r->texels + 3 * r->waiting, texel, 3);
    r->waiting_light[r->waiting] = light;
    r->to[r->waiting++] = to;
    r->stats->pixels--; /* it will be counted */
    if (r->waiting == PART)
        correct_waiting(r);
}

/* The lines on which codes go from row to row. */
typedef struct lines {
    unsigned char texels[3 * PART]; /* the first row's */
    int32_t codes[3 * PART], steps[3 * PART];
    unsigned char settled[3 * PART]; /* codes that stay the same, whatever the row */
    size_t moving, at[PART];         /* pixels of which some do not */
} lines;

static bool find_lines(const repeat *r, const columns *c, size_t rows, lines *l)
{
    const size_t bytes = 3 * c->count;
    const float share = 1.0f / (float)(rows - 1);
    unsigned char moves[3 * PART];
    if (!compute(r, c, 0, l->codes) || !compute(r, c, rows - 1, l->steps))
        return false;
    for (size_t i = 0; i < bytes; i++) {
        const int32_t a = l->codes[i], b = l->steps[i], low = a < b ? a : b, high = a < b ? b : a;
        l->settled[i] = (unsigned char)((low - MARGIN) >> FRACTION);
        moves[i] = (low - MARGIN) >> FRACTION != (high + MARGIN) >> FRACTION;
        l->steps[i] = (int32_t)((float)(b - a) * share);
    }
    l->moving = 0;
    for (size_t i = 0; i < c->count; i++) {
        l->at[l->moving] = i;
        l->moving += (moves[3 * i] | moves[3 * i + 1] | moves[3 * i + 2]) != 0;
    }
    memcpy(l->texels, c->pixels, bytes);
    return true;
}

/* The codes of pixel i in row y; false if they are open. */
static bool follow(const lines *l, size_t i, int32_t y, int32_t last, unsigned char *out)
{
    for (size_t k = 3 * i; k < 3 * i + 3; k++) {
        const int32_t code = l->codes[k] + y * l->steps[k], change = last * l->steps[k];
        if (((code + MARGIN) & (ONE - 1)) < 2 * MARGIN || change > STEEP || change < -STEEP)
            return false;
        *out++ = (unsigned char)(code >> FRACTION);
    }
    return true;
}

static void correct_row(repeat *r, const columns *c, const lines *l, size_t y, size_t last)
{
    const size_t bytes = 3 * c->count;
    const float *light = c->light + y * c->light_step;
    unsigned char *row = c->pixels + y * c->row_bytes, own[3 * PART];
    const bool differs = memcmp(row, l->texels, bytes) != 0;
    memcpy(own, row, bytes);
    memcpy(row, l->settled, bytes);
    for (size_t k = 0; k < l->moving; k++) {
        const size_t i = l->at[k];
        const bool is_other = differs && memcmp(own + 3 * i, l->texels + 3 * i, 3) != 0;
        if (!is_other && !follow(l, i, (int32_t)y, (int32_t)last, row + 3 * i))
            wait(r, own + 3 * i, light[i], row + 3 * i);
    }
    for (size_t i = 0; differs && i < c->count; i++)
        if (memcmp(own + 3 * i, l->texels + 3 * i, 3) != 0)
            wait(r, own + 3 * i, light[i], row + 3 * i);
}

/* So many rows that repeat. False if nothing was done. */
static bool correct_rows(repeat *r, const columns *c, size_t rows)
{
    lines l;
    if (!find_lines(r, c, rows, &l))
        return false;
    r->stats->pixels += c->count * rows;
    for (size_t y = 0; y < rows; y++)
        correct_row(r, c, &l, y, rows - 1);
    return true;
}

/* What repeats in one part of the rows of a band. */
static void correct_part(repeat *r, const illuminance_rows *light, const pipeline_band *band,
                         size_t part)
{
    const size_t x = part * PART;
    columns c = {.count = r->width - x < PART ? r->width - x : PART,
                 .row_bytes = 3 * r->width,
                 .light_step = r->width};
    for (size_t y = 0, rows; y < band->rows; y += rows) {
        const size_t left = band->rows - y < ROWS_MAX ? band->rows - y : ROWS_MAX;
        c.pixels = band->pixels + y * c.row_bytes + 3 * x;
        c.light = r->light + y * r->width + x;
        rows = find_repeats(r, light, band->first + y, &c, left);
        if (rows > 0 && correct_rows(r, &c, rows))
            for (size_t i = y; i < y + rows; i++)
                r->done[i * r->parts + part] = 1;
        if (rows == 0)
            rows = 1;
    }
}

/* What does not repeat in row y of a band. */
static void correct_others(repeat *r, const pipeline_band *band, size_t y)
{
    const unsigned char *done = r->done + y * r->parts;
    for (size_t begin = 0, end; begin < r->parts; begin = end + 1) {
        for (end = begin; end < r->parts && !done[end];)
            end++;
        const size_t x = begin * PART, stop = end < r->parts ? end * PART : r->width;
        unsigned char *pixels = band->pixels + 3 * (y * r->width + x);
        if (end > begin)
            lcor_correct_row(r->plan, band->first + y, stop - x, pixels,
                             r->light + y * r->width + x, NULL, pixels, r->stats);
    }
}

/* Does anything repeat in a band? */
static bool is_worth_it(const repeat *r, const pipeline_band *band)
{
    const size_t row_bytes = 3 * r->width, over = ROWS_MIN - 1;
    for (size_t y = 0; y + over < band->rows; y += over)
        for (size_t at = 0; at < row_bytes; at += 3 * PART) {
            const unsigned char *p = band->pixels + y * row_bytes + at;
            const size_t bytes = row_bytes - at < 3 * PART ? row_bytes - at : 3 * PART;
            if (are_alike(p, p + over * row_bytes, bytes))
                return true;
        }
    return false;
}

/* Row after row: all rows at once would fill the cache for nothing. */
static bool correct_plainly(repeat *r, illuminance_rows *light, const pipeline_band *band)
{
    for (size_t y = 0; y < band->rows; y++) {
        unsigned char *pixels = band->pixels + y * 3 * r->width;
        if (!illuminance_row(light, band->first + y, r->light))
            return false;
        lcor_correct_row(r->plan, band->first + y, r->width, pixels, r->light, NULL, pixels,
                         r->stats);
    }
    return true;
}

bool repeat_correct(repeat *r, illuminance_rows *light, const pipeline_band *band)
{
    if (!is_worth_it(r, band))
        return correct_plainly(r, light, band);
    for (size_t y = 0; y < band->rows; y++)
        if (!illuminance_row(light, band->first + y, r->light + y * r->width))
            return false;
    memset(r->done, 0, band->rows * r->parts);
    for (size_t part = 0; part < r->parts; part++)
        correct_part(r, light, band, part);
    correct_waiting(r);
    for (size_t y = 0; y < band->rows; y++)
        correct_others(r, band, y);
    return true;
}
