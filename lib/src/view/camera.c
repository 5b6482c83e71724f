/* SPDX-License-Identifier: MIT */
#include "view/internal.h"

#include "base/internal.h"
#include "geometry/vec.h"

#include <math.h>

enum { SIZE_MAX_SIDE = 65535 };

static const double pi = 3.14159265358979323846;

static int finite3(const double a[3]) { return isfinite(a[0]) && isfinite(a[1]) && isfinite(a[2]); }

lcor_status lcor_camera_check(const lcor_camera *camera, lcor_error *err)
{
    const char *bad = NULL;
    camera_frame frame;

    if (!camera)
        return lcor_internal_fail(err, LCOR_ERR_ARG, -1, "camera is missing");
    if (camera->size_x < 1 || camera->size_x > SIZE_MAX_SIDE || camera->size_y < 1 ||
        camera->size_y > SIZE_MAX_SIDE)
        bad = "picture sides must be 1 to 65535 pixels";
    else if (!finite3(camera->position) || !finite3(camera->forward) || !finite3(camera->up))
        bad = "position, forward and up must be finite";
    else if (!(camera->fov_y >= 0 && camera->fov_y < pi))
        bad = "fov_y must lie between 0 and pi";
    else if (camera->fov_y == 0 && !(camera->height > 0 && isfinite(camera->height)))
        bad = "an orthographic camera needs a height > 0";
    else if (!(camera->z_near >= 0 && camera->z_far >= 0 && isfinite(camera->z_near)) ||
             isnan(camera->z_far) || (camera->z_far > 0 && camera->z_far <= camera->z_near))
        bad = "clip distances must be 0 <= z_near < z_far (0 = none)";
    if (!bad) {
        camera_frame_set(camera, &frame);
        if (vec_length(frame.forward) == 0 || vec_length(frame.right) == 0)
            bad = "forward and up must have a length and not be parallel";
    }
    if (bad)
        return lcor_internal_fail(err, LCOR_ERR_DOMAIN, -1, "camera: %s", bad);
    return LCOR_OK;
}

void camera_frame_set(const lcor_camera *camera, camera_frame *frame)
{
    double up[3];

    vec_copy(camera->position, frame->position);
    vec_copy(camera->forward, frame->forward);
    vec_copy(camera->up, up);
    vec_normalize(frame->forward);
    vec_normalize(up);
    vec_cross(frame->forward, up, frame->right);
    /* the sine of the angle between them: less is rounding, not a direction */
    if (vec_length(frame->right) < 1e-9)
        frame->right[0] = frame->right[1] = frame->right[2] = 0;
    vec_normalize(frame->right);
    vec_cross(frame->forward, frame->right, frame->down);
    frame->perspective = camera->fov_y > 0;
    frame->pixel =
        (frame->perspective ? 2 * tan(camera->fov_y / 2) : camera->height) / (double)camera->size_y;
    frame->centre[0] = (double)camera->size_x / 2;
    frame->centre[1] = (double)camera->size_y / 2;
}

void lcor_camera_ray(const lcor_camera *camera, double x, double y, double origin[3],
                     double direction[3])
{
    camera_frame frame;
    double *moved; /* what depends on the place: direction in perspective, else origin */

    camera_frame_set(camera, &frame);
    vec_copy(frame.position, origin);
    vec_copy(frame.forward, direction);
    moved = frame.perspective ? direction : origin;
    vec_add_scaled(moved, (x - frame.centre[0]) * frame.pixel, frame.right, moved);
    vec_add_scaled(moved, (y - frame.centre[1]) * frame.pixel, frame.down, moved);
    vec_normalize(direction);
}
