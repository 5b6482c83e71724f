/* SPDX-License-Identifier: MIT */
#include "instrument/instrument.h"

#include <stdio.h>
#include <string.h>

enum { LINE_LIMIT = 256, WRITE_MS = 1000, QUIET_MS = 100, DRAIN_MS = 2000, LATE_READS = 8 };

void instrument_fact_set(instrument *in, const char *key, const char *value, size_t n)
{
    size_t i = 0;
    while (i < in->fact_count && strcmp(in->facts[i].key, key) != 0)
        i++;
    if (i == INSTRUMENT_FACTS)
        return;
    if (i == in->fact_count)
        in->fact_count++;
    instrument_fact *fact = &in->facts[i];
    snprintf(fact->key, sizeof fact->key, "%s", key);
    size_t used = 0;
    for (size_t k = 0; k < n && used + 1 < sizeof fact->value; k++)
        if (value[k] >= 0x20 && value[k] < 0x7F && value[k] != '"') /* goes into text files */
            fact->value[used++] = value[k];
    fact->value[used] = '\0';
}

const char *instrument_fact_get(const instrument *in, const char *key)
{
    for (size_t i = 0; i < in->fact_count; i++)
        if (strcmp(in->facts[i].key, key) == 0)
            return in->facts[i].value;
    return "";
}

cal_status instrument_fail(const instrument *in, cal_status status, cal_error *err)
{
    const char *port = in->port->name;
    const char *title = in->driver->title;
    switch (status) {
    case CAL_TIMEOUT:
        return cal_fail(err, status, "%s on '%s' stayed silent; is it switched on and connected?",
                        title, port);
    case CAL_GONE:
        return cal_fail(err, status,
                        "%s on '%s' was unplugged or switched off; connect it and "
                        "start again",
                        title, port);
    case CAL_IO: return cal_fail(err, status, "the system cannot read or write '%s'", port);
    case CAL_PROTOCOL:
        return cal_fail(err, status,
                        "what answers on '%s' does not talk like %s; name another --instrument",
                        port, title);
    case CAL_UNSUPPORTED:
        return cal_fail(err, status, "'%s' cannot be set up as %s needs it", port, title);
    case CAL_MISREAD:
        return cal_fail(err, status, "%s could not read the patch; place it flat and read again",
                        title);
    case CAL_CALIBRATE:
        return cal_fail(err, status,
                        "%s wants to be calibrated; do that on its reference first (its manual "
                        "says how)",
                        title);
    case CAL_INTERRUPTED: return cal_fail(err, status, "interrupted");
    case CAL_OK:
    case CAL_NO_DEVICE:
    case CAL_PERMISSION:
    case CAL_BUSY:
    case CAL_NO_MEMORY: break;
    }
    return cal_fail(err, status, "cannot use '%s' as %s", port, title);
}

cal_status instrument_send(instrument *in, const char *command, cal_error *err)
{
    const cal_status status = in->port->ops->write(in->port, command, strlen(command), WRITE_MS);
    return status == CAL_OK ? status : instrument_fail(in, status, err);
}

/* A busy machine may let this program look long after bytes came. What the system holds by then is
 * read too; not for ever, since some ports never stop talking. */
cal_status instrument_fill(instrument *in, int64_t deadline)
{
    size_t got = 0;
    const int left = transport_left(in->port, deadline);
    in->late_reads = left > 0 ? 0 : in->late_reads + 1;
    if (in->late_reads > LATE_READS)
        return CAL_TIMEOUT;
    const cal_status status = in->port->ops->read(in->port, in->buffer + in->have,
                                                  sizeof in->buffer - in->have, &got, left);
    in->have += got;
    return status;
}

void instrument_drop(instrument *in, size_t n)
{
    in->have -= n;
    memmove(in->buffer, in->buffer + n, in->have);
}

cal_status instrument_discard(instrument *in)
{
    in->have = 0;
    return transport_drain(in->port, QUIET_MS, DRAIN_MS);
}

/* Is there more in the buffer than the line feed after the last line? */
static bool holds_text(const instrument *in)
{
    for (size_t i = 0; i < in->have; i++)
        if (in->buffer[i] != '\r' && in->buffer[i] != '\n')
            return true;
    return false;
}

static cal_status fail_unheard(const instrument *in, int timeout_ms, cal_error *err)
{
    if (in->noise == 0)
        return cal_fail(
            err, CAL_TIMEOUT,
            "'%s' sent nothing within %d s; press the instrument's button on the patch, or "
            "give yourself more time with --timeout",
            in->port->name, (timeout_ms + 999) / 1000);
    return cal_fail(err, CAL_PROTOCOL,
                    "'%s' sends text (lines: %u) but no reading; is --instrument right?",
                    in->port->name, in->noise);
}

cal_status instrument_listen(instrument *in, int timeout_ms, reading *out, cal_error *err)
{
    const int64_t deadline = in->port->ops->now_ms(in->port) + timeout_ms;
    for (;;) {
        size_t used = 0;
        switch (in->driver->parse(&in->format, in->buffer, in->have, &used, out)) {
        case PARSE_OK: instrument_drop(in, used); return CAL_OK;
        case PARSE_BAD:
            instrument_drop(in, used);
            in->noise++;
            continue;
        case PARSE_MORE: break;
        }
        /* A line that was begun is finished soon or never: cable noise, or half a reading from
         * before this program looked. */
        const bool begun = holds_text(in);
        const int64_t idle = in->port->ops->now_ms(in->port) + in->idle_ms;
        const bool last = !begun || idle >= deadline;
        const cal_status status = instrument_fill(in, last ? deadline : idle);
        if (status == CAL_TIMEOUT) {
            in->noise += begun;
            in->have = 0;
            if (last)
                return fail_unheard(in, timeout_ms, err);
        } else if (status != CAL_OK) {
            return instrument_fail(in, status, err);
        }
    }
}

parse_result line_split(const uint8_t *bytes, size_t n, size_t *start, size_t *length, size_t *used)
{
    size_t from = 0;
    while (from < n && (bytes[from] == '\r' || bytes[from] == '\n'))
        from++;
    size_t to = from;
    while (to < n && bytes[to] != '\r' && bytes[to] != '\n')
        to++;
    *start = from;
    *length = to - from;
    if (to < n) {
        *used = to + 1;
        return to - from < LINE_LIMIT ? PARSE_OK : PARSE_BAD;
    }
    if (to - from <= LINE_LIMIT)
        return PARSE_MORE;
    *used = to - LINE_LIMIT;
    return PARSE_BAD;
}

void instrument_close(instrument *in)
{
    if (!in->port)
        return;
    if (in->driver && in->driver->leave)
        in->driver->leave(in);
    in->port->ops->close(in->port);
    in->port = NULL;
}
