/* SPDX-License-Identifier: MIT */
/* On grids aligned with the room's edges the factor between two patches depends on few numbers, so
 * there is a table, not a matrix. Formulas: J. R. Howell's catalog, C-13 and C-15, as mean factors
 * of finite rectangles. */
#include "richardson.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { FACES = 6, COARSE = 25, ITERATIONS = 60 };

static const double pi = 3.14159265358979323846;
static const double light[3] = {0.3, 0.4, 0.7};
static const double rho[FACES] = {0.3, 0.8, 0.5, 0.5, 0.5, 0.5};
static const int normal_axis[FACES] = {2, 2, 0, 0, 1, 1};
static const int axes[FACES][2] = {{0, 1}, {0, 1}, {1, 2}, {1, 2}, {0, 2}, {0, 2}};

/* 2 pi times the fourth antiderivative of cos cos / pi r^2 of parallel planes a length 1 apart. */
static double opposite(double u, double v)
{
    const double p = sqrt(u * u + 1), q = sqrt(v * v + 1);

    return v * p * atan(v / p) + u * q * atan(u / q) - 0.5 * log(u * u + v * v + 1);
}

/* The same of perpendicular planes, at distances x and z from their common edge. */
static double adjacent(double x, double z, double y)
{
    const double r2 = x * x + z * z, r = sqrt(r2), s2 = r2 + y * y;

    return s2 > 0 ? (r > 0 ? y * r * atan(y / r) : 0) - 0.25 * (r2 - y * y) * log(s2) : 0;
}

/* Factors on a grid of n x n, from a patch: opposite[d][e + n] to one d, e patches aside;
 * adjacent[p][r][e + n] from row p to row r, counted from the edge. */
typedef struct tables {
    size_t n;
    double *opposite, *adjacent;
} tables;

static double second_difference(const double g[3]) { return 2 * g[1] - g[0] - g[2]; }

static int make_tables(tables *t, size_t n)
{
    const double h = 1 / (double)n, scale = 1 / (2 * pi * h * h);

    t->n = n;
    t->opposite = malloc(n * 2 * n * sizeof(double));
    t->adjacent = malloc(n * n * 2 * n * sizeof(double));
    if (!t->opposite || !t->adjacent)
        return 0;
    for (size_t e = 0; e < 2 * n; e++) {
        const double aside = fabs((double)e - (double)n) * h;

        for (size_t d = 0; d < n; d++) {
            double rows[3], g[3];

            for (int a = 0; a < 3; a++) {
                for (int b = 0; b < 3; b++)
                    g[b] = opposite(((double)d + a - 1) * h, aside + (b - 1) * h);
                rows[a] = second_difference(g);
            }
            t->opposite[d * 2 * n + e] = scale * second_difference(rows);
        }
        for (size_t p = 0; p < n; p++)
            for (size_t r = 0; r < n; r++) {
                double sum = 0, g[3];

                for (int a = 0; a < 4; a++) {
                    for (int b = 0; b < 3; b++)
                        g[b] = adjacent((double)(p + (size_t)(a / 2)) * h,
                                        (double)(r + (size_t)(a % 2)) * h, aside + (b - 1) * h);
                    sum += (a == 0 || a == 3 ? 1 : -1) * second_difference(g);
                }
                t->adjacent[(p * n + r) * 2 * n + e] = scale * sum;
            }
    }
    return 1;
}

/* E of face f from B of the opposite face. */
static void add_opposite(const tables *t, const double *b, double *e)
{
    const size_t n = t->n;

    for (size_t i = 0; i < n; i++)
        for (size_t j = 0; j < n; j++)
            for (size_t k = 0; k < n; k++) {
                const double *row = t->opposite + (i > k ? i - k : k - i) * 2 * n + n - j;
                double sum = 0;

                for (size_t l = 0; l < n; l++)
                    sum += row[l] * b[k * n + l];
                e[i * n + j] += sum;
            }
}

/* E of face f from B of a face g that shares an edge with it: both as rows away from the edge. */
static void add_adjacent(const tables *t, const double *b, double *e)
{
    const size_t n = t->n;

    for (size_t p = 0; p < n; p++)
        for (size_t q = 0; q < n; q++)
            for (size_t r = 0; r < n; r++) {
                const double *row = t->adjacent + (p * n + r) * 2 * n + n - q;
                double sum = 0;

                for (size_t s = 0; s < n; s++)
                    sum += row[s] * b[r * n + s];
                e[p * n + q] += sum;
            }
}

/* Between a face's own order and rows away from its edge with face g. */
static void turn(size_t n, int f, int g, const double *in, double *out, int back)
{
    const int first = axes[f][0] == normal_axis[g];

    for (size_t i = 0; i < n; i++)
        for (size_t j = 0; j < n; j++) {
            const size_t away = first ? i : j, along = first ? j : i;
            const size_t row = g % 2 ? n - 1 - away : away;

            if (back)
                out[i * n + j] += in[row * n + along];
            else
                out[row * n + along] = in[i * n + j];
        }
}

static void gather(const tables *t, const double *b, double *e, double *work)
{
    const size_t n = t->n, patches = n * n;

    memset(e, 0, FACES * patches * sizeof *e);
    for (int f = 0; f < FACES; f++)
        for (int g = 0; g < FACES; g++) {
            double *in = work, *out = work + patches;

            if (normal_axis[f] == normal_axis[g]) {
                if (f != g)
                    add_opposite(t, b + (size_t)g * patches, e + (size_t)f * patches);
                continue;
            }
            memset(out, 0, patches * sizeof *out);
            turn(n, g, f, b + (size_t)g * patches, in, 0);
            add_adjacent(t, in, out);
            turn(n, f, g, out, e + (size_t)f * patches, 1);
        }
}

/* Mean irradiance straight from the light: its solid angle over the area. */
static void direct(size_t n, double *e)
{
    for (size_t f = 0; f < FACES; f++) {
        const int w = normal_axis[f];
        const double d = fabs(light[w] - (double)(f % 2)), h = 1 / (double)n;

        for (size_t i = 0; i < n; i++)
            for (size_t j = 0; j < n; j++) {
                double sum = 0;

                for (size_t k = 0; k < 4; k++) {
                    const double u = (double)(i + k / 2) * h - light[axes[f][0]];
                    const double v = (double)(j + k % 2) * h - light[axes[f][1]];

                    sum += (k == 0 || k == 3 ? 1 : -1) *
                           atan(u * v / (d * sqrt(u * u + v * v + d * d)));
                }
                e[(f * n + i) * n + j] = sum / (h * h);
            }
    }
}

/* Averages over patches of n x n; `e` holds room for all of them. */
static int solve(size_t n, double *e)
{
    const size_t patches = n * n, all = FACES * patches;
    double *first = malloc((2 * all + 2 * patches) * sizeof *first);
    double *b = first + all, *work = b + all, change = 1;
    tables t = {n, NULL, NULL};
    const int good = first && make_tables(&t, n);

    if (good) {
        direct(n, first);
        memcpy(e, first, all * sizeof *e);
    }
    for (int k = 0; good && k < ITERATIONS && change > 1e-7; k++) {
        change = 0;
        for (size_t i = 0; i < all; i++) {
            const double next = rho[i / patches] * e[i];

            if (k > 0)
                change = fmax(change, fabs(next / b[i] - 1));
            else
                change = 1;
            b[i] = next;
        }
        gather(&t, b, e, work);
        for (size_t i = 0; i < all; i++)
            e[i] += first[i];
    }
    free(first);
    free(t.opposite);
    free(t.adjacent);
    return good;
}

/* Averages over the patches of a mesh half as fine. */
static void halve(size_t n, const double *fine, double *coarse)
{
    for (size_t f = 0; f < FACES; f++)
        for (size_t i = 0; i < n; i++)
            for (size_t j = 0; j < n; j++) {
                const double *at = fine + (f * 2 * n + 2 * i) * 2 * n + 2 * j;

                coarse[(f * n + i) * n + j] = 0.25 * (at[0] + at[1] + at[2 * n] + at[2 * n + 1]);
            }
}

/* rms of a / b - 1 */
static double differ(size_t n, const double *a, const double *b)
{
    double sum = 0;

    for (size_t i = 0; i < n; i++)
        sum += (a[i] / b[i] - 1) * (a[i] / b[i] - 1);
    return sqrt(sum / (double)n);
}

int richardson_paper_room(double *values, double *order, double *left)
{
    const size_t small = FACES * COARSE * COARSE, all = 4 * small, fine = 16 * small;
    double *e = malloc((fine + all + 3 * small) * sizeof *e);
    double *middle = e + fine, *coarse = middle + all, *second = coarse + small,
           *third = second + small;
    const int good =
        e && solve(COARSE, coarse) && solve(2 * COARSE, middle) && solve(4 * COARSE, e);

    if (good) {
        double gain;

        halve(2 * COARSE, e, values);
        halve(COARSE, middle, second);
        halve(COARSE, values, third);
        gain = differ(small, coarse, second) / differ(small, second, third);
        *order = log(gain) / log(2);
        for (size_t i = 0; i < all; i++)
            middle[i] = values[i] + (values[i] - middle[i]) / (gain - 1);
        *left = differ(all, values, middle);
        memcpy(values, middle, all * sizeof *values);
    }
    free(e);
    return good;
}
