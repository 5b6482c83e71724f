/* SPDX-License-Identifier: MIT */
#include "colour/internal.h"

#include "base/elementary.h"
#include "base/internal.h"

#include <float.h>
#include <math.h>
#include <string.h>

static const double NTSC[9] = {0.6067, 0.1736, 0.2001, 0.2988, 0.5868,
                               0.1144, 0.0,    0.0661, 1.1150}; /* eq 1 */

/* From the chromaticities of BT.709 (0.64 0.33, 0.30 0.60, 0.15 0.06, white 0.3127 0.3290). */
static const double BT709[9] = {0.41239079926595934, 0.357584339383878,   0.1804807884018343,
                                0.21263900587151027, 0.715168678767756,   0.07219231536073371,
                                0.01933081871559182, 0.11919477979462598, 0.9505321522496607};

/* 0 if m has no inverse worth the name: fewer than three good digits would be left */
static LCOR_COLD int mat3_invert(const double m[9], double inv[9])
{
    double cof[9], det, largest = 0.0;

    for (int i = 0; i < 9; i++) {
        const int r1 = (i / 3 + 1) % 3, r2 = (i / 3 + 2) % 3;
        const int c1 = (i % 3 + 1) % 3, c2 = (i % 3 + 2) % 3;

        cof[i] = m[3 * r1 + c1] * m[3 * r2 + c2] - m[3 * r1 + c2] * m[3 * r2 + c1];
        largest = fmax(largest, fabs(m[i]));
    }
    det = m[0] * cof[0] + m[1] * cof[1] + m[2] * cof[2];
    if (!(fabs(det) > 1e-12 * largest * largest * largest) || !isfinite(det))
        return 0;
    for (int i = 0; i < 9; i++)
        inv[3 * (i % 3) + i / 3] = cof[i] / det;
    return 1;
}

LCOR_COLD lcor_status lcor_colour_init(lcor_colour *colour, lcor_primaries primaries,
                                       const double *matrix, lcor_transfer transfer, double gamma,
                                       lcor_lightness lightness, lcor_error *err)
{
    static const double ones[3] = {1.0, 1.0, 1.0};
    lcor_colour c;

    if (colour == NULL)
        return lcor_internal_fail(err, LCOR_ERR_ARG, -1, "colour space is NULL");
    if ((primaries == LCOR_PRIMARIES_CUSTOM) != (matrix != NULL))
        return lcor_internal_fail(err, LCOR_ERR_ARG, -1,
                                  "a matrix goes with LCOR_PRIMARIES_CUSTOM, and only with it");
    switch (primaries) {
    case LCOR_PRIMARIES_NTSC: matrix = NTSC; break;
    case LCOR_PRIMARIES_SRGB: matrix = BT709; break;
    case LCOR_PRIMARIES_CUSTOM: break;
    }
    if (matrix == NULL)
        return lcor_internal_fail(err, LCOR_ERR_ARG, -1, "unknown primaries %d", (int)primaries);
    if ((unsigned)transfer > LCOR_TRANSFER_GAMMA || (unsigned)lightness > LCOR_LIGHTNESS_PAPER)
        return lcor_internal_fail(err, LCOR_ERR_ARG, -1, "unknown transfer %d or lightness %d",
                                  (int)transfer, (int)lightness);
    if (transfer == LCOR_TRANSFER_GAMMA && !(gamma > 0.0 && gamma <= DBL_MAX))
        return lcor_internal_fail(err, LCOR_ERR_DOMAIN, -1, "gamma must be finite and > 0");

    memset(&c, 0, sizeof c);
    memcpy(c.to_xyz, matrix, sizeof c.to_xyz);
    lcor_internal_mat3_apply(c.to_xyz, ones, c.white);
    for (int i = 0; i < 3; i++)
        if (!(c.white[i] > 0.0 && c.white[i] <= DBL_MAX))
            return lcor_internal_fail(err, LCOR_ERR_DOMAIN, i,
                                      "row %d of the RGB -> XYZ matrix must be finite and sum "
                                      "to more than 0 (the white point)",
                                      i);
    if (!mat3_invert(c.to_xyz, c.from_xyz))
        return lcor_internal_fail(err, LCOR_ERR_DOMAIN, -1, "the RGB -> XYZ matrix has no inverse");
    c.transfer = transfer;
    c.gamma = transfer == LCOR_TRANSFER_GAMMA ? gamma : 1.0;
    c.lightness = lightness;
    *colour = c;
    return LCOR_OK;
}

double lcor_transfer_to_linear(const lcor_colour *colour, double stored)
{
    const double v = fabs(stored);
    double linear;

    switch (colour->transfer) {
    case LCOR_TRANSFER_SRGB:
        linear = v <= 0.04045 ? v / 12.92 : lcor_internal_pow((v + 0.055) / 1.055, 2.4);
        break;
    case LCOR_TRANSFER_GAMMA: linear = lcor_internal_pow(v, colour->gamma); break;
    case LCOR_TRANSFER_LINEAR:
    default: return stored;
    }
    return stored < 0.0 ? -linear : linear;
}

double lcor_transfer_from_linear(const lcor_colour *colour, double linear)
{
    const double v = fabs(linear);
    double stored;

    switch (colour->transfer) {
    case LCOR_TRANSFER_SRGB:
        stored = v <= 0.0031308 ? v * 12.92 : 1.055 * lcor_internal_pow(v, 1.0 / 2.4) - 0.055;
        break;
    case LCOR_TRANSFER_GAMMA: stored = lcor_internal_pow(v, 1.0 / colour->gamma); break;
    case LCOR_TRANSFER_LINEAR:
    default: return linear;
    }
    return linear < 0.0 ? -stored : stored;
}

void lcor_xyz_from_rgb(const lcor_colour *colour, const double rgb[3], double xyz[3])
{
    lcor_internal_mat3_apply(colour->to_xyz, rgb, xyz); /* eq 1 */
}

void lcor_rgb_from_xyz(const lcor_colour *colour, const double xyz[3], double rgb[3])
{
    lcor_internal_mat3_apply(colour->from_xyz, xyz, rgb);
}

void lcor_lab_from_xyz(const lcor_colour *colour, const double xyz[3], double lab[3])
{
    double f[3];

    for (int i = 0; i < 3; i++)
        f[i] = lcor_internal_f(colour->lightness, xyz[i] / colour->white[i]);
    lab[0] = 116.0 * f[1] - 16.0;   /* eq 2 */
    lab[1] = 500.0 * (f[0] - f[1]); /* eq 3 */
    lab[2] = 200.0 * (f[1] - f[2]); /* eq 4 */
}

void lcor_xyz_from_lab(const lcor_colour *colour, const double lab[3], double xyz[3])
{
    const double fy = (lab[0] + 16.0) / 116.0;
    const double fx = fy + lab[1] / 500.0;
    const double fz = fy - lab[2] / 200.0;

    xyz[0] = colour->white[0] * lcor_internal_f_inverse(colour->lightness, fx);
    xyz[1] = colour->white[1] * lcor_internal_f_inverse(colour->lightness, fy);
    xyz[2] = colour->white[2] * lcor_internal_f_inverse(colour->lightness, fz);
}

void lcor_lab_from_rgb_row_f64(const lcor_colour *colour, size_t n, const double *rgb, double *lab)
{
    for (size_t i = 0; i < n; i++, rgb += 3, lab += 3) {
        for (int k = 0; k < 3; k++)
            lab[k] = lcor_transfer_to_linear(colour, rgb[k]);
        lcor_xyz_from_rgb(colour, lab, lab);
        lcor_lab_from_xyz(colour, lab, lab);
    }
}

void lcor_rgb_from_lab_row_f64(const lcor_colour *colour, size_t n, const double *lab, double *rgb)
{
    for (size_t i = 0; i < n; i++, lab += 3, rgb += 3) {
        lcor_xyz_from_lab(colour, lab, rgb);
        lcor_rgb_from_xyz(colour, rgb, rgb);
        for (int k = 0; k < 3; k++)
            rgb[k] = lcor_transfer_from_linear(colour, rgb[k]);
    }
}

typedef void row_f64(const lcor_colour *colour, size_t n, const double *in, double *out);

static void row_in_double(row_f64 *row, const lcor_colour *colour, size_t n, const float *in,
                          float *out)
{
    for (size_t i = 0; i < n; i++, in += 3, out += 3) {
        double c[3] = {(double)in[0], (double)in[1], (double)in[2]};

        row(colour, 1, c, c);
        for (int k = 0; k < 3; k++)
            out[k] = (float)c[k];
    }
}

void lcor_lab_from_rgb_row_f32(const lcor_colour *colour, size_t n, const float *rgb, float *lab)
{
    row_in_double(lcor_lab_from_rgb_row_f64, colour, n, rgb, lab);
}

void lcor_rgb_from_lab_row_f32(const lcor_colour *colour, size_t n, const float *lab, float *rgb)
{
    row_in_double(lcor_rgb_from_lab_row_f64, colour, n, lab, rgb);
}

double lcor_hue(const double lab[3])
{
    return lab[1] == 0.0 && lab[2] == 0.0 ? 0.0 : atan2(lab[2], lab[1]); /* eq 17 */
}

double lcor_chroma(const double lab[3]) { return hypot(lab[1], lab[2]); /* eq 18 */ }
