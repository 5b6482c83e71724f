/* SPDX-License-Identifier: MIT */
/* The view as project.c prepares it, scan.c and merge.c fill it and the public calls read it. */
#ifndef LCOR_VIEW_INTERNAL_H
#define LCOR_VIEW_INTERNAL_H

#include "base/array.h"

#include <lcor/view.h>

/* A camera made orthonormal: the ray through picture place (x, y) starts at `position` (+ the
 * linear part when orthographic) and goes along `forward` (+ the linear part when perspective). */
typedef struct camera_frame {
    double position[3], right[3], down[3], forward[3];
    double pixel;     /* size of a pixel: at depth 1, or in scene units when orthographic */
    double centre[2]; /* of the picture, in pixels */
    int perspective;
} camera_frame;

void camera_frame_set(const lcor_camera *camera, camera_frame *frame);

/* c[0] + c[1] x + c[2] y over the picture */
typedef struct linear {
    double c[3];
} linear;

static inline double linear_at(const linear *f, double x, double y)
{
    return f->c[0] + f->c[1] * x + f->c[2] * y;
}

/* One surface as the camera sees it. On a plane u, v and depth are quotients of functions linear
 * in the picture: u / w, v / w, depth / w, with w = 1 / depth and depth = 1 in perspective,
 * w = 1 when orthographic. */
typedef struct view_surface {
    linear u, v, w, depth;
    linear nearness; /* larger is nearer: w in perspective, -depth when orthographic */
    double normal[3];
    int front;
    double y_min, y_max; /* rows it may be seen in; y_min >= y_max: none */
    size_t first, count; /* its clipped corners in the picture */
} view_surface;

enum { VIEW_LINES_MAX = 64 };

/* Part x0..x1 of a horizontal line on which one surface is seen. */
typedef struct line_span {
    double x0, x1;
    size_t surface;
} line_span;

struct lcor_view {
    lcor_allocator allocator;
    const lcor_scene *scene;
    lcor_camera camera;
    view_surface *surfaces;
    size_t surface_count;
    const unsigned char *cull_back; /* the caller's, while surfaces are projected */
    lcor_array corners;             /* double[2] */
    lcor_array spans;               /* lcor_span */
    size_t *rows;                   /* size_y + 1 places in spans */
};

/* project.c: fills view->surfaces and view->corners. */
lcor_status view_project(lcor_view *view, lcor_error *err);

/* scan.c: visible line_spans of the lines y, which must come in rising order. */
typedef struct view_scan {
    const lcor_view *view;
    size_t *order; /* surfaces by y_min */
    size_t order_count, next;
    struct scan_run *active; /* surfaces that the line meets, by x0 */
    size_t active_count;
    struct scan_run **live; /* those at the place of the sweep */
} view_scan;

lcor_status view_scan_init(view_scan *scan, const lcor_view *view, lcor_error *err);
void view_scan_free(view_scan *scan);
/* Appends to `out`; LCOR_ERR_NOMEM. */
lcor_status view_scan_line(view_scan *scan, double y, lcor_array *out, lcor_error *err);

/* merge.c: the spans of a pixel row from `lines` lists of line_spans, list s at
 * spans[starts[s]] .. spans[starts[s + 1]]; appends to view->spans. `pieces` is
 * room that is used again from row to row. */
lcor_status view_merge_row(lcor_view *view, lcor_array *pieces, size_t lines,
                           const line_span *spans, const size_t *starts, lcor_error *err);

#endif
