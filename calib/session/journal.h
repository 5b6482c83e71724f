/* SPDX-License-Identifier: MIT */
/* Every reading is on disk before the next one is taken, so that an interrupted session can go on
 * where it stopped. A journal is played back through the same judgements that saw it live, and so
 * ends in the same state.
 *
 *     lccal journal 1 printalyzer 0123ABCD readings=5 positions=1 ramp=0
 *     R 0 0.070000001 0.000000000 0 0 0 0 0 0 0       a reading
 *     U                                               the patch before was asked for again */
#ifndef LCCAL_JOURNAL_H
#define LCCAL_JOURNAL_H

#include "instrument/instrument.h"

#include <stdio.h>

typedef struct journal {
    char *path; /* NULL: none is kept */
    FILE *file;
    char *text; /* what is played back, or NULL */
    size_t at, size;
    size_t entries;
    bool failed; /* a write failed and the user was told */
} journal;

/* Start or, with resume, take up the journal at path (NULL: none). Failure is told to the user. */
int journal_open(journal *j, const char *path, const char *header, bool resume);
/* The next entry to play back: 'R' with *out filled, 'U', or 0 when all was played. */
char journal_next(journal *j, reading *out);
/* Is there an entry to play back, and is it this one? */
bool journal_peek(const journal *j, char entry);
void journal_reading(journal *j, const reading *r);
void journal_undo(journal *j);
/* Close it; remove the file unless keep. */
void journal_close(journal *j, bool keep);

#endif
