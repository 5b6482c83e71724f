/* SPDX-License-Identifier: MIT */
/* Illuminance of a page from a picture file: PFM (Pf) or PGM (P5, 8 or 16 bit), both linear. Rows
 * are read from the file as they are wanted, so that memory does not depend on the map's height. */
#ifndef RASTERTOLCOR_ILLUMINANCE_H
#define RASTERTOLCOR_ILLUMINANCE_H

#include <stdbool.h>
#include <stddef.h>
#include <sys/types.h>

typedef struct illuminance_map {
    int fd;
    size_t width, height; /* 0: no map, the same light everywhere */
    size_t sample_bytes;  /* 1, 2 or 4 (float) */
    bool little_endian, bottom_up;
    float scale; /* stored value -> illuminance */
    off_t data;  /* where the first stored row begins */
} illuminance_map;

/* `path` is named in the ERROR line said on false. */
bool illuminance_open(illuminance_map *map, const char *path);
void illuminance_close(illuminance_map *map);

/* The largest step of light along a row or down a column, relative: no eye sees it. The light of a
 * step is that of its middle, so it is within this of the interpolated one. */
#define ILLUMINANCE_STEP 0.002f

/* Bilinear resampling to `width` columns, pixel centres aligned. One per thread. */
typedef struct illuminance_rows {
    const illuminance_map *map;
    size_t width, height; /* of the page */
    bool in_steps;      /* as long as the step between them allows; else every pixel has its own */
    size_t *left;       /* for each column: map column on the left, ... */
    float *place;       /* ... how far it is on the way to the next one, 0..1 ... */
    float *share;       /* ... and where the middle of its step is */
    size_t *end;        /* for each map column: page column where the next one is on the left */
    float *rows[2];     /* two neighbouring map rows */
    float *mixed;       /* their mixture */
    size_t loaded[2];   /* which rows they are */
    unsigned char *raw; /* one stored row */
    size_t upper;       /* the map row above the page row asked for last */
    size_t steps_down;  /* from there to the next one; 0: every row has its own light */
    float *light;       /* the row of the page made last */
    float down;         /* how far it is on that way */
    size_t drawn;       /* how many have been made */
} illuminance_rows;

bool illuminance_rows_open(illuminance_rows *rows, const illuminance_map *map, size_t width,
                           size_t height, bool in_steps);
void illuminance_rows_close(illuminance_rows *rows);
/* All of row y of the page, valid until the next one is asked for: the same as before unless
 * rows->drawn has changed. NULL if the file could not be read. */
const float *illuminance_row(illuminance_rows *rows, size_t y);
/* Its columns x[0..n-1] alone, the same values. */
bool illuminance_at(illuminance_rows *rows, size_t y, size_t n, const size_t *x, float *out);

#endif
