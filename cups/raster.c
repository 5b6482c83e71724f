/* SPDX-License-Identifier: MIT */
#include "raster.h"

#include "pack.h"

#include <arpa/inet.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#define WIDTH_MAX 262144 /* pixels: 11 m at 600 dpi */

static const char mark[] = "lcor corrected";

/* Linear RGB -> XYZ of Adobe RGB (1998), section 4.3.5.3 of its specification; gamma 563/256. */
static const double adobe_rgb[9] = {0.57667, 0.18556, 0.18823, 0.29734, 0.62736,
                                    0.07529, 0.02703, 0.07069, 0.99134};

static bool colour_space(cups_cspace_t space, lcor_lightness lightness, raster_format *format)
{
    lcor_primaries primaries = LCOR_PRIMARIES_SRGB;
    lcor_transfer transfer = LCOR_TRANSFER_SRGB;
    switch ((int)space) {
    case CUPS_CSPACE_K:
    case CUPS_CSPACE_W:
    case CUPS_CSPACE_SW:
        format->samples = 1;
        format->inverted = space == CUPS_CSPACE_K;
        break;
    case CUPS_CSPACE_ADOBERGB:
        primaries = LCOR_PRIMARIES_CUSTOM;
        transfer = LCOR_TRANSFER_GAMMA;
        format->samples = 3;
        break;
    case CUPS_CSPACE_RGB:
    case CUPS_CSPACE_SRGB: format->samples = 3; break;
    default: return false;
    }
    return lcor_colour_init(&format->colour, primaries,
                            primaries == LCOR_PRIMARIES_CUSTOM ? adobe_rgb : NULL, transfer,
                            563.0 / 256.0, lightness, NULL) == LCOR_OK;
}

const char *raster_check(const cups_page_header2_t *header, lcor_lightness lightness,
                         raster_format *format, char *text, size_t capacity)
{
    memset(format, 0, sizeof *format);
    const unsigned bits = header->cupsBitsPerColor;
    const bool banded = header->cupsColorOrder == CUPS_ORDER_BANDED;
    if (!colour_space(header->cupsColorSpace, lightness, format))
        snprintf(text, capacity,
                 "colour space %d cannot be corrected: choose RGB, sRGB, AdobeRGB, W, sGray or K",
                 (int)header->cupsColorSpace);
    else if (header->cupsColorOrder != CUPS_ORDER_CHUNKED && !banded)
        snprintf(text, capacity,
                 "planar order cannot be corrected row by row: choose chunked "
                 "or banded order");
    else if (bits != 8 && bits != 16)
        snprintf(text, capacity, "%u bits per colour cannot be corrected: choose 8 or 16", bits);
    else if (header->cupsWidth == 0 || header->cupsWidth > WIDTH_MAX || header->cupsHeight == 0)
        snprintf(text, capacity, "the header says %u x %u pixels: at least 1 x 1, at most %d wide",
                 header->cupsWidth, header->cupsHeight, WIDTH_MAX);
    else
        *text = '\0';
    if (*text)
        return text;

    format->width = header->cupsWidth;
    format->height = header->cupsHeight;
    format->row_bytes = format->width * format->samples * (bits / 8);
    format->type = bits == 8 ? LCOR_U8 : LCOR_U16;
    format->unit_bytes = bits / 8 * (banded ? 1 : format->samples);
    format->layout.pixel_step = banded && format->samples == 3 ? 1 : 3;
    format->layout.channel_step = banded && format->samples == 3 ? format->width : 1;
    /* libcups counts the bits of one band's pixel in banded order; some writers count all bands. */
    const unsigned all = bits * (unsigned)format->samples;
    if (header->cupsBytesPerLine != format->row_bytes)
        snprintf(text, capacity, "the header says %u bytes a line, but %u pixels need %lu",
                 header->cupsBytesPerLine, header->cupsWidth, (unsigned long)format->row_bytes);
    else if (header->cupsBitsPerPixel != all && !(banded && header->cupsBitsPerPixel == bits))
        snprintf(text, capacity, "the header says %u bits a pixel, but %u colours of %u bits",
                 header->cupsBitsPerPixel, (unsigned)format->samples, bits);
    else if (header->cupsNumColors != format->samples)
        snprintf(text, capacity, "the header says %u colours, but its colour space has %u",
                 header->cupsNumColors, (unsigned)format->samples);
    return *text ? text : NULL;
}

bool raster_marked(const cups_page_header2_t *header)
{
    for (size_t i = 0; i < 16; i++)
        if (strncmp(header->cupsString[i], mark, sizeof header->cupsString[i]) == 0)
            return true;
    return false;
}

bool raster_mark(cups_page_header2_t *header)
{
    for (size_t i = 16; i-- > 0;) {
        if (header->cupsString[i][0] == '\0') {
            memset(header->cupsString[i], 0, sizeof header->cupsString[i]);
            memcpy(header->cupsString[i], mark, sizeof mark);
            return true;
        }
    }
    return false;
}

/* libcups does not say which kind of stream it reads, so its first four bytes are kept. */
static ssize_t read_and_keep(void *context, unsigned char *buffer, size_t size)
{
    raster_reader *reader = context;
    const ssize_t got = reader->read(reader->context, buffer, size);
    for (ssize_t i = 0; i < got && reader->seen < sizeof reader->sync; i++)
        reader->sync[reader->seen++] = buffer[i];
    reader->ended = got == 0;
    reader->since += got > 0 ? (size_t)got : 0;
    return got;
}

const char *raster_reader_open(raster_reader *reader, cups_raster_iocb_t read, void *context)
{
    memset(reader, 0, sizeof *reader);
    reader->read = read;
    reader->context = context;
    reader->raster = cupsRasterOpenIO(read_and_keep, reader, CUPS_RASTER_READ);
    if (!reader->raster)
        return reader->seen == 0 ? "the input is empty" : "the input is no CUPS or PWG raster";
    if (memcmp(reader->sync, "UNIR", 4) == 0 || memcmp(reader->sync, "RINU", 4) == 0) {
        cupsRasterClose(reader->raster);
        return "Apple raster has no place for the mark of a corrected page: send CUPS or PWG "
               "raster";
    }
    return NULL;
}

bool raster_read_header(raster_reader *reader, cups_page_header2_t *header, bool *damaged)
{
    reader->since = 0;
    const bool good = cupsRasterReadHeader2(reader->raster, header) != 0;
    /* libcups tells neither a header it rejects nor a part of one from the end of the stream. */
    *damaged = !good && (!reader->ended || reader->since > 0);
    return good;
}

/* libcups' PWG writer leaves out most of the header: image box, print quality, vendor data. It
 * passes the header here in one piece, so ours can take its place. */
static ssize_t write_or_replace(void *context, unsigned char *buffer, size_t size)
{
    raster_writer *writer = context;
    if (writer->replace && size == sizeof writer->header)
        memcpy(buffer, &writer->header, size);
    writer->replace = false;
    return writer->write(writer->context, buffer, size);
}

bool raster_writer_open(raster_writer *writer, const raster_reader *reader,
                        const cups_page_header2_t *first, cups_raster_iocb_t write, void *context)
{
    cups_mode_t mode = CUPS_RASTER_WRITE;
    if (memcmp(reader->sync, "2SaR", 4) == 0 || memcmp(reader->sync, "RaS2", 4) == 0)
        mode = CUPS_RASTER_WRITE_COMPRESSED;
    if (memcmp(reader->sync, "RaS2", 4) == 0 && strcmp(first->MediaClass, "PwgRaster") == 0)
        mode = CUPS_RASTER_WRITE_PWG;
    memset(writer, 0, sizeof *writer);
    writer->packs = mode != CUPS_RASTER_WRITE;
    writer->pwg = mode == CUPS_RASTER_WRITE_PWG;
    writer->write = write;
    writer->context = context;
    writer->raster = cupsRasterOpenIO(write_or_replace, writer, mode);
    return writer->raster != NULL;
}

bool raster_write_header(raster_writer *writer, cups_page_header2_t *header)
{
    if (writer->pwg) {
        /* The words between the strings at both ends, as libcups' reader swaps them back. */
        const size_t begin = offsetof(cups_page_header2_t, AdvanceDistance);
        const size_t end = offsetof(cups_page_header2_t, cupsString);
        writer->header = *header;
        for (size_t at = begin; at < end; at += sizeof(uint32_t)) {
            uint32_t word;
            memcpy(&word, (const char *)header + at, sizeof word);
            word = htonl(word);
            memcpy((char *)&writer->header + at, &word, sizeof word);
        }
        writer->replace = true;
    }
    return cupsRasterWriteHeader2(writer->raster, header) != 0;
}

size_t raster_pack(const raster_writer *writer, const raster_format *format, size_t rows,
                   unsigned char *pixels, unsigned char *to)
{
    const size_t size = rows * format->row_bytes;
    if (writer->pwg && format->type == LCOR_U16) { /* big-endian */
        for (size_t i = 0; i < size; i += sizeof(uint16_t)) {
            uint16_t sample;
            memcpy(&sample, pixels + i, sizeof sample);
            sample = htons(sample);
            memcpy(pixels + i, &sample, sizeof sample);
        }
    }
    return pack_rows(pixels, rows, format->row_bytes / format->unit_bytes, format->unit_bytes, to);
}

bool raster_write(const raster_writer *writer, unsigned char *bytes, size_t size)
{
    while (size > 0) {
        const ssize_t put = writer->write(writer->context, bytes, size);
        if (put <= 0)
            return false;
        bytes += put;
        size -= (size_t)put;
    }
    return true;
}
