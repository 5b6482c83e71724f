/* SPDX-License-Identifier: MIT */
/* The paper's room solved apart from the library, as a reference for small tolerances: constant
 * patches with exact factors from rectangle to rectangle, at several meshes, extrapolated. */
#ifndef LCOR_BENCH_RICHARDSON_H
#define LCOR_BENCH_RICHARDSON_H

#include <stddef.h>

/* Averages over the 50 x 50 patches of each face, in the references' order. *order gets the order
 * seen from three meshes, *left the rms of what the extrapolation from the finer two added.
 * Returns 0 without memory. */
int richardson_paper_room(double *values, double *order, double *left);

#endif
