/* SPDX-License-Identifier: MIT */
/* CGATS.17 text -> profile: what header.c and parse.c share. */
#ifndef LCOR_PROFILE_READER_H
#define LCOR_PROFILE_READER_H

#include "profile/cgats.h"
#include "profile/internal.h"

enum {
    RGB_R,
    RGB_G,
    RGB_B,
    CMYK_C,
    CMYK_M,
    CMYK_Y,
    CMYK_K,
    XYZ_X,
    XYZ_Y,
    XYZ_Z,
    D_RED,
    D_GREEN,
    D_BLUE,
    D_VIS,
    LAB_L,
    LAB_A,
    LAB_B,
    REJECTED,
    NUMBERS, /* columns of numbers end here */
    ID = NUMBERS,
    NAME,
    COLUMNS
};

extern const char *const lcor_internal_columns[COLUMNS];

typedef struct data_row {
    double value[NUMBERS];
    cgats_word id, name;
    long line;
} data_row;

typedef struct reader {
    cgats_text text;
    lcor_profile *profile;
    lcor_error *err;
    size_t field[COLUMNS]; /* 1 + place of the column in a row; 0: not there */
    size_t fields;
    unsigned has;
    int from_lab;         /* XYZ are computed from L*a*b* */
    double declared_sets; /* -1: not said */
    size_t sets;
    double largest[NUMBERS];
    int decimals[NUMBERS]; /* most digits after the point */
    double scale[NUMBERS];
    int own;                                   /* written by this library */
    double contrast, contrast_u95, resolution; /* as the text says; -1: it does not */
} reader;

/* LCOR_ERR_FORMAT with the line the reader has come to. */
lcor_status lcor_internal_bad(const reader *r, const char *what);
lcor_status lcor_internal_bad_word(const reader *r, cgats_word word, const char *what);
lcor_status lcor_internal_bad_bytes(const reader *r);

/* All up to BEGIN_DATA: keywords into the profile, columns into the reader. */
lcor_status lcor_internal_read_header(reader *r);

/* Do the readings of another program's text make sense, or have columns the wrong label? */
lcor_status lcor_internal_check_plausible(const reader *r);
/* Do the readings give what the text says they do? */
lcor_status lcor_internal_check_contrast(const reader *r);

#endif
