/* SPDX-License-Identifier: MIT */
#include "radiosity/evaluate.h"

#include "geometry/vec.h"

#include <math.h>

enum { BLOCK = 64, POLYGON_MAX = 24 };

static const double gauss2[2] = {0.21132486540518711775, 0.78867513459481288225};

/* What a leaf gives to patch k of n along one axis of a quad: values of its polynomials at the
 * patch's middle, or their mean over the part of the patch it covers, times that part. */
static void axis_values(double leaf0, double leaf_size, size_t k, size_t n, lcor_value value,
                        double out[RULE_P])
{
    const double h = 1 / (double)n, low = (double)k * h, high = (double)(k + 1) * h;
    const double from = fmax(low, leaf0), to = fmin(high, leaf0 + leaf_size);

    for (int a = 0; a < RULE_P; a++)
        out[a] = 0;
    if (value == LCOR_VALUE_CENTRE) {
        const double middle = 0.5 * (low + high) - leaf0;

        if (middle >= -LINKS_ON_EDGE && middle < leaf_size - LINKS_ON_EDGE)
            rule_values(middle / leaf_size, out);
        return;
    }
    for (int g = 0; g < 2 && to > from; g++) { /* two points are exact for cubics */
        double at[RULE_P];

        rule_values((from + gauss2[g] * (to - from) - leaf0) / leaf_size, at);
        for (int a = 0; a < RULE_P; a++)
            out[a] += 0.5 * (to - from) / h * at[a];
    }
}

/* A range of rows and all columns of a quad's patches, and a face's place on the quad. */
typedef struct grid {
    const links *l;
    size_t nu, nv, row0, row1;
    lcor_value value;
    double *out;
    cell place;
} grid;

static size_t clamp_index(double x, size_t n)
{
    return x <= 0 ? 0 : x >= (double)n ? n : (size_t)x;
}

static void add_leaf(const grid *g, const links_element *e, size_t element)
{
    const int channels = g->l->channels;
    const double s0 = g->place.s0 + e->c.s0 * g->place.hs, hs = e->c.hs * g->place.hs;
    const double t0 = g->place.t0 + e->c.t0 * g->place.ht, ht = e->c.ht * g->place.ht;
    const double touch = 1e-9;
    size_t i0 = clamp_index(floor(s0 * (double)g->nu + touch), g->nu);
    size_t i1 = clamp_index(ceil((s0 + hs) * (double)g->nu - touch), g->nu);
    const size_t j0 = clamp_index(floor(t0 * (double)g->nv + touch), g->nv);
    const size_t j1 = clamp_index(ceil((t0 + ht) * (double)g->nv - touch), g->nv);

    i0 = i0 > g->row0 ? i0 : g->row0;
    i1 = i1 < g->row1 ? i1 : g->row1;
    for (size_t base = j0; base < j1 && i0 < i1; base += BLOCK) {
        const size_t n = j1 - base < BLOCK ? j1 - base : BLOCK;
        double at_t[RULE_P][BLOCK];

        for (size_t j = 0; j < n; j++) {
            double v[RULE_P];

            axis_values(t0, ht, base + j, g->nv, g->value, v);
            for (int b = 0; b < RULE_P; b++)
                at_t[b][j] = v[b];
        }
        for (size_t i = i0; i < i1; i++) {
            double at_s[RULE_P];

            axis_values(s0, hs, i, g->nu, g->value, at_s);
            for (int c = 0; c < channels; c++) {
                const double *in = links_channel(g->l, &g->l->irradiance, element, c);
                double *out = g->out + ((i - g->row0) * g->nv + base) * (size_t)channels + c;
                double column[RULE_P] = {0}, sum[BLOCK];

                for (int k = 0; k < RULE_Q; k++)
                    column[k % RULE_P] += at_s[k / RULE_P] * in[k];
                for (size_t j = 0; j < n; j++)
                    sum[j] = column[0] * at_t[0][j] + column[1] * at_t[1][j] +
                             column[2] * at_t[2][j] + column[3] * at_t[3][j];
                for (size_t j = 0; j < n; j++)
                    out[j * (size_t)channels] += sum[j];
            }
        }
    }
}

static void add_tree(const grid *g, size_t element)
{
    const links_element *e = links_at(g->l, element);
    const double s0 = g->place.s0 + e->c.s0 * g->place.hs, s1 = s0 + e->c.hs * g->place.hs;
    const double t0 = g->place.t0 + e->c.t0 * g->place.ht, t1 = t0 + e->c.ht * g->place.ht;

    if (s1 * (double)g->nu < (double)g->row0 || s0 * (double)g->nu > (double)g->row1 || t1 < 0 ||
        t0 > 1)
        return;
    if (e->child < 0) {
        add_leaf(g, e, element);
        return;
    }
    add_tree(g, (size_t)e->child);
    add_tree(g, (size_t)e->child + 1);
}

/* A convex polygon in a face's affine coordinates. */
typedef struct polygon {
    int n;
    double p[POLYGON_MAX][2];
} polygon;

/* Keeps a x + b y >= c. */
static void cut(polygon *q, double a, double b, double c)
{
    polygon out = {0, {{0}}};

    for (int i = 0; i < q->n && out.n + 2 <= POLYGON_MAX; i++) {
        const double *p = q->p[i], *r = q->p[i + 1 < q->n ? i + 1 : 0];
        const double hp = a * p[0] + b * p[1] - c, hr = a * r[0] + b * r[1] - c;

        if (hp >= 0) {
            out.p[out.n][0] = p[0];
            out.p[out.n++][1] = p[1];
        }
        if ((hp > 0 && hr < 0) || (hp < 0 && hr > 0)) {
            out.p[out.n][0] = p[0] + hp / (hp - hr) * (r[0] - p[0]);
            out.p[out.n++][1] = p[1] + hp / (hp - hr) * (r[1] - p[1]);
        }
    }
    *q = out;
}

/* The side of the line through the face where a parameter is at most, or at least, m. */
static void cut_parameter(polygon *q, const face *f, int axis, double m, int below)
{
    const double sign = below ? -1 : 1;

    if (axis == 0)
        cut(q, sign, f->triangle ? sign : 0, sign * m);
    else if (f->triangle) /* b = m (a + b) */
        cut(q, -sign * m, sign * (1 - m), 0);
    else
        cut(q, 0, sign, sign * m);
}

/* Integral over the polygon within a leaf, in units of the face's jacobian. */
static void add_integral(const links *l, const face *f, size_t element, const polygon *q,
                         double *out)
{
    const links_element *e = links_at(l, element);

    for (int i = 1; i + 1 < q->n; i++) {
        const double ax = q->p[i][0] - q->p[0][0], ay = q->p[i][1] - q->p[0][1];
        const double bx = q->p[i + 1][0] - q->p[i][0], by = q->p[i + 1][1] - q->p[i][1];
        const double area2 = fabs(ax * by - ay * bx);

        for (int k = 0; k < RULE_Q; k++) {
            const double x = rule_x[k / RULE_P], y = x * rule_x[k % RULE_P];
            const double a = q->p[0][0] + x * ax + y * bx, b = q->p[0][1] + x * ay + y * by;
            const double s = f->triangle ? a + b : a, t = f->triangle ? (s > 0 ? b / s : 0) : b;
            const double w = area2 * x * rule_w[k / RULE_P] * rule_w[k % RULE_P];
            double at_s[RULE_P], at_t[RULE_P];

            rule_values((s - e->c.s0) / e->c.hs, at_s);
            rule_values((t - e->c.t0) / e->c.ht, at_t);
            for (int c = 0; c < l->channels; c++)
                out[c] +=
                    w * rule_interpolate(links_channel(l, &l->irradiance, element, c), at_s, at_t);
        }
    }
}

static void descend(const links *l, const face *f, size_t element, polygon q, double *out)
{
    const links_element *e = links_at(l, element);

    if (q.n < 3)
        return;
    if (e->child < 0) {
        add_integral(l, f, element, &q, out);
        return;
    }
    for (int h = 0; h < 2; h++) {
        polygon part = q;
        const double m = e->axis == 0 ? e->c.s0 + 0.5 * e->c.hs : e->c.t0 + 0.5 * e->c.ht;

        cut_parameter(&part, f, e->axis, m, h == 0);
        descend(l, f, (size_t)e->child + (size_t)h, part, out);
    }
}

/* Average over any patch of a surface whose pieces lie anyhow. */
static void add_average(const links *l, const scene_surface *s, size_t surface,
                        const scene_patch *p, double *out)
{
    double cross[3], area2 = 0, sum[3] = {0};

    vec_cross(s->edge_u, s->edge_v, cross);
    for (int c = 0; c < p->corner_count; c++) {
        const int d = c + 1 < p->corner_count ? c + 1 : 0;

        area2 += p->s[c] * p->t[d] - p->s[d] * p->t[c];
    }
    for (size_t i = l->sides[2 * surface].begin; i < l->sides[2 * surface].end; i++) {
        const face *f = (const face *)l->faces.items + i;
        polygon q = {p->corner_count, {{0}}};
        double part[3] = {0};

        for (int c = 0; c < p->corner_count; c++) {
            double x[3], d[3];

            vec_plane_point(s->origin, s->edge_u, s->edge_v, p->s[c], p->t[c], x);
            vec_sub(x, f->origin, d);
            q.p[c][0] = vec_dot(d, f->dual_u);
            q.p[c][1] = vec_dot(d, f->dual_v);
        }
        cut(&q, 1, 0, 0);
        cut(&q, 0, 1, 0);
        if (f->triangle) {
            cut(&q, -1, -1, -1);
        } else {
            cut(&q, -1, 0, -1);
            cut(&q, 0, -1, -1);
        }
        descend(l, f, (size_t)f->root, q, part);
        for (int c = 0; c < l->channels; c++)
            sum[c] += part[c] * f->jacobian;
    }
    for (int c = 0; c < l->channels; c++)
        out[c] += sum[c] / (0.5 * area2 * vec_length(cross));
}

/* Face of a surface's side that holds the point, or the nearest. */
static const face *face_at(const links *l, size_t surface, int back, const double x[3], double *s,
                           double *t)
{
    const face_range *side = &l->sides[2 * surface + (size_t)back];
    const face *best = NULL;
    double least = HUGE_VAL;

    for (size_t i = side->begin; i < side->end; i++) {
        const face *f = (const face *)l->faces.items + i;
        double a, b, out;

        face_coordinates(f, x, &a, &b);
        out = fmax(fmax(-a, a - 1), fmax(-b, b - 1));
        if (out < least) {
            least = out;
            best = f;
            *s = fmin(1, fmax(0, a));
            *t = fmin(1, fmax(0, b));
        }
    }
    return best;
}

static void add_at(const links *l, const face *f, double s, double t, double *out)
{
    double u, v, at_s[RULE_P], at_t[RULE_P];
    const size_t leaf = links_leaf_at(l, f, s, t, &u, &v);

    rule_values(u, at_s);
    rule_values(v, at_t);
    for (int c = 0; c < l->channels; c++)
        out[c] += rule_interpolate(links_channel(l, &l->irradiance, leaf, c), at_s, at_t);
}

static int all_in_quad(const links *l, const scene_surface *s, const face_range *side)
{
    cell place;

    for (size_t i = side->begin; i < side->end; i++)
        if (!face_in_quad((const face *)l->faces.items + i, s, &place))
            return 0;
    return 1;
}

void links_patches(const links *l, size_t surface, lcor_value value, size_t first, size_t count,
                   double *out)
{
    const scene_surface *s = scene_surface_at(l->scene, surface);
    const face_range *side = &l->sides[2 * surface];

    if (all_in_quad(l, s, side)) {
        const size_t nu = s->look.patches[0] ? s->look.patches[0] : 1;
        const size_t nv = s->look.patches[1] ? s->look.patches[1] : 1;
        grid g = {l, nu, nv, first / nv, (first + count) / nv, value, out, {0, 0, 0, 0}};

        for (size_t i = side->begin; i < side->end; i++) {
            const face *f = (const face *)l->faces.items + i;

            (void)face_in_quad(f, s, &g.place);
            add_tree(&g, (size_t)f->root);
        }
        return;
    }
    for (size_t i = 0; i < count; i++) {
        scene_patch p;
        double a = 0, b = 0, x[3], u, v;
        const face *f;

        lcor_scene_patch(l->scene, s, first + i, &p);
        if (value == LCOR_VALUE_AVERAGE) {
            add_average(l, s, surface, &p, out + i * (size_t)l->channels);
            continue;
        }
        for (int c = 0; c < p.corner_count; c++) {
            a += p.s[c] / p.corner_count;
            b += p.t[c] / p.corner_count;
        }
        vec_plane_point(s->origin, s->edge_u, s->edge_v, a, b, x);
        f = face_at(l, surface, 0, x, &u, &v);
        if (f)
            add_at(l, f, u, v, out + i * (size_t)l->channels);
    }
}

void links_point(const links *l, const double x[3], const double normal[3], uint32_t surface,
                 double accuracy, double *out)
{
    const face *f = NULL;
    double s, t;

    if (surface != LCOR_BVH_NONE)
        f = face_at(l, surface, vec_dot(normal, scene_surface_at(l->scene, surface)->normal) < 0, x,
                    &s, &t);
    if (f) {
        for (int c = 0; c < l->channels; c++)
            out[c] = 0;
        add_at(l, f, s, t, out);
    } else {
        links_gather(l, x, normal, surface, accuracy, 10 * l->floor, out);
    }
}
