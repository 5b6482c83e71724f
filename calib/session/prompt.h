/* SPDX-License-Identifier: MIT */
/* Asking the person in front of the instrument. */
#ifndef LCCAL_PROMPT_H
#define LCCAL_PROMPT_H

#include <stddef.h>

typedef enum answer {
    ANSWER_GO,    /* Enter */
    ANSWER_REDO,  /* r: the patch before again */
    ANSWER_QUIT,  /* q */
    ANSWER_CLOSED /* nobody is there: end of input */
} answer;

/* Show `question` on stderr (as an event too) and wait for a line from stdin, or for SIGINT. */
answer prompt_wait(const char *patch, const char *question);

/* The same, and the line that was typed (as much of it as fits): GO, QUIT after SIGINT or CLOSED.
 */
answer prompt_line(const char *patch, const char *question, char *line, size_t capacity);

#endif
