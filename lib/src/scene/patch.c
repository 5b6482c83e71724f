/* SPDX-License-Identifier: MIT */
/* Patches: the grid on which results are asked for. */
#include "base/internal.h"
#include "geometry/vec.h"
#include "scene/scene_internal.h"

void lcor_scene_coordinates(const scene_surface *surface, const double point[3], double *s,
                            double *t)
{
    const double *u = surface->edge_u, *v = surface->edge_v;
    const double uu = vec_dot(u, u), uv = vec_dot(u, v), vv = vec_dot(v, v);
    const double det = uu * vv - uv * uv;
    double d[3], du, dv;

    vec_sub(point, surface->origin, d);
    du = vec_dot(d, u);
    dv = vec_dot(d, v);
    *s = (vv * du - uv * dv) / det;
    *t = (uu * dv - uv * du) / det;
}

size_t lcor_scene_patch_grid(const scene_surface *surface)
{
    const size_t nu = surface->look.patches[0], nv = surface->look.patches[1];
    const size_t n = nu > nv ? nu : nv;

    return n ? n : 1;
}

size_t lcor_scene_patches_of(const scene_surface *surface)
{
    const size_t nu = surface->look.patches[0], nv = surface->look.patches[1];
    const size_t n = lcor_scene_patch_grid(surface);

    switch (surface->shape) {
    case SCENE_QUAD: return (nu ? nu : 1) * (nv ? nv : 1);
    case SCENE_TRIANGLE: return n * n;
    case SCENE_POLYGON: break;
    }
    return n * n * (surface->corner_count - 2);
}

/* Patch k of the n * n in the unit triangle. Row i, between s = i/n and (i+1)/n, holds upright and
 * inverted ones in turn; 2 n i - i^2 come before it. */
static void triangle_patch(size_t n, size_t k, scene_patch *out)
{
    const double h = 1.0 / (double)n;
    size_t i = 0, j;

    while (2 * n * (i + 1) - (i + 1) * (i + 1) <= k)
        i++;
    k -= 2 * n * i - i * i;
    j = k / 2;
    out->corner_count = 3;
    if (k % 2 == 0) {
        const double s[3] = {(double)i, (double)(i + 1), (double)i};
        const double t[3] = {(double)j, (double)j, (double)(j + 1)};

        for (int c = 0; c < 3; c++) {
            out->s[c] = s[c] * h;
            out->t[c] = t[c] * h;
        }
    } else {
        const double s[3] = {(double)(i + 1), (double)(i + 1), (double)i};
        const double t[3] = {(double)j, (double)(j + 1), (double)(j + 1)};

        for (int c = 0; c < 3; c++) {
            out->s[c] = s[c] * h;
            out->t[c] = t[c] * h;
        }
    }
}

static void quad_patch(const scene_surface *surface, size_t k, scene_patch *out)
{
    const size_t nu = surface->look.patches[0] ? surface->look.patches[0] : 1;
    const size_t nv = surface->look.patches[1] ? surface->look.patches[1] : 1;
    const double s0 = (double)(k / nv) / (double)nu, s1 = (double)(k / nv + 1) / (double)nu;
    const double t0 = (double)(k % nv) / (double)nv, t1 = (double)(k % nv + 1) / (double)nv;
    const double s[4] = {s0, s1, s1, s0}, t[4] = {t0, t0, t1, t1};

    out->corner_count = 4;
    for (int c = 0; c < 4; c++) {
        out->s[c] = s[c];
        out->t[c] = t[c];
    }
}

void lcor_scene_patch(const lcor_scene *scene, const scene_surface *surface, size_t index,
                      scene_patch *out)
{
    const size_t n = lcor_scene_patch_grid(surface);
    const double *p = scene_corners(scene, surface);
    double s1, t1, s2, t2;

    if (surface->shape == SCENE_QUAD) {
        quad_patch(surface, index, out);
        return;
    }
    triangle_patch(n, index % (n * n), out);
    if (surface->shape == SCENE_TRIANGLE)
        return;
    p += 3 * (index / (n * n));
    lcor_scene_coordinates(surface, p + 3, &s1, &t1);
    lcor_scene_coordinates(surface, p + 6, &s2, &t2);
    for (int c = 0; c < 3; c++) {
        const double a = out->s[c], b = out->t[c];

        out->s[c] = a * s1 + b * s2;
        out->t[c] = a * t1 + b * t2;
    }
}

lcor_status lcor_scene_patch_count(const lcor_scene *scene, size_t surface, size_t *count,
                                   lcor_error *err)
{
    if (!scene || !count || surface >= scene->surfaces.count)
        return lcor_internal_fail(err, LCOR_ERR_ARG, (long)surface, "surface %lu: there is none",
                                  (unsigned long)surface);
    *count = lcor_scene_patches_of(scene_surface_at(scene, surface));
    return LCOR_OK;
}

lcor_status lcor_scene_patch_geometry(const lcor_scene *scene, size_t surface, double *centres,
                                      double *areas, double normal[3], lcor_error *err)
{
    const scene_surface *s;
    size_t count;
    double cross[3], unit;

    if (!scene || !scene->committed || surface >= scene->surfaces.count)
        return lcor_internal_fail(err, LCOR_ERR_ARG, (long)surface,
                                  "surface %lu: there is none, or the scene is not committed",
                                  (unsigned long)surface);
    s = scene_surface_at(scene, surface);
    count = lcor_scene_patches_of(s);
    vec_cross(s->edge_u, s->edge_v, cross);
    unit = vec_length(cross);
    if (normal)
        vec_copy(s->normal, normal);
    for (size_t i = 0; i < count; i++) {
        scene_patch patch;
        double a = 0, b = 0, area = 0;

        lcor_scene_patch(scene, s, i, &patch);
        for (int c = 0; c < patch.corner_count; c++) {
            const int d = c + 1 < patch.corner_count ? c + 1 : 0;

            a += patch.s[c] / patch.corner_count;
            b += patch.t[c] / patch.corner_count;
            area += 0.5 * (patch.s[c] * patch.t[d] - patch.s[d] * patch.t[c]);
        }
        if (centres)
            vec_plane_point(s->origin, s->edge_u, s->edge_v, a, b, centres + 3 * i);
        if (areas)
            areas[i] = area * unit;
    }
    return LCOR_OK;
}
