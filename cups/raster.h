/* SPDX-License-Identifier: MIT */
/* CUPS and PWG raster streams: which pages can be corrected, a way through libcups that keeps
 * headers whole, and rows on their way out. */
#ifndef RASTERTOLCOR_RASTER_H
#define RASTERTOLCOR_RASTER_H

#include <cups/raster.h>
#include <lcor/correct.h>

#include <stdbool.h>
#include <stddef.h>

/* How the rows of a page lie in memory. */
typedef struct raster_format {
    size_t width, height;
    size_t row_bytes;
    size_t samples;     /* a pixel: 1 (grey) or 3 */
    size_t unit_bytes;  /* what compression repeats: a pixel, or in banded order a sample */
    bool inverted;      /* K: 0 is white */
    lcor_sample type;   /* LCOR_U8 or LCOR_U16 */
    lcor_layout layout; /* of a row of three samples; grey rows are spread to RGB first */
    lcor_colour colour;
} raster_format;

/* Derives every size from width, colour space and depth and compares it with what the header says.
 * NULL if the page can be corrected, else why not, in `text`. */
const char *raster_check(const cups_page_header2_t *header, lcor_lightness lightness,
                         raster_format *format, char *text, size_t capacity);

/* The mark of a corrected page: one of the header's free strings. */
bool raster_marked(const cups_page_header2_t *header);
bool raster_mark(cups_page_header2_t *header); /* false: no string is free */

/* A stream being read, and one being written of the same kind. */
typedef struct raster_reader {
    cups_raster_t *raster;
    cups_raster_iocb_t read;
    void *context;
    unsigned char sync[4];
    size_t seen;  /* bytes of sync */
    bool ended;   /* the stream had no more bytes */
    size_t since; /* bytes read since the last header was asked for */
} raster_reader;

typedef struct raster_writer {
    cups_raster_t *raster;
    cups_raster_iocb_t write;
    void *context;
    bool packs; /* the stream is compressed */
    bool pwg;
    bool replace;               /* the next write is a PWG header: `header` goes out instead */
    cups_page_header2_t header; /* in the big-endian order of PWG raster */
} raster_writer;

/* NULL if the stream can be read, else why not. */
const char *raster_reader_open(raster_reader *reader, cups_raster_iocb_t read, void *context);
/* True for a page header, false at the end of the stream; *damaged if neither. */
bool raster_read_header(raster_reader *reader, cups_page_header2_t *header, bool *damaged);
/* The kind of stream `reader` is, now that its first page header is known. */
bool raster_writer_open(raster_writer *writer, const raster_reader *reader,
                        const cups_page_header2_t *first, cups_raster_iocb_t write, void *context);
bool raster_write_header(raster_writer *writer, cups_page_header2_t *header);
/* Rows of a compressed stream, packed into `to`; changes `pixels`. Any thread may do it. */
size_t raster_pack(const raster_writer *writer, const raster_format *format, size_t rows,
                   unsigned char *pixels, unsigned char *to);
/* Rows in order, packed if the stream is compressed. */
bool raster_write(const raster_writer *writer, unsigned char *bytes, size_t size);

#endif
