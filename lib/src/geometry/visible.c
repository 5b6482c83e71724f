/* SPDX-License-Identifier: MIT */
#include "geometry/visible.h"

#include "geometry/vec.h"

#include <string.h>

enum { POLYGON_MAX = 44 };

static void copy(const visible_piece *from, visible_piece *to)
{
    to->n = from->n;
    to->sign = from->sign;
    memcpy(to->p, from->p, (size_t)from->n * sizeof from->p[0]);
}

int visible_is(const visible_piece *piece, int n, const double *corners)
{
    return piece->n == n && memcmp(piece->p, corners, (size_t)n * sizeof piece->p[0]) == 0;
}

double visible_area(const visible_piece *piece)
{
    double sum[3] = {0, 0, 0};

    for (int i = 1; i + 1 < piece->n; i++) {
        double a[3], b[3], c[3];

        vec_sub(piece->p[i], piece->p[0], a);
        vec_sub(piece->p[i + 1], piece->p[0], b);
        vec_cross(a, b, c);
        vec_add_scaled(sum, 1, c, sum);
    }
    return vec_length(sum);
}

int visible_start(visible_set *set, size_t n, const double *corners)
{
    if (n > VISIBLE_CORNERS)
        return 0;
    set->count = 1;
    set->pieces[0].n = (int)n;
    set->pieces[0].sign = 1;
    memcpy(set->pieces[0].p, corners, n * sizeof set->pieces[0].p[0]);
    return 1;
}

enum { CUT_NO_ROOM, CUT_DONE, CUT_NOTHING };

/* Cuts a polygon in two by a plane. Without `out`, a polygon that lies inside is not copied: then
 * CUT_NOTHING. CUT_NO_ROOM if one gets too long. */
static int cut(const visible_piece *whole, const double x[3], const double normal[3],
               visible_piece *in, visible_piece *out)
{
    const double offset = vec_dot(x, normal);
    double height[VISIBLE_CORNERS];
    int outside = 0;

    for (int i = 0; i < whole->n; i++) {
        height[i] = vec_dot(whole->p[i], normal) - offset;
        outside |= height[i] < 0;
    }
    if (!out && !outside)
        return CUT_NOTHING;
    in->n = 0;
    in->sign = whole->sign;
    if (out) {
        out->n = 0;
        out->sign = whole->sign;
    }
    for (int i = 0; i < whole->n; i++) {
        const int j = i + 1 < whole->n ? i + 1 : 0;
        const double *a = whole->p[i], *b = whole->p[j];

        if (in->n + 2 > VISIBLE_CORNERS || (out && out->n + 2 > VISIBLE_CORNERS))
            return CUT_NO_ROOM;
        if (height[i] >= 0)
            vec_copy(a, in->p[in->n++]);
        if (height[i] <= 0 && out)
            vec_copy(a, out->p[out->n++]);
        if ((height[i] > 0 && height[j] < 0) || (height[i] < 0 && height[j] > 0)) {
            const double t = height[i] / (height[i] - height[j]);
            double c[3];

            for (int k = 0; k < 3; k++)
                c[k] = a[k] + t * (b[k] - a[k]);
            vec_copy(c, in->p[in->n++]);
            if (out)
                vec_copy(c, out->p[out->n++]);
        }
    }
    return CUT_DONE;
}

void visible_clip(visible_set *set, const double x[3], const double normal[3])
{
    int kept = 0;

    for (int i = 0; i < set->count; i++) {
        visible_piece in;

        if (cut(&set->pieces[i], x, normal, &in, NULL) != CUT_DONE)
            copy(&set->pieces[i], &in);
        if (in.n >= 3)
            copy(&in, &set->pieces[kept++]);
    }
    set->count = kept;
}

/* Keeps the points where sign * (height - limit) >= 0, adds those where edges cross it. */
static int clip_heights(int n, double (*p)[3], double *height, double sign, double limit)
{
    double q[POLYGON_MAX][3], h[POLYGON_MAX];
    int m = 0;

    for (int i = 0; i < n && m + 2 <= POLYGON_MAX; i++) {
        const int j = i + 1 < n ? i + 1 : 0;
        const double a = sign * (height[i] - limit), b = sign * (height[j] - limit);

        if (a >= 0) {
            h[m] = height[i];
            vec_copy(p[i], q[m++]);
        }
        if ((a > 0 && b < 0) || (a < 0 && b > 0)) {
            for (int k = 0; k < 3; k++)
                q[m][k] = p[i][k] + a / (a - b) * (p[j][k] - p[i][k]);
            h[m++] = limit;
        }
    }
    memcpy(p, q, (size_t)m * sizeof q[0]);
    memcpy(height, h, (size_t)m * sizeof h[0]);
    return m;
}

int visible_between(const visible_view *view, size_t n, const double *corners, int count,
                    double (*out)[3])
{
    double p[POLYGON_MAX][3], height[POLYGON_MAX], top = 0, d[3];
    int m = (int)n, low = 0, high = 0;

    if (n + 4 > POLYGON_MAX)
        return -1;
    if (!view->eye.parallel) {
        vec_sub(view->eye.at, view->target, d);
        top = vec_dot(d, view->normal) - view->touch;
    }
    for (int i = 0; i < m; i++) {
        vec_copy(corners + 3 * (size_t)i, p[i]);
        vec_sub(p[i], view->target, d);
        height[i] = vec_dot(d, view->normal);
        low |= height[i] < view->touch;
        high |= !view->eye.parallel && height[i] > top;
    }
    if (low)
        m = clip_heights(m, p, height, 1, view->touch);
    if (high)
        m = clip_heights(m, p, height, -1, top);
    if (count + m > VISIBLE_POINTS)
        return -1;
    memcpy(out + count, p, (size_t)m * sizeof p[0]);
    return count + m;
}

/* Places of points on a plane across the view. */
static void project(const visible_view *view, int n, double (*points)[3], double (*flat)[2])
{
    const double *normal = view->eye.parallel ? view->eye.at : view->normal;
    double a[3] = {0, 0, 0}, b[3];
    int least = 0;

    for (int k = 1; k < 3; k++)
        if (fabs(normal[k]) < fabs(normal[least]))
            least = k;
    a[least] = 1;
    vec_cross(normal, a, b);
    vec_cross(b, normal, a);
    for (int i = 0; i < n; i++) {
        double d[3], depth = 1;

        vec_copy(points[i], d);
        if (!view->eye.parallel) {
            vec_sub(points[i], view->eye.at, d);
            depth = -vec_dot(d, normal);
        }
        flat[i][0] = vec_dot(d, a) / depth;
        flat[i][1] = vec_dot(d, b) / depth;
    }
}

static double turn(const double a[2], const double b[2], const double c[2])
{
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/* Andrew's monotone chain: puts the outline's points first and in order, returns how many. */
static int outline(const visible_view *view, int n, double (*points)[3])
{
    double flat[VISIBLE_POINTS][2], kept[VISIBLE_POINTS][3];
    int order[VISIBLE_POINTS], chain[2 * VISIBLE_POINTS], m = 0;

    project(view, n, points, flat);
    for (int i = 0; i < n; i++) {
        int j = i;

        for (; j > 0; j--) {
            const double *before = flat[order[j - 1]];

            if (before[0] < flat[i][0] || (before[0] == flat[i][0] && before[1] <= flat[i][1]))
                break;
            order[j] = order[j - 1];
        }
        order[j] = i;
    }
    for (int pass = 0; pass < 2; pass++) {
        const int base = m;

        for (int i = 0; i < n; i++) {
            const int next = order[pass == 0 ? i : n - 1 - i];

            while (m - base >= 2 && turn(flat[chain[m - 2]], flat[chain[m - 1]], flat[next]) <= 0)
                m--;
            chain[m++] = next;
        }
        m--; /* the last of one chain is the first of the other */
    }
    for (int i = 0; i < m; i++)
        vec_copy(points[chain[i]], kept[i]);
    memcpy(points, kept, (size_t)m * sizeof kept[0]);
    return m;
}

int visible_cone_add(visible_cone *cone, const visible_view *view, const double p[3],
                     const double q[3], const double inside[3])
{
    double edge[3], towards[3], d[3], depth, length, *inward = cone->inward[cone->n];

    if (cone->n == VISIBLE_EDGES)
        return -1;
    vec_sub(q, p, edge);
    if (view->eye.parallel)
        vec_copy(view->eye.at, towards);
    else
        vec_sub(view->eye.at, p, towards);
    vec_cross(towards, edge, inward);
    length = vec_length(inward); /* left as it is: only signs count */
    if (!(length > 0))
        return 1;
    vec_sub(inside, p, d);
    depth = vec_dot(d, inward);
    if (fabs(depth) <= 1e-3 * view->touch * length)
        return 0; /* seen edge-on */
    if (depth < 0)
        for (int k = 0; k < 3; k++)
            inward[k] = -inward[k];
    vec_copy(p, cone->point[cone->n++]);
    return 1;
}

int visible_cone_over(visible_cone *cone, const visible_view *view, int n, double (*points)[3],
                      int hull)
{
    double middle[3] = {0, 0, 0};

    if (n < 3)
        return 0;
    if (hull)
        n = outline(view, n, points);
    if (n < 3)
        return 0;
    if (n > VISIBLE_EDGES)
        return -1;
    for (int i = 0; i < n; i++)
        vec_add_scaled(middle, 1.0 / n, points[i], middle);
    cone->n = 0;
    for (int i = 0; i < n; i++)
        if (!visible_cone_add(cone, view, points[i], points[i + 1 < n ? i + 1 : 0], middle))
            return 0;
    return cone->n >= 3;
}

int visible_apart(const visible_piece *piece, const visible_cone *cone)
{
    for (int e = 0; e < cone->n; e++) {
        const double offset = vec_dot(cone->point[e], cone->inward[e]);
        int inside = 0;

        for (int i = 0; i < piece->n && !inside; i++)
            inside = vec_dot(piece->p[i], cone->inward[e]) > offset;
        if (!inside)
            return 1;
    }
    return 0;
}

int visible_inside(const visible_piece *piece, const visible_cone *cone, visible_piece *inside)
{
    visible_piece other;
    const visible_piece *from = piece;

    for (int e = 0; e < cone->n; e++) {
        visible_piece *to = from == inside ? &other : inside;
        const int result = cut(from, cone->point[e], cone->inward[e], to, NULL);

        if (result == CUT_NO_ROOM)
            return -1;
        if (result == CUT_DONE && to->n < 3)
            return 0;
        if (result == CUT_DONE)
            from = to;
    }
    if (from != inside)
        copy(from, inside);
    return 1;
}

int visible_subtract(visible_set *set, const visible_cone *cone)
{
    visible_set result;

    result.count = 0;
    for (int i = 0; i < set->count; i++) {
        visible_piece rest;

        if (result.count + cone->n + 1 > VISIBLE_PIECES)
            return 0;
        copy(&set->pieces[i], &rest);
        if (visible_apart(&rest, cone)) {
            copy(&rest, &result.pieces[result.count++]);
            continue;
        }
        for (int e = 0; e < cone->n && rest.n >= 3; e++) {
            visible_piece in, *out = &result.pieces[result.count];

            if (cut(&rest, cone->point[e], cone->inward[e], &in, out) == CUT_NO_ROOM)
                return 0;
            result.count += out->n >= 3;
            copy(&in, &rest);
        }
    }
    set->count = result.count;
    for (int i = 0; i < result.count; i++)
        copy(&result.pieces[i], &set->pieces[i]);
    return 1;
}
