/* SPDX-License-Identifier: MIT */
#include "view/field.h"

#include "base/internal.h"
#include "geometry/vec.h"
#include "radiosity/engine.h"
#include "scene/scene_internal.h"
#include "view/internal.h"

#include <math.h>
#include <string.h>

/* Samples of the solution's estimate where there is no other. */
enum { SAMPLES_UNTOLD = 256 };

void field_to_uv(const field_part *part, const double st[2], double uv[2])
{
    for (int k = 0; k < 2; k++)
        uv[k] = part->triangle ? st[1] * ((1 - st[0]) * part->b[k] + st[0] * part->c[k]) : st[k];
}

/* The inverse; returns how deep inside the part the place is, negative outside. */
static double from_uv(const field_part *part, const double uv[2], double st[2])
{
    double det, p, q;

    if (!part->triangle) {
        st[0] = uv[0];
        st[1] = uv[1];
        return fmin(fmin(uv[0], 1 - uv[0]), fmin(uv[1], 1 - uv[1]));
    }
    det = part->b[0] * part->c[1] - part->b[1] * part->c[0];
    p = (uv[0] * part->c[1] - uv[1] * part->c[0]) / det;
    q = (part->b[0] * uv[1] - part->b[1] * uv[0]) / det;
    st[1] = p + q;
    st[0] = st[1] > 0 ? q / st[1] : 0;
    return fmin(p, q);
}

/* Values at x of the polynomials that are 1 at one of n equidistant places of 0..1 and 0 at the
 * others. */
static void lagrange(unsigned n, double x, double *weights)
{
    if (n == 2) {
        weights[0] = 1 - x;
        weights[1] = x;
    } else if (n == 3) {
        const double a = 2 * x, b = a - 1, c = a - 2;

        weights[0] = b * c / 2;
        weights[1] = -a * c;
        weights[2] = a * b / 2;
    } else {
        const double a = 4 * x, b = a - 1, c = a - 2, d = a - 3, e = a - 4;
        const double ab = a * b, de = d * e;

        weights[0] = b * c * de / 24;
        weights[1] = -a * c * de / 6;
        weights[2] = ab * de / 4;
        weights[3] = -ab * c * e / 6;
        weights[4] = ab * c * d / 24;
    }
}

void field_interpolate(const lcor_field *field, const field_cell *cell, const double st[2],
                       double *indirect)
{
    const size_t channels = (size_t)field->report.channels;
    const double *value = (const double *)field->values.items + cell->first;
    double ws[FIELD_NODES], wt[FIELD_NODES];

    lagrange(cell->nodes, (st[0] - cell->low[0]) / cell->size[0], ws);
    lagrange(cell->nodes, (st[1] - cell->low[1]) / cell->size[1], wt);
    for (size_t c = 0; c < channels; c++)
        indirect[c] = 0;
    for (unsigned i = 0; i < cell->nodes; i++)
        for (unsigned j = 0; j < cell->nodes; j++)
            for (size_t c = 0; c < channels; c++)
                indirect[c] += ws[i] * wt[j] * *value++;
}

/* The smallest cell with values around a place, which is moved into the seen part. */
static const field_cell *find_cell(const lcor_field *field, const field_part *part, double st[2])
{
    const field_cell *cell = field_cell_at(field, part->root);

    for (int k = 0; k < 2; k++)
        st[k] = fmin(fmax(st[k], cell->low[k]), cell->low[k] + cell->size[k]);
    while (cell->child) {
        const size_t s = st[0] > cell->low[0] + cell->size[0] / 2;
        const size_t t = st[1] > cell->low[1] + cell->size[1] / 2;
        const field_cell *child = field_cell_at(field, cell->child + 2 * s + t);

        if (child->nodes == 0)
            break;
        cell = child;
    }
    return cell;
}

const field_part *field_part_of(const lcor_field *field, size_t surface, const double uv[2],
                                double st[2])
{
    const field_surface *seen = &field->surfaces[surface];
    const field_part *part = field_part_at(field, seen->part), *best = part;
    double deepest = from_uv(part, uv, st);

    for (size_t i = 1; i < seen->part_count; i++) {
        double other[2];
        const double depth = from_uv(part + i, uv, other);

        if (depth > deepest) {
            deepest = depth;
            best = part + i;
            st[0] = other[0];
            st[1] = other[1];
        }
    }
    return best;
}

/* What the solution says at the place itself, less what is direct. */
static void ask_solution(const lcor_field *field, size_t surface, const double x[3],
                         const double normal[3], const double *direct, double *indirect)
{
    const lcor_solution *s = field->solution;
    const size_t channels = (size_t)field->report.channels;

    memcpy(indirect, direct, channels * sizeof *indirect);
    if (s->engine->estimate)
        (void)s->engine->estimate(s, x, normal, (uint32_t)surface, SAMPLES_UNTOLD, 0, indirect);
    else
        s->engine->point(s, x, normal, (uint32_t)surface, 0, indirect);
    for (size_t c = 0; c < channels; c++)
        indirect[c] -= direct[c];
}

/* Returns 0 where the cell does not tell: at the foot of what stands on a surface, say, where light
 * jumps, and where it was split because it did not and no place of the part around was noticed. */
static int cells_at(const lcor_field *field, size_t surface, const double uv[2], double *indirect)
{
    double st[2];
    const field_part *part = field_part_of(field, surface, uv, st);
    const field_cell *cell = find_cell(field, part, st);

    if (cell->torn || cell->child)
        return 0;
    field_interpolate(field, cell, st, indirect);
    return 1;
}

/* Returns 0 where no record tells, as may be beyond the limit on samples. */
static int cache_at(const lcor_field *field, size_t surface, const double x[3],
                    const double normal[3], double *indirect)
{
    cache_fit fit;

    cache_fit_at(&field->cache, x, normal, 1, &fit);
    memcpy(indirect, fit.value, sizeof fit.value);
    field->solution->engine->emitted(field->solution, x, normal, (uint32_t)surface, indirect);
    return fit.count > 0;
}

lcor_status lcor_field_at(const lcor_field *field, size_t surface, size_t n, const double *uv,
                          double *total, double *direct, lcor_error *err)
{
    const lcor_view *view = field ? field->view : NULL;
    const scene_surface *shape;
    double normal[3];

    if (!field || (n > 0 && !uv) || surface >= view->surface_count)
        return lcor_internal_fail(err, LCOR_ERR_ARG, -1, "field: no points, or no such surface");
    if (field->surfaces[surface].part_count == 0)
        return lcor_internal_fail(err, LCOR_ERR_DOMAIN, (long)surface,
                                  "surface %lu is not seen in this view", (unsigned long)surface);
    shape = scene_surface_at(view->scene, surface);
    lcor_view_normal(view, surface, normal);
    for (size_t i = 0; i < n; i++) {
        const size_t channels = (size_t)field->report.channels;
        double point[3], straight[FIELD_CHANNELS_MAX], indirect[FIELD_CHANNELS_MAX];

        vec_plane_point(shape->origin, shape->edge_u, shape->edge_v, uv[2 * i], uv[2 * i + 1],
                        point);
        lcor_solution_direct_at(field->solution, point, normal, (uint32_t)surface, straight);
        if (total &&
            !(field->solution->engine->estimate ? cache_at(field, surface, point, normal, indirect)
                                                : cells_at(field, surface, uv + 2 * i, indirect)))
            ask_solution(field, surface, point, normal, straight, indirect);
        for (size_t c = 0; c < channels; c++) {
            if (total) /* polynomials may dip below zero beside black */
                total[channels * i + c] = straight[c] + fmax(indirect[c], 0);
            if (direct)
                direct[channels * i + c] = straight[c];
        }
    }
    return LCOR_OK;
}

void lcor_field_get_report(const lcor_field *field, lcor_field_report *report)
{
    *report = field->report;
}

void lcor_field_free(lcor_field *field)
{
    lcor_allocator allocator;

    if (!field)
        return;
    allocator = field->allocator;
    lcor_array_clear(&allocator, &field->parts);
    lcor_array_clear(&allocator, &field->cells);
    lcor_array_clear(&allocator, &field->values);
    cache_clear(&field->cache);
    lcor_internal_free(&allocator, field->surfaces);
    lcor_internal_free(&allocator, field);
}

lcor_status lcor_field_new(const lcor_solution *solution, const lcor_view *view,
                           const lcor_field_options *options, lcor_field **out, lcor_error *err)
{
    lcor_allocator given;
    lcor_field *field;
    lcor_status status;

    if (!solution || !view || !out || !options || options->struct_size == 0)
        return lcor_internal_fail(err, LCOR_ERR_ARG, -1,
                                  "a field needs a solution, a view and options");
    if (!(options->tolerance >= 0 && options->tolerance <= 1))
        return lcor_internal_fail(err, LCOR_ERR_DOMAIN, -1, "tolerance must lie between 0 and 1");
    status = lcor_internal_allocator(&options->allocator, &given, err);
    if (status != LCOR_OK)
        return status;
    field = lcor_internal_alloc(&given, sizeof *field);
    if (!field)
        return lcor_internal_fail(err, LCOR_ERR_NOMEM, -1, "no memory for the field");
    *field = (lcor_field){.allocator = given, .solution = solution, .view = view};
    field->report.channels = lcor_solution_report(solution)->channels;
    status = field_build(field, options, err);
    if (status == LCOR_OK)
        *out = field;
    else
        lcor_field_free(field);
    return status;
}
