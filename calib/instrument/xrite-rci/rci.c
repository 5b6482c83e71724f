/* SPDX-License-Identifier: MIT */
/* X-Rite's remote control interface (DTP41): commands are arguments in hex digits, a mnemonic and
 * CR; an answer is data and a status such as <00>. A reading is X, Y, Z in percent of white, the
 * form of output that other programs are known to use; its visual density is -log10(Y/100). */
#include "instrument/xrite-rci/rci.h"
#include "number.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum {
    PROBE_MS = 500,
    SET_UP_MS = 1500,
    READ_MS = 20000,
    FETCH_MS = 5000,
    CLEAR_MS = 500,
    MISREADS = 2,
    RCI_OK = 0x00,
    RCI_BUSY = 0x14,
    RCI_ERROR = 0x20,
    RCI_TIMED_OUT = 0x21,
    RCI_BAD_READING = 0x27,
    RCI_CALIBRATE = 0x28,
    RCI_INSTRUMENT = 0x30,
    RCI_DRIVE = 0x34,
    RCI_ADC = 0x38,
    RCI_LAMP = 0x3F,
    RCI_BAD_COMMAND = 0x11,
    RCI_PARAMETERS = 0x12,
    RCI_RANGE = 0x13,
    RCI_INVALID = 0x40
};

cal_status rci_meaning(int status)
{
    switch (status) {
    case RCI_OK: return CAL_OK;
    case RCI_BUSY:
    case RCI_ERROR:
    case RCI_TIMED_OUT:
    case RCI_BAD_READING:
    case RCI_INSTRUMENT:
    case RCI_DRIVE:
    case RCI_ADC:
    case RCI_LAMP: return CAL_MISREAD;
    case RCI_CALIBRATE: return CAL_CALIBRATE;
    case RCI_BAD_COMMAND:
    case RCI_PARAMETERS:
    case RCI_RANGE:
    case RCI_INVALID: return CAL_UNSUPPORTED;
    default: return CAL_PROTOCOL;
    }
}

static int hex_digit(uint8_t c)
{
    if (c >= '0' && c <= '9')
        return c - '0';
    if (c >= 'A' && c <= 'F')
        return c - 'A' + 10;
    return c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
}

parse_result rci_status(const uint8_t *bytes, size_t n, size_t *used, size_t *data, int *status)
{
    const uint8_t *end = n > 0 ? memchr(bytes, '>', n) : NULL;
    if (!end) {
        *used = n;
        return n < INSTRUMENT_BUFFER / 2 ? PARSE_MORE : PARSE_BAD;
    }
    const size_t at = (size_t)(end - bytes);
    *used = at + 1;
    if (at < 3 || bytes[at - 3] != '<')
        return PARSE_BAD;
    const int high = hex_digit(bytes[at - 2]), low = hex_digit(bytes[at - 1]);
    if (high < 0 || low < 0)
        return PARSE_BAD;
    *data = at - 3;
    *status = (high * 16 + low) & 0x7F; /* bit 7 says that more errors could be listed */
    return PARSE_OK;
}

static bool is_blank(uint8_t c) { return c == '\r' || c == '\n' || c == ' ' || c == '\t'; }

parse_result rci_parse(const line_format *format, const uint8_t *bytes, size_t n, size_t *used,
                       reading *out)
{
    size_t data;
    int status;
    const parse_result answer = rci_status(bytes, n, used, &data, &status);
    (void)format;
    if (answer != PARSE_OK)
        return answer;
    if (status != RCI_OK)
        return PARSE_BAD;
    memset(out, 0, sizeof *out);
    size_t at = 0, last_decimals = 0;
    for (int i = 0; i < 3; i++) {
        while (at < data && is_blank(bytes[at]))
            at++;
        const size_t start = at;
        while (at < data && !is_blank(bytes[at]))
            at++;
        const uint8_t *point = at > start ? memchr(bytes + start, '.', at - start) : NULL;
        if (!point || !lccal_parse_number((const char *)bytes + start, at - start, &out->xyz[i]))
            return PARSE_BAD;
        if (i == 1)
            last_decimals = (size_t)(bytes + at - point - 1);
    }
    while (at < data && is_blank(bytes[at]))
        at++;
    if (at != data || !(out->xyz[1] > 0.0) || out->xyz[1] > 200.0)
        return PARSE_BAD;
    out->kind = READING_REFLECTION;
    out->value = -log10(out->xyz[1] / 100.0);
    out->step = pow(10.0, -(double)last_decimals) / (out->xyz[1] * log(10.0));
    return PARSE_OK;
}

/* Send a command and wait for its status. The answer stays at the front of the buffer: data bytes,
 * then what *used covers. */
static cal_status ask(instrument *in, const char *command, int timeout_ms, size_t *used,
                      size_t *data, int *status, cal_error *err)
{
    in->have = 0;
    cal_status result = instrument_send(in, command, err);
    if (result != CAL_OK)
        return result;
    const int64_t deadline = in->port->ops->now_ms(in->port) + timeout_ms;
    for (;;) {
        switch (rci_status(in->buffer, in->have, used, data, status)) {
        case PARSE_OK: return CAL_OK;
        case PARSE_BAD:
            instrument_drop(in, *used);
            in->noise++;
            continue;
        case PARSE_MORE: break;
        }
        result = instrument_fill(in, deadline);
        if (result == CAL_TIMEOUT && in->have + in->noise > 0)
            result = CAL_PROTOCOL;
        if (result != CAL_OK)
            return instrument_fail(in, result, err);
    }
}

static cal_status fail_status(instrument *in, int status, cal_error *err)
{
    size_t used, data;
    int cleared;
    const cal_status meaning = rci_meaning(status);
    if (meaning == CAL_OK)
        return CAL_OK;
    /* It wants the error cleared before it takes the next command. */
    (void)ask(in, "CE\r", CLEAR_MS, &used, &data, &cleared, NULL);
    if (meaning == CAL_MISREAD || meaning == CAL_CALIBRATE)
        return instrument_fail(in, meaning, err);
    return cal_fail(err, meaning, "%s on '%s' reports error %02X; its manual says what that is",
                    in->driver->title, in->port->name, (unsigned)status);
}

static cal_status command(instrument *in, const char *text, int timeout_ms, cal_error *err)
{
    size_t used, data;
    int status = RCI_OK;
    const cal_status result = ask(in, text, timeout_ms, &used, &data, &status, err);
    return result == CAL_OK ? fail_status(in, status, err) : result;
}

/* The rate nobody knows: a CR is answered by a status at the right one only. */
static cal_status find_rate(instrument *in, int timeout_ms, cal_error *err)
{
    static const int rates[] = {9600, 19200, 38400, 57600, 4800, 2400, 1200, 600, 300};
    bool spoke = false;
    for (size_t i = 0; i < sizeof rates / sizeof rates[0]; i++) {
        const line_settings line = {
            .baud = rates[i], .data_bits = 8, .parity = 'N', .stop_bits = 1};
        size_t used, data;
        int status;
        const cal_status set = in->port->ops->configure(in->port, &line);
        if (set != CAL_OK)
            return instrument_fail(in, set, err);
        const int wait = timeout_ms < PROBE_MS ? timeout_ms : PROBE_MS;
        const cal_status result = ask(in, "\r", wait, &used, &data, &status, err);
        if (result == CAL_OK) {
            char text[16];
            const int n = snprintf(text, sizeof text, "%d", rates[i]);
            instrument_fact_set(in, "baud", text, (size_t)n);
            return CAL_OK;
        }
        if (result != CAL_TIMEOUT && result != CAL_PROTOCOL)
            return result;
        spoke = spoke || result == CAL_PROTOCOL;
    }
    return instrument_fail(in, spoke ? CAL_PROTOCOL : CAL_TIMEOUT, err);
}

/* SV answers "X-Rite DTP41..." and may be split over lines. */
static cal_status ask_version(instrument *in, int timeout_ms, cal_error *err)
{
    size_t used = 0, data = 0;
    int status = RCI_OK;
    const cal_status result = ask(in, "SV\r", timeout_ms, &used, &data, &status, err);
    if (result != CAL_OK)
        return result;
    if (status != RCI_OK)
        return fail_status(in, status, err);
    size_t start = 0;
    while (start < data && is_blank(in->buffer[start]))
        start++;
    size_t end = start;
    while (end < data && in->buffer[end] != '\r' && in->buffer[end] != '\n')
        end++;
    instrument_fact_set(in, "maker", "X-Rite", 6);
    const char *model = (const char *)in->buffer + start;
    const bool named = end - start > 7 && memcmp(model, "X-Rite ", 7) == 0;
    instrument_fact_set(in, "model", named ? model + 7 : model, end - start - (named ? 7 : 0));
    return CAL_OK;
}

/* A command it does not know is no wish of the user's that cannot be met: it is another
 * instrument. */
static cal_status not_unsupported(cal_status status, cal_error *err)
{
    if (status != CAL_UNSUPPORTED)
        return status;
    if (err)
        err->status = CAL_PROTOCOL;
    return CAL_PROTOCOL;
}

static cal_status identify(instrument *in, int timeout_ms, cal_error *err)
{
    /* RCI protocol, no echo, CR between lines, no transmission by itself, points in numbers, tabs
     * between fields, no labels, reflection, spot reading, one reading a measurement. */
    static const char *const set_up[] = {"0012CF\r", "0009CF\r", "0008CF\r", "0005CF\r",
                                         "0106CF\r", "0207CF\r", "000FCF\r", "0019CF\r",
                                         "0013CF\r", "0115CF\r"};
    const int wait = timeout_ms < SET_UP_MS ? timeout_ms : SET_UP_MS;
    if (!in->port->ops->configure)
        return instrument_fail(in, CAL_UNSUPPORTED, err);
    cal_status result = find_rate(in, timeout_ms, err);
    for (size_t i = 0; result == CAL_OK && i < sizeof set_up / sizeof set_up[0]; i++)
        result = command(in, set_up[i], wait, err);
    if (result == CAL_OK) {
        /* Four decimals where it can give them, two otherwise. */
        result = command(in, "040ACF\r", wait, err);
        if (result == CAL_UNSUPPORTED)
            result = command(in, "020ACF\r", wait, err);
    }
    if (result == CAL_OK)
        result = ask_version(in, wait, err);
    return not_unsupported(result, err);
}

static cal_status measure_once(instrument *in, int timeout_ms, reading *out, cal_error *err)
{
    const int wait = timeout_ms < READ_MS ? timeout_ms : READ_MS;
    cal_status result = command(in, "RM\r", wait, err);
    if (result != CAL_OK)
        return result;
    size_t used, data;
    int status = RCI_OK;
    result = ask(in, "0405TS\r", wait < FETCH_MS ? wait : FETCH_MS, &used, &data, &status, err);
    if (result == CAL_OK)
        result = fail_status(in, status, err);
    if (result != CAL_OK)
        return result;
    if (in->driver->parse(&in->format, in->buffer, in->have, &used, out) != PARSE_OK)
        return cal_fail(err, CAL_PROTOCOL,
                        "%s on '%s' sent a reading that is no X Y Z in percent; read again",
                        in->driver->title, in->port->name);
    return CAL_OK;
}

static cal_status measure(instrument *in, int timeout_ms, reading *out, cal_error *err)
{
    cal_status result = CAL_MISREAD;
    for (int i = 0; result == CAL_MISREAD && i <= MISREADS; i++)
        result = measure_once(in, timeout_ms, out, err);
    return not_unsupported(result, err);
}

const instrument_driver rci_driver = {
    .name = "xrite-rci",
    .title = "X-Rite DTP41 (RCI)",
    .how = "place the instrument on the patch; it reads by itself",
    .identify = identify,
    .measure = measure,
    .discard = instrument_discard,
    .parse = rci_parse,
};
