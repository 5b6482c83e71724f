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

static void fill_colour(const lcor_row_job *job, size_t at, size_t m, lcor_block *b)
{
    const lcor_plan *p = job->plan;

    if (job->f != NULL) {
        if (m < LCOR_BLOCK)
            memset(b->c, 0, sizeof b->c);
        for (size_t k = 0; k < 3; k++)
            memcpy(b->c[k], job->f + k * job->plane + at, m * sizeof b->c[k][0]);
    } else if (m == LCOR_BLOCK && p->decode_table == NULL && is_dense(p->in)) {
        p->kernel->load(job, at, b);
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
        b->fn[j] = 0.5f; /* neither below J1 nor above J2 */
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
    if (suspect || p->kernel->any_suspect(b->c[0], 3))
        return lcor_internal_replace_bad(job, at, m, b);
    return 0;
}

/* Chroma and lightness of a filled block, up to linear RGB that is not yet clamped. */
static void compute(const lcor_row_job *job, size_t m, size_t bad, lcor_block *b)
{
    const lcor_plan *p = job->plan;

    if (job->stats != NULL && p->reading == LCOR_READING_PATCH)
        p->kernel->count(b->fn, job->stats);
    if (job->f != NULL) {
        p->kernel->lightness_of_f(&p->k, b);
    } else {
        for (int k = 0; p->decode_by_power && k < 3; k++)
            p->kernel->transfer(&p->k.decode, b->c[k]);
        p->kernel->lightness(&p->k, b);
    }
    if (job->stats != NULL && p->reading == LCOR_READING_TEXEL) {
        p->kernel->count(b->kx, job->stats);
        if (p->k.w < 0.0f) /* what is bad or beyond the end stands there as black */
            job->stats->clipped_low -= bad + (LCOR_BLOCK - m);
    }
    p->kernel->chroma(&p->k, b);
}

/* Sum of LCOR_BLOCK flags, eight at a time. */
static unsigned count_flags(const uint8_t *flags)
{
    unsigned count = 0;

    for (size_t j = 0; j < LCOR_BLOCK; j += 8) {
        uint64_t eight;

        memcpy(&eight, flags + j, sizeof eight);
        count += (unsigned)((eight * UINT64_C(0x0101010101010101)) >> 56);
    }
    return count;
}

void lcor_internal_correct_blocks(const lcor_row_job *job)
{
    const lcor_plan *p = job->plan;
    const int keep_hue = p->gamut == LCOR_GAMUT_KEEP_HUE;
    lcor_block b;
    lcor_outside q;
    uint8_t flags[LCOR_BLOCK];

    memset(&q, 0, sizeof q);
    for (size_t at = 0; at < job->n; at += LCOR_BLOCK) {
        const size_t m = job->n - at < LCOR_BLOCK ? job->n - at : LCOR_BLOCK;
        unsigned outside = 0;

        prefetch_block(job, at + 2 * LCOR_BLOCK);
        compute(job, m, fill(job, at, m, &b), &b);
        if (keep_hue || job->stats != NULL) {
            p->kernel->find_outside(&b, flags);
            outside = count_flags(flags);
        }
        if (job->stats != NULL)
            job->stats->out_of_gamut += outside;
        lcor_internal_to_device(p, b.c[0], b.c[1], b.c[2]);
        if (m == LCOR_BLOCK && is_dense(p->out))
            p->kernel->store(job, at, &b);
        else
            lcor_internal_store_strided(job, at, m, b.c[0], b.c[1], b.c[2]);
        if (keep_hue && outside != 0)
            lcor_internal_gather(job, at, m, &b, flags, &q);
    }
    lcor_internal_flush(job, &q);
    if (job->stats != NULL)
        job->stats->pixels += job->n;
}
