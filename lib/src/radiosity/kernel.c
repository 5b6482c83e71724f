/* SPDX-License-Identifier: MIT */
/* Coefficients of links, and the light that the sources send. */
#include "base/internal.h"
#include "geometry/vec.h"
#include "radiosity/links.h"
#include "radiosity/moments.h"
#include "radiosity/transfer.h"

#include <math.h>
#include <string.h>

enum { CHUNK = 16, BATCH = 64 };

/* Relative accuracy of the light an element gets: its moments are exact sources. */
static const double light_accuracy = 1e-6;

void links_run(const links *l, size_t n, void (*task)(void *arg, size_t i), void *arg)
{
    if (l->parallel.run && n > 1)
        l->parallel.run(l->parallel.user, n, task, arg);
    else
        for (size_t i = 0; i < n; i++)
            task(arg, i);
}

/* Axis of the receiver along which nodes are about as far from the sender's plane. */
static int level_axis(const links_element *r, const face *fr, const face *fs)
{
    return fabs(vec_dot(fr->u, fs->normal)) * r->c.hs < fabs(vec_dot(fr->v, fs->normal)) * r->c.ht
               ? 0
               : 1;
}

static void fill_open(const links *l, const links_link *link, double (*x)[3], links_block *block)
{
    const links_element *r = links_at(l, link->receiver), *s = links_at(l, link->sender);
    const face *fr = links_face_of(l, r), *fs = links_face_of(l, s);
    const int step = level_axis(r, fr, fs) == 0 ? RULE_P : 1, next = RULE_P + 1 - step;

    for (int line = 0; line < RULE_P; line++) {
        double at[TRANSFER_LANES][3], exact[TRANSFER_LANES];
        float weights[TRANSFER_LANES][RULE_Q];

        for (int i = 0; i < TRANSFER_LANES; i++) {
            vec_copy(x[line * next + i * step], at[i]);
            exact[i] = block->exact[line * next + i * step];
        }
        transfer_open(l->scene, at, fr->normal, fs, &s->c, (double)link->accuracy, exact, weights);
        for (int k = 0; k < RULE_Q; k++)
            for (int i = 0; i < TRANSFER_LANES; i++)
                block->k[k][line * next + i * step] = weights[i][k];
    }
}

static void fill_link(const links *l, const links_link *link)
{
    const links_element *r = links_at(l, link->receiver), *s = links_at(l, link->sender);
    links_block *block = (links_block *)l->blocks.items + link->block;
    double x[RULE_Q][3];
    transfer t;

    links_nodes(l, r, x);
    transfer_target(&t, l->scene, links_face_of(l, r)->normal, links_face_of(l, s),
                    (const uint32_t *)l->occluders.items + link->first_occluder,
                    link->occluder_count, (double)link->accuracy);
    if (link->factors != links_no_block)
        memcpy(block->exact, (double *)l->factors.items + (size_t)link->factors * RULE_Q,
               sizeof block->exact);
    else
        transfer_factors(&t, RULE_Q, x, &s->c, block->exact);
    if (transfer_is_open(&t, x[0], &s->c)) {
        fill_open(l, link, x, block);
        return;
    }
    for (int i = 0; i < RULE_Q; i++) {
        float weights[RULE_Q];

        transfer_aim(&t, x[i]);
        transfer_weights(&t, &s->c, block->exact[i], weights);
        for (int k = 0; k < RULE_Q; k++)
            block->k[k][i] = weights[k];
    }
}

typedef struct fill_job {
    const links *l;
    size_t first_new;   /* blocks from here on are empty */
    size_t first_chunk; /* of this batch */
} fill_job;

static void fill_task(void *arg, size_t chunk)
{
    const fill_job *job = arg;
    const size_t begin = (job->first_chunk + chunk) * CHUNK;

    for (size_t i = begin; i < begin + CHUNK && i < job->l->list.count; i++) {
        const links_link *link = (const links_link *)job->l->list.items + i;

        if (link->block >= job->first_new)
            fill_link(job->l, link);
    }
}

/* Stable sort by receiver, with counters in the scratch array. */
static int sort_links(links *l)
{
    const size_t n = l->elements.count;
    lcor_array sorted = {0};
    uint32_t *start;
    links_link *out;

    l->scratch.count = 0;
    start = lcor_array_reserve(&l->allocator, &l->scratch, n + 1, sizeof *start);
    out = lcor_array_reserve(&l->allocator, &sorted, l->list.count, sizeof *out);
    if (!start || !out) {
        lcor_array_clear(&l->allocator, &sorted);
        return 0;
    }
    memset(start, 0, (n + 1) * sizeof *start);
    for (size_t i = 0; i < l->list.count; i++)
        start[((links_link *)l->list.items)[i].receiver + 1]++;
    for (size_t i = 0; i < n; i++)
        start[i + 1] += start[i];
    for (size_t i = 0; i < l->list.count; i++) {
        const links_link *link = (links_link *)l->list.items + i;

        out[start[link->receiver]++] = *link;
    }
    sorted.count = l->list.count;
    lcor_array_clear(&l->allocator, &l->list);
    l->list = sorted;
    return 1;
}

/* Moves the blocks still in use to the front, so that dropped links cost nothing. */
static void compact_blocks(links *l)
{
    links_block *blocks = l->blocks.items;
    uint32_t *owner = l->scratch.items;
    size_t kept = 0;

    memset(owner, 0xff, l->blocks.count * sizeof *owner);
    for (size_t i = 0; i < l->list.count; i++) {
        const links_link *link = (links_link *)l->list.items + i;

        if (link->block != links_no_block)
            owner[link->block] = (uint32_t)i;
    }
    for (size_t b = 0; b < l->blocks.count; b++)
        if (owner[b] != links_no_block) {
            if (kept != b)
                blocks[kept] = blocks[b];
            ((links_link *)l->list.items)[owner[b]].block = (uint32_t)kept++;
        }
    l->blocks.count = kept;
}

int links_fill(links *l)
{
    fill_job job = {l, 0, 0};
    size_t missing, chunks;

    if (!sort_links(l))
        return 0;
    l->scratch.count = 0;
    if (!lcor_array_reserve(&l->allocator, &l->scratch, l->blocks.count, sizeof(uint32_t)))
        return 0;
    compact_blocks(l);
    missing = l->list.count - l->blocks.count;
    if (!lcor_array_reserve(&l->allocator, &l->blocks, missing, sizeof(links_block)))
        return 0;
    job.first_new = l->blocks.count;
    for (size_t i = 0; i < l->list.count; i++) {
        links_link *link = (links_link *)l->list.items + i;

        if (link->block == links_no_block)
            link->block = (uint32_t)l->blocks.count++;
    }
    chunks = (l->list.count + CHUNK - 1) / CHUNK;
    for (; job.first_chunk < chunks && !l->cancelled; job.first_chunk += BATCH) {
        const size_t left = chunks - job.first_chunk;

        links_run(l, left < BATCH ? left : BATCH, fill_task, &job);
        l->poll(l);
    }
    for (size_t i = 0; i < l->list.count; i++)
        ((links_link *)l->list.items)[i].factors = links_no_block;
    l->factors.count = 0;
    return !l->cancelled;
}

/* Radiosity that a leaf has before any interreflection: emission, and the reflected direct light
 * by its moments, which stay right where shadows cut the element. */
static void leaf_source(const links *l, size_t element)
{
    links_element *e = links_at(l, element);
    const face *f = links_face_of(l, e);
    const lcor_surface *look = face_look(l->scene, f);
    const size_t lights = l->scene->lights.count;
    double *out = links_values(l, &l->source, element);
    double area[RULE_Q], weights[RULE_Q];

    links_node_areas(l, e, area);
    e->power = 0;
    for (int c = 0; c < l->channels; c++) {
        const double emission = light_channel(l->lights, look->emission, c);

        e->power += emission * e->area / l->channels;
        for (int k = 0; k < RULE_Q; k++)
            out[c * RULE_Q + k] = emission;
    }
    for (size_t i = 0; i < lights; i++) {
        const links_shadow *shadow = &l->shadows[e->face * lights + i];
        const lcor_light *light = scene_light_at(l->scene, i);
        moments m;
        double flux;

        if (shadow->dark || f->covered)
            continue;
        moments_aim(&m, l->scene, light, f, (const uint32_t *)l->occluders.items + shadow->first,
                    shadow->count, light_accuracy);
        flux = moments_of(&m, &e->c, weights);
        for (int c = 0; c < l->channels; c++) {
            const double intensity = light_channel(l->lights, light->intensity, c);
            const double sent = intensity * light_channel(l->lights, look->reflectance, c);

            e->power += intensity * flux / l->channels;
            for (int k = 0; k < RULE_Q; k++)
                out[c * RULE_Q + k] += sent * weights[k] / area[k];
        }
    }
}

static void source_task(void *arg, size_t chunk)
{
    const links *l = arg;

    for (size_t i = chunk * CHUNK; i < (chunk + 1) * CHUNK && i < l->elements.count; i++)
        if (links_at(l, i)->child < 0)
            leaf_source(l, i);
}

void links_set_source(links *l)
{
    links_run(l, (l->elements.count + CHUNK - 1) / CHUNK, source_task, l);
}

void links_node_areas(const links *l, const links_element *e, double area[RULE_Q])
{
    const face *f = links_face_of(l, e);

    for (int a = 0; a < RULE_P; a++) {
        const double s = f->triangle ? e->c.s0 + rule_x[a] * e->c.hs : 1;

        for (int b = 0; b < RULE_P; b++)
            area[a * RULE_P + b] = f->jacobian * e->c.hs * e->c.ht * s * rule_w[a] * rule_w[b];
    }
}
