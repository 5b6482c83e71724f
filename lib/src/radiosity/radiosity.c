/* SPDX-License-Identifier: MIT */
/* First solver: constant elements, final gather by exact factors, one channel or three. */
#include "base/internal.h"
#include "geometry/factor.h"
#include "geometry/vec.h"
#include "radiosity/direct.h"

#include <lcor/radiosity.h>

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { CHANNELS_MAX = 3, CHUNK = 64 };

static const double gauss3_x[3] = {0.1127016653792583, 0.5, 0.8872983346207417};
static const double gauss3_w[3] = {5.0 / 18, 8.0 / 18, 5.0 / 18};

typedef struct element {
    double   corners[12], centre[3], normal[3], probe[4][3], area;
    double   rho[CHANNELS_MAX], emission[CHANNELS_MAX];
    double   radiosity[CHANNELS_MAX];
    size_t   corner_count;
    uint32_t surface;
} element;

struct lcor_solution {
    lcor_allocator           allocator;
    const lcor_scene        *scene;
    lcor_radiosity_options   options;
    lcor_radiosity_report    report;
    element                 *elements;
    size_t                   count;
    unsigned char           *light_free;
};

static void run(const lcor_parallel *p, size_t n, void (*task)(void *, size_t), void *arg)
{
    if (p->run)
        p->run(p->user, n, task, arg);
    else
        for (size_t i = 0; i < n; i++)
            task(arg, i);
}

void lcor_solution_direct_at(const lcor_solution *s, const double x[3], const double n[3],
                             uint32_t skip, double *e)
{
    for (int c = 0; c < s->report.channels; c++)
        e[c] = 0;
    for (size_t i = 0; i < s->scene->lights.count; i++) {
        const lcor_light *light = scene_light_at(s->scene, i);
        const double      v = lcor_direct_unshadowed(light, x, n);

        if (v <= 0 || (!s->light_free[i] && lcor_direct_shadowed(s->scene, light, x, skip, NULL)))
            continue;
        if (s->report.channels == 1)
            e[0] += v * (light->intensity[0] * s->options.luminance[0] +
                         light->intensity[1] * s->options.luminance[1] +
                         light->intensity[2] * s->options.luminance[2]);
        else
            for (int c = 0; c < 3; c++)
                e[c] += v * light->intensity[c];
    }
}

static double factor_to(const lcor_solution *s, const double x[3], const double n[3],
                        uint32_t skip, const element *e)
{
    double d[3], f;
    int    open = 0;

    vec_sub(x, e->centre, d);
    if (vec_dot(d, e->normal) <= SCENE_TOUCH * s->scene->diameter)
        return 0;
    f = lcor_factor_point(x, n, e->corner_count, e->corners);
    if (f <= 0 || s->scene->convex)
        return f;
    for (int k = 0; k < 4; k++)
        open += !lcor_scene_blocked(s->scene, x, e->probe[k], skip, NULL);
    return f * open / 4;
}

static void gather(const lcor_solution *s, const double x[3], const double n[3], uint32_t skip,
                   double *e)
{
    for (int c = 0; c < s->report.channels; c++)
        e[c] = 0;
    for (size_t i = 0; i < s->count; i++) {
        const double f = factor_to(s, x, n, skip, &s->elements[i]);

        for (int c = 0; c < s->report.channels; c++)
            e[c] += f * s->elements[i].radiosity[c];
    }
}

static size_t steps(double length, double h)
{
    const double n = floor(length / h + 0.5);

    return n < 1 ? 1 : n > 64 ? 64 : (size_t)n;
}

static void make_element(const lcor_solution *s, const scene_surface *f, size_t index,
                         const scene_patch *p, int back, element *e)
{
    double cross[3], area = 0;

    memset(e, 0, sizeof *e);
    e->surface = (uint32_t)index;
    e->corner_count = (size_t)p->corner_count;
    for (int c = 0; c < p->corner_count; c++) {
        const int d = c + 1 < p->corner_count ? c + 1 : 0;

        vec_plane_point(f->origin, f->edge_u, f->edge_v, p->s[c], p->t[c], e->corners + 3 * c);
        vec_add_scaled(e->centre, 1.0 / p->corner_count, e->corners + 3 * c, e->centre);
        area += 0.5 * (p->s[c] * p->t[d] - p->s[d] * p->t[c]);
    }
    vec_cross(f->edge_u, f->edge_v, cross);
    e->area = area * vec_length(cross);
    for (int k = 0; k < 4; k++)
        for (int j = 0; j < 3; j++)
            e->probe[k][j] = 0.5 * e->centre[j] + 0.5 * e->corners[3 * (k % p->corner_count) + j];
    for (int k = 0; k < 3; k++)
        e->normal[k] = back ? -f->normal[k] : f->normal[k];
    for (int c = 0; c < s->report.channels; c++)
        if (s->report.channels == 1) {
            for (int k = 0; k < 3; k++) {
                e->rho[0] += f->look.reflectance[k] * s->options.luminance[k];
                e->emission[0] += f->look.emission[k] * s->options.luminance[k];
            }
        } else {
            e->rho[c] = f->look.reflectance[c];
            e->emission[c] = f->look.emission[c];
        }
}

static size_t elements(const lcor_solution *s, double h, element *out)
{
    size_t n = 0;

    for (size_t i = 0; i < s->scene->surfaces.count; i++) {
        const scene_surface *f = scene_surface_at(s->scene, i);
        scene_surface        grid = *f;

        grid.look.patches[0] = steps(vec_length(f->edge_u), h);
        grid.look.patches[1] = steps(vec_length(f->edge_v), h);
        for (int back = 0; back <= (f->look.two_sided != 0); back++)
            for (size_t k = 0; k < lcor_scene_patches_of(&grid); k++, n++)
                if (out) {
                    scene_patch p;

                    lcor_scene_patch(s->scene, &grid, k, &p);
                    make_element(s, f, i, &p, back, &out[n]);
                }
    }
    return n;
}

typedef struct matrix_job {
    const lcor_solution *s;
    float               *m;
    double              *direct;
} matrix_job;

static void matrix_row(void *arg, size_t i)
{
    matrix_job    *job = arg;
    const element *e = &job->s->elements[i];

    for (size_t j = 0; j < job->s->count; j++)
        job->m[i * job->s->count + j] =
            (float)factor_to(job->s, e->centre, e->normal, e->surface, &job->s->elements[j]);
    lcor_solution_direct_at(job->s, e->centre, e->normal, e->surface, job->direct + CHANNELS_MAX * i);
}

static lcor_status solve(lcor_solution *s, lcor_error *err)
{
    const size_t n = s->count;
    matrix_job   job = {s, NULL, NULL};

    job.m = lcor_internal_alloc(&s->allocator, n * n * sizeof *job.m);
    job.direct = lcor_internal_alloc(&s->allocator, n * CHANNELS_MAX * sizeof *job.direct);
    if (!job.m || !job.direct) {
        lcor_internal_free(&s->allocator, job.m);
        lcor_internal_free(&s->allocator, job.direct);
        return lcor_internal_fail(err, LCOR_ERR_NOMEM, -1, "no memory for the form factors");
    }
    run(&s->options.parallel, n, matrix_row, &job);
    for (size_t i = 0; i < n; i++)
        for (int c = 0; c < s->report.channels; c++)
            s->elements[i].radiosity[c] = s->elements[i].emission[c];
    for (s->report.iterations = 1; s->report.iterations < 2000; s->report.iterations++) {
        double change = 0, largest = 0;

        for (size_t i = 0; i < n; i++)
            for (int c = 0; c < s->report.channels; c++) {
                double e = job.direct[CHANNELS_MAX * i + (size_t)c], b;

                for (size_t j = 0; j < n; j++)
                    e += (double)job.m[i * n + j] * s->elements[j].radiosity[c];
                b = s->elements[i].emission[c] + s->elements[i].rho[c] * e;
                change = fmax(change, fabs(b - s->elements[i].radiosity[c]));
                largest = fmax(largest, b);
                s->elements[i].radiosity[c] = b;
            }
        if (change <= 1e-6 * largest)
            break;
    }
    lcor_internal_free(&s->allocator, job.m);
    lcor_internal_free(&s->allocator, job.direct);
    return LCOR_OK;
}

static int grey(const double v[3]) { return v[0] == v[1] && v[1] == v[2]; }

static lcor_status prepare(lcor_solution *s, lcor_error *err)
{
    const lcor_scene *scene = s->scene;
    double            area = 0;

    s->report.channels = s->options.channels;
    if (s->report.channels == 0) {
        s->report.channels = 1;
        for (size_t i = 0; i < scene->lights.count; i++)
            if (!grey(scene_light_at(scene, i)->intensity))
                s->report.channels = 3;
        for (size_t i = 0; i < scene->surfaces.count; i++)
            if (!grey(scene_surface_at(scene, i)->look.emission))
                s->report.channels = 3;
    }
    s->light_free = lcor_internal_alloc(&s->allocator, scene->lights.count);
    for (size_t i = 0; s->light_free && i < scene->lights.count; i++)
        s->light_free[i] = scene->convex && scene_light_at(scene, i)->kind != LCOR_LIGHT_DIRECTIONAL &&
                           lcor_scene_inside(scene, scene_light_at(scene, i)->position);
    for (size_t i = 0; i < scene->surfaces.count; i++)
        area += scene_surface_at(scene, i)->area;
    s->count = elements(s, sqrt(area / 500), NULL);
    s->elements = lcor_internal_alloc(&s->allocator, s->count * sizeof *s->elements);
    if (!s->elements || !s->light_free)
        return lcor_internal_fail(err, LCOR_ERR_NOMEM, -1, "no memory for the elements");
    (void)elements(s, sqrt(area / 500), s->elements);
    return solve(s, err);
}

static lcor_status check_options(const lcor_radiosity_options *o, lcor_error *err)
{
    if (!(o->tolerance == 0 || (o->tolerance >= 1e-5 && o->tolerance <= 1)))
        return lcor_internal_fail(err, LCOR_ERR_DOMAIN, -1,
                                  "radiosity: tolerance must be 1e-5 .. 1");
    if (o->channels != 0 && o->channels != 1 && o->channels != 3)
        return lcor_internal_fail(err, LCOR_ERR_ARG, -1, "radiosity: channels must be 0, 1 or 3");
    return LCOR_OK;
}

lcor_status lcor_radiosity_solve(const lcor_scene *scene, const lcor_radiosity_options *options,
                                 lcor_solution **out, lcor_error *err)
{
    lcor_radiosity_options o;
    lcor_allocator         own;
    lcor_solution         *s;
    lcor_status            status;
    double                 sum;

    if (!scene || !out || (options && options->struct_size == 0))
        return lcor_internal_fail(err, LCOR_ERR_ARG, -1,
                                  "radiosity: scene or out is NULL, or struct_size unset");
    if (!scene->committed)
        return lcor_internal_fail(err, LCOR_ERR_ARG, -1,
                                  "radiosity: the scene is not committed (lcor_scene_commit)");
    memset(&o, 0, sizeof o);
    if (options)
        memcpy(&o, options, options->struct_size < sizeof o ? options->struct_size : sizeof o);
    status = check_options(&o, err);
    if (status == LCOR_OK)
        status = lcor_internal_allocator(&o.allocator, &own, err);
    if (status != LCOR_OK)
        return status;
    sum = o.luminance[0] + o.luminance[1] + o.luminance[2];
    if (sum == 0) {
        o.luminance[0] = 0.2126;
        o.luminance[1] = 0.7152;
        o.luminance[2] = 0.0722;
        sum = 1;
    }
    for (int c = 0; c < 3; c++)
        o.luminance[c] /= sum;
    s = lcor_internal_alloc(&own, sizeof *s);
    if (!s)
        return lcor_internal_fail(err, LCOR_ERR_NOMEM, -1, "no memory for a solution");
    memset(s, 0, sizeof *s);
    s->allocator = own;
    s->scene = scene;
    s->options = o;
    s->report.engine = LCOR_ENGINE_LINKS;
    s->report.converged = 1;
    s->report.error_rms = s->report.error_max = 0.01;
    status = prepare(s, err);
    if (status != LCOR_OK) {
        lcor_solution_free(s);
        return status;
    }
    s->report.elements = s->count;
    s->report.bytes = s->count * sizeof *s->elements;
    (void)snprintf(s->report.models, sizeof s->report.models, "%s; %d channel%s",
                   scene->convex ? "convex: no visibility tests" : "visibility by rays",
                   s->report.channels, s->report.channels == 1 ? "" : "s");
    *out = s;
    return LCOR_OK;
}

lcor_status lcor_solution_update(lcor_solution *s, lcor_error *err)
{
    lcor_internal_free(&s->allocator, s->elements);
    lcor_internal_free(&s->allocator, s->light_free);
    s->elements = NULL;
    s->light_free = NULL;
    return prepare(s, err);
}

void lcor_solution_free(lcor_solution *s)
{
    if (!s)
        return;
    lcor_internal_free(&s->allocator, s->elements);
    lcor_internal_free(&s->allocator, s->light_free);
    lcor_internal_free(&s->allocator, s);
}

const lcor_radiosity_report *lcor_solution_report(const lcor_solution *s) { return &s->report; }

typedef struct patch_job {
    const lcor_solution *s;
    const scene_surface *f;
    size_t               surface, count;
    lcor_value           value;
    double              *total, *direct;
} patch_job;

static void direct_of_patch(const patch_job *job, const scene_patch *p, const double centre[3],
                            double *e)
{
    const lcor_solution *s = job->s;
    const int            last = p->corner_count - 1;
    double               weight = 0;

    if (job->value == LCOR_VALUE_CENTRE) {
        lcor_solution_direct_at(s, centre, job->f->normal, (uint32_t)job->surface, e);
        return;
    }
    for (int c = 0; c < s->report.channels; c++)
        e[c] = 0;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            const double a = gauss3_x[i], b = gauss3_x[j] * (last == 2 ? 1 - a : 1);
            const double w = gauss3_w[i] * gauss3_w[j] * (last == 2 ? 1 - a : 1);
            double       x[3], d[CHANNELS_MAX];

            vec_plane_point(job->f->origin, job->f->edge_u, job->f->edge_v,
                            p->s[0] + a * (p->s[1] - p->s[0]) + b * (p->s[last] - p->s[0]),
                            p->t[0] + a * (p->t[1] - p->t[0]) + b * (p->t[last] - p->t[0]), x);
            lcor_solution_direct_at(s, x, job->f->normal, (uint32_t)job->surface, d);
            weight += w;
            for (int c = 0; c < s->report.channels; c++)
                e[c] += w * d[c];
        }
    for (int c = 0; c < s->report.channels; c++)
        e[c] /= weight;
}

static void patch_chunk(void *arg, size_t chunk)
{
    const patch_job *job = arg;
    const size_t     channels = (size_t)job->s->report.channels;

    for (size_t i = chunk * CHUNK; i < job->count && i < (chunk + 1) * CHUNK; i++) {
        scene_patch p;
        double      a = 0, b = 0, x[3], direct[CHANNELS_MAX], indirect[CHANNELS_MAX];

        lcor_scene_patch(job->s->scene, job->f, i, &p);
        for (int c = 0; c < p.corner_count; c++) {
            a += p.s[c] / p.corner_count;
            b += p.t[c] / p.corner_count;
        }
        vec_plane_point(job->f->origin, job->f->edge_u, job->f->edge_v, a, b, x);
        direct_of_patch(job, &p, x, direct);
        if (job->total)
            gather(job->s, x, job->f->normal, (uint32_t)job->surface, indirect);
        for (size_t c = 0; c < channels; c++) {
            if (job->direct)
                job->direct[channels * i + c] = direct[c];
            if (job->total)
                job->total[channels * i + c] = direct[c] + indirect[c];
        }
    }
}

lcor_status lcor_solution_patches(const lcor_solution *s, size_t surface, lcor_value value,
                                  double *total, double *direct, lcor_error *err)
{
    patch_job job = {s, NULL, surface, 0, value, total, direct};

    if (surface >= s->scene->surfaces.count)
        return lcor_internal_fail(err, LCOR_ERR_ARG, (long)surface, "surface %lu: there is none",
                                  (unsigned long)surface);
    job.f = scene_surface_at(s->scene, surface);
    job.count = lcor_scene_patches_of(job.f);
    run(&s->options.parallel, (job.count + CHUNK - 1) / CHUNK, patch_chunk, &job);
    return LCOR_OK;
}

typedef struct point_job {
    const lcor_solution *s;
    size_t               n;
    const double        *points, *normals;
    double              *total, *direct;
} point_job;

static void point_chunk(void *arg, size_t chunk)
{
    const point_job *job = arg;
    const size_t     channels = (size_t)job->s->report.channels;

    for (size_t i = chunk * CHUNK; i < job->n && i < (chunk + 1) * CHUNK; i++) {
        double direct[CHANNELS_MAX], indirect[CHANNELS_MAX];

        lcor_solution_direct_at(job->s, job->points + 3 * i, job->normals + 3 * i, LCOR_BVH_NONE, direct);
        if (job->total)
            gather(job->s, job->points + 3 * i, job->normals + 3 * i, LCOR_BVH_NONE, indirect);
        for (size_t c = 0; c < channels; c++) {
            if (job->direct)
                job->direct[channels * i + c] = direct[c];
            if (job->total)
                job->total[channels * i + c] = direct[c] + indirect[c];
        }
    }
}

lcor_status lcor_solution_at(const lcor_solution *s, size_t n, const double *points,
                             const double *normals, double *total, double *direct, lcor_error *err)
{
    point_job job = {s, n, points, normals, total, direct};

    if (n > 0 && (!points || !normals))
        return lcor_internal_fail(err, LCOR_ERR_ARG, -1, "at: points or normals are NULL");
    run(&s->options.parallel, (n + CHUNK - 1) / CHUNK, point_chunk, &job);
    return LCOR_OK;
}
