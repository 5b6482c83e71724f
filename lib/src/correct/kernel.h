/* SPDX-License-Identifier: MIT */
/* The float path: rows in blocks of 64 pixels that stay in the first-level cache, one short loop
 * over a block for each step. The loops live in kernel_template.h, compiled once per instruction
 * set; what compilers do not vectorise is shared in block.c. */
#ifndef LCOR_CORRECT_KERNEL_H
#define LCOR_CORRECT_KERNEL_H

#include <lcor/correct.h>

#include <stddef.h>
#include <stdint.h>

enum { LCOR_BLOCK = 64 };

#if defined(__GNUC__)
#    define LCOR_ALIGNED __attribute__((aligned(64)))
#else
#    define LCOR_ALIGNED
#endif

/* Constants of a plan for the float path. */
typedef struct lcor_kernel_constants {
    float m[9], n[9]; /* linear RGB -> X/X0, Y/Y0, Z/Z0 and back; rows of n sum to exactly 1 */
    /* Ynew = clamp(v y + w): with the patch's rho v = max(T, 0) / rho and w = 0, with the texel's
     * own y (T linear in y) v = illuminance * slope and w the constant of T */
    float w;
    float offset;    /* T = illuminance * rho * slope + offset */
    float slope;
    float slope_rho; /* with the plan's rho in it */
    float slope_texel;
    float ratio;     /* of section 5.2 */
    float over_rho;  /* ratio over the plan's rho */
    float gamma, over_gamma;
} lcor_kernel_constants;

/* Planes of one block; ends of short ones are padded with black. */
typedef struct lcor_block {
    float LCOR_ALIGNED c[3][LCOR_BLOCK]; /* RGB, then fx fy fz, then RGB */
    float LCOR_ALIGNED v[LCOR_BLOCK];    /* v of Ynew = v y + w, then Ynew */
    float LCOR_ALIGNED fn[LCOR_BLOCK];   /* T where it is counted, then f(Ynew) */
    float LCOR_ALIGNED kx[LCOR_BLOCK];   /* k (fx - fy) and k (fz - fy), eqs 14 and 15 */
    float LCOR_ALIGNED kz[LCOR_BLOCK];
} lcor_block;

/* Pixels out of gamut, gathered over blocks so that they are fitted many at a time. */
typedef struct lcor_outside {
    float LCOR_ALIGNED kx[LCOR_BLOCK]; /* in: chroma, f and Ynew; out: RGB in kx, kz, fn */
    float LCOR_ALIGNED kz[LCOR_BLOCK];
    float LCOR_ALIGNED fn[LCOR_BLOCK];
    float LCOR_ALIGNED y[LCOR_BLOCK];
    size_t             at[LCOR_BLOCK]; /* pixel of the row */
    size_t             count;
} lcor_outside;

/* Arguments of lcor_correct_row, or of lcor_correct_texture_row when f is not NULL. */
typedef struct lcor_row_job {
    const lcor_plan *plan;
    size_t           row, n;
    const void      *texels;
    const float     *f; /* planes fx, fy, fz, `plane` floats apart */
    size_t           plane;
    const void      *illuminance, *rho;
    void            *out;
    lcor_row_stats  *stats;
} lcor_row_job;

typedef struct lcor_kernel {
    const char *name;
    void (*row)(const lcor_row_job *job);
    /* for tests of the worst error: y = f(x), x^(1/3) for x >= 0.0088, over one block */
    void (*cube_root)(const float x[LCOR_BLOCK], float y[LCOR_BLOCK]);
} lcor_kernel;

/* Kernels of this build, best first, that the machine can run: index 0, 1...; NULL after the last. */
const lcor_kernel *lcor_internal_kernel(size_t index);

/* Shared steps. m is the number of pixels in the block, `at` its first pixel. */
void   lcor_internal_prefetch(const lcor_row_job *job, size_t at);
void   lcor_internal_load_strided(const lcor_row_job *job, size_t at, size_t m, lcor_block *b);
void   lcor_internal_load_maps(const lcor_row_job *job, size_t at, size_t m, lcor_block *b);
size_t lcor_internal_replace_bad(const lcor_row_job *job, size_t at, size_t m, lcor_block *b);
void   lcor_internal_apply_tone(const lcor_plan *plan, float *values);
void   lcor_internal_store_strided(const lcor_row_job *job, size_t at, size_t m, const float *r,
                                   const float *g, const float *b);
void   lcor_internal_store_scattered(const lcor_row_job *job, const lcor_outside *q);

#endif
