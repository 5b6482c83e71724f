/* SPDX-License-Identifier: MIT */
#include "base/internal.h"

#include <stdint.h>
#include <stdlib.h>

static void *default_alloc(size_t size, void *user)
{
    (void)user;
    return malloc(size);
}

static void default_free(void *ptr, void *user)
{
    (void)user;
    free(ptr);
}

lcor_status lcor_internal_allocator(const lcor_allocator *given, lcor_allocator *out,
                                    lcor_error *err)
{
    if (given != NULL && (given->alloc == NULL) != (given->free == NULL))
        return lcor_internal_fail(err, LCOR_ERR_ARG, -1,
                                  "allocator needs both alloc and free, or neither");
    if (given != NULL && given->alloc != NULL) {
        *out = *given;
    } else {
        out->alloc = default_alloc;
        out->free = default_free;
        out->user = NULL;
    }
    return LCOR_OK;
}

void *lcor_internal_alloc(const lcor_allocator *allocator, size_t size)
{
    /* malloc(0) may return NULL, which callers read as out of memory */
    return allocator->alloc(size != 0 ? size : 1, allocator->user);
}

void lcor_internal_free(const lcor_allocator *allocator, void *ptr)
{
    if (ptr != NULL)
        allocator->free(ptr, allocator->user);
}

int lcor_internal_size_mul(size_t a, size_t b, size_t *out)
{
    if (b != 0 && a > SIZE_MAX / b)
        return 0;
    *out = a * b;
    return 1;
}

int lcor_internal_size_add(size_t a, size_t b, size_t *out)
{
    if (a > SIZE_MAX - b)
        return 0;
    *out = a + b;
    return 1;
}
