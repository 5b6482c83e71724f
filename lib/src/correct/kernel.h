/* SPDX-License-Identifier: MIT */
/* The float path: rows in blocks of 64 pixels that stay in the first-level cache, one short loop
 * over a block for each step. The loops live in kernel_template.h, compiled once per instruction
 * set; what compilers do not vectorise is shared in block.c. */
#ifndef LCOR_CORRECT_KERNEL_H
#define LCOR_CORRECT_KERNEL_H

#include <lcor/correct.h>

#include <stddef.h>
#include <stdint.h>

#if defined(__ARM_ARCH_PROFILE) && __ARM_ARCH_PROFILE == 'M' /* little stack, no vectors */
enum { LCOR_BLOCK = 32, LCOR_GATHERED = 16 };
#else
enum { LCOR_BLOCK = 64, LCOR_GATHERED = 32 };
#endif

#if defined(__GNUC__)
#define LCOR_ALIGNED __attribute__((aligned(64)))
#else
#define LCOR_ALIGNED
#endif

/* x clamped to 0..top; x <= knee: slope x; else scale (in_scale x + in_offset)^exponent + offset */
typedef struct lcor_power {
    float top, knee, slope;
    float in_scale, in_offset, exponent, scale, offset;
} lcor_power;

/* Constants of a plan for the float path. */
typedef struct lcor_kernel_constants {
    float m[9], n[9]; /* linear RGB -> X/X0, Y/Y0, Z/Z0 and back; rows of n sum to exactly 1 */
    /* Ynew = clamp(v y + w): with the patch's rho v = max(T, 0) / rho and w = 0, with the texel's
     * own y (T linear in y) v = illuminance * slope and w the constant of T */
    float w;
    float offset; /* T = illuminance * rho * slope + offset */
    float slope;
    float slope_rho; /* with the plan's rho in it */
    float slope_texel;
    float ratio;               /* of section 5.2 */
    float over_rho;            /* ratio over the plan's rho */
    lcor_power decode, encode; /* the transfer function */
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
    float LCOR_ALIGNED kx[LCOR_GATHERED]; /* chroma, f and Ynew */
    float LCOR_ALIGNED kz[LCOR_GATHERED];
    float LCOR_ALIGNED fn[LCOR_GATHERED];
    float LCOR_ALIGNED y[LCOR_GATHERED];
    size_t at[LCOR_GATHERED]; /* pixel of the row */
    size_t count;
} lcor_outside;

/* Arguments of lcor_correct_row, or of lcor_correct_texture_row when f is not NULL. */
typedef struct lcor_row_job {
    const lcor_plan *plan;
    size_t row, n;
    const void *texels;
    const float *f; /* planes fx, fy, fz, `plane` floats apart */
    size_t plane;
    const void *illuminance, *rho;
    void *out;
    lcor_row_stats *stats;
} lcor_row_job;

/* The loops of one instruction set; planes are LCOR_BLOCK floats. */
typedef struct lcor_kernel {
    const char *name;
    /* a full block of dense samples in and out */
    void (*load)(const lcor_row_job *job, size_t at, lcor_block *b);
    void (*store)(const lcor_row_job *job, size_t at, const lcor_block *b);
    /* T and v from full float maps; rho may be NULL */
    void (*maps)(const lcor_plan *plan, const float *illuminance, const float *rho, lcor_block *b);
    int (*any_suspect)(const float *x, size_t planes);
    void (*count)(const float *t, lcor_row_stats *stats);
    void (*transfer)(const lcor_power *p, float *c);
    void (*lightness)(const lcor_kernel_constants *k, lcor_block *b);
    void (*lightness_of_f)(const lcor_kernel_constants *k, lcor_block *b);
    void (*chroma)(const lcor_kernel_constants *k, lcor_block *b);
    /* flags: 1 for the pixels that left 0..1 by more than rounding */
    void (*find_outside)(const lcor_block *b, uint8_t *flags);
    /* for the test of its worst error: x^(1/3) for x >= 0.0088 */
    void (*cube_root)(const float *x, float *y);
} lcor_kernel;

/* Kernels of this build, best first, that the machine can run: index 0, 1...; NULL after the last.
 */
const lcor_kernel *lcor_internal_kernel(size_t index);

/* Any row of a plan that has a kernel. */
void lcor_internal_correct_blocks(const lcor_row_job *job);

/* Shared steps. m is the number of pixels in the block, `at` its first pixel. */
void lcor_internal_load_strided(const lcor_row_job *job, size_t at, size_t m, lcor_block *b);
void lcor_internal_load_maps(const lcor_row_job *job, size_t at, size_t m, lcor_block *b);
size_t lcor_internal_replace_bad(const lcor_row_job *job, size_t at, size_t m, lcor_block *b);
/* Linear RGB of three planes to what the device takes. */
void lcor_internal_to_device(const lcor_plan *plan, float *r, float *g, float *b);
void lcor_internal_store_strided(const lcor_row_job *job, size_t at, size_t m, const float *r,
                                 const float *g, const float *b);
/* After the block is stored: its pixels marked in `flags` are stored again once fitted. */
void lcor_internal_gather(const lcor_row_job *job, size_t at, size_t m, const lcor_block *b,
                          const uint8_t *flags, lcor_outside *q);
/* Fit and store the gathered ones. */
void lcor_internal_flush(const lcor_row_job *job, lcor_outside *q);

#endif
