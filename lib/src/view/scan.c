/* SPDX-License-Identifier: MIT */
/* Hidden surfaces along horizontal lines: a sweep over the ends of the surfaces' runs, and between
 * two ends the upper envelope of their nearness, which is linear along a line. */
#include "view/internal.h"

#include "base/internal.h"

#include <math.h>
#include <stdlib.h>

/* Nearness that differs by less, relative, is a tie: the surfaces touch or coincide. */
#define TIE 1e-11

/* A surface along the current line: seen over x0..x1, nearness base + slope x. */
typedef struct scan_run {
    size_t surface;
    double x0, x1;
    double base, slope;
} scan_run;

typedef struct keyed {
    double y_min;
    size_t surface;
} keyed;

static int by_y_min(const void *a, const void *b)
{
    const keyed *ka = a, *kb = b;

    if (ka->y_min != kb->y_min)
        return ka->y_min < kb->y_min ? -1 : 1;
    return ka->surface < kb->surface ? -1 : ka->surface > kb->surface;
}

/* Surfaces that may be seen, topmost first. */
static lcor_status sort_surfaces(view_scan *scan, lcor_error *err)
{
    const lcor_view *view = scan->view;
    keyed *keys = lcor_internal_alloc(&view->allocator, view->surface_count * sizeof *keys);
    size_t count = 0;

    if (!keys)
        return lcor_internal_fail(err, LCOR_ERR_NOMEM, -1, "no memory for the view");
    for (size_t id = 0; id < view->surface_count; id++) {
        const view_surface *s = &view->surfaces[id];

        if (s->y_min < s->y_max && s->y_max > 0 && s->y_min < (double)view->camera.size_y) {
            keys[count].y_min = s->y_min;
            keys[count++].surface = id;
        }
    }
    qsort(keys, count, sizeof *keys, by_y_min);
    for (size_t i = 0; i < count; i++)
        scan->order[i] = keys[i].surface;
    scan->order_count = count;
    lcor_internal_free(&view->allocator, keys);
    return LCOR_OK;
}

lcor_status view_scan_init(view_scan *scan, const lcor_view *view, lcor_error *err)
{
    const lcor_allocator *allocator = &view->allocator;
    const size_t n = view->surface_count; /* memory for n larger structures stands */
    lcor_status status;

    *scan = (view_scan){.view = view};
    scan->order = lcor_internal_alloc(allocator, n * sizeof *scan->order);
    scan->active = lcor_internal_alloc(allocator, n * sizeof *scan->active);
    scan->live = lcor_internal_alloc(allocator, n * sizeof(struct scan_run *));
    if (scan->order && scan->active && scan->live)
        status = sort_surfaces(scan, err);
    else
        status = lcor_internal_fail(err, LCOR_ERR_NOMEM, -1, "no memory for the view");
    if (status != LCOR_OK)
        view_scan_free(scan);
    return status;
}

void view_scan_free(view_scan *scan)
{
    const lcor_allocator *allocator = &scan->view->allocator;

    lcor_internal_free(allocator, scan->order);
    lcor_internal_free(allocator, scan->active);
    lcor_internal_free(allocator, scan->live);
    scan->order = NULL;
    scan->active = NULL;
    scan->live = NULL;
}

/* Where the line y enters and leaves the convex outline; x0 >= x1 if it misses the picture. */
static void cut_outline(const lcor_view *view, const view_surface *s, double y, scan_run *run)
{
    const double(*corners)[2] = (const double(*)[2])view->corners.items + s->first;
    const double width = (double)view->camera.size_x;
    double x0 = HUGE_VAL, x1 = -HUGE_VAL;

    for (size_t i = 0; i < s->count; i++) {
        const double *a = corners[i], *b = corners[i + 1 < s->count ? i + 1 : 0];
        const double *top = a[1] < b[1] ? a : b, *low = a[1] < b[1] ? b : a;
        double x;

        if (!(top[1] <= y && y < low[1]))
            continue;
        /* from the upper end in either winding, so that neighbours get the same edge */
        x = top[0] + (y - top[1]) * ((low[0] - top[0]) / (low[1] - top[1]));
        x0 = fmin(x0, x);
        x1 = fmax(x1, x);
    }
    run->x0 = fmin(fmax(x0, 0), width);
    run->x1 = fmin(fmax(x1, 0), width);
}

static void set_run(const lcor_view *view, double y, scan_run *run)
{
    const view_surface *s = &view->surfaces[run->surface];

    cut_outline(view, s, y, run);
    run->base = s->nearness.c[0] + s->nearness.c[2] * y;
    run->slope = s->nearness.c[1];
}

/* Brings the active runs to line y, ordered by x0. Lines follow closely, so the order hardly
 * changes and insertion is quick. */
static void advance(view_scan *scan, double y)
{
    const lcor_view *view = scan->view;
    size_t count = 0;

    while (scan->next < scan->order_count && view->surfaces[scan->order[scan->next]].y_min <= y)
        scan->active[scan->active_count++].surface = scan->order[scan->next++];
    for (size_t i = 0; i < scan->active_count; i++) {
        scan_run run = scan->active[i];
        size_t at = count;

        if (view->surfaces[run.surface].y_max <= y)
            continue;
        set_run(view, y, &run);
        for (; at > 0 && scan->active[at - 1].x0 > run.x0; at--)
            scan->active[at] = scan->active[at - 1];
        scan->active[at] = run;
        count++;
    }
    scan->active_count = count;
}

static double nearness_at(const scan_run *run, double x) { return run->base + run->slope * x; }

/* > 0: a is nearer at x; 0: a tie. */
static double nearer_by(const scan_run *a, const scan_run *b, double x)
{
    const double na = nearness_at(a, x), nb = nearness_at(b, x);

    return fabs(na - nb) <= TIE * fmax(fabs(na), fabs(nb)) ? 0 : na - nb;
}

/* Whether a is seen rather than b just right of xa, as far as xb tells. */
static int seen_first(const scan_run *a, const scan_run *b, double xa, double xb)
{
    double by = nearer_by(a, b, xa);

    if (by == 0)
        by = nearer_by(a, b, xb);
    return by > 0 || (by == 0 && a->surface < b->surface);
}

static lcor_status append(const view_scan *scan, double x0, double x1, size_t surface,
                          lcor_array *out, size_t first, lcor_error *err)
{
    line_span *last = (line_span *)out->items + out->count;

    if (!(x1 > x0))
        return LCOR_OK;
    if (out->count > first && last[-1].surface == surface && last[-1].x1 == x0) {
        last[-1].x1 = x1;
        return LCOR_OK;
    }
    last = lcor_array_reserve(&scan->view->allocator, out, 1, sizeof *last);
    if (!last)
        return lcor_internal_fail(err, LCOR_ERR_NOMEM, -1, "no memory for the view's spans");
    *last = (line_span){x0, x1, surface};
    out->count++;
    return LCOR_OK;
}

/* The nearest of n runs that all cover xa..xb: starts with the nearest at xa and changes where
 * another one comes through it. Each change is to a run nearer at xb, so it ends. */
static lcor_status envelope(const view_scan *scan, size_t n, double xa, double xb, lcor_array *out,
                            size_t first, lcor_error *err)
{
    const scan_run *seen = scan->live[0];
    double x = xa;

    for (size_t i = 1; i < n; i++)
        if (seen_first(scan->live[i], seen, xa, xb))
            seen = scan->live[i];
    for (;;) {
        const scan_run *through = NULL;
        double where = xb;
        lcor_status status;

        for (size_t i = 0; i < n; i++) {
            const scan_run *run = scan->live[i];
            double behind, ahead, cross;

            if (!(nearer_by(run, seen, xb) > 0))
                continue;
            behind = nearness_at(seen, x) - nearness_at(run, x);
            ahead = nearness_at(run, xb) - nearness_at(seen, xb);
            cross = behind > 0 ? x + (xb - x) * (behind / (behind + ahead)) : x;
            if (cross < where || (through && cross == where && run->slope > through->slope)) {
                where = cross;
                through = run;
            }
        }
        status = append(scan, x, where, seen->surface, out, first, err);
        if (!through || status != LCOR_OK)
            return status;
        seen = through;
        x = where;
    }
}

lcor_status view_scan_line(view_scan *scan, double y, lcor_array *out, lcor_error *err)
{
    const size_t first = out->count;
    size_t next = 0, live = 0;
    double x = 0;

    advance(scan, y);
    for (;;) {
        double until = HUGE_VAL;
        size_t kept = 0;
        lcor_status status;

        for (size_t i = 0; i < live; i++)
            if (scan->live[i]->x1 > x)
                scan->live[kept++] = scan->live[i];
        live = kept;
        if (live == 0) {
            if (next == scan->active_count)
                return LCOR_OK;
            x = fmax(x, scan->active[next].x0);
        }
        for (; next < scan->active_count && scan->active[next].x0 <= x; next++)
            if (scan->active[next].x1 > x)
                scan->live[live++] = &scan->active[next];
        if (live == 0)
            continue;
        for (size_t i = 0; i < live; i++)
            until = fmin(until, scan->live[i]->x1);
        if (next < scan->active_count)
            until = fmin(until, scan->active[next].x0);
        status = envelope(scan, live, x, until, out, first, err);
        if (status != LCOR_OK)
            return status;
        x = until;
    }
}
