/* SPDX-License-Identifier: MIT */
/* Low-discrepancy numbers: Sobol's sequence [Joe and Kuo 2008] under nested uniform scrambling
 * [Owen 1995] by a hash [Burley 2020], so that every seed is a sequence of its own. */
#ifndef LCOR_RADIOSITY_GATHER_RANDOM_H
#define LCOR_RADIOSITY_GATHER_RANDOM_H

#include <stdint.h>

enum { SOBOL_AXES = 6, SOBOL_BITS = 32, SOBOL_BASE = 16, SOBOL_DIGITS = SOBOL_BITS / 4 };

/* What each digit of the index adds to a point, highest bit last. */
typedef struct sobol {
    uint32_t reversed[SOBOL_AXES][SOBOL_DIGITS][SOBOL_BASE];
} sobol;

void sobol_init(sobol *s);

/* Point `index` of the sequence `seed`: numbers of 0..1 for axes first..first+count-1. */
void sobol_point(const sobol *s, uint32_t index, uint32_t seed, int first, int count, double *out);

/* A hash that changes about half the bits for every bit changed. */
static inline uint32_t random_hash(uint32_t x)
{
    x ^= x >> 16;
    x *= 0x7feb352du;
    x ^= x >> 15;
    x *= 0x846ca68bu;
    return x ^ x >> 16;
}

/* The next of independent numbers of 0..1. */
static inline double random_next(uint32_t *state)
{
    *state += 0x9e3779b9u;
    return (random_hash(*state) + 0.5) / 4294967296.0;
}

/* A seed for a place, the same if its coordinates were kept in single precision. */
uint32_t random_seed_at(const double x[3]);

/* Direction with density cosine / pi around the third axis, from two numbers of 0..1: the
 * concentric map of the square to the disc [Shirley and Chiu 1997], lifted to the hemisphere. */
void random_cosine(double a, double b, double direction[3]);

#endif
