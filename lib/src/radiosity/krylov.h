/* SPDX-License-Identifier: MIT */
/* Fixed points x = b + K x of linear maps, by GMRES [Saad and Schultz 1986]. */
#ifndef LCOR_RADIOSITY_KRYLOV_H
#define LCOR_RADIOSITY_KRYLOV_H

#include <lcor/alloc.h>

#include <stddef.h>

typedef struct krylov {
    size_t n;
    void (*map)(void *arg, const double *x, double *out); /* out = K x */
    void *arg;
    const double *weight; /* of the inner product, one for every `group` values; NULL: all are 1 */
    size_t group;
    double tolerance;   /* of x, relative to b */
    int iterations;     /* most, at most 60; afterwards those made */
    double contraction; /* set: |K b| / |b| */
    size_t bytes;       /* set: held at once */
} krylov;

/* Fills x. Returns 0 without memory. */
int krylov_solve(krylov *k, const lcor_allocator *allocator, const double *b, double *x);

#endif
