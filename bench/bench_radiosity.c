/* SPDX-License-Identifier: MIT */
/* What a tolerance costs: engine links in the paper's room against the classical dense solver in
 * the same run, growth with the number of patches, walls in pieces, the room with a box, the white
 * furnace, an update.
 *
 *   bench_radiosity [FILE.json]
 *
 * One thread, processor time, best of several. The reference files are looked for in
 * tests/data/reference below the current folder. */
#include "dense.h"
#include "report.h"
#include "richardson.h"
#include "room_quads.h"

#include <lcor/radiosity.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { REPEAT = 5, TURNS = 10 };

/* Short runs are repeated until they have taken so many seconds together. */
static const double long_enough = 0.2;

static void must(lcor_status status, const lcor_error *err)
{
    if (status != LCOR_OK) {
        fprintf(stderr, "bench_radiosity: %s\n", err->text);
        exit(1);
    }
}

static lcor_light lamp(double x)
{
    lcor_light light;

    memset(&light, 0, sizeof light);
    light.position[0] = x;
    light.position[1] = 0.4;
    light.position[2] = 0.7;
    light.intensity[0] = light.intensity[1] = light.intensity[2] = 1;
    return light;
}

/* The paper's room with n x n patches a face, with a box, or as a furnace of reflectance rho. */
static lcor_scene *room(size_t n, int box, double furnace)
{
    static const double rho[ROOM_AND_BOX_FACES] = {0.3, 0.8, 0.5, 0.5, 0.5, 0.5,
                                                   0.5, 0.5, 0.5, 0.5, 0.5};
    const lcor_light light = lamp(0.3);
    lcor_scene *scene = NULL;
    lcor_error err;

    must(lcor_scene_new(NULL, &scene, &err), &err);
    for (int f = 0; f < (box ? ROOM_AND_BOX_FACES : ROOM_FACES); f++) {
        lcor_surface look;

        memset(&look, 0, sizeof look);
        for (int c = 0; c < 3; c++) {
            look.reflectance[c] = furnace > 0 ? furnace : rho[f];
            look.emission[c] = furnace > 0 ? 1 : 0;
        }
        look.patches[0] = look.patches[1] = f < ROOM_FACES ? n : 10;
        must(lcor_scene_add_quad(scene, room_quads[f], room_quads[f] + 3, room_quads[f] + 6, &look,
                                 NULL, &err),
             &err);
    }
    if (!(furnace > 0))
        must(lcor_scene_add_light(scene, &light, NULL, &err), &err);
    must(lcor_scene_commit(scene, NULL, &err), &err);
    return scene;
}

/* All patches of the room's faces, in the references' order. */
static void patches(const lcor_solution *solution, size_t n, double *face, double *out)
{
    lcor_error err;

    for (size_t f = 0; f < ROOM_FACES; f++) {
        must(lcor_solution_patches(solution, f, LCOR_VALUE_AVERAGE, face, NULL, &err), &err);
        if (out)
            for (size_t i = 0; i < n; i++)
                for (size_t j = 0; j < n; j++)
                    out[(f * n + i) * n + j] = room_swapped[f] ? face[j * n + i] : face[i * n + j];
    }
}

typedef struct run {
    double seconds; /* solve and all patches, best */
    lcor_radiosity_report report;
} run;

static run measure(const lcor_scene *scene, size_t n, double tolerance, lcor_norm norm, double *out)
{
    double *face = malloc(n * n * sizeof *face), spent = 0;
    run r;

    r.seconds = 1e300;
    for (int k = 0; face && (k == 0 || spent < long_enough || (k < REPEAT && spent < 1)); k++) {
        lcor_radiosity_options options;
        lcor_solution *solution = NULL;
        lcor_error err;
        double start = bench_seconds();

        memset(&options, 0, sizeof options);
        options.struct_size = sizeof options;
        options.tolerance = tolerance;
        options.norm = norm;
        must(lcor_radiosity_solve(scene, &options, &solution, &err), &err);
        patches(solution, n, face, out);
        start = bench_seconds() - start;
        r.seconds = start < r.seconds ? start : r.seconds;
        spent += start;
        r.report = *lcor_solution_report(solution);
        lcor_solution_free(solution);
    }
    free(face);
    return r;
}

typedef struct errors {
    double rms, max;
    int rows;
} errors;

/* Against a reference file with columns ...face,i,j,E...: rms and worst error. */
static errors compare(const char *path, const char *format, size_t n, const double *values)
{
    FILE *file = fopen(path, "r");
    char line[256], name[16];
    double mean = 0;
    errors e = {0, 0, 0};

    if (!file) {
        fprintf(stderr, "bench_radiosity: cannot open %s: run it in the source folder\n", path);
        exit(1);
    }
    for (size_t k = 0; k < ROOM_FACES * n * n; k++)
        mean += values[k] / (double)(ROOM_FACES * n * n);
    while (fgets(line, sizeof line, file)) {
        double truth;
        size_t i, j, f = 0;

        if (sscanf(line, format, name, &i, &j, &truth) != 4)
            continue;
        while (f < ROOM_FACES && strcmp(name, room_names[f]) != 0)
            f++;
        if (f < ROOM_FACES) {
            const double d = (values[(f * n + i) * n + j] - truth) / fmax(truth, 0.02 * mean);

            e.rms += d * d;
            e.max = fmax(e.max, fabs(d));
            e.rows++;
        }
    }
    fclose(file);
    e.rms = sqrt(e.rms / e.rows);
    return e;
}

static const char *const paper_file = "tests/data/reference/paper_room_50x50.csv";
static const char *const paper_format = "%*[^,],%15[^,],%zu,%zu,%lf";
static const char *const box_file = "tests/data/reference/box_room_50x50.csv";
static const char *const box_format = "%15[^,],%zu,%zu,%lf";

/* Against what richardson.c extrapolates, which is a check of the file as well. */
static void against_extrapolation(const lcor_scene *scene, double *values)
{
    const run r = measure(scene, 50, 1e-4, LCOR_NORM_RMS, values);
    const errors file = compare(paper_file, paper_format, 50, values);
    double *truth = malloc(ROOM_FACES * 2500 * sizeof *truth);
    double out[6] = {0, 0, r.report.error_rms, file.rms, 0, 0};

    if (!truth || !richardson_paper_room(truth, &out[4], &out[5]))
        exit(1);
    for (int i = 0; i < ROOM_FACES * 2500; i++) {
        const double d = values[i] / truth[i] - 1;

        out[0] += d * d / (ROOM_FACES * 2500);
        out[1] = fmax(out[1], fabs(d));
    }
    out[0] = sqrt(out[0]);
    report_table(
        "Paper's room at a tolerance of 1e-4, against a solver of its own",
        "Constant patches with exact factors on 25, 50 and 100 patches an edge, extrapolated with "
        "the order seen; the last column is what the last step of that added.",
        "\"true rms\", \"true max\", \"estimated rms\", \"rms against the file\", "
        "\"order\", \"extrapolated by\"");
    report_row(out, 6);
    free(truth);
}

static void against_dense(double *values)
{
    static const double tolerances[] = {1e-2, 1e-3, 1e-4, 1e-2};
    const size_t n = 50;
    lcor_scene *scene = room(n, 0, 0);
    double start = bench_seconds(), dense;
    size_t bytes = dense_paper_room(n, values);

    dense = bench_seconds() - start;
    printf("dense solver: %.0f ms, %.0f MB\n", 1e3 * dense, 1e-6 * (double)bytes);
    report_table(
        "Paper's room, 15,000 patches: what a request costs",
        "Engine links with all patch averages, one thread; times are shares of the dense solver's "
        "in the same run (float matrix, 900 MB). The last row asks for the worst patch.",
        "\"tolerance\", \"true rms\", \"estimated rms\", \"true max\", \"ms\", "
        "\"dense over links\", \"MB\", \"links\"");
    for (int k = 0; k < 4; k++) {
        const run r =
            measure(scene, n, tolerances[k], k == 3 ? LCOR_NORM_MAX : LCOR_NORM_RMS, values);
        const errors e = compare(paper_file, paper_format, n, values);
        const double out[8] = {tolerances[k],
                               e.rms,
                               r.report.error_rms,
                               e.max,
                               1e3 * r.seconds,
                               dense / r.seconds,
                               1e-6 * (double)r.report.bytes,
                               (double)r.report.links};

        report_row(out, 8);
    }
    against_extrapolation(scene, values);
    lcor_scene_free(scene);
}

static void growth(void)
{
    double first = 0;

    report_table(
        "Growth with the number of patches at a tolerance of 1e-3",
        "Solve and all patch averages; the exponent is log(time ratio) / log(patch ratio) from the "
        "first row.",
        "\"patches\", \"ms\", \"MB besides the output\", \"exponent\"");
    for (size_t n = 50; n <= 800; n *= 4) {
        lcor_scene *scene = room(n, 0, 0);
        const run r = measure(scene, n, 1e-3, LCOR_NORM_RMS, NULL);
        const double count = (double)(ROOM_FACES * n * n);
        double out[4] = {count, 1e3 * r.seconds, 1e-6 * (double)r.report.bytes, 0};

        if (n == 50)
            first = r.seconds;
        else
            out[3] = log(r.seconds / first) / log(count / 15000);
        report_row(out, 4);
        lcor_scene_free(scene);
    }
}

/* The paper's room, each face cut into n x n quads, or for n = 0 into two triangles. */
static lcor_scene *room_in_pieces(int n)
{
    static const double rho[ROOM_FACES] = {0.3, 0.8, 0.5, 0.5, 0.5, 0.5};
    const lcor_light light = lamp(0.3);
    lcor_scene *scene = NULL;
    lcor_error err;

    must(lcor_scene_new(NULL, &scene, &err), &err);
    for (int k = 0; k < ROOM_FACES * n * n; k++) {
        const double *face = room_quads[k / (n * n)];
        double corner[3], u[3], v[3];
        lcor_surface look = {.patches = {(size_t)(48 / n), (size_t)(48 / n)}};

        for (int c = 0; c < 3; c++) {
            u[c] = face[3 + c] / n;
            v[c] = face[6 + c] / n;
            corner[c] = face[c] + k / n % n * u[c] + k % n * v[c];
            look.reflectance[c] = rho[k / (n * n)];
        }
        must(lcor_scene_add_quad(scene, corner, u, v, &look, NULL, &err), &err);
    }
    for (int k = 0; k < (n == 0 ? 2 * ROOM_FACES : 0); k++) {
        const double *face = room_quads[k / 2];
        double side[3], opposite[3];
        lcor_surface look = {.patches = {48, 48}};

        for (int c = 0; c < 3; c++) {
            side[c] = face[c] + face[3 + 3 * (k % 2) + c];
            opposite[c] = face[c] + face[3 + c] + face[6 + c];
            look.reflectance[c] = rho[k / 2];
        }
        must(k % 2 ? lcor_scene_add_triangle(scene, face, opposite, side, &look, NULL, &err)
                   : lcor_scene_add_triangle(scene, face, side, opposite, &look, NULL, &err),
             &err);
    }
    must(lcor_scene_add_light(scene, &light, NULL, &err), &err);
    must(lcor_scene_commit(scene, NULL, &err), &err);
    return scene;
}

static double solving_time(const lcor_scene *scene, double tolerance)
{
    double best = 1e300;

    for (int k = 0; k < REPEAT; k++) {
        const lcor_radiosity_options options = {.struct_size = sizeof options,
                                                .tolerance = tolerance};
        lcor_solution *solution = NULL;
        lcor_error err;
        const double start = bench_seconds();

        must(lcor_radiosity_solve(scene, &options, &solution, &err), &err);
        best = fmin(best, bench_seconds() - start);
        lcor_solution_free(solution);
    }
    return best;
}

static void pieces(void)
{
    static const double tolerances[] = {1e-2, 1e-3};
    static const int cuts[] = {1, 0, 4};
    lcor_scene *scenes[3];

    for (int i = 0; i < 3; i++)
        scenes[i] = room_in_pieces(cuts[i]);
    report_table(
        "Walls in pieces",
        "The paper's room with every face as one quad, as two triangles and as 4 x 4 quads: "
        "milliseconds to solve, and times that of the first.",
        "\"tolerance\", \"quads, ms\", \"two triangles\", \"times\", \"4 x 4 quads\", "
        "\"times \"");
    for (int k = 0; k < 2; k++) {
        double out[6] = {tolerances[k], 0, 0, 0, 0, 0};

        out[1] = 1e3 * solving_time(scenes[0], tolerances[k]);
        for (int i = 1; i < 3; i++) {
            out[2 * i] = 1e3 * solving_time(scenes[i], tolerances[k]);
            out[2 * i + 1] = out[2 * i] / out[1];
        }
        report_row(out, 6);
    }
    for (int i = 0; i < 3; i++)
        lcor_scene_free(scenes[i]);
}

static void box(double *values)
{
    static const double tolerances[] = {1e-2, 3e-3};
    lcor_scene *empty = room(50, 0, 0), *full = room(50, 1, 0);

    report_table(
        "The room with a box on the floor, against path tracing",
        "Errors at the 540 patches of the reference, a third of them next to the box or at shadow "
        "edges; the reference itself has a noise of 1.3e-3. Time over that of the empty room.",
        "\"tolerance\", \"rms\", \"worst\", \"ms\", \"times the empty room\", \"links\"");
    for (int k = 0; k < 2; k++) {
        run a = measure(empty, 50, tolerances[k], LCOR_NORM_RMS, NULL);
        run b = measure(full, 50, tolerances[k], LCOR_NORM_RMS, values);
        const errors e = compare(box_file, box_format, 50, values);

        for (int turn = 1; turn < TURNS; turn++) { /* by turns, whatever else the machine does */
            a.seconds =
                fmin(a.seconds, measure(empty, 50, tolerances[k], LCOR_NORM_RMS, NULL).seconds);
            b.seconds =
                fmin(b.seconds, measure(full, 50, tolerances[k], LCOR_NORM_RMS, NULL).seconds);
        }
        const double out[6] = {
            tolerances[k],         e.rms, e.max, 1e3 * b.seconds, b.seconds / a.seconds,
            (double)b.report.links};

        report_row(out, 6);
    }
    lcor_scene_free(empty);
    lcor_scene_free(full);
}

static void furnace(double *values)
{
    static const double rhos[] = {0.5, 0.9, 0.99, 0.999};

    report_table("White furnace: worst error of B = 1 / (1 - rho)", "Closed room, emission 1.",
                 "\"rho\", \"error\", \"iterations\", \"ms\"");
    for (int k = 0; k < 4; k++) {
        lcor_scene *scene = room(10, 0, rhos[k]);
        const run r = measure(scene, 10, 1e-2, LCOR_NORM_RMS, values);
        double out[4] = {rhos[k], 0, r.report.iterations, 1e3 * r.seconds};

        for (int i = 0; i < ROOM_FACES * 100; i++)
            out[1] = fmax(out[1], fabs((1 + rhos[k] * values[i]) * (1 - rhos[k]) - 1));
        report_row(out, 4);
        lcor_scene_free(scene);
    }
}

static void update(void)
{
    lcor_scene *scene = room(50, 0, 0);
    lcor_solution *solution = NULL;
    lcor_radiosity_options options;
    lcor_error err;
    double out[3];

    memset(&options, 0, sizeof options);
    options.struct_size = sizeof options;
    options.tolerance = 1e-3;
    out[0] = bench_seconds();
    must(lcor_radiosity_solve(scene, &options, &solution, &err), &err);
    out[0] = 1e3 * (bench_seconds() - out[0]);
    for (int k = 1; k < 3; k++) { /* moved a little, then moved back */
        const lcor_light light = lamp(k == 1 ? 0.31 : 0.3);

        must(lcor_scene_set_light(scene, 0, &light, &err), &err);
        out[k] = bench_seconds();
        must(lcor_solution_update(solution, &err), &err);
        out[k] = 1e3 * (bench_seconds() - out[k]);
    }
    report_table("Light moved: links are kept", "Tolerance 1e-3, milliseconds without patches.",
                 "\"solve\", \"update after a move\", \"update after moving back\"");
    report_row(out, 3);
    lcor_solution_free(solution);
    lcor_scene_free(scene);
}

int main(int argc, char **argv)
{
    double *values = malloc(ROOM_FACES * 2500 * sizeof *values);

    if (!values || !report_open("bench_radiosity", argc > 1 ? argv[1] : NULL))
        return 1;
    against_dense(values);
    growth();
    pieces();
    box(values);
    furnace(values);
    update();
    free(values);
    return report_close() ? 0 : 1;
}
