/* SPDX-License-Identifier: MIT */
#include "radiosity/rule.h"

#include <stddef.h>

const double rule_x[RULE_P] = {0.06943184420297371239, 0.33000947820757186760,
                               0.66999052179242813240, 0.93056815579702628761};
const double rule_w[RULE_P] = {0.17392742256872692869, 0.32607257743127307131,
                               0.32607257743127307131, 0.17392742256872692869};

/* clang-format off */
#define HALVES(X)                                                                                  \
    {{{X(1.24706002059021446916), X(-0.3713464629329096705), X(0.17261231228231495598), X(-0.0483258699396197546)}, \
      {X(0.47336076207371348124), X(0.69446086758875954879), X(-0.2269159612062269743), X(0.05909433154375394426)}, \
      {X(-0.0073814630032159984), X(0.99585142579386540218), X(0.01482140011742123726), X(-0.0032913629080706410)}, \
      {X(-0.0956095946480186732), X(0.70865608285499706932), X(0.46829580008941685915), X(-0.0813422882963952552)}}, \
     {{X(-0.0813422882963952552), X(0.46829580008941685915), X(0.70865608285499706932), X(-0.0956095946480186732)}, \
      {X(-0.0032913629080706410), X(0.01482140011742123726), X(0.99585142579386540218), X(-0.0073814630032159984)}, \
      {X(0.05909433154375394426), X(-0.2269159612062269743), X(0.69446086758875954879), X(0.47336076207371348124)}, \
      {X(-0.0483258699396197546), X(0.17261231228231495598), X(-0.3713464629329096705), X(1.24706002059021446916)}}}
/* clang-format on */
#define AS_DOUBLE(x) x
#define AS_FLOAT(x)  x##F

const double rule_half[2][RULE_P][RULE_P] = HALVES(AS_DOUBLE);
static const float half_float[2][RULE_P][RULE_P] = HALVES(AS_FLOAT);

/* 1 / product of (x_a - x_j) over j != a */
static const double scale[RULE_P] = {-7.4205400680389461052, 18.7954494075550608112,
                                     -18.795449407555060811, 7.42054006803894610520};

void rule_values(double x, double values[RULE_P])
{
    const double d[RULE_P] = {x - rule_x[0], x - rule_x[1], x - rule_x[2], x - rule_x[3]};

    values[0] = scale[0] * d[1] * d[2] * d[3];
    values[1] = scale[1] * d[0] * d[2] * d[3];
    values[2] = scale[2] * d[0] * d[1] * d[3];
    values[3] = scale[3] * d[0] * d[1] * d[2];
}

/* Inner loops run along memory, so that they become SIMD. */
void rule_push(int axis, int c, const double *whole, double *half)
{
    for (int g = 0; g < RULE_P; g++)
        for (int a = 0; a < RULE_P; a++)
            for (int b = 0; b < RULE_P; b++)
                if (axis == 0)
                    half[g * RULE_P + b] += rule_half[c][g][a] * whole[a * RULE_P + b];
                else
                    half[b * RULE_P + g] += rule_half[c][g][a] * whole[b * RULE_P + a];
}

void rule_fold(int axis, int c, const double *half, double *whole)
{
    for (int a = 0; a < RULE_P; a++)
        for (int g = 0; g < RULE_P; g++) {
            const double p = rule_half[c][g][a], h = half[a * RULE_P + g];

            if (axis == 0)
                for (int b = 0; b < RULE_P; b++)
                    whole[a * RULE_P + b] += p * half[g * RULE_P + b];
            else
                for (int b = 0; b < RULE_P; b++)
                    whole[a * RULE_P + b] += h * rule_half[c][g][b];
        }
}

/* row += p times other; four sums, spelled out, become one vector. */
static void add_row(float row[RULE_P], const float p[RULE_P], const float other[RULE_Q])
{
    float r0 = row[0], r1 = row[1], r2 = row[2], r3 = row[3];

    for (size_t g = 0; g < RULE_P; g++) {
        r0 += p[g] * other[RULE_P * g];
        r1 += p[g] * other[RULE_P * g + 1];
        r2 += p[g] * other[RULE_P * g + 2];
        r3 += p[g] * other[RULE_P * g + 3];
    }
    row[0] = r0;
    row[1] = r1;
    row[2] = r2;
    row[3] = r3;
}

void rule_fold_float(int axis, int c, const float *half, float *whole)
{
    for (size_t a = 0; a < RULE_P; a++)
        if (axis == 0) {
            const float p[RULE_P] = {half_float[c][0][a], half_float[c][1][a], half_float[c][2][a],
                                     half_float[c][3][a]};

            add_row(whole + RULE_P * a, p, half);
        } else {
            add_row(whole + RULE_P * a, half + RULE_P * a, half_float[c][0]);
        }
}

double rule_interpolate(const double *f, const double at_s[RULE_P], const double at_t[RULE_P])
{
    double sum = 0;

    for (int a = 0; a < RULE_P; a++) {
        double row = 0;

        for (int b = 0; b < RULE_P; b++)
            row += at_t[b] * f[a * RULE_P + b];
        sum += at_s[a] * row;
    }
    return sum;
}
