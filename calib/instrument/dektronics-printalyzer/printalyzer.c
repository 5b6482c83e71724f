/* SPDX-License-Identifier: MIT */
/* Dektronics Printalyzer Densitometer (DPD-100 and UV/VIS) on its USB serial port.
 *
 * The user presses, it reports a line such as R+1.37D,3FAF5C29,7FC00000,3C23D70A,3C1374BC: mode,
 * displayed density, then absolute density, zero offset and two counts as IEEE-754 singles, most
 * significant digit first. Readings may arrive between a command and its reply. Calibration
 * (S C, I C) and storage (ID WIPE) commands are never sent. */
#include "instrument/dektronics-printalyzer/printalyzer.h"
#include "number.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { BASIC_LENGTH = 7, HEX_LENGTH = 8, REPLY_MS = 1000, TRIES = 2 };

static bool parse_hex_float(const uint8_t *text, float *out)
{
    uint32_t bits = 0;
    for (int i = 0; i < HEX_LENGTH; i++) {
        const uint8_t c = text[i];
        if (c >= '0' && c <= '9')
            bits = bits << 4 | (uint32_t)(c - '0');
        else if (c >= 'A' && c <= 'F')
            bits = bits << 4 | (uint32_t)(c - 'A' + 10);
        else
            return false;
    }
    memcpy(out, &bits, sizeof *out);
    return true;
}

/* The extended part: ",d,zero,raw[,corr]" after the displayed density. */
static bool parse_extended(const uint8_t *text, size_t n, double displayed, double *density)
{
    float fields[4];
    const size_t count = n / (HEX_LENGTH + 1);
    if (n % (HEX_LENGTH + 1) != 0 || count < 3 || count > 4)
        return false;
    for (size_t i = 0; i < count; i++) {
        const uint8_t *field = text + i * (HEX_LENGTH + 1);
        if (field[0] != ',' || !parse_hex_float(field + 1, &fields[i]))
            return false;
    }
    if (!isfinite(fields[0]) || isinf(fields[1]))
        return false;
    /* Both forms of the density must agree, or the line was damaged. The display shows two
     * decimals and never goes below zero. */
    const double zero = isnan(fields[1]) ? 0.0 : (double)fields[1];
    const double shown = (double)fields[0] - zero;
    if (fabs(shown - displayed) > 0.0051)
        return false;
    *density = (double)fields[0];
    return true;
}

static bool parse_line(const uint8_t *text, size_t n, reading *out)
{
    double density;
    if (n < BASIC_LENGTH || (text[0] != 'R' && text[0] != 'T' && text[0] != 'U') ||
        text[6] != 'D' || text[3] != '.' || (text[1] != '+' && text[1] != '-') ||
        !lccal_parse_number((const char *)text + 1, 5, &density))
        return false;
    memset(out, 0, sizeof *out);
    out->step = 0.01;
    if (n > BASIC_LENGTH) {
        if (!parse_extended(text + BASIC_LENGTH, n - BASIC_LENGTH, density, &density))
            return false;
        out->step = FLOAT_DENSITY_STEP;
    }
    const double top = text[0] == 'R' ? 2.5 : 5.0;
    out->kind = text[0] == 'R' ? READING_REFLECTION : READING_TRANSMISSION;
    out->value = density;
    out->clamped = density <= 0.0 || density >= top;
    return true;
}

parse_result printalyzer_parse(const line_format *format, const uint8_t *bytes, size_t n,
                               size_t *used, reading *out)
{
    size_t start, length;
    const parse_result line = line_split(bytes, n, &start, &length, used);
    (void)format;
    if (line != PARSE_OK)
        return line;
    return parse_line(bytes + start, length, out) ? PARSE_OK : PARSE_BAD;
}

static bool is_printable(const uint8_t *bytes, size_t n)
{
    for (size_t i = 0; i < n; i++)
        if (bytes[i] < 0x20 || bytes[i] > 0x7E)
            return false;
    return true;
}

/* Take the reply to `command` out of the buffer. Readings stay where they are once the format is
 * set; those before are from before this program. Everything else is dropped (log lines, answers to
 * other commands). False: it is not there yet. */
static bool take_reply(instrument *in, const char *command, char *reply, size_t capacity)
{
    const size_t asked = strlen(command);
    const bool set_up = *instrument_fact_get(in, "format") != '\0';
    size_t at = 0;
    for (;;) {
        size_t start, length, used;
        const uint8_t *bytes = in->buffer + at;
        const parse_result line = line_split(bytes, in->have - at, &start, &length, &used);
        if (line == PARSE_MORE)
            return false;
        reading unused;
        const bool is_line = line == PARSE_OK;
        if (is_line && set_up && parse_line(bytes + start, length, &unused)) {
            at += used;
            continue;
        }
        const bool found = is_line && length > asked && bytes[start + asked] == ',' &&
                           memcmp(bytes + start, command, asked) == 0 &&
                           is_printable(bytes + start, length);
        if (found) {
            size_t size = length - asked - 1;
            size = size < capacity ? size : capacity - 1;
            memcpy(reply, bytes + start + asked + 1, size);
            reply[size] = '\0';
        }
        in->noise += !found && length > 0;
        in->have -= used;
        memmove(in->buffer + at, in->buffer + at + used, in->have - at);
        if (found)
            return true;
    }
}

/* Send `command` (with `argument`, or "") and wait for the reply that echoes it. */
static cal_status ask(instrument *in, const char *command, const char *argument, int timeout_ms,
                      char *reply, size_t capacity, cal_error *err)
{
    char text[64];
    snprintf(text, sizeof text, "%s%s%s\r\n", command, *argument ? "," : "", argument);
    const int wait = timeout_ms < REPLY_MS ? timeout_ms : REPLY_MS;
    for (int attempt = 0; attempt < TRIES; attempt++) {
        cal_status status = instrument_send(in, text, err);
        if (status != CAL_OK)
            return status;
        const int64_t deadline = in->port->ops->now_ms(in->port) + wait;
        for (;;) {
            if (take_reply(in, command, reply, capacity))
                return CAL_OK;
            if (in->have == sizeof in->buffer)
                instrument_drop(in, in->have / 2);
            status = instrument_fill(in, deadline);
            if (status == CAL_TIMEOUT)
                break;
            if (status != CAL_OK)
                return instrument_fail(in, status, err);
        }
    }
    return cal_fail(err, in->noise ? CAL_PROTOCOL : CAL_TIMEOUT,
                    "'%s' %s `%s` of a Printalyzer within %d ms (%d tries); is it switched on, and "
                    "--instrument right?",
                    in->port->name,
                    in->noise ? "sends other things and does not answer" : "does not answer",
                    command, wait, TRIES);
}

/* The index-th field of a comma-separated reply, quotes around it left out. */
static size_t field_of(const char *reply, int index, const char **start)
{
    const char *from = reply;
    for (; index > 0 && from; index--) {
        const char *quote = *from == '"' ? strchr(from + 1, '"') : NULL;
        from = strchr(quote ? quote : from, ',');
        from = from ? from + 1 : NULL;
    }
    *start = from ? from : "";
    if (!from)
        return 0;
    if (*from == '"') {
        ++*start;
        const char *end = strchr(*start, '"');
        return end ? (size_t)(end - *start) : strlen(*start);
    }
    return strcspn(from, ",");
}

static void fact_from(instrument *in, const char *key, const char *reply, int index)
{
    const char *text;
    const size_t n = field_of(reply, index, &text);
    if (n > 0)
        instrument_fact_set(in, key, text, n);
}

static bool is_refusal(const char *reply)
{
    return strcmp(reply, "NAK") == 0 || strcmp(reply, "ERR") == 0;
}

typedef enum calibration { CALIBRATION_UNKNOWN, CALIBRATION_NONE, CALIBRATION_GOOD } calibration;

/* Two targets, each density and count: kept as "0.0800/0.320100 1.5000/0.012300". An answer that is
 * not four numbers does not tell whether it is calibrated. */
static calibration calibration_fact(instrument *in, const char *key, const char *reply)
{
    float values[4];
    bool good = true;
    for (int i = 0; i < 4; i++) {
        const char *text;
        const size_t n = field_of(reply, i, &text);
        if (n != HEX_LENGTH || !parse_hex_float((const uint8_t *)text, &values[i]))
            return CALIBRATION_UNKNOWN;
        good = good && fabsf(values[i]) < 1e9F && (i % 2 == 0 || values[i] > 0.0F);
    }
    if (!good) {
        instrument_fact_set(in, key, "none", 4);
        return CALIBRATION_NONE;
    }
    char text[4][24], all[100];
    for (int i = 0; i < 4; i++)
        lccal_format_number(text[i], sizeof text[i], (double)values[i], 4 + i % 2 * 2);
    const int n = snprintf(all, sizeof all, "%s/%s %s/%s", text[0], text[1], text[2], text[3]);
    instrument_fact_set(in, key, all, (size_t)n);
    return CALIBRATION_GOOD;
}

/* Who it is and how it is calibrated. One that knows only some of the questions is good enough to
 * measure with, so the first that stays unanswered ends the interview. */
static cal_status interview(instrument *in, int timeout_ms, cal_error *err)
{
    static const struct {
        const char *command, *key;
        int index;
    } questions[] = {{"GS UID", "serial", 0},
                     {"GS B", "build", 0},
                     {"GS B", "build_describe", 1},
                     {"GS B", "build_checksum", 2},
                     {"GS ISEN", "temperature", 1}};
    char reply[160] = "";
    const char *asked = "";
    for (size_t i = 0; i < sizeof questions / sizeof questions[0]; i++) {
        if (strcmp(asked, questions[i].command) != 0) {
            asked = questions[i].command;
            const cal_status status = ask(in, asked, "", timeout_ms, reply, sizeof reply, NULL);
            if (status == CAL_TIMEOUT || status == CAL_PROTOCOL)
                return CAL_OK;
            if (status != CAL_OK)
                return instrument_fail(in, status, err);
        }
        if (!is_refusal(reply))
            fact_from(in, questions[i].key, reply, questions[i].index);
    }
    bool uncalibrated = true;
    for (int transmission = 0; transmission < 2; transmission++) {
        const char *command = transmission ? "GC TRAN" : "GC REFL";
        const char *key = transmission ? "calibration_transmission" : "calibration_reflection";
        const cal_status status = ask(in, command, "", timeout_ms, reply, sizeof reply, NULL);
        if (status != CAL_OK)
            return status == CAL_TIMEOUT || status == CAL_PROTOCOL
                       ? CAL_OK
                       : instrument_fail(in, status, err);
        if (calibration_fact(in, key, reply) != CALIBRATION_NONE)
            uncalibrated = false;
    }
    return uncalibrated ? instrument_fail(in, CAL_CALIBRATE, err) : CAL_OK;
}

static cal_status identify(instrument *in, int timeout_ms, cal_error *err)
{
    char reply[160] = "";
    cal_status status = ask(in, "GS V", "", timeout_ms, reply, sizeof reply, err);
    if (status != CAL_OK)
        return status;
    fact_from(in, "model", reply, 0);
    fact_from(in, "firmware", reply, 1);
    if (!*instrument_fact_get(in, "firmware"))
        return cal_fail(err, CAL_PROTOCOL,
                        "'%s' answered GS V with '%.60s' instead of a model and a version",
                        in->port->name, reply);
    instrument_fact_set(in, "maker", "Dektronics", 10);
    status = ask(in, "SM FORMAT", "EXT", timeout_ms, reply, sizeof reply, err);
    if (status != CAL_OK)
        return status;
    /* Refusing the extended format is no failure: two decimals do. */
    const bool extended = strcmp(reply, "OK") == 0;
    instrument_fact_set(in, "format", extended ? "extended" : "basic", extended ? 8 : 5);
    return interview(in, timeout_ms, err);
}

static void leave(instrument *in)
{
    static const char basic[] = "SM FORMAT,BASIC\r\n";
    (void)in->port->ops->write(in->port, basic, sizeof basic - 1, REPLY_MS);
}

static const line_settings line = {.baud = 115200, .data_bits = 8, .parity = 'N', .stop_bits = 1};

const instrument_driver printalyzer_driver = {
    .name = "printalyzer",
    .title = "Printalyzer Densitometer",
    .line = &line,
    .user_triggered = true,
    .how = "lower the head on the patch and hold the button until it has read",
    .recalibrate =
        "in the instrument's menu choose Calibration, then Reflection (or Transmission), "
        "and measure its targets as it asks",
    .identify = identify,
    .measure = instrument_listen,
    .discard = instrument_discard,
    .parse = printalyzer_parse,
    .leave = leave,
};
