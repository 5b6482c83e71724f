/* SPDX-License-Identifier: MIT */
/* Reports of the ColorHug2. */
#include "fuzz_reading.h"
#include "instrument/hughski-colorhug2/colorhug2.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    check_stream(colorhug2_parse, NULL, data, size);
    return 0;
}
