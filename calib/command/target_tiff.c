/* SPDX-License-Identifier: MIT */
#include "command/target.h"

#ifdef LCCAL_TIFF

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <tiffio.h>

/* libtiff writes here, so that the file itself is saved like every other. */
typedef struct memory_file {
    buffer bytes;
    size_t at;
} memory_file;

static tmsize_t memory_write(thandle_t handle, void *data, tmsize_t n)
{
    memory_file *f = handle;
    const size_t count = (size_t)n;
    const size_t inside = f->at < f->bytes.size ? f->bytes.size - f->at : 0;
    const size_t over = count < inside ? count : inside;
    if (n <= 0 || f->at > f->bytes.size)
        return 0;
    if (over > 0)
        memcpy(f->bytes.bytes + f->at, data, over);
    buffer_bytes(&f->bytes, (const char *)data + over, count - over);
    f->at += count;
    return f->bytes.failed ? 0 : n;
}

static tmsize_t memory_read(thandle_t handle, void *data, tmsize_t n)
{
    memory_file *f = handle;
    const size_t left = f->at < f->bytes.size ? f->bytes.size - f->at : 0;
    const size_t count = (size_t)n < left ? (size_t)n : left;
    if (count > 0)
        memcpy(data, f->bytes.bytes + f->at, count);
    f->at += count;
    return (tmsize_t)count;
}

static toff_t memory_seek(thandle_t handle, toff_t offset, int whence)
{
    memory_file *f = handle;
    const size_t from = whence == SEEK_CUR ? f->at : whence == SEEK_END ? f->bytes.size : 0;
    size_t to = from + (size_t)offset;
    while (f->bytes.size < to && !f->bytes.failed) /* libtiff aligns its directory */
        buffer_bytes(&f->bytes, "", 1);
    f->at = to;
    return to;
}

static int memory_close(thandle_t handle)
{
    (void)handle;
    return 0;
}

static toff_t memory_size(thandle_t handle) { return ((memory_file *)handle)->bytes.size; }

static void set_tags(TIFF *tiff, uint32_t width, uint32_t height, double dpi)
{
    TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, width);
    TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, height);
    TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, 16);
    TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, 3);
    TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_RGB);
    TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
    TIFFSetField(tiff, TIFFTAG_ORIENTATION, ORIENTATION_TOPLEFT);
    TIFFSetField(tiff, TIFFTAG_COMPRESSION, COMPRESSION_LZW);
    TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, TIFFDefaultStripSize(tiff, 0));
    TIFFSetField(tiff, TIFFTAG_RESOLUTIONUNIT, RESUNIT_INCH);
    TIFFSetField(tiff, TIFFTAG_XRESOLUTION, dpi);
    TIFFSetField(tiff, TIFFTAG_YRESOLUTION, dpi);
    TIFFSetField(tiff, TIFFTAG_SOFTWARE, "lccal");
    TIFFSetField(tiff, TIFFTAG_IMAGEDESCRIPTION,
                 "lccal target: print at 100 % with all colour management off");
}

static long pixel(double mm, double dpi) { return (long)floor(mm * dpi / 25.4 + 0.5); }

static void draw_row(const target *t, long y, double dpi, uint16_t *row, uint32_t width)
{
    memset(row, 0xFF, (size_t)width * 3 * sizeof *row);
    for (size_t i = 0; i < t->count; i++) {
        const rectangle *r = &t->rectangles[i];
        if (y < pixel(r->y, dpi) || y >= pixel(r->y + r->height, dpi))
            continue;
        const long right = pixel(r->x + r->width, dpi);
        for (long x = pixel(r->x, dpi); x < right && x < (long)width; x++)
            for (int channel = 0; channel < 3; channel++)
                row[3 * x + channel] = (uint16_t)(257 * r->level);
    }
}

bool target_tiff(const target *t, double dpi, buffer *out)
{
    memory_file file = {{0}, 0};
    const uint32_t width = (uint32_t)pixel(t->width, dpi), height = (uint32_t)pixel(t->height, dpi);
    uint16_t *row = malloc((size_t)width * 3 * sizeof *row);
    TIFF *tiff = row ? TIFFClientOpen("target", "wm", &file, memory_read, memory_write, memory_seek,
                                      memory_close, memory_size, NULL, NULL)
                     : NULL;
    bool good = tiff != NULL;
    if (tiff) {
        set_tags(tiff, width, height, dpi);
        for (uint32_t y = 0; y < height && good; y++) {
            draw_row(t, (long)y, dpi, row, width);
            good = TIFFWriteScanline(tiff, row, y, 0) == 1;
        }
        good = TIFFFlush(tiff) && good;
        TIFFClose(tiff);
    }
    free(row);
    good = good && !file.bytes.failed;
    if (good)
        *out = file.bytes;
    else
        buffer_free(&file.bytes);
    return good;
}

#else

bool target_tiff(const target *t, double dpi, buffer *out)
{
    (void)t;
    (void)dpi;
    (void)out;
    return false;
}

#endif
