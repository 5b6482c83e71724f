/* SPDX-License-Identifier: MIT */
#include "pipeline.h"

#include "pack.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define BAND_BYTES ((size_t)256 * 1024)

/* What has been done with a band. GONE is EMPTY for the next band of the same slot. */
enum stage { EMPTY = 0, FULL = 1, DONE = 2, GONE = 3 };

typedef struct belt {
    const pipeline *pipeline;
    size_t band_rows, band_count; /* of the whole page */
    size_t slots;                 /* bands in memory: band i lies in slot i % slots */
    pipeline_band bands[PIPELINE_SLOTS_MAX];
    size_t reached[PIPELINE_SLOTS_MAX]; /* GONE * (i / slots) + stage, of band i in that slot */
    size_t taken;                       /* bands that workers have asked for */
    size_t usable;                      /* bands before the first one that failed */
    pthread_mutex_t lock;
    pthread_cond_t changed[GONE]; /* one for those who wait for a band that is EMPTY, FULL, DONE */
} belt;

typedef struct worker {
    belt *belt;
    size_t index;
} worker;

/* Rows in a band; the last one may have fewer. */
static size_t rows_of_band(size_t height, size_t row_bytes)
{
    const size_t rows = row_bytes < BAND_BYTES ? BAND_BYTES / row_bytes : 1;
    return rows < height ? rows : height;
}

static size_t bands_of_page(size_t height, size_t row_bytes)
{
    return (height - 1) / rows_of_band(height, row_bytes) + 1;
}

size_t pipeline_workers(size_t wanted, size_t height, size_t row_bytes)
{
    const size_t bands = bands_of_page(height, row_bytes);
    if (wanted == 0) {
        const long processors = sysconf(_SC_NPROCESSORS_ONLN);
        wanted = processors < 1 ? 1 : (size_t)processors;
    }
    if (wanted > PIPELINE_WORKERS_MAX)
        wanted = PIPELINE_WORKERS_MAX;
    return wanted < bands ? wanted : bands;
}

/* Band i has reached `stage`; or it failed, and nothing from it on will be used. */
static void settle(belt *b, size_t i, enum stage stage, bool good)
{
    pthread_mutex_lock(&b->lock);
    b->reached[i % b->slots] = GONE * (i / b->slots) + stage;
    pthread_cond_broadcast(&b->changed[stage % GONE]);
    if (!good && i < b->usable) {
        b->usable = i;
        for (int s = EMPTY; s < GONE; s++)
            pthread_cond_broadcast(&b->changed[s]);
    }
    pthread_mutex_unlock(&b->lock);
}

/* Wait until band i has reached `stage`; false if it never will. */
static bool await(belt *b, size_t i, enum stage stage)
{
    pthread_mutex_lock(&b->lock);
    while (i < b->usable && b->reached[i % b->slots] != GONE * (i / b->slots) + stage)
        pthread_cond_wait(&b->changed[stage], &b->lock);
    const bool usable = i < b->usable;
    pthread_mutex_unlock(&b->lock);
    return usable;
}

static bool fill(belt *b, size_t i)
{
    const pipeline *p = b->pipeline;
    pipeline_band *band = &b->bands[i % b->slots];
    band->first = i * b->band_rows;
    band->rows = p->height - band->first;
    if (band->rows > b->band_rows)
        band->rows = b->band_rows;
    return p->fill(p->user, band);
}

static void *fill_all(void *argument)
{
    belt *b = argument;
    for (size_t i = 0; i < b->band_count && await(b, i, EMPTY); i++)
        settle(b, i, FULL, fill(b, i));
    return NULL;
}

static void *work_all(void *argument)
{
    const worker *self = argument;
    belt *b = self->belt;
    const pipeline *p = b->pipeline;
    for (;;) {
        pthread_mutex_lock(&b->lock);
        const size_t i = b->taken++;
        pthread_mutex_unlock(&b->lock);
        if (!await(b, i, FULL))
            return NULL;
        settle(b, i, DONE, p->work(p->user, self->index, &b->bands[i % b->slots]));
    }
}

static bool empty_all(belt *b)
{
    const pipeline *p = b->pipeline;
    size_t i = 0;
    for (; i < b->band_count && await(b, i, DONE); i++)
        settle(b, i, GONE, p->empty(p->user, &b->bands[i % b->slots]));
    return i == b->band_count && b->usable == b->band_count;
}

/* With threads: a filler and at least one worker. False if the system gives none. */
static bool run_threads(belt *b, bool *good)
{
    pthread_t threads[PIPELINE_WORKERS_MAX + 1];
    worker workers[PIPELINE_WORKERS_MAX];
    const size_t wanted = b->pipeline->workers;
    size_t started = 0;
    const bool filler = pthread_create(&threads[wanted], NULL, fill_all, b) == 0;
    for (; filler && started < wanted; started++) {
        workers[started] = (worker){b, started};
        if (pthread_create(&threads[started], NULL, work_all, &workers[started]) != 0)
            break;
    }
    if (started == 0)
        settle(b, 0, EMPTY, false); /* sends the filler home */
    *good = empty_all(b);
    for (size_t i = 0; i < started; i++)
        pthread_join(threads[i], NULL);
    if (filler)
        pthread_join(threads[wanted], NULL);
    return started > 0;
}

bool pipeline_run(const pipeline *p, bool *no_memory)
{
    belt b = {.pipeline = p, .slots = p->workers + 2};
    bool good = false;
    b.band_rows = rows_of_band(p->height, p->row_bytes);
    b.band_count = bands_of_page(p->height, p->row_bytes);
    b.usable = b.band_count;
    if (b.slots > b.band_count)
        b.slots = b.band_count;
    *no_memory = false;
    for (size_t i = 0; i < b.slots; i++) {
        b.bands[i].slot = i;
        b.bands[i].pixels = malloc(b.band_rows * p->row_bytes + PACK_SLACK);
        b.bands[i].packed = malloc(b.band_rows * p->packed_row_bytes + PACK_SLACK);
        if (!b.bands[i].pixels || !b.bands[i].packed)
            *no_memory = true;
    }
    if (!*no_memory && b.band_count == 1) { /* not worth a thread */
        good = fill(&b, 0) && p->work(p->user, 0, &b.bands[0]) && p->empty(p->user, &b.bands[0]);
    } else if (!*no_memory) {
        pthread_mutex_init(&b.lock, NULL);
        for (int s = EMPTY; s < GONE; s++)
            pthread_cond_init(&b.changed[s], NULL);
        *no_memory = !run_threads(&b, &good);
        for (int s = EMPTY; s < GONE; s++)
            pthread_cond_destroy(&b.changed[s]);
        pthread_mutex_destroy(&b.lock);
    }
    for (size_t i = 0; i < b.slots; i++)
        free(b.bands[i].pixels), free(b.bands[i].packed);
    return good;
}
