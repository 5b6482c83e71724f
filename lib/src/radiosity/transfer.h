/* SPDX-License-Identifier: MIT */
/* Light from the cells of a face to a point as weights of the cell's nodes: the near field, the
 * exact scaling and the exact visibility live here. */
#ifndef LCOR_RADIOSITY_TRANSFER_H
#define LCOR_RADIOSITY_TRANSFER_H

#include "radiosity/rule.h"
#include "radiosity/sight.h"

/* Most points that look at a face at once: nodes of one line of a receiver, with one normal. */
enum { TRANSFER_LANES = RULE_P };

/* Coordinates of the points and of their normal as a face sees them: along its lines of constant
 * first parameter, across them in its plane, off its plane. */
typedef struct transfer_frame {
    double along[TRANSFER_LANES], across[TRANSFER_LANES], height[TRANSFER_LANES];
    double n_along, n_across, n_height;
} transfer_frame;

/* A receiving point that looks at a face. */
typedef struct transfer {
    const double *x, *normal;
    const face *f;
    double accuracy; /* of a form factor */
    double distant;  /* squared distance in radii at which the rule reaches it */
    transfer_frame frame;
    sight sight;
} transfer;

/* What points with this normal look at; `blockers` are what may stand between them and the cells.
 */
void transfer_target(transfer *t, const lcor_scene *scene, const double normal[3], const face *f,
                     const uint32_t *blockers, size_t count, double accuracy);
/* The point that looks: any number of them, one after the other. */
void transfer_aim(transfer *t, const double x[3]);

/* Irradiance at x = sum of weights[k] * radiosity at node k of the cell; `exact` is the form factor
 * to what is seen of it. */
void transfer_weights(const transfer *t, const cell *c, double exact, float weights[RULE_Q]);

/* The same for TRANSFER_LANES points that see the whole cell. */
void transfer_open(const lcor_scene *scene, double (*x)[3], const double normal[3], const face *f,
                   const cell *c, double accuracy, const double *exact, float (*weights)[RULE_Q]);

/* Exact form factor from x to what it sees of the cell. */
double transfer_factor(const transfer *t, const cell *c);

/* The same from n points (at most TRANSFER_POINTS) of one plane, many at once; aims at some. */
enum { TRANSFER_POINTS = 24 };
void transfer_factors(transfer *t, size_t n, double (*points)[3], const cell *c, double *factors);

/* Whether nothing hides any of the cell from any point of the plane through x, nor is any below its
 * horizon. */
int transfer_is_open(const transfer *t, const double x[3], const cell *c);

/* The parameter q of the Bernstein ellipse along each axis in which 1/r^2 seen from x is analytic:
 * polynomials of order p on the cell come as close as q^-p, quadrature as q^-2p. Returns the
 * squared distance, at most the true one. */
double transfer_ellipse(const double x[3], const face *f, const cell *c, double q[2]);

/* The same for TRANSFER_LANES points: the lesser q of both axes and the squared distance of each.
 */
void transfer_ellipses(double (*x)[3], const face *f, const cell *c, double *q, double *distance2);

#endif
