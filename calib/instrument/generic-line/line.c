/* SPDX-License-Identifier: MIT */
#include "instrument/generic-line/line.h"
#include "number.h"

#include <stdio.h>
#include <string.h>

#define FRAME(rate, bits, frame_parity)                                                            \
    {                                                                                              \
        .baud = (rate), .data_bits = (bits), .parity = (frame_parity), .stop_bits = 1              \
    }
#define FORM(form, points)                                                                         \
    .forms = (form), .decimals = (points), .scale = 1.0, .lowest = -99.0, .highest = 99.0

/* Rates and frames are the makers' factory settings where they are published; a user who changed
 * them says so: line:xrite-400,baud=9600. */
const line_preset line_presets[] = {
    {"heiland-trd2", "Heiland TRD 2", FRAME(9600, 8, 'N'), {FORM(FORM_SIGNED, DECIMALS_WRITTEN)}},
    {"xrite-400",
     "X-Rite 400 series",
     FRAME(1200, 7, 'S'),
     {FORM(FORM_FIELDS, DECIMALS_AUTO), .visual = "V"}},
    {"xrite-photo",
     "X-Rite 310, 361T or 800 series",
     FRAME(1200, 7, 'S'),
     {FORM(FORM_FIELDS, DECIMALS_AUTO), .visual = "V"}},
    {"xrite-39x", "X-Rite 390 or 391", FRAME(9600, 7, 'S'), {FORM(FORM_NUMBER, DECIMALS_WRITTEN)}},
    {"xrite-500",
     "X-Rite 500 series",
     FRAME(9600, 7, 'S'),
     {FORM(FORM_FIELDS, DECIMALS_AUTO), .visual = "V"}},
    {"technet",
     "Technet printing densitometer",
     FRAME(1200, 7, 'S'),
     {FORM(FORM_FIELDS, DECIMALS_IMPLIED), .visual = "V"}},
    {"technet-adv",
     "Advanced Technet printing densitometer",
     FRAME(1200, 7, 'S'),
     {FORM(FORM_FIELDS, DECIMALS_IMPLIED), .visual = "vpP"}},
    {"tobias-tbx", "Tobias TBX", FRAME(9600, 8, 'N'), {FORM(FORM_TOBIAS, DECIMALS_WRITTEN)}},
    {"macbeth-900",
     "Macbeth 900 series",
     FRAME(300, 7, 'N'),
     {FORM(FORM_FIELDS, DECIMALS_AUTO), .visual = "V"}},
    {"generic",
     "densitometer that prints lines",
     FRAME(9600, 8, 'N'),
     {FORM(FORM_SIGNED | FORM_TOBIAS | FORM_FIELDS | FORM_ANY, DECIMALS_AUTO), .visual = "V"}},
};
const size_t line_preset_count = sizeof line_presets / sizeof line_presets[0];

static const line_preset *find(const char *name, size_t length)
{
    for (size_t i = 0; i < line_preset_count; i++)
        if (strlen(line_presets[i].name) == length &&
            memcmp(line_presets[i].name, name, length) == 0)
            return &line_presets[i];
    return NULL;
}

static cal_status unknown_preset(const char *name, size_t length, cal_error *err)
{
    char all[224] = "";
    size_t used = 0;
    for (size_t i = 0; i < line_preset_count; i++)
        used += (size_t)snprintf(all + used, sizeof all - used, " %s", line_presets[i].name);
    return cal_fail(err, CAL_UNSUPPORTED, "no line preset '%.*s'; known:%s", (int)length, name,
                    all);
}

/* Index of `text` among up to four words, or -1. */
static int word(const char *text, const char *const words[4])
{
    for (int i = 0; i < 4 && words[i]; i++)
        if (strcmp(text, words[i]) == 0)
            return i;
    return -1;
}

static bool set_line(line_settings *line, const char *name, const char *value)
{
    static const char *const flows[4] = {"none", "xonxoff", "rtscts"};
    static const char *const switches[4] = {"on", "off"};
    double number;
    int index;
    if (strcmp(name, "baud") == 0) {
        if (!lccal_parse_number(value, strlen(value), &number) || number < 1.0 || number > 1e6)
            return false;
        line->baud = (int)number;
        return true;
    }
    if (strcmp(name, "frame") == 0)
        return line_frame_parse(value, line);
    if (strcmp(name, "flow") == 0) {
        index = word(value, flows);
        line->flow = index < 0 ? FLOW_NONE : (line_flow)index;
        return index >= 0;
    }
    index = word(value, switches);
    if (strcmp(name, "dtr") == 0)
        line->dtr_off = index == 1;
    else if (strcmp(name, "rts") == 0)
        line->rts_off = index == 1;
    else
        return false;
    return index >= 0;
}

static bool set_format(line_format *format, const char *name, const char *value)
{
    static const char *const points[4] = {"auto", "implied", "written"};
    const size_t n = strlen(value);
    if (strcmp(name, "channel") == 0 && n < sizeof format->visual && n > 0) {
        memcpy(format->visual, value, n + 1);
        return true;
    }
    if (strcmp(name, "mode") == 0 && (strcmp(value, "R") == 0 || strcmp(value, "T") == 0)) {
        format->mode = value[0];
        return true;
    }
    if (strcmp(name, "decimals") == 0 && word(value, points) >= 0) {
        format->decimals = (line_decimals)word(value, points);
        return true;
    }
    if (strcmp(name, "trigger") == 0 && n + 2 < sizeof format->trigger) {
        memcpy(format->trigger, value, n);
        memcpy(format->trigger + n, "\r", 2);
        return true;
    }
    double *number = strcmp(name, "scale") == 0 ? &format->scale
                     : strcmp(name, "min") == 0 ? &format->lowest
                     : strcmp(name, "max") == 0 ? &format->highest
                                                : NULL;
    return number && lccal_parse_number(value, n, number) && format->scale > 0.0;
}

cal_status line_preset_parse(const char *text, line_preset *out, cal_error *err)
{
    const size_t length = strcspn(text, ",");
    const line_preset *preset = find(text, length);
    if (!preset)
        return unknown_preset(text, length, err);
    *out = *preset;
    for (const char *at = text + length; *at;) {
        char part[64] = "";
        const size_t n = strcspn(at + 1, ",");
        snprintf(part, sizeof part, "%.*s", (int)n, at + 1);
        char *value = strchr(part, '=');
        if (value)
            *value++ = '\0';
        if (!value ||
            (!set_line(&out->line, part, value) && !set_format(&out->format, part, value)))
            return cal_fail(err, CAL_UNSUPPORTED,
                            "'%.*s' does not set up a line: baud=, frame=8N1.., flow=none|xonxoff|"
                            "rtscts, dtr=, rts=on|off, channel=, mode=R|T, decimals=auto|implied|"
                            "written, scale=, min=, max=, trigger=",
                            (int)n, at + 1);
        at += 1 + n;
    }
    return CAL_OK;
}

static cal_status identify(instrument *in, int timeout_ms, cal_error *err)
{
    enum { SLOW_BAUD = 600, SLOW_IDLE_MS = 2000 };
    line_preset preset = {.name = "", .title = ""};
    (void)timeout_ms;
    cal_status status = line_preset_parse(in->preset, &preset, err);
    if (status != CAL_OK)
        return status;
    if (!in->port->ops->configure)
        return cal_fail(err, CAL_UNSUPPORTED, "%s is on a serial port, and '%s' is none",
                        preset.title, in->port->name);
    status = in->port->ops->configure(in->port, &preset.line);
    if (status != CAL_OK)
        return instrument_fail(in, status, err);
    in->format = preset.format;
    if (preset.line.baud <= SLOW_BAUD)
        in->idle_ms = SLOW_IDLE_MS;
    instrument_fact_set(in, "model", preset.title, strlen(preset.title));
    return CAL_OK;
}

static cal_status measure(instrument *in, int timeout_ms, reading *out, cal_error *err)
{
    if (in->format.trigger[0] != '\0') {
        const cal_status status = instrument_send(in, in->format.trigger, err);
        if (status != CAL_OK)
            return status;
    }
    return instrument_listen(in, timeout_ms, out, err);
}

const instrument_driver line_driver = {
    .name = "line",
    .title = "densitometer that prints lines",
    .user_triggered = true,
    .silent = true,
    .how = "place the instrument on the patch and press its read key",
    .identify = identify,
    .measure = measure,
    .discard = instrument_discard,
    .parse = line_parse,
};
