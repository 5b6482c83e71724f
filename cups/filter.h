/* SPDX-License-Identifier: MIT */
/* What the parts of rastertolcor share: messages for the scheduler, numbers of job options, and the
 * settings of one job. */
#ifndef RASTERTOLCOR_FILTER_H
#define RASTERTOLCOR_FILTER_H

#include "illuminance.h"

#include <cups/cups.h>
#include <cups/ppd.h>
#include <cups/raster.h>
#include <lcor/lcor.h>

#include <stdbool.h>
#include <stddef.h>

/* One line "LEVEL: text" on stderr, as filter(7) wants it. LEVEL: ERROR, WARNING, INFO, DEBUG. */
void filter_say(const char *level, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* [+-] digits [. digits] [e [+-] digits], the whole text, in C notation whatever the locale. */
bool filter_number(const char *text, double *out);

/* What one job asks for; made once, then only read. */
typedef struct filter_job {
    bool correct; /* lcor-correction; false: copy */
    bool two_passes;
    bool r_mean_given;
    double r_mean;
    lcor_mean_method mean_method;
    double contrast, rho, exponent;
    lcor_reading reading;
    lcor_gamut gamut;
    lcor_lightness lightness;
    illuminance_map map; /* width 0: the same light everywhere */
    float *tone_curve;
    size_t tone_size;
    size_t threads; /* that correct; 0: one for each processor */
    bool say_pages; /* PAGE lines: no later filter counts them */
} filter_job;

/* Settings from the job's options, then from the PPD's options and keywords. On false one ERROR
 * line was said. job_close frees what it holds. */
bool job_open(filter_job *job, int option_count, cups_option_t *options, ppd_file_t *ppd);
void job_close(filter_job *job);

/* Correct every page of the raster that `read` gives into `write`; true if all went well, else one
 * ERROR line was said. */
bool filter_run(const filter_job *job, cups_raster_iocb_t read, void *read_context,
                cups_raster_iocb_t write, void *write_context);

#endif
