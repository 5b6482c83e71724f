/* SPDX-License-Identifier: MIT */
/* Engine `gather`: a coarse ray-sampled field of the reflected light, and a quasi-Monte-Carlo
 * gathering of it wherever irradiance is asked for. docs/RADIOSITY.md tells how it works. */
#ifndef LCOR_RADIOSITY_GATHER_H
#define LCOR_RADIOSITY_GATHER_H

#include "radiosity/emitters.h"
#include "radiosity/engine.h"
#include "radiosity/gather_guide.h"
#include "radiosity/gather_random.h"

#include "base/array.h"

#include <math.h>

/* GATHER_TRIES: places tried for one that rays come to. */
enum { GATHER_TRIES = 8, GATHER_TERMS = 6, GATHER_CHANNELS = 3, GATHER_GROUPS = 8 };

static const uint32_t gather_none = UINT32_MAX; /* no surface, side or leaf */

/* Coplanar surfaces that touch share a plane, with orthonormal coordinates u, v. Irradiance does
 * not depend on the reflectance of what receives it, so looks may differ. */
typedef struct gather_plane {
    double origin[3], u[3], v[3], normal[3];
    size_t first, count; /* in gather.members */
} gather_plane;

/* A triangle or parallelogram of a surface, numbered as the ray structure does. */
typedef struct gather_prim {
    uint32_t surface;
    uint32_t corner;    /* a polygon's fan: between this corner and the next */
    double area_before; /* of all before it */
} gather_prim;

/* Side 2 i of plane i is the one its normal points to. */
typedef struct gather_side {
    int32_t root;    /* node, or -1: no field, rays go on from here */
    uint32_t hits;   /* by probing rays */
    double reflects; /* area that reflects, of either look */
} gather_side;

typedef struct gather_node { /* of a side's kd tree */
    int axis;
    double at;
    int32_t child[2], leaf; /* leaf -1: split */
} gather_node;

typedef struct gather_piece { /* a triangle of a surface, or what splits left of it */
    double corner[3][2];
    double area_before; /* of the leaf's pieces up to this one */
    uint32_t surface;
} gather_piece;

/* The reflected irradiance on a leaf is a polynomial of degree 0, 1 or 2 in coordinates -1..1. */
typedef struct gather_leaf {
    uint32_t side;
    int32_t node;
    size_t first_piece, piece_count;
    double centre[2], half[2], area;
    double ray_length; /* harmonic mean */
    double brightness; /* irradiance, of the scene's mean, at most 1: 1 where nobody asked */
    uint32_t hits;     /* by probing rays */
    int terms;         /* 1, 3 or 6; 0: the leaf was split */
    size_t slot;       /* number among those that were not */
    uint64_t rays;
    size_t first_record, record_count, record_room;
    size_t tries; /* places from which rays for records were to start */
    double inverse[GATHER_TERMS * GATHER_TERMS]; /* of the normal equations */
} gather_leaf;

/* One ray of a leaf: irradiance = source + through * field where it ended. */
typedef struct gather_record {
    float from[2]; /* where it left its leaf, -1..1, */
    float at[2];   /* and where it ended on another, of this slot */
    uint32_t slot; /* or gather_none */
} gather_record;

/* What a request needs; each round that misses it asks for more. */
typedef struct gather_effort {
    double leaf_size;  /* of the harmonic mean ray length, and less until there are */
    size_t leaves;     /* so many */
    double rays;       /* a leaf, on average */
    double near;       /* rays shorter than so many leaf sizes go on instead of reading the field */
    double stop;       /* relative error of an answer, */
    double patch_stop; /* and of an average over a patch, whose rays differ by place too */
    int share;         /* that is of usual effort; more where it takes more, less where less: the
                          least effort for an rms over all */
    double samples;    /* most of an answer */
} gather_effort;

typedef struct gather {
    lcor_solution *solution;
    const lcor_scene *scene;
    const lcor_allocator *allocator;
    int channels;
    sobol sobol;
    double *reflectance, *emission; /* per surface and channel; what is emitted and exact is 0 */
    emitter_set emitters;
    double touch; /* rays start and end this far from surfaces */

    lcor_array planes, members; /* gather_plane; uint32_t: surfaces by plane */
    uint32_t *plane_of;         /* per surface */
    signed char *facing;        /* per surface: 1 if its normal is the plane's, else -1 */
    gather_side *sides;
    lcor_array prims; /* gather_prim, and a last one with the area of all */

    lcor_array nodes, leaves, pieces;
    size_t probed;                 /* leaves whose ray length is known */
    uint64_t probes;               /* rays that looked around */
    lcor_array records;            /* gather_record */
    float *source, *through;       /* per record and channel */
    double *field;                 /* GATHER_TERMS a leaf and channel */
    double *groups[GATHER_GROUPS]; /* what groups of rays add to it; one block */
    size_t slots;                  /* leaves that were not split */

    guide guide;
    gather_effort effort;
    size_t places;          /* that the error is estimated from */
    double rays_per_sample; /* about */
    double mean;            /* irradiance of the scene: errors refer to at least 2 % of it */
    double contraction;     /* of one reflection */
    int iterations;
    int dark; /* no light at all */
    int cancelled, hurry;
    uint64_t rays;
} gather;

static inline gather_leaf *gather_leaf_at(const gather *g, size_t i)
{
    return (gather_leaf *)g->leaves.items + i;
}

/* Rays shorter than this do not read the leaf's field. */
static inline double gather_reach(const gather_leaf *l, double near)
{
    return 2 * near * fmax(l->half[0], l->half[1]);
}

static inline int gather_is_near(const gather_leaf *l, double near, double distance)
{
    return !(distance > gather_reach(l, near));
}

/* What is this close to a place on the leaf hides it from rays that come from afar. */
static inline double gather_hemmed_in(const gather_leaf *l)
{
    return 0.1 * fmax(l->half[0], l->half[1]);
}

static inline gather_plane *gather_plane_at(const gather *g, size_t i)
{
    return (gather_plane *)g->planes.items + i;
}

/* Runs task(arg, 0..n-1) a part at a time, minding progress and limits. Returns 0 if cancelled. */
int gather_each(gather *g, size_t n, void (*task)(void *arg, size_t i), void *arg);
/* Rays that max_seconds leave time for, by those traced so far. */
double gather_rays_left(const gather *g);

uint64_t gather_bytes(const gather *g);

/* Where rays start: a place on a surface, or free (surface LCOR_BVH_NONE). */
typedef struct gather_stand {
    double x[3], u[3], v[3], normal[3];
    uint32_t surface;
} gather_stand;

/* gather_planes.c. Functions that return int return 0 without memory or when cancelled. */
int gather_find_planes(gather *g);
/* The side of its plane that a surface shows on its front (back 0) or back. */
uint32_t gather_side_of(const gather *g, uint32_t surface, int back);
void gather_to_plane(const gather_plane *p, const double x[3], double at[2]);
/* Fills all but x. */
void gather_stand_on(const gather *g, uint32_t surface, int back, gather_stand *stand);

/* gather_prims.c */
int gather_list_prims(gather *g);
/* Origin and edges; returns 1 for a triangle. */
int gather_prim_frame(const gather *g, size_t prim, double origin[3], double u[3], double v[3]);
/* Places of 0..1 squared to coordinates along a primitive's edges, ratios of areas kept. */
void gather_square_to_edges(int triangle, const double q[2], double st[2]);
/* A place on the front of all surfaces, uniform by area; returns its primitive. */
size_t gather_place(const gather *g, double a, double b, gather_stand *stand);

/* gather_tree.c */
int gather_grow(gather *g); /* fields for the sides that matter, leaves by ray length */
uint32_t gather_leaf_of(const gather *g, uint32_t side, const double at[2]);
/* The leaf of a place on a surface, or gather_none; `at` gets the plane's coordinates. */
uint32_t gather_leaf_at_stand(const gather *g, const gather_stand *stand, double at[2]);
/* Place a, b of 0..1 on the leaf, uniform by area, in the plane's coordinates and as a stand. */
void gather_leaf_stand(const gather *g, const gather_leaf *leaf, double a, double b, double at[2],
                       gather_stand *stand);

/* Where a ray ends. */
typedef struct gather_spot {
    gather_stand stand; /* on the side the ray came from */
    double distance;
    uint32_t side;
    int back;     /* that is the back of the surface */
    int reflects; /* the look is on this side; else it is black */
    uint32_t prim;
    double st[2]; /* along the primitive's edges */
} gather_spot;

/* gather_path.c: what arrives straight at a place, from lights and from emitters that are exact. */
void gather_straight(const gather *g, const double x[3], const double normal[3], uint32_t surface,
                     double *out);
/* The first hit; 0 if there is none. */
int gather_trace(const gather *g, const gather_stand *from, const double direction[3],
                 gather_spot *spot);

/* One estimate of the irradiance that is not direct, as source + through * field. */
typedef struct gather_sample {
    double source[GATHER_CHANNELS], through[GATHER_CHANNELS];
    uint32_t leaf; /* gather_none: through is 0 */
    double at[2];
    double distance; /* to the first hit, infinite if there is none */
    uint32_t rays;
} gather_sample;

/* Sample `index` of the sequence `seed`, whose axes 2 and 3 are free for the place. `near` as in
 * gather_effort; `view` may be NULL: not guided. */
void gather_sample_at(const gather *g, const gather_stand *stand, const guide_view *view,
                      double near, uint32_t index, uint32_t seed, gather_sample *out);

/* gather_field.c */
void gather_forget_records(gather *g); /* what they tell is no longer so */
int gather_solve_field(gather *g);     /* keeps the records there are and adds what is missing */
/* `field`: coefficients like gather.field. */
double gather_field_at(const gather *g, const double *field, uint32_t leaf, const double at[2],
                       int channel);
/* The sample's irradiance with coefficients like gather.field. */
double gather_sample_value(const gather *g, const gather_sample *sample, const double *field,
                           int channel);
/* out = K in: coefficients of what leaves get if the field is `in`. arg: gather */
void gather_apply(void *arg, const double *in, double *out);
/* What groups of a leaf's rays say more than the field does, mean over the leaf, as fields. */
void gather_residuals(const gather *g, double *const groups[GATHER_GROUPS]);

/* Sets the brightness of leaves by the field there is. */
int gather_find_dark(gather *g);

/* gather_query.c: the irradiance that is not direct, at a stand or as the average over a patch. */
typedef struct gather_query {
    gather_stand stand;
    int average;       /* over a patch: */
    double patch[9];   /* origin and two edges of a parallelogram or */
    int triangle;      /* a triangle */
    double near, stop; /* as in gather_effort */
    int share_effort;
    double samples; /* at most */
    uint32_t seed;
    double *const *groups; /* NULL, or GATHER_GROUPS more fields, */
    double *variance;      /* NULL, or gets that of the answer, mean of the channels */
} gather_query;

/* At a point on a surface or free (LCOR_BVH_NONE). */
void gather_query_point(const gather *g, const double x[3], const double normal[3],
                        uint32_t surface, gather_query *q);
void gather_query_patch(const gather *g, size_t surface, lcor_value value, size_t index,
                        gather_query *q);
/* What the irradiance may be where `direct` is what comes straight, and at least what is dark. */
double gather_expected(const gather *g, const gather_stand *stand, const double *direct);
/* Adds to `total`, which holds what is direct; `group` gets what the other fields add to the
 * answer, mean of the channels. Returns the number of rays. */
uint64_t gather_answer(const gather *g, const gather_query *q, double *total, double *group);

/* gather_error.c: relative errors of answers at `places`. Without memory or when cancelled: 0. */
typedef struct gather_errors {
    double rms, max;
    double noise, field; /* parts of rms: of the answer's rays, and of the field they read; */
    double bias;         /* what the latter have in common */
} gather_errors;
/* Sets `mean`, near enough to tell what is dark, and `groups`; the field's part alone. */
int gather_judge_field(gather *g, gather_errors *out);
/* Without a field: sets `mean` and `rays_per_sample`. */
int gather_survey(gather *g);
int gather_estimate(gather *g, gather_errors *out);
/* The noise of averages over patches. */
int gather_patch_noise(gather *g, double *noise);
/* Squares of a sample of `count` spread: what to multiply a root of their mean by. */
double gather_upper_end(size_t count);
/* rms from its parts. */
void gather_sum_errors(gather_errors *e, size_t count);

#endif
