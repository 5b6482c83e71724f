/* SPDX-License-Identifier: MIT */
/* Indirect irradiance of patches and points from the solved polynomials. */
#ifndef LCOR_RADIOSITY_EVALUATE_H
#define LCOR_RADIOSITY_EVALUATE_H

#include "radiosity/links.h"

/* Adds to out[channels * patch]: patches first..first+count-1 of a surface, of a quad whole rows.
 */
void links_patches(const links *l, size_t surface, lcor_value value, size_t first, size_t count,
                   double *out);

/* At a point on a surface or free (LCOR_BVH_NONE): from the element it lies on, or by a gathering
 * of its own where it lies on none. */
void links_point(const links *l, const double x[3], const double normal[3], uint32_t surface,
                 double accuracy, double *out);

#endif
