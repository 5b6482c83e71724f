/* SPDX-License-Identifier: MIT */
/* What each engine would cost, so that the scene can choose. Constants are fitted to processor
 * seconds of rooms with none, one and two boxes, with walls that divide them, of Cornell boxes and
 * of the benches' scenes: mostly right within a factor of three, up to eight for either engine
 * where screens hang in mid-air. */
#include "radiosity/engine.h"

#include "geometry/vec.h"
#include "scene/scene_internal.h"

#include <math.h>

/* Links: of a pair of faces at 1 %, and for each blocker as part of that. */
static const double pair_seconds = 9e-5, blocker_share = 4.7, links_power = 0.8;
/* Light of emitting surfaces lives on elements, with its penumbrae. */
static const double penumbrae = 5;
/* More shapes than this are not compared pair by pair, nor would links be the better engine. */
enum { PAIRED_MOST = 512 };
/* Gather: at any tolerance, at 1 %, and by how many surfaces that doubles. */
static const double gather_start = 0.05, gather_seconds = 0.25, gather_power = 1.8;
static const double gather_doubles = 300;
/* Behind sheets it is dark, or light comes through slits. */
static const double sheets_factor = 3;
/* Answers of gather come no closer. */
static const double gather_least = 5e-4;

/* Whether the surface has a corner before (sign 1) or behind (-1) another one's plane. */
static int reaches(const lcor_scene *scene, const scene_surface *of, const scene_surface *plane,
                   double sign)
{
    const double *corners = scene_corners(scene, of);

    for (size_t i = 0; i < of->corner_count; i++) {
        double away[3];

        vec_sub(corners + 3 * i, plane->origin, away);
        if (sign * vec_dot(away, plane->normal) > SCENE_TOUCH * scene->diameter)
            return 1;
    }
    return 0;
}

static const scene_surface *nth_shape(const lcor_scene *scene, size_t i)
{
    return scene_shape_at(scene, ((const uint32_t *)scene->shapes.items)[i]);
}

/* Pairs of sides that are before each other, each way counted. A side is one that reflects. */
static double count_pairs(const lcor_scene *scene)
{
    double pairs = 0;

    for (size_t i = 0; i < scene->shapes.count; i++)
        for (size_t j = i + 1; j < scene->shapes.count; j++) {
            const scene_surface *a = nth_shape(scene, i), *b = nth_shape(scene, j);
            const int of_a =
                reaches(scene, b, a, 1) + (a->look.two_sided && reaches(scene, b, a, -1));
            const int of_b =
                reaches(scene, a, b, 1) + (b->look.two_sided && reaches(scene, a, b, -1));

            pairs += 2.0 * of_a * of_b;
        }
    return pairs;
}

/* Whether there is something on both sides of it. */
static int is_between(const lcor_scene *scene, const scene_surface *plane)
{
    int before = 0, behind = 0;

    for (size_t j = 0; j < scene->shapes.count && !(before && behind); j++) {
        before |= reaches(scene, nth_shape(scene, j), plane, 1);
        behind |= reaches(scene, nth_shape(scene, j), plane, -1);
    }
    return before && behind;
}

/* What can hide something: solids, and sheets, which are part of none. */
typedef struct hiding {
    double all, sheets;
} hiding;

static hiding count_hiding(const lcor_scene *scene)
{
    const uint32_t *blockers = scene->blockers.items;
    hiding count = {0, 0};

    for (size_t i = 0; i < scene->blockers.count; i++) {
        const scene_surface *part;
        int hides = 0;

        for (size_t k = 0; !hides && (part = scene_blocker_part(scene, blockers[i], k)) != NULL;
             k++)
            hides = is_between(scene, part);
        count.all += hides;
        count.sheets += hides && !scene_blocker_part(scene, blockers[i], 1);
    }
    return count;
}

static int emits(const lcor_scene *scene)
{
    for (size_t i = 0; i < scene->surfaces.count; i++) {
        const double *emission = scene_surface_at(scene, i)->look.emission;

        if (emission[0] > 0 || emission[1] > 0 || emission[2] > 0)
            return 1;
    }
    return 0;
}

void engine_costs(const lcor_scene *scene, double tolerance, double *links, double *gather)
{
    const double finer = 0.01 / tolerance, surfaces = (double)scene->surfaces.count;
    const int paired = scene->shapes.count <= PAIRED_MOST;
    hiding hides = {0, 0};

    if (paired && !scene->convex)
        hides = count_hiding(scene);
    *gather = HUGE_VAL;
    if (tolerance >= gather_least)
        *gather = gather_start + gather_seconds * (1 + surfaces / gather_doubles) *
                                     (hides.sheets > 0 ? sheets_factor : 1) *
                                     pow(finer, gather_power);
    *links = HUGE_VAL;
    if (paired)
        *links = pair_seconds * count_pairs(scene) * (1 + blocker_share * hides.all) *
                 (hides.all > 0 && emits(scene) ? penumbrae : 1) * pow(finer, links_power);
}
