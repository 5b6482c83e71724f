/* SPDX-License-Identifier: MIT */
/* The peer: the classical solver with a stored matrix of form factors between all patches. */
#ifndef LCOR_BENCH_DENSE_H
#define LCOR_BENCH_DENSE_H

#include <stddef.h>

/* The paper's room with n x n patches a face: total irradiance at patch centres, faces in the order
 * floor, ceiling, x0, x1, y0, y1 with i along u, j along v as in paper_room_50x50.csv. Returns the
 * bytes of the matrix, or 0 without memory. */
size_t dense_paper_room(size_t n, double *irradiance);

#endif
