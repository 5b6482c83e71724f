/* SPDX-License-Identifier: MIT */
#define _POSIX_C_SOURCE 200809L
#include "transport/transport.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

cal_status cal_fail(cal_error *err, cal_status status, const char *format, ...)
{
    if (err) {
        va_list args;
        va_start(args, format);
        vsnprintf(err->text, sizeof err->text, format, args);
        va_end(args);
        err->status = status;
    }
    return status;
}

bool line_frame_parse(const char *text, line_settings *out)
{
    if (strlen(text) != 3 || (text[0] != '7' && text[0] != '8') || !strchr("NEOSM", text[1]) ||
        (text[2] != '1' && text[2] != '2'))
        return false;
    out->data_bits = text[0] - '0';
    out->parity = text[1];
    out->stop_bits = text[2] - '0';
    return true;
}

cal_status transport_open(const char *port, transport **out, cal_error *err)
{
    if (strncmp(port, "script:", 7) == 0)
        return script_open(port + 7, out, err);
    if (strncmp(port, "hid:", 4) == 0 || strncmp(port, "/dev/hidraw", 11) == 0)
        return hid_open_port(port, out, err);
    return serial_open(port, out, err);
}

int64_t transport_clock(transport *t)
{
    (void)t;
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (int64_t)now.tv_sec * 1000 + now.tv_nsec / 1000000;
}

int transport_left(transport *t, int64_t deadline)
{
    const int64_t left = deadline - t->ops->now_ms(t);
    if (left <= 0)
        return 0;
    return left < 1000000000 ? (int)left : 1000000000;
}

cal_status transport_drain(transport *t, int quiet_ms, int limit_ms)
{
    const int64_t deadline = t->ops->now_ms(t) + limit_ms;
    for (;;) {
        char waste[256];
        size_t got;
        const int left = transport_left(t, deadline);
        const cal_status status =
            t->ops->read(t, waste, sizeof waste, &got, left < quiet_ms ? left : quiet_ms);
        if (status == CAL_TIMEOUT)
            return CAL_OK;
        if (status != CAL_OK)
            return status;
        if (left == 0)
            return CAL_PROTOCOL; /* it never stops talking */
    }
}
