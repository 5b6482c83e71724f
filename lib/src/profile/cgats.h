/* SPDX-License-Identifier: MIT */
/* CGATS.17 text as a stream of words that know their line. */
#ifndef LCOR_PROFILE_CGATS_H
#define LCOR_PROFILE_CGATS_H

#include <stddef.h>

typedef struct cgats_text {
    const char *at, *end;
    long line; /* of `at`, from 1 */
} cgats_text;

typedef struct cgats_word {
    const char *text; /* without the quotes */
    size_t n;
    int quoted;
} cgats_word;

typedef enum cgats_next { CGATS_WORD, CGATS_LINE_END, CGATS_END, CGATS_BAD } cgats_next;

/* Start behind a byte order mark, if there is one. */
cgats_text lcor_internal_cgats_open(const char *text, size_t size);

/* Next word of the line; a comment counts as the line's end. CGATS_LINE_END steps to the next line.
 * CGATS_BAD: a quote without its end on this line, or a NUL. */
cgats_next lcor_internal_cgats_next(cgats_text *text, cgats_word *word);

/* The rest of the line up to a comment, without the blanks around it. */
cgats_word lcor_internal_cgats_rest(cgats_text *text);

/* Is the word, not quoted, `name` (capitals), whatever its own capitals? */
int lcor_internal_cgats_is(cgats_word word, const char *name);

#endif
