/* SPDX-License-Identifier: MIT */
#include "illuminance.h"

#include "filter.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define HEADER_MAX      256   /* bytes of header looked at */
#define SIDE_MAX        65536 /* columns and rows of a map */
#define MAP_PIXEL_WORTH 8     /* page pixels across a map pixel at which it is worth making steps */

/* The next word of a PNM header; '#' starts a comment. Returns its length, 0 at the end. */
static size_t next_word(const char *text, size_t size, size_t *at, char *word, size_t capacity)
{
    size_t i = *at, n = 0;
    while (i < size && (strchr(" \t\r\n", text[i]) || text[i] == '#')) {
        if (text[i] == '#')
            while (i < size && text[i] != '\n')
                i++;
        else
            i++;
    }
    while (i < size && !strchr(" \t\r\n", text[i]) && n + 1 < capacity)
        word[n++] = text[i++];
    word[n] = '\0';
    *at = i;
    return n;
}

/* A whole number of the header, 1..limit; 0 otherwise. */
static size_t whole(const char *word, double limit)
{
    double x;
    return filter_number(word, &x) && x >= 1.0 && x <= limit && x == (double)(size_t)x ? (size_t)x
                                                                                       : 0;
}

static const char *parse_header(illuminance_map *map, const char *text, size_t size)
{
    char word[4][32];
    size_t at = 0;
    for (int i = 0; i < 4; i++)
        if (next_word(text, size, &at, word[i], sizeof word[i]) == 0)
            return "is no PFM or PGM picture: its header is incomplete";
    const bool pfm = strcmp(word[0], "Pf") == 0;
    if (!pfm && strcmp(word[0], "P5") != 0)
        return "is neither a grey PFM (Pf) nor a binary PGM (P5): convert it, for example with "
               "oiiotool --ch R -o map.pfm";
    map->width = whole(word[1], SIDE_MAX);
    map->height = whole(word[2], SIDE_MAX);
    if (map->width == 0 || map->height == 0)
        return "has a size outside 1..65536";
    map->bottom_up = pfm;
    map->data = (off_t)(at + 1); /* exactly one white space ends the header */
    if (pfm) {
        double order;
        if (!filter_number(word[3], &order) || order == 0.0)
            return "has no byte order: the fourth word of a PFM is -1 or 1";
        map->little_endian = order < 0.0;
        map->sample_bytes = 4;
        map->scale = 1.0f;
    } else {
        const size_t top = whole(word[3], 65535);
        if (top == 0)
            return "has a largest value outside 1..65535";
        map->little_endian = false;
        map->sample_bytes = top > 255 ? 2 : 1;
        map->scale = 1.0f / (float)top;
    }
    return NULL;
}

bool illuminance_open(illuminance_map *map, const char *path)
{
    char header[HEADER_MAX];
    struct stat info;
    /* O_NONBLOCK: a pipe or device under that name must not hold the job up. */
    map->fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (map->fd < 0 || fstat(map->fd, &info) != 0) {
        filter_say("ERROR", "illuminance map %s: %s", path, strerror(errno));
        illuminance_close(map);
        return false;
    }
    const ssize_t got = S_ISREG(info.st_mode) ? pread(map->fd, header, sizeof header, 0) : -1;
    const char *why = got < 0 ? "is not a regular file" : parse_header(map, header, (size_t)got);
    if (!why && (uint64_t)(info.st_size - map->data) !=
                    (uint64_t)map->width * map->height * map->sample_bytes)
        why = "is cut short or longer than its header says";
    if (why) {
        filter_say("ERROR", "illuminance map %s %s", path, why);
        illuminance_close(map);
        return false;
    }
    return true;
}

void illuminance_close(illuminance_map *map)
{
    if (map->fd >= 0)
        close(map->fd);
    memset(map, 0, sizeof *map);
    map->fd = -1;
}

bool illuminance_rows_open(illuminance_rows *rows, const illuminance_map *map, size_t width,
                           size_t height, bool in_steps)
{
    memset(rows, 0, sizeof *rows);
    rows->map = map;
    rows->width = width;
    rows->height = height;
    rows->in_steps = in_steps && width / MAP_PIXEL_WORTH >= map->width &&
                     height / MAP_PIXEL_WORTH >= map->height;
    rows->loaded[0] = rows->loaded[1] = rows->upper = SIZE_MAX;
    rows->light = malloc(width * sizeof *rows->light);
    if (map->width == 0) {
        for (size_t x = 0; rows->light && x < width; x++)
            rows->light[x] = 1.0f;
        return rows->light != NULL;
    }
    const size_t w = map->width + 1; /* one more: the last column's right neighbour is itself */
    rows->left = calloc(width, sizeof *rows->left);
    rows->place = calloc(width, sizeof *rows->place);
    rows->share = calloc(width, sizeof *rows->share);
    rows->end = calloc(w, sizeof *rows->end);
    rows->rows[0] = calloc(w, sizeof(float));
    rows->rows[1] = calloc(w, sizeof(float));
    rows->mixed = calloc(w, sizeof(float));
    rows->raw = malloc(w * map->sample_bytes);
    if (!rows->light || !rows->left || !rows->place || !rows->share || !rows->end ||
        !rows->rows[0] || !rows->rows[1] || !rows->mixed || !rows->raw) {
        illuminance_rows_close(rows);
        return false;
    }
    for (size_t x = 0; x < width; x++) {
        const double u = ((double)x + 0.5) * (double)map->width / (double)width - 0.5;
        const double inside = u < 0.0 ? 0.0 : u;
        rows->left[x] = (size_t)inside < map->width ? (size_t)inside : map->width - 1;
        rows->place[x] = rows->share[x] = (float)(inside - (double)rows->left[x]);
        rows->end[rows->left[x]] = x + 1;
    }
    return true;
}

void illuminance_rows_close(illuminance_rows *rows)
{
    free(rows->light);
    free(rows->left);
    free(rows->place);
    free(rows->share);
    free(rows->end);
    free(rows->rows[0]);
    free(rows->rows[1]);
    free(rows->mixed);
    free(rows->raw);
    memset(rows, 0, sizeof *rows);
}

static float sample(const illuminance_map *map, const unsigned char *p)
{
    uint32_t bits = 0;
    for (size_t i = 0; i < map->sample_bytes; i++)
        bits = bits << 8 | p[map->little_endian ? map->sample_bytes - 1 - i : i];
    if (map->sample_bytes < 4)
        return map->scale * (float)bits;
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

/* Map row `y` into slot 0 or 1. */
static bool load(illuminance_rows *rows, int slot, size_t y)
{
    const illuminance_map *map = rows->map;
    const size_t bytes = map->width * map->sample_bytes;
    const size_t stored = map->bottom_up ? map->height - 1 - y : y;
    if (rows->loaded[slot] == y)
        return true;
    if (pread(map->fd, rows->raw, bytes, map->data + (off_t)(stored * bytes)) != (ssize_t)bytes)
        return false;
    for (size_t x = 0; x < map->width; x++)
        rows->rows[slot][x] = sample(map, rows->raw + x * map->sample_bytes);
    rows->rows[slot][map->width] = rows->rows[slot][map->width - 1];
    rows->loaded[slot] = y;
    return true;
}

/* The difference of two values of the map in steps, if it can be made in equal steps longer than a
 * pixel; else 0. */
static size_t steps_between(float a, float b, size_t pixels, size_t map_pixels)
{
    if (a == b)
        return 1;
    if (!(a > 0.0f && b > 0.0f))
        return 0;
    const float steps = ceilf(fabsf(a - b) / fminf(a, b) / ILLUMINANCE_STEP);
    return steps < (float)pixels / (float)map_pixels ? (size_t)steps : 0;
}

/* The middle of the step that holds this share of the way, 0..1. */
static float in_steps(float share, size_t steps)
{
    const size_t step = (size_t)(share * (float)steps);
    if (steps == 0)
        return share;
    return ((float)(step < steps ? step : steps - 1) + 0.5f) / (float)steps;
}

/* More steps; 0 is the most. */
static size_t more(size_t a, size_t b) { return a == 0 || b == 0 ? 0 : a > b ? a : b; }

/* The steps between the map rows a and b. */
static void find_steps(illuminance_rows *rows, const float *a, const float *b)
{
    const illuminance_map *map = rows->map;
    rows->steps_down = 1;
    for (size_t i = 0; i <= map->width; i++)
        rows->steps_down =
            more(rows->steps_down, steps_between(a[i], b[i], rows->height, map->height));
    for (size_t x = 0; x < rows->width;) {
        const size_t i = rows->left[x], end = rows->end[i];
        const size_t steps = more(steps_between(a[i], a[i + 1], rows->width, map->width),
                                  steps_between(b[i], b[i + 1], rows->width, map->width));
        for (; x < end; x++)
            rows->share[x] = in_steps(rows->place[x], steps);
    }
}

/* The two map rows about row y of the page, in a and b; the share of b; the steps between them. */
static bool load_two(illuminance_rows *rows, size_t y, const float **a, const float **b,
                     float *share)
{
    const illuminance_map *map = rows->map;
    const double v = ((double)y + 0.5) * (double)map->height / (double)rows->height - 0.5;
    const double inside = v < 0.0 ? 0.0 : v;
    const size_t upper = (size_t)inside < map->height ? (size_t)inside : map->height - 1;
    const size_t lower = upper + 1 < map->height ? upper + 1 : upper;
    /* Even rows live in slot 0 and odd ones in slot 1, so going down a page reads each row once. */
    *a = rows->rows[upper % 2];
    *b = rows->rows[lower % 2];
    if (!load(rows, (int)(upper % 2), upper) || !load(rows, (int)(lower % 2), lower))
        return false;
    if (rows->upper != upper) {
        rows->upper = upper;
        rows->down = -1.0f; /* the row drawn last lies between others */
        if (rows->in_steps)
            find_steps(rows, *a, *b);
    }
    *share = in_steps((float)(inside - (double)upper), rows->steps_down);
    return true;
}

static float mix(float a, float b, float share) { return a + share * (b - a); }

const float *illuminance_row(illuminance_rows *rows, size_t y)
{
    const float *a, *b;
    float down;
    if (rows->map->width == 0)
        return rows->light;
    if (!load_two(rows, y, &a, &b, &down))
        return NULL;
    if (down == rows->down)
        return rows->light;
    for (size_t x = 0; x <= rows->map->width; x++)
        rows->mixed[x] = mix(a[x], b[x], down);
    /* Between two columns of the map there is no looking up. */
    for (size_t x = 0; x < rows->width;) {
        const size_t left = rows->left[x], end = rows->end[left];
        const float l = rows->mixed[left], r = rows->mixed[left + 1];
        for (; x < end; x++)
            rows->light[x] = mix(l, r, rows->share[x]);
    }
    rows->down = down;
    rows->drawn++;
    return rows->light;
}

bool illuminance_at(illuminance_rows *rows, size_t y, size_t n, const size_t *x, float *out)
{
    const float *a, *b;
    float down;
    if (rows->map->width > 0 && !load_two(rows, y, &a, &b, &down))
        return false;
    for (size_t i = 0; i < n; i++) {
        if (rows->map->width == 0) {
            out[i] = 1.0f;
            continue;
        }
        const size_t left = rows->left[x[i]];
        out[i] = mix(mix(a[left], b[left], down), mix(a[left + 1], b[left + 1], down),
                     rows->share[x[i]]);
    }
    return true;
}
