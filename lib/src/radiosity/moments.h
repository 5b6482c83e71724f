/* SPDX-License-Identifier: MIT */
/* What a light sends to a cell of a face, as moments with the cell's polynomials. */
#ifndef LCOR_RADIOSITY_MOMENTS_H
#define LCOR_RADIOSITY_MOMENTS_H

#include "radiosity/rule.h"
#include "radiosity/sight.h"

/* A light of intensity 1 that looks at a face. */
typedef struct moments {
    const lcor_light *light;
    const face *f;
    double accuracy; /* relative */
    sight sight;
} moments;

/* `blockers` are what may stand between the light and the cells. */
void moments_aim(moments *m, const lcor_scene *scene, const lcor_light *light, const face *f,
                 const uint32_t *blockers, size_t count, double accuracy);

/* out[k] = integral over what the light sees of the cell of irradiance times polynomial k. Returns
 * their sum, the flux. */
double moments_of(const moments *m, const cell *c, double out[RULE_Q]);

#endif
