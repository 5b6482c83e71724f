/* SPDX-License-Identifier: MIT */
#include "session/session.h"

#include <stdio.h>
#include <string.h>

int session_fail(const cal_error *err)
{
    int code = LCCAL_PROTOCOL;
    switch (err->status) {
    case CAL_OK:
    case CAL_TIMEOUT:
    case CAL_GONE:
    case CAL_PROTOCOL:
    case CAL_MISREAD:
    case CAL_CALIBRATE: break;
    case CAL_IO:
    case CAL_NO_MEMORY: code = LCCAL_FAILED; break;
    case CAL_UNSUPPORTED: code = LCCAL_USAGE; break;
    case CAL_NO_DEVICE: code = LCCAL_NO_INSTRUMENT; break;
    case CAL_PERMISSION:
    case CAL_BUSY: code = LCCAL_PERMISSION; break;
    case CAL_INTERRUPTED: code = LCCAL_INTERRUPTED; break;
    }
    return lccal_fail(code, "%s", err->text);
}

void session_describe(const instrument *in, char *text, size_t capacity)
{
    const char *model = instrument_fact_get(in, "model");
    const char *maker = *model ? instrument_fact_get(in, "maker") : "";
    const char *serial = instrument_fact_get(in, "serial");
    const char *firmware = instrument_fact_get(in, "firmware");
    snprintf(text, capacity, "%s%s%s%s%s%s%s", maker, *maker ? " " : "",
             *model ? model : in->driver->title, *serial ? ", serial " : "", serial,
             *firmware ? ", firmware " : "", firmware);
}

static void announce(const session *s)
{
    char text[256];
    session_describe(&s->in, text, sizeof text);
    lccal_say("%s on %s", text, s->in.port->name);
    if (s->in.driver->experimental)
        lccal_warn("the driver %s is experimental: compare its first readings with another "
                   "instrument's",
                   s->in.driver->name);
    json event = lccal_event("instrument");
    json_text(&event, "driver", s->in.driver->name);
    json_text(&event, "port", s->in.port->name);
    for (size_t i = 0; i < s->in.fact_count; i++)
        json_text(&event, s->in.facts[i].key, s->in.facts[i].value);
    lccal_event_end(&event);
}

int session_open(session *s, const lccal_measure_options *options)
{
    memset(s, 0, sizeof *s);
    s->options = options;
    cal_error err;
    transport *port;
    cal_status status = transport_open(options->port, &port, &err);
    if (status == CAL_OK && options->record)
        status = record_open(port, options->record, &port, &err);
    if (status != CAL_OK)
        return session_fail(&err);
    status = instrument_open(options->instrument ? options->instrument : "auto", port,
                             (int)(options->timeout * 1000.0), &s->in, &err);
    if (status != CAL_OK) {
        instrument_close(&s->in);
        return session_fail(&err);
    }
    announce(s);
    return LCCAL_OK;
}
