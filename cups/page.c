/* SPDX-License-Identifier: MIT */
#include "page.h"

#include "pack.h"
#include "pipeline.h"
#include "repeats.h"
#include "sample.h"

#include <errno.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define MAP_SAMPLES ((size_t)1 << 17) /* light is smooth: so many give the mean of a map */

/* What one thread needs of its own. */
typedef struct hand {
    illuminance_rows light_rows;
    row_sample sample;
    float *light;          /* of the sample */
    double *r;             /* of the sample */
    unsigned char *spread; /* one grey row as RGB */
    repeats repeats;       /* of pages that may repeat themselves */
    lcor_mean mean;
    lcor_row_stats stats;
} hand;

typedef struct page {
    const filter_job *job;
    unsigned number;
    const raster_format *format;
    raster_reader *reader;
    raster_writer *writer;
    lcor_plan_options options;
    lcor_plan *measure; /* gives r of a sample */
    lcor_plan *plan;
    lcor_plan *band_plans[PIPELINE_SLOTS_MAX]; /* running mean: each band has its own */
    int spool;                                 /* the page between two passes, or -1 */
    size_t workers;
    size_t hand_count; /* one for each worker; with a running mean, then the filling thread's */
    hand *hands;
    bool repeats; /* interleaved samples of 8 bits: what repeats is computed once */
} page;

/* The mean of r depends on the pixels ... */
static bool is_mean_of_pixels(const filter_job *job)
{
    return job->reading == LCOR_READING_TEXEL && !job->r_mean_given;
}

/* ... and is that of the rows so far. */
static bool is_running_mean(const filter_job *job)
{
    return is_mean_of_pixels(job) && !job->two_passes;
}

/* ---- rows ---- */

/* A grey row as three equal samples, 0 = black. */
static void spread_grey(const raster_format *format, const unsigned char *row, unsigned char *rgb)
{
    if (format->type == LCOR_U8) {
        const unsigned char flip = format->inverted ? 0xff : 0;
        for (size_t x = 0; x < format->width; x++)
            rgb[3 * x] = rgb[3 * x + 1] = rgb[3 * x + 2] = row[x] ^ flip;
    } else {
        const uint16_t flip = format->inverted ? 0xffff : 0;
        for (size_t x = 0; x < format->width; x++) {
            uint16_t v[3];
            memcpy(v, row + 2 * x, 2);
            v[0] = v[1] = v[2] = v[0] ^ flip;
            memcpy(rgb + 6 * x, v, 6);
        }
    }
}

/* Back again: a corrected grey is grey, so its green stands for all. */
static void gather_grey(const raster_format *format, const unsigned char *rgb, unsigned char *row)
{
    if (format->type == LCOR_U8) {
        const unsigned char flip = format->inverted ? 0xff : 0;
        for (size_t x = 0; x < format->width; x++)
            row[x] = rgb[3 * x + 1] ^ flip;
    } else {
        const uint16_t flip = format->inverted ? 0xffff : 0;
        for (size_t x = 0; x < format->width; x++) {
            uint16_t v;
            memcpy(&v, rgb + 6 * x + 2, 2);
            v ^= flip;
            memcpy(row + 2 * x, &v, 2);
        }
    }
}

static bool no_light(const page *p)
{
    filter_say("ERROR", "page %u: the illuminance map cannot be read any more", p->number);
    return false;
}

/* r of the pixels that stand for row y; `row` may be NULL where only light counts. */
static bool measure_row(const page *p, hand *h, size_t y, const unsigned char *row)
{
    row_sample *s = &h->sample;
    row_sample_place(s, y);
    if (row)
        row_sample_take(s, row);
    if (!illuminance_at(&h->light_rows, y, s->count, s->x, h->light))
        return no_light(p);
    lcor_plan_reflectance_row(p->measure, s->count, s->texels, h->light, NULL, h->r);
    lcor_mean_add(&h->mean, s->count, h->r, NULL);
    return true;
}

static bool measure_rows(const page *p, hand *h, const pipeline_band *band)
{
    for (size_t i = 0; i < band->rows; i++)
        if (!measure_row(p, h, band->first + i, band->pixels + i * p->format->row_bytes))
            return false;
    return true;
}

/* ---- what the pipeline calls ---- */

static bool fill_from_raster(void *user, pipeline_band *band)
{
    page *p = user;
    const unsigned size = (unsigned)(band->rows * p->format->row_bytes);
    if (cupsRasterReadPixels(p->reader->raster, band->pixels, size) == size)
        return true;
    filter_say("ERROR", "page %u: the raster ends or is damaged within rows %zu to %zu of %zu",
               p->number, band->first + 1, band->first + band->rows, p->format->height);
    return false;
}

static size_t units_of_row(const raster_format *format)
{
    return format->row_bytes / format->unit_bytes;
}

/* The most bytes of a packed row. */
static size_t packed_row_max(const raster_format *format)
{
    return pack_row_max(units_of_row(format), format->unit_bytes);
}

/* All of some bytes to or from the spool file, which goes from its beginning to its end. */
static bool through_spool(page *p, unsigned char *bytes, size_t size, bool out)
{
    for (size_t done = 0; done < size;) {
        const ssize_t n = out ? write(p->spool, bytes + done, size - done)
                              : read(p->spool, bytes + done, size - done);
        if (n <= 0 && !(n < 0 && errno == EINTR)) {
            filter_say("ERROR", "page %u: the temporary file cannot be %s: %s", p->number,
                       out ? "written" : "read", n < 0 ? strerror(errno) : "it is too short");
            return false;
        }
        done += n > 0 ? (size_t)n : 0;
    }
    return true;
}

static bool damaged_spool(const page *p)
{
    filter_say("ERROR", "page %u: the temporary file is damaged", p->number);
    return false;
}

/* In the spool file bands are packed, each after its size. */
static bool fill_from_spool(void *user, pipeline_band *band)
{
    page *p = user;
    unsigned char *size = (unsigned char *)&band->packed_size;
    if (!through_spool(p, size, sizeof band->packed_size, false))
        return false;
    if (band->packed_size > band->rows * packed_row_max(p->format))
        return damaged_spool(p);
    return through_spool(p, band->packed, band->packed_size, false);
}

static bool empty_to_spool(void *user, pipeline_band *band)
{
    unsigned char *size = (unsigned char *)&band->packed_size;
    return through_spool(user, size, sizeof band->packed_size, true) &&
           through_spool(user, band->packed, band->packed_size, true);
}

static bool empty_to_raster(void *user, pipeline_band *band)
{
    const page *p = user;
    const bool packs = p->writer->packs;
    if (raster_write(p->writer, packs ? band->packed : band->pixels,
                     packs ? band->packed_size : band->rows * p->format->row_bytes))
        return true;
    filter_say("ERROR", "page %u: the output cannot be written: %s", p->number, strerror(errno));
    return false;
}

static bool new_plan(const page *p, const lcor_plan_options *options, lcor_plan **plan)
{
    lcor_error error;
    lcor_plan_free(*plan);
    *plan = NULL;
    if (lcor_plan_new(options, plan, &error) == LCOR_OK)
        return true;
    filter_say("ERROR", "page %u: %s", p->number, error.text);
    return false;
}

static bool take_mean(page *p, const lcor_mean *mean)
{
    lcor_error error;
    if (lcor_mean_get(mean, p->job->mean_method, &p->options.r_mean, &error) == LCOR_OK)
        return true;
    filter_say("ERROR", "page %u: no mean of r: %s", p->number, error.text);
    return false;
}

/* One pass: the mean of what has been seen so far. */
static bool fill_and_adapt(void *user, pipeline_band *band)
{
    page *p = user;
    hand *h = &p->hands[p->hand_count - 1];
    return fill_from_raster(p, band) && measure_rows(p, h, band) && take_mean(p, &h->mean) &&
           new_plan(p, &p->options, &p->band_plans[band->slot]);
}

static bool work_measure(void *user, size_t worker, pipeline_band *band)
{
    page *p = user;
    const raster_format *format = p->format;
    band->packed_size =
        pack_rows(band->pixels, band->rows, units_of_row(format), format->unit_bytes, band->packed);
    return measure_rows(p, &p->hands[worker], band);
}

/* All that is left to do with corrected rows, and with those that only pass. */
static bool work_pack(void *user, size_t worker, pipeline_band *band)
{
    const page *p = user;
    (void)worker;
    if (p->writer->packs)
        band->packed_size =
            raster_pack(p->writer, p->format, band->rows, band->pixels, band->packed);
    return true;
}

static bool work_correct(void *user, size_t worker, pipeline_band *band)
{
    page *p = user;
    hand *h = &p->hands[worker];
    const raster_format *format = p->format;
    const lcor_plan *plan = p->band_plans[band->slot] ? p->band_plans[band->slot] : p->plan;
    if (p->spool >= 0 && !unpack_rows(band->packed, band->packed_size, band->rows,
                                      units_of_row(format), format->unit_bytes, band->pixels))
        return damaged_spool(p);
    if (p->band_plans[band->slot])
        repeats_forget(&h->repeats);
    for (size_t i = 0; i < band->rows; i++) {
        const size_t y = band->first + i;
        unsigned char *row = band->pixels + i * format->row_bytes, *texels = row;
        const float *light = illuminance_row(&h->light_rows, y);
        if (!light)
            return no_light(p);
        if (format->samples == 1)
            spread_grey(format, row, texels = h->spread);
        if (p->repeats)
            repeats_correct_row(&h->repeats, plan, y, texels, light, h->light_rows.drawn,
                                &h->stats);
        else
            lcor_correct_row(plan, y, format->width, texels, light, NULL, texels, &h->stats);
        if (texels != row)
            gather_grey(format, texels, row);
    }
    return work_pack(p, worker, band);
}

/* ---- the page ---- */

static bool run(page *p, bool (*fill)(void *, pipeline_band *),
                bool (*work)(void *, size_t, pipeline_band *),
                bool (*empty)(void *, pipeline_band *))
{
    const bool packs = p->spool >= 0 || p->writer->packs;
    const pipeline line = {.height = p->format->height,
                           .row_bytes = p->format->row_bytes,
                           .packed_row_bytes = packs ? packed_row_max(p->format) : 0,
                           .workers = p->workers,
                           .fill = fill,
                           .work = work,
                           .empty = empty,
                           .user = p};
    bool no_memory;
    const bool good = pipeline_run(&line, &no_memory);
    if (no_memory)
        filter_say("ERROR", "page %u: no memory for %zu bytes a row, or no threads", p->number,
                   p->format->row_bytes);
    return good;
}

/* Patch reading: r is the map times a constant, so the pixels play no part and the map gives its
 * mean before the page is read. */
static bool mean_of_map(page *p)
{
    hand *h = &p->hands[0];
    const size_t step = 1 + p->format->height / (1 + MAP_SAMPLES / h->sample.count);
    if (p->job->map.width == 0) { /* a rho or a tone curve of its own */
        p->options.r_mean = p->job->rho;
        return true;
    }
    for (size_t y = step / 2; y < p->format->height; y += step)
        if (!measure_row(p, h, y, NULL))
            return false;
    return take_mean(p, &h->mean);
}

/* Texel reading: the pixels decide, so the page is read to its end and kept in a file. */
static bool mean_of_pixels(page *p)
{
    char path[1024];
    const char *folder = getenv("TMPDIR");
    snprintf(path, sizeof path, "%s/rastertolcorXXXXXX", folder ? folder : "/tmp");
    p->spool = mkstemp(path);
    if (p->spool < 0) {
        filter_say("ERROR", "page %u: no temporary file in %s: %s", p->number,
                   folder ? folder : "/tmp", strerror(errno));
        return false;
    }
    unlink(path); /* gone with this process, however it ends */
    if (!run(p, fill_from_raster, work_measure, empty_to_spool))
        return false;
    for (size_t i = 1; i < p->hand_count; i++)
        if (lcor_mean_merge(&p->hands[0].mean, &p->hands[i].mean, NULL) != LCOR_OK)
            return false;
    if (lseek(p->spool, 0, SEEK_SET) != 0) {
        filter_say("ERROR", "page %u: the temporary file cannot be read: %s", p->number,
                   strerror(errno));
        return false;
    }
    return take_mean(p, &p->hands[0].mean);
}

static bool make_hand(const page *p, hand *h)
{
    const size_t width = p->format->width;
    const bool is_grey = p->format->samples == 1;
    lcor_mean_init(&h->mean);
    h->spread = is_grey ? malloc(width * 6) : NULL;
    if ((h->spread || !is_grey) && (!p->repeats || repeats_open(&h->repeats, width)) &&
        row_sample_open(&h->sample, p->format) &&
        (h->light = malloc(h->sample.count * sizeof *h->light)) &&
        (h->r = malloc(h->sample.count * sizeof *h->r)) &&
        illuminance_rows_open(&h->light_rows, &p->job->map, width, p->format->height,
                              p->format->type == LCOR_U8))
        return true;
    filter_say("ERROR", "page %u: no memory for rows of %zu pixels", p->number, width);
    return false;
}

/* What the threads need of their own, and what tells them r. */
static bool make_hands(page *p)
{
    lcor_plan_options options = p->options;
    options.in_layout = options.out_layout = (lcor_layout){0}; /* as samples lie */
    p->hand_count = p->workers + is_running_mean(p->job);
    p->hands = calloc(p->hand_count, sizeof *p->hands);
    if (!p->hands) {
        filter_say("ERROR", "page %u: no memory", p->number);
        return false;
    }
    for (size_t i = 0; i < p->hand_count; i++)
        if (!make_hand(p, &p->hands[i]))
            return false;
    return new_plan(p, &options, &p->measure);
}

static void close_page(page *p)
{
    for (size_t i = 0; p->hands && i < p->hand_count; i++) {
        free(p->hands[i].light);
        free(p->hands[i].r);
        free(p->hands[i].spread);
        repeats_close(&p->hands[i].repeats);
        row_sample_close(&p->hands[i].sample);
        illuminance_rows_close(&p->hands[i].light_rows);
    }
    free(p->hands);
    for (size_t i = 0; i < PIPELINE_SLOTS_MAX; i++)
        lcor_plan_free(p->band_plans[i]);
    lcor_plan_free(p->measure);
    lcor_plan_free(p->plan);
    if (p->spool >= 0)
        close(p->spool);
    free(p);
}

static void set_options(page *p)
{
    const filter_job *job = p->job;
    lcor_plan_options *o = &p->options;
    o->struct_size = sizeof *o;
    o->contrast = job->contrast;
    o->r_mean = job->r_mean;
    o->rho = job->rho;
    o->exponent = job->exponent;
    o->reading = job->reading;
    o->gamut = job->gamut;
    o->colour = &p->format->colour;
    o->in_type = o->out_type = p->format->type;
    o->map_type = LCOR_F32;
    o->in_layout = o->out_layout = p->format->layout;
    o->tone_curve = job->tone_curve;
    o->tone_size = job->tone_size;
}

static void report(const page *p)
{
    lcor_row_stats sum = {0};
    for (size_t i = 0; i < p->hand_count; i++) {
        const lcor_row_stats *s = &p->hands[i].stats;
        sum.pixels += s->pixels;
        sum.clipped_low += s->clipped_low;
        sum.clipped_high += s->clipped_high;
        sum.out_of_gamut += s->out_of_gamut;
        sum.non_finite += s->non_finite;
    }
    filter_say("DEBUG", "page %u: r_mean %.9g, contrast %.4g", p->number, p->options.r_mean,
               p->options.contrast);
    filter_say("DEBUG",
               "page %u: %llu pixels computed, %llu too dark and %llu too light for the device, "
               "%llu outside its gamut",
               p->number, (unsigned long long)sum.pixels, (unsigned long long)sum.clipped_low,
               (unsigned long long)sum.clipped_high, (unsigned long long)sum.out_of_gamut);
    if (sum.non_finite > 0)
        filter_say("WARNING",
                   "page %u: the illuminance map is negative or no number under pixels that are "
                   "black now",
                   p->number);
}

static page *open_page(const filter_job *job, unsigned number, const raster_format *format,
                       raster_reader *reader, raster_writer *writer)
{
    page *p = calloc(1, sizeof *p);
    if (!p) {
        filter_say("ERROR", "page %u: no memory", number);
        return NULL;
    }
    p->job = job;
    p->number = number;
    p->format = format;
    p->reader = reader;
    p->writer = writer;
    p->workers = pipeline_workers(job->threads, format->height, format->row_bytes);
    p->spool = -1;
    return p;
}

/* Patch reading in even light: q = r / r_mean is 1, T is 1/2, and Ynew = T y / rho is y. */
static bool changes_nothing(const filter_job *job)
{
    return job->reading == LCOR_READING_PATCH && job->map.width == 0 && !job->r_mean_given &&
           job->rho == 0.5 && !job->tone_curve;
}

bool page_correct(const filter_job *job, unsigned number, const raster_format *format,
                  raster_reader *reader, raster_writer *writer)
{
    page *p = open_page(job, number, format, reader, writer);
    if (!p)
        return false;
    if (changes_nothing(job)) {
        filter_say("DEBUG", "page %u: the light is even, which changes nothing", number);
        const bool copied = run(p, fill_from_raster, work_pack, empty_to_raster);
        close_page(p);
        return copied;
    }
    set_options(p);
    p->repeats = format->type == LCOR_U8 && p->options.in_layout.pixel_step == 3;
    bool good = make_hands(p);
    bool (*fill)(void *, pipeline_band *) = fill_from_raster;
    if (is_running_mean(job)) {
        fill = fill_and_adapt;
    } else if (good && is_mean_of_pixels(job)) {
        good = mean_of_pixels(p);
        fill = fill_from_spool;
    } else if (good && !job->r_mean_given) {
        good = mean_of_map(p);
    }
    good =
        good && new_plan(p, &p->options, &p->plan) && run(p, fill, work_correct, empty_to_raster);
    if (good)
        report(p);
    close_page(p);
    return good;
}

bool page_copy(const filter_job *job, unsigned number, const raster_format *format,
               raster_reader *reader, raster_writer *writer)
{
    page *p = open_page(job, number, format, reader, writer);
    if (!p)
        return false;
    const bool good = run(p, fill_from_raster, work_pack, empty_to_raster);
    close_page(p);
    return good;
}
