/* SPDX-License-Identifier: MIT */
/* A row on the float path, block by block: read, light, chroma, what left the gamut, write. */
#include "correct/internal.h"

#include <string.h>

/* The texels of a block as the kernels read them. */
typedef struct texels {
    const float
        *v;       /* linear RGB interleaved, or planes fx, fy, fz: the caller's memory or `copy` */
    size_t plane; /* distance of the planes */
    float LCOR_ALIGNED copy[3 * LCOR_BLOCK];
} texels;

static void copy_texels(const lcor_row_job *job, size_t at, size_t m, texels *t)
{
    lcor_internal_load_texels(job, at, m, t->copy);
    t->v = t->copy;
    t->plane = LCOR_BLOCK;
}

static void read_texels(const lcor_row_job *job, size_t at, size_t m, texels *t)
{
    const lcor_plan *p = job->plan;

    if (m == LCOR_BLOCK && job->f != NULL) {
        t->v = job->f + at;
        t->plane = job->plane;
    } else if (m == LCOR_BLOCK && p->in_type == LCOR_F32 && !p->decode_by_power &&
               lcor_internal_is_interleaved(p->in)) {
        t->v = (const float *)job->texels + 3 * at;
    } else {
        copy_texels(job, at, m, t);
    }
}

/* m values, then ones, in `space` */
static const float *padded(const float *values, size_t m, float space[LCOR_BLOCK])
{
    for (size_t j = 0; j < LCOR_BLOCK; j++)
        space[j] = j < m ? values[j] : 1.0f;
    return space;
}

/* T and v of a block. Not 0 if some values may be bad. */
static int read_maps(const lcor_row_job *job, size_t at, size_t m, lcor_block *b)
{
    const float *i, *rho;
    float LCOR_ALIGNED short_i[LCOR_BLOCK], short_rho[LCOR_BLOCK];
    int suspect;

    if (!job->plan->float_maps)
        return lcor_internal_load_maps(job, at, m, b);
    i = (const float *)job->illuminance + at;
    rho = job->rho != NULL ? (const float *)job->rho + at : NULL;
    if (m < LCOR_BLOCK) {
        i = padded(i, m, short_i);
        rho = rho != NULL ? padded(rho, m, short_rho) : NULL;
    }
    suspect = job->plan->kernel->maps(job->plan, i, rho, b);
    for (size_t j = m; j < LCOR_BLOCK; j++) {
        b->v[j] = 0.0f;
        b->t[j] = 0.5f; /* neither below J1 nor above J2 */
    }
    return suspect;
}

/* X, Y, Z and Ynew, or what of them a converted texture leaves to do. Not 0 if some may be bad. */
static int light(const lcor_row_job *job, texels *t, lcor_block *b)
{
    const lcor_plan *p = job->plan;
    int suspect = 0;

    if (job->f != NULL)
        return p->kernel->lightness_of_f(&p->k, t->v, t->plane, b);
    for (size_t k = 0; p->decode_by_power && k < 3; k++)
        suspect |= p->kernel->transfer(&p->k.decode, t->copy + k * LCOR_BLOCK);
    return suspect | p->kernel->lightness(&p->k, t->v, b);
}

/* Chroma and lightness of a block, up to linear RGB that is not yet clamped. */
static void compute(const lcor_row_job *job, size_t at, size_t m, lcor_block *b)
{
    const lcor_plan *p = job->plan;
    const int suspect_maps = read_maps(job, at, m, b);
    size_t bad = 0;
    texels t;

    read_texels(job, at, m, &t);
    if (suspect_maps | light(job, &t, b)) { /* rule S10: once more, without what is bad */
        copy_texels(job, at, m, &t);
        bad = lcor_internal_replace_bad(job, at, m, t.copy, b);
        light(job, &t, b);
    }
    if (job->stats != NULL) {
        p->kernel->count(b->t, job->stats);
        if (p->k.w < 0.0f) /* T of what is bad or beyond the end: stands there as black */
            job->stats->clipped_low -= bad + (LCOR_BLOCK - m);
    }
    if (job->f != NULL)
        p->kernel->g(b->c[3], 1);
    else
        p->kernel->g(b->c[0], 4);
    p->kernel->chroma(&p->k, b);
}

/* Are eight of them 0? */
static int none(const int32_t *outside)
{
    uint64_t two[4];

    memcpy(two, outside, sizeof two);
    return (two[0] | two[1] | two[2] | two[3]) == 0;
}

/* What float leaves open: pixels out of gamut, or too near its faces to say. The reference gives
 * them their colour by rule S9, and their count. */
static void settle_outside(const lcor_row_job *job, size_t at, size_t m, lcor_block *b)
{
    const int keep_hue = job->plan->gamut == LCOR_GAMUT_KEEP_HUE;
    int32_t LCOR_ALIGNED outside[LCOR_BLOCK];

    job->plan->kernel->find_outside(b, outside);
    for (size_t j = 0; j < m; j++) {
        double rgb[3];
        unsigned flags;

        if (j % 8 == 0 && none(outside + j)) {
            j += 7;
            continue;
        }
        if (outside[j] == 0)
            continue;
        flags = lcor_internal_correct_at(job, at + j, rgb);
        for (int k = 0; keep_hue && k < 3; k++)
            b->c[k][j] = (float)rgb[k];
        if (job->stats != NULL)
            job->stats->out_of_gamut += (flags & LCOR_PIXEL_OUTSIDE) != 0;
    }
}

void lcor_internal_correct_blocks(const lcor_row_job *job)
{
    lcor_block b;

    for (size_t at = 0; at < job->n; at += LCOR_BLOCK) {
        const size_t m = job->n - at < LCOR_BLOCK ? job->n - at : LCOR_BLOCK;

        compute(job, at, m, &b);
        if (job->plan->gamut == LCOR_GAMUT_KEEP_HUE || job->stats != NULL)
            settle_outside(job, at, m, &b);
        lcor_internal_to_device(job->plan, b.c);
        lcor_internal_store_pixels(job, at, m, &b);
    }
    if (job->stats != NULL)
        job->stats->pixels += job->n;
}
