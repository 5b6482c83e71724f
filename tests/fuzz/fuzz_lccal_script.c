/* SPDX-License-Identifier: MIT */
/* Recorded dialogues: any bytes are one, or are refused with the line that is not. */
#include "fuzz_reading.h"
#include "transport/transport.h"

#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    transport *t;
    cal_error err;
    if (script_open_text((const char *)data, size, &t, &err) != CAL_OK) {
        require(err.text[0] != '\0');
        return 0;
    }
    for (int i = 0; i < 64; i++) {
        char bytes[32];
        size_t got = 99;
        if (t->ops->read(t, bytes, sizeof bytes, &got, 1000) == CAL_OK)
            require(got > 0 && got <= sizeof bytes);
        (void)t->ops->write(t, "R\r", 2, 1000);
    }
    t->ops->close(t);
    return 0;
}
