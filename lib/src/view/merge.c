/* SPDX-License-Identifier: MIT */
/* From lines to pixels: runs that one surface covers on every line become one span, all other
 * pixels are taken apart into pieces. */
#include "view/internal.h"

#include "base/internal.h"

#include <math.h>

/* Pieces smaller than this part of a pixel are rounding at shared edges. */
#define COVERAGE_MIN 1e-5

/* What one surface covers of a pixel, in lines * pixels, and its moments. */
typedef struct piece {
    size_t surface;
    double coverage, x, y;
} piece;

/* The lists of line_spans of a row's lines; each next[s] moves on with the pixel. */
typedef struct row_lines {
    size_t count;
    const line_span *next[VIEW_LINES_MAX], *end[VIEW_LINES_MAX];
} row_lines;

static void skip_to(row_lines *lines, double x)
{
    for (size_t s = 0; s < lines->count; s++)
        while (lines->next[s] < lines->end[s] && lines->next[s]->x1 <= x)
            lines->next[s]++;
}

/* The pixel behind the last one from x on that the same surface covers wholly on all lines; x if
 * there is none. */
static size_t whole_until(const row_lines *lines, size_t x, size_t *surface)
{
    double until = HUGE_VAL;
    size_t s = 0;

    do { /* a row has one line at least */
        const line_span *span = lines->next[s];

        if (span == lines->end[s] || span->x0 > (double)x ||
            span->surface != lines->next[0]->surface)
            return x;
        until = fmin(until, span->x1);
    } while (++s < lines->count);
    *surface = lines->next[0]->surface;
    return (size_t)until;
}

/* The first pixel from x on in which any line has a surface; `size` if none. */
static size_t next_seen(const row_lines *lines, size_t x, size_t size)
{
    double nearest = (double)size;

    for (size_t s = 0; s < lines->count; s++)
        if (lines->next[s] < lines->end[s])
            nearest = fmin(nearest, lines->next[s]->x0);
    return nearest > (double)x ? (size_t)nearest : x;
}

static lcor_status add_piece(lcor_view *view, lcor_array *pieces, size_t surface, double length,
                             double x, double y, lcor_error *err)
{
    piece *p = pieces->items, *end = p + pieces->count;

    while (p < end && p->surface != surface)
        p++;
    if (p == end) {
        p = lcor_array_reserve(&view->allocator, pieces, 1, sizeof *p);
        if (!p)
            return lcor_internal_fail(err, LCOR_ERR_NOMEM, -1, "no memory for the view's spans");
        *p = (piece){.surface = surface};
        pieces->count++;
    }
    p->coverage += length;
    p->x += length * x;
    p->y += length * y;
    return LCOR_OK;
}

static lcor_status collect(lcor_view *view, const row_lines *lines, size_t x, lcor_array *pieces,
                           lcor_error *err)
{
    const double left = (double)x, right = left + 1;

    pieces->count = 0;
    for (size_t s = 0; s < lines->count; s++) {
        const double y = ((double)s + 0.5) / (double)lines->count;

        for (const line_span *span = lines->next[s]; span < lines->end[s] && span->x0 < right;
             span++) {
            const double x0 = fmax(span->x0, left), x1 = fmin(span->x1, right);
            lcor_status status;

            status = add_piece(view, pieces, span->surface, x1 - x0, (x0 + x1) / 2 - left, y, err);
            if (status != LCOR_OK)
                return status;
        }
    }
    return LCOR_OK;
}

static void sort_pieces(lcor_array *pieces)
{
    piece *p = pieces->items;

    for (size_t i = 1; i < pieces->count; i++) {
        const piece moved = p[i];
        size_t at = i;

        for (; at > 0 &&
               (p[at - 1].coverage < moved.coverage ||
                (p[at - 1].coverage == moved.coverage && p[at - 1].surface > moved.surface));
             at--)
            p[at] = p[at - 1];
        p[at] = moved;
    }
}

static lcor_status add_span(lcor_view *view, const lcor_span *span, lcor_error *err)
{
    lcor_span *out = lcor_array_reserve(&view->allocator, &view->spans, 1, sizeof *out);

    if (!out)
        return lcor_internal_fail(err, LCOR_ERR_NOMEM, -1, "no memory for the view's spans");
    *out = *span;
    view->spans.count++;
    return LCOR_OK;
}

static lcor_status add_pieces(lcor_view *view, lcor_array *pieces, size_t lines, size_t x,
                              lcor_error *err)
{
    const piece *p = pieces->items;

    sort_pieces(pieces);
    for (size_t i = 0; i < pieces->count; i++) {
        const double coverage = p[i].coverage / (double)lines;
        const lcor_span span = {
            .surface = p[i].surface,
            .x0 = (uint32_t)x,
            .x1 = (uint32_t)x + 1,
            .coverage = (float)fmin(coverage, 1),
            .at = {(float)(p[i].x / p[i].coverage), (float)(p[i].y / p[i].coverage)}};
        lcor_status status;

        if (!(coverage >= COVERAGE_MIN))
            continue;
        status = add_span(view, &span, err);
        if (status != LCOR_OK)
            return status;
    }
    return LCOR_OK;
}

lcor_status view_merge_row(lcor_view *view, lcor_array *pieces, size_t lines,
                           const line_span *spans, const size_t *starts, lcor_error *err)
{
    const size_t size = view->camera.size_x;
    row_lines at = {.count = lines};
    size_t x = 0;
    lcor_status status = LCOR_OK;

    for (size_t s = 0; s < lines; s++) {
        at.next[s] = spans + starts[s];
        at.end[s] = spans + starts[s + 1];
    }
    while (status == LCOR_OK) {
        size_t surface = 0, until;

        skip_to(&at, (double)x);
        x = next_seen(&at, x, size);
        if (x >= size)
            return LCOR_OK;
        until = whole_until(&at, x, &surface);
        if (until > x) {
            const lcor_span whole = {.surface = surface,
                                     .x0 = (uint32_t)x,
                                     .x1 = (uint32_t)until,
                                     .coverage = 1,
                                     .at = {0.5F, 0.5F}};

            status = add_span(view, &whole, err);
            x = until;
        } else {
            status = collect(view, &at, x, pieces, err);
            if (status == LCOR_OK)
                status = add_pieces(view, pieces, lines, x, err);
            x++;
        }
    }
    return status;
}
