/* SPDX-License-Identifier: MIT */
#ifndef LCOR_COLOUR_INTERNAL_H
#define LCOR_COLOUR_INTERNAL_H

#include <lcor/colour.h>

/* f of eqs 2-4 and its inverse, in the kind of lightness asked for. */
double lcor_internal_f(lcor_lightness lightness, double t);
double lcor_internal_f_inverse(lcor_lightness lightness, double f);
/* Derivative of the inverse. */
double lcor_internal_f_inverse_slope(lcor_lightness lightness, double f);

/* out = m in, m row-major 3x3; in may be out. */
void lcor_internal_mat3_apply(const double m[9], const double in[3], double out[3]);

#endif
