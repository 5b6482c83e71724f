/* SPDX-License-Identifier: MIT */
/* One guided measurement: an open instrument, the person before it, the readings so far. */
#ifndef LCCAL_SESSION_H
#define LCCAL_SESSION_H

#include "instrument/instrument.h"
#include "lccal.h"
#include "session/journal.h"

enum { PATCHES_MAX = 66, POSITIONS_MAX = 9, WHITE = 0, BLACK = 1, FIRST_STEP = 2 };

/* A patch to be measured. */
typedef struct patch {
    char name[24];
    double level; /* 0 black .. 255 white */
    size_t first; /* the last attempt's readings are first .. first + count - 1 of the profile, */
    size_t count; /* with the rejected ones among them */
} patch;

typedef struct session {
    const lccal_measure_options *options;
    instrument in;
    lcor_profile *profile; /* every reading, rejected ones marked */
    journal log;
    double step;                /* coarsest resolution seen */
    reading_kind kind;          /* of the first reading */
    unsigned has;               /* what the first reading held; all must hold the same */
    patch patches[PATCHES_MAX]; /* WHITE, BLACK, then the grey steps */
    size_t patch_count;
    size_t at;        /* how many patches are done */
    bool black_first; /* the first two are measured in this order */
} session;

/* Exit code for a failed call below this floor, after telling the user. */
int session_fail(const cal_error *err);
/* A reading or a patch is no good: with --yes that ends the session, otherwise the person at the
 * instrument is told and tries again. Returns LCCAL_REJECTED. */
int session_reject(const session *s, const char *format, ...) LCCAL_PRINTF(2, 3);

/* "Dektronics Printalyzer Densitometer, serial 0123, firmware v1.1.0" */
void session_describe(const instrument *in, char *text, size_t capacity);

/* Open options->port with its instrument and announce it. */
int session_open(session *s, const lccal_measure_options *options);

/* Ask for patch p. LCCAL_OK: go; -1: the patch before again; else an exit code. */
int session_ask(session *s, const patch *p);
/* Measure patch p and judge it. LCCAL_REJECTED without --yes: ask for it again. If it is the first
 * one and surely black, white and black change places. */
int session_patch(session *s, patch *p);
/* Exchange white and black among the readings taken so far, and in the order of patches. */
int session_exchange(session *s);
/* Strike out the last attempt at p. */
void session_strike(session *s, const patch *p);

/* Median density of the readings of p that count. */
double session_patch_density(const session *s, const patch *p);

/* What the first two patches are to each other: names them by what they show, refuses two that are
 * the same. */
int session_sort(session *s);
/* Grey step i lies between its lighter neighbour and black. */
int session_check_step(session *s, size_t i);
/* Go back to white and black until c is known to options->precision percent. */
int session_refine(session *s);

#endif
