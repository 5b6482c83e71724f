/* SPDX-License-Identifier: MIT */
/* A row on the float path, block by block: read, light, chroma, what left the gamut, write. */
#include "correct/lanes.h"
#include "correct/sample.h"

#include <string.h>

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
    suspect = job->plan->kernel.maps(job->plan, i, rho, b);
    for (size_t j = m; j < LCOR_BLOCK; j++) {
        b->v[j] = 0.0f;
        b->t[j] = 0.5f; /* neither below J1 nor above J2 */
    }
    return suspect;
}

/* X, Y, Z and Ynew of a block of samples. Not 0 if some are bad: with `bad`, a second call does
 * without them and counts them. */
static int light(const lcor_row_job *job, size_t at, size_t m, size_t *bad, lcor_block *b)
{
    const lcor_plan *p = job->plan;
    const int are_pixels = m == LCOR_BLOCK && bad == NULL && !p->decode_by_power &&
                           p->decode_table == NULL && lcor_internal_is_interleaved(p->in);
    int suspect = 0;

    if (are_pixels && p->in_type == LCOR_F32)
        return p->kernel.lightness(&p->k, (const float *)job->texels + 3 * at, b);
    if (are_pixels && p->in_type == LCOR_U8) {
        p->kernel.lightness_of_bytes(&p->k, (const uint8_t *)job->texels + 3 * at, b);
        return 0;
    }
    if (are_pixels) {
        p->kernel.widen(LCOR_U16, 3, (const uint16_t *)job->texels + 3 * at, b->g[0]);
        return p->kernel.lightness(&p->k, b->g[0], b);
    }
    lcor_internal_load_texels(job, at, m, b);
    if (bad != NULL)
        *bad = lcor_internal_replace_bad(job, at, m, b->c, b);
    for (size_t k = 0; p->decode_by_power && k < 3; k++)
        suspect |= p->colour.transfer == LCOR_TRANSFER_SRGB
                       ? p->kernel.from_srgb(&p->k.srgb, b->c[k])
                       : p->kernel.power(&p->k.decode, b->c[k]);
    return suspect | p->kernel.lightness_of_planes(&p->k, b);
}

/* Y, Ynew and 1 - f of X, Y, Z, where f is there already. */
static int light_of_f(const lcor_row_job *job, size_t at, size_t m, size_t *bad, lcor_block *b)
{
    const lcor_plan *p = job->plan;
    float LCOR_ALIGNED f[3][LCOR_BLOCK];

    if (m == LCOR_BLOCK && bad == NULL)
        return p->kernel.lightness_of_f(&p->k, job->f + at, job->plane, b);
    lcor_internal_load_f(job, at, m, f);
    if (bad != NULL)
        *bad = lcor_internal_replace_bad(job, at, m, f, b);
    return p->kernel.lightness_of_f(&p->k, f[0], LCOR_BLOCK, b);
}

/* Chroma and lightness of a block, up to linear RGB that is not yet clamped. */
static void compute(const lcor_row_job *job, size_t at, size_t m, lcor_block *b)
{
    const lcor_plan *p = job->plan;
    int (*const lit)(const lcor_row_job *, size_t, size_t, size_t *, lcor_block *) =
        job->f != NULL ? light_of_f : light;
    size_t bad = 0;

    if (read_maps(job, at, m, b) | lit(job, at, m, NULL, b))
        lit(job, at, m, &bad, b); /* rule S10 */
    if (job->stats != NULL) {
        p->kernel.count(&p->k, b, job->stats);
        if (p->k.w < 0.0f) /* T of what is bad or beyond the end: stands there as black */
            job->stats->clipped_low -= bad + (LCOR_BLOCK - m);
    }
    if (job->f == NULL)
        p->kernel.g(b->c[0], b->g[0], 4);
    else
        p->kernel.g(b->c[3], b->g[3], 1);
    p->kernel.chroma(&p->k, b);
}

/* Pixels whose colour float leaves open: out of the gamut, or too near its faces to say. */
typedef struct open_pixels {
    lcor_lanes lanes;
    size_t count, at[LCOR_LANES];
} open_pixels;

/* The reference gives them their count, and by rule S9 their colour: into the block at hand, or
 * over what float wrote of blocks before. */
static void settle(const lcor_row_job *job, size_t at, lcor_block *b, open_pixels *open)
{
    const lcor_plan *p = job->plan;
    float LCOR_ALIGNED values[LCOR_BLOCK] = {0.0f};
    size_t earlier = 0;

    lcor_internal_correct_lanes(job, &open->lanes);
    for (size_t i = 0; job->stats != NULL && i < open->count; i++)
        job->stats->out_of_gamut += open->lanes.outside[i] != 0.0;
    if (p->settles) {
        for (size_t i = 0; i < open->count; i++)
            for (size_t k = 0; k < 3; k++) {
                values[3 * i + k] = (float)open->lanes.c[k][i];
                if (open->at[i] >= at)
                    b->c[k][open->at[i] - at] = values[3 * i + k];
            }
        lcor_internal_to_device(p, values);
        while (earlier < open->count && open->at[earlier] < at)
            earlier++;
        lcor_internal_store_apart(job, earlier, open->at, values);
    }
    open->count = 0;
}

static void find_open(const lcor_row_job *job, size_t at, size_t m, lcor_block *b,
                      open_pixels *open)
{
    int32_t LCOR_ALIGNED outside[LCOR_BLOCK];
    uint8_t list[LCOR_BLOCK];
    size_t count = 0;

    job->plan->kernel.find_outside(&job->plan->k, b, outside);
    for (size_t j = 0; j < m; j += 8) {
        uint64_t two[4];

        memcpy(two, outside + j, sizeof two);
        if ((two[0] | two[1] | two[2] | two[3]) == 0)
            continue;
        for (size_t i = j; i < j + 8 && i < m; i++) {
            list[count] = (uint8_t)i;
            count += outside[i] != 0;
        }
    }
    for (size_t i = 0, more; i < count; i += more) {
        const size_t room = LCOR_LANES - open->count;

        more = count - i < room ? count - i : room;
        lcor_internal_load_lanes(job, at, list + i, more, &open->lanes, open->count);
        for (size_t j = i; j < i + more; j++)
            open->at[open->count++] = at + list[j];
        if (open->count == LCOR_LANES)
            settle(job, at, b, open);
    }
}

void lcor_internal_correct_blocks(const lcor_row_job *job)
{
    const int are_exact = job->plan->settles || job->stats != NULL;
    open_pixels open;
    lcor_block b;

    memset(&open, 0, sizeof open);
    for (size_t at = 0; at < job->n; at += LCOR_BLOCK) {
        const size_t m = job->n - at < LCOR_BLOCK ? job->n - at : LCOR_BLOCK;

        compute(job, at, m, &b);
        if (are_exact)
            find_open(job, at, m, &b, &open);
        for (int k = 0; k < 3; k++)
            lcor_internal_to_device(job->plan, b.c[k]);
        lcor_internal_store_pixels(job, at, m, &b);
    }
    if (open.count > 0)
        settle(job, job->n, &b, &open);
    if (job->stats != NULL)
        job->stats->pixels += job->n;
}
