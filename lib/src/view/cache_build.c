/* SPDX-License-Identifier: MIT */
/* Placing a cache's records: on ever finer grids of the picture, where those there are do not tell
 * the irradiance to the tolerance. */
#include "base/internal.h"
#include "geometry/vec.h"
#include "radiosity/engine.h"
#include "radiosity/gather_random.h"
#include "scene/scene_internal.h"
#include "view/field.h"
#include "view/internal.h"

#include <math.h>
#include <string.h>

enum { PROBES = 32, FEW = 8, SHRINKS = 6, SAMPLES_LEAST = 128, SAMPLES_MOST = 4096 };

/* Grids: every so many pixels, and the share of places without a record that get one: those near
 * them may then have one too. */
static const struct grid {
    size_t stride;
    double share;
} grids[] = {{16, 1}, {8, 1}, {4, 0.5}, {2, 0.5}, {1, 0.25}, {1, 1}};

static const double pi = 3.14159265358979323846;

static const uint64_t records_default = 32768;
/* Radius of a new record: at most this part of the harmonic mean distance of what it sees, between
 * so many pixels. Radii never shrink below the last. */
static const double reach_share = 0.25, first_pixels = 3, most_pixels = 96, least_pixels = 0.7;
/* Along walls records reach so many times as far as they would without them, in all at most so
 * many times as across. */
static const double stretch_share = 0.5, stretch_most = 4;
/* What the polynomial itself may err, of the tolerance. */
static const double model_share = 0.3;
/* Radii shrink where records within half of them tell something else, by so many deviations. */
static const double shrink_sure = 2.5;
/* Largest deviation allowed, of the tolerance. */
static const double allowed_share = 2.3;
/* Errors are smaller than the deviations expected, since the fit's priors are wide: by this factor,
 * which was 0.34 to 0.64 in a Cornell box, a room with coloured walls and a height field. */
static const double error_share = 0.55;
/* Part of the picture's mean irradiance below which errors are not relative any more. */
static const double dark = 0.02;

typedef struct placing {
    lcor_field *field;
    light_cache *cache;
    const lcor_field_options *options;
    double tolerance;
    const struct grid *grid;
    size_t *rows;   /* first piece of each picture row */
    float *samples; /* by piece: of a record to be made there */
    size_t first;   /* record of this grid */
} placing;

static lcor_status no_memory(lcor_error *err)
{
    return lcor_internal_fail(err, LCOR_ERR_NOMEM, -1, "no memory for the field");
}

static void run(const placing *p, size_t n, void (*task)(void *arg, size_t i))
{
    const lcor_parallel *parallel = &p->options->parallel;

    if (parallel->run && n > 1)
        parallel->run(parallel->user, n, task, (void *)p);
    else
        for (size_t i = 0; i < n; i++)
            task((void *)p, i);
}

/* ---- places of the picture ---- */

typedef struct place {
    double x[3], normal[3];
    double pixel[2]; /* least and largest size on the surface */
    size_t surface;
} place;

static double length_of(const scene_surface *s, double du, double dv)
{
    double step[3];

    for (int k = 0; k < 3; k++)
        step[k] = du * s->edge_u[k] + dv * s->edge_v[k];
    return vec_length(step);
}

static void find_place(const placing *p, size_t y, const lcor_span *span, size_t x, place *out)
{
    const lcor_view *view = p->field->view;
    const scene_surface *s = scene_surface_at(view->scene, span->surface);
    double size[2];
    lcor_place at;

    lcor_view_places(view, y, span, x, 1, &at);
    vec_plane_point(s->origin, s->edge_u, s->edge_v, at.uv[0], at.uv[1], out->x);
    (void)lcor_view_normal(view, span->surface, out->normal);
    size[0] = length_of(s, at.du[0], at.dv[0]);
    size[1] = length_of(s, at.du[1], at.dv[1]);
    out->pixel[0] = fmin(size[0], size[1]);
    out->pixel[1] = fmax(size[0], size[1]);
    out->surface = span->surface;
}

/* Calls visit for the pieces of a row that are on this grid. */
static void each_place(const placing *p, size_t y,
                       void (*visit)(const placing *p, size_t piece, const place *at, void *arg),
                       void *arg)
{
    size_t count, piece = p->rows[y];
    const lcor_span *spans = lcor_view_row(p->field->view, y, &count);

    for (size_t i = 0; i < count; i++)
        for (size_t x = spans[i].x0; x < spans[i].x1; x++, piece++) {
            place at;

            if (x % p->grid->stride != p->grid->stride / 2)
                continue;
            find_place(p, y, &spans[i], x, &at);
            visit(p, piece, &at, arg);
        }
}

static size_t grid_row(const placing *p, size_t i)
{
    return i * p->grid->stride + p->grid->stride / 2;
}

static size_t grid_rows(const placing *p)
{
    const size_t height = p->field->view->camera.size_y;

    return (height + p->grid->stride - 1 - p->grid->stride / 2) / p->grid->stride;
}

/* ---- what is needed ---- */

/* What needs no estimate. */
static double exact_at(const placing *p, const place *at)
{
    const lcor_solution *s = p->field->solution;
    double values[FIELD_CHANNELS_MAX], sum = 0;

    lcor_solution_direct_at(s, at->x, at->normal, (uint32_t)at->surface, values);
    s->engine->emitted(s, at->x, at->normal, (uint32_t)at->surface, values);
    for (size_t c = 0; c < p->cache->channels; c++)
        sum += values[c] / (double)p->cache->channels;
    return sum;
}

/* A number of 0..1 for each piece. */
static double dither(size_t piece)
{
    uint32_t state = (uint32_t)piece;

    return random_next(&state);
}

/* Samples of a record at a place; or less the relative deviation there, if that may stand.
 * Deviations fall with the root of the records' number: so many as are missing are spread over the
 * grid's places within the radius. On the last grids noise of many may stand, jumps may not. */
static double samples_at(const placing *p, size_t piece, const place *at)
{
    const double stride = (double)p->grid->stride;
    double scale, allowed, deviation, need, places, share, samples = SAMPLES_LEAST;
    cache_fit fit;

    cache_fit_at(p->cache, at->x, at->normal, 1, &fit);
    if (fit.count == 0)
        return dither(piece) < p->grid->share ? samples : 0;
    scale = exact_at(p, at);
    for (size_t c = 0; c < p->cache->channels; c++)
        scale += fit.value[c] / (double)p->cache->channels;
    scale = fmax(scale, p->cache->floor);
    if (!(scale > 0))
        return 0;
    allowed = allowed_share * p->tolerance * scale;
    deviation = hypot(fit.deviation, fit.unrest);
    need = (p->grid->stride > 1 || fit.count < FEW ? deviation : fit.unrest) / allowed;
    places = pi * fit.radius * fit.radius * fit.stretch /
             (at->pixel[0] * at->pixel[1] * stride * stride);
    places = fmax(1, places);
    if (!(dither(piece) * places < fmax((double)fit.count, FEW) * (need * need - 1)))
        return -deviation / scale;
    share = fmin(fmax(places / 4, 1), 9);
    while (samples < SAMPLES_MOST && fit.variance > samples * share * allowed * allowed)
        samples *= 2;
    return samples;
}

static void judge_place(const placing *p, size_t piece, const place *at, void *arg)
{
    (void)arg;
    p->samples[piece] = (float)samples_at(p, piece, at);
}

static void judge_row(void *arg, size_t i)
{
    const placing *p = arg;

    each_place(p, grid_row(p, i), judge_place, NULL);
}

typedef struct tally {
    size_t wanted;
    double keep, kept;      /* the part of the wanted records that is made; its sum */
    double places, squares; /* of deviations: those that stand, or what a record is made for */
} tally;

static void count_place(const placing *p, size_t piece, const place *at, void *arg)
{
    tally *t = arg;

    const double deviation =
        p->samples[piece] > 0 ? allowed_share * p->tolerance : (double)p->samples[piece];

    (void)at;
    t->wanted += p->samples[piece] > 0;
    t->places++;
    t->squares += deviation * deviation;
}

/* ---- records ---- */

/* Mean nearness (1 / distance) of what a place sees, and how much of it is walls across each
 * direction: the sum of nearness n n^T, n their normals in the frame u, v. */
typedef struct surroundings {
    double u[3], v[3], nearness, uu, uv, vv;
} surroundings;

/* By rays in directions that fill the hemisphere. */
static void look_around(const placing *p, const cache_record *at, surroundings *out)
{
    const double golden = 0.6180339887498949; /* spreads points of a line best */

    memset(out, 0, sizeof *out);
    vec_frame(at->normal, out->u, out->v);
    for (int i = 0; i < PROBES; i++) {
        lcor_ray ray = {.t_min = SCENE_TOUCH * p->cache->scene->diameter,
                        .t_max = HUGE_VAL,
                        .skip = at->surface};
        double d[3], near, u, v;
        const double *normal;
        lcor_bvh_hit hit;

        random_cosine((i + 0.5) / PROBES, golden * i - floor(golden * i), d);
        vec_copy(at->x, ray.origin);
        for (int k = 0; k < 3; k++)
            ray.direction[k] = d[0] * out->u[k] + d[1] * out->v[k] + d[2] * at->normal[k];
        if (!lcor_bvh_closest(p->cache->scene->bvh, &ray, &hit))
            continue;
        near = 1 / (hit.t * PROBES);
        normal = scene_surface_at(p->cache->scene, hit.owner)->normal;
        u = vec_dot(normal, out->u);
        v = vec_dot(normal, out->v);
        out->nearness += near;
        out->uu += near * u * u;
        out->uv += near * u * v;
        out->vv += near * v * v;
    }
}

/* Sets how far an estimate counts: a part of the harmonic mean distance of what its place sees.
 * Along a wall the view of that wall stays the same: there the others alone matter, as along the
 * edge of a room. */
static void set_reach(const placing *p, cache_record *r)
{
    const double most = r->radius;
    double middle, apart, across;
    surroundings s;

    look_around(p, r, &s);
    if (s.nearness > 0)
        r->radius = fmin(reach_share / s.nearness, most);
    r->stretch = 1;
    middle = (s.uu + s.vv) / 2;
    apart = hypot((s.uu - s.vv) / 2, s.uv);
    if (!(apart > 0))
        return;
    across = middle + apart; /* the larger eigenvalue; that vector's perpendicular is: */
    for (int k = 0; k < 3; k++)
        r->along[k] = s.uu > s.vv ? (across - s.vv) * s.v[k] - s.uv * s.u[k]
                                  : s.uv * s.v[k] - (across - s.uu) * s.u[k];
    (void)vec_normalize(r->along);
    r->stretch = stretch_share * s.nearness /
                 fmax(s.nearness - across, s.nearness * stretch_share / stretch_most);
    r->stretch = fmax(1, fmin(r->stretch, most / r->radius));
}

static void add_record(const placing *p, size_t piece, const place *at, void *arg)
{
    tally *t = arg;
    cache_record *r;

    if (!(p->samples[piece] > 0))
        return;
    t->kept += t->keep;
    if (floor(t->kept) == floor(t->kept - t->keep))
        return;
    r = cache_record_at(p->cache, p->cache->records.count++);
    *r = (cache_record){.samples = (uint32_t)p->samples[piece],
                        .least = least_pixels * at->pixel[0],
                        .radius = most_pixels * at->pixel[1],
                        .surface = (uint32_t)at->surface};
    vec_copy(at->x, r->x);
    vec_copy(at->normal, r->normal);
}

static void fill_record(void *arg, size_t i)
{
    const placing *p = arg;
    const lcor_solution *s = p->field->solution;
    cache_record *r = cache_record_at(p->cache, p->first + i);
    double total[FIELD_CHANNELS_MAX];
    cache_fit fit;

    cache_fit_at(p->cache, r->x, r->normal, 1, &fit);
    set_reach(p, r);
    if (fit.count > 0)
        r->radius = fmin(r->radius, fit.radius);
    r->radius = fmax(r->radius, first_pixels / least_pixels * r->least);
    lcor_solution_direct_at(s, r->x, r->normal, r->surface, total);
    for (size_t c = 0; c < p->cache->channels; c++)
        r->value[c] = total[c];
    s->engine->emitted(s, r->x, r->normal, r->surface, r->value);
    for (size_t c = 0; c < p->cache->channels; c++)
        r->exact += r->value[c] / (double)p->cache->channels;
    r->variance = s->engine->estimate(s, r->x, r->normal, r->surface, r->samples,
                                      (uint32_t)(p->first + i), total);
    for (size_t c = 0; c < p->cache->channels; c++)
        r->value[c] = total[c] - r->value[c];
}

static void fence_record(void *arg, size_t i)
{
    const placing *p = arg;

    cache_fence(p->cache, i);
}

/* Radii shrink where records do not lie on a polynomial. */
static void shrink_record(void *arg, size_t i)
{
    const placing *p = arg;
    cache_record *r = cache_record_at(p->cache, i);
    double total = r->exact, differs = 0;
    cache_fit whole, half;

    cache_fit_at(p->cache, r->x, r->normal, 1, &whole);
    cache_fit_at(p->cache, r->x, r->normal, 0.5, &half);
    for (size_t c = 0; c < p->cache->channels; c++) {
        total += whole.value[c] / (double)p->cache->channels;
        differs += (whole.value[c] - half.value[c]) / (double)p->cache->channels;
    }
    r->shrink = fabs(differs) >
                fmax(p->tolerance * fmax(total, p->cache->floor), shrink_sure * half.deviation);
}

/* Returns 0 without memory. */
static int fit_radii(placing *p)
{
    int shrunk = 1;

    for (int round = 0; round < SHRINKS && shrunk; round++) {
        shrunk = 0;
        if (!cache_index(p->cache))
            return 0;
        run(p, p->cache->records.count, fence_record);
        run(p, p->cache->records.count, shrink_record);
        for (size_t i = 0; i < p->cache->records.count; i++) {
            cache_record *r = cache_record_at(p->cache, i);

            shrunk |= r->shrink && r->radius > r->least;
            if (r->shrink && r->stretch > 1)
                r->stretch = 1;
            else if (r->shrink)
                r->radius = fmax(r->radius / 2, r->least);
        }
    }
    return cache_index(p->cache);
}

static void set_floor(placing *p)
{
    const light_cache *cache = p->cache;
    double sum = 0;

    for (size_t i = 0; i < cache->records.count; i++) {
        const cache_record *r = cache_record_at(cache, i);

        sum += r->exact;
        for (size_t c = 0; c < cache->channels; c++)
            sum += r->value[c] / (double)cache->channels;
    }
    p->cache->floor = cache->records.count > 0 ? dark * sum / (double)cache->records.count : 0;
}

/* One grid: judges its places, adds records where they are needed most, and fits radii. */
static lcor_status refine(placing *p, lcor_error *err)
{
    const uint64_t most = p->options->max_samples ? p->options->max_samples : records_default;
    light_cache *cache = p->cache;
    const double left = (double)most - (double)cache->records.count;
    tally t = {0, 1, 0, 0, 0};

    run(p, grid_rows(p), judge_row);
    for (size_t i = 0; i < grid_rows(p); i++)
        each_place(p, grid_row(p, i), count_place, &t);
    p->field->report.error = error_share * sqrt(t.squares / fmax(t.places, 1));
    if ((double)t.wanted > left)
        t.keep = left / (double)t.wanted;
    p->first = cache->records.count;
    if (!lcor_array_reserve(cache->allocator, &cache->records, t.wanted + 1, sizeof(cache_record)))
        return no_memory(err);
    for (size_t i = 0; i < grid_rows(p); i++)
        each_place(p, grid_row(p, i), add_record, &t);
    run(p, cache->records.count - p->first, fill_record);
    if (p->first == 0)
        set_floor(p);
    return fit_radii(p) ? LCOR_OK : no_memory(err);
}

static lcor_status prepare(placing *p, lcor_error *err)
{
    const lcor_view *view = p->field->view;
    const size_t height = view->camera.size_y;

    p->rows = lcor_internal_alloc(p->cache->allocator, (height + 1) * sizeof *p->rows);
    if (!p->rows)
        return no_memory(err);
    p->rows[0] = 0;
    for (size_t y = 0; y < height; y++) {
        size_t count;
        const lcor_span *spans = lcor_view_row(view, y, &count);

        p->rows[y + 1] = p->rows[y];
        for (size_t i = 0; i < count; i++)
            p->rows[y + 1] += spans[i].x1 - spans[i].x0;
    }
    p->samples =
        lcor_internal_alloc(p->cache->allocator, (p->rows[height] + 1) * sizeof *p->samples);
    return p->samples ? LCOR_OK : no_memory(err);
}

lcor_status cache_build(lcor_field *field, const lcor_field_options *options, lcor_error *err)
{
    /* Noise below the solution's own error would be work for nothing. */
    const double tolerance = fmax(options->tolerance, field->solution->options.tolerance);
    placing p = {
        .field = field, .cache = &field->cache, .options = options, .tolerance = tolerance};
    const lcor_progress *progress = &options->progress;
    lcor_status status;

    field->cache = (light_cache){.allocator = &field->allocator,
                                 .scene = field->view->scene,
                                 .channels = (size_t)field->report.channels,
                                 .tolerance = model_share * tolerance};
    status = prepare(&p, err);
    for (size_t i = 0; i < sizeof grids / sizeof *grids && status == LCOR_OK; i++) {
        p.grid = &grids[i];
        status = refine(&p, err);
        if (status == LCOR_OK && progress->report &&
            progress->report(progress->user, (double)(i + 1) / (sizeof grids / sizeof *grids)))
            status = lcor_internal_fail(err, LCOR_ERR_CANCELLED, -1, "cancelled");
    }
    field->report.samples = field->cache.records.count;
    lcor_internal_free(&field->allocator, p.rows);
    lcor_internal_free(&field->allocator, p.samples);
    return status;
}
