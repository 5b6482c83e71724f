/* SPDX-License-Identifier: MIT */
/* What a tolerance costs in engine gather: a furnished room of 6,000 triangles, a hall of 360 and
 * an open box with one bright patch, against path tracing; engine paths beside it where few points
 * are asked for; growth with the number of triangles; threads.
 *
 *   bench_gather [FILE.json]
 *   bench_gather --mesh SCENE FILE
 *
 * The second writes the scene for other programs: lines "light kind x y z dx dy dz intensity inner
 * outer", then "rho ax ay az bx by bz cx cy cz" for each triangle. References are looked for in
 * tests/data/reference below the current folder; reference_gather makes them. */
#include "crew.h"
#include "report.h"
#include "scenes.h"

#include <lcor/radiosity.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { REFERENCES = 400 };

static void must(lcor_status status, const lcor_error *err)
{
    if (status != LCOR_OK) {
        fprintf(stderr, "bench_gather: %s\n", err->text);
        exit(1);
    }
}

/* Values of tests/data/reference/gather_*.csv: points, then whole triangles. */
typedef struct reference {
    size_t points, count;
    double x[3 * REFERENCES], n[3 * REFERENCES], e[REFERENCES], sigma[REFERENCES];
    size_t triangle[REFERENCES];
} reference;

static int read_reference(const char *name, reference *r)
{
    char path[256], line[512], kind[16];
    FILE *file;

    snprintf(path, sizeof path, "tests/data/reference/gather_%s.csv", name);
    file = fopen(path, "r");
    memset(r, 0, sizeof *r);
    while (file && r->count < REFERENCES && fgets(line, sizeof line, file)) {
        double *x = r->x + 3 * r->count, *n = r->n + 3 * r->count;

        if (sscanf(line, "%15[^,],%zu,%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf", kind,
                   &r->triangle[r->count], x, x + 1, x + 2, n, n + 1, n + 2, &r->e[r->count],
                   &r->sigma[r->count]) != 10)
            continue;
        r->points += strcmp(kind, "point") == 0;
        r->count++;
    }
    if (!file || r->count == 0) {
        fprintf(stderr, "bench_gather: cannot read %s: run it in the source folder\n", path);
        return 0;
    }
    fclose(file);
    return 1;
}

/* Relative to max(E, 2 % of the mean), as lcor_norm says. */
typedef struct errors {
    double rms, bias; /* rms less the reference's own noise */
} errors;

static errors compare(const reference *r, size_t first, size_t end, const double *values)
{
    errors e = {0, 0};
    double mean = 0, noise = 0;
    const double count = (double)(end - first);

    for (size_t i = 0; i < r->count; i++)
        mean += r->e[i] / (double)r->count;
    for (size_t i = first; i < end; i++) {
        const double scale = fmax(r->e[i], 0.02 * mean), d = (values[i] - r->e[i]) / scale;

        e.rms += d * d / count;
        e.bias += d / count;
        noise += r->sigma[i] * r->sigma[i] / (scale * scale) / count;
    }
    e.rms = sqrt(fmax(0, e.rms - noise));
    return e;
}

typedef struct run {
    double solve, points; /* seconds of processor time, all threads */
    lcor_radiosity_report report;
} run;

/* Solves and evaluates what the reference holds. `r` may be NULL. */
static run measure(const lcor_scene *scene, lcor_engine engine, double tolerance, int threads,
                   const reference *r, double *values)
{
    crew c = {.threads = threads};
    lcor_radiosity_options options;
    lcor_solution *solution = NULL;
    lcor_error err;
    run out;

    memset(&options, 0, sizeof options);
    options.struct_size = sizeof options;
    options.tolerance = tolerance;
    options.engine = engine;
    options.points = r ? r->count : 0;
    options.parallel.run = threads > 1 ? crew_run : NULL;
    options.parallel.user = &c;
    out.solve = bench_seconds();
    must(lcor_radiosity_solve(scene, &options, &solution, &err), &err);
    out.points = bench_seconds();
    out.solve = out.points - out.solve;
    if (r)
        must(lcor_solution_at(solution, r->points, r->x, r->n, values, NULL, &err), &err);
    out.points = bench_seconds() - out.points;
    for (size_t i = r ? r->points : 0; r && i < r->count; i++)
        must(lcor_solution_patches(solution, r->triangle[i], LCOR_VALUE_AVERAGE, values + i, NULL,
                                   &err),
             &err);
    out.report = *lcor_solution_report(solution);
    lcor_solution_free(solution);
    return out;
}

/* A scene and its reference, or the end. */
static lcor_scene *load(const char *name, bench_scene *scene, reference *r)
{
    if (!read_reference(name, r) || !bench_scene_named(scene, name))
        exit(1);
    return bench_library_scene(scene);
}

static void requests(const char *name)
{
    static const double tolerances[] = {0.02, 0.01, 0.005};
    static double values[REFERENCES];
    static reference r;
    bench_scene scene;
    lcor_scene *library = load(name, &scene, &r);
    char title[128];

    snprintf(title, sizeof title,
             "Engine gather: what a request costs, scene %s (%zu triangles, %zu dropped)", name,
             scene.count, scene.dropped);
    report_table(
        title,
        "200 points and 100 whole triangles drawn by area, against path tracing whose own "
        "noise is taken off; two threads, seconds of processor time of both. Reported over true is "
        "the estimate over the rms at the points.",
        "\"tolerance\", \"rms at points\", \"rms of triangles\", \"reported rms\", "
        "\"reported over true\", \"bias\", \"solve, s\", \"200 points, s\", \"MB\", "
        "\"rays, million\"");
    for (int k = 0; k < 3; k++) {
        const run m = measure(library, LCOR_ENGINE_GATHER, tolerances[k], 2, &r, values);
        const errors points = compare(&r, 0, r.points, values);
        const errors triangles = compare(&r, r.points, r.count, values);
        const errors all = compare(&r, 0, r.count, values);

        report_row((const double[10]){tolerances[k], points.rms, triangles.rms, m.report.error_rms,
                                      m.report.error_rms / points.rms, all.bias, m.solve, m.points,
                                      1e-6 * (double)m.report.bytes, 1e-6 * (double)m.report.rays},
                   10);
    }
    lcor_scene_free(library);
    bench_scene_free(&scene);
}

static void few_points(const char *name)
{
    static const size_t counts[] = {1, 10, 100};
    static double values[REFERENCES];
    static reference r;
    bench_scene scene;
    lcor_scene *library = load(name, &scene, &r);
    char title[128];

    snprintf(title, sizeof title, "Engine paths: few points, scene %s", name);
    report_table(title,
                 "Tolerance 2 %, two threads, seconds of processor time for solution and answers; "
                 "rms against path tracing, its noise taken off, which is luck for few points. "
                 "The last columns are what the scene estimates for itself; it takes the least.",
                 "\"points\", \"gather, s\", \"paths, s\", \"rms of paths\", \"reported rms\", "
                 "\"gather estimated, s\", \"paths estimated, s\"");
    for (int k = 0; k < 3; k++) {
        run gather, paths, choice;

        r.points = r.count = counts[k];
        gather = measure(library, LCOR_ENGINE_GATHER, 0.02, 2, &r, values);
        choice = measure(library, LCOR_ENGINE_AUTO, 0.02, 2, &r, values);
        paths = measure(library, LCOR_ENGINE_PATHS, 0.02, 2, &r, values);
        report_row((const double[7]){(double)counts[k], gather.solve + gather.points,
                                     paths.solve + paths.points,
                                     compare(&r, 0, r.points, values).rms, paths.report.error_rms,
                                     choice.report.gather_seconds, choice.report.paths_seconds},
                   7);
    }
    lcor_scene_free(library);
    bench_scene_free(&scene);
}

static void threads_agree(void)
{
    static double values[3][REFERENCES];
    static const int threads[] = {1, 2, 5};
    static reference r;
    bench_scene scene;
    lcor_scene *library = load("hall", &scene, &r);
    double seconds[3];
    int same = 1;

    for (int k = 0; k < 3; k++) {
        seconds[k] = bench_wall_seconds();
        (void)measure(library, LCOR_ENGINE_GATHER, 0.01, threads[k], &r, values[k]);
        seconds[k] = bench_wall_seconds() - seconds[k];
        same &= memcmp(values[k], values[0], r.count * sizeof **values) == 0;
    }
    report_table("Engine gather: 1, 2 and 5 threads in the hall",
                 "Tolerance 1 %, solution, 200 points and 100 triangles, seconds by the wall "
                 "clock; the last column is "
                 "1 if all bits agree.",
                 "\"1 thread, s\", \"2 threads, s\", \"5 threads, s\", \"same bits\"");
    report_row((const double[4]){seconds[0], seconds[1], seconds[2], same}, 4);
    lcor_scene_free(library);
    bench_scene_free(&scene);
}

static void growth(void)
{
    static const char *const names[] = {"room1000", "room3000", "room10000", "room100000"};
    static const double tolerances[] = {0.02, 0.02, 0.02, 0.05};
    double first = 0, first_count = 1;

    report_table("Engine gather: growth with the number of triangles",
                 "Furnished rooms, two threads, seconds of processor time for commit and for the "
                 "solution; the exponent is log(time ratio) / log(triangle ratio) from the first "
                 "row. The last row asks for 5 %.",
                 "\"triangles\", \"tolerance\", \"commit, s\", \"solve, s\", \"exponent\", "
                 "\"reported rms\", \"MB\"");
    for (int k = 0; k < 4; k++) {
        bench_scene scene;
        lcor_scene *library;
        double commit = bench_seconds(), solve, exponent = 0, count;
        run m;

        if (!bench_scene_named(&scene, names[k]))
            exit(1);
        library = bench_library_scene(&scene);
        solve = bench_seconds();
        commit = solve - commit;
        m = measure(library, LCOR_ENGINE_GATHER, tolerances[k], 2, NULL, NULL);
        solve = bench_seconds() - solve;
        count = (double)scene.count;
        if (k == 0) {
            first = solve;
            first_count = count;
        } else if (tolerances[k] == tolerances[0]) {
            exponent = log(solve / first) / log(count / first_count);
        }
        report_row((const double[7]){count, tolerances[k], commit, solve, exponent,
                                     m.report.error_rms, 1e-6 * (double)m.report.bytes},
                   7);
        lcor_scene_free(library);
        bench_scene_free(&scene);
    }
}

static int write_mesh(const char *name, const char *path)
{
    bench_scene scene;
    FILE *file;

    if (!bench_scene_named(&scene, name)) {
        fprintf(stderr, "bench_gather: no scene %s\n", name);
        return 2;
    }
    file = fopen(path, "w");
    if (!file) {
        perror(path);
        return 1;
    }
    for (size_t i = 0; i < scene.light_count; i++) {
        const lcor_light *l = &scene.lights[i];

        fprintf(file, "light %d %.9g %.9g %.9g %.9g %.9g %.9g %.9g %.9g %.9g\n", (int)l->kind,
                l->position[0], l->position[1], l->position[2], l->direction[0], l->direction[1],
                l->direction[2], l->intensity[0], l->inner_cone, l->outer_cone);
    }
    for (size_t i = 0; i < scene.count; i++) {
        fprintf(file, "%.9g", scene.rho[i]);
        for (int k = 0; k < 9; k++)
            fprintf(file, " %.9g", scene.corners[i][k]);
        fprintf(file, "\n");
    }
    bench_scene_free(&scene);
    return fclose(file) == 0 ? 0 : 1;
}

int main(int argc, char **argv)
{
    if (argc == 4 && strcmp(argv[1], "--mesh") == 0)
        return write_mesh(argv[2], argv[3]);
    if (!report_open("bench_gather", argc > 1 ? argv[1] : NULL))
        return 1;
    requests("hall");
    requests("box");
    requests("room");
    few_points("hall");
    few_points("box");
    few_points("room");
    threads_agree();
    growth();
    return report_close() ? 0 : 1;
}
