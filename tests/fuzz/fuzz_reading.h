/* SPDX-License-Identifier: MIT */
/* What every parser of readings promises, whatever the bytes. */
#ifndef FUZZ_READING_H
#define FUZZ_READING_H

#include "instrument/instrument.h"

#include <math.h>
#include <stdlib.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

typedef parse_result (*parser)(const line_format *format, const uint8_t *bytes, size_t n,
                               size_t *used, reading *out);

static inline void require(int condition)
{
    if (!condition)
        abort();
}

/* Parse from the front until nothing more comes out: every step but the last takes bytes, never
 * more than there are, and a reading is made of finite numbers. */
static inline void check_stream(parser parse, const line_format *format, const uint8_t *bytes,
                                size_t n)
{
    for (;;) {
        size_t used = 0;
        reading r;
        const parse_result result = parse(format, bytes, n, &used, &r);
        if (result == PARSE_MORE)
            return;
        require(used <= n);
        if (result == PARSE_OK) {
            require(isfinite(r.value) && isfinite(r.step) && r.step >= 0.0);
            for (int i = 0; i < 3; i++)
                require((!r.has_colour || isfinite(r.density[i])) &&
                        (!r.has_xyz || isfinite(r.xyz[i])));
        }
        require(used > 0);
        bytes += used;
        n -= used;
    }
}

#endif
