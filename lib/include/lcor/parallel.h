/* SPDX-License-Identifier: MIT */
#ifndef LCOR_PARALLEL_H
#define LCOR_PARALLEL_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/** The caller's threads. liblcor starts none.
 *
 *  `run` calls task(arg, i) once for each i in 0..n-1, in any order and on any threads, and
 *  returns when all have finished. NULL `run` means one after another on the calling thread.
 *  Results of the library have the same bits whatever `run` does. */
typedef struct lcor_parallel {
    void (*run)(void *user, size_t n, void (*task)(void *arg, size_t i), void *arg);
    void *user;
} lcor_parallel;

/** Progress and cancelling of long calls.
 *
 *  `report` is called from the thread that made the long call with the part done, 0..1 and never
 *  falling; returning nonzero makes the call end with LCOR_ERR_CANCELLED. NULL is allowed. */
typedef struct lcor_progress {
    int (*report)(void *user, double done);
    void *user;
} lcor_progress;

#ifdef __cplusplus
}
#endif

#endif
