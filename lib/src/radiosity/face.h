/* SPDX-License-Identifier: MIT */
/* Faces: one side of a piece of a surface, the roots of the element trees. */
#ifndef LCOR_RADIOSITY_FACE_H
#define LCOR_RADIOSITY_FACE_H

#include "scene/scene_internal.h"

/* A parallelogram X(s, t) = origin + s u + t v, or a triangle in collapsed coordinates
 * X(s, t) = origin + s u + s t (v - u), both over the unit square: splitting the square splits
 * either, and polynomials in (s, t) nest. */
typedef struct face {
    double origin[3], u[3], v[3], normal[3];
    double dual_u[3], dual_v[3]; /* affine coordinates of x: (x - origin) . dual */
    double jacobian;             /* |u x v| */
    /* Lines of constant s are parallel: their direction, the one across them in the plane, u in
     * these two, and the length of the line at s = 1. */
    double along[3], across[3], u_along, u_across, line;
    int triangle;
    uint32_t surface; /* of a sheet: the first one */
    int back;         /* 1: the side away from the surface's normal */
    int covered;      /* 1: another one that faces the same way lies on it */
    double patch;     /* shorter edge of the surface's patches */
    double finest;    /* elements are not split below this edge length */
    int32_t root;     /* element */
} face;

typedef struct cell { /* a rectangle of a face's square */
    double s0, t0, hs, ht;
} cell;

/* The faces of a surface's side. The surfaces of a sheet have them in common. */
typedef struct face_range {
    size_t begin, end;
} face_range;

/* Appends the faces of every sheet whose surfaces still look alike and of every other surface: cut
 * along lines where other shapes touch or cross it, or end nearer above it than the least element
 * is long, since irradiance jumps there. Returns 0 if there is no memory. `sides` gets those of
 * surface i, side b, at 2 i + b. */
int face_build(const lcor_scene *scene, const lcor_allocator *allocator, lcor_array *faces,
               face_range *sides);

/* How it meets light: black and dark where it is covered, so that no place sends twice. */
const lcor_surface *face_look(const lcor_scene *scene, const face *f);

/* Whether they would be the same after looks have changed. */
int face_still_holds(const lcor_scene *scene, const face_range *sides);

/* How many surfaces have the faces of sheets, and how many sheets these are. */
void face_count_merged(const lcor_scene *scene, const face_range *sides, uint64_t *surfaces,
                       uint64_t *into);

/* The rectangle of a quad's (s, t) that the face is; 0 if it is none in the same directions. */
int face_in_quad(const face *f, const scene_surface *quad, cell *out);

void face_point(const face *f, double s, double t, double out[3]);
void face_coordinates(const face *f, const double x[3], double *s, double *t);
double face_cell_area(const face *f, const cell *c);
/* Fills origin, u, v and what follows from them; the normal is the caller's. Returns 0 if it has
 * no area. */
int face_set(face *f, const double origin[3], const double u[3], const double v[3], int triangle);
/* Appends the face with corner a and edges to b and c: a triangle, or the parallelogram; nothing if
 * it has no area. `normal` is the surface's. Returns 0 without memory. */
int face_append(const lcor_allocator *allocator, lcor_array *faces, const double normal[3],
                uint32_t surface, int back, const double a[3], const double b[3], const double c[3],
                int triangle);
/* Four corners in order around the cell; at a triangle's tip two are equal. */
void face_cell_corners(const face *f, const cell *c, double corners[4][3]);

#endif
