/* SPDX-License-Identifier: MIT */
/* Light from a cell of a face to a point, or from a light to a cell, as weights of the cell's
 * nodes: the near field, the exact scaling and the exact visibility live here. */
#ifndef LCOR_RADIOSITY_TRANSFER_H
#define LCOR_RADIOSITY_TRANSFER_H

#include "radiosity/face.h"
#include "radiosity/rule.h"

/* One end of a transfer: a receiving point with its normal, or a light. `occluders` are the
 * surfaces that may stand between it and the cell. */
typedef struct transfer {
    const lcor_scene *scene;
    const double *x, *normal; /* receiver, when light is NULL */
    const lcor_light *light;
    const uint32_t *occluders;
    size_t occluder_count;
    double accuracy; /* of a form factor; for a light, relative */
    double exact;    /* the form factor to the cell if known, else < 0 */
} transfer;

/* Receiver: irradiance at x = sum of weights[k] * radiosity at node k. Light of intensity 1:
 * weights[k] = integral over the cell of irradiance * polynomial k, so that their sum is the
 * flux. Returns the exact form factor (receiver) or the flux (light). */
double transfer_weights(const transfer *t, const face *f, const cell *c, double weights[RULE_Q]);

/* Exact form factor from point x to what it sees of the cell. */
double transfer_factor(const transfer *t, const face *f, const cell *c);

/* The same from n points (at most TRANSFER_POINTS) of face r; the x and normal of t are not used.
 * Returns 1 if nothing had to be clipped, and then the factors hold for transfer.exact too. */
enum { TRANSFER_POINTS = 24 };
int transfer_factors(const transfer *t, const face *r, size_t n, double (*points)[3], const face *f,
                     const cell *c, double *factors);

/* The larger parameter q of the Bernstein ellipse along each axis in which 1/r^2 seen from x is
 * analytic: polynomials of order p on the cell come as close as q^-p, quadrature as q^-2p. Returns
 * the squared distance, at most the true one. */
double transfer_ellipse(const double x[3], const face *f, const cell *c, double q[2]);

#endif
