/* SPDX-License-Identifier: MIT */
/* What of a convex polygon an eye sees past convex obstacles, exactly, as convex pieces. */
#ifndef LCOR_GEOMETRY_VISIBLE_H
#define LCOR_GEOMETRY_VISIBLE_H

#include <stddef.h>

enum { VISIBLE_CORNERS = 32, VISIBLE_PIECES = 48, VISIBLE_POINTS = 96, VISIBLE_EDGES = 24 };

typedef struct visible_piece {
    int n;
    int sign; /* -1: what it covers is to be taken away from the others */
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

/* An eye looking at a plane through `target`, `normal` on the eye's side. Parts of obstacles within
 * `touch` of that plane, behind it or beyond the eye hide nothing. */
typedef struct visible_view {
    visible_eye eye;
    double target[3], normal[3], touch;
} visible_view;

/* A cone with its tip in the eye: the planes through the eye and an obstacle's outline. */
typedef struct visible_cone {
    int n;
    double point[VISIBLE_EDGES][3], inward[VISIBLE_EDGES][3]; /* of any length */
} visible_cone;

/* Appends the part of a polygon of n corners (at most 40) that lies between plane and eye to the
 * `count` points of out[VISIBLE_POINTS]; returns the new count, or -1 if they are too many. */
int visible_between(const visible_view *view, size_t n, const double *corners, int count,
                    double (*out)[3]);

/* The cone over a convex polygon, or with `hull` over the convex hull of points, of which
 * visible_between gave n. 0: nothing is hidden, -1: too many edges. */
int visible_cone_over(visible_cone *cone, const visible_view *view, int n, double (*points)[3],
                      int hull);

/* Adds to a cone, its n first set to 0, the plane through the eye and an edge p-q of an outline,
 * and keeps the side on which `inside` lies. Returns as visible_cone_over, 1 with an edge too short
 * or seen end-on. */
int visible_cone_add(visible_cone *cone, const visible_view *view, const double p[3],
                     const double q[3], const double inside[3]);

/* Whether the piece is the polygon of these n corners, uncut. */
int visible_is(const visible_piece *piece, int n, const double *corners);

/* Twice the area of a piece. */
double visible_area(const visible_piece *piece);

/* Starts with the whole polygon of n corners. Returns 0 if they are too many. */
int visible_start(visible_set *set, size_t n, const double *corners);

/* Keeps what lies in the half-space (p - x) . normal >= 0. */
void visible_clip(visible_set *set, const double x[3], const double normal[3]);

/* Whether a plane of the cone has the whole piece on its outer side. */
int visible_apart(const visible_piece *piece, const visible_cone *cone);

/* The part of a piece, which is not apart, inside the cone: 0 if it is empty, else 1; -1 without
 * room for it. */
int visible_inside(const visible_piece *piece, const visible_cone *cone, visible_piece *inside);

/* Takes away what lies inside the cone. Returns 0 if there is no room for the pieces. */
int visible_subtract(visible_set *set, const visible_cone *cone);

#endif
