/* SPDX-License-Identifier: MIT */
/* Bands of rows on their way through threads: one thread fills them in order, as many as there are
 * processors work on them in any order, the calling thread empties them in order. Memory is a fixed
 * number of bands, and what comes out does not depend on the number of threads. */
#ifndef RASTERTOLCOR_PIPELINE_H
#define RASTERTOLCOR_PIPELINE_H

#include <stdbool.h>
#include <stddef.h>

typedef struct pipeline_band {
    size_t first, rows; /* rows of the page it holds */
    unsigned char *pixels;
    unsigned char *packed; /* the rows as they go out, if they are packed */
    size_t packed_size;
    size_t slot; /* 0..PIPELINE_SLOTS_MAX-1: which of the bands in memory it is */
} pipeline_band;

typedef struct pipeline {
    size_t height, row_bytes;
    size_t packed_row_bytes; /* room in `packed` for a row */
    size_t workers;          /* what pipeline_workers says */
    /* False ends everything, as soon as the bands before it have gone through. */
    bool (*fill)(void *user, pipeline_band *band);
    bool (*work)(void *user, size_t worker, pipeline_band *band);
    bool (*empty)(void *user, pipeline_band *band);
    void *user;
} pipeline;

#define PIPELINE_WORKERS_MAX 8
#define PIPELINE_SLOTS_MAX   (PIPELINE_WORKERS_MAX + 2) /* one being filled, one being emptied */

/* Number of workers for a page, 1..PIPELINE_WORKERS_MAX: as many as wanted (0: as there are
 * processors), but none has less to do than a band, which is about 256 KiB whatever the machine. */
size_t pipeline_workers(size_t wanted, size_t height, size_t row_bytes);
/* True if every band went through. False with *no_memory set if it could not start. */
bool pipeline_run(const pipeline *pipeline, bool *no_memory);

#endif
