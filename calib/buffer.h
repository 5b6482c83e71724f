/* SPDX-License-Identifier: MIT */
/* Text or bytes that grow. */
#ifndef LCCAL_BUFFER_H
#define LCCAL_BUFFER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Zero-initialise. Once memory is short `failed` stays set and nothing more is added. */
typedef struct buffer {
    char *bytes; /* NUL-terminated once something was added */
    size_t size, room;
    bool failed;
} buffer;

void buffer_free(buffer *b);
void buffer_bytes(buffer *b, const void *bytes, size_t n);
void buffer_text(buffer *b, const char *text);
/* At most `decimals` (0..9) digits after the point, without zeros at the end. */
void buffer_number(buffer *b, double value, int decimals);
/* Big-endian, as ICC has it. */
void buffer_u16(buffer *b, uint32_t value);
void buffer_u32(buffer *b, uint32_t value);

#endif
