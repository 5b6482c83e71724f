/* SPDX-License-Identifier: MIT */
/* Light that arrives straight from emitting surfaces, exactly: Lambert's integral over what a place
 * sees of each. Meant for scenes where little stands in its way. */
#ifndef LCOR_RADIOSITY_EMITTERS_H
#define LCOR_RADIOSITY_EMITTERS_H

#include "base/array.h"
#include "radiosity/direct.h"

#include <stdint.h>

/* Of one scene. Zero-initialise. */
typedef struct emitter_set {
    const light_set *lights; /* whose channels count */
    lcor_array faces;        /* face */
    lcor_array lists;        /* for side 2 * surface + back and each face: what may hide it */
    lcor_array occluders;    /* uint32_t */
    int exact;               /* else there is too much of all this, and nothing is known */
} emitter_set;

/* Finds the emitters and what may hide them from whom. Returns 0 without memory. */
int emitters_find(emitter_set *set, const lcor_allocator *allocator, const light_set *lights);
void emitters_clear(emitter_set *set, const lcor_allocator *allocator);

/* Corner or middle `index` of the emitters and where it faces; 0 behind the last, or if the set is
 * not exact. */
int emitters_point(const emitter_set *set, size_t index, double x[3], double facing[3]);

/* Adds the irradiance at x, on `surface` or free (LCOR_BVH_NONE): as many values as channels;
 * nothing if the set is not exact. */
void emitters_at(const emitter_set *set, const double x[3], const double normal[3],
                 uint32_t surface, double *out);

#endif
