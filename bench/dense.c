/* SPDX-License-Identifier: MIT */
/* Float matrix, point-to-patch kernels in loops the compiler turns into SIMD (this file is built
 * with -O3 -march=native -ffast-math), Lambert's contour integral for near patches, Jacobi
 * iteration until the change is 1e-5. */
#include "dense.h"

#include <math.h>
#include <stdlib.h>

static const float pi = 3.14159265f;
static const double light[3] = {0.3, 0.4, 0.7};
static const double rho[6] = {0.3, 0.8, 0.5, 0.5, 0.5, 0.5};
static const int normal_axis[6] = {2, 2, 0, 0, 1, 1};

typedef struct room {
    size_t n, patches, all;
    float *x[3], *b, *e, *matrix;
} room;

static double contour(const double p[3], int axis, double sign, const double corner[4][3])
{
    double sum = 0;

    for (int k = 0; k < 4; k++) {
        double a[3], b[3], c[3], length;

        for (int j = 0; j < 3; j++) {
            a[j] = corner[k][j] - p[j];
            b[j] = corner[(k + 1) % 4][j] - p[j];
        }
        c[0] = a[1] * b[2] - a[2] * b[1];
        c[1] = a[2] * b[0] - a[0] * b[2];
        c[2] = a[0] * b[1] - a[1] * b[0];
        length = sqrt(c[0] * c[0] + c[1] * c[1] + c[2] * c[2]);
        if (length > 0)
            sum += sign * c[axis] / length * atan2(length, a[0] * b[0] + a[1] * b[1] + a[2] * b[2]);
    }
    return fabs(sum) / (2 * (double)pi);
}

/* Patches of face s nearer than `limit` to p: exact. */
static void near_patches(const room *r, const double p[3], int axis, double sign, int s,
                         double limit, float *row)
{
    const int w = normal_axis[s], u = w == 0 ? 1 : 0, v = w == 2 ? 1 : 2;
    const double h = 1.0 / (double)r->n;

    if (fabs(p[w] - s % 2) >= limit)
        return;
    for (size_t i = 0; i < r->n; i++)
        for (size_t j = 0; j < r->n; j++) {
            const double at[2] = {((double)i + 0.5) * h, ((double)j + 0.5) * h};
            double corner[4][3];

            if (fabs(at[0] - p[u]) >= limit || fabs(at[1] - p[v]) >= limit)
                continue;
            for (int k = 0; k < 4; k++) {
                corner[k][w] = s % 2;
                corner[k][u] = at[0] + (k == 1 || k == 2 ? 0.5 : -0.5) * h;
                corner[k][v] = at[1] + (k >= 2 ? 0.5 : -0.5) * h;
            }
            row[i * r->n + j] = (float)contour(p, axis, sign, (const double(*)[3])corner);
        }
}

static void fill_row(const room *r, size_t i)
{
    const int s = (int)(i / r->patches), axis = normal_axis[s];
    const float sign = s % 2 ? -1 : 1, area = 1 / (float)r->patches;
    const float px = r->x[0][i], py = r->x[1][i], pz = r->x[2][i];
    const double p[3] = {(double)px, (double)py, (double)pz};

    for (int t = 0; t < 6; t++) {
        const size_t first = (size_t)t * r->patches;
        const float *x = r->x[0] + first, *y = r->x[1] + first, *z = r->x[2] + first;
        const float *mine = r->x[axis] + first, *other = r->x[normal_axis[t]] + first;
        const float from = r->x[axis][i], there = r->x[normal_axis[t]][i], side = t % 2 ? 1 : -1;
        float *row = r->matrix + i * r->all + first;

        if (t == s) {
            for (size_t j = 0; j < r->patches; j++)
                row[j] = 0;
            continue;
        }
        for (size_t j = 0; j < r->patches; j++) {
            const float dx = x[j] - px, dy = y[j] - py, dz = z[j] - pz;
            const float r2 = dx * dx + dy * dy + dz * dz;

            row[j] = sign * (mine[j] - from) * side * (other[j] - there) * (area / pi) / (r2 * r2);
        }
        near_patches(r, p, axis, (double)sign, t, 4.5 / (double)r->n, row);
    }
}

size_t dense_paper_room(size_t n, double *irradiance)
{
    room r = {n, n * n, 6 * n * n, {NULL, NULL, NULL}, NULL, NULL, NULL};
    float *store = malloc(5 * r.all * sizeof *store);
    double *direct = irradiance;

    r.matrix = malloc(r.all * r.all * sizeof *r.matrix);
    if (!store || !r.matrix) {
        free(store);
        free(r.matrix);
        return 0;
    }
    for (int k = 0; k < 3; k++)
        r.x[k] = store + (size_t)k * r.all;
    r.b = store + 3 * r.all;
    r.e = store + 4 * r.all;
    for (size_t i = 0; i < r.all; i++) {
        const int s = (int)(i / r.patches), w = normal_axis[s], u = w == 0 ? 1 : 0;
        const size_t k = i % r.patches;
        double p[3], d2 = 0;

        p[w] = s % 2;
        p[u] = ((double)(k / n) + 0.5) / (double)n;
        p[w == 2 ? 1 : 2] = ((double)(k % n) + 0.5) / (double)n;
        for (int j = 0; j < 3; j++) {
            r.x[j][i] = (float)p[j];
            d2 += (light[j] - p[j]) * (light[j] - p[j]);
        }
        direct[i] = fabs(light[w] - p[w]) / (d2 * sqrt(d2));
        r.b[i] = (float)(rho[s] * direct[i]);
    }
    for (size_t i = 0; i < r.all; i++)
        fill_row(&r, i);
    for (int pass = 0; pass < 100; pass++) {
        float change = 0, largest = 0;

        for (size_t i = 0; i < r.all; i++) {
            const float *row = r.matrix + i * r.all;
            float sum = 0;

            for (size_t j = 0; j < r.all; j++)
                sum += row[j] * r.b[j];
            r.e[i] = sum;
        }
        for (size_t i = 0; i < r.all; i++) {
            const float b = (float)(rho[i / r.patches] * (direct[i] + (double)r.e[i]));

            change = fmaxf(change, fabsf(b - r.b[i]));
            largest = fmaxf(largest, b);
            r.b[i] = b;
        }
        if (change < 1e-5f * largest)
            break;
    }
    for (size_t i = 0; i < r.all; i++)
        irradiance[i] = direct[i] + (double)r.e[i];
    free(store);
    free(r.matrix);
    return r.all * r.all * sizeof(float);
}
