/* SPDX-License-Identifier: MIT */
#ifndef LCCAL_RCI_H
#define LCCAL_RCI_H

#include "instrument/instrument.h"

extern const instrument_driver rci_driver;

/* The end of an answer: "<hh>". PARSE_OK: *status is its number with the more-errors bit taken off,
 * and the data are bytes[0 .. *data - 1]. Pure. */
parse_result rci_status(const uint8_t *bytes, size_t n, size_t *used, size_t *data, int *status);

/* The answer to 0405TS: X, Y and Z in percent and the status. Pure. */
parse_result rci_parse(const line_format *format, const uint8_t *bytes, size_t n, size_t *used,
                       reading *out);

/* What the session should think of a status. */
cal_status rci_meaning(int status);

#endif
