/* SPDX-License-Identifier: MIT */
#include "radiosity/gather_guide.h"

#include "base/internal.h"
#include "geometry/vec.h"
#include "radiosity/gather.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>

enum { DEPTH_MAX = 5, DEPTH_FOOT = 8, OPEN_RAYS = 16 };

static const double pi = 3.14159265358979323846;

/* Darker than this part of the mean: not worth a look of its own. */
static const double bright = 0.05;
/* Variance that guiding must take away, of the irradiance squared, to be worth its rays. */
static const double worth = 0.05;
/* What stands nearer before a cell than this part of its width hides it. */
static const double closeness = 0.25;
/* But something of it is seen from aside. */
static const double aslant = 1.0 / 64;
/* Cells are split while their parts differ by this factor and they hold more than this part of
 * all brightness. */
static const double uneven = 1.5, least_share = 1.0 / 512;
/* A coarse target's part of all power at most, unless there are no smaller cells. */
static const double coarse_share = 1.0 / 64;
static const size_t most_targets[GUIDE_DETAILS] = {128, GUIDE_TARGETS};

/* The inverse of gather_square_to_edges. */
static void edges_to_square(int triangle, const double st[2], double q[2])
{
    if (triangle) {
        const double s = st[0] + st[1];

        q[0] = s * s;
        q[1] = s > 0 ? st[1] / s : 0;
    } else {
        q[0] = st[0];
        q[1] = st[1];
    }
}

static guide_cell *cell_at(const guide *d, int32_t i) { return (guide_cell *)d->cells.items + i; }

static guide_root *root_at(const guide *d, size_t i) { return (guide_root *)d->roots.items + i; }

static void root_place(const guide_root *r, const double q[2], double x[3])
{
    double st[2];

    gather_square_to_edges(r->triangle, q, st);
    vec_plane_point(r->origin, r->edge_u, r->edge_v, st[0], st[1], x);
}

static void root_normal(const gather *g, const guide_root *r, double normal[3])
{
    const double *n = scene_surface_at(g->scene, r->surface)->normal;

    for (int k = 0; k < 3; k++)
        normal[k] = r->back ? -n[k] : n[k];
}

/* Radiosity at a place without what is reflected more than once, mean of the channels. */
static double brightness_at(const gather *g, const guide_root *r, const double q[2])
{
    const double *rho = g->reflectance + (size_t)r->surface * (size_t)g->channels;
    const double *emission = g->emission + (size_t)r->surface * (size_t)g->channels;
    double x[3], normal[3], direct[GATHER_CHANNELS], sum = 0;

    root_place(r, q, x);
    root_normal(g, r, normal);
    gather_straight(g, x, normal, r->surface, direct);
    for (int c = 0; c < g->channels; c++)
        sum += emission[c] + rho[c] * direct[c];
    return sum / g->channels;
}

/* The place of a root below a corner or the middle of an emitter that is nearer than the root is
 * wide: it may be bright there and nowhere else. Returns 0 if there is none. */
static int foot_of(const gather *g, const guide_root *r, const double x[3], const double facing[3],
                   double q[2])
{
    scene_surface frame = *scene_surface_at(g->scene, r->surface);
    double normal[3], d[3], st[2], height;

    root_normal(g, r, normal);
    vec_sub(x, r->origin, d);
    height = vec_dot(d, normal);
    if (!(height > 0 && height * height < r->area && vec_dot(normal, facing) < 0))
        return 0;
    vec_copy(r->origin, frame.origin);
    vec_copy(r->edge_u, frame.edge_u);
    vec_copy(r->edge_v, frame.edge_v);
    lcor_scene_coordinates(&frame, x, &st[0], &st[1]);
    if (!(st[0] >= 0 && st[1] >= 0 && (r->triangle ? st[0] + st[1] : fmax(st[0], st[1])) <= 1))
        return 0;
    edges_to_square(r->triangle, st, q);
    return 1;
}

/* Brightness of the brightest foot in a square of a root; 0 without one. */
static double brightest_foot(const gather *g, const guide_root *r, const double low[2], double size)
{
    double most = 0, x[3], facing[3], q[2];

    for (size_t i = 0; emitters_point(&g->emitters, i, x, facing); i++)
        if (foot_of(g, r, x, facing, q) && fabs(q[0] - low[0] - 0.5 * size) <= 0.5 * size &&
            fabs(q[1] - low[1] - 0.5 * size) <= 0.5 * size)
            most = fmax(most, brightness_at(g, r, q));
    return most;
}

/* A first look at every primitive: n x n places, and the feet of emitters. */
typedef struct survey {
    guide_root root;
    uint32_t prim;
    double mean, most;
} survey;

static void look_at(const gather *g, survey *s, int n)
{
    const double corner[2] = {0, 0};

    s->mean = 0;
    s->most = brightest_foot(g, &s->root, corner, 1);
    for (int i = 0; i < n * n; i++) {
        const double q[2] = {(i / n + 0.5) / n, (i % n + 0.5) / n};
        const double b = brightness_at(g, &s->root, q);

        s->mean += b / (n * n);
        s->most = fmax(s->most, b);
    }
}

typedef struct survey_job {
    const gather *g;
    survey *items;
    size_t count;
    double area;
} survey_job;

enum { SURVEY_STEP = 64 };

static void survey_task(void *arg, size_t chunk)
{
    const survey_job *job = arg;

    for (size_t i = chunk * SURVEY_STEP; i < job->count && i < (chunk + 1) * SURVEY_STEP; i++) {
        const double share = job->items[i].root.area / job->area;

        look_at(job->g, &job->items[i], share < 1e-3 ? 1 : share < 1e-2 ? 2 : 4);
    }
}

static int reflects(const gather *g, size_t surface)
{
    const double *rho = g->reflectance + surface * (size_t)g->channels;
    const double *emission = g->emission + surface * (size_t)g->channels;

    for (int c = 0; c < g->channels; c++)
        if (rho[c] > 0 || emission[c] > 0)
            return 1;
    return 0;
}

/* The sides of all primitives that reflect or emit. */
static size_t list_sides(const gather *g, survey *out)
{
    size_t count = 0;

    for (size_t i = 0; i < g->prims.count; i++) {
        const gather_prim *p = (const gather_prim *)g->prims.items + i;
        const int sides = 1 + (scene_surface_at(g->scene, p->surface)->look.two_sided != 0);

        for (int back = 0; back < sides && reflects(g, p->surface); back++, count++) {
            guide_root *r = &out[count].root;

            r->triangle = gather_prim_frame(g, i, r->origin, r->edge_u, r->edge_v);
            r->surface = p->surface;
            r->back = back;
            r->area = p[1].area_before - p->area_before;
            out[count].prim = (uint32_t)i;
        }
    }
    return count;
}

static int32_t add_cell(gather *g, uint32_t root, double s, double t, double size)
{
    guide *d = &g->guide;
    guide_cell *c = lcor_array_reserve(g->allocator, &d->cells, 1, sizeof *c);

    if (!c)
        return -1;
    *c = (guide_cell){root, {s, t}, size, -1, {-1, -1}, 0};
    return (int32_t)d->cells.count++;
}

/* Samples a cell's quarters and splits it while they differ. Returns 0 without memory. */
static int refine(gather *g, int32_t at, int depth, double all)
{
    guide *d = &g->guide;
    const guide_cell c = *cell_at(d, at);
    const guide_root r = *root_at(d, c.root);
    const double foot = brightest_foot(g, &r, c.low, c.size);
    double part[4], least = HUGE_VAL, most = foot, sum = 0;
    int32_t first = -1;

    for (int i = 0; i < 4; i++) {
        const double q[2] = {c.low[0] + c.size * (0.25 + 0.5 * (i / 2)),
                             c.low[1] + c.size * (0.25 + 0.5 * (i % 2))};

        part[i] = brightness_at(g, &r, q);
        least = fmin(least, part[i]);
        most = fmax(most, part[i]);
        sum += part[i] / 4;
    }
    cell_at(d, at)->brightness = sum;
    if (depth >= (foot > 0 ? DEPTH_FOOT : DEPTH_MAX) || most <= uneven * least ||
        most * most * c.size * c.size * r.area <= least_share * all)
        return 1;
    for (int i = 0; i < 4; i++) {
        const int32_t child = add_cell(g, c.root, c.low[0] + 0.5 * c.size * (i / 2),
                                       c.low[1] + 0.5 * c.size * (i % 2), 0.5 * c.size);

        if (child < 0)
            return 0;
        cell_at(d, child)->brightness = part[i];
        first = i == 0 ? child : first;
    }
    cell_at(d, at)->child = first;
    for (int i = 0; i < 4; i++)
        if (!refine(g, first + i, depth + 1, all))
            return 0;
    return 1;
}

typedef struct rank {
    double score;
    int32_t cell;
} rank;

static int compare_ranks(const void *a, const void *b)
{
    const rank *p = a, *q = b;

    if (p->score != q->score)
        return p->score > q->score ? -1 : 1;
    return p->cell < q->cell ? -1 : p->cell > q->cell;
}

static int compare_cells(const void *a, const void *b)
{
    const rank *p = a, *q = b;

    return p->cell < q->cell ? -1 : p->cell > q->cell;
}

static double cell_area(const guide *d, const guide_cell *c)
{
    return c->size * c->size * root_at(d, c->root)->area;
}

static void set_target(gather *g, guide_detail detail, int number, int32_t cell)
{
    guide *d = &g->guide;
    guide_cell *c = cell_at(d, cell);
    const guide_root *r = root_at(d, c->root);
    const double q[2] = {c->low[0] + 0.5 * c->size, c->low[1] + 0.5 * c->size};
    const double scale = 1 / g->scene->diameter, area = cell_area(d, c);
    guide_row *row = &d->targets[detail].rows[number / GUIDE_LANES];
    const int lane = number % GUIDE_LANES;
    double centre[3], normal[3];

    c->target[detail] = number;
    d->targets[detail].items[number] = (guide_target){area, cell};
    root_place(r, q, centre);
    root_normal(g, r, normal);
    for (int k = 0; k < 3; k++) {
        row->centre[k][lane] = (float)((centre[k] - d->origin[k]) * scale);
        row->normal[k][lane] = (float)normal[k];
    }
    row->area[lane] = (float)(area * scale * scale);
    row->brightness[lane] = (float)(c->brightness / d->mean);
}

/* Part of a cell that is seen from afar: nothing stands close before it. */
static double openness(const gather *g, const guide_cell *c)
{
    const guide_root *r = root_at(&g->guide, c->root);
    uint32_t random = random_hash(c->root);
    gather_stand stand;
    int open = 0;

    gather_stand_on(g, r->surface, r->back, &stand);
    for (int i = 0; i < OPEN_RAYS; i++) {
        double q[2], direction[3];
        lcor_ray ray = {
            .t_min = g->touch, .t_max = closeness * c->size * sqrt(r->area), .skip = r->surface};

        for (int k = 0; k < 2; k++)
            q[k] = c->low[k] + c->size * random_next(&random);
        root_place(r, q, ray.origin);
        random_cosine(random_next(&random), random_next(&random), direction);
        for (int k = 0; k < 3; k++)
            ray.direction[k] = direction[0] * stand.u[k] + direction[1] * stand.v[k] +
                               direction[2] * stand.normal[k];
        open += !lcor_bvh_occluded(g->scene->bvh, &ray, NULL);
    }
    return fmax((double)open / OPEN_RAYS, aslant);
}

/* Adds the cells below that are not split or of no more power than `most`. */
static size_t list_cells(const guide *d, int32_t at, double most, rank *out)
{
    const guide_cell *c = cell_at(d, at);
    const double power = c->brightness * cell_area(d, c);
    size_t count = 0;

    if (c->child < 0 || power <= most) {
        if (!(c->brightness > bright * d->mean))
            return 0;
        out[0] = (rank){c->brightness * power, at};
        return 1;
    }
    for (int i = 0; i < 4; i++)
        count += list_cells(d, c->child + i, most, out + count);
    return count;
}

/* The brightest cells become targets: those that a cosine-weighted ray would find too seldom. */
static void choose_targets(gather *g, guide_detail detail, double most, rank *ranks)
{
    guide *d = &g->guide;
    guide_targets *t = &d->targets[detail];
    size_t count = 0;

    for (size_t i = 0; i < d->roots.count; i++)
        count += list_cells(d, root_at(d, i)->cell, most, ranks + count);
    qsort(ranks, count, sizeof *ranks, compare_ranks);
    t->count = count < most_targets[detail] ? (int)count : (int)most_targets[detail];
    qsort(ranks, (size_t)t->count, sizeof *ranks, compare_cells); /* neighbours side by side */
    t->row_count = (t->count + GUIDE_LANES - 1) / GUIDE_LANES;
    memset(t->rows, 0, sizeof t->rows);
    for (int i = 0; i < t->count; i++) /* neighbours one below the other: a lane is a place */
        set_target(g, detail, i / t->row_count + GUIDE_LANES * (i % t->row_count), ranks[i].cell);
}

/* What hangs close over the place it lights also hides it; a cell is as bright as its quarters. */
static void dim_hidden(gather *g)
{
    guide *d = &g->guide;

    for (size_t i = d->cells.count; i-- > 0;) { /* quarters come behind what they are of */
        guide_cell *c = cell_at(d, (int32_t)i);
        double sum = 0;

        for (int k = 0; k < 4 && c->child >= 0; k++)
            sum += cell_at(d, c->child + k)->brightness / 4;
        if (c->child >= 0)
            c->brightness = sum;
        else if (c->brightness > bright * d->mean)
            c->brightness *= openness(g, c);
    }
}

static int set_targets(gather *g)
{
    guide *d = &g->guide;
    rank *ranks = lcor_internal_alloc(g->allocator, (d->cells.count + 1) * sizeof *ranks);
    double power = 0;

    if (!ranks)
        return 0;
    if (g->emitters.exact)
        dim_hidden(g);
    for (size_t i = 0; i < d->roots.count; i++)
        power += cell_at(d, root_at(d, i)->cell)->brightness * root_at(d, i)->area;
    vec_copy(g->scene->corners.items, d->origin);
    choose_targets(g, GUIDE_COARSE, coarse_share * power, ranks);
    choose_targets(g, GUIDE_FINE, 0, ranks);
    lcor_internal_free(g->allocator, ranks);
    return 1;
}

/* Area-weighted mean of the brightness; what neither reflects nor emits is black. */
static double mean_brightness(const survey *items, size_t count, double fronts, double *squares)
{
    double area = 0, sum = 0;

    *squares = 0;
    for (size_t i = 0; i < count; i++) {
        const double a = items[i].root.area;

        area += a;
        sum += a * items[i].mean;
        *squares += a * items[i].mean * items[i].most;
    }
    return sum / fmax(area, fronts);
}

static int build_cells(gather *g, const survey *items, size_t count, double squares)
{
    guide *d = &g->guide;

    for (size_t i = 0; i < count; i++) {
        guide_root *r;
        int32_t cell;

        if (!(items[i].most > bright * d->mean))
            continue;
        r = lcor_array_reserve(g->allocator, &d->roots, 1, sizeof *r);
        cell = add_cell(g, (uint32_t)d->roots.count, 0, 0, 1);
        if (!r || cell < 0)
            return 0;
        *r = items[i].root;
        r->cell = cell;
        d->root_of[2 * items[i].prim + (uint32_t)r->back] = (int32_t)d->roots.count++;
        if (!refine(g, cell, 0, squares))
            return 0;
    }
    return set_targets(g);
}

int guide_build(gather *g)
{
    const size_t prims = g->prims.count;
    guide *d = &g->guide;
    survey_job job = {g, NULL, 0, ((gather_prim *)g->prims.items)[prims].area_before};
    double squares;
    int ok;

    guide_clear(g);
    d->root_of = lcor_internal_alloc(g->allocator, 2 * prims * sizeof *d->root_of);
    d->lit = lcor_internal_alloc(g->allocator, prims);
    job.items = lcor_internal_alloc(g->allocator, 2 * prims * sizeof *job.items);
    if (!d->root_of || !d->lit || !job.items) {
        lcor_internal_free(g->allocator, job.items);
        return 0;
    }
    for (size_t i = 0; i < 2 * prims; i++)
        d->root_of[i] = -1;
    memset(d->lit, 0, prims);
    job.count = list_sides(g, job.items);
    engine_run(g->solution, (job.count + SURVEY_STEP - 1) / SURVEY_STEP, survey_task, &job);
    for (size_t i = 0; i < job.count; i++)
        if (job.items[i].most > 0 && !job.items[i].root.back)
            d->lit[job.items[i].prim] = 1;
    d->mean = mean_brightness(job.items, job.count, job.area, &squares);
    ok = build_cells(g, job.items, job.count, squares);
    lcor_internal_free(g->allocator, job.items);
    return ok;
}

void guide_clear(gather *g)
{
    guide *d = &g->guide;

    lcor_array_clear(g->allocator, &d->roots);
    lcor_array_clear(g->allocator, &d->cells);
    lcor_internal_free(g->allocator, d->root_of);
    lcor_internal_free(g->allocator, d->lit);
    d->root_of = NULL;
    d->lit = NULL;
    d->targets[GUIDE_COARSE].count = d->targets[GUIDE_FINE].count = 0;
}

/* Sums over the targets of each lane. */
typedef struct lanes {
    float covered[GUIDE_LANES]; /* form factors, */
    float light[GUIDE_LANES];   /* times brightness, */
    float square[GUIDE_LANES];  /* times brightness squared */
} lanes;

static void look_at_row(const guide_row *row, const float x[3], const float normal[3],
                        float upto[GUIDE_LANES], lanes *sums)
{
    for (int i = 0; i < GUIDE_LANES; i++) {
        const float a = row->centre[0][i] - x[0], b = row->centre[1][i] - x[1],
                    c = row->centre[2][i] - x[2], area = row->area[i];
        const float height = a * normal[0] + b * normal[1] + c * normal[2];
        const float cosine =
            -(a * row->normal[0][i] + b * row->normal[1][i] + c * row->normal[2][i]);
        const float square = a * a + b * b + c * c;
        const float seen = (height > 0 ? height : 0) * (cosine > 0 ? cosine : 0) * area;
        const float factor = seen / (square * ((float)pi * square + area) + FLT_MIN);
        const float light = factor * row->brightness[i];

        sums->covered[i] += factor;
        sums->light[i] += light;
        upto[i] = sums->light[i];
        sums->square[i] += light * row->brightness[i];
    }
}

/* Sums of all lanes before each, from those of each. */
static void set_below(guide_view *view, const float lane[GUIDE_LANES])
{
    view->below[0] = 0;
    for (int i = 0; i < GUIDE_LANES; i++)
        view->below[i + 1] = view->below[i] + (double)lane[i];
    view->all = view->below[GUIDE_LANES];
}

static double sum_lanes(const float v[GUIDE_LANES])
{
    double sum = 0;

    for (int i = 0; i < GUIDE_LANES; i++)
        sum += (double)v[i];
    return sum;
}

/* Of the first-hand light of a cosine-weighted ray over its mean everywhere, the rest of the
 * hemisphere being average. */
static double variance(double light, double square, double covered)
{
    const double rest = fmax(1 - covered, 0), all = covered + rest;
    const double mean = (light + rest) / all;

    return (square + rest) / all - mean * mean;
}

int guide_look(const gather *g, const double x[3], const double normal[3], double expected,
               guide_detail detail, guide_view *view)
{
    const guide *d = &g->guide;
    const guide_targets *t = &d->targets[detail];
    lanes sums = {{0}, {0}, {0}};
    float from[3], towards[3];
    double relative;

    if (t->count == 0)
        return 0;
    view->detail = detail;
    relative = expected / d->mean;
    for (int k = 0; k < 3; k++) {
        from[k] = (float)((x[k] - d->origin[k]) / g->scene->diameter);
        towards[k] = (float)normal[k];
    }
    for (int r = 0; r < t->row_count; r++)
        look_at_row(&t->rows[r], from, towards, view->upto[r], &sums);
    set_below(view, sums.light);
    return view->all > 0 && variance(view->all, sum_lanes(sums.square), sum_lanes(sums.covered)) >
                                worth * relative * relative;
}

/* A target's share, of view.all. */
static double share_of(const guide_view *view, int row, int lane)
{
    const float before = row > 0 ? view->upto[row - 1][lane] : 0;

    return (double)(view->upto[row][lane] - before);
}

/* The lane in which *at falls; *at becomes the place in it. */
static int choose_lane(const guide_view *view, double *at)
{
    int lane = 0;

    for (int i = 1; i < GUIDE_LANES; i++)
        lane += view->below[i] <= *at;
    *at -= view->below[lane];
    return lane;
}

/* The row of a lane in which *at falls, by halving; *at becomes the place in it. */
static int choose_row(const guide_view *view, int rows, int lane, double *at)
{
    const double top = (double)view->upto[rows - 1][lane];
    int row = 0;

    for (int step = GUIDE_ROWS / 2; step > 0; step /= 2) {
        const int next = row + step;

        /* what is left of a lane that is full has nothing to choose */
        if (next < rows && (double)view->upto[next - 1][lane] <= *at &&
            (double)view->upto[next - 1][lane] < top)
            row = next;
    }
    *at -= row > 0 ? (double)view->upto[row - 1][lane] : 0;
    return row;
}

void guide_choose(const gather *g, const guide_view *view, double a, double b, guide_place *out)
{
    const guide *d = &g->guide;
    const guide_targets *t = &d->targets[view->detail];
    double at = a * view->all, q[2], share;
    const guide_cell *c;
    const guide_root *r;
    int lane, row;

    lane = choose_lane(view, &at);
    row = choose_row(view, t->row_count, lane, &at);
    share = share_of(view, row, lane);
    out->target = lane + GUIDE_LANES * row;
    c = cell_at(d, t->items[out->target].cell);
    r = root_at(d, c->root);
    q[0] = c->low[0] + c->size * fmin(at / share, 1);
    q[1] = c->low[1] + c->size * b;
    root_place(r, q, out->x);
    root_normal(g, r, out->normal);
    out->density = share / (view->all * t->items[out->target].area);
    out->surface = r->surface;
    out->back = r->back;
}

void guide_learn(const gather *g, guide_view *view, const int tries[GUIDE_TARGETS],
                 const int seen[GUIDE_TARGETS])
{
    float before[GUIDE_LANES] = {0}, sums[GUIDE_LANES] = {0}; /* up to a row, as it was and is */

    for (int r = 0; r < g->guide.targets[view->detail].row_count; r++)
        for (int i = 0; i < GUIDE_LANES; i++) {
            const int target = r * GUIDE_LANES + i;
            const float share = view->upto[r][i] - before[i];

            before[i] = view->upto[r][i];
            sums[i] += share * ((float)seen[target] + 0.5f) / ((float)tries[target] + 0.5f);
            view->upto[r][i] = sums[i];
        }
    set_below(view, sums);
}

double guide_density(const gather *g, const guide_view *view, uint32_t prim, int back,
                     const double st[2])
{
    const guide *d = &g->guide;
    const int32_t root = d->root_of[2 * prim + (uint32_t)back];
    const guide_cell *c;
    double q[2];
    int32_t number;

    if (root < 0)
        return 0;
    edges_to_square(root_at(d, (size_t)root)->triangle, st, q);
    c = cell_at(d, root_at(d, (size_t)root)->cell);
    while (c->target[view->detail] < 0 && c->child >= 0) {
        const int s = q[0] >= c->low[0] + 0.5 * c->size, t = q[1] >= c->low[1] + 0.5 * c->size;

        c = cell_at(d, c->child + 2 * s + t);
    }
    number = c->target[view->detail];
    if (number < 0)
        return 0;
    return share_of(view, number / GUIDE_LANES, number % GUIDE_LANES) /
           (view->all * d->targets[view->detail].items[number].area);
}
