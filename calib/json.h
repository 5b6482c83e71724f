/* SPDX-License-Identifier: MIT */
/* JSON text, written from front to back. */
#ifndef LCCAL_JSON_H
#define LCCAL_JSON_H

#include "buffer.h"

/* Zero-initialise. The key of each value is NULL inside a list and for the outermost value. */
typedef struct json {
    buffer out;
    bool comma; /* a value stands before the next one */
} json;

/* '{' or '[' */
void json_open(json *j, const char *key, char bracket);
/* '}' or ']' */
void json_close(json *j, char bracket);
/* Bytes that are not UTF-8 become U+FFFD. */
void json_text(json *j, const char *key, const char *value);
/* At most `decimals` (0..9) digits after the point; null when not finite, or 1e12 and more. */
void json_number(json *j, const char *key, double value, int decimals);
void json_bool(json *j, const char *key, bool value);

#endif
