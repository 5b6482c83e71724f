/* SPDX-License-Identifier: MIT */
/** @file
 *  What a camera sees: hidden surfaces with coverage, and the irradiance of each pixel.
 *
 *  | call                              | may run at the same time as                   |
 *  |-----------------------------------|-----------------------------------------------|
 *  | lcor_view_new, lcor_field_new     | const calls on the scene and the solution     |
 *  | calls on a const view or field    | any const calls on them                       |
 *  | *_free                            | nothing on that object                        |
 *
 *  A view refers to its scene, a field to its view and solution: free the field first. */
#ifndef LCOR_VIEW_H
#define LCOR_VIEW_H

#include <lcor/alloc.h>
#include <lcor/parallel.h>
#include <lcor/radiosity.h>
#include <lcor/scene.h>
#include <lcor/status.h>

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** A camera. Zero it and set what differs. */
typedef struct lcor_camera {
    double position[3];
    double forward[3], up[3]; /**< any length > 0, not parallel; made orthonormal */
    double fov_y;             /**< full vertical angle in radians, 0..pi; 0: orthographic */
    double height;            /**< orthographic: height of the picture in scene units, > 0 */
    double z_near, z_far;     /**< clip distances along forward; 0 = none */
    size_t size_x, size_y;    /**< pixels, 1..65535 each */
} lcor_camera;

/** Errors: LCOR_ERR_DOMAIN names the first number outside its range. */
LCOR_API lcor_status lcor_camera_check(const lcor_camera *camera, lcor_error *err);

/** Ray through a place of the picture: (0, 0) is the upper left corner, (size_x, size_y) the lower
 *  right; direction has length 1. The camera must have passed lcor_camera_check. */
LCOR_API void lcor_camera_ray(const lcor_camera *camera, double x, double y, double origin[3],
                              double direction[3]);

/** Hidden-surface solution of one picture. */
typedef struct lcor_view lcor_view;

/** Zero it, set struct_size and what differs. NULL where taken means all zeros. */
typedef struct lcor_view_options {
    size_t struct_size;
    int lines; /**< lines a pixel row for coverage, 1..64; 0 = 8 */
    /** One flag a surface, or NULL: surfaces with flag 1 are seen from their facing side only,
     *  as when one looks into a room from outside. Read by lcor_view_new only. */
    const unsigned char *cull_back;
    lcor_allocator allocator;
} lcor_view_options;

/** Find the visible surfaces of a whole picture.
 *
 *  Each pixel row is cut by equally spaced horizontal lines; along each line the nearest surfaces
 *  are found exactly, so coverage is exact in x and averaged over the lines in y. Surfaces that
 *  coincide: the one added first is seen.
 *
 *  @param scene  committed
 *
 *  Errors: LCOR_ERR_ARG scene not committed, lines; LCOR_ERR_DOMAIN camera; LCOR_ERR_NOMEM.
 *  Memory: about 32 bytes a span.  Cost: lines x size_y x surfaces met by a line. */
LCOR_API lcor_status lcor_view_new(const lcor_scene *scene, const lcor_camera *camera,
                                   const lcor_view_options *options, lcor_view **out,
                                   lcor_error *err);
LCOR_API void lcor_view_free(lcor_view *view);

/** A visible piece: pixels x0..x1-1 of a row. Either the surface covers them wholly, or it is one
 *  pixel covered in part; a pixel may then have several pieces, whose coverages sum to at most 1.
 *  Pixels in no span show no surface. */
typedef struct lcor_span {
    size_t surface;
    uint32_t x0, x1;
    float coverage; /**< part of the pixel, 0 < coverage <= 1 */
    float at[2];    /**< middle of the piece within its pixel, 0..1; (0.5, 0.5) when whole */
} lcor_span;

/** The spans of row y, 0 <= y < size_y, ordered by x0, then from the largest coverage down. */
LCOR_API const lcor_span *lcor_view_row(const lcor_view *view, size_t y, size_t *count);

/** Where a pixel's piece lies on its surface. */
typedef struct lcor_place {
    double uv[2];        /**< as lcor_hit's u and v, at the piece's middle */
    double du[2], dv[2]; /**< change of u and of v per pixel along x and y: texture filtering */
    double depth;        /**< distance along forward */
} lcor_place;

/** Places of the n pixels from column `x` of a span of row y. */
LCOR_API void lcor_view_places(const lcor_view *view, size_t y, const lcor_span *span, size_t x,
                               size_t n, lcor_place *places);

/** Unit normal of a surface towards the camera; returns 1 if that is its facing side, else 0. */
LCOR_API int lcor_view_normal(const lcor_view *view, size_t surface, double normal[3]);

/** Irradiance over what a view shows: direct light exactly for each point; indirect light
 *  interpolated on grids of the visible part of each surface, or where the solution's answers have
 *  noise (engine gather) by local regression over estimates at pixels, for which nothing that
 *  stands on a surface is looked through. */
typedef struct lcor_field lcor_field;

/** Zero it, set struct_size and what differs. */
typedef struct lcor_field_options {
    size_t struct_size;
    double tolerance;     /**< interpolation error wanted, relative to the irradiance or to 2 % of
                               the picture's mean, whichever is more; 0 = 0.001. With noise, never
                               less than the solution's own tolerance */
    uint64_t max_samples; /**< 0 = 32768. Beyond it splitting is kept to the worst places; with
                               noise, pixels far from all estimates take a quick one of their own */
    lcor_parallel parallel;
    lcor_progress progress;
    lcor_allocator allocator;
} lcor_field_options;

/** Sample the indirect irradiance until interpolation agrees with the solution.
 *
 *  A grid is doubled until its new samples agree with what the old ones predicted, or its cells
 *  are a few pixels wide. Results do not depend on options->parallel.
 *
 *  @param solution  of the view's scene
 *  Errors: LCOR_ERR_ARG, LCOR_ERR_DOMAIN options; LCOR_ERR_NOMEM; LCOR_ERR_CANCELLED. */
LCOR_API lcor_status lcor_field_new(const lcor_solution *solution, const lcor_view *view,
                                    const lcor_field_options *options, lcor_field **out,
                                    lcor_error *err);
LCOR_API void lcor_field_free(lcor_field *field);

/** What lcor_field_new did. */
typedef struct lcor_field_report {
    double error;     /**< largest relative difference between samples and their prediction from
                           the next coarser grid: the error left is smaller. With noise, the root
                           mean square over pixels of the errors expected */
    uint64_t samples; /**< indirect irradiances taken from the solution */
    int channels;     /**< of the solution: 1 or 3 */
} lcor_field_report;

LCOR_API void lcor_field_get_report(const lcor_field *field, lcor_field_report *report);

/** Irradiance at n points of a surface on the side the view sees.
 *
 *  @param uv             2 n numbers as lcor_place's
 *  @param total, direct  n * channels values each, channel fastest; either may be NULL
 *  Errors: LCOR_ERR_ARG; LCOR_ERR_DOMAIN surface not in the view. */
LCOR_API lcor_status lcor_field_at(const lcor_field *field, size_t surface, size_t n,
                                   const double *uv, double *total, double *direct,
                                   lcor_error *err);

#ifdef __cplusplus
}
#endif

#endif
