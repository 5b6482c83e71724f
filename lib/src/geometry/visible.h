/* SPDX-License-Identifier: MIT */
/* What of a convex polygon an eye sees past other convex polygons, exactly, as convex pieces. */
#ifndef LCOR_GEOMETRY_VISIBLE_H
#define LCOR_GEOMETRY_VISIBLE_H

#include <stddef.h>

enum { VISIBLE_CORNERS = 16, VISIBLE_PIECES = 48 };

typedef struct visible_piece {
    int n;
    double p[VISIBLE_CORNERS][3];
} visible_piece;

typedef struct visible_set {
    int count;
    visible_piece pieces[VISIBLE_PIECES];
} visible_set;

/* The eye is the point `at`, or with `parallel` infinitely far away in direction `at`. */
typedef struct visible_eye {
    double at[3];
    int parallel;
} visible_eye;

/* Starts with the whole polygon of n corners, whose plane has `normal` on the eye's side. */
int visible_start(visible_set *set, size_t n, const double *corners);

/* Keeps what lies in the half-space (p - x) . normal >= 0. */
void visible_clip(visible_set *set, const double x[3], const double normal[3]);

/* Takes away what the polygon of n corners (at most 40) hides. Parts of it within `touch` of the
 * target's plane, behind it or beyond the eye hide nothing. Returns 0, leaving the set as it was,
 * if there is no room for the pieces. */
int visible_subtract(visible_set *set, const visible_eye *eye, const double target_normal[3],
                     size_t n, const double *occluder, double touch);

#endif
