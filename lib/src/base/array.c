/* SPDX-License-Identifier: MIT */
#include "base/array.h"

#include "base/internal.h"

#include <string.h>

void *lcor_array_reserve(const lcor_allocator *allocator, lcor_array *array, size_t more,
                         size_t item_size)
{
    size_t need, bytes;

    if (!lcor_internal_size_add(array->count, more, &need))
        return NULL;
    if (need > array->capacity || array->items == NULL) {
        size_t capacity = array->capacity + array->capacity / 2 + 16;
        void *items;

        if (capacity < need)
            capacity = need;
        if (!lcor_internal_size_mul(capacity, item_size, &bytes))
            return NULL;
        items = lcor_internal_alloc(allocator, bytes);
        if (!items)
            return NULL;
        if (array->items)
            memcpy(items, array->items, array->count * item_size);
        lcor_internal_free(allocator, array->items);
        array->items = items;
        array->capacity = capacity;
    }
    return (char *)array->items + array->count * item_size;
}

void lcor_array_clear(const lcor_allocator *allocator, lcor_array *array)
{
    lcor_internal_free(allocator, array->items);
    array->items = NULL;
    array->count = array->capacity = 0;
}
