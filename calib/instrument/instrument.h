/* SPDX-License-Identifier: MIT */
/* What a densitometer or colorimeter is to the session: it says who it is and gives readings. Knows
 * transports and nothing of sessions. */
#ifndef LCCAL_INSTRUMENT_H
#define LCCAL_INSTRUMENT_H

#include "transport/transport.h"

typedef enum reading_kind {
    READING_REFLECTION,   /* reflection density [1] */
    READING_TRANSMISSION, /* transmission density [1] */
    READING_LUMINANCE     /* cd/m2 */
} reading_kind;

/* One reading, as the instrument gave it. */
typedef struct reading {
    reading_kind kind;
    double value;    /* visual density, or luminance */
    double step;     /* values closer than this are not told apart */
    bool has_colour; /* density[] holds red, green and blue too */
    double density[3];
    bool has_xyz;
    double xyz[3];
    bool clamped; /* at an end of the instrument's range: the truth may lie beyond */
} reading;

/* Step of a density that is sent as a floating-point number. Digits beyond it are arithmetic: a
 * count of the sensor is some 0.0002 D in a dark print, and its noise is several counts. */
#define FLOAT_DENSITY_STEP 0.001

/* What a driver's parser makes of the bytes so far. */
typedef enum parse_result {
    PARSE_BAD = -1, /* *used bytes are no reading: drop them */
    PARSE_OK = 0,   /* *used bytes were a reading */
    PARSE_MORE = 1  /* no reading yet and nothing to drop: read on */
} parse_result;

/* How an instrument that prints lines writes a density. */
enum {
    FORM_SIGNED = 1, /* T+1.53D: mode, sign, four characters, unit */
    FORM_TOBIAS = 2, /* DenAA +1.47, ... */
    FORM_FIELDS = 4, /* V1.37 C0.05 M0.06 Y0.07 */
    FORM_NUMBER = 8, /* 1.37 alone */
    FORM_ANY = 16    /* the first number of whatever it is */
};

typedef enum line_decimals { DECIMALS_AUTO, DECIMALS_IMPLIED, DECIMALS_WRITTEN } line_decimals;

typedef struct line_format {
    unsigned forms;         /* FORM_... that this instrument prints */
    char visual[8];         /* letters that mark the visual filter */
    char mode;              /* 'R' or 'T': kind of the readings where the line does not say, and the
                               only one taken where it does; 0: as the line says, or reflection */
    line_decimals decimals; /* 137 is 1.37 */
    double scale, lowest, highest;
    char trigger[32]; /* sent to ask for a reading; "": the user presses */
} line_format;

typedef struct instrument instrument;
typedef struct instrument_driver instrument_driver;

struct instrument_driver {
    const char *name; /* for --instrument */
    const char *title;
    const line_settings *line; /* NULL: not on a serial line, or the preset says */
    bool on_hid;               /* else on a serial line */
    bool displays;             /* reads displays, not prints */
    bool user_triggered;       /* the user presses, the instrument reports */
    bool experimental;
    const char *how;         /* what the user does for one reading */
    const char *recalibrate; /* what the user does to calibrate it; NULL: nothing */
    bool silent;             /* cannot say who it is: `auto` never finds it */
    /* Say hello, fill in the facts, set the reporting format. CAL_TIMEOUT and CAL_PROTOCOL mean
     * that it is another instrument. */
    cal_status (*identify)(instrument *in, int timeout_ms, cal_error *err);
    /* One reading. */
    cal_status (*measure)(instrument *in, int timeout_ms, reading *out, cal_error *err);
    /* Forget readings that came before now. */
    cal_status (*discard)(instrument *in);
    /* Pure: fuzzed and tested apart. Used by measure. Only line printers look at the format. */
    parse_result (*parse)(const line_format *format, const uint8_t *bytes, size_t n, size_t *used,
                          reading *out);
    /* Put back what identify changed; the port may be gone. NULL: nothing to put back. */
    void (*leave)(instrument *in);
};

/* Something the instrument told about itself. */
typedef struct instrument_fact {
    char key[32];
    char value[80];
} instrument_fact;

enum { INSTRUMENT_FACTS = 24, INSTRUMENT_BUFFER = 2048 };

struct instrument {
    const instrument_driver *driver;
    const char *preset; /* what follows NAME: in --instrument, or "" */
    transport *port;
    line_format format;
    instrument_fact facts[INSTRUMENT_FACTS];
    size_t fact_count;
    uint8_t buffer[INSTRUMENT_BUFFER]; /* bytes no parser has taken yet */
    size_t have;
    unsigned noise; /* lines that were nothing we know */
    int late_reads; /* since the deadline */
    int idle_ms;    /* longest pause inside a line */
};

/* A USB device by its numbers. */
typedef struct usb_model {
    unsigned vendor, product;
    const char *title;
    const char *driver; /* NULL: not one that lccal can use, and */
    const char *advice; /* what to do instead */
} usb_model;

extern const usb_model usb_models[];
extern const size_t usb_model_count;

/* NULL: lccal does not know it. */
const usb_model *usb_model_find(unsigned vendor, unsigned product);

extern const instrument_driver *const instrument_drivers[];
extern const size_t instrument_driver_count;

/* By its name; NULL: there is none. */
const instrument_driver *instrument_driver_find(const char *name);

/* Set up `name` ("printalyzer", "line:PRESET", "auto"...) on an open port. */
cal_status instrument_open(const char *name, transport *port, int timeout_ms, instrument *in,
                           cal_error *err);
void instrument_close(instrument *in); /* closes the port too */

void instrument_fact_set(instrument *in, const char *key, const char *value, size_t n);
const char *instrument_fact_get(const instrument *in, const char *key); /* "" when unknown */

/* Read and parse until a reading came: what `measure` of every user-triggered driver does. */
cal_status instrument_listen(instrument *in, int timeout_ms, reading *out, cal_error *err);
cal_status instrument_discard(instrument *in);
/* Send a NUL-terminated command. */
cal_status instrument_send(instrument *in, const char *command, cal_error *err);
/* Read more bytes into the buffer; they may have come until `deadline` of the port's clock. */
cal_status instrument_fill(instrument *in, int64_t deadline);
/* Drop the first n bytes of the buffer. */
void instrument_drop(instrument *in, size_t n);
/* Explain a transport's failure. */
cal_status instrument_fail(const instrument *in, cal_status status, cal_error *err);

/* Find the first line in bytes. PARSE_OK: it is bytes[*start .. *start + *length - 1] and ends
 * before *used. PARSE_BAD: *used bytes belong to a line too long to be anything; what is left of
 * it stays too long, so its tail is never taken for a line. Lines end by CR, LF or CR LF. */
parse_result line_split(const uint8_t *bytes, size_t n, size_t *start, size_t *length,
                        size_t *used);

#endif
