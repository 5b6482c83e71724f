/* SPDX-License-Identifier: MIT */
#ifndef LCOR_ALLOC_H
#define LCOR_ALLOC_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Where an object gets its memory. All NULL means malloc and free.
 *
 *  `alloc` returns `size` bytes aligned for any type, or NULL. `free` is never called with NULL.
 *  Calls are made from the thread that calls the library, never from a task of lcor_parallel. */
typedef struct lcor_allocator {
    void *(*alloc)(size_t size, void *user);
    void (*free)(void *ptr, void *user);
    void *user;
} lcor_allocator;

#ifdef __cplusplus
}
#endif

#endif
