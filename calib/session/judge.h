/* SPDX-License-Identifier: MIT */
/* Are the readings of a patch, and of two patches, what they claim to be? Pure arithmetic on
 * densities; displays are judged by -log10(Y/100). */
#ifndef LCCAL_JUDGE_H
#define LCCAL_JUDGE_H

#include <stdbool.h>
#include <stddef.h>

typedef enum verdict {
    VERDICT_GOOD,
    VERDICT_TOO_FEW,  /* fewer than half may be left after rejection */
    VERDICT_MIXED,    /* readings of different patches */
    VERDICT_DRIFTING, /* each farther from the first than the one before */
    VERDICT_EQUAL     /* two patches that are one */
} verdict;

/* Densities an instrument can mean; beyond lies damage on the wire or a wrong decimal point. */
bool judge_plausible(double density);

double judge_median(const double *values, size_t n); /* n <= JUDGE_MAX */

/* Mark the readings that agree with the median; judge what they say together. */
verdict judge_patch(const double *values, size_t n, bool *accepted);
/* The medians of two patches. */
verdict judge_pair(double first, double second);

enum { JUDGE_MAX = 1000 };

#endif
