/* SPDX-License-Identifier: MIT */
#include "geometry/factor.h"

#include "base/cpu.h"
#include "base/internal.h"
#include "geometry/vec.h"

enum { LANES = 8 };

/* An edge along the receiver's normal sees nothing of its plane: squared sine of what counts as
 * along. */
static const double along_normal = 1e-28;

static const double half_pi = 1.57079632679489661923, quarter_pi = 0.78539816339744830962;
static const double tan_eighth_pi = 0.41421356237309504880;

/* Chebyshev interpolation of atan(sqrt z) / sqrt z on 0..tan(pi/8)^2: relative error 2.3e-16. */
static const double atan_terms[12] = {
    1.0,
    -3.33333333333331205406e-01,
    1.99999999999408900608e-01,
    -1.42857142792502389561e-01,
    1.11111107449193960428e-01,
    -9.09089680905643821029e-02,
    7.69204533076591201457e-02,
    -6.66295181206183750877e-02,
    5.84687828578700080628e-02,
    -5.03510240394302935329e-02,
    3.79652560995765650520e-02,
    -1.78053957045375063628e-02,
};

/* atan2(y, x) for y >= 0, without branches so that loops over it become SIMD. */
static LCOR_INLINE double angle(double y, double x)
{
    const double ax = x < 0 ? -x : x;
    const double low = y < ax ? y : ax, high = y < ax ? ax : y;
    const int big = low > tan_eighth_pi * high;
    const double top = big ? low - high : low, bottom = big ? low + high : high;
    const double t = top / (bottom > 0 ? bottom : 1), z = t * t;
    double sum = atan_terms[11];

    for (int k = 10; k >= 0; k--)
        sum = sum * z + atan_terms[k];
    sum = t * sum + (big ? quarter_pi : 0);
    sum = y > ax ? half_pi - sum : sum;
    return x < 0 ? 2 * half_pi - sum : sum;
}

/* Contour integral over corners already relative to x and not below its plane. The angle between
 * two corners from cross and dot product keeps full precision where acos of the dot product would
 * lose half of the digits. */
static double contour(const double normal[3], size_t n, const double (*r)[3])
{
    double sum = 0;

    for (size_t i = 0; i < n; i++) {
        const double *a = r[i], *b = r[i + 1 < n ? i + 1 : 0];
        double c[3], length;

        vec_cross(a, b, c);
        length = vec_length(c);
        if (length > 0)
            sum += vec_dot(c, normal) / length * angle(length, vec_dot(a, b));
    }
    return fabs(sum) / (4 * half_pi);
}

static size_t clip(const double normal[3], size_t n, const double (*r)[3], double (*out)[3])
{
    size_t m = 0;

    for (size_t i = 0; i < n; i++) {
        const double *a = r[i], *b = r[i + 1 < n ? i + 1 : 0];
        const double ha = vec_dot(a, normal), hb = vec_dot(b, normal);

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

size_t lcor_clip_polygon(const double x[3], const double normal[3], size_t n, const double *corners,
                         double *out)
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
    int below = 0;
    size_t m;

    for (size_t i = 0; i < n; i++)
        below |= vec_dot(r[i], normal) < 0;
    if (!below)
        return contour(normal, n, (const double(*)[3])r);
    m = clip(normal, n, (const double(*)[3])r, kept);
    return m < 3 ? 0 : contour(normal, m, (const double(*)[3])kept);
}

double lcor_factor_point(const double x[3], const double normal[3], size_t n, const double *corners)
{
    double r[LCOR_CLIP_MAX][3];

    for (size_t i = 0; i < n; i++)
        vec_sub(corners + 3 * i, x, r[i]);
    return factor(normal, n, r);
}

/* Adds edge p-q of the contours around LANES points. With a the way to p, cross product and height
 * of the triangle a x b are a x edge and a . (edge x normal). */
static LCOR_INLINE void add_edge(const double px[LANES], const double py[LANES],
                                 const double pz[LANES], const double normal[3], const double p[3],
                                 const double q[3], double sum[LANES])
{
    double edge[3], m[3];

    vec_sub(q, p, edge);
    vec_cross(edge, normal, m);
    if (vec_dot(m, m) <= along_normal * vec_dot(edge, edge))
        return;
    for (int i = 0; i < LANES; i++) {
        const double ax = p[0] - px[i], ay = p[1] - py[i], az = p[2] - pz[i];
        const double bx = q[0] - px[i], by = q[1] - py[i], bz = q[2] - pz[i];
        const double cx = ay * edge[2] - az * edge[1], cy = az * edge[0] - ax * edge[2],
                     cz = ax * edge[1] - ay * edge[0];
        const double length = sqrt(cx * cx + cy * cy + cz * cz);
        const double height = ax * m[0] + ay * m[1] + az * m[2];

        sum[i] += height / (length > 0 ? length : 1) * angle(length, ax * bx + ay * by + az * bz);
    }
}

static LCOR_INLINE void factor_points(size_t n, const double *x, const double *y, const double *z,
                                      const double normal[3], const double corners[4][3],
                                      double *factors)
{
    for (size_t base = 0; base < n; base += LANES) {
        const size_t count = n - base < LANES ? n - base : LANES;
        double px[LANES], py[LANES], pz[LANES], sum[LANES];

        for (size_t i = 0; i < LANES; i++) {
            const size_t k = base + (i < count ? i : 0);

            px[i] = x[k];
            py[i] = y[k];
            pz[i] = z[k];
            sum[i] = 0;
        }
        for (int e = 0; e < 4; e++)
            add_edge(px, py, pz, normal, corners[e], corners[(e + 1) % 4], sum);
        for (size_t i = 0; i < count; i++)
            factors[base + i] = fabs(sum[i]) / (4 * half_pi);
    }
}

static void factor_points_base(size_t n, const double *x, const double *y, const double *z,
                               const double normal[3], const double corners[4][3], double *factors)
{
    factor_points(n, x, y, z, normal, corners, factors);
}

#ifdef LCOR_HAVE_X86
static __attribute__((target("avx2"))) void
factor_points_avx2(size_t n, const double *x, const double *y, const double *z,
                   const double normal[3], const double corners[4][3], double *factors)
{
    factor_points(n, x, y, z, normal, corners, factors);
}
#endif

lcor_factor_points *lcor_factor_points_at(size_t index)
{
    lcor_factor_points *found[2];
    size_t count = 0;

#ifdef LCOR_HAVE_X86
    if (lcor_internal_cpu().avx2)
        found[count++] = factor_points_avx2;
#endif
    found[count++] = factor_points_base;
    return index < count ? found[index] : NULL;
}
