/* SPDX-License-Identifier: MIT */
/* Indirect irradiance as polynomials on a quadtree over each seen surface. */
#ifndef LCOR_VIEW_FIELD_H
#define LCOR_VIEW_FIELD_H

#include "base/array.h"

#include "view/cache.h"

#include <lcor/view.h>

enum { FIELD_NODES = 5, FIELD_CHANNELS_MAX = 3 };

/* A quadrilateral or triangular part of a surface as the image of the unit square. Parallelogram:
 * (u, v) = (s, t). Triangle with a corner at (u, v) = 0: (u, v) = t ((1 - s) b + s c). */
typedef struct field_part {
    double b[2], c[2];
    int triangle;
    size_t root; /* in cells */
} field_part;

/* A rectangle of the square with values at nodes x nodes equidistant places, edges included;
 * values of place (i, j) at first + (i nodes + j) channels, i along s. */
typedef struct field_cell {
    double low[2], size[2];
    size_t surface, part;
    size_t first;   /* in values */
    size_t child;   /* first of four: [s half][t half]; 0: none */
    unsigned nodes; /* a side; 0: nothing of it is seen, the parent serves */
    double pixels;  /* about how many show it */
    int torn;       /* its values are not those of a polynomial, but it is too small to split */
} field_cell;

typedef struct field_surface {
    size_t part, part_count; /* 0: not seen */
} field_surface;

struct lcor_field {
    lcor_allocator allocator;
    const lcor_solution *solution;
    const lcor_view *view;
    field_surface *surfaces;
    lcor_array parts;  /* field_part */
    lcor_array cells;  /* field_cell */
    lcor_array values; /* double */
    light_cache cache; /* instead of cells, where the solution's answers have noise */
    lcor_field_report report;
};

static inline field_part *field_part_at(const lcor_field *field, size_t i)
{
    return (field_part *)field->parts.items + i;
}

static inline field_cell *field_cell_at(const lcor_field *field, size_t i)
{
    return (field_cell *)field->cells.items + i;
}

void field_to_uv(const field_part *part, const double st[2], double uv[2]);
/* The inverse: the part of the surface in which uv lies, and the place in its square. */
const field_part *field_part_of(const lcor_field *field, size_t surface, const double uv[2],
                                double st[2]);
/* The cell's interpolant at a place of the square. */
void field_interpolate(const lcor_field *field, const field_cell *cell, const double st[2],
                       double *indirect);

/* field_build.c: fills a field whose first three members are set. */
lcor_status field_build(lcor_field *field, const lcor_field_options *options, lcor_error *err);

/* cache_build.c: the same for a field with a cache. */
lcor_status cache_build(lcor_field *field, const lcor_field_options *options, lcor_error *err);

#endif
