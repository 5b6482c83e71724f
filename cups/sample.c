/* SPDX-License-Identifier: MIT */
#include "sample.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

bool row_sample_open(row_sample *sample, const raster_format *format)
{
    const size_t width = format->width, rows = format->height;
    sample->format = format;
    sample->count = SAMPLE_PIXELS / rows < width ? SAMPLE_PIXELS / rows : width;
    if (sample->count == 0)
        sample->count = 1;
    sample->x = malloc(sample->count * sizeof *sample->x);
    sample->texels = malloc(sample->count * 6);
    if (sample->x && sample->texels)
        return true;
    row_sample_close(sample);
    return false;
}

void row_sample_close(row_sample *sample)
{
    free(sample->x);
    free(sample->texels);
    memset(sample, 0, sizeof *sample);
}

/* Every bit of the result depends on every bit of n. */
static uint32_t hash(uint32_t n)
{
    n = (n ^ n >> 16) * 0x7feb352du;
    n = (n ^ n >> 15) * 0x846ca68bu;
    return n ^ n >> 16;
}

void row_sample_place(row_sample *sample, size_t y)
{
    const size_t width = sample->format->width;
    const double stretch = (double)width / (double)sample->count;
    for (size_t i = 0; i < sample->count; i++) {
        const double place = (double)hash((uint32_t)(y * sample->count + i)) * 0x1p-32;
        const size_t x = (size_t)(((double)i + place) * stretch);
        sample->x[i] = x < width ? x : width - 1;
    }
}

void row_sample_take(row_sample *sample, const unsigned char *row)
{
    const raster_format *f = sample->format;
    const size_t size = f->type == LCOR_U8 ? 1 : 2;
    const size_t pixel = (f->samples == 3 ? f->layout.pixel_step : 1) * size;
    const size_t channel = (f->samples == 3 ? f->layout.channel_step : 0) * size;
    const unsigned char flip = f->inverted ? 0xff : 0;
    unsigned char *to = sample->texels;
    for (size_t i = 0; i < sample->count; i++)
        for (size_t k = 0; k < 3; k++)
            for (size_t byte = 0; byte < size; byte++)
                *to++ = row[sample->x[i] * pixel + k * channel + byte] ^ flip;
}
