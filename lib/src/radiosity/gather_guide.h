/* SPDX-License-Identifier: MIT */
/* Small bright places, emitting or brightly lit, towards which rays are guided. */
#ifndef LCOR_RADIOSITY_GATHER_GUIDE_H
#define LCOR_RADIOSITY_GATHER_GUIDE_H

#include "base/array.h"

#include <stdint.h>

/* Targets are looked at in rows, and chosen by lane first. */
enum { GUIDE_LANES = 16, GUIDE_ROWS = 64, GUIDE_TARGETS = GUIDE_LANES * GUIDE_ROWS };

/* The same light in few large targets or in many small ones: for one ray and for hundreds. */
typedef enum guide_detail { GUIDE_COARSE, GUIDE_FINE, GUIDE_DETAILS } guide_detail;

struct gather;
struct gather_stand;

/* A part of a primitive's unit square, whose map to the primitive keeps ratios of areas. */
typedef struct guide_cell {
    uint32_t root; /* in guide.roots */
    double low[2], size;
    int32_t child;                 /* the first of four, or -1 */
    int32_t target[GUIDE_DETAILS]; /* or -1 */
    double brightness;
} guide_cell;

/* A side of a primitive with targets. */
typedef struct guide_root {
    double origin[3], edge_u[3], edge_v[3];
    uint32_t surface;
    int back, triangle;
    int32_t cell;
    double area;
} guide_root;

typedef struct guide_target {
    double area;
    int32_t cell;
} guide_target;

/* What a look needs of a row of targets: lengths in diameters of the scene, brightness over the
 * mean. Single precision will do for a probability. */
typedef struct guide_row {
    float centre[3][GUIDE_LANES], normal[3][GUIDE_LANES], area[GUIDE_LANES],
        brightness[GUIDE_LANES];
} guide_row;

typedef struct guide_targets {
    guide_target items[GUIDE_TARGETS]; /* number lane + GUIDE_LANES * row */
    guide_row rows[GUIDE_ROWS];
    int count, row_count;
} guide_targets;

typedef struct guide {
    lcor_array roots, cells;
    int32_t *root_of;   /* per primitive and side, or -1 */
    unsigned char *lit; /* per primitive: its front gets or sends light directly */
    guide_targets targets[GUIDE_DETAILS];
    double origin[3]; /* of the rows' lengths */
    double mean;      /* brightness of what is seen on average */
} guide;

/* Finds what is bright. Returns 0 without memory. */
int guide_build(struct gather *g);
void guide_clear(struct gather *g);

/* Shares of the targets as seen from one place. */
typedef struct guide_view {
    guide_detail detail;
    float upto[GUIDE_ROWS][GUIDE_LANES]; /* sums over a lane's rows up to each */
    double below[GUIDE_LANES + 1];       /* sums over all lanes before each */
    double all;
} guide_view;

/* Returns 0 if guiding does not pay where the irradiance is about `expected`. */
int guide_look(const struct gather *g, const double x[3], const double normal[3], double expected,
               guide_detail detail, guide_view *view);

typedef struct guide_place {
    double x[3], normal[3];
    double density; /* per area */
    uint32_t surface;
    int back, target;
} guide_place;

void guide_choose(const struct gather *g, const guide_view *view, double a, double b,
                  guide_place *out);

/* Makes targets less likely that `seen` of `tries` found hidden. */
void guide_learn(const struct gather *g, guide_view *view, const int tries[GUIDE_TARGETS],
                 const int seen[GUIDE_TARGETS]);

/* Density per area with which guide_choose comes upon a place of a primitive. */
double guide_density(const struct gather *g, const guide_view *view, uint32_t prim, int back,
                     const double st[2]);

#endif
