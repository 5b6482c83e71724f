/* SPDX-License-Identifier: MIT */
/* What each engine would cost, so that the scene can choose. Constants are fitted to processor
 * seconds of rooms with none, one and two boxes, with a screen, and of the benches' scenes: mostly
 * right within a factor of three, ten times too low for gather in slits that trap light. */
#include "radiosity/engine.h"

#include "geometry/vec.h"
#include "scene/scene_internal.h"

#include <math.h>

/* Links: of a pair of faces at 1 %, and for each blocker as part of that. */
static const double pair_seconds = 9e-5, blocker_share = 4.7, links_power = 0.8;
/* More shapes than this are not compared pair by pair, nor would links be the better engine. */
enum { PAIRED_MOST = 512 };
/* Gather: at any tolerance, at 1 %, and by how many surfaces that doubles. */
static const double gather_start = 0.05, gather_seconds = 0.25, gather_power = 1.8;
static const double gather_doubles = 300;
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

/* Solids and shapes with something on both sides: those can hide. */
static double count_blockers(const lcor_scene *scene)
{
    const uint32_t *blockers = scene->blockers.items;
    double count = 0;

    for (size_t i = 0; i < scene->blockers.count; i++) {
        const scene_surface *part;
        int hides = 0;

        for (size_t k = 0; !hides && (part = scene_blocker_part(scene, blockers[i], k)) != NULL;
             k++) {
            int before = 0, behind = 0;

            for (size_t j = 0; j < scene->shapes.count && !(before && behind); j++) {
                before |= reaches(scene, nth_shape(scene, j), part, 1);
                behind |= reaches(scene, nth_shape(scene, j), part, -1);
            }
            hides = before && behind;
        }
        count += hides;
    }
    return count;
}

void engine_costs(const lcor_scene *scene, double tolerance, double *links, double *gather)
{
    const double finer = 0.01 / tolerance, surfaces = (double)scene->surfaces.count;

    *gather = HUGE_VAL;
    if (tolerance >= gather_least)
        *gather = gather_start +
                  gather_seconds * (1 + surfaces / gather_doubles) * pow(finer, gather_power);
    *links = HUGE_VAL;
    if (scene->shapes.count <= PAIRED_MOST)
        *links = pair_seconds * count_pairs(scene) *
                 (1 + (scene->convex ? 0 : blocker_share * count_blockers(scene))) *
                 pow(finer, links_power);
}
