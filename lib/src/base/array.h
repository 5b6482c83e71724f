/* SPDX-License-Identifier: MIT */
/* Growing arrays through the caller's allocator. */
#ifndef LCOR_BASE_ARRAY_H
#define LCOR_BASE_ARRAY_H

#include <lcor/alloc.h>

#include <stddef.h>

/* An array of `count` items of one size in use, room for `capacity`. Zero-initialise. */
typedef struct lcor_array {
    void *items;
    size_t count, capacity;
} lcor_array;

/* Makes room for `more` items behind the used ones and returns the first of them, without counting
 * them as used; NULL if there is no memory. Items may move. */
void *lcor_array_reserve(const lcor_allocator *allocator, lcor_array *array, size_t more,
                         size_t item_size);

/* Releases the items; the array is empty and usable afterwards. */
void lcor_array_clear(const lcor_allocator *allocator, lcor_array *array);

#endif
