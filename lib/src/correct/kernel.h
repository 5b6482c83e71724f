/* SPDX-License-Identifier: MIT */
/* The float path: rows in blocks of pixels that stay in the first-level cache, one short loop
 * over a block for each step. The loops live in the *_template.h, compiled once per instruction
 * set; what compilers do not vectorise is shared in block_memory.c. */
#ifndef LCOR_CORRECT_KERNEL_H
#define LCOR_CORRECT_KERNEL_H

#include <lcor/correct.h>

#include <stddef.h>
#include <stdint.h>

#if defined(__ARM_ARCH_PROFILE) && __ARM_ARCH_PROFILE == 'M' /* little stack, no vectors */
enum { LCOR_BLOCK = 32, LCOR_LANES = 1 };
#else
enum { LCOR_BLOCK = 128, LCOR_LANES = 16 };
#endif

#if defined(__GNUC__)
#define LCOR_ALIGNED __attribute__((aligned(64)))
#else
#define LCOR_ALIGNED
#endif

/* (scale x)^exponent of x clamped to 0..top */
typedef struct lcor_power {
    float top, scale, exponent;
} lcor_power;

/* What sRGB stores: of x clamped to 0..top, slope x up to the knee, else (scale x + offset)^2.4. */
typedef struct lcor_srgb {
    float top, knee, slope, scale, offset;
} lcor_srgb;

/* Constants of a plan for the float path. */
typedef struct lcor_kernel_constants {
    float m[3][3]; /* linear RGB, or codes of it, -> X/X0, Y/Y0, Z/Z0 */
    float n[3][2]; /* and back: factors of X/X0 - Y/Y0 and Z/Z0 - Y/Y0, since rows sum to 1 */
    /* Ynew = clamp(v y + w): with the patch's rho v = max(T, 0) / rho and w = 0, with the texel's
     * own y (T linear in y) v = illuminance * slope and w the constant of T */
    float w;
    float offset; /* T = illuminance * rho * slope + offset */
    float slope;
    float slope_rho; /* with the plan's rho in it */
    float slope_texel;
    float ratio;               /* of section 5.2 */
    float over_rho;            /* ratio over the plan's rho */
    float dark;                /* channels below this share of Ynew are not left to float */
    lcor_srgb srgb;            /* the transfer function ... */
    lcor_power decode, encode; /* ... or gamma */
} lcor_kernel_constants;

/* Planes of one block; ends of short ones are padded with black. */
typedef struct lcor_block {
    float LCOR_ALIGNED c[4][LCOR_BLOCK]; /* X Y Z over white and Ynew, then RGB and Ynew */
    float LCOR_ALIGNED g[4][LCOR_BLOCK]; /* 1 - f of X Y Z Ynew */
    float LCOR_ALIGNED v[LCOR_BLOCK];    /* of Ynew = clamp(v y + w) */
    float LCOR_ALIGNED t[LCOR_BLOCK];    /* T, where it is no such product */
} lcor_block;

typedef struct lcor_lanes lcor_lanes; /* pixels in double: lanes.h */

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

/* The loops of one instruction set over full blocks. Results of type int are not 0 if a number
 * read is negative, NaN, infinite or huge: then they have to be looked at one by one. */
typedef struct lcor_kernel {
    const char *name;
    /* T and v; rho may be NULL */
    int (*maps)(const lcor_plan *plan, const float *illuminance, const float *rho, lcor_block *b);
    int (*power)(const lcor_power *p, float *c);
    int (*from_srgb)(const lcor_srgb *s, float *c);
    void (*to_srgb)(float *c); /* linear values as sRGB stores them, clamped */
    /* X Y Z and Ynew from pixels of three samples; from RGB in b->c; or what a texture leaves */
    int (*lightness)(const lcor_kernel_constants *k, const float *rgb, lcor_block *b);
    int (*lightness_of_planes)(const lcor_kernel_constants *k, lcor_block *b);
    void (*lightness_of_bytes)(const lcor_kernel_constants *k, const uint8_t *rgb, lcor_block *b);
    int (*lightness_of_f)(const lcor_kernel_constants *k, const float *f, size_t plane,
                          lcor_block *b);
    void (*count)(const lcor_kernel_constants *k, const lcor_block *b, lcor_row_stats *stats);
    void (*g)(const float *t, float *g, size_t planes); /* 1 - f, of eqs 2-4 */
    void (*chroma)(const lcor_kernel_constants *k, lcor_block *b);
    void (*find_outside)(const lcor_kernel_constants *k, const lcor_block *b, int32_t *outside);
    void (*clamp_planes)(float *c);                             /* three, to 0..1 */
    void (*interleave)(lcor_block *b, float *to);               /* clamped, too */
    void (*interleave_bytes)(const lcor_block *b, uint8_t *to); /* and as codes */
    /* u8 or u16 to floats, and back from 0..1 */
    void (*widen)(lcor_sample type, size_t blocks, const void *from, float *to);
    void (*narrow)(lcor_sample type, size_t blocks, const float *from, void *to);
    /* in double: linear RGB to f of eqs 2-4; from f and Ynew on to corrected RGB */
    void (*lanes_to_f)(const lcor_plan *plan, lcor_lanes *lanes);
    void (*lanes_to_rgb)(const lcor_plan *plan, lcor_lanes *lanes);
} lcor_kernel;

/* Kernels of this build, best first, that the machine can run: index 0, 1... Returns 0 after the
 * last one. */
int lcor_internal_kernel(size_t index, lcor_kernel *kernel);

/* Any row of a plan that has a kernel. */
void lcor_internal_correct_blocks(const lcor_row_job *job);

/* Blocks between memory and float. m is the number of pixels in the block, `at` its first. */
int lcor_internal_is_interleaved(lcor_layout l); /* and without gaps */
/* Texels into b->c, linear unless the plan decodes by a power; f of a converted texture into f. */
void lcor_internal_load_texels(const lcor_row_job *job, size_t at, size_t m, lcor_block *b);
void lcor_internal_load_f(const lcor_row_job *job, size_t at, size_t m, float f[][LCOR_BLOCK]);
/* kernel->maps of any plan. */
int lcor_internal_load_maps(const lcor_row_job *job, size_t at, size_t m, lcor_block *b);
/* Rule S10 on loaded planes c of texels or f, and maps; returns how many pixels were bad and are
 * black now. */
size_t lcor_internal_replace_bad(const lcor_row_job *job, size_t at, size_t m,
                                 float c[][LCOR_BLOCK], lcor_block *b);
/* Linear values to what the device takes. */
void lcor_internal_to_device(const lcor_plan *plan, float values[LCOR_BLOCK]);
/* RGB out, clamped: a block; or a few pixels of the row, as many values as three times `count`. */
void lcor_internal_store_pixels(const lcor_row_job *job, size_t at, size_t m, lcor_block *b);
void lcor_internal_store_apart(const lcor_row_job *job, size_t count, const size_t *at,
                               float values[LCOR_BLOCK]);

#endif
