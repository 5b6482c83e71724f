/* SPDX-License-Identifier: MIT */
/* Sheets: coplanar surfaces side by side that look alike and make up a parallelogram, as the tiles
 * of a wall or the two triangles of a quad do. As one surface they need the links, and the tests of
 * visibility, of one. */
#include "base/internal.h"
#include "geometry/vec.h"
#include "scene/scene_internal.h"

#include <string.h>

/* Surfaces are compared with every plane. */
static const size_t surfaces_max = 2000;

/* A surface, or the parallelogram of several. */
typedef struct part {
    size_t corner_count; /* 0: more than 4, which no pair makes a parallelogram with */
    double corners[4][3], area;
} part;

typedef struct merger {
    const lcor_scene *scene;
    double touch;
    uint32_t *plane;     /* per surface: the first one in its plane */
    uint32_t *first;     /* per surface: the first one of those it is merged with */
    part *parts;         /* per surface that is the first one */
    uint32_t *group;     /* surfaces of one plane that look alike */
    unsigned char *done; /* per surface: grouped, or not to be merged */
    double (*points)[3];
} merger;

static int is_near(const merger *m, const double a[3], const double b[3])
{
    double d[3];

    vec_sub(a, b, d);
    return vec_length(d) <= m->touch;
}

/* Whether all corners of b lie in the plane of a. */
static int holds(const merger *m, const scene_surface *a, const scene_surface *b)
{
    const double *p = scene_corners(m->scene, b);

    for (size_t i = 0; i < b->corner_count; i++) {
        double d[3];

        vec_sub(p + 3 * i, a->origin, d);
        if (fabs(vec_dot(d, a->normal)) > m->touch)
            return 0;
    }
    return 1;
}

static int coplanar(const merger *m, const scene_surface *a, const scene_surface *b)
{
    return fabs(vec_dot(a->normal, b->normal)) > 1 - 1e-6 && holds(m, a, b) && holds(m, b, a);
}

/* Whether an edge of a has all of b on its outer side; both are convex and in one plane. */
static int separates(const merger *m, const scene_surface *a, const scene_surface *b)
{
    const double *p = scene_corners(m->scene, a), *q = scene_corners(m->scene, b);

    for (size_t i = 0; i < a->corner_count; i++) {
        double edge[3], inward[3], d[3];
        int out = 1;

        vec_sub(p + 3 * ((i + 1) % a->corner_count), p + 3 * i, edge);
        vec_cross(a->normal, edge, inward);
        if (!(vec_normalize(inward) > 0))
            continue;
        for (size_t j = 0; out && j < b->corner_count; j++) {
            vec_sub(q + 3 * j, p + 3 * i, d);
            out = vec_dot(d, inward) <= m->touch;
        }
        if (out)
            return 1;
    }
    return 0;
}

int lcor_scene_look_alike(const lcor_surface *a, const lcor_surface *b)
{
    int same = !a->two_sided == !b->two_sided;

    for (int c = 0; c < 3; c++)
        same &= a->reflectance[c] == b->reflectance[c] && a->emission[c] == b->emission[c];
    return same;
}

/* Planes, and what lies on other surfaces: duplicates stay what they are. */
static void find_planes(const merger *m)
{
    for (size_t i = 0; i < m->scene->surfaces.count; i++) {
        const scene_surface *a = scene_surface_at(m->scene, i);
        size_t j = 0;

        while (j < i && !(m->plane[j] == j && coplanar(m, scene_surface_at(m->scene, j), a)))
            j++;
        m->plane[i] = (uint32_t)j;
        for (size_t k = j; k < i; k++) {
            const scene_surface *b = scene_surface_at(m->scene, k);

            if (m->plane[k] == j && !separates(m, a, b) && !separates(m, b, a))
                m->done[i] = m->done[k] = 1;
        }
    }
}

/* The next corner of the points' hull, anticlockwise from corner `from`. */
static const double *next_corner(const merger *m, const double *from, const double normal[3],
                                 size_t n)
{
    const double *best = NULL;
    double to_best[3] = {0, 0, 0}, length = 0;

    for (size_t i = 0; i < n; i++) {
        double d[3], cross[3], left;

        vec_sub(m->points[i], from, d);
        if (vec_length(d) <= m->touch)
            continue;
        vec_cross(to_best, d, cross);
        left = best ? vec_dot(cross, normal) / length : -HUGE_VAL;
        if (left < -m->touch || (left <= m->touch && vec_length(d) > length)) {
            best = m->points[i];
            vec_copy(d, to_best);
            length = vec_length(d);
        }
    }
    return best;
}

/* Whether parts of that area, which do not overlap and whose corners are the first n points, make
 * up a parallelogram: then *out is it. */
static int make_up(const merger *m, const double normal[3], size_t n, double area, part *out)
{
    const double *at = m->points[0];
    double u[3], v[3], w[3], cross[3], far = 0;

    for (size_t i = 0; i < n; i++) { /* the one farthest from anything is a corner */
        vec_sub(m->points[i], m->points[0], u);
        if (vec_length(u) > far) {
            far = vec_length(u);
            at = m->points[i];
        }
    }
    for (int i = 0; i < 4; i++) {
        vec_copy(at, out->corners[i]);
        at = next_corner(m, at, normal, n);
        if (!at)
            return 0;
    }
    vec_sub(out->corners[1], out->corners[0], u);
    vec_sub(out->corners[3], out->corners[0], v);
    vec_sub(out->corners[2], v, w);
    vec_cross(u, v, cross);
    out->corner_count = 4;
    out->area = vec_length(cross);
    return is_near(m, at, out->corners[0]) && is_near(m, w, out->corners[1]) &&
           fabs(out->area - area) <= m->touch * (vec_length(u) + vec_length(v));
}

/* All of the group at once, in whatever pieces it comes. */
static int merge_all(const merger *m, size_t count)
{
    const scene_surface *s = scene_surface_at(m->scene, m->group[0]);
    double normal[3], area = 0;
    size_t n = 0;
    part whole;

    vec_copy(s->normal, normal);
    for (size_t i = 0; i < count; i++) {
        s = scene_surface_at(m->scene, m->group[i]);
        memcpy(m->points + n, scene_corners(m->scene, s), s->corner_count * sizeof *m->points);
        n += s->corner_count;
        area += s->area;
    }
    if (!make_up(m, normal, n, area, &whole))
        return 0;
    m->parts[m->group[0]] = whole;
    for (size_t i = 0; i < count; i++)
        m->first[m->group[i]] = m->group[0];
    return 1;
}

static int merge_two(const merger *m, uint32_t a, uint32_t b, size_t count)
{
    const part *p = &m->parts[a], *q = &m->parts[b];
    part both;

    if (p->corner_count == 0 || q->corner_count == 0)
        return 0;
    memcpy(m->points, p->corners, p->corner_count * sizeof *m->points);
    memcpy(m->points + p->corner_count, q->corners, q->corner_count * sizeof *m->points);
    if (!make_up(m, scene_surface_at(m->scene, a)->normal, p->corner_count + q->corner_count,
                 p->area + q->area, &both))
        return 0;
    m->parts[a] = both;
    for (size_t i = 0; i < count; i++)
        if (m->first[m->group[i]] == b)
            m->first[m->group[i]] = a;
    return 1;
}

/* What is left of a wall around a door: two by two, as long as some fit. */
static void merge_pairs(const merger *m, size_t count)
{
    int more = 1;

    while (more) {
        more = 0;
        for (size_t i = 0; i < count; i++)
            for (size_t j = i + 1; j < count; j++) {
                const uint32_t a = m->group[i], b = m->group[j];

                if (m->first[a] == a && m->first[b] == b)
                    more |= merge_two(m, a, b, count);
            }
    }
}

static void merge(const merger *m)
{
    for (uint32_t i = 0; i < m->scene->surfaces.count; i++) {
        const scene_surface *a = scene_surface_at(m->scene, i);
        size_t count = 0;

        for (uint32_t j = i; !m->done[i] && j < m->scene->surfaces.count; j++) {
            const scene_surface *b = scene_surface_at(m->scene, j);

            if (!m->done[j] && m->plane[j] == m->plane[i] && vec_dot(a->normal, b->normal) > 0 &&
                lcor_scene_look_alike(&a->look, &b->look))
                m->group[count++] = j;
        }
        for (size_t k = 0; k < count; k++)
            m->done[m->group[k]] = 1;
        if (count > 1 && !merge_all(m, count))
            merge_pairs(m, count);
    }
}

static void start(const merger *m)
{
    for (uint32_t i = 0; i < m->scene->surfaces.count; i++) {
        const scene_surface *s = scene_surface_at(m->scene, i);
        part *p = &m->parts[i];

        m->first[i] = i;
        m->done[i] = 0;
        p->corner_count = s->corner_count <= 4 ? s->corner_count : 0;
        memcpy(p->corners, scene_corners(m->scene, s), p->corner_count * sizeof p->corners[0]);
        p->area = s->area;
    }
}

/* A quad with the corners of the part, its edges along those of the first surface as far as may be.
 */
static int add_sheet(lcor_scene *scene, const part *p, uint32_t id, size_t members)
{
    double(*corners)[3] =
        lcor_array_reserve(&scene->allocator, &scene->corners, 4, sizeof *corners);
    scene_sheet *sheet = lcor_array_reserve(&scene->allocator, &scene->sheets, 1, sizeof *sheet);
    const scene_surface *like = scene_surface_at(scene, id);
    double most = -HUGE_VAL, cross[3];
    size_t turn = 0;

    if (!corners || !sheet)
        return 0;
    for (size_t i = 0; i < 4; i++) {
        double edge[3];

        vec_sub(p->corners[(i + 1) % 4], p->corners[i], edge);
        (void)vec_normalize(edge);
        if (vec_dot(edge, like->edge_u) > most) {
            most = vec_dot(edge, like->edge_u);
            turn = i;
        }
    }
    for (size_t i = 0; i < 4; i++)
        vec_copy(p->corners[(i + turn) % 4], corners[i]);
    memset(sheet, 0, sizeof *sheet);
    sheet->shape.shape = SCENE_QUAD;
    vec_copy(corners[0], sheet->shape.origin);
    vec_sub(corners[1], corners[0], sheet->shape.edge_u);
    vec_sub(corners[3], corners[0], sheet->shape.edge_v);
    vec_cross(sheet->shape.edge_u, sheet->shape.edge_v, cross);
    sheet->shape.area = vec_normalize(cross);
    vec_copy(cross, sheet->shape.normal);
    sheet->shape.first_corner = scene->corners.count;
    sheet->shape.corner_count = 4;
    sheet->shape.look = like->look;
    sheet->first_member = scene->sheet_members.count - members;
    sheet->member_count = members;
    scene->corners.count += 4;
    scene->sheets.count++;
    return 1;
}

/* Every part in the order of first surfaces. */
static int list_shapes(lcor_scene *scene, const merger *m)
{
    const size_t n = scene->surfaces.count;
    uint32_t *shapes = lcor_array_reserve(&scene->allocator, &scene->shapes, n, sizeof *shapes);
    uint32_t *members =
        lcor_array_reserve(&scene->allocator, &scene->sheet_members, n, sizeof *members);

    if (!shapes || !members)
        return 0;
    for (uint32_t i = 0; i < n; i++) {
        const size_t before = scene->sheet_members.count;

        if (m && m->first[i] != i)
            continue;
        shapes[scene->shapes.count++] = i;
        for (uint32_t j = i; m && j < n; j++)
            if (m->first[j] == i)
                members[scene->sheet_members.count++] = j;
        if (scene->sheet_members.count <= before + 1) {
            scene->sheet_members.count = before;
            continue;
        }
        shapes[scene->shapes.count - 1] = (uint32_t)(n + scene->sheets.count);
        if (!add_sheet(scene, &m->parts[i], i, scene->sheet_members.count - before))
            return 0;
    }
    return 1;
}

int lcor_scene_find_sheets(lcor_scene *scene)
{
    const lcor_allocator *own = &scene->allocator;
    const size_t n = scene->surfaces.count;
    merger m = {.scene = scene, .touch = SCENE_TOUCH * scene->diameter};
    uint32_t *numbers;
    int good;

    scene->sheets.count = scene->sheet_members.count = scene->shapes.count = 0;
    if (n > surfaces_max)
        return list_shapes(scene, NULL);
    numbers = lcor_internal_alloc(own, 3 * n * sizeof *numbers);
    m.parts = lcor_internal_alloc(own, n * sizeof *m.parts);
    m.done = lcor_internal_alloc(own, n);
    m.points = lcor_internal_alloc(own, (scene->corners.count + 8) * sizeof *m.points);
    good = numbers && m.parts && m.done && m.points;
    if (good) {
        m.plane = numbers;
        m.first = numbers + n;
        m.group = numbers + 2 * n;
        start(&m);
        find_planes(&m);
        merge(&m);
        good = list_shapes(scene, &m);
    }
    lcor_internal_free(own, m.points);
    lcor_internal_free(own, m.done);
    lcor_internal_free(own, m.parts);
    lcor_internal_free(own, numbers);
    return good;
}
