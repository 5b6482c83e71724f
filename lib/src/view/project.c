/* SPDX-License-Identifier: MIT */
/* Surfaces as the camera sees them: clipped outlines, and u, v and depth over the picture. */
#include "view/internal.h"

#include "base/internal.h"
#include "geometry/vec.h"
#include "scene/scene_internal.h"

#include <float.h>
#include <math.h>

/* Depths this small a part of the farthest corner are clipped where the camera asks for no near
 * plane: what passes through the eye has no picture. */
#define NEAR_PART 1e-9

/* f(point) = g . (point - origin) along the ray of place (x, y): in perspective, for direction
 * d(x, y) and eye e, f w = g . (e - origin) w + g . d; orthographic f = g . (e(x, y) - origin) +
 * depth g . forward. Both are linear in x, y. */
static linear across_plane(const camera_frame *frame, const double g[3], const double origin[3],
                           const view_surface *surface)
{
    const double along[2] = {frame->pixel * vec_dot(g, frame->right),
                             frame->pixel * vec_dot(g, frame->down)};
    const double ahead = vec_dot(g, frame->forward);
    double eye[3], from_eye;
    linear f;

    vec_sub(frame->position, origin, eye);
    from_eye = vec_dot(g, eye);
    for (int k = 0; k < 3; k++)
        f.c[k] = frame->perspective ? from_eye * surface->w.c[k] : ahead * surface->depth.c[k];
    f.c[0] += frame->perspective ? ahead : from_eye;
    f.c[0] -= along[0] * frame->centre[0] + along[1] * frame->centre[1];
    f.c[1] += along[0];
    f.c[2] += along[1];
    return f;
}

/* w and depth of the plane through `origin` with a unit normal; 0 if it is seen edge-on. */
static int set_depth(const camera_frame *frame, const double origin[3], double scale,
                     view_surface *s)
{
    const double across[2] = {frame->pixel * vec_dot(s->normal, frame->right),
                              frame->pixel * vec_dot(s->normal, frame->down)};
    const double ahead = vec_dot(s->normal, frame->forward);
    const double one[3] = {1, 0, 0};
    double to_plane[3], distance, turn;
    linear f; /* perspective: normal . d; orthographic: distance of the plane */

    vec_sub(origin, frame->position, to_plane);
    distance = vec_dot(s->normal, to_plane);
    turn = frame->perspective ? distance : ahead;
    if (fabs(turn) <= (frame->perspective ? 1e-14 * scale : 1e-14))
        return 0;
    f.c[0] = frame->perspective ? ahead : distance;
    f.c[1] = frame->perspective ? across[0] : -across[0];
    f.c[2] = frame->perspective ? across[1] : -across[1];
    f.c[0] -= f.c[1] * frame->centre[0] + f.c[2] * frame->centre[1];
    for (int k = 0; k < 3; k++) {
        s->w.c[k] = frame->perspective ? f.c[k] / turn : one[k];
        s->depth.c[k] = frame->perspective ? one[k] : f.c[k] / turn;
        s->nearness.c[k] = frame->perspective ? s->w.c[k] : -s->depth.c[k];
    }
    s->front = turn < 0;
    return 1;
}

/* The vectors with g_u . e_u = 1, g_u . e_v = 0 and the reverse, in the plane of the edges. */
static void dual_basis(const double e_u[3], const double e_v[3], double g_u[3], double g_v[3])
{
    double normal[3], square;

    vec_cross(e_u, e_v, normal);
    square = vec_dot(normal, normal);
    vec_cross(e_v, normal, g_u);
    vec_cross(normal, e_u, g_v);
    for (int k = 0; k < 3; k++) {
        g_u[k] /= square;
        g_v[k] /= square;
    }
}

/* Right, down and depth of a point in the camera's frame. */
static void to_camera(const camera_frame *frame, const double point[3], double out[3])
{
    double from_eye[3];

    vec_sub(point, frame->position, from_eye);
    out[0] = vec_dot(from_eye, frame->right);
    out[1] = vec_dot(from_eye, frame->down);
    out[2] = vec_dot(from_eye, frame->forward);
}

/* Cuts the polygon of n corners by sign * (depth - limit) >= 0; `out` has room for n + 1. */
static size_t clip_depth(size_t n, double (*corners)[3], double limit, double sign,
                         double (*out)[3])
{
    size_t count = 0;

    for (size_t i = 0; i < n; i++) {
        const double *a = corners[i], *b = corners[(i + 1) % n];
        const double in_a = sign * (a[2] - limit), in_b = sign * (b[2] - limit);

        if (in_a >= 0)
            vec_copy(a, out[count++]);
        if ((in_a < 0) != (in_b < 0)) {
            const double t = in_a / (in_a - in_b);

            for (int k = 0; k < 3; k++)
                out[count][k] = a[k] + t * (b[k] - a[k]);
            out[count++][2] = limit;
        }
    }
    return count;
}

/* Puts the clipped outline into view->corners, in pixels. */
static lcor_status add_outline(lcor_view *view, const camera_frame *frame, size_t n,
                               double (*corners)[3], double (*work)[3], view_surface *s,
                               lcor_error *err)
{
    double(*outline)[2], scale = 0, nearest = view->camera.z_near;

    for (size_t i = 0; i < n; i++)
        scale = fmax(scale, vec_length(corners[i]));
    if (nearest == 0 && frame->perspective)
        nearest = NEAR_PART * scale;
    n = clip_depth(n, corners, nearest, 1, work);
    if (view->camera.z_far > 0)
        n = clip_depth(n, work, view->camera.z_far, -1, corners);
    else
        corners = work;
    outline = lcor_array_reserve(&view->allocator, &view->corners, n, sizeof *outline);
    if (!outline)
        return lcor_internal_fail(err, LCOR_ERR_NOMEM, -1, "no memory for the view's outlines");
    s->first = view->corners.count;
    s->count = n;
    s->y_min = DBL_MAX;
    s->y_max = -DBL_MAX;
    for (size_t i = 0; i < n; i++) {
        const double shrink = frame->pixel * (frame->perspective ? corners[i][2] : 1);

        for (int k = 0; k < 2; k++)
            outline[i][k] = frame->centre[k] + corners[i][k] / shrink;
        s->y_min = fmin(s->y_min, outline[i][1]);
        s->y_max = fmax(s->y_max, outline[i][1]);
    }
    view->corners.count += n;
    return LCOR_OK;
}

static lcor_status project(lcor_view *view, const camera_frame *frame, size_t id,
                           double (*corners)[3], double (*work)[3], lcor_error *err)
{
    view_surface *s = &view->surfaces[id];
    const scene_surface *shape = scene_surface_at(view->scene, id);
    const double *points = scene_corners(view->scene, shape);
    double g_u[3], g_v[3], scale = 0;

    vec_copy(shape->normal, s->normal);
    s->y_min = 1;
    s->y_max = 0;
    for (size_t i = 0; i < shape->corner_count; i++) {
        to_camera(frame, points + 3 * i, corners[i]);
        scale = fmax(scale, vec_length(corners[i]));
    }
    if (!set_depth(frame, shape->origin, scale, s))
        return LCOR_OK;
    if (view->cull_back && view->cull_back[id] && !s->front)
        return LCOR_OK;
    dual_basis(shape->edge_u, shape->edge_v, g_u, g_v);
    s->u = across_plane(frame, g_u, shape->origin, s);
    s->v = across_plane(frame, g_v, shape->origin, s);
    for (int k = 0; k < 3 && !s->front; k++)
        s->normal[k] = -s->normal[k];
    return add_outline(view, frame, shape->corner_count, corners, work, s, err);
}

lcor_status view_project(lcor_view *view, lcor_error *err)
{
    size_t most = 0;
    camera_frame frame;
    double(*work)[3];
    lcor_status status = LCOR_OK;

    camera_frame_set(&view->camera, &frame);
    for (size_t id = 0; id < view->surface_count; id++) {
        const size_t n = scene_surface_at(view->scene, id)->corner_count;

        most = n > most ? n : most;
    }
    /* two lists that each of the two clips may lengthen by a corner */
    work = lcor_internal_alloc(&view->allocator, 2 * (most + 2) * sizeof *work);
    if (!work)
        return lcor_internal_fail(err, LCOR_ERR_NOMEM, -1, "no memory for the view's outlines");
    for (size_t id = 0; id < view->surface_count && status == LCOR_OK; id++)
        status = project(view, &frame, id, work, work + most + 2, err);
    lcor_internal_free(&view->allocator, work);
    return status;
}
