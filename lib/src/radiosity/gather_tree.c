/* SPDX-License-Identifier: MIT */
/* Which sides get a field, and its leaves: kd trees split until leaves are small against the
 * distance of what they see. */
#include "radiosity/gather.h"

#include "base/internal.h"
#include "geometry/vec.h"

#include <math.h>
#include <string.h>

enum { PROBES = 16, SCOUTS = 8192, HITS_LEAST = 4, CORNERS_MAX = 5 };

/* A side that a smaller part of all probing rays meets gets no field: paths through it are
 * cheaper. */
static const double share_least = 1.0 / 8000;
/* Nor is a leaf split that they meet less often. */
static const double share_split = 1.0 / 4000;
/* Leaves are not split below this part of the scene's diameter. */
static const double finest = 1e-3;
static const double leaf_size_least = 0.1;

static gather_node *node_at(const gather *g, size_t i) { return (gather_node *)g->nodes.items + i; }

static gather_piece *piece_at(const gather *g, size_t i)
{
    return (gather_piece *)g->pieces.items + i;
}

static double triangle_area(double p[][2])
{
    return 0.5 * fabs((p[1][0] - p[0][0]) * (p[2][1] - p[0][1]) -
                      (p[2][0] - p[0][0]) * (p[1][1] - p[0][1]));
}

static int add_piece(gather *g, double corner[][2], uint32_t surface)
{
    gather_piece *p = lcor_array_reserve(g->allocator, &g->pieces, 1, sizeof *p);

    if (!p)
        return 0;
    memcpy(p->corner, corner, sizeof p->corner);
    p->area_before = 0;
    p->surface = surface;
    g->pieces.count++;
    return 1;
}

/* A leaf of the pieces from first_piece on, with its node. Returns its number, or gather_none
 * without memory. */
static uint32_t add_leaf(gather *g, uint32_t side, size_t first_piece)
{
    gather_leaf *l = lcor_array_reserve(g->allocator, &g->leaves, 1, sizeof *l);
    gather_node *n = lcor_array_reserve(g->allocator, &g->nodes, 1, sizeof *n);
    double low[2] = {HUGE_VAL, HUGE_VAL}, high[2] = {-HUGE_VAL, -HUGE_VAL};

    if (!l || !n)
        return gather_none;
    memset(l, 0, sizeof *l);
    l->side = side;
    l->node = (int32_t)g->nodes.count++;
    l->terms = 1;
    l->ray_length = g->scene->diameter;
    l->brightness = 1;
    l->first_piece = first_piece;
    l->piece_count = g->pieces.count - first_piece;
    *n = (gather_node){0, 0, {-1, -1}, (int32_t)g->leaves.count};
    for (size_t i = first_piece; i < g->pieces.count; i++) {
        gather_piece *p = piece_at(g, i);

        p->area_before = l->area;
        l->area += triangle_area(p->corner);
        for (int c = 0; c < 3; c++)
            for (int k = 0; k < 2; k++) {
                low[k] = fmin(low[k], p->corner[c][k]);
                high[k] = fmax(high[k], p->corner[c][k]);
            }
    }
    for (int k = 0; k < 2; k++) {
        l->centre[k] = 0.5 * (low[k] + high[k]);
        l->half[k] = fmax(0.5 * (high[k] - low[k]), g->touch);
    }
    return (uint32_t)g->leaves.count++;
}

static int reflects_on(const gather *g, uint32_t surface, uint32_t side)
{
    return gather_side_of(g, surface, 0) == side ||
           scene_surface_at(g->scene, surface)->look.two_sided;
}

static int add_root(gather *g, uint32_t side)
{
    const gather_plane *plane = gather_plane_at(g, side / 2);
    const uint32_t *members = (const uint32_t *)g->members.items + plane->first;
    const size_t first = g->pieces.count;
    uint32_t leaf;

    for (size_t i = 0; i < plane->count; i++) {
        const scene_surface *f = scene_surface_at(g->scene, members[i]);
        const double *p = scene_corners(g->scene, f);

        for (size_t j = 1; j + 1 < f->corner_count && reflects_on(g, members[i], side); j++) {
            double corner[3][2];

            gather_to_plane(plane, p, corner[0]);
            gather_to_plane(plane, p + 3 * j, corner[1]);
            gather_to_plane(plane, p + 3 * (j + 1), corner[2]);
            if (!add_piece(g, corner, members[i]))
                return 0;
        }
    }
    if (g->pieces.count == first)
        return 1;
    leaf = add_leaf(g, side, first);
    if (leaf == gather_none)
        return 0;
    g->sides[side].root = gather_leaf_at(g, leaf)->node;
    return 1;
}

/* Corners of a triangle's part with sign * (p[axis] - at) >= 0. */
static int clip(double in[][2], int axis, double at, double sign, double out[CORNERS_MAX][2])
{
    int n = 0;

    for (int i = 0; i < 3; i++) {
        const double *a = in[i], *b = in[(i + 1) % 3];
        const double da = sign * (a[axis] - at), db = sign * (b[axis] - at);

        if (da >= 0)
            memcpy(out[n++], a, sizeof out[0]);
        if ((da > 0 && db < 0) || (da < 0 && db > 0)) {
            const double t = da / (da - db);

            for (int k = 0; k < 2; k++)
                out[n][k] = a[k] + t * (b[k] - a[k]);
            out[n++][axis] = at;
        }
    }
    return n;
}

/* The part of a leaf on one side of its middle as a new leaf; *out is gather_none if there is
 * nothing. */
static int split_off(gather *g, uint32_t leaf, int axis, double sign, uint32_t *out)
{
    const gather_leaf l = *gather_leaf_at(g, leaf);
    const size_t first = g->pieces.count;

    for (size_t i = l.first_piece; i < l.first_piece + l.piece_count; i++) {
        gather_piece whole = *piece_at(g, i);
        double corner[CORNERS_MAX][2];
        const int n = clip(whole.corner, axis, l.centre[axis], sign, corner);

        for (int j = 1; j + 1 < n; j++) {
            double part[3][2] = {{corner[0][0], corner[0][1]},
                                 {corner[j][0], corner[j][1]},
                                 {corner[j + 1][0], corner[j + 1][1]}};

            if (triangle_area(part) > g->touch * g->touch && !add_piece(g, part, whole.surface))
                return 0;
        }
    }
    *out = gather_none;
    if (g->pieces.count == first)
        return 1;
    *out = add_leaf(g, l.side, first);
    return *out != gather_none;
}

static int split(gather *g, uint32_t leaf)
{
    const gather_leaf *l = gather_leaf_at(g, leaf);
    const int axis = l->half[1] > l->half[0];
    const double at = l->centre[axis];
    const size_t node = (size_t)l->node;
    const uint32_t hits = l->hits;
    const double brightness = l->brightness;
    uint32_t part[2];
    int32_t child[2];

    if (!split_off(g, leaf, axis, -1, &part[0]) || !split_off(g, leaf, axis, 1, &part[1]))
        return 0;
    if (part[0] == gather_none && part[1] == gather_none)
        return 1;
    for (int i = 0; i < 2; i++) /* an empty half's places belong to the other */
        child[i] = gather_leaf_at(g, part[part[i] == gather_none ? 1 - i : i])->node;
    for (int i = 0; i < 2; i++)
        if (part[i] != gather_none) {
            gather_leaf_at(g, part[i])->hits = hits / 2;
            gather_leaf_at(g, part[i])->brightness = brightness;
        }
    *node_at(g, node) = (gather_node){axis, at, {child[0], child[1]}, -1};
    gather_leaf_at(g, leaf)->terms = 0;
    return 1;
}

uint32_t gather_leaf_of(const gather *g, uint32_t side, const double at[2])
{
    int32_t i = g->sides[side].root;

    if (i < 0)
        return gather_none;
    while (node_at(g, (size_t)i)->leaf < 0) {
        const gather_node *n = node_at(g, (size_t)i);

        i = n->child[at[n->axis] >= n->at];
    }
    return (uint32_t)node_at(g, (size_t)i)->leaf;
}

uint32_t gather_leaf_at_stand(const gather *g, const gather_stand *stand, double at[2])
{
    const double *front = scene_surface_at(g->scene, stand->surface)->normal;
    const uint32_t side = gather_side_of(g, stand->surface, vec_dot(front, stand->normal) < 0);

    gather_to_plane(gather_plane_at(g, side / 2), stand->x, at);
    return gather_leaf_of(g, side, at);
}

static void leaf_place(const gather *g, const gather_leaf *leaf, double a, double b, double at[2],
                       uint32_t *surface)
{
    const double wanted = a * leaf->area;
    size_t low = leaf->first_piece, high = leaf->first_piece + leaf->piece_count - 1;
    const gather_piece *p;
    double rest, area, s;

    while (low < high) { /* the last piece that begins at or before the wanted area */
        const size_t middle = (low + high + 1) / 2;

        if (piece_at(g, middle)->area_before <= wanted)
            low = middle;
        else
            high = middle - 1;
    }
    p = piece_at(g, low);
    area = (low + 1 < leaf->first_piece + leaf->piece_count ? p[1].area_before : leaf->area) -
           p->area_before;
    rest = area > 0 ? fmin(fmax((wanted - p->area_before) / area, 0), 1) : 0.5;
    s = sqrt(rest);
    for (int k = 0; k < 2; k++)
        at[k] = (1 - s) * p->corner[0][k] + s * (1 - b) * p->corner[1][k] + s * b * p->corner[2][k];
    *surface = p->surface;
}

void gather_leaf_stand(const gather *g, const gather_leaf *leaf, double a, double b, double at[2],
                       gather_stand *stand)
{
    const gather_plane *plane = gather_plane_at(g, leaf->side / 2);
    const scene_surface *f;
    double d[3];
    uint32_t surface;

    leaf_place(g, leaf, a, b, at, &surface);
    gather_stand_on(g, surface, gather_side_of(g, surface, 0) != leaf->side, stand);
    vec_plane_point(plane->origin, plane->u, plane->v, at[0], at[1], stand->x);
    f = scene_surface_at(g->scene, surface);
    vec_sub(f->origin, stand->x, d); /* the plane is that of another member */
    vec_add_scaled(stand->x, vec_dot(d, f->normal), f->normal, stand->x);
}

/* What a ray met: a side that reflects, or gather_none. */
typedef struct sighting {
    uint32_t side;
    double at[2], distance;
} sighting;

static void see(const gather *g, const gather_spot *spot, sighting *out)
{
    out->side = spot && spot->reflects ? spot->side : gather_none;
    if (out->side == gather_none)
        return;
    gather_to_plane(gather_plane_at(g, out->side / 2), spot->stand.x, out->at);
    out->distance = spot->distance;
}

/* A leaf is hit by rays that would read its field: those from nearer go on as paths. Otherwise the
 * two sides of a slit would split each other without end. */
static void count_hits(gather *g, const sighting *seen, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        uint32_t leaf;

        if (seen[i].side == gather_none)
            continue;
        g->sides[seen[i].side].hits++;
        leaf = gather_leaf_of(g, seen[i].side, seen[i].at);
        if (leaf != gather_none &&
            !gather_is_near(gather_leaf_at(g, leaf), g->effort.near, seen[i].distance))
            gather_leaf_at(g, leaf)->hits++;
    }
    g->probes += count;
}

/* Rays that find out how far leaves see, and what. */
typedef struct probing {
    gather *g;
    size_t first_leaf;
    sighting *seen; /* PROBES a leaf */
} probing;

static void probe_task(void *arg, size_t i)
{
    const probing *job = arg;
    const gather *g = job->g;
    gather_leaf *l = gather_leaf_at(g, job->first_leaf + i);
    const uint32_t seed = random_hash((uint32_t)(job->first_leaf + i));
    double sum = 0;

    for (uint32_t k = 0; k < PROBES; k++) {
        double random[4], at[2], d[3];
        gather_stand stand;
        gather_spot spot;

        sobol_point(&g->sobol, k, seed, 0, 4, random);
        gather_leaf_stand(g, l, random[2], random[3], at, &stand);
        random_cosine(random[0], random[1], d);
        if (gather_trace(g, &stand, d, &spot)) {
            sum += 1 / fmax(spot.distance, 1e-4 * g->scene->diameter);
            see(g, &spot, &job->seen[i * PROBES + k]);
        } else {
            see(g, NULL, &job->seen[i * PROBES + k]);
        }
    }
    l->ray_length = sum > 0 ? fmin(PROBES / sum, g->scene->diameter) : g->scene->diameter;
}

/* Probes the leaves that are new. */
static int probe(gather *g)
{
    const size_t leaves = g->leaves.count - g->probed, count = leaves * PROBES;
    probing job = {g, g->probed, lcor_internal_alloc(g->allocator, count * sizeof *job.seen)};
    int ok;

    if (!job.seen)
        return 0;
    ok = gather_each(g, leaves, probe_task, &job);
    if (ok)
        count_hits(g, job.seen, count);
    lcor_internal_free(g->allocator, job.seen);
    g->probed += leaves;
    g->rays += count;
    return ok;
}

/* Rays from all fronts that are lit, to see what is worth a field. */
typedef struct scouting {
    const gather *g;
    sighting *seen;
} scouting;

static void scout_task(void *arg, size_t i)
{
    const scouting *job = arg;
    const gather *g = job->g;

    for (size_t k = i * 64; k < (i + 1) * 64; k++) {
        double random[4], d[3];
        gather_stand stand;
        gather_spot spot;

        sobol_point(&g->sobol, (uint32_t)k, 1, 0, 4, random);
        see(g, NULL, &job->seen[k]);
        if (!g->guide.lit[gather_place(g, random[2], random[3], &stand)])
            continue;
        random_cosine(random[0], random[1], d);
        if (gather_trace(g, &stand, d, &spot))
            see(g, &spot, &job->seen[k]);
    }
}

static int scout(gather *g)
{
    scouting job = {g, lcor_internal_alloc(g->allocator, SCOUTS * sizeof *job.seen)};
    int ok;

    if (!job.seen)
        return 0;
    ok = gather_each(g, SCOUTS / 64, scout_task, &job);
    if (ok)
        count_hits(g, job.seen, SCOUTS);
    lcor_internal_free(g->allocator, job.seen);
    g->rays += SCOUTS;
    return ok;
}

/* Gives a field to every side that is met often enough. */
static int activate(gather *g)
{
    const double least = fmax(HITS_LEAST, share_least * (double)g->probes);

    for (size_t i = 0; i < 2 * g->planes.count; i++)
        if (g->sides[i].root < 0 && g->sides[i].hits >= least && g->sides[i].reflects > 0 &&
            !add_root(g, (uint32_t)i))
            return 0;
    return 1;
}

/* How small a leaf must be. What is dark is lit by what is dark as well, and errs by a larger part
 * of what it has. */
static double size_wanted(const gather *g, const gather_leaf *l)
{
    return g->effort.leaf_size * l->ray_length * sqrt(l->brightness);
}

/* Splits leaves until they are small against the rays' length. */
static int refine(gather *g)
{
    const double least = finest * g->scene->diameter;
    size_t judged = 0;

    while (judged < g->leaves.count && !g->hurry) {
        double hits;

        if (g->probed < g->leaves.count && !probe(g))
            return 0;
        hits = share_split * (double)g->probes;
        for (; judged < g->probed; judged++) {
            const gather_leaf *l = gather_leaf_at(g, judged);
            const double half = fmax(l->half[0], l->half[1]);

            if (l->terms > 0 && half > size_wanted(g, l) && half > least &&
                (double)l->hits > hits && !split(g, (uint32_t)judged))
                return 0;
        }
        if (!activate(g))
            return 0;
    }
    return 1;
}

static size_t count_leaves(const gather *g)
{
    size_t count = 0;

    for (size_t i = 0; i < g->leaves.count; i++)
        count += gather_leaf_at(g, i)->terms > 0;
    return count;
}

int gather_grow(gather *g)
{
    if (g->leaves.count == 0 && (!scout(g) || !activate(g)))
        return 0;
    for (;;) {
        size_t before;

        do { /* leaves made later see what earlier ones are worth */
            before = g->leaves.count;
            if (!refine(g))
                return 0;
        } while (g->leaves.count > before && !g->hurry);
        /* A scene of few planes can afford smaller leaves. */
        if (g->leaves.count == 0 || count_leaves(g) >= g->effort.leaves || g->hurry ||
            g->effort.leaf_size < leaf_size_least)
            return 1;
        g->effort.leaf_size *= 0.7;
    }
}
