/* SPDX-License-Identifier: MIT */
#include "radiosity/occluders.h"

#include "geometry/vec.h"

#include <math.h>

enum { PLANES_MAX = 48 };

typedef struct shaft_plane { /* light crosses only where x . outward <= offset */
    double outward[3], offset, touch;
} shaft_plane;

/* Convex hull of what light may cross, as planes; not all of them are needed, since a surface is
 * only dropped when one plane has it outside. */
typedef struct shaft {
    int count;
    shaft_plane planes[PLANES_MAX];
} shaft;

/* `normal` of any length: points nearer than touch times it count as on the plane. */
static void add_plane(shaft *s, const double point[3], const double normal[3], double sign,
                      double touch)
{
    shaft_plane *p = &s->planes[s->count];

    if (s->count == PLANES_MAX)
        return;
    for (int k = 0; k < 3; k++)
        p->outward[k] = sign * normal[k];
    p->offset = vec_dot(point, p->outward);
    p->touch = touch;
    s->count++;
}

/* +1 if none of the corners is below the plane, -1 if none is above, 0 if it cuts them. */
static int side_of(const region *r, const double normal[3], double offset, double touch)
{
    int above = 0, below = 0;

    for (int i = 0; i < 4; i++) {
        const double h = vec_dot(r->corners[i], normal) - offset;

        above |= h > touch;
        below |= h < -touch;
    }
    return !below ? 1 : -!above;
}

/* Planes through edges of a and corners of b that have both on one side. */
static void add_edge_planes(shaft *s, const region *a, const region *b, double touch)
{
    for (int i = 0; i < 4; i++) {
        const double *p = a->corners[i], *q = a->corners[(i + 1) % 4];
        double edge[3];

        vec_sub(q, p, edge);
        if (!(vec_dot(edge, edge) > 0))
            continue;
        for (int j = 0; j < 4; j++) {
            double d[3], normal[3], offset, slack;
            int side;

            vec_sub(b->corners[j], p, d);
            vec_cross(edge, d, normal);
            slack = touch * vec_length(normal); /* most planes are not worth dividing for */
            offset = vec_dot(p, normal);
            side = side_of(a, normal, offset, slack);
            if (slack > 0 && side != 0 && side_of(b, normal, offset, slack) == side)
                add_plane(s, p, normal, -side, slack);
        }
    }
}

static void add_box(shaft *s, const region *a, const region *b, double touch)
{
    for (int k = 0; k < 3; k++) {
        double lo[3], hi[3], axis[3] = {0, 0, 0};

        axis[k] = 1;
        vec_copy(a->corners[0], lo);
        vec_copy(lo, hi);
        for (int i = 0; i < 4; i++) {
            lo[k] = fmin(lo[k], fmin(a->corners[i][k], b->corners[i][k]));
            hi[k] = fmax(hi[k], fmax(a->corners[i][k], b->corners[i][k]));
        }
        add_plane(s, lo, axis, -1, touch);
        add_plane(s, hi, axis, 1, touch);
    }
}

const uint32_t *occluders_of(const lcor_scene *scene, int single, size_t *count)
{
    *count = single ? scene->shapes.count : scene->blockers.count;
    return single ? scene->shapes.items : scene->blockers.items;
}

/* Whether one plane of the shaft, from number `first` on, has all of the blocker outside. */
static int outside(const shaft *s, int first, const lcor_scene *scene, uint32_t id)
{
    for (int i = first; i < s->count; i++) {
        const shaft_plane *plane = &s->planes[i];
        const double lowest = plane->offset - plane->touch;
        const scene_surface *o;
        int out = 1;

        for (size_t k = 0; out && (o = scene_blocker_part(scene, id, k)); k++) {
            const double *corners = scene_corners(scene, o);

            for (size_t j = 0; out && j < o->corner_count; j++)
                out = vec_dot(corners + 3 * j, plane->outward) >= lowest;
        }
        if (out)
            return 1;
    }
    return 0;
}

/* Whether segment p-q passes through the inside of the solid. */
static int pierces(const lcor_scene *scene, const scene_solid *solid, const double p[3],
                   const double q[3], double touch)
{
    const scene_plane *planes = (const scene_plane *)scene->planes.items + solid->first_plane;
    double from = 0, to = 1;

    for (size_t i = 0; i < solid->plane_count; i++) {
        double d[3], hp, hq;

        vec_sub(p, planes[i].point, d);
        hp = vec_dot(d, planes[i].normal) + touch;
        vec_sub(q, planes[i].point, d);
        hq = vec_dot(d, planes[i].normal) + touch;
        if (hp >= 0 && hq >= 0)
            return 0;
        if (hp > 0)
            from = fmax(from, hp / (hp - hq));
        else if (hq > 0)
            to = fmin(to, hp / (hp - hq));
    }
    return from < to;
}

/* Whether segment p-q crosses the blocker, which is convex. An end may lie on it, as corners do
 * where surfaces meet, but not both. */
static int crosses(const lcor_scene *scene, uint32_t id, const double p[3], const double q[3],
                   double touch)
{
    const scene_solid *solid = scene_solid_of(scene, id);
    const scene_surface *o = scene_blocker_part(scene, id, 0);
    const double *corners = scene_corners(scene, o);
    double d[3], hp, hq, at[3];

    if (solid)
        return pierces(scene, solid, p, q, touch);

    vec_sub(p, o->origin, d);
    hp = vec_dot(d, o->normal);
    vec_sub(q, o->origin, d);
    hq = vec_dot(d, o->normal);
    if (!((hp > touch && hq <= touch) || (hp < -touch && hq >= -touch) ||
          (hq > touch && hp <= touch) || (hq < -touch && hp >= -touch)))
        return 0;
    for (int k = 0; k < 3; k++)
        at[k] = p[k] + hp / (hp - hq) * (q[k] - p[k]);
    for (size_t i = 0; i < o->corner_count; i++) {
        const double *a = corners + 3 * i, *b = corners + 3 * ((i + 1) % o->corner_count);
        double edge[3], inward[3];

        vec_sub(b, a, edge);
        vec_cross(o->normal, edge, inward);
        (void)vec_normalize(inward);
        vec_sub(at, a, d);
        if (vec_dot(d, inward) < -touch)
            return 0;
    }
    return 1;
}

/* Of the sixteen segments between corners the blocker, which is convex, crosses: 1 all, and so
 * every one between the regions, -1 none, 0 some. */
static int blocks(const lcor_scene *scene, uint32_t id, const region *a, const region *b,
                  double touch)
{
    int crossed = 0;

    for (int i = 0; i < 16; i++) {
        crossed += crosses(scene, id, a->corners[i / 4], b->corners[i % 4], touch);
        if (crossed > 0 && crossed <= i)
            return 0;
    }
    return crossed > 0 ? 1 : -1;
}

long occluders_between(const lcor_scene *scene, const region *a, const region *b,
                       const uint32_t *in, size_t count, uint32_t *out, size_t room)
{
    const double touch = SCENE_TOUCH * scene->diameter;
    int edges = 0, box;
    long kept = 0;
    shaft s;

    s.count = 0;
    add_plane(&s, a->corners[0], a->normal, -1, touch);
    add_plane(&s, b->corners[0], b->normal, -1, touch);
    add_box(&s, a, b, touch);
    box = s.count;
    for (size_t i = 0; i < count; i++) {
        const uint32_t id = in[i];
        int block;

        if (outside(&s, 0, scene, id))
            continue;
        block = blocks(scene, id, a, b, touch);
        if (block > 0)
            return OCCLUDERS_BLOCK;
        if (block < 0 && !edges) { /* needed after all */
            edges = 1;
            add_edge_planes(&s, a, b, touch);
            add_edge_planes(&s, b, a, touch);
            if (outside(&s, box, scene, id))
                continue;
        }
        if ((size_t)kept == room)
            return OCCLUDERS_CROWD;
        out[kept++] = id;
    }
    return kept;
}

static int light_blocks(const lcor_scene *scene, uint32_t id, const lcor_light *light,
                        const region *a, double far, double touch)
{
    for (int i = 0; i < 4; i++) {
        double eye[3];

        if (light->kind == LCOR_LIGHT_DIRECTIONAL)
            vec_add_scaled(a->corners[i], -far, light->direction, eye);
        else
            vec_copy(light->position, eye);
        if (!crosses(scene, id, a->corners[i], eye, touch))
            return 0;
    }
    return 1;
}

long occluders_of_light(const lcor_scene *scene, const lcor_light *light, const region *a,
                        const uint32_t *in, size_t count, uint32_t *out, size_t room)
{
    const double touch = SCENE_TOUCH * scene->diameter;
    const int parallel = light->kind == LCOR_LIGHT_DIRECTIONAL;
    shaft s;
    long kept = 0;
    double middle[3] = {0, 0, 0};

    s.count = 0;
    for (int i = 0; i < 4; i++)
        vec_add_scaled(middle, 0.25, a->corners[i], middle);
    add_plane(&s, a->corners[0], a->normal, -1, touch);
    if (!parallel) {
        region eye;

        for (int i = 0; i < 4; i++)
            vec_copy(light->position, eye.corners[i]);
        add_plane(&s, light->position, a->normal, 1, touch);
        add_box(&s, a, &eye, touch);
    }
    for (int i = 0; i < 4; i++) {
        double edge[3], towards[3], normal[3], d[3];

        vec_sub(a->corners[(i + 1) % 4], a->corners[i], edge);
        if (parallel)
            vec_copy(light->direction, towards);
        else
            vec_sub(light->position, a->corners[i], towards);
        vec_cross(edge, towards, normal);
        if (!(vec_normalize(normal) > 0))
            continue;
        vec_sub(middle, a->corners[i], d);
        add_plane(&s, a->corners[i], normal, vec_dot(d, normal) > 0 ? -1 : 1, touch);
    }
    for (size_t i = 0; i < count; i++) {
        const uint32_t id = in[i];

        if (outside(&s, 0, scene, id))
            continue;
        if (light_blocks(scene, id, light, a, 4 * scene->diameter, touch))
            return OCCLUDERS_BLOCK;
        if ((size_t)kept == room)
            return OCCLUDERS_CROWD;
        out[kept++] = id;
    }
    return kept;
}
