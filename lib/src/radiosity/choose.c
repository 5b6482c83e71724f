/* SPDX-License-Identifier: MIT */
/* What each engine would cost, so that the scene can choose. Constants are fitted to processor
 * seconds of rooms with none and two boxes, lamps, boards in mid-air and walls that divide them,
 * and of the benches' scenes: mostly right within a factor of three; six for gather in the open
 * box that one bright patch lights. */
#include "radiosity/engine.h"

#include "geometry/vec.h"
#include "scene/scene_internal.h"

#include <math.h>

/* Links: of a pair of faces at 1 %, and for each blocker as part of that. */
static const double pair_seconds = 5e-5, blocker_share = 4.7, links_power = 0.8;
/* Light of emitting surfaces lives on elements, with its penumbrae. */
static const double penumbrae = 5;
/* More shapes than this are not compared pair by pair, nor would links be the better engine. */
enum { PAIRED_MOST = 512 };
/* Gather: at any tolerance, at 1 %, of an answer, and by how many surfaces that doubles. */
static const double gather_start = 0.03, gather_seconds = 0.2, gather_power = 1.5;
static const double gather_answer = 8e-4, gather_answer_power = 1.4;
static const double gather_doubles = 300;
/* Paths: at any tolerance, and a ray's part of an answer at 1 %, for each level of a binary tree of
 * all surfaces. */
static const double paths_start = 5e-3, paths_answer = 5e-4, paths_power = 1.8;
/* Answers by rays come no closer. */
static const double rays_least = 5e-4;

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
static double count_hiding(const lcor_scene *scene)
{
    const uint32_t *blockers = scene->blockers.items;
    double count = 0;

    for (size_t i = 0; i < scene->blockers.count; i++) {
        const scene_surface *part;
        int hides = 0;

        for (size_t k = 0; !hides && (part = scene_blocker_part(scene, blockers[i], k)) != NULL;
             k++)
            hides = is_between(scene, part);
        count += hides;
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

static double mean_reflectance(const lcor_scene *scene, const double luminance[3])
{
    double area = 0, sum = 0;

    for (size_t i = 0; i < scene->surfaces.count; i++) {
        const scene_surface *s = scene_surface_at(scene, i);

        area += s->area;
        sum += s->area * vec_dot(s->look.reflectance, luminance);
    }
    return area > 0 ? sum / area : 0;
}

/* Rays of a path that carries on to a quarter of its light, then by chance. */
static double path_length(double reflectance)
{
    const double rho = fmin(fmax(reflectance, 1e-3), 0.999);

    return 1 + log(0.25) / log(rho) + rho / (1 - rho);
}

static double links_cost(const lcor_scene *scene, double finer)
{
    const double hiding = scene->convex ? 0 : count_hiding(scene);

    return pair_seconds * count_pairs(scene) * (1 + blocker_share * hiding) *
           (hiding > 0 && emits(scene) ? penumbrae : 1) * pow(finer, links_power);
}

static double gather_cost(const lcor_scene *scene, double points, double finer)
{
    const double size = 1 + (double)scene->surfaces.count / gather_doubles;

    return gather_start + size * (gather_seconds * pow(finer, gather_power) +
                                  points * gather_answer * pow(finer, gather_answer_power));
}

/* Answers at points, and at places that tell the error. */
static double paths_cost(const lcor_scene *scene, const lcor_radiosity_options *options,
                         double finer)
{
    const double answers = (double)options->points + (double)engine_paths_places(options);
    const double levels = log(1 + (double)scene->surfaces.count) / log(2);

    return paths_start + answers * paths_answer * pow(finer, paths_power) * levels *
                             path_length(mean_reflectance(scene, options->luminance));
}

void engine_costs(const lcor_scene *scene, const lcor_radiosity_options *options,
                  lcor_radiosity_report *report)
{
    const double finer = 0.01 / options->tolerance;
    const int rays = options->tolerance >= rays_least;

    report->links_seconds =
        scene->shapes.count <= PAIRED_MOST ? links_cost(scene, finer) : HUGE_VAL;
    report->gather_seconds = rays ? gather_cost(scene, (double)options->points, finer) : HUGE_VAL;
    report->paths_seconds =
        rays && options->points > 0 ? paths_cost(scene, options, finer) : HUGE_VAL;
}
