/* SPDX-License-Identifier: MIT */
#include "filter.h"
#include "page.h"
#include "raster.h"

#include <errno.h>
#include <string.h>

/* The header goes out marked, then the rows. */
static bool one_page(const filter_job *job, unsigned number, cups_page_header2_t *header,
                     raster_reader *reader, raster_writer *writer)
{
    raster_format format;
    char text[200];
    bool correct = job->correct;
    if (correct && raster_marked(header)) {
        filter_say("INFO", "page %u is corrected already and passes unchanged", number);
        correct = false;
    }
    const char *why = raster_check(header, job->lightness, &format, text, sizeof text);
    if (why) {
        filter_say("ERROR", "page %u: %s", number, why);
        return false;
    }
    if (correct && !raster_mark(header))
        filter_say("WARNING",
                   "page %u: no cupsString is free for the mark of a corrected page: do "
                   "not send it through this filter again",
                   number);
    if (!writer->raster || !raster_write_header(writer, header)) {
        filter_say("ERROR", "page %u: the output cannot be written: %s", number, strerror(errno));
        return false;
    }
    if (!correct)
        return page_copy(job, number, &format, reader, writer);
    return page_correct(job, number, &format, reader, writer);
}

bool filter_run(const filter_job *job, cups_raster_iocb_t read, void *read_context,
                cups_raster_iocb_t write, void *write_context)
{
    raster_reader reader;
    raster_writer writer = {0};
    cups_page_header2_t header;
    unsigned number = 0;
    bool good = true, damaged = false;
    const char *why = raster_reader_open(&reader, read, read_context);
    if (why) {
        filter_say("ERROR", "%s", why);
        return false;
    }
    while (good && raster_read_header(&reader, &header, &damaged)) {
        if (number++ == 0)
            raster_writer_open(&writer, &reader, &header, write, write_context);
        good = one_page(job, number, &header, &reader, &writer);
        if (good && job->say_pages)
            filter_say("PAGE", "%u %u", number, header.NumCopies > 0 ? header.NumCopies : 1);
    }
    if (good && (damaged || number == 0)) {
        filter_say("ERROR",
                   damaged ? "page %u: its header is damaged or cut short"
                           : "the raster has no page",
                   number + 1);
        good = false;
    }
    cupsRasterClose(writer.raster);
    cupsRasterClose(reader.raster);
    return good;
}
