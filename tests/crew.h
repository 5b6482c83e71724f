/* SPDX-License-Identifier: MIT */
/* A parallel-for on real threads, as a caller of the library would write it: each takes the next
 * task until there is none. */
#ifndef LCOR_TEST_CREW_H
#define LCOR_TEST_CREW_H

#include <pthread.h>
#include <stddef.h>

enum { CREW_MOST = 8 };

/* Set `threads`, the rest to 0; `calls` counts. */
typedef struct crew {
    int threads, calls;
    size_t n, next;
    pthread_mutex_t lock;
    void (*task)(void *arg, size_t i);
    void *arg;
} crew;

static void *crew_work(void *user)
{
    crew *c = user;

    for (;;) {
        size_t i;

        pthread_mutex_lock(&c->lock);
        i = c->next++;
        pthread_mutex_unlock(&c->lock);
        if (i >= c->n)
            return NULL;
        c->task(c->arg, i);
    }
}

/* An lcor_parallel's run; `user` is a crew. Goes on with fewer threads where there are no more. */
static inline void crew_run(void *user, size_t n, void (*task)(void *arg, size_t i), void *arg)
{
    crew *c = user;
    pthread_t others[CREW_MOST];
    int started = 0;

    c->calls++;
    c->n = n;
    c->next = 0;
    c->task = task;
    c->arg = arg;
    pthread_mutex_init(&c->lock, NULL);
    while (started < c->threads - 1 && started < CREW_MOST &&
           pthread_create(&others[started], NULL, crew_work, c) == 0)
        started++;
    (void)crew_work(c);
    for (int i = 0; i < started; i++)
        pthread_join(others[i], NULL);
    pthread_mutex_destroy(&c->lock);
}

#endif
