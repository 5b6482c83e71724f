/* SPDX-License-Identifier: MIT */
/* A port that writes down everything said on it, for bug reports and as test fixtures. */
#include "transport/transport.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct recorder {
    transport base;
    transport_ops ops; /* the inner port's, with write, read and close replaced */
    transport *inner;
    FILE *file;
    int64_t last; /* when the last line was written */
} recorder;

static void note(recorder *r, char letter, const uint8_t *bytes, size_t n)
{
    const int64_t now = r->inner->ops->now_ms(r->inner);
    fprintf(r->file, "%c %ld ", letter, (long)(now - r->last));
    for (size_t i = 0; i < n; i++) {
        if (bytes[i] < 0x20 || bytes[i] == '^') {
            fputc('^', r->file);
            fputc(bytes[i] == '^' ? '`' : bytes[i] + '@', r->file);
        } else {
            fputc(bytes[i], r->file);
        }
    }
    fputc('\n', r->file);
    fflush(r->file); /* a crash is what recordings are for */
    r->last = now;
}

static cal_status record_write(transport *t, const void *bytes, size_t n, int timeout_ms)
{
    recorder *r = (recorder *)t;
    const cal_status status = r->inner->ops->write(r->inner, bytes, n, timeout_ms);
    if (status == CAL_OK)
        note(r, 'w', bytes, n);
    return status;
}

static cal_status record_read(transport *t, void *bytes, size_t capacity, size_t *got,
                              int timeout_ms)
{
    recorder *r = (recorder *)t;
    const cal_status status = r->inner->ops->read(r->inner, bytes, capacity, got, timeout_ms);
    if (status == CAL_OK)
        note(r, 'r', bytes, *got);
    else if (status == CAL_GONE)
        note(r, 'h', NULL, 0);
    return status;
}

static cal_status record_configure(transport *t, const line_settings *line)
{
    recorder *r = (recorder *)t;
    return r->inner->ops->configure(r->inner, line);
}

static cal_status record_set_feature(transport *t, const uint8_t *report, size_t n)
{
    recorder *r = (recorder *)t;
    return r->inner->ops->set_feature(r->inner, report, n);
}

static cal_status record_get_feature(transport *t, uint8_t *report, size_t n)
{
    recorder *r = (recorder *)t;
    return r->inner->ops->get_feature(r->inner, report, n);
}

static int64_t record_now(transport *t)
{
    recorder *r = (recorder *)t;
    return r->inner->ops->now_ms(r->inner);
}

static void record_close(transport *t)
{
    recorder *r = (recorder *)t;
    r->inner->ops->close(r->inner);
    fclose(r->file);
    free(r);
}

cal_status record_open(transport *inner, const char *path, transport **out, cal_error *err)
{
    recorder *r = calloc(1, sizeof *r);
    FILE *file = r ? fopen(path, "wb") : NULL;
    if (!file) {
        inner->ops->close(inner);
        free(r);
        return cal_fail(err, CAL_IO, "cannot write the recording '%s'; choose another --record",
                        path);
    }
    r->inner = inner;
    r->file = file;
    r->last = inner->ops->now_ms(inner);
    r->ops = *inner->ops;
    r->ops.write = record_write;
    r->ops.read = record_read;
    r->ops.now_ms = record_now;
    r->ops.close = record_close;
    if (inner->ops->configure)
        r->ops.configure = record_configure;
    if (inner->ops->set_feature) {
        r->ops.set_feature = record_set_feature;
        r->ops.get_feature = record_get_feature;
    }
    r->base = *inner;
    r->base.ops = &r->ops;
    fprintf(file, "d 0 %s\n", inner->name);
    *out = &r->base;
    return CAL_OK;
}
