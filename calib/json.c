/* SPDX-License-Identifier: MIT */
#include "json.h"

#include <math.h>
#include <stdio.h>

/* Length of the well-formed UTF-8 character at s, or 0. */
static size_t utf8_length(const unsigned char *s)
{
    static const struct {
        unsigned char mask, lead, length, second_min_lead, second_min;
    } forms[] = {{0x80, 0x00, 1, 0, 0},
                 {0xE0, 0xC0, 2, 0, 0},
                 {0xF0, 0xE0, 3, 0xE0, 0xA0},
                 {0xF8, 0xF0, 4, 0xF0, 0x90}};
    for (size_t i = 0; i < sizeof forms / sizeof forms[0]; i++) {
        if ((s[0] & forms[i].mask) != forms[i].lead)
            continue;
        for (size_t k = 1; k < forms[i].length; k++)
            if ((s[k] & 0xC0) != 0x80)
                return 0;
        if (forms[i].length == 2 && s[0] < 0xC2)
            return 0; /* overlong */
        if (forms[i].length > 2 && s[0] == forms[i].second_min_lead && s[1] < forms[i].second_min)
            return 0; /* overlong */
        if ((s[0] == 0xED && s[1] > 0x9F) || s[0] > 0xF4 || (s[0] == 0xF4 && s[1] > 0x8F))
            return 0; /* surrogate, or beyond U+10FFFF */
        return forms[i].length;
    }
    return 0;
}

static void put_string(buffer *out, const char *value)
{
    buffer_text(out, "\"");
    for (const unsigned char *s = (const unsigned char *)value; *s;) {
        char escaped[8];
        const size_t n = utf8_length(s);
        if (n == 0) {
            buffer_text(out, "\\ufffd");
        } else if (n == 1 && (*s < 0x20 || *s == '"' || *s == '\\')) {
            snprintf(escaped, sizeof escaped, "\\u%04x", (unsigned)*s);
            buffer_text(out, escaped);
        } else {
            buffer_bytes(out, s, n);
        }
        s += n > 0 ? n : 1;
    }
    buffer_text(out, "\"");
}

/* What stands before a value. */
static void begin_value(json *j, const char *key)
{
    if (j->comma)
        buffer_text(&j->out, ",");
    j->comma = true;
    if (key) {
        put_string(&j->out, key);
        buffer_text(&j->out, ":");
    }
}

void json_open(json *j, const char *key, char bracket)
{
    begin_value(j, key);
    buffer_bytes(&j->out, &bracket, 1);
    j->comma = false;
}

void json_close(json *j, char bracket)
{
    buffer_bytes(&j->out, &bracket, 1);
    j->comma = true;
}

void json_text(json *j, const char *key, const char *value)
{
    begin_value(j, key);
    put_string(&j->out, value);
}

void json_number(json *j, const char *key, double value, int decimals)
{
    begin_value(j, key);
    if (fabs(value) < 1e12)
        buffer_number(&j->out, value, decimals);
    else
        buffer_text(&j->out, "null");
}

void json_bool(json *j, const char *key, bool value)
{
    begin_value(j, key);
    buffer_text(&j->out, value ? "true" : "false");
}
