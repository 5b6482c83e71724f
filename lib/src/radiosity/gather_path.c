/* SPDX-License-Identifier: MIT */
/* Rays, and paths of them up to a place whose field may be read. */
#include "radiosity/gather.h"

#include "geometry/vec.h"

#include <math.h>
#include <string.h>

/* Paths that carry less than this are ended by chance; the longest read any field at last. */
static const double roulette_below = 0.25;
enum { DEPTH_MAX = 64 };

static const double pi = 3.14159265358979323846;

void gather_straight(const gather *g, const double x[3], const double normal[3], uint32_t surface,
                     double *out)
{
    light_at(&g->solution->lights, x, normal, surface, out);
    emitters_at(&g->emitters, x, normal, surface, out);
}

int gather_trace(const gather *g, const gather_stand *from, const double direction[3],
                 gather_spot *spot)
{
    const scene_surface *f;
    lcor_bvh_hit hit;
    lcor_ray ray;
    int back;

    vec_copy(from->x, ray.origin);
    for (int k = 0; k < 3; k++)
        ray.direction[k] =
            direction[0] * from->u[k] + direction[1] * from->v[k] + direction[2] * from->normal[k];
    ray.t_min = g->touch;
    ray.t_max = HUGE_VAL;
    ray.skip = from->surface;
    if (!lcor_bvh_closest(g->scene->bvh, &ray, &hit))
        return 0;
    f = scene_surface_at(g->scene, hit.owner);
    back = vec_dot(ray.direction, f->normal) > 0;
    gather_stand_on(g, hit.owner, back, &spot->stand);
    vec_add_scaled(ray.origin, hit.t, ray.direction, spot->stand.x);
    spot->distance = hit.t;
    spot->side = gather_side_of(g, hit.owner, back);
    spot->back = back;
    spot->reflects = !back || f->look.two_sided;
    spot->prim = hit.prim;
    spot->st[0] = hit.u;
    spot->st[1] = hit.v;
    return 1;
}

/* A path under way: what it has found and what it passes on. */
typedef struct path {
    const gather *g;
    double near;
    uint32_t random, choice; /* choice: of lights */
    gather_sample *out;
} path;

static double largest(const gather *g, const double *v)
{
    double most = 0;

    for (int c = 0; c < g->channels; c++)
        most = fmax(most, v[c]);
    return most;
}

/* gather_straight on average, with one shadow ray for all lights, or one for the strongest and one
 * for all others. */
static void straight_by_chance(path *p, const double x[3], const double normal[3], uint32_t surface,
                               int strongest, double *out)
{
    light_by_chance(&p->g->solution->lights, x, normal, surface, strongest, random_next(&p->choice),
                    out);
    emitters_at(&p->g->emitters, x, normal, surface, out);
}

/* Light of a guided ray: what its target sends at first hand, weighed against the chance of the
 * cosine-weighted ray that goes with it [Veach and Guibas 1995]. */
static void add_guided(path *p, const gather_stand *stand, const guide_view *view, double a,
                       double b)
{
    const gather *g = p->g;
    double to[3], direct[GATHER_CHANNELS], square, height, cosine, by_cosine, by_guide, weight;
    const double *rho, *emission;
    guide_place target;

    guide_choose(g, view, a, b, &target);
    vec_sub(target.x, stand->x, to);
    square = vec_dot(to, to);
    height = vec_dot(to, stand->normal);
    cosine = -vec_dot(to, target.normal);
    if (!(height > 0 && cosine > 0))
        return;
    p->out->rays++;
    if (lcor_scene_blocked(g->scene, stand->x, target.x, stand->surface, NULL))
        return;
    straight_by_chance(p, target.x, target.normal, target.surface, 0, direct);
    by_cosine = height * cosine / (pi * square * square); /* densities per area */
    by_guide = target.density;
    weight = by_cosine / (by_cosine + by_guide);
    rho = g->reflectance + (size_t)target.surface * (size_t)g->channels;
    emission = g->emission + (size_t)target.surface * (size_t)g->channels;
    for (int c = 0; c < g->channels; c++)
        p->out->source[c] += p->out->through[c] * weight * (emission[c] + rho[c] * direct[c]);
}

/* Weight of first-hand light that a cosine-weighted ray found and a guided one might have. */
static double unguided(const gather *g, const gather_stand *from, const guide_view *view,
                       const gather_spot *spot)
{
    const double density = view ? guide_density(g, view, spot->prim, spot->back, spot->st) : 0;
    double to[3], by_cosine, square;

    if (!(density > 0))
        return 1;
    vec_sub(spot->stand.x, from->x, to);
    square = vec_dot(to, to);
    by_cosine =
        vec_dot(to, from->normal) * -vec_dot(to, spot->stand.normal) / (pi * square * square);
    return by_cosine / (by_cosine + density);
}

/* Adds the light at a spot; what is left to find out is its irradiance times `through`. */
static void add_spot(path *p, const gather_spot *spot, double weight, int depth)
{
    const gather *g = p->g;
    const double *rho = g->reflectance + (size_t)spot->stand.surface * (size_t)g->channels;
    const double *emission = g->emission + (size_t)spot->stand.surface * (size_t)g->channels;
    double direct[GATHER_CHANNELS] = {0};

    if (!spot->reflects) {
        memset(p->out->through, 0, sizeof p->out->through);
        return;
    }
    if (largest(g, rho) > 0) /* further on paths carry less, and so does their noise */
        straight_by_chance(p, spot->stand.x, spot->stand.normal, spot->stand.surface, depth == 0,
                           direct);
    for (int c = 0; c < g->channels; c++) {
        p->out->source[c] += p->out->through[c] * weight * (emission[c] + rho[c] * direct[c]);
        p->out->through[c] *= rho[c];
    }
}

/* Whether the path may end here with what the field says. From close above the leaf's plane a ray
 * sees what is hemmed in, which the field leaves out. */
static int read_field(path *p, const gather_stand *from, const gather_spot *spot, int depth)
{
    const gather *g = p->g;
    double at[2], down[3], height;
    uint32_t leaf;

    gather_to_plane(gather_plane_at(g, spot->side / 2), spot->stand.x, at);
    leaf = gather_leaf_of(g, spot->side, at);
    if (leaf == gather_none)
        return 0;
    vec_sub(from->x, spot->stand.x, down);
    height = vec_dot(down, spot->stand.normal);
    if (depth < DEPTH_MAX && (gather_is_near(gather_leaf_at(g, leaf), p->near, spot->distance) ||
                              height < gather_hemmed_in(gather_leaf_at(g, leaf))))
        return 0;
    p->out->leaf = leaf;
    p->out->at[0] = at[0];
    p->out->at[1] = at[1];
    return 1;
}

/* Ends some of the paths that carry little, the others carry on for them. */
static int survives(path *p)
{
    const double through = largest(p->g, p->out->through);
    const double chance = through / roulette_below;

    if (chance >= 1)
        return 1;
    if (random_next(&p->random) >= chance)
        return 0;
    for (int c = 0; c < p->g->channels; c++)
        p->out->through[c] /= chance;
    return 1;
}

/* Two numbers of 0..1: of the sequence for the first two rays, of chance for others. */
static void next_pair(path *p, int depth, uint32_t index, uint32_t seed, double random[2])
{
    if (depth < 2) {
        sobol_point(&p->g->sobol, index, seed, 4 * depth, 2, random);
        return;
    }
    random[0] = random_next(&p->random);
    random[1] = random_next(&p->random);
}

void gather_sample_at(const gather *g, const gather_stand *stand, const guide_view *view,
                      double near, uint32_t index, uint32_t seed, gather_sample *out)
{
    /* The mean may be that of slits behind emitters, which paths hardly come to. */
    const double usual = g->emitters.exact ? g->guide.mean : g->mean;
    path p = {g, near, random_hash(seed + index), random_hash(~(seed + index)), out};
    gather_stand from = *stand;
    double random[2], direction[3];
    guide_view own;

    memset(out, 0, sizeof *out);
    out->distance = HUGE_VAL;
    out->leaf = gather_none;
    for (int c = 0; c < g->channels; c++)
        out->through[c] = 1;
    for (int depth = 0;; depth++) {
        gather_spot spot;

        /* Directions and targets are integrals of their own, each by the best two axes. */
        if (view) {
            next_pair(&p, depth, index, random_hash(seed + 1), random);
            add_guided(&p, &from, view, random[0], random[1]);
        }
        next_pair(&p, depth, index, seed, random);
        random_cosine(random[0], random[1], direction);
        out->rays++;
        if (!gather_trace(g, &from, direction, &spot))
            break;
        if (depth == 0)
            out->distance = spot.distance;
        add_spot(&p, &spot, unguided(g, &from, view, &spot), depth);
        if (!(largest(g, out->through) > 0) || read_field(&p, &from, &spot, depth))
            break;
        if (!survives(&p))
            break;
        from = spot.stand;
        view = guide_look(g, from.x, from.normal, usual, GUIDE_COARSE, &own) ? &own : NULL;
    }
    if (out->leaf == gather_none)
        memset(out->through, 0, sizeof out->through);
}
