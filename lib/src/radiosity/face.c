/* SPDX-License-Identifier: MIT */
#include "radiosity/face.h"

#include "geometry/factor.h"
#include "geometry/vec.h"

#include <math.h>
#include <string.h>

enum { PIECES_MAX = 256, CORNERS_MAX = LCOR_CLIP_MAX };

/* Without a finer patch grid, elements may shrink to this part of the surface. */
static const double grid_floor = 1.0 / 64;

typedef struct piece {
    size_t n;
    double p[CORNERS_MAX][3];
} piece;

void face_point(const face *f, double s, double t, double out[3])
{
    const double a = f->triangle ? s * (1 - t) : s, b = f->triangle ? s * t : t;

    vec_plane_point(f->origin, f->u, f->v, a, b, out);
}

void face_coordinates(const face *f, const double x[3], double *s, double *t)
{
    double d[3], a, b;

    vec_sub(x, f->origin, d);
    a = vec_dot(d, f->dual_u);
    b = vec_dot(d, f->dual_v);
    if (f->triangle) {
        *s = a + b;
        *t = *s > 0 ? b / *s : 0;
    } else {
        *s = a;
        *t = b;
    }
}

double face_cell_area(const face *f, const cell *c)
{
    return f->jacobian * c->hs * c->ht * (f->triangle ? c->s0 + 0.5 * c->hs : 1);
}

void face_cell_corners(const face *f, const cell *c, double corners[4][3])
{
    face_point(f, c->s0, c->t0, corners[0]);
    face_point(f, c->s0 + c->hs, c->t0, corners[1]);
    face_point(f, c->s0 + c->hs, c->t0 + c->ht, corners[2]);
    face_point(f, c->s0, c->t0 + c->ht, corners[3]);
}

static double piece_area(const piece *q, const double normal[3])
{
    double sum = 0;

    for (size_t i = 1; i + 1 < q->n; i++) {
        double a[3], b[3], c[3];

        vec_sub(q->p[i], q->p[0], a);
        vec_sub(q->p[i + 1], q->p[0], b);
        vec_cross(a, b, c);
        sum += 0.5 * vec_dot(c, normal);
    }
    return sum;
}

/* Part of segment a-b inside the convex piece, as lengths; 0 if it only touches the border. */
static double inside_length(const piece *q, const double normal[3], const double a[3],
                            const double b[3], double touch)
{
    double d[3], lo = 0, hi = 1;

    vec_sub(b, a, d);
    for (size_t i = 0; i < q->n; i++) {
        double edge[3], inward[3], r[3], h0, h1;

        vec_sub(q->p[(i + 1) % q->n], q->p[i], edge);
        vec_cross(normal, edge, inward);
        if (!(vec_normalize(inward) > 0))
            continue;
        vec_sub(a, q->p[i], r);
        h0 = vec_dot(r, inward) - touch;
        h1 = h0 + vec_dot(d, inward);
        if (h0 < 0 && h1 < 0)
            return 0;
        if (h0 < 0)
            lo = fmax(lo, h0 / (h0 - h1));
        else if (h1 < 0)
            hi = fmin(hi, h0 / (h0 - h1));
    }
    return hi > lo ? (hi - lo) * vec_length(d) : 0;
}

/* Splits every piece the segment passes through along the segment's line. */
static void cut(piece *pieces, size_t *count, const double normal[3], const double a[3],
                const double b[3], double touch)
{
    double d[3], side[3];

    vec_sub(b, a, d);
    vec_cross(normal, d, side);
    if (!(vec_normalize(side) > 0))
        return;
    for (size_t i = *count; i-- > 0 && *count < PIECES_MAX;) {
        const double back[3] = {-side[0], -side[1], -side[2]};
        const piece whole = pieces[i];
        piece left, right;

        if (whole.n + 1 >= CORNERS_MAX || inside_length(&whole, normal, a, b, touch) <= touch)
            continue;
        left.n = lcor_clip_polygon(a, side, whole.n, whole.p[0], left.p[0]);
        right.n = lcor_clip_polygon(a, back, whole.n, whole.p[0], right.p[0]);
        if (left.n < 3 || right.n < 3 || piece_area(&left, normal) < touch * touch ||
            piece_area(&right, normal) < touch * touch)
            continue;
        pieces[i] = left;
        pieces[(*count)++] = right;
    }
}

/* Cuts the pieces of surface s where surface t meets its plane. */
static void cut_along(const lcor_scene *scene, const scene_surface *s, const scene_surface *t,
                      piece *pieces, size_t *count)
{
    const double touch = SCENE_TOUCH * scene->diameter;
    const double *p = scene_corners(scene, t);
    double height[CORNERS_MAX], on[2][3], above = -2 * touch;
    int crossings = 0;

    for (size_t i = 0; i < t->corner_count; i++) {
        double d[3];

        vec_sub(p + 3 * i, s->origin, d);
        height[i] = vec_dot(d, s->normal);
        above = fmax(above, s->look.two_sided ? fabs(height[i]) : height[i]);
    }
    if (above <= -touch)
        return;
    for (size_t i = 0; i < t->corner_count; i++) {
        const size_t j = (i + 1) % t->corner_count;

        if (fabs(height[i]) <= touch && fabs(height[j]) <= touch) {
            cut(pieces, count, s->normal, p + 3 * i, p + 3 * j, touch);
        } else if ((height[i] > touch && height[j] < -touch) ||
                   (height[i] < -touch && height[j] > touch)) {
            const double part = height[i] / (height[i] - height[j]);
            double *at = on[crossings == 0 ? 0 : 1];

            for (size_t k = 0; k < 3; k++)
                at[k] = p[3 * i + k] + part * (p[3 * j + k] - p[3 * i + k]);
            crossings++;
        }
    }
    if (crossings > 1)
        cut(pieces, count, s->normal, on[0], on[1], touch);
}

int face_set(face *f, const double origin[3], const double u[3], const double v[3], int triangle)
{
    double cross[3], uu, uv, vv, det;

    vec_copy(origin, f->origin);
    vec_copy(u, f->u);
    vec_copy(v, f->v);
    f->triangle = triangle;
    vec_cross(u, v, cross);
    f->jacobian = vec_length(cross);
    uu = vec_dot(u, u);
    uv = vec_dot(u, v);
    vv = vec_dot(v, v);
    det = uu * vv - uv * uv;
    if (!(det > 0 && f->jacobian > 0))
        return 0;
    for (int k = 0; k < 3; k++) {
        f->dual_u[k] = (vv * u[k] - uv * v[k]) / det;
        f->dual_v[k] = (uu * v[k] - uv * u[k]) / det;
    }
    vec_copy(v, f->along);
    if (triangle)
        vec_sub(v, u, f->along);
    f->line = vec_normalize(f->along);
    vec_cross(cross, f->along, f->across);
    (void)vec_normalize(f->across);
    f->u_along = vec_dot(u, f->along);
    f->u_across = vec_dot(u, f->across);
    return 1;
}

/* Appends the face with corner a and edges to b and c: a triangle, or the parallelogram. */
static int add_face(const lcor_allocator *allocator, lcor_array *faces, const scene_surface *s,
                    uint32_t surface, int back, const double a[3], const double b[3],
                    const double c[3], int triangle)
{
    face *f = lcor_array_reserve(allocator, faces, 1, sizeof *f);
    double u[3], v[3];

    if (!f)
        return 0;
    memset(f, 0, sizeof *f);
    f->surface = surface;
    f->back = back;
    f->root = -1;
    vec_sub(back ? c : b, a, u);
    vec_sub(back ? b : c, a, v);
    for (int k = 0; k < 3; k++)
        f->normal[k] = back ? -s->normal[k] : s->normal[k];
    faces->count += (size_t)face_set(f, a, u, v, triangle); /* slivers without area are left out */
    return 1;
}

/* A piece of a quad that is a rectangle of its (s, t) becomes a face in the same directions. */
static int add_aligned(const lcor_allocator *allocator, lcor_array *faces, const scene_surface *q,
                       uint32_t surface, const piece *p, int *done)
{
    const double snap = 1e-9;
    double s[4], t[4], s0 = 1, s1 = 0, t0 = 1, t1 = 0, o[3], u[3], v[3];
    size_t before = faces->count;

    *done = 0;
    for (size_t i = 0; i < 4 && p->n == 4; i++) {
        lcor_scene_coordinates(q, p->p[i], &s[i], &t[i]);
        s0 = fmin(s0, s[i]);
        s1 = fmax(s1, s[i]);
        t0 = fmin(t0, t[i]);
        t1 = fmax(t1, t[i]);
    }
    for (size_t i = 0; i < 4 && p->n == 4; i++)
        if (fmin(s[i] - s0, s1 - s[i]) > snap || fmin(t[i] - t0, t1 - t[i]) > snap)
            return 1;
    if (q->shape != SCENE_QUAD || p->n != 4)
        return 1;
    vec_plane_point(q->origin, q->edge_u, q->edge_v, s0, t0, o);
    vec_plane_point(o, q->edge_u, q->edge_v, s1 - s0, 0, u);
    vec_plane_point(o, q->edge_u, q->edge_v, 0, t1 - t0, v);
    if (!add_face(allocator, faces, q, surface, 0, o, u, v, 0))
        return 0;
    if (faces->count > before) {
        face *f = (face *)faces->items + before;

        f->aligned = 1;
        f->s0 = s0;
        f->t0 = t0;
        f->hs = s1 - s0;
        f->ht = t1 - t0;
    }
    *done = 1;
    return 1;
}

static int is_parallelogram(const piece *q, double touch)
{
    double d[3];

    if (q->n != 4)
        return 0;
    for (int k = 0; k < 3; k++)
        d[k] = q->p[0][k] - q->p[1][k] + q->p[2][k] - q->p[3][k];
    return vec_length(d) <= touch;
}

static int add_piece(const lcor_allocator *allocator, lcor_array *faces, const scene_surface *s,
                     uint32_t surface, int back, const piece *q, double touch)
{
    int done = 0;

    if (!back && !add_aligned(allocator, faces, s, surface, q, &done))
        return 0;
    if (done)
        return 1;
    if (is_parallelogram(q, touch))
        return add_face(allocator, faces, s, surface, back, q->p[0], q->p[1], q->p[3], 0);
    for (size_t i = 1; i + 1 < q->n; i++)
        if (!add_face(allocator, faces, s, surface, back, q->p[0], q->p[i], q->p[i + 1], 1))
            return 0;
    return 1;
}

static double patch_size(const scene_surface *s)
{
    const double nu = (double)(s->look.patches[0] ? s->look.patches[0] : 1);
    const double nv = (double)(s->look.patches[1] ? s->look.patches[1] : 1);

    return fmin(vec_length(s->edge_u) / nu, vec_length(s->edge_v) / nv);
}

/* At a corner of a room irradiance has no limit, so splitting must end somewhere: at leaves of two
 * to four patches, with a node or two a patch. */
static double finest_of(const scene_surface *s)
{
    return 4 * fmin(patch_size(s), grid_floor * fmin(vec_length(s->edge_u), vec_length(s->edge_v)));
}

static int build_surface(const lcor_scene *scene, const lcor_allocator *allocator, size_t index,
                         piece *pieces, lcor_array *faces, size_t *first)
{
    const scene_surface *s = scene_surface_at(scene, index);
    const double touch = SCENE_TOUCH * scene->diameter;
    const size_t start = faces->count;
    size_t count = 1;

    pieces[0].n = s->corner_count;
    memcpy(pieces[0].p, scene_corners(scene, s), s->corner_count * sizeof pieces[0].p[0]);
    for (size_t j = 0; j < scene->surfaces.count && !scene->convex; j++)
        if (j != index)
            cut_along(scene, s, scene_surface_at(scene, j), pieces, &count);
    for (int back = 0; back < 2; back++) {
        first[2 * index + (size_t)back] = faces->count;
        for (size_t i = 0; i < count && (!back || s->look.two_sided); i++)
            if (!add_piece(allocator, faces, s, (uint32_t)index, back, &pieces[i], touch))
                return 0;
    }
    for (size_t i = start; i < faces->count; i++) {
        ((face *)faces->items)[i].finest = finest_of(s);
        ((face *)faces->items)[i].patch = patch_size(s);
    }
    return 1;
}

int face_build(const lcor_scene *scene, const lcor_allocator *allocator, lcor_array *faces,
               size_t *first)
{
    lcor_array scratch = {0};
    piece *pieces = lcor_array_reserve(allocator, &scratch, PIECES_MAX, sizeof *pieces);
    int good = pieces != NULL;

    for (size_t i = 0; good && i < scene->surfaces.count; i++)
        good = build_surface(scene, allocator, i, pieces, faces, first);
    first[2 * scene->surfaces.count] = faces->count;
    lcor_array_clear(allocator, &scratch);
    return good;
}
