/* SPDX-License-Identifier: MIT */
/* One guided measurement: an open instrument, the person before it, the readings so far. */
#ifndef LCCAL_SESSION_H
#define LCCAL_SESSION_H

#include "instrument/instrument.h"
#include "lccal.h"

/* A patch to be measured. */
typedef struct patch {
    char   name[24];
    double level; /* 0 black .. 255 white */
    size_t first; /* its readings in the profile: first .. first + count - 1 */
    size_t count;
} patch;

typedef struct session {
    const lccal_measure_options *options;
    instrument                   in;
    lcor_profile                *profile; /* every reading, rejected ones marked */
    double                       step;    /* coarsest resolution seen */
    reading_kind                 kind;    /* of the first reading */
} session;

/* Exit code for a failed call below this floor, after telling the user. */
int session_fail(const cal_error *err);

/* Open options->port with its instrument, announce it. */
int session_open(session *s, const lccal_measure_options *options);

/* Measure one patch until it has options->readings good readings; appends them to the profile. */
int session_patch(session *s, patch *p);

/* The reading's density; for displays -log10(Y/100), so that only differences mean something. */
double session_density(const lcor_profile_reading *r);

#endif
