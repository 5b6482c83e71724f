/* SPDX-License-Identifier: MIT */
/** @file
 *  Lightness correction of pixel rows (sections 4.3-4.5, eqs 9-16).
 *
 *  Two passes over a picture: lcor_plan_reflectance_row and lcor_mean_add on every row give r_mean;
 *  lcor_correct_row writes the corrected pixels.
 *
 *  Rows whose samples are all u8, u16 or f32 are computed in float, others in double (as are the
 *  rare plans of docs/MODEL.md, "Two paths"). Output has the same bytes on every processor and
 *  from every compiler. Row calls use at most 12 KB of stack.
 *
 *  | call                                       | may run at the same time as                  |
 *  |--------------------------------------------|----------------------------------------------|
 *  | row calls on one plan                      | row calls on the same plan, other buffers    |
 *  | lcor_plan_new, lcor_plan_size              | anything                                     |
 *  | lcor_plan_free                             | nothing on that plan                         | */
#ifndef LCOR_CORRECT_H
#define LCOR_CORRECT_H

#include <lcor/alloc.h>
#include <lcor/colour.h>
#include <lcor/status.h>

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Immutable once made; shared by any number of threads. */
typedef struct lcor_plan lcor_plan;

/** Type of one sample. Integers are 0..1 scaled by 255 or 65535. */
typedef enum lcor_sample { LCOR_F32 = 0, LCOR_F64 = 1, LCOR_U8 = 2, LCOR_U16 = 3 } lcor_sample;

/** What rho in r = alpha rho means (4.2; "Readings of rho" in docs/MODEL.md). */
typedef enum lcor_reading {
    LCOR_READING_PATCH = 0, /**< the patch's (texture's mean) reflectance; pixel = beta y */
    LCOR_READING_TEXEL = 1  /**< the texel's own y, so that H is proportional to alpha y exactly */
} lcor_reading;

/** What happens to corrected colours outside RGB 0..1 (rule S9). */
typedef enum lcor_gamut {
    LCOR_GAMUT_KEEP_HUE = 0, /**< chroma is reduced until the colour fits: hue and L* stay */
    LCOR_GAMUT_CLIP = 1      /**< each channel is clipped */
} lcor_gamut;

/** How pixels lie in a buffer, counted in samples. Zeros mean interleaved RGB: {3, 1}.
 *  RGBA is {4, 1}; a planar or banded row is {1, plane size}. Samples between are not touched. */
typedef struct lcor_layout {
    size_t pixel_step;
    size_t channel_step;
} lcor_layout;

/** Options of a plan. Zero it, set struct_size = sizeof(lcor_plan_options) and what differs. */
typedef struct lcor_plan_options {
    size_t struct_size;
    double contrast;  /**< c = Jmax/Jmin [1], > 1, infinity allowed (eq 13a) */
    double r_mean;    /**< mean of r over the picture (4.3), in the unit of illuminance *
                           reflectance, >= 0. 0: nothing was lit, all comes out black */
    double rho;       /**< reflectance used where a row gets none [1], 0..1; 0 = 0.5 */
    double rho_ratio; /**< measured over textured reflectance (5.2); 0 = 1 */
    double exponent;  /**< t of eq 8, > 0; 0 = 1 */
    lcor_reading reading;
    lcor_gamut gamut;
    const lcor_colour *colour; /**< NULL: NTSC, linear, CIE. Copied. */
    lcor_sample in_type, out_type;
    lcor_sample map_type; /**< of illuminance and rho rows: LCOR_F32 or LCOR_F64 */
    lcor_layout in_layout, out_layout;
    const float *tone_curve; /**< NULL, or tone_size values of the device at equal steps of
                                  linear 0..1, non-decreasing, 0..1: replaces the transfer
                                  function on output. Copied. */
    size_t tone_size;        /**< 0 or >= 2 */
    lcor_allocator allocator;
} lcor_plan_options;

/** Make a plan: the only allocation of the row path.
 *
 *  Errors: LCOR_ERR_ARG options missing, struct_size unset, unknown enumerator, layout that
 *  overlaps itself; LCOR_ERR_DOMAIN a number outside its range above; LCOR_ERR_NOMEM.
 *  `*out` is left alone on failure. */
LCOR_API lcor_status lcor_plan_new(const lcor_plan_options *options, lcor_plan **out,
                                   lcor_error *err);
/** NULL does nothing. */
LCOR_API void lcor_plan_free(lcor_plan *plan);

/** What rows did to their pixels. Calls add to it, so one follows a page. Zero-initialise. */
typedef struct lcor_row_stats {
    uint64_t pixels;
    uint64_t clipped_low;   /**< darker than the device shows (J < J1, eq 8) */
    uint64_t clipped_high;  /**< lighter than the device shows (J > J2, eq 8) */
    uint64_t out_of_gamut;  /**< RGB left 0..1 before the gamut rule */
    uint64_t non_finite;    /**< NaN, infinity or negative input; written as 0 */
    uint64_t first_bad_row; /**< row and pixel of the first non_finite one, if any */
    uint64_t first_bad_pixel;
} lcor_row_stats;

/** Virtual reflectance r = alpha rho of one row (section 3.1), for the mean of section 4.3.
 *
 *  @param texels       n pixels of the plan's in_layout; read with LCOR_READING_TEXEL only
 *  @param illuminance  n values of map_type >= 0, any unit
 *  @param rho          n reflectances of map_type, or NULL for the plan's
 *  @param r            n values out
 *
 *  Errors: none; trouble gives 0 (rule S10).  Memory: none.  Cost: O(n). */
LCOR_API void lcor_plan_reflectance_row(const lcor_plan *plan, size_t n, const void *texels,
                                        const void *illuminance, const void *rho, double *r);

/** Correct one row.
 *
 *  T = beta rho from eq 12 in its stable form, Ynew from eq 11, lightness eq 13b, chroma
 *  eqs 14-16, then the gamut rule, then the transfer function or tone curve.
 *
 *  @param row          index of the row, reported in stats only
 *  @param texels       n pixels of in_type and in_layout, stored values
 *  @param illuminance  n values of map_type >= 0, in the unit of r_mean
 *  @param rho          n reflectances of map_type, or NULL for the plan's
 *  @param out          n pixels of out_type and out_layout; may be `texels` when type and layout
 *                      agree, no other overlap
 *  @param stats        added to; may be NULL
 *
 *  Errors: none.  Memory: none.  Cost: O(n).
 *  Accuracy: docs/MODEL.md, "Accuracy". */
LCOR_API void lcor_correct_row(const lcor_plan *plan, size_t row, size_t n, const void *texels,
                               const void *illuminance, const void *rho, void *out,
                               lcor_row_stats *stats);

/** The lightness planes of a texture, for pictures that show it many times: f of eqs 2-4.
 *
 *  Rows corrected from them compute one cube root a pixel instead of four.
 *
 *  @param texels  n pixels of in_type and in_layout
 *  @param f       fx of pixel i in f[i], fy in f[plane + i], fz in f[2 * plane + i]; they may be
 *                 filtered like any texture. Bad texels (rule S10) become NaN.
 *  @param plane   >= n
 *
 *  Errors: none.  Memory: none.  Cost: O(n). */
LCOR_API void lcor_plan_texture_row(const lcor_plan *plan, size_t n, const void *texels, float *f,
                                    size_t plane);

/** lcor_correct_row from such planes instead of texels; `out` must not overlap f. */
LCOR_API void lcor_correct_texture_row(const lcor_plan *plan, size_t row, size_t n, const float *f,
                                       size_t plane, const void *illuminance, const void *rho,
                                       void *out, lcor_row_stats *stats);

/** The conventional method for comparison: linear RGB times rho times illuminance, clipped
 *  (eq 19). Contrast, mean, reading and gamut of the plan play no part. */
LCOR_API void lcor_conventional_row(const lcor_plan *plan, size_t row, size_t n, const void *texels,
                                    const void *illuminance, const void *rho, void *out,
                                    lcor_row_stats *stats);

#ifdef __cplusplus
}
#endif

#endif
