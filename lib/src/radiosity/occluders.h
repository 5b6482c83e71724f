/* SPDX-License-Identifier: MIT */
/* Which blockers may stand between two elements, or between a light and an element. */
#ifndef LCOR_RADIOSITY_OCCLUDERS_H
#define LCOR_RADIOSITY_OCCLUDERS_H

#include "scene/scene_internal.h"

typedef struct region { /* a cell of a face as four corners and its normal */
    double corners[4][3], normal[3];
} region;

enum { OCCLUDERS_BLOCK = -1, OCCLUDERS_CROWD = -2 };

/* Everything that may hide something: the scene's blockers, or with `single` every shape by itself,
 * as what lies inside a solid or on the inner side of its hull sees them. */
const uint32_t *occluders_of(const lcor_scene *scene, int single, size_t *count);

/* Filters `in` to what may stand between a and b, which face
 * each other. Returns how many, OCCLUDERS_BLOCK if one of them hides all of b from all of a, or
 * OCCLUDERS_CROWD if there are more than `room`. */
long occluders_between(const lcor_scene *scene, const region *a, const region *b,
                       const uint32_t *in, size_t count, uint32_t *out, size_t room);

/* The same between a light and a. */
long occluders_of_light(const lcor_scene *scene, const lcor_light *light, const region *a,
                        const uint32_t *in, size_t count, uint32_t *out, size_t room);

#endif
