/* SPDX-License-Identifier: MIT */
#ifndef LCCAL_COLORHUG2_H
#define LCCAL_COLORHUG2_H

#include "instrument/instrument.h"

extern const instrument_driver colorhug2_driver;

/* The report that answers "take reading XYZ". Pure. */
parse_result colorhug2_parse(const line_format *format, const uint8_t *bytes, size_t n,
                             size_t *used, reading *out);

#endif
