/* SPDX-License-Identifier: MIT */
/* An allocator that runs out of memory at a given allocation and counts what is not freed. */
#ifndef LCOR_TEST_FAILING_H
#define LCOR_TEST_FAILING_H

#include <lcor/alloc.h>
#include <stdlib.h>

/* Allocations that succeed yet, and pieces that are held. */
typedef struct failing {
    long left, live;
} failing;

static void *failing_alloc(size_t size, void *user)
{
    failing *f = user;
    void *p = f->left-- > 0 ? malloc(size) : NULL;

    f->live += p != NULL;
    return p;
}

static void failing_free(void *p, void *user)
{
    ((failing *)user)->live -= p != NULL;
    free(p);
}

static inline lcor_allocator failing_allocator(failing *f)
{
    return (lcor_allocator){failing_alloc, failing_free, f};
}

#endif
