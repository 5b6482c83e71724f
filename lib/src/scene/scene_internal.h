/* SPDX-License-Identifier: MIT */
/* A scene as the engines see it. Everything below is filled by lcor_scene_commit and constant
 * afterwards, except the looks and lights that lcor_scene_set_* change. */
#ifndef LCOR_SCENE_INTERNAL_H
#define LCOR_SCENE_INTERNAL_H

#include "base/array.h"
#include "base/cpu.h"
#include "geometry/bvh.h"
#include "geometry/factor.h"

#include <lcor/scene.h>

#include <stdint.h>

typedef enum scene_shape { SCENE_QUAD, SCENE_TRIANGLE, SCENE_POLYGON } scene_shape;

typedef struct scene_surface {
    scene_shape shape;
    double origin[3], edge_u[3], edge_v[3]; /* polygon: corner 0 and the edges to 1 and 2 */
    double normal[3];                       /* of length 1, on the facing side */
    double area;
    size_t first_corner, corner_count; /* in lcor_scene.corners, counted in points */
    lcor_surface look;
} scene_surface;

/* Coplanar surfaces side by side whose union is a parallelogram. They looked alike when the scene
 * was committed; lcor_scene_set_surface may have changed that. */
typedef struct scene_sheet {
    scene_surface shape;               /* its look is not used */
    size_t first_member, member_count; /* in lcor_scene.sheet_members: surfaces */
} scene_sheet;

/* Shapes that together are the hull of a convex solid, but for at most one of its sides: what
 * stands in the light as one. */
typedef struct scene_solid {
    size_t first_member, member_count; /* in lcor_scene.members: shapes */
    size_t first_plane, plane_count;   /* in lcor_scene.planes, the missing side's included */
    size_t first_edge, edge_count;     /* in lcor_scene.edges */
    double middle[3];                  /* a point inside */
} scene_solid;

typedef struct scene_edge { /* of a solid, between two of its planes, counted from its first */
    double p[3], q[3];
    size_t side[2];
} scene_edge;

enum { SCENE_SOLID_SIDES = 64 }; /* a solid has at most, the missing one included */

typedef struct scene_plane { /* (p - point) . normal <= 0 inside */
    double point[3], normal[3];
} scene_plane;

struct lcor_scene {
    lcor_allocator allocator;
    lcor_array surfaces; /* scene_surface */
    lcor_array lights;   /* lcor_light, directions of length 1 after commit */
    lcor_array corners;  /* double[3] */
    int committed;
    lcor_bvh *bvh;                     /* owners are surface numbers */
    lcor_factor_points *factor_points; /* for this machine */
    lcor_cpu cpu;
    double diameter; /* of the bounding box */
    int convex;      /* no surface has anything behind it: nothing hides anything */
    /* Shape i is a surface as it was added, or sheet i - surfaces.count. */
    lcor_array sheets, sheet_members; /* scene_sheet, uint32_t */
    lcor_array shapes;                /* uint32_t: the sheets and every surface that is in none */
    /* Blocker i is what may stand in the light: shape i, or behind all shapes' numbers a solid. */
    lcor_array solids, members; /* scene_solid, uint32_t */
    lcor_array planes, edges;   /* scene_plane, scene_edge */
    lcor_array blockers;        /* uint32_t: the solids and every shape that is in none */
};

/* Distance below which a ray's end counts as lying on a surface, as part of scene->diameter. */
#define SCENE_TOUCH 1e-9
/* And a caller's point, which may have been kept in single precision or as text. */
#define SCENE_REACH 1e-6

static inline const scene_surface *scene_surface_at(const lcor_scene *scene, size_t i)
{
    return (const scene_surface *)scene->surfaces.items + i;
}

/* The sheet that a shape is, or NULL. */
static inline const scene_sheet *scene_sheet_of(const lcor_scene *scene, uint32_t shape)
{
    return shape < scene->surfaces.count
               ? NULL
               : (const scene_sheet *)scene->sheets.items + (shape - scene->surfaces.count);
}

static inline const scene_surface *scene_shape_at(const lcor_scene *scene, uint32_t shape)
{
    const scene_sheet *sheet = scene_sheet_of(scene, shape);

    return sheet ? &sheet->shape : scene_surface_at(scene, shape);
}

static inline const lcor_light *scene_light_at(const lcor_scene *scene, size_t i)
{
    return (const lcor_light *)scene->lights.items + i;
}

static inline const double *scene_corners(const lcor_scene *scene, const scene_surface *surface)
{
    return (const double *)scene->corners.items + 3 * surface->first_corner;
}

/* The checks of commit, one item each; `where` of the error is its number. */
lcor_status lcor_scene_check_look(const lcor_surface *look, size_t id, lcor_error *err);
lcor_status lcor_scene_check_light(const lcor_light *light, size_t id, lcor_error *err);

/* Whether the point lies on the facing side or on the plane of every surface. In a convex scene
 * nothing then hides it from any surface. */
int lcor_scene_inside(const lcor_scene *scene, const double point[3]);

/* The surface that a point lies on, `normal` (of length 1) being that of one of its sides; the
 * point is moved onto its plane. LCOR_BVH_NONE if there is none. */
uint32_t lcor_scene_surface_of(const lcor_scene *scene, const double normal[3], double point[3]);

/* Whether anything stands between two points of the scene, each on a surface or free. Surface
 * `skip` (or LCOR_BVH_NONE) is looked through. `cache` as in lcor_bvh_occluded. */
int lcor_scene_blocked(const lcor_scene *scene, const double from[3], const double to[3],
                       uint32_t skip, uint32_t *cache);
/* The same towards a direction, without end. */
int lcor_scene_blocked_towards(const lcor_scene *scene, const double from[3],
                               const double direction[3], uint32_t skip, uint32_t *cache);

/* convex.c: finds whether the scene is; 0 without memory. */
int lcor_scene_find_convex(lcor_scene *scene);

/* sheet.c: finds the sheets and fills the shapes; 0 without memory. */
int lcor_scene_find_sheets(lcor_scene *scene);

/* Whether two looks reflect and emit the same, whatever their patches. */
int lcor_scene_look_alike(const lcor_surface *a, const lcor_surface *b);

/* solid.c: finds the solids and fills the blockers; 0 without memory. */
int lcor_scene_find_solids(lcor_scene *scene);

/* The solid that a blocker is, or NULL. */
static inline const scene_solid *scene_solid_of(const lcor_scene *scene, uint32_t blocker)
{
    const size_t shapes = scene->surfaces.count + scene->sheets.count;

    return blocker < shapes ? NULL : (const scene_solid *)scene->solids.items + (blocker - shapes);
}

/* Shape k of a blocker, NULL behind the last one. */
static inline const scene_surface *scene_blocker_part(const lcor_scene *scene, uint32_t blocker,
                                                      size_t k)
{
    const scene_solid *solid = scene_solid_of(scene, blocker);

    if (!solid)
        return k == 0 ? scene_shape_at(scene, blocker) : NULL;
    return k < solid->member_count
               ? scene_shape_at(scene,
                                ((const uint32_t *)scene->members.items)[solid->first_member + k])
               : NULL;
}

/* Whether a point lies inside one of the solids: then only single shapes hide anything from it.
 */
int lcor_scene_in_solid(const lcor_scene *scene, const double point[3]);

/* Corners of patch `index` as a parallelogram (corner_count 4) or triangle (3) in the surface's
 * edge coordinates: point = origin + s edge_u + t edge_v. Triangular patches of a polygon are
 * counted fan triangle by fan triangle. */
typedef struct scene_patch {
    double s[4], t[4];
    int corner_count;
} scene_patch;

size_t lcor_scene_patches_of(const scene_surface *surface); /* 0: does not fit size_t */
void lcor_scene_patch(const lcor_scene *scene, const scene_surface *surface, size_t index,
                      scene_patch *out);
size_t lcor_scene_patch_grid(const scene_surface *surface); /* n of a triangle or polygon */

/* Edge coordinates of the point's projection onto the surface's plane. */
void lcor_scene_coordinates(const scene_surface *surface, const double point[3], double *s,
                            double *t);

#endif
