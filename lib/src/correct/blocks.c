/* SPDX-License-Identifier: MIT */
/* A row on the float path: blocks through the loops of the plan's kernel. */
#include "correct/internal.h"
#include "correct/sample.h"

#include <string.h>

static void prefetch(const void *base, size_t from, size_t bytes, int write)
{
#if defined(__GNUC__)
    const char *p = (const char *)base + from;

    for (size_t i = 0; i < bytes; i += 64)
        if (write)
            __builtin_prefetch(p + i, 1);
        else
            __builtin_prefetch(p + i, 0);
#else
    (void)base, (void)from, (void)bytes, (void)write;
#endif
}

/* The processor's own prefetcher loses the thread between two blocks. */
static void prefetch_block(const lcor_row_job *job, size_t at)
{
    const lcor_plan *p = job->plan;
    const size_t in = lcor_internal_sample_size(p->in_type);
    const size_t out = lcor_internal_sample_size(p->out_type);

    if (at + LCOR_BLOCK > job->n)
        return;
    if (job->f == NULL && p->in.channel_step == 1)
        prefetch(job->texels, at * p->in.pixel_step * in, LCOR_BLOCK * p->in.pixel_step * in, 0);
    if (p->out.channel_step == 1)
        prefetch(job->out, at * p->out.pixel_step * out, LCOR_BLOCK * p->out.pixel_step * out, 1);
}

/* Is the row made of whole pixels, or of planes, without gaps? */
static int is_dense(lcor_layout l)
{
    return l.pixel_step == 1 || (l.pixel_step == 3 && l.channel_step == 1);
}

/* A full block of a dense row. */
static void load_dense(const lcor_row_job *job, size_t at, lcor_block *b)
{
    const lcor_plan *p = job->plan;
    const size_t size = lcor_internal_sample_size(p->in_type);
    const char *from = (const char *)job->texels + at * p->in.pixel_step * size;
    float LCOR_ALIGNED pixels[3 * LCOR_BLOCK];

    if (p->in.pixel_step == 3 && p->in_type == LCOR_F32) {
        p->kernel->separate((const float *)(const void *)from, b);
    } else if (p->in.pixel_step == 3) {
        p->kernel->widen(p->in_type, from, 3, pixels);
        p->kernel->separate(pixels, b);
    } else {
        for (size_t k = 0; k < 3; k++, from += p->in.channel_step * size)
            if (p->in_type == LCOR_F32)
                memcpy(b->c[k], from, sizeof b->c[k]);
            else
                p->kernel->widen(p->in_type, from, 1, b->c[k]);
    }
}

static void store_dense(const lcor_row_job *job, size_t at, const lcor_block *b)
{
    const lcor_plan *p = job->plan;
    const size_t size = lcor_internal_sample_size(p->out_type);
    char *to = (char *)job->out + at * p->out.pixel_step * size;
    float LCOR_ALIGNED pixels[3 * LCOR_BLOCK];

    if (p->out.pixel_step == 3 && p->out_type == LCOR_F32) {
        p->kernel->interleave(b, (float *)(void *)to);
    } else if (p->out.pixel_step == 3) {
        p->kernel->interleave(b, pixels);
        p->kernel->narrow(p->out_type, pixels, 3, to);
    } else {
        for (size_t k = 0; k < 3; k++, to += p->out.channel_step * size)
            if (p->out_type == LCOR_F32)
                p->kernel->clamp(b->c[k], (float *)(void *)to);
            else
                p->kernel->narrow(p->out_type, b->c[k], 1, to);
    }
}

static void fill_colour(const lcor_row_job *job, size_t at, size_t m, lcor_block *b)
{
    const lcor_plan *p = job->plan;

    if (job->f != NULL) {
        if (m < LCOR_BLOCK)
            memset(b->c, 0, sizeof b->c);
        for (size_t k = 0; k < 3; k++)
            memcpy(b->c[k], job->f + k * job->plane + at, m * sizeof b->c[k][0]);
    } else if (m == LCOR_BLOCK && p->decode_table == NULL && is_dense(p->in)) {
        load_dense(job, at, b);
    } else {
        lcor_internal_load_strided(job, at, m, b);
    }
}

/* m values, then ones, in `space` */
static const float *padded(const float *values, size_t m, float space[LCOR_BLOCK])
{
    for (size_t j = 0; j < LCOR_BLOCK; j++)
        space[j] = j < m ? values[j] : 1.0f;
    return space;
}

/* Returns 1 if some may be bad. */
static int fill_float_maps(const lcor_row_job *job, size_t at, size_t m, lcor_block *b)
{
    const lcor_kernel *kernel = job->plan->kernel;
    const float *i = (const float *)job->illuminance + at;
    const float *rho = job->rho != NULL ? (const float *)job->rho + at : NULL;
    float LCOR_ALIGNED short_i[LCOR_BLOCK], short_rho[LCOR_BLOCK];

    if (m < LCOR_BLOCK) {
        i = padded(i, m, short_i);
        rho = rho != NULL ? padded(rho, m, short_rho) : NULL;
    }
    kernel->maps(job->plan, i, rho, b);
    for (size_t j = m; j < LCOR_BLOCK; j++) {
        b->v[j] = 0.0f;
        b->t[j] = 0.5f; /* neither below J1 nor above J2 */
    }
    return kernel->any_suspect(i, 1) || (rho != NULL && kernel->any_suspect(rho, 1));
}

/* Read the pixels of block `at`; returns how many were bad and are black now. */
static size_t fill(const lcor_row_job *job, size_t at, size_t m, lcor_block *b)
{
    const lcor_plan *p = job->plan;
    int suspect = 0;

    fill_colour(job, at, m, b);
    if (p->float_maps)
        suspect = fill_float_maps(job, at, m, b);
    else
        lcor_internal_load_maps(job, at, m, b);
    if (suspect ||
        ((job->f != NULL || p->in_type == LCOR_F32) && p->kernel->any_suspect(b->c[0], 3)))
        return lcor_internal_replace_bad(job, at, m, b);
    return 0;
}

/* Chroma and lightness of a filled block, up to linear RGB that is not yet clamped. */
static void compute(const lcor_row_job *job, size_t m, size_t bad, lcor_block *b)
{
    const lcor_plan *p = job->plan;

    if (job->stats != NULL && p->reading == LCOR_READING_PATCH)
        p->kernel->count(b->t, job->stats);
    if (job->f != NULL) {
        p->kernel->lightness_of_f(&p->k, b);
        p->kernel->g(b->c[3], 1);
    } else {
        for (int k = 0; p->decode_by_power && k < 3; k++)
            p->kernel->transfer(&p->k.decode, b->c[k]);
        p->kernel->lightness(&p->k, b);
        p->kernel->g(b->c[0], 4);
    }
    if (job->stats != NULL && p->reading == LCOR_READING_TEXEL) {
        p->kernel->count(b->t, job->stats);
        if (p->k.w < 0.0f) /* what is bad or beyond the end stands there as black */
            job->stats->clipped_low -= bad + (LCOR_BLOCK - m);
    }
    p->kernel->chroma(&p->k, b);
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
    const lcor_plan *p = job->plan;
    lcor_block b;

    for (size_t at = 0; at < job->n; at += LCOR_BLOCK) {
        const size_t m = job->n - at < LCOR_BLOCK ? job->n - at : LCOR_BLOCK;

        prefetch_block(job, at + 2 * LCOR_BLOCK);
        compute(job, m, fill(job, at, m, &b), &b);
        if (p->gamut == LCOR_GAMUT_KEEP_HUE || job->stats != NULL)
            settle_outside(job, at, m, &b);
        lcor_internal_to_device(p, b.c);
        if (m == LCOR_BLOCK && is_dense(p->out))
            store_dense(job, at, &b);
        else
            lcor_internal_store_strided(job, at, m, &b);
    }
    if (job->stats != NULL)
        job->stats->pixels += job->n;
}
