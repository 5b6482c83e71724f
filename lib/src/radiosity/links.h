/* SPDX-License-Identifier: MIT */
/* Engine `links`: hierarchical radiosity of order RULE_P. docs/RADIOSITY.md tells how it works. */
#ifndef LCOR_RADIOSITY_LINKS_H
#define LCOR_RADIOSITY_LINKS_H

#include "radiosity/direct.h"
#include "radiosity/face.h"
#include "radiosity/occluders.h"
#include "radiosity/rule.h"

#include <lcor/radiosity.h>

/* A node of a face's binary tree. Values at its nodes lie in links.irradiance and .radiosity. */
typedef struct links_element {
    uint32_t face;
    int32_t child; /* the first of two, or -1 */
    int axis;      /* along which it was split */
    int leaf;      /* number among the leaves, or -1 */
    cell c;
    double area, low[3], high[3], centre[3];
    double direct_min, direct_max; /* of irradiance straight from the lights */
    double rough;                  /* error of the polynomial for its radiosity */
    double rough_direct;           /* the same due to the direct light */
    double power;                  /* put in by lights and emission, mean of the channels */
    double e_min, b_max;           /* of the solution so far; guesses before the first */
} links_element;

/* Irradiance of `receiver` due to `sender`. `block` is its place among the coefficients. */
typedef struct links_link {
    uint32_t receiver, sender;
    uint32_t first_occluder, occluder_count; /* in links.occluders */
    uint32_t block;
    uint32_t factors; /* place in links.factors, if measured and not yet filled */
    float accuracy;   /* of the block's weights, a form factor */
    float defect[3];  /* of the interpolated form factor: at the ends of either axis, the worst;
                         defect[2] < 0: not measured yet */
} links_link;

static const uint32_t links_no_block = UINT32_MAX;

/* What may hide a light from a face: `count` surfaces in links.occluders, or all of it is dark. */
typedef struct links_shadow {
    uint32_t first, count;
    int dark;
} links_shadow;

/* E[i] += exact[i] mean(B) + sum_k k[k][i] (B[k] - mean(B)): what varies in float, the mean by the
 * exact form factor in double, so that constants are transferred exactly. */
typedef struct links_block {
    float k[RULE_Q][RULE_Q]; /* [node of the sender][node of the receiver] */
    double exact[RULE_Q];
} links_block;

typedef struct links_mean { /* of an element's radiosity, and the largest deviation from it */
    double value, deviation;
} links_mean;

typedef struct links links;
struct links {
    const lcor_scene *scene;
    lcor_allocator allocator;
    lcor_parallel parallel;
    const light_set *lights;
    int channels;
    links_shadow *shadows;                    /* of face f and light i at f * lights + i */
    lcor_array faces;                         /* face */
    face_range *sides;                        /* of face_build */
    lcor_array elements;                      /* links_element */
    lcor_array list;                          /* links_link, by receiver once built */
    lcor_array blocks;                        /* links_block */
    lcor_array factors;                       /* double[RULE_Q]: measured at receivers' nodes */
    lcor_array occluders;                     /* uint32_t */
    lcor_array scratch;                       /* uint32_t, used as a stack while refining */
    lcor_array irradiance, radiosity, source; /* double[RULE_Q * channels] an element */
    lcor_array mean;                          /* links_mean[channels] an element */
    lcor_array deviation;                     /* float[RULE_Q * channels]: (B - mean) / deviation */
    lcor_array work;                          /* double, of the solve */
    size_t pairs_apart, pairs_open, pairs_tested; /* of faces */
    size_t leaf_count, basis_bytes;               /* the second: of the last linear solve */
    void (*poll)(links *l); /* called now and then: may set hurry or cancelled */
    void *poll_arg;
    unsigned polls;
    int hurry;             /* a limit is reached: link what is left as it is */
    int cancelled;         /* the caller wants to stop */
    double eps;            /* error a link may make, relative to its receiver */
    double accuracy;       /* of near-field weights, relative to the receiver's irradiance */
    int share;             /* a receiver's errors count by the root of its area, as in an rms */
    double finest;         /* elements may be split down to this times face.finest */
    double ambient, floor; /* mean indirect irradiance; least E errors refer to */
    int closed;            /* convex and without a hole: every hemisphere is full */
    double contraction;    /* of one interreflection */
    double energy_defect;  /* of the power put in */
    int iterations;
};

static inline links_element *links_at(const links *l, size_t i)
{
    return (links_element *)l->elements.items + i;
}

static inline face *links_face_of(const links *l, const links_element *e)
{
    return (face *)l->faces.items + e->face;
}

static inline double *links_values(const links *l, const lcor_array *a, size_t element)
{
    return (double *)a->items + element * RULE_Q * (size_t)l->channels;
}

static inline double *links_channel(const links *l, const lcor_array *a, size_t element, int c)
{
    return links_values(l, a, element) + (size_t)c * RULE_Q;
}

/* tree.c. Functions that return int return 0 without memory or when cancelled. */
int links_init(links *l); /* faces and their root elements; the caller fills the head */
void links_clear(links *l);
int links_relight(links *l); /* after lights or looks changed */
int links_split(links *l, size_t element, int axis);
int links_may_split(const links *l, const links_element *e, int axis);
/* Length of an element along an axis: of its middle line. */
double links_extent(const links *l, const links_element *e, int axis);
void links_nodes(const links *l, const links_element *e, double x[RULE_Q][3]);
void links_region(const links *l, const links_element *e, region *out);
/* A point this little before the edge between two leaves belongs to the second, so that rounding
 * does not decide. */
#define LINKS_ON_EDGE 1e-12
/* Leaf at (s, t) of the face, and the place within it. */
size_t links_leaf_at(const links *l, const face *f, double s, double t, double *u, double *v);

/* refine.c: the first time every pair of faces, then every link that is too coarse for eps. */
int links_refine(links *l);

/* kernel.c: coefficients of links that have none; sorts links by receiver. */
int links_fill(links *l);

void links_set_source(links *l);
void links_node_areas(const links *l, const links_element *e, double area[RULE_Q]);
void links_run(const links *l, size_t n, void (*task)(void *arg, size_t i), void *arg);

/* solve.c: irradiance and radiosity of all elements, contraction, iterations, energy_defect. */
int links_solve(links *l, double tolerance, int max_iterations);

/* tight.c: indirect irradiance at x as the solution's radiosity gives it by one gathering of its
 * own, about as accurate as wanted if all irradiance there is as `expected`; `skip` is the surface
 * x lies on, or LCOR_BVH_NONE. `channels` values. */
void links_gather(const links *l, const double x[3], const double normal[3], uint32_t skip,
                  double accuracy, double expected, double *out);

/* Estimated errors from about n points spread over the leaves by area. */
typedef struct links_errors {
    double rms, max;
} links_errors;
int links_estimate(links *l, size_t n, links_errors *out);

#endif
