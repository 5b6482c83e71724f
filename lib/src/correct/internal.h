/* SPDX-License-Identifier: MIT */
#ifndef LCOR_CORRECT_INTERNAL_H
#define LCOR_CORRECT_INTERNAL_H

#include "correct/kernel.h"

#include <lcor/correct.h>

#include <stddef.h>

/* A digested plan: nothing in it changes after lcor_plan_new. */
struct lcor_plan {
    lcor_colour colour;
    double f_from_rgb[9]; /* linear RGB -> X/X0, Y/Y0, Z/Z0 */
    double rgb_from_f[9]; /* its inverse */
    double gain;          /* (1 + 2/(c-1)) / 2 */
    double r_mean, rho, rho_ratio, exponent;
    lcor_reading reading;
    lcor_gamut gamut;
    lcor_sample in_type, out_type, map_type;
    lcor_layout in, out;
    const float *tone; /* in the same allocation, or NULL */
    size_t tone_size;
    const double *decode_table; /* linear values of 8-bit samples, where they are not a product */
    const float *decode_floats; /* the same */
    lcor_kernel kernel;
    int in_double; /* the float path cannot do it: all goes through the reference */
    int settles;   /* what float leaves open gets its colour from the reference */
    lcor_kernel_constants k;
    int decode_by_power; /* samples are neither linear nor in decode_table */
    int float_maps;      /* maps are float and need nothing but float arithmetic */
    lcor_allocator allocator;
};

/* What became of one pixel; bits of a mask. */
enum {
    LCOR_PIXEL_LOW = 1,     /* J < J1 */
    LCOR_PIXEL_HIGH = 2,    /* J > J2 */
    LCOR_PIXEL_OUTSIDE = 4, /* RGB left 0..1 before the gamut rule */
    LCOR_PIXEL_BAD = 8      /* rule S10: written as 0 */
};

/* T = beta rho from eq 12 in its stable form, not clamped: q = r / r_mean >= 0. */
double lcor_internal_display(double q, double exponent, double gain);
/* k of eq 16 from the CIE lightness, for reflectances y before and y_new after (rules S5, S6). */
double lcor_internal_chroma_factor(double y, double y_new);

#endif
