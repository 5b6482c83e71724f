/* SPDX-License-Identifier: MIT */
/* Direct light of patches: averages by quadrature or, where a shadow's edge crosses the patch, over
 * what the light sees of it; by shadow rays only where very much stands in the way. */
#ifndef LCOR_RADIOSITY_PATCH_LIGHT_H
#define LCOR_RADIOSITY_PATCH_LIGHT_H

#include "radiosity/direct.h"

/* Patches first..first+count-1 of a surface (of a quad: whole rows) into out[channels * patch].
 * `accuracy`: relative error allowed to quadrature. */
void patch_light(const light_set *set, size_t surface, lcor_value value, size_t first, size_t count,
                 double accuracy, double *out);

#endif
