/* SPDX-License-Identifier: MIT */
/* The polynomial basis of an element: Lagrange polynomials on RULE_P Gauss points along each of
 * its two parameters. Node (a, b) has number a * RULE_P + b. */
#ifndef LCOR_RADIOSITY_RULE_H
#define LCOR_RADIOSITY_RULE_H

enum { RULE_P = 4, RULE_Q = RULE_P * RULE_P };

extern const double rule_x[RULE_P]; /* Gauss points of 0..1 */
extern const double rule_w[RULE_P]; /* their weights, sum 1 */

/* rule_half[c][g][a]: value of the whole interval's polynomial a at point g of its half c. */
extern const double rule_half[2][RULE_P][RULE_P];

/* Values of the polynomials at x. */
void rule_values(double x, double values[RULE_P]);

/* Adds the polynomial with node values `whole`, seen on half c along `axis` (0: first parameter),
 * to the node values `half`. */
void rule_push(int axis, int c, const double *whole, double *half);

/* The transpose: adds weights of the half's nodes to those of the whole's. */
void rule_fold(int axis, int c, const double *half, double *whole);
void rule_fold_float(int axis, int c, const float *half, float *whole);

/* sum over nodes of values[a] values[b] f[a, b] */
double rule_interpolate(const double *f, const double at_s[RULE_P], const double at_t[RULE_P]);

#endif
