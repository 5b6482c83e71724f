/* SPDX-License-Identifier: MIT */
#include "message.h"
#include "json.h"
#include "lccal.h"

#include <stdarg.h>
#include <stdio.h>

/* How this run of the program talks; set once while the options are read. */
static bool json_events;
static bool be_quiet;

void message_set_json(bool on) { json_events = on; }
void message_set_quiet(bool on) { be_quiet = on; }
bool lccal_json(void) { return json_events; }
bool lccal_quiet(void) { return be_quiet; }

static int fail(json *event, int code, const char *format, va_list args)
{
    char text[1024];
    vsnprintf(text, sizeof text, format, args);
    fprintf(stderr, "lccal: %s\n", text);
    json_number(event, "code", code, 0);
    json_text(event, "text", text);
    lccal_event_end(event);
    return code;
}

int lccal_fail(int code, const char *format, ...)
{
    json event = lccal_event("error");
    va_list args;
    va_start(args, format);
    const int result = fail(&event, code, format, args);
    va_end(args);
    return result;
}

int lccal_fail_as(json *event, int code, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    const int result = fail(event, code, format, args);
    va_end(args);
    return result;
}

void lccal_warn(const char *format, ...)
{
    char text[1024];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    fprintf(stderr, "lccal: warning: %s\n", text);
    json event = lccal_event("warning");
    json_text(&event, "text", text);
    lccal_event_end(&event);
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

json lccal_event(const char *name)
{
    json event = {.comma = false};
    json_open(&event, NULL, '{');
    json_text(&event, "event", name);
    return event;
}

void lccal_event_end(json *event)
{
    json_close(event, '}');
    buffer_text(&event->out, "\n");
    if (json_events && !event->out.failed) {
        fwrite(event->out.bytes, 1, event->out.size, stdout);
        fflush(stdout);
    }
    lccal_event_drop(event);
}

void lccal_event_drop(json *event) { buffer_free(&event->out); }
