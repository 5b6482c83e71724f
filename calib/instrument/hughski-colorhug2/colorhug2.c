/* SPDX-License-Identifier: MIT */
/* Hughski ColorHug2, a colorimeter for displays: 64-byte HID reports without numbers. A request is
 * command and arguments; the answer is return code, the command again, and data in little-endian,
 * where a real number is a signed 16.16 fixed-point one. One request at a time. */
#include "instrument/hughski-colorhug2/colorhug2.h"

#include <stdio.h>
#include <string.h>

enum {
    REPORT = 64,
    HEADER = 2,
    XYZ_SIZE = 12,
    GET_FIRMWARE = 0x07,
    GET_SERIAL = 0x0B,
    TAKE_XYZ = 0x23,
    GET_HARDWARE = 0x30,
    GET_TEMPERATURE = 0x3B,
    CODE_UNDERFLOW = 4,
    CODE_UNCALIBRATED = 12,
    CODE_OVERFLOW = 15,
    CODE_INCOMPLETE = 18,
    CODE_BAD_CALIBRATION = 25,
    ASK_MS = 2000,
    READ_MS = 30000,
    STALE_LIMIT = 16
};

/* cd/m2: the fixed-point fraction has more digits than the sensor tells apart. */
#define LUMINANCE_STEP 0.001

static int32_t get_i32(const uint8_t *b)
{
    const uint32_t u =
        (uint32_t)b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
    int32_t value;
    memcpy(&value, &u, sizeof value);
    return value;
}

static double get_fixed(const uint8_t *b) { return get_i32(b) / 65536.0; }

parse_result colorhug2_parse(const line_format *format, const uint8_t *bytes, size_t n,
                             size_t *used, reading *out)
{
    (void)format;
    *used = n;
    if (n == 0)
        return PARSE_MORE;
    if (n < HEADER + XYZ_SIZE || n > REPORT || bytes[0] != 0 || bytes[1] != TAKE_XYZ)
        return PARSE_BAD;
    memset(out, 0, sizeof *out);
    out->kind = READING_LUMINANCE;
    out->has_xyz = true;
    for (size_t i = 0; i < 3; i++)
        out->xyz[i] = get_fixed(bytes + HEADER + 4 * i);
    out->value = out->xyz[1];
    out->step = LUMINANCE_STEP;
    return PARSE_OK;
}

static cal_status fail_code(instrument *in, int code, cal_error *err)
{
    switch (code) {
    case 0: return CAL_OK;
    case CODE_UNDERFLOW:
        return cal_fail(err, CAL_MISREAD,
                        "the patch is too dark for the ColorHug2; raise the display's brightness "
                        "or measure with the room dark and the sensor touching the screen");
    case CODE_OVERFLOW:
        return cal_fail(err, CAL_MISREAD,
                        "the patch is too bright for the ColorHug2; lower the display's "
                        "brightness");
    case CODE_UNCALIBRATED:
    case CODE_BAD_CALIBRATION: return instrument_fail(in, CAL_CALIBRATE, err);
    default:
        return cal_fail(err, CAL_PROTOCOL,
                        "the ColorHug2 on '%s' reports error %d; unplug it and "
                        "plug it in again",
                        in->port->name, code);
    }
}

/* The next report into the buffer: that one alone, also where reports are queued on a stream. */
static cal_status next_report(instrument *in, int timeout_ms)
{
    in->have = 0;
    return in->port->ops->read(in->port, in->buffer, REPORT, &in->have, timeout_ms);
}

/* One request and its answer, left in the buffer. An answer that echoes another command is left
 * over from before and dropped; an incomplete request is sent once more. */
static cal_status ask(instrument *in, uint8_t command, const uint8_t *arguments, size_t n,
                      int timeout_ms, cal_error *err)
{
    uint8_t request[1 + REPORT] = {0, command}; /* reports have no number */
    if (n > 0)
        memcpy(request + 2, arguments, n);
    for (int attempt = 0;; attempt++) {
        cal_status result = CAL_OK;
        for (int i = 0; result == CAL_OK && i < STALE_LIMIT; i++)
            result = next_report(in, 0);
        if (result == CAL_TIMEOUT)
            result = in->port->ops->write(in->port, request, sizeof request, ASK_MS);
        const int64_t deadline = in->port->ops->now_ms(in->port) + timeout_ms;
        bool answered = false;
        while (result == CAL_OK && !answered) {
            result = next_report(in, transport_left(in->port, deadline));
            answered = result == CAL_OK && in->have >= HEADER && in->buffer[1] == command;
            in->noise += result == CAL_OK && !answered;
        }
        if (result == CAL_TIMEOUT && in->noise > 0)
            result = CAL_PROTOCOL;
        if (result != CAL_OK)
            return instrument_fail(in, result, err);
        if (in->buffer[0] != CODE_INCOMPLETE || attempt > 0)
            return fail_code(in, in->buffer[0], err);
    }
}

/* Which of the factory's calibrations: the display's kind, after colorhug2: in --instrument. */
static bool calibration_index(const char *kind, uint8_t *index)
{
    static const struct {
        const char *kind;
        uint8_t index;
    } kinds[] = {{"", 64},          {"lcd", 64}, {"crt", 65},
                 {"projector", 66}, {"led", 67}, {"factory", 0}};
    for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; i++) {
        if (strcmp(kinds[i].kind, kind) == 0) {
            *index = kinds[i].index;
            return true;
        }
    }
    return false;
}

static void fact_format(instrument *in, const char *key, const char *format, unsigned a, unsigned b,
                        unsigned c)
{
    char text[48];
    const int n = snprintf(text, sizeof text, format, a, b, c);
    instrument_fact_set(in, key, text, (size_t)n);
}

static unsigned get_u16(const uint8_t *b) { return (unsigned)b[0] | (unsigned)b[1] << 8; }

static cal_status identify(instrument *in, int timeout_ms, cal_error *err)
{
    uint8_t index;
    const int wait = timeout_ms < ASK_MS ? timeout_ms : ASK_MS;
    if (!in->port->ops->messages && strcmp(in->port->ops->scheme, "script") != 0)
        return cal_fail(err, CAL_UNSUPPORTED, "a ColorHug2 is on hid:273f:1004, not on '%s'",
                        in->port->name);
    if (!calibration_index(in->preset, &index))
        return cal_fail(err, CAL_UNSUPPORTED,
                        "no display kind '%s'; known: lcd crt projector led factory", in->preset);
    const uint8_t *data = in->buffer + HEADER;
    cal_status result = ask(in, GET_FIRMWARE, NULL, 0, wait, err);
    if (result != CAL_OK)
        return result;
    instrument_fact_set(in, "maker", "Hughski", 7);
    instrument_fact_set(in, "model", "ColorHug2", 9);
    fact_format(in, "firmware", "%u.%u.%u", get_u16(data), get_u16(data + 2), get_u16(data + 4));
    fact_format(in, "calibration", *in->preset ? in->preset : "lcd", 0, 0, 0);
    result = ask(in, GET_SERIAL, NULL, 0, wait, err);
    if (result == CAL_OK) {
        fact_format(in, "serial", "%u", get_u16(data) | get_u16(data + 2) << 16, 0, 0);
        result = ask(in, GET_HARDWARE, NULL, 0, wait, err);
    }
    if (result == CAL_OK) {
        fact_format(in, "hardware", "%u", data[0], 0, 0);
        result = ask(in, GET_TEMPERATURE, NULL, 0, wait, err);
    }
    if (result == CAL_OK) {
        const int tenths = (int)(get_fixed(data) * 10.0);
        if (tenths >= 0)
            fact_format(in, "temperature", "%u.%uC", (unsigned)tenths / 10, (unsigned)tenths % 10,
                        0);
    }
    return result;
}

static cal_status measure(instrument *in, int timeout_ms, reading *out, cal_error *err)
{
    uint8_t arguments[2] = {0, 0};
    size_t used;
    (void)calibration_index(in->preset, &arguments[0]);
    const cal_status result = ask(in, TAKE_XYZ, arguments, sizeof arguments,
                                  timeout_ms < READ_MS ? timeout_ms : READ_MS, err);
    if (result != CAL_OK)
        return result;
    if (in->driver->parse(&in->format, in->buffer, in->have, &used, out) != PARSE_OK)
        return instrument_fail(in, CAL_PROTOCOL, err);
    return CAL_OK;
}

/* Answers come to requests only, so there is nothing old to forget but a report in the queue. */
static cal_status discard(instrument *in)
{
    in->have = 0;
    return CAL_OK;
}

const instrument_driver colorhug2_driver = {
    .name = "colorhug2",
    .title = "ColorHug2",
    .on_hid = true,
    .displays = true,
    .how = "show the patch full-screen and hang the instrument before it; it reads by itself",
    .identify = identify,
    .measure = measure,
    .discard = discard,
    .parse = colorhug2_parse,
};
