/* SPDX-License-Identifier: MIT */
/** @file
 *  RGB spaces, transfer functions, XYZ and L*a*b* (eqs 1-4, 17, 18).
 *
 *  Every function here is pure: any thread, no memory, no errors unless said. */
#ifndef LCOR_COLOUR_H
#define LCOR_COLOUR_H

#include <lcor/status.h>

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Primaries: whose matrix turns linear RGB into XYZ. */
typedef enum lcor_primaries {
    LCOR_PRIMARIES_NTSC = 0, /**< eq 1, the paper's; white (0.9804, 1, 1.1811) */
    LCOR_PRIMARIES_SRGB = 1, /**< sRGB / BT.709, white D65 */
    LCOR_PRIMARIES_CUSTOM = 2
} lcor_primaries;

/** Transfer function between stored and linear RGB. */
typedef enum lcor_transfer {
    LCOR_TRANSFER_LINEAR = 0,
    LCOR_TRANSFER_SRGB = 1, /**< IEC 61966-2-1 */
    LCOR_TRANSFER_GAMMA = 2 /**< linear = stored^gamma */
} lcor_transfer;

/** Which f stands in eqs 2-4. */
typedef enum lcor_lightness {
    LCOR_LIGHTNESS_CIE = 0,  /**< CIE 1976: cube root above (6/29)^3, straight line below */
    LCOR_LIGHTNESS_PAPER = 1 /**< cube root everywhere, as eqs 2-4 are printed */
} lcor_lightness;

/** One colour space: a plain value, filled by lcor_colour_init. Read it freely, do not edit it. */
typedef struct lcor_colour {
    double to_xyz[9];   /**< row-major, linear RGB -> XYZ (eq 1) */
    double from_xyz[9]; /**< its inverse */
    double white[3];    /**< XYZ of RGB (1, 1, 1) */
    lcor_transfer transfer;
    double gamma; /**< of LCOR_TRANSFER_GAMMA, else 1 */
    lcor_lightness lightness;
} lcor_colour;

/** Fill a colour space.
 *
 *  @param primaries  LCOR_PRIMARIES_CUSTOM takes `matrix`, the others want it NULL
 *  @param matrix     9 numbers, row-major, linear RGB -> XYZ; white is its image of (1, 1, 1)
 *  @param gamma      > 0, read with LCOR_TRANSFER_GAMMA only
 *
 *  Errors: LCOR_ERR_ARG unknown enumerator; LCOR_ERR_DOMAIN matrix not finite or not
 *  invertible, a white component <= 0, gamma <= 0. */
LCOR_API lcor_status lcor_colour_init(lcor_colour *colour, lcor_primaries primaries,
                                      const double *matrix, lcor_transfer transfer, double gamma,
                                      lcor_lightness lightness, lcor_error *err);

/** Stored value -> linear and back. Odd around 0, so negative values survive a round trip. */
LCOR_API double lcor_transfer_to_linear(const lcor_colour *colour, double stored);
LCOR_API double lcor_transfer_from_linear(const lcor_colour *colour, double linear);

/** One colour between linear RGB, XYZ (white Y = 1) and L*a*b* (eqs 1-4). `in` may be `out`.
 *  Nothing is clipped. */
LCOR_API void lcor_xyz_from_rgb(const lcor_colour *colour, const double rgb[3], double xyz[3]);
LCOR_API void lcor_rgb_from_xyz(const lcor_colour *colour, const double xyz[3], double rgb[3]);
LCOR_API void lcor_lab_from_xyz(const lcor_colour *colour, const double xyz[3], double lab[3]);
LCOR_API void lcor_xyz_from_lab(const lcor_colour *colour, const double lab[3], double xyz[3]);

/** Rows of n interleaved colours, stored RGB (the transfer function is applied) <-> L*a*b*.
 *  `in` may be `out`, no other overlap. The f32 rows compute in double. */
LCOR_API void lcor_lab_from_rgb_row_f64(const lcor_colour *colour, size_t n, const double *rgb,
                                        double *lab);
LCOR_API void lcor_lab_from_rgb_row_f32(const lcor_colour *colour, size_t n, const float *rgb,
                                        float *lab);
LCOR_API void lcor_rgb_from_lab_row_f64(const lcor_colour *colour, size_t n, const double *lab,
                                        double *rgb);
LCOR_API void lcor_rgb_from_lab_row_f32(const lcor_colour *colour, size_t n, const float *lab,
                                        float *rgb);

/** Hue angle in radians, -pi..pi, 0 where chroma is 0 (eq 17); chroma (eq 18). */
LCOR_API double lcor_hue(const double lab[3]);
LCOR_API double lcor_chroma(const double lab[3]);

#ifdef __cplusplus
}
#endif

#endif
