/* SPDX-License-Identifier: MIT */
#include "geometry/factor.h"

#include "geometry/vec.h"

static const double pi = 3.14159265358979323846;

/* Contour integral over corners already relative to x and not below its plane. atan2 of cross and
 * dot keeps full precision where acos of the dot product would lose half of the digits. */
static double contour(const double normal[3], size_t n, const double (*r)[3])
{
    double sum = 0;

    for (size_t i = 0; i < n; i++) {
        const double *a = r[i], *b = r[i + 1 < n ? i + 1 : 0];
        double        c[3], length;

        vec_cross(a, b, c);
        length = vec_length(c);
        if (length > 0)
            sum += vec_dot(c, normal) / length * atan2(length, vec_dot(a, b));
    }
    return fabs(sum) / (2 * pi);
}

static size_t clip(const double normal[3], size_t n, const double (*r)[3], double (*out)[3])
{
    size_t m = 0;

    for (size_t i = 0; i < n; i++) {
        const double *a = r[i], *b = r[i + 1 < n ? i + 1 : 0];
        const double  ha = vec_dot(a, normal), hb = vec_dot(b, normal);

        if (ha >= 0)
            vec_copy(a, out[m++]);
        if ((ha > 0 && hb < 0) || (ha < 0 && hb > 0)) {
            const double t = ha / (ha - hb);

            for (int k = 0; k < 3; k++)
                out[m][k] = a[k] + t * (b[k] - a[k]);
            m++;
        }
    }
    return m;
}

size_t lcor_clip_polygon(const double x[3], const double normal[3], size_t n,
                         const double *corners, double *out)
{
    double r[LCOR_CLIP_MAX][3], kept[LCOR_CLIP_MAX][3];
    size_t m;

    for (size_t i = 0; i < n; i++)
        vec_sub(corners + 3 * i, x, r[i]);
    m = clip(normal, n, (const double(*)[3])r, kept);
    for (size_t i = 0; i < m; i++)
        for (int k = 0; k < 3; k++)
            out[3 * i + (size_t)k] = kept[i][k] + x[k];
    return m;
}

/* Factor of corners relative to x. Clips only when something lies below the plane. */
static double factor(const double normal[3], size_t n, double (*r)[3])
{
    double kept[LCOR_CLIP_MAX][3];
    int    below = 0;
    size_t m;

    for (size_t i = 0; i < n; i++)
        below |= vec_dot(r[i], normal) < 0;
    if (!below)
        return contour(normal, n, (const double(*)[3])r);
    m = clip(normal, n, (const double(*)[3])r, kept);
    return m < 3 ? 0 : contour(normal, m, (const double(*)[3])kept);
}

double lcor_factor_point(const double x[3], const double normal[3], size_t n,
                         const double *corners)
{
    double r[LCOR_CLIP_MAX][3];

    for (size_t i = 0; i < n; i++)
        vec_sub(corners + 3 * i, x, r[i]);
    return factor(normal, n, r);
}

double lcor_factor_point_quad(const double x[3], const double normal[3], const double origin[3],
                              const double u[3], const double v[3])
{
    double r[4][3];

    for (int k = 0; k < 3; k++) {
        r[0][k] = origin[k] - x[k];
        r[1][k] = r[0][k] + u[k];
        r[2][k] = r[1][k] + v[k];
        r[3][k] = r[0][k] + v[k];
    }
    return factor(normal, 4, r);
}
