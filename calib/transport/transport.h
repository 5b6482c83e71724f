/* SPDX-License-Identifier: MIT */
/* Bytes in, bytes out, each with a deadline. Knows nothing of densitometers. */
#ifndef LCCAL_TRANSPORT_H
#define LCCAL_TRANSPORT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef enum cal_status {
    CAL_OK = 0,
    CAL_TIMEOUT,     /* nothing came before the deadline */
    CAL_GONE,        /* the port hung up: cable pulled, device switched off */
    CAL_IO,          /* the system refused a read or a write */
    CAL_PROTOCOL,    /* an answer came and is not what the instrument should say */
    CAL_NO_DEVICE,   /* no such port or device */
    CAL_PERMISSION,  /* not allowed to open it */
    CAL_BUSY,        /* another program has it */
    CAL_UNSUPPORTED, /* this build, port or instrument cannot do it */
    CAL_MISREAD,     /* the instrument says: try again */
    CAL_CALIBRATE,   /* the instrument says: calibrate me first */
    CAL_INTERRUPTED, /* SIGINT */
    CAL_NO_MEMORY
} cal_status;

/* Detail of a failure, owned by the caller; `text` is one line without the program's name. */
typedef struct cal_error {
    cal_status status;
    char text[224];
} cal_error;

/* Fill *err (may be NULL) and return status. */
cal_status cal_fail(cal_error *err, cal_status status, const char *format, ...);

typedef enum line_flow { FLOW_NONE, FLOW_XONXOFF, FLOW_RTSCTS } line_flow;

typedef struct line_settings {
    int baud;
    int data_bits; /* 7 or 8 */
    char parity;   /* N, E, O, S(pace), M(ark) */
    int stop_bits; /* 1 or 2 */
    line_flow flow;
    bool dtr_off, rts_off; /* both are asserted unless told otherwise */
} line_settings;

/* "8N1", "7E1"... into data_bits, parity and stop_bits. */
bool line_frame_parse(const char *text, line_settings *out);

typedef struct transport transport;
typedef struct transport_ops transport_ops;

struct transport {
    const transport_ops *ops;
    char name[96];            /* what --port said */
    unsigned vendor, product; /* of a USB HID device; 0: not known */
};

struct transport_ops {
    const char *scheme; /* "serial", "hid", "script" */
    bool messages;      /* keeps message borders (HID reports) */
    /* Baud rate, frame and control lines; NULL where the port has none. */
    cal_status (*configure)(transport *t, const line_settings *line);
    /* All n bytes, or an error. */
    cal_status (*write)(transport *t, const void *bytes, size_t n, int timeout_ms);
    /* At least one byte (one message), or an error. */
    cal_status (*read)(transport *t, void *bytes, size_t capacity, size_t *got, int timeout_ms);
    /* HID feature reports, first byte is the report id; NULL where there are none. */
    cal_status (*set_feature)(transport *t, const uint8_t *report, size_t n);
    cal_status (*get_feature)(transport *t, uint8_t *report, size_t n);
    /* Milliseconds since some start; a replayed script has its own time. */
    int64_t (*now_ms)(transport *t);
    void (*close)(transport *t);
};

/* Open what `port` names by its form: a serial device, hid:VID:PID[:SERIAL], /dev/hidrawN or
 * script:FILE. */
cal_status transport_open(const char *port, transport **out, cal_error *err);

cal_status serial_open(const char *path, transport **out, cal_error *err);
cal_status hid_open_port(const char *port, transport **out, cal_error *err);
cal_status script_open(const char *path, transport **out, cal_error *err);
/* The same from memory; for tests. */
cal_status script_open_text(const char *text, size_t size, transport **out, cal_error *err);
/* Everything `inner` says and hears also goes to a file that script: replays. Owns `inner`, which
 * is closed too when this fails. */
cal_status record_open(transport *inner, const char *path, transport **out, cal_error *err);

/* Throw away what arrives until `quiet_ms` passed without a byte, for `limit_ms` at most. */
cal_status transport_drain(transport *t, int quiet_ms, int limit_ms);
/* now_ms of ports whose time is the machine's. */
int64_t transport_clock(transport *t);
/* Milliseconds left until `deadline` of t's clock, never negative. */
int transport_left(transport *t, int64_t deadline);

#endif
