/* SPDX-License-Identifier: MIT */
#include "radiosity/face.h"

#include "geometry/factor.h"
#include "geometry/vec.h"

#include <math.h>
#include <string.h>

/* What does not touch cuts until there are so many pieces: each costs links. */
enum { PIECES_MAX = 256, PIECES_NEAR = 32, CORNERS_MAX = LCOR_CLIP_MAX };

/* Without a finer patch grid, elements may shrink to this part of the shape. */
static const double grid_floor = 1.0 / 64;

/* Edge coordinates that are the same. */
static const double snap = 1e-9;

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

/* Whether a height above a shape counts as on it. */
static int is_near(double height, int two_sided, double gap, double touch)
{
    return fabs(height) <= touch || (fabs(height) < gap && (two_sided || height > 0));
}

/* Cuts the pieces of shape s where shape t meets its plane, and below those of its edges that are
 * nearer than `gap`: what is narrower than an element ends there as at a contact. */
static void cut_along(const lcor_scene *scene, const scene_surface *s, int two_sided, double gap,
                      const scene_surface *t, piece *pieces, size_t *count)
{
    const double touch = SCENE_TOUCH * scene->diameter;
    const double *p = scene_corners(scene, t);
    double height[CORNERS_MAX], on[2][3], above = -2 * touch, apart = 0;
    int crossings = 0;

    for (size_t i = 0; i < t->corner_count; i++) {
        double d[3];

        vec_sub(p + 3 * i, s->origin, d);
        height[i] = vec_dot(d, s->normal);
        above = fmax(above, two_sided ? fabs(height[i]) : height[i]);
        apart = fmax(apart, fabs(height[i]));
    }
    if (above <= -touch || (scene->convex && apart > touch))
        return;
    for (size_t i = 0; i < t->corner_count; i++) {
        const size_t j = (i + 1) % t->corner_count;

        if (is_near(height[i], two_sided, gap, touch) &&
            is_near(height[j], two_sided, gap, touch)) {
            double foot[2][3];

            vec_add_scaled(p + 3 * i, -height[i], s->normal, foot[0]);
            vec_add_scaled(p + 3 * j, -height[j], s->normal, foot[1]);
            cut(pieces, count, s->normal, foot[0], foot[1], touch);
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

int face_append(const lcor_allocator *allocator, lcor_array *faces, const double normal[3],
                uint32_t surface, int back, const double a[3], const double b[3], const double c[3],
                int triangle)
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
        f->normal[k] = back ? -normal[k] : normal[k];
    faces->count += (size_t)face_set(f, a, u, v, triangle);
    return 1;
}

/* A parallelogram out of a quad, if it is a rectangle of its (s, t), becomes a face in the same
 * directions. */
static int add_aligned(const lcor_allocator *allocator, lcor_array *faces, const scene_surface *q,
                       uint32_t surface, const piece *p, int *done)
{
    double s[4], t[4], s0 = 1, s1 = 0, t0 = 1, t1 = 0, o[3], b[3], c[3];

    *done = 0;
    if (q->shape != SCENE_QUAD)
        return 1;
    for (size_t i = 0; i < 4; i++) {
        lcor_scene_coordinates(q, p->p[i], &s[i], &t[i]);
        s0 = fmin(s0, s[i]);
        s1 = fmax(s1, s[i]);
        t0 = fmin(t0, t[i]);
        t1 = fmax(t1, t[i]);
    }
    for (size_t i = 0; i < 4; i++)
        if (fmin(s[i] - s0, s1 - s[i]) > snap || fmin(t[i] - t0, t1 - t[i]) > snap)
            return 1;
    *done = 1;
    vec_plane_point(q->origin, q->edge_u, q->edge_v, s0, t0, o);
    vec_plane_point(o, q->edge_u, q->edge_v, s1 - s0, 0, b);
    vec_plane_point(o, q->edge_u, q->edge_v, 0, t1 - t0, c);
    return face_append(allocator, faces, q->normal, surface, 0, o, b, c, 0);
}

int face_in_quad(const face *f, const scene_surface *quad, cell *out)
{
    double p[3], q[3], su, tu, sv, tv;

    if (f->triangle || quad->shape != SCENE_QUAD)
        return 0;
    vec_add_scaled(f->origin, 1, f->u, p);
    vec_add_scaled(f->origin, 1, f->v, q);
    lcor_scene_coordinates(quad, f->origin, &out->s0, &out->t0);
    lcor_scene_coordinates(quad, p, &su, &tu);
    lcor_scene_coordinates(quad, q, &sv, &tv);
    out->hs = su - out->s0;
    out->ht = tv - out->t0;
    return out->hs > 0 && out->ht > 0 && fabs(sv - out->s0) <= snap * out->hs &&
           fabs(tu - out->t0) <= snap * out->ht;
}

/* A triangle with a corner counted twice is none. */
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

    if (is_parallelogram(q, touch)) {
        if (!back && !add_aligned(allocator, faces, s, surface, q, &done))
            return 0;
        return done || face_append(allocator, faces, s->normal, surface, back, q->p[0], q->p[1],
                                   q->p[3], 0);
    }
    for (size_t i = 1; i + 1 < q->n; i++)
        if (!face_append(allocator, faces, s->normal, surface, back, q->p[0], q->p[i], q->p[i + 1],
                         1))
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
static double finest_of(const scene_surface *s, double patch)
{
    return 4 * fmin(patch, grid_floor * fmin(vec_length(s->edge_u), vec_length(s->edge_v)));
}

/* What face_build works on. */
typedef struct builder {
    const lcor_scene *scene;
    const lcor_allocator *allocator;
    lcor_array *faces;
    piece *pieces;
} builder;

/* The faces of a shape, which belong to `surface`, on both sides. */
static int build_shape(const builder *b, uint32_t id, const scene_surface *s, uint32_t surface,
                       double patch, face_range sides[2])
{
    const lcor_scene *scene = b->scene;
    const lcor_surface *look = &scene_surface_at(scene, surface)->look;
    const double touch = SCENE_TOUCH * scene->diameter, gap = finest_of(s, patch);
    size_t count = 1;

    b->pieces[0].n = s->corner_count;
    memcpy(b->pieces[0].p, scene_corners(scene, s), s->corner_count * sizeof b->pieces[0].p[0]);
    for (size_t j = 0; j < scene->shapes.count; j++) {
        const uint32_t other = ((const uint32_t *)scene->shapes.items)[j];

        if (other != id)
            cut_along(scene, s, look->two_sided, count < PIECES_NEAR ? gap : 0,
                      scene_shape_at(scene, other), b->pieces, &count);
    }
    for (int back = 0; back < 2; back++) {
        sides[back].begin = b->faces->count;
        for (size_t i = 0; i < count && (!back || look->two_sided); i++)
            if (!add_piece(b->allocator, b->faces, s, surface, back, &b->pieces[i], touch))
                return 0;
        sides[back].end = b->faces->count;
    }
    for (size_t i = sides[0].begin; i < sides[1].end; i++) {
        ((face *)b->faces->items)[i].finest = gap;
        ((face *)b->faces->items)[i].patch = patch;
    }
    return 1;
}

static const uint32_t *members_of(const lcor_scene *scene, const scene_sheet *sheet)
{
    return (const uint32_t *)scene->sheet_members.items + sheet->first_member;
}

/* Whether the surfaces of a sheet still look alike. */
static int is_uniform(const lcor_scene *scene, const scene_sheet *sheet)
{
    const uint32_t *member = members_of(scene, sheet);

    for (size_t i = 1; i < sheet->member_count; i++)
        if (!lcor_scene_look_alike(&scene_surface_at(scene, member[0])->look,
                                   &scene_surface_at(scene, member[i])->look))
            return 0;
    return 1;
}

static int build_sheet(const builder *b, uint32_t id, const scene_sheet *sheet, face_range *sides)
{
    const lcor_scene *scene = b->scene;
    const uint32_t *member = members_of(scene, sheet);
    const int uniform = is_uniform(scene, sheet);
    double patch = HUGE_VAL;

    for (size_t i = 0; i < sheet->member_count; i++) {
        const scene_surface *s = scene_surface_at(scene, member[i]);

        patch = fmin(patch, patch_size(s));
        if (!uniform &&
            !build_shape(b, id, s, member[i], patch_size(s), sides + 2 * (size_t)member[i]))
            return 0;
    }
    if (uniform &&
        !build_shape(b, id, &sheet->shape, member[0], patch, sides + 2 * (size_t)member[0]))
        return 0;
    for (size_t i = 1; uniform && i < sheet->member_count; i++)
        memcpy(sides + 2 * (size_t)member[i], sides + 2 * (size_t)member[0], 2 * sizeof *sides);
    return 1;
}

/* Of two faces on each other the smaller surface's is seen: a carpet, a lamp in a ceiling. */
static int is_above(const lcor_scene *scene, const face *a, const face *b)
{
    const double area = scene_surface_at(scene, a->surface)->area;
    const double other = scene_surface_at(scene, b->surface)->area;

    return area < other || (!(other < area) && a->surface < b->surface);
}

/* Faces are cut where others end on them, so the middle tells for all of a face. */
static int lies_on(const face *a, const face *b, double touch)
{
    double x[3], d[3], s, t;

    if (vec_dot(a->normal, b->normal) < 1 - snap)
        return 0;
    face_point(b, b->triangle ? 2.0 / 3 : 0.5, 0.5, x);
    vec_sub(x, a->origin, d);
    if (fabs(vec_dot(d, a->normal)) > touch)
        return 0;
    face_coordinates(a, x, &s, &t);
    return s > 0 && s < 1 && t > 0 && t < 1;
}

static void mark_covered(const lcor_scene *scene, face *faces, size_t count)
{
    const double touch = SCENE_TOUCH * scene->diameter;

    for (size_t i = 0; i < count; i++)
        for (size_t j = 0; j < count && !faces[i].covered; j++)
            faces[i].covered = faces[j].surface != faces[i].surface &&
                               lies_on(&faces[j], &faces[i], touch) &&
                               is_above(scene, &faces[j], &faces[i]);
}

const lcor_surface *face_look(const lcor_scene *scene, const face *f)
{
    static const lcor_surface dark = {0};

    return f->covered ? &dark : &scene_surface_at(scene, f->surface)->look;
}

int face_build(const lcor_scene *scene, const lcor_allocator *allocator, lcor_array *faces,
               face_range *sides)
{
    lcor_array scratch = {0};
    const builder b = {scene, allocator, faces,
                       lcor_array_reserve(allocator, &scratch, PIECES_MAX, sizeof(piece))};
    int good = b.pieces != NULL;

    for (size_t i = 0; good && i < scene->shapes.count; i++) {
        const uint32_t id = ((const uint32_t *)scene->shapes.items)[i];
        const scene_sheet *sheet = scene_sheet_of(scene, id);
        const scene_surface *s = scene_shape_at(scene, id);

        good = sheet ? build_sheet(&b, id, sheet, sides)
                     : build_shape(&b, id, s, id, patch_size(s), sides + 2 * (size_t)id);
    }
    if (good)
        mark_covered(scene, faces->items, faces->count);
    lcor_array_clear(allocator, &scratch);
    return good;
}

/* Whether the surfaces of a sheet have their faces in common. */
static int is_merged(const lcor_scene *scene, const scene_sheet *sheet, const face_range *sides)
{
    const uint32_t *member = members_of(scene, sheet);

    return sides[2 * (size_t)member[0]].begin == sides[2 * (size_t)member[1]].begin;
}

int face_still_holds(const lcor_scene *scene, const face_range *sides)
{
    for (size_t i = 0; i < scene->surfaces.count; i++)
        if ((sides[2 * i + 1].end > sides[2 * i + 1].begin) !=
            (scene_surface_at(scene, i)->look.two_sided != 0))
            return 0;
    for (size_t i = 0; i < scene->sheets.count; i++) {
        const scene_sheet *sheet = (const scene_sheet *)scene->sheets.items + i;

        if (is_merged(scene, sheet, sides) != is_uniform(scene, sheet))
            return 0;
    }
    return 1;
}

void face_count_merged(const lcor_scene *scene, const face_range *sides, uint64_t *surfaces,
                       uint64_t *into)
{
    *surfaces = *into = 0;
    for (size_t i = 0; i < scene->sheets.count; i++) {
        const scene_sheet *sheet = (const scene_sheet *)scene->sheets.items + i;

        if (is_merged(scene, sheet, sides)) {
            *surfaces += sheet->member_count;
            ++*into;
        }
    }
}
