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

/* Bilinear resampling to `width` columns, pixel centres aligned. One per thread. */
typedef struct illuminance_rows {
    const illuminance_map *map;
    size_t width, height; /* of the page */
    size_t *left;         /* for each column: map column on the left ... */
    float *share;         /* ... and the share of the one on its right */
    size_t *end;          /* for each map column: page column where the next one is on the left */
    float *rows[2];       /* two neighbouring map rows */
    float *mixed;         /* their mixture */
    size_t loaded[2];     /* which rows they are */
    unsigned char *raw;   /* one stored row */
} illuminance_rows;

bool illuminance_rows_open(illuminance_rows *rows, const illuminance_map *map, size_t width,
                           size_t height);
void illuminance_rows_close(illuminance_rows *rows);
/* All of row y of the page; false if the file could not be read. */
bool illuminance_row(illuminance_rows *rows, size_t y, float *out);
/* Its columns x[0..n-1] alone, the same values. */
bool illuminance_at(illuminance_rows *rows, size_t y, size_t n, const size_t *x, float *out);

#endif
