/* SPDX-License-Identifier: MIT */
/* One page: where its mean comes from, and its rows through the plan. */
#ifndef RASTERTOLCOR_PAGE_H
#define RASTERTOLCOR_PAGE_H

#include "filter.h"
#include "raster.h"

/* Correct the page whose header was read, into `writer` whose header was written. On false one
 * ERROR line was said. */
bool page_correct(const filter_job *job, unsigned number, const raster_format *format,
                  raster_reader *reader, raster_writer *writer);
/* The same bytes out as in. */
bool page_copy(const filter_job *job, unsigned number, const raster_format *format,
               raster_reader *reader, raster_writer *writer);

#endif
