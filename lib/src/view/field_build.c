/* SPDX-License-Identifier: MIT */
/* Sampling a field: cells are split where samples within them differ from the interpolant. */
#include "base/internal.h"
#include "geometry/vec.h"
#include "radiosity/engine.h"
#include "scene/scene_internal.h"
#include "view/field.h"
#include "view/internal.h"

#include <math.h>

/* Picture places that stand for their neighbours when pixels of cells are counted. */
enum { STRIDE_X = 8, STRIDE_Y = 4 };
/* Cells of fewer pixels are not split; smaller ones still get fewer nodes. */
enum { PIXELS_SPLIT = 64, PIXELS_QUARTIC = 144, PIXELS_QUADRATIC = 16 };
/* Cells sampled by one call to the solution. */
enum { BATCH = 1024 };
enum { TESTS = 4, POINTS_MAX = FIELD_NODES * FIELD_NODES + TESTS };

static const double tolerance_default = 1e-3;
static const uint64_t samples_default = 32768;
/* Samples keep this distance from edges, where two surfaces meet. */
static const double inset = 1e-5;
/* Part of the picture's mean irradiance below which errors are not relative any more. */
static const double dark = 0.02;

/* Where the interpolant is tried: near the edges, where it is worst. */
static const double test_places[TESTS][2] = {
    {0.125, 0.375}, {0.625, 0.125}, {0.875, 0.625}, {0.375, 0.875}};

/* A picture place on its surface, and the cell it has come down to. */
typedef struct seen_place {
    double st[2];
    size_t cell;
} seen_place;

/* What the test places of a cell gave, per channel. */
typedef struct test_result {
    double differs[TESTS][FIELD_CHANNELS_MAX], total[TESTS][FIELD_CHANNELS_MAX];
} test_result;

typedef struct build {
    lcor_field *field;
    const lcor_field_options *options;
    lcor_array places;                         /* seen_place */
    lcor_array tests;                          /* test_result of each cell from `first` on */
    size_t first;                              /* cell of this round */
    double *points, *normals, *total, *direct; /* of one batch */
    double done;                               /* last progress reported */
    double floor;                              /* irradiance below which errors are absolute */
} build;

static lcor_status no_memory(lcor_error *err)
{
    return lcor_internal_fail(err, LCOR_ERR_NOMEM, -1, "no memory for the field");
}

/* ---- the parts of surfaces and where they are seen ---- */

/* One part for a parallelogram, else the triangles of a fan from the first corner. */
static lcor_status add_parts(build *b, size_t surface, lcor_error *err)
{
    lcor_field *field = b->field;
    const scene_surface *shape = scene_surface_at(field->view->scene, surface);
    const double *corners = scene_corners(field->view->scene, shape);
    const int quad = shape->shape == SCENE_QUAD;
    const size_t count = quad ? 1 : shape->corner_count - 2;
    field_part *part = lcor_array_reserve(&field->allocator, &field->parts, count, sizeof *part);

    if (!part)
        return no_memory(err);
    for (size_t i = 0; i < count; i++) {
        part[i] = (field_part){.triangle = !quad};
        if (!quad) {
            lcor_scene_coordinates(shape, corners + 3 * (i + 1), &part[i].b[0], &part[i].b[1]);
            lcor_scene_coordinates(shape, corners + 3 * (i + 2), &part[i].c[0], &part[i].c[1]);
        }
    }
    field->surfaces[surface] = (field_surface){field->parts.count, count};
    field->parts.count += count;
    return LCOR_OK;
}

static lcor_status add_cell(build *b, const field_cell *cell, lcor_error *err)
{
    field_cell *out = lcor_array_reserve(&b->field->allocator, &b->field->cells, 1, sizeof *out);

    if (!out)
        return no_memory(err);
    *out = *cell;
    b->field->cells.count++;
    return LCOR_OK;
}

/* The root of each part starts empty and inside out; the picture then widens it. */
static lcor_status add_roots(build *b, size_t surface, lcor_error *err)
{
    const field_surface *seen = &b->field->surfaces[surface];
    lcor_status status = LCOR_OK;

    for (size_t i = 0; i < seen->part_count && status == LCOR_OK; i++) {
        const field_cell root = {
            .low = {HUGE_VAL, HUGE_VAL}, /* size holds the upper end until finish_roots */
            .size = {-HUGE_VAL, -HUGE_VAL},
            .surface = surface,
            .part = seen->part + i};

        field_part_at(b->field, seen->part + i)->root = b->field->cells.count;
        status = add_cell(b, &root, err);
    }
    return status;
}

static void widen(field_cell *root, const double st[2])
{
    for (int k = 0; k < 2; k++) {
        root->low[k] = fmin(root->low[k], st[k]);
        root->size[k] = fmax(root->size[k], st[k]);
    }
}

/* Counts a place of the picture for its cell; `pixels` 0 only widens the root. */
static lcor_status see_place(build *b, size_t y, const lcor_span *span, size_t x, double pixels,
                             int remember, lcor_error *err)
{
    lcor_field *field = b->field;
    field_cell *root;
    lcor_place place;
    seen_place *seen, found;

    lcor_view_places(field->view, y, span, x, 1, &place);
    found.cell = field_part_of(field, span->surface, place.uv, found.st)->root;
    root = field_cell_at(field, found.cell);
    widen(root, found.st);
    root->pixels += pixels;
    if (!remember)
        return LCOR_OK;
    seen = lcor_array_reserve(&field->allocator, &b->places, 1, sizeof *seen);
    if (!seen)
        return no_memory(err);
    *seen = found;
    b->places.count++;
    return LCOR_OK;
}

/* Both ends of a span bound what it shows of a part, since s and t are monotone along it unless
 * the part changes; a few places between them see to that. */
static lcor_status see_span(build *b, size_t y, const lcor_span *span, lcor_error *err)
{
    const size_t last = span->x1 - 1;
    lcor_status status;

    if (b->field->surfaces[span->surface].part_count == 0) {
        status = add_parts(b, span->surface, err);
        if (status == LCOR_OK)
            status = add_roots(b, span->surface, err);
        if (status != LCOR_OK)
            return status;
    }
    status = see_place(b, y, span, span->x0, 0, 0, err);
    if (status == LCOR_OK && last > span->x0)
        status = see_place(b, y, span, last, 0, 0, err);
    for (size_t x = span->x0 + (STRIDE_X - 1 - span->x0 % STRIDE_X);
         x <= last && y % STRIDE_Y == STRIDE_Y / 2 && status == LCOR_OK; x += STRIDE_X)
        status = see_place(b, y, span, x, STRIDE_X * STRIDE_Y, 1, err);
    return status;
}

static lcor_status see_picture(build *b, lcor_error *err)
{
    const lcor_view *view = b->field->view;

    for (size_t y = 0; y < view->camera.size_y; y++) {
        size_t count;
        const lcor_span *spans = lcor_view_row(view, y, &count);

        for (size_t i = 0; i < count; i++) {
            const lcor_status status = see_span(b, y, &spans[i], err);

            if (status != LCOR_OK)
                return status;
        }
    }
    return LCOR_OK;
}

static void finish_roots(lcor_field *field)
{
    for (size_t i = 0; i < field->cells.count; i++) {
        field_cell *root = field_cell_at(field, i);

        if (!(root->size[0] >= root->low[0])) /* a part of the surface that is not seen */
            root->low[0] = root->low[1] = root->size[0] = root->size[1] = 0;
        for (int k = 0; k < 2; k++)
            root->size[k] = fmax(root->size[k] - root->low[k], 1e-9);
        root->nodes = root->pixels <= PIXELS_QUADRATIC ? 2
                      : root->pixels <= PIXELS_QUARTIC ? 3
                                                       : FIELD_NODES;
    }
}

/* ---- sampling ---- */

static int tested(const field_cell *cell) { return cell->nodes == FIELD_NODES; }

static size_t points_of(const field_cell *cell)
{
    return (size_t)cell->nodes * cell->nodes + (tested(cell) ? TESTS : 0);
}

/* Place of point `index` of a cell in the cell, 0..1: nodes first, then tests. */
static void place_in_cell(const field_cell *cell, size_t index, double place[2])
{
    const size_t nodes = cell->nodes;

    if (index >= nodes * nodes) {
        place[0] = test_places[index - nodes * nodes][0];
        place[1] = test_places[index - nodes * nodes][1];
    } else {
        place[0] = (double)(index / nodes) / (double)(nodes - 1);
        place[1] = (double)(index % nodes) / (double)(nodes - 1);
    }
}

static void place_in_square(const field_cell *cell, size_t index, double st[2])
{
    double place[2];

    place_in_cell(cell, index, place);
    for (int k = 0; k < 2; k++)
        st[k] = cell->low[k] + place[k] * cell->size[k];
}

static void set_point(const build *b, const field_cell *cell, size_t index, size_t at)
{
    const lcor_view *view = b->field->view;
    const scene_surface *shape = scene_surface_at(view->scene, cell->surface);
    double st[2], uv[2];

    place_in_square(cell, index, st);
    for (int k = 0; k < 2; k++)
        st[k] = fmin(fmax(st[k], inset), 1 - inset);
    field_to_uv(field_part_at(b->field, cell->part), st, uv);
    vec_plane_point(shape->origin, shape->edge_u, shape->edge_v, uv[0], uv[1], b->points + 3 * at);
    lcor_view_normal(view, cell->surface, b->normals + 3 * at);
}

/* Takes over what the solution gave for a cell's points from place `at` of the batch. */
static void store_samples(build *b, const field_cell *cell, test_result *result, size_t at)
{
    const size_t channels = (size_t)b->field->report.channels;
    const size_t nodes = (size_t)cell->nodes * cell->nodes;
    double *value = (double *)b->field->values.items + cell->first;

    for (size_t i = 0; i < nodes * channels; i++)
        value[i] = b->total[at * channels + i] - b->direct[at * channels + i];
    for (size_t i = 0; tested(cell) && i < TESTS; i++) {
        const size_t from = (at + nodes + i) * channels;
        double st[2], guess[FIELD_CHANNELS_MAX];

        place_in_square(cell, nodes + i, st);
        field_interpolate(b->field, cell, st, guess);
        for (size_t c = 0; c < channels; c++) {
            result->total[i][c] = b->total[from + c];
            result->differs[i][c] = fabs(guess[c] + b->direct[from + c] - b->total[from + c]);
        }
    }
}

/* Samples cells begin..end-1, at most BATCH of them. */
static lcor_status sample_batch(build *b, size_t begin, size_t end, lcor_error *err)
{
    lcor_field *field = b->field;
    size_t count = 0, at = 0;
    test_result *results;
    lcor_status status;

    for (size_t i = begin; i < end; i++)
        for (size_t k = 0; k < points_of(field_cell_at(field, i)); k++)
            set_point(b, field_cell_at(field, i), k, count++);
    results = lcor_array_reserve(&field->allocator, &b->tests, end - begin, sizeof *results);
    if (!results || !lcor_array_reserve(&field->allocator, &field->values,
                                        count * (size_t)field->report.channels, sizeof(double)))
        return no_memory(err);
    status =
        lcor_solution_at(field->solution, count, b->points, b->normals, b->total, b->direct, err);
    if (status != LCOR_OK)
        return status;
    for (size_t i = begin; i < end; i++) {
        field_cell *cell = field_cell_at(field, i);

        results[i - begin] = (test_result){0};
        cell->first = field->values.count;
        field->values.count += (size_t)cell->nodes * cell->nodes * (size_t)field->report.channels;
        store_samples(b, cell, &results[i - begin], at);
        at += points_of(cell);
    }
    b->tests.count += end - begin;
    field->report.samples += count;
    return LCOR_OK;
}

/* ---- judging and splitting ---- */

/* The mean irradiance of the picture as the roots' nodes show it. */
static double mean_irradiance(const build *b)
{
    const lcor_field *field = b->field;
    const size_t channels = (size_t)field->report.channels;
    double sum = 0, pixels = 0;

    for (size_t i = 0; i < field->cells.count; i++) {
        const field_cell *cell = field_cell_at(field, i);
        const test_result *result = (const test_result *)b->tests.items + i;

        for (size_t k = 0; tested(cell) && k < TESTS; k++)
            for (size_t c = 0; c < channels; c++)
                sum += cell->pixels * result->total[k][c];
        pixels += tested(cell) ? cell->pixels * TESTS * (double)channels : 0;
    }
    return pixels > 0 ? sum / pixels : 0;
}

/* Largest difference of a cell's tests, relative to the irradiance there or to the floor. */
static double worst_test(const build *b, size_t cell)
{
    const test_result *result = (const test_result *)b->tests.items + (cell - b->first);
    double worst = 0;

    for (int i = 0; i < TESTS; i++)
        for (int c = 0; c < b->field->report.channels; c++) {
            const double scale = fmax(result->total[i][c], b->floor);

            if (result->differs[i][c] > 0)
                worst = fmax(worst, result->differs[i][c] / scale);
        }
    return worst;
}

/* The tolerance at which splitting cells b->first..end-1 stays within max_samples. */
static double affordable(const build *b, double tolerance, size_t end)
{
    const uint64_t asked = b->options->max_samples ? b->options->max_samples : samples_default;
    const uint64_t left = asked > b->field->report.samples ? asked - b->field->report.samples : 0;

    for (;;) {
        uint64_t count = 0;

        for (size_t i = b->first; i < end; i++)
            if (worst_test(b, i) > tolerance && field_cell_at(b->field, i)->pixels > PIXELS_SPLIT)
                count += 4 * (uint64_t)POINTS_MAX;
        if (count <= left)
            return tolerance;
        tolerance *= 2;
    }
}

static lcor_status split(build *b, size_t index, lcor_error *err)
{
    const field_cell parent = *field_cell_at(b->field, index);
    lcor_status status = LCOR_OK;

    field_cell_at(b->field, index)->child = b->field->cells.count;
    for (int i = 0; i < 4 && status == LCOR_OK; i++) {
        const int half[2] = {i / 2, i % 2};
        field_cell child = {.surface = parent.surface, .part = parent.part};

        for (int k = 0; k < 2; k++) {
            child.size[k] = parent.size[k] / 2;
            child.low[k] = parent.low[k] + half[k] * child.size[k];
        }
        status = add_cell(b, &child, err);
    }
    return status;
}

/* Moves the picture's places down into new cells; cells without any stay without nodes. */
static void descend(build *b)
{
    lcor_field *field = b->field;
    seen_place *place = b->places.items;

    for (size_t i = 0; i < b->places.count; i++) {
        const field_cell *cell = field_cell_at(field, place[i].cell);
        size_t half[2];

        if (!cell->child)
            continue;
        for (int k = 0; k < 2; k++)
            half[k] = place[i].st[k] > cell->low[k] + cell->size[k] / 2;
        place[i].cell = cell->child + 2 * half[0] + half[1];
        field_cell_at(field, place[i].cell)->pixels += STRIDE_X * STRIDE_Y;
        field_cell_at(field, place[i].cell)->nodes = FIELD_NODES;
    }
}

/* How many cells will follow is not known, so progress may pause. */
static lcor_status report_progress(build *b, double done, lcor_error *err)
{
    const lcor_progress *progress = &b->options->progress;

    b->done = fmax(b->done, done);
    if (progress->report && progress->report(progress->user, b->done))
        return lcor_internal_fail(err, LCOR_ERR_CANCELLED, -1, "cancelled");
    return LCOR_OK;
}

/* One round: samples the cells from b->first on and splits those that need it. */
static lcor_status refine(build *b, lcor_error *err)
{
    lcor_field *field = b->field;
    double tolerance = b->options->tolerance > 0 ? b->options->tolerance : tolerance_default;
    const size_t end = field->cells.count;
    lcor_status status = LCOR_OK;

    b->tests.count = 0;
    for (size_t i = b->first; i < end && status == LCOR_OK; i += BATCH) {
        status = sample_batch(b, i, i + BATCH < end ? i + BATCH : end, err);
        if (status == LCOR_OK)
            status = report_progress(b, (double)i / (double)end, err);
    }
    if (status != LCOR_OK)
        return status;
    if (b->first == 0)
        b->floor = dark * mean_irradiance(b);
    tolerance = affordable(b, tolerance, end);
    for (size_t i = b->first; i < end && status == LCOR_OK; i++) {
        const double worst = worst_test(b, i);

        if (worst > tolerance && field_cell_at(field, i)->pixels > PIXELS_SPLIT)
            status = split(b, i, err);
        else if (worst > tolerance)
            field_cell_at(field, i)->torn = 1;
        else
            field->report.error = fmax(field->report.error, worst);
    }
    b->first = end;
    descend(b);
    return status;
}

static lcor_status build_all(build *b, lcor_error *err)
{
    lcor_field *field = b->field;
    const size_t points = (size_t)BATCH * POINTS_MAX;
    const size_t surfaces = field->view->surface_count; /* the view holds larger items of them */
    double *room;
    lcor_status status;

    field->surfaces = lcor_internal_alloc(&field->allocator, surfaces * sizeof *field->surfaces);
    room = lcor_internal_alloc(&field->allocator,
                               points * 2 * (3 + FIELD_CHANNELS_MAX) * sizeof *room);
    b->points = room;
    if (!field->surfaces || !room)
        return no_memory(err);
    b->normals = room + 3 * points;
    b->total = b->normals + 3 * points;
    b->direct = b->total + FIELD_CHANNELS_MAX * points;
    for (size_t i = 0; i < surfaces; i++)
        field->surfaces[i] = (field_surface){0};
    status = see_picture(b, err);
    if (status == LCOR_OK && field->solution->engine->estimate)
        return cache_build(field, b->options, err);
    finish_roots(field);
    while (status == LCOR_OK && b->first < field->cells.count)
        status = refine(b, err);
    return status;
}

lcor_status field_build(lcor_field *field, const lcor_field_options *options, lcor_error *err)
{
    build b = {.field = field, .options = options};
    lcor_status status = build_all(&b, err);

    lcor_internal_free(&field->allocator, b.points);
    lcor_array_clear(&field->allocator, &b.places);
    lcor_array_clear(&field->allocator, &b.tests);
    return status;
}
