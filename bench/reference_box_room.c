/* SPDX-License-Identifier: MIT */
/* Makes tests/data/reference/box_room_50x50.csv: irradiance averages of some patches of the paper's
 * room with a box on its floor, by path tracing that shares no code with the library.
 *
 *   reference_box_room PATHS > box_room_50x50.csv
 *
 * Room 0..1 cubed, reflectance floor 0.3, ceiling 0.8, walls 0.5; point light of intensity 1 at
 * (0.3, 0.4, 0.7); box 0.45..0.75 x 0.2..0.5 x 0..0.4 of reflectance 0.5. Faces, i and j as in
 * paper_room_50x50.csv. What the box stands on is dark. */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

static const double box_low[3] = {0.45, 0.2, 0}, box_high[3] = {0.75, 0.5, 0.4};
static const double light[3] = {0.3, 0.4, 0.7};
static const double pi = 3.14159265358979323846;

static uint64_t state = 88172645463325252u;

static double uniform(void) /* xorshift64* */
{
    state ^= state >> 12;
    state ^= state << 25;
    state ^= state >> 27;
    return (double)((state * 2685821657736338717u) >> 11) * 0x1p-53;
}

/* Where the ray enters the box, or a negative number. */
static double enter_box(const double o[3], const double d[3], int *axis)
{
    double near = 0, far = 1e30;

    *axis = -1;
    for (int k = 0; k < 3; k++) {
        double a = (box_low[k] - o[k]) / d[k], b = (box_high[k] - o[k]) / d[k];

        if (a > b) {
            const double swap = a;

            a = b;
            b = swap;
        }
        if (a > near) {
            near = a;
            *axis = k;
        }
        far = b < far ? b : far;
    }
    return *axis >= 0 && near < far ? near : -1;
}

static double direct(const double x[3], const double n[3])
{
    double d[3], r2 = 0, cosine = 0, t;
    int axis;

    for (int k = 0; k < 3; k++) {
        d[k] = light[k] - x[k];
        r2 += d[k] * d[k];
        cosine += d[k] * n[k];
    }
    if (cosine <= 0)
        return 0;
    t = enter_box(x, d, &axis);
    return t > 1e-9 && t < 1 ? 0 : cosine / (r2 * sqrt(r2));
}

/* Indirect irradiance along one path, by next event estimation at every bounce. */
static double path(const double start[3], const double normal[3])
{
    double x[3] = {start[0], start[1], start[2]}, n[3] = {normal[0], normal[1], normal[2]};
    double weight = 1, sum = 0;

    for (int bounce = 0; bounce < 60; bounce++) {
        const double phi = 2 * pi * uniform(), r2 = uniform(), r = sqrt(r2);
        const double local[3] = {r * cos(phi), r * sin(phi), sqrt(1 - r2)};
        const int k = fabs(n[0]) > 0.5 ? 0 : fabs(n[1]) > 0.5 ? 1 : 2;
        double d[3], t = 1e30, hit, rho;
        int axis = 0, box_axis;

        d[k] = n[k] * local[2];
        d[(k + 1) % 3] = local[0];
        d[(k + 2) % 3] = local[1];
        for (int j = 0; j < 3; j++) {
            const double wall = ((d[j] > 0) - x[j]) / d[j];

            if (wall < t) {
                t = wall;
                axis = j;
            }
        }
        hit = enter_box(x, d, &box_axis);
        for (int j = 0; j < 3; j++)
            n[j] = 0;
        if (hit > 1e-9 && hit < t) {
            t = hit;
            axis = box_axis;
            rho = 0.5;
        } else {
            rho = axis < 2 ? 0.5 : d[2] > 0 ? 0.8 : 0.3;
        }
        n[axis] = d[axis] > 0 ? -1 : 1;
        for (int j = 0; j < 3; j++)
            x[j] += t * d[j];
        weight *= rho;
        sum += weight * direct(x, n);
        if (bounce >= 3) {
            if (uniform() >= 0.6)
                break;
            weight /= 0.6;
        }
    }
    return sum;
}

static void patch(int face, int i, int j, long paths)
{
    static const char *const names[] = {"floor", "ceiling", "x0", "x1", "y0", "y1"};
    static const int axes[] = {2, 2, 0, 0, 1, 1};
    const int axis = axes[face], side = face % 2;
    const int u = axis == 0 ? 1 : 0, v = axis == 2 ? 1 : 2;
    double sum = 0, square = 0, mean;
    const int strata = 64;

    for (long p = 0; p < paths; p++) {
        /* Positions stratified, so that the direct light adds little noise. */
        const long cell = p % (strata * strata);
        double x[3], n[3] = {0, 0, 0}, value = 0;

        x[axis] = side;
        x[u] = (i + ((double)(cell / strata) + uniform()) / strata) / 50;
        x[v] = (j + ((double)(cell % strata) + uniform()) / strata) / 50;
        n[axis] = side ? -1 : 1;
        if (face != 0 || x[0] < box_low[0] || x[0] > box_high[0] || x[1] < box_low[1] ||
            x[1] > box_high[1])
            value = direct(x, n) + path(x, n);
        sum += value;
        square += value * value;
    }
    mean = sum / (double)paths;
    printf("%s,%d,%d,%.8g,%.2g\n", names[face], i, j, mean,
           sqrt(fmax(0, square / (double)paths - mean * mean) / (double)paths));
}

int main(int argc, char **argv)
{
    const long paths = argc > 1 ? atol(argv[1]) : 0;

    if (paths <= 0) {
        fprintf(stderr, "usage: reference_box_room PATHS\n");
        return 2;
    }
    printf("face,i,j,E_avg,sigma\n");
    for (int k = 0; k < 360; k++) /* anywhere */
        patch(k % 6, (int)(50 * uniform()), (int)(50 * uniform()), paths);
    for (int k = 0; k < 120; k++) /* the floor around the box, cut patches and shadow edges */
        patch(0, 20 + (int)(20 * uniform()), 7 + (int)(21 * uniform()), paths);
    for (int k = 0; k < 60; k++) /* walls in the box's shadow, near the floor */
        patch(k % 2 ? 4 : 3, (int)(50 * uniform()), (int)(12 * uniform()), paths);
    return 0;
}
