/* SPDX-License-Identifier: MIT */
#include "buffer.h"

#include "lccal.h"

#include <stdlib.h>
#include <string.h>

void buffer_free(buffer *b)
{
    free(b->bytes);
    *b = (buffer){0};
}

void buffer_bytes(buffer *b, const void *bytes, size_t n)
{
    if (b->failed || n == 0)
        return;
    if (b->room - b->size <= n) {
        size_t room = b->room ? b->room : 1024;
        while (room - b->size <= n && room < SIZE_MAX / 2)
            room *= 2;
        char *const larger = room - b->size > n ? realloc(b->bytes, room) : NULL;
        if (!larger) {
            b->failed = true;
            return;
        }
        b->bytes = larger;
        b->room = room;
    }
    memcpy(b->bytes + b->size, bytes, n);
    b->size += n;
    b->bytes[b->size] = '\0';
}

void buffer_text(buffer *b, const char *text) { buffer_bytes(b, text, strlen(text)); }

void buffer_number(buffer *b, double value, int decimals)
{
    char text[64];
    lccal_format_number(text, sizeof text, value, decimals);
    size_t n = strlen(text);
    if (strchr(text, '.')) {
        while (text[n - 1] == '0')
            n--;
        n -= text[n - 1] == '.';
    }
    buffer_bytes(b, text, n);
}

void buffer_u16(buffer *b, uint32_t value)
{
    const unsigned char bytes[] = {(unsigned char)(value >> 8 & 0xFF),
                                   (unsigned char)(value & 0xFF)};
    buffer_bytes(b, bytes, sizeof bytes);
}

void buffer_u32(buffer *b, uint32_t value)
{
    buffer_u16(b, value >> 16);
    buffer_u16(b, value & 0xFFFF);
}
