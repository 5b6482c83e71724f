/* SPDX-License-Identifier: MIT */
#include "message.h"
#include "lccal.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

/* How this run of the program talks; set once while the options are read. */
static bool json_events;
static bool be_quiet;

void message_set_json(bool on) { json_events = on; }
void message_set_quiet(bool on) { be_quiet = on; }
bool lccal_json(void) { return json_events; }
bool lccal_quiet(void) { return be_quiet; }

int lccal_fail(int code, const char *format, ...)
{
    char text[1024];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    fprintf(stderr, "lccal: %s\n", text);
    lccal_event_begin("error");
    lccal_event_number("code", code, 0);
    lccal_event_text("text", text);
    lccal_event_end();
    return code;
}

void lccal_warn(const char *format, ...)
{
    char text[1024];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    fprintf(stderr, "lccal: warning: %s\n", text);
    lccal_event_begin("warning");
    lccal_event_text("text", text);
    lccal_event_end();
}

void lccal_say(const char *format, ...)
{
    if (be_quiet)
        return;
    va_list args;
    va_start(args, format);
    vfprintf(stderr, format, args);
    va_end(args);
    fputc('\n', stderr);
}

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

static void put_json_string(const char *value)
{
    putchar('"');
    for (const unsigned char *s = (const unsigned char *)value; *s;) {
        const size_t n = utf8_length(s);
        if (n == 0) {
            fputs("\\ufffd", stdout);
            s++;
        } else if (n == 1 && (*s < 0x20 || *s == '"' || *s == '\\')) {
            printf("\\u%04x", (unsigned)*s++);
        } else {
            fwrite(s, 1, n, stdout);
            s += n;
        }
    }
    putchar('"');
}

static bool put_key(const char *key)
{
    if (json_events)
        printf(",\"%s\":", key);
    return json_events;
}

void lccal_event_begin(const char *name)
{
    if (json_events)
        printf("{\"event\":\"%s\"", name);
}

void lccal_event_text(const char *key, const char *value)
{
    if (put_key(key))
        put_json_string(value);
}

void lccal_event_number(const char *key, double value, int decimals)
{
    char text[64];
    if (!put_key(key))
        return;
    fputs(fabs(value) < 1e12 ? lccal_format_number(text, sizeof text, value, decimals) : "null",
          stdout);
}

void lccal_event_bool(const char *key, bool value)
{
    if (put_key(key))
        fputs(value ? "true" : "false", stdout);
}

void lccal_event_end(void)
{
    if (!json_events)
        return;
    fputs("}\n", stdout);
    fflush(stdout);
}
