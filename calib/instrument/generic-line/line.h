/* SPDX-License-Identifier: MIT */
/* Densitometers that print a line when the user presses: line:PRESET[,NAME=VALUE...]. */
#ifndef LCCAL_LINE_H
#define LCCAL_LINE_H

#include "instrument/instrument.h"

typedef struct line_preset {
    const char *name;
    const char *title;
    line_settings line;
    line_format format;
} line_preset;

extern const line_preset line_presets[];
extern const size_t line_preset_count;

extern const instrument_driver line_driver;

/* "xrite-400,baud=9600,channel=R" into a preset with changes. */
cal_status line_preset_parse(const char *text, line_preset *out, cal_error *err);

/* One printed line. Pure. */
parse_result line_parse(const line_format *format, const uint8_t *bytes, size_t n, size_t *used,
                        reading *out);

#endif
