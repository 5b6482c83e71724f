/* SPDX-License-Identifier: MIT */
/* Whether a scene is convex. Every corner would have to be compared with the plane of every
 * surface; boxes around runs of corners, and boxes around two of these, tell most of it at once.
 */
#include "base/internal.h"
#include "geometry/vec.h"
#include "scene/scene_internal.h"

#include <float.h>

enum { RUN = 16 }; /* corners in a box at the bottom */

typedef struct box {
    double lo[3], hi[3];
} box;

/* Box 1 is the root, those of box i are 2 i and 2 i + 1; the runs' are `runs` and on. */
typedef struct boxes {
    const double *corners;
    size_t count, runs;
    box *box;
} boxes;

static void box_add(box *b, const double lo[3], const double hi[3])
{
    for (int k = 0; k < 3; k++) {
        b->lo[k] = lo[k] < b->lo[k] ? lo[k] : b->lo[k];
        b->hi[k] = hi[k] > b->hi[k] ? hi[k] : b->hi[k];
    }
}

static int make_boxes(const lcor_scene *scene, boxes *b)
{
    const box empty = {{DBL_MAX, DBL_MAX, DBL_MAX}, {-DBL_MAX, -DBL_MAX, -DBL_MAX}};

    b->corners = scene->corners.items;
    b->count = scene->corners.count;
    for (b->runs = 1; b->runs * RUN < b->count;)
        b->runs *= 2;
    b->box = lcor_internal_alloc(&scene->allocator, 2 * b->runs * sizeof *b->box);
    if (!b->box)
        return 0;
    for (size_t i = 0; i < 2 * b->runs; i++)
        b->box[i] = empty;
    for (size_t j = 0; j < b->count; j++)
        box_add(&b->box[b->runs + j / RUN], b->corners + 3 * j, b->corners + 3 * j);
    for (size_t i = 2 * b->runs - 1; i > 1; i--)
        box_add(&b->box[i / 2], b->box[i].lo, b->box[i].hi);
    return 1;
}

/* Whether a corner in box `at` lies lower than `least` over the surface's plane. Rounding is
 * monotonic: no corner is found lower than its boxes. */
static int any_below(const boxes *b, size_t at, const scene_surface *s, double least)
{
    double d[3];

    for (int k = 0; k < 3; k++)
        d[k] = (s->normal[k] > 0 ? b->box[at].lo[k] : b->box[at].hi[k]) - s->origin[k];
    if (!(vec_dot(d, s->normal) < least))
        return 0;
    if (at < b->runs)
        return any_below(b, 2 * at, s, least) || any_below(b, 2 * at + 1, s, least);
    for (size_t j = (at - b->runs) * RUN; j < b->count && j < (at - b->runs + 1) * RUN; j++) {
        vec_sub(b->corners + 3 * j, s->origin, d);
        if (vec_dot(d, s->normal) < least)
            return 1;
    }
    return 0;
}

static int are_same(const double a[3], const double b[3])
{
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

int lcor_scene_find_convex(lcor_scene *scene)
{
    const double least = -SCENE_TOUCH * scene->diameter;
    const scene_surface *before = NULL;
    boxes b;

    if (!make_boxes(scene, &b))
        return 0;
    scene->convex = 1;
    for (size_t i = 0; i < scene->surfaces.count && scene->convex; i++) {
        const scene_surface *s = scene_surface_at(scene, i);
        double d[3];

        /* Walls of many tiles or triangles lie in one plane: it is looked at once. */
        if (before && are_same(s->normal, before->normal)) {
            vec_sub(s->origin, before->origin, d);
            if (vec_dot(d, s->normal) == 0)
                continue;
        }
        before = s;
        scene->convex = !any_below(&b, 1, s, least);
    }
    lcor_internal_free(&scene->allocator, b.box);
    return 1;
}
