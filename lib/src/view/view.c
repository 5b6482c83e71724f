/* SPDX-License-Identifier: MIT */
#include "view/internal.h"

#include "base/internal.h"
#include "geometry/vec.h"
#include "scene/scene_internal.h"

enum { LINES_DEFAULT = 8 };

static lcor_status scan_row(lcor_view *view, view_scan *scan, lcor_array *found, lcor_array *pieces,
                            size_t lines, size_t y, lcor_error *err)
{
    size_t starts[VIEW_LINES_MAX + 1];
    lcor_status status = LCOR_OK;

    found->count = 0;
    starts[0] = 0;
    for (size_t s = 0; s < lines && status == LCOR_OK; s++) {
        const double place = (double)y + ((double)s + 0.5) / (double)lines;

        status = view_scan_line(scan, place, found, err);
        starts[s + 1] = found->count;
    }
    if (status == LCOR_OK)
        status = view_merge_row(view, pieces, lines, found->items, starts, err);
    return status;
}

static lcor_status scan_rows(lcor_view *view, size_t lines, lcor_error *err)
{
    lcor_array found = {0}, pieces = {0};
    view_scan scan;
    lcor_status status = view_scan_init(&scan, view, err);

    if (status != LCOR_OK)
        return status;
    view->rows[0] = 0;
    for (size_t y = 0; y < view->camera.size_y && status == LCOR_OK; y++) {
        status = scan_row(view, &scan, &found, &pieces, lines, y, err);
        view->rows[y + 1] = view->spans.count;
    }
    lcor_array_clear(&view->allocator, &found);
    lcor_array_clear(&view->allocator, &pieces);
    view_scan_free(&scan);
    return status;
}

static lcor_status fill(lcor_view *view, size_t lines, lcor_error *err)
{
    lcor_status status;

    view->rows =
        lcor_internal_alloc(&view->allocator, (view->camera.size_y + 1) * sizeof *view->rows);
    view->surfaces =
        lcor_internal_alloc(&view->allocator, view->surface_count * sizeof *view->surfaces);
    if (!view->rows || !view->surfaces)
        return lcor_internal_fail(err, LCOR_ERR_NOMEM, -1, "no memory for the view");
    status = view_project(view, err);
    if (status == LCOR_OK)
        status = scan_rows(view, lines, err);
    lcor_array_clear(&view->allocator, &view->corners); /* only scanning needs them */
    return status;
}

lcor_status lcor_view_new(const lcor_scene *scene, const lcor_camera *camera,
                          const lcor_view_options *options, lcor_view **out, lcor_error *err)
{
    const lcor_view_options plain = {.struct_size = sizeof plain};
    lcor_allocator allocator;
    lcor_view *view;
    size_t bytes;
    lcor_status status;

    if (!options)
        options = &plain;
    if (!scene || !out || !scene->committed)
        return lcor_internal_fail(err, LCOR_ERR_ARG, -1, "a view needs a committed scene");
    if (options->struct_size == 0 || options->lines < 0 || options->lines > VIEW_LINES_MAX)
        return lcor_internal_fail(err, LCOR_ERR_ARG, -1,
                                  "view options: struct_size unset, or lines not 0 to %d",
                                  VIEW_LINES_MAX);
    status = lcor_camera_check(camera, err);
    if (status == LCOR_OK)
        status = lcor_internal_allocator(&options->allocator, &allocator, err);
    if (status != LCOR_OK)
        return status;
    if (!lcor_internal_size_mul(lcor_scene_surface_count(scene), sizeof(view_surface), &bytes))
        return lcor_internal_fail(err, LCOR_ERR_NOMEM, -1, "too many surfaces");
    view = lcor_internal_alloc(&allocator, sizeof *view);
    if (!view)
        return lcor_internal_fail(err, LCOR_ERR_NOMEM, -1, "no memory for the view");
    *view = (lcor_view){.allocator = allocator,
                        .scene = scene,
                        .camera = *camera,
                        .cull_back = options->cull_back,
                        .surface_count = lcor_scene_surface_count(scene)};
    status = fill(view, options->lines ? (size_t)options->lines : LINES_DEFAULT, err);
    view->cull_back = NULL;
    if (status == LCOR_OK)
        *out = view;
    else
        lcor_view_free(view);
    return status;
}

void lcor_view_free(lcor_view *view)
{
    lcor_allocator allocator;

    if (!view)
        return;
    allocator = view->allocator;
    lcor_array_clear(&allocator, &view->corners);
    lcor_array_clear(&allocator, &view->spans);
    lcor_internal_free(&allocator, view->rows);
    lcor_internal_free(&allocator, view->surfaces);
    lcor_internal_free(&allocator, view);
}

const lcor_span *lcor_view_row(const lcor_view *view, size_t y, size_t *count)
{
    *count = view->rows[y + 1] - view->rows[y];
    return (const lcor_span *)view->spans.items + view->rows[y];
}

void lcor_view_places(const lcor_view *view, size_t y, const lcor_span *span, size_t x, size_t n,
                      lcor_place *places)
{
    const view_surface *s = &view->surfaces[span->surface];
    const double py = (double)y + (double)span->at[1];

    for (size_t i = 0; i < n; i++) {
        const double px = (double)(x + i) + (double)span->at[0];
        const double depth_w = 1 / linear_at(&s->w, px, py);
        const double u = linear_at(&s->u, px, py) * depth_w;
        const double v = linear_at(&s->v, px, py) * depth_w;

        /* (f / w)' = (f' - (f / w) w') / w */
        places[i] = (lcor_place){
            .uv = {u, v},
            .du = {(s->u.c[1] - u * s->w.c[1]) * depth_w, (s->u.c[2] - u * s->w.c[2]) * depth_w},
            .dv = {(s->v.c[1] - v * s->w.c[1]) * depth_w, (s->v.c[2] - v * s->w.c[2]) * depth_w},
            .depth = linear_at(&s->depth, px, py) * depth_w};
    }
}

int lcor_view_normal(const lcor_view *view, size_t surface, double normal[3])
{
    vec_copy(view->surfaces[surface].normal, normal);
    return view->surfaces[surface].front;
}
