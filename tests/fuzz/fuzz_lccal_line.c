/* SPDX-License-Identifier: MIT */
/* Lines of printing densitometers; the first byte chooses the preset. */
#include "fuzz_reading.h"
#include "instrument/generic-line/line.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    if (size == 0)
        return 0;
    check_stream(line_parse, &line_presets[data[0] % line_preset_count].format, data + 1, size - 1);
    return 0;
}
