/* SPDX-License-Identifier: MIT */
/* Lines of the Printalyzer densitometer. */
#include "fuzz_reading.h"
#include "instrument/dektronics-printalyzer/printalyzer.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    check_stream(printalyzer_parse, NULL, data, size);
    return 0;
}
