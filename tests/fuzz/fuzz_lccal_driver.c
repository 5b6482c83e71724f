/* SPDX-License-Identifier: MIT */
/* Whole drivers on a device that says anything: the first byte chooses the driver, the rest is cut
 * into answers. Nothing may hang, and what comes out as a reading is one. */
#include "fuzz_reading.h"
#include "transport/transport.h"

#include <string.h>

typedef struct babbler {
    transport base;
    const uint8_t *bytes;
    size_t size;
    int64_t now;
} babbler;

static cal_status babble(transport *t, void *bytes, size_t capacity, size_t *got, int timeout_ms)
{
    babbler *b = (babbler *)t;
    /* The first byte of an answer is its length; 0 is silence. */
    size_t n = b->size > 0 ? b->bytes[0] : 0;
    if (n == 0 || timeout_ms == 0) {
        b->now += timeout_ms;
        b->bytes += b->size > 0;
        b->size -= b->size > 0;
        *got = 0;
        return CAL_TIMEOUT;
    }
    n = n < b->size ? n : b->size - 1;
    n = n < capacity ? n : capacity;
    memcpy(bytes, b->bytes + 1, n);
    b->bytes += 1 + n;
    b->size -= 1 + n;
    b->now += 1;
    *got = n;
    return n > 0 ? CAL_OK : CAL_GONE;
}

static cal_status listen_to_nothing(transport *t, const void *bytes, size_t n, int timeout_ms)
{
    (void)t;
    (void)bytes;
    (void)n;
    (void)timeout_ms;
    return CAL_OK;
}

static cal_status take_any_line(transport *t, const line_settings *line)
{
    (void)t;
    (void)line;
    return CAL_OK;
}

static int64_t own_time(transport *t) { return ((babbler *)t)->now; }
static void stay(transport *t) { (void)t; }

static const transport_ops line_ops = {.scheme = "script",
                                       .configure = take_any_line,
                                       .write = listen_to_nothing,
                                       .read = babble,
                                       .now_ms = own_time,
                                       .close = stay};

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static const char *const names[] = {"printalyzer", "xrite-rci", "colorhug2", "line:generic",
                                        "auto"};
    if (size == 0)
        return 0;
    babbler b = {.base = {.ops = &line_ops}, .bytes = data + 1, .size = size - 1};
    instrument in;
    cal_error err;
    const char *name = names[data[0] % (sizeof names / sizeof names[0])];
    if (instrument_open(name, &b.base, 1000, &in, &err) == CAL_OK) {
        reading r;
        for (int i = 0; i < 8; i++)
            if (in.driver->measure(&in, 1000, &r, &err) == CAL_OK)
                require(isfinite(r.value));
        (void)in.driver->discard(&in);
    }
    for (size_t i = 0; i < in.fact_count; i++)
        require(memchr(in.facts[i].value, '\0', sizeof in.facts[i].value) != NULL);
    require(b.now < 1000000);
    instrument_close(&in);
    return 0;
}
