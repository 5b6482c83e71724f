/* SPDX-License-Identifier: MIT */
/* rastertolcor: CUPS filter that corrects the lightness of raster pages for a printer of known
 * contrast. See rastertolcor(8). */
#include "filter.h"

#include <errno.h>
#include <fcntl.h>
#include <locale.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const char usage[] =
    "usage: rastertolcor JOB USER TITLE COPIES OPTIONS [FILE]\n"
    "Corrects the lightness of CUPS or PWG raster pages (FILE or standard input) for the contrast\n"
    "of the printer, onto standard output. OPTIONS are words such as \"lcor-contrast=23.4\":\n"
    "  lcor-profile=FILE | lcor-contrast=C    the device\n"
    "  lcor-illuminance=FILE                  PFM or PGM, stretched over the page\n"
    "  lcor-adaptation=FILE                   r_mean as lcor render saved it\n"
    "  lcor-mean=adaptive|literal|NUMBER      mean of the virtual reflectance r\n"
    "  lcor-passes=2|1                        1: with texels, the mean of the rows so far\n"
    "  lcor-reading=patch|texel  lcor-rho=R  lcor-exponent=T\n"
    "  lcor-gamut=keep-hue|clip  lcor-lightness=cie|paper  lcor-correction=on|off\n"
    "  lcor-threads=N                         1 to 8\n";

/* Nothing is left behind: temporary files have no name any more. */
static void cancel(int number)
{
    static const char text[] = "INFO: cancelled\n";
    (void)number;
    if (write(STDERR_FILENO, text, sizeof text - 1) < 0)
        _exit(1);
    _exit(0);
}

static void handle_signals(void)
{
    struct sigaction action = {.sa_handler = cancel};
    sigaction(SIGTERM, &action, NULL);
    action.sa_handler = SIG_IGN; /* a broken pipe is an error of write(2) */
    sigaction(SIGPIPE, &action, NULL);
}

static ssize_t read_descriptor(void *context, unsigned char *buffer, size_t size)
{
    ssize_t got;
    do
        got = read(*(const int *)context, buffer, size);
    while (got < 0 && errno == EINTR);
    return got;
}

static ssize_t write_descriptor(void *context, unsigned char *buffer, size_t size)
{
    ssize_t put;
    do
        put = write(*(const int *)context, buffer, size);
    while (put < 0 && errno == EINTR);
    return put;
}

/* PAGE lines are for the last filter of a chain, or every page would be counted twice.
 * FINAL_CONTENT_TYPE is what the PPD's own filter takes: if it is a raster that this filter reads,
 * this filter is the PPD's. */
static bool is_last(void)
{
    const char *final = getenv("FINAL_CONTENT_TYPE");
    return !final || strcmp(final, "image/pwg-raster") == 0 ||
           strcmp(final, "application/vnd.cups-raster") == 0;
}

int main(int argc, char *argv[])
{
    int in = STDIN_FILENO, out = STDOUT_FILENO;
    if (argc == 2 && strcmp(argv[1], "--help") == 0)
        return fputs(usage, stdout) < 0;
    if (argc == 2 && strcmp(argv[1], "--version") == 0)
        return printf("rastertolcor (lcor) %s\n", lcor_version()) < 0;
    if (argc < 6 || argc > 7) {
        fputs(usage, stderr);
        return 1;
    }
    setvbuf(stderr, NULL, _IOLBF, BUFSIZ);
    handle_signals();
    if (argc == 7 && (in = open(argv[6], O_RDONLY | O_CLOEXEC)) < 0) {
        filter_say("ERROR", "%s: %s", argv[6], strerror(errno));
        return 1;
    }

    filter_job job;
    cups_option_t *options = NULL;
    const int count = cupsParseOptions(argv[5], 0, &options);
    ppd_file_t *ppd = getenv("PPD") ? ppdOpenFile(getenv("PPD")) : NULL;
    if (ppd) {
        ppdMarkDefaults(ppd);
        cupsMarkOptions(ppd, count, options);
    }
    setlocale(LC_ALL, "C"); /* libcups changes it; numbers in messages keep their point */
    bool good = job_open(&job, count, options, ppd);
    if (ppd)
        ppdClose(ppd);
    cupsFreeOptions(count, options);
    if (!good)
        return 1;
    job.say_pages = is_last();
    good = filter_run(&job, read_descriptor, &in, write_descriptor, &out);
    job_close(&job);
    return good ? 0 : 1;
}
