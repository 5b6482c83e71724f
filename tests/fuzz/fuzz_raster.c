/* SPDX-License-Identifier: MIT */
/* Any bytes as a raster through the whole filter: one byte of settings, then the stream. What comes
 * out of a page that was accepted must be a raster of the same size. */
#include "filter.h"
#include "raster.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

int LLVMFuzzerInitialize(int *argc, char ***argv);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* libcups allocates what a header asks for before anyone can judge the header, and never touches
 * it: no reason to stop. Nor are ERROR lines. */
int LLVMFuzzerInitialize(int *argc, char ***argv)
{
    static char limit[] = "-malloc_limit_mb=20000", quiet[] = "-close_fd_mask=2";
    char **more = malloc((size_t)(*argc + 3) * sizeof *more);
    if (!more)
        return 0;
    more[0] = (*argv)[0];
    more[1] = limit;
    more[2] = quiet;
    memcpy(more + 3, *argv + 1, (size_t)*argc * sizeof *more);
    *argc += 2;
    *argv = more;
    return 0;
}

typedef struct input {
    const uint8_t *data;
    size_t size, at;
} input;

static ssize_t read_input(void *context, unsigned char *buffer, size_t size)
{
    input *in = context;
    const size_t n = size < in->size - in->at ? size : in->size - in->at;
    memcpy(buffer, in->data + in->at, n);
    in->at += n;
    return (ssize_t)n;
}

static ssize_t write_nowhere(void *context, unsigned char *buffer, size_t size)
{
    size_t *written = context;
    unsigned char sum = 0;
    for (size_t i = 0; i < size; i++) /* every byte of it must be initialised memory */
        sum ^= buffer[i];
    *written += size + (sum & 0u);
    return (ssize_t)size;
}

/* Light that hardly changes, that changes fast, and that is no number. */
static illuminance_map open_map(void)
{
    static const float light[] = {0.5f, 0.501f, 0.503f, 0.504f, 2.0f, NAN};
    static const char header[] = "Pf\n2 3\n-1\n";
    char path[] = "/tmp/fuzz_rasterXXXXXX";
    illuminance_map map;
    const int fd = mkstemp(path);
    if (fd < 0 || write(fd, header, sizeof header - 1) < 0 || write(fd, light, sizeof light) < 0 ||
        !illuminance_open(&map, path))
        abort();
    close(fd);
    unlink(path);
    return map;
}

#ifdef LCOR_LIBFUZZER
size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t capacity);
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t capacity, unsigned seed);

/* A word of the page header, in the byte order of the stream. */
static void set_word(uint8_t *data, size_t member, uint32_t word)
{
    const bool big = data[1] == 'R'; /* RaS2, RaS3; 2SaR, 3SaR are little-endian */
    for (size_t i = 0; i < 4; i++)
        data[5 + member + i] = (uint8_t)(word >> 8 * (big ? 3 - i : i));
}

static uint32_t get_word(const uint8_t *data, size_t member)
{
    uint32_t word = 0;
    for (size_t i = 0; i < 4; i++)
        word = word << 8 | data[5 + member + (data[1] == 'R' ? i : 3 - i)];
    return word;
}

#define AT(member) offsetof(cups_page_header2_t, member)

/* Header words that agree with each other, or hardly any input would come to its pixels. */
static void make_honest(uint8_t *data, unsigned seed)
{
    static const uint32_t spaces[] = {CUPS_CSPACE_W,  CUPS_CSPACE_RGB,  CUPS_CSPACE_K,
                                      CUPS_CSPACE_SW, CUPS_CSPACE_SRGB, CUPS_CSPACE_ADOBERGB};
    const uint32_t space = spaces[seed % 6], bits = seed / 8 % 2 ? 8 : 16;
    const uint32_t colours = space == CUPS_CSPACE_RGB || space >= CUPS_CSPACE_SRGB ? 3 : 1;
    const uint32_t widest = seed / 16 % 1024 == 0 ? 262145 : seed / 16 % 16 == 0 ? 2000 : 70;
    const uint32_t width = get_word(data, AT(cupsWidth)) % widest;
    set_word(data, AT(cupsWidth), width);
    set_word(data, AT(cupsBitsPerColor), bits);
    set_word(data, AT(cupsBitsPerPixel), bits * colours);
    set_word(data, AT(cupsBytesPerLine), width * colours * bits / 8);
    set_word(data, AT(cupsColorOrder), seed / 16384 % 2);
    set_word(data, AT(cupsColorSpace), space);
    set_word(data, AT(cupsNumColors), colours);
}

/* Few bytes can say that a row comes millions of times. Most pages have some ten rows, a few enough
 * for several bands of the pipeline. */
static void limit_height(uint8_t *data, unsigned seed)
{
    const uint32_t width = get_word(data, AT(cupsWidth)), height = get_word(data, AT(cupsHeight));
    const uint32_t highest = seed % 256 == 0 && width < 4096 ? (1u << 18) / (width + 1) : 20;
    if (height > highest)
        set_word(data, AT(cupsHeight), height % (highest + 1));
}

/* libFuzzer's mutations; then three headers of four are made to agree with themselves. Lines above
 * 64 KiB are rare: libcups allocates them unseen, and a sanitizer needs a second to mark the
 * gigabytes that a random word asks for. */
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t capacity, unsigned seed)
{
    size = LLVMFuzzerMutate(data, size, capacity);
    if (size < 5 + sizeof(cups_page_header2_t))
        return size;
    if (seed % 4 != 0)
        make_honest(data, seed / 4);
    else if (get_word(data, AT(cupsBytesPerLine)) > 1u << 16 && seed / 4 % 1024)
        set_word(data, AT(cupsBytesPerLine), get_word(data, AT(cupsBytesPerLine)) % (1u << 16));
    limit_height(data, seed / 131072);
    return size;
}
#endif

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    if (size == 0)
        return 0;
    static illuminance_map map;
    if (map.width == 0)
        map = open_map();
    filter_job job = {.correct = (data[0] & 1) == 0,
                      .two_passes = (data[0] & 2) != 0,
                      .reading = data[0] & 4 ? LCOR_READING_TEXEL : LCOR_READING_PATCH,
                      .lightness = data[0] & 8 ? LCOR_LIGHTNESS_PAPER : LCOR_LIGHTNESS_CIE,
                      .contrast = 23.4,
                      .rho = 0.5,
                      .exponent = 1.0,
                      .r_mean = 1.0,
                      .map.fd = -1};
    if (data[0] & 16)
        job.map = map;
    input in = {data + 1, size - 1, 0};
    size_t written = 0;
    const bool good = filter_run(&job, read_input, &in, write_nowhere, &written);
    if (good && written < sizeof(cups_page_header2_t) + 4)
        abort();
    return 0;
}
