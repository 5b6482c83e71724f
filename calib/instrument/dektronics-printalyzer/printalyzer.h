/* SPDX-License-Identifier: MIT */
#ifndef LCCAL_PRINTALYZER_H
#define LCCAL_PRINTALYZER_H

#include "instrument/instrument.h"

extern const instrument_driver printalyzer_driver;

/* One line of the instrument, basic or extended. */
parse_result printalyzer_parse(const line_format *format, const uint8_t *bytes, size_t n,
                               size_t *used, reading *out);

#endif
