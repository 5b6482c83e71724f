/* SPDX-License-Identifier: MIT */
/* Answers of X-Rite's remote control interface. */
#include "fuzz_reading.h"
#include "instrument/xrite-rci/rci.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    check_stream(rci_parse, NULL, data, size);
    return 0;
}
