/* SPDX-License-Identifier: MIT */
#include "radiosity/krylov.h"

#include "base/array.h"

#include <math.h>
#include <string.h>

enum { STEPS_MAX = 60 };

/* Least squares by Givens rotations, one new column at a time. */
typedef struct hessenberg {
    double h[STEPS_MAX + 1][STEPS_MAX], cosine[STEPS_MAX], sine[STEPS_MAX];
    double g[STEPS_MAX + 1];
} hessenberg;

static double product(const krylov *k, const double *a, const double *b)
{
    const size_t group = k->weight ? k->group : k->n;
    double sum = 0;

    for (size_t first = 0, i = 0; first < k->n; first += group, i++) {
        double part = 0;

        for (size_t j = first; j < first + group; j++)
            part += a[j] * b[j];
        sum += k->weight ? k->weight[i] * part : part;
    }
    return sum;
}

static void rotate(hessenberg *s, int k)
{
    double d;

    for (int j = 0; j < k; j++) {
        const double a = s->h[j][k], b = s->h[j + 1][k];

        s->h[j][k] = s->cosine[j] * a + s->sine[j] * b;
        s->h[j + 1][k] = s->cosine[j] * b - s->sine[j] * a;
    }
    d = sqrt(s->h[k][k] * s->h[k][k] + s->h[k + 1][k] * s->h[k + 1][k]);
    s->cosine[k] = d > 0 ? s->h[k][k] / d : 1;
    s->sine[k] = d > 0 ? s->h[k + 1][k] / d : 0;
    s->h[k][k] = d;
    s->g[k + 1] = -s->sine[k] * s->g[k];
    s->g[k] *= s->cosine[k];
}

/* x += V y with H y = g */
static void combine(const hessenberg *s, int steps, size_t n, const double *basis, double *x)
{
    double y[STEPS_MAX];

    for (int i = steps - 1; i >= 0; i--) {
        y[i] = s->g[i];
        for (int j = i + 1; j < steps; j++)
            y[i] -= s->h[i][j] * y[j];
        y[i] = s->h[i][i] > 0 ? y[i] / s->h[i][i] : 0;
    }
    for (int j = 0; j < steps; j++)
        for (size_t i = 0; i < n; i++)
            x[i] += y[j] * basis[(size_t)j * n + i];
}

/* One step of Arnoldi's method: v[step] makes v[step + 1]. */
static void arnoldi(const krylov *k, hessenberg *s, double *basis, int step)
{
    double *v = basis + (size_t)step * k->n, *next = v + k->n, length;

    k->map(k->arg, v, next);
    for (size_t i = 0; i < k->n; i++)
        next[i] = v[i] - next[i];
    for (int j = 0; j <= step; j++) {
        const double *u = basis + (size_t)j * k->n;

        s->h[j][step] = product(k, next, u);
        for (size_t i = 0; i < k->n; i++)
            next[i] -= s->h[j][step] * u[i];
    }
    length = sqrt(product(k, next, next));
    s->h[step + 1][step] = length;
    for (size_t i = 0; length > 0 && i < k->n; i++)
        next[i] /= length;
    rotate(s, step);
}

int krylov_solve(krylov *k, const lcor_allocator *allocator, const double *b, double *x)
{
    const int most = k->iterations < STEPS_MAX ? k->iterations : STEPS_MAX;
    const double norm = sqrt(product(k, b, b));
    lcor_array basis = {0};
    hessenberg s = {{{0}}, {0}, {0}, {0}};
    double beta, enough;
    int step = 0;

    memcpy(x, b, k->n * sizeof *x);
    k->iterations = 0;
    k->contraction = 0;
    k->bytes = 0;
    if (!(norm > 0))
        return 1;
    if (!lcor_array_reserve(allocator, &basis, k->n, sizeof *x))
        return 0;
    k->map(k->arg, b, basis.items); /* the residual of x = b */
    beta = sqrt(product(k, basis.items, basis.items));
    k->contraction = beta / norm;
    for (size_t i = 0; beta > 0 && i < k->n; i++)
        ((double *)basis.items)[i] /= beta;
    s.g[0] = beta;
    /* what is left undone is mapped too */
    enough = k->tolerance * (1 - fmin(k->contraction, 1 - 1e-6)) * norm;
    while (step < most && fabs(s.g[step]) > enough) {
        basis.count = (size_t)(step + 1) * k->n;
        if (!lcor_array_reserve(allocator, &basis, k->n, sizeof *x)) {
            lcor_array_clear(allocator, &basis);
            return 0;
        }
        arnoldi(k, &s, basis.items, step++);
    }
    combine(&s, step, k->n, basis.items, x);
    k->bytes = basis.capacity * sizeof *x;
    lcor_array_clear(allocator, &basis);
    k->iterations = step;
    return 1;
}
