/* SPDX-License-Identifier: MIT */
/* What must hold for any scene: threads, scale, order, reuse; and the report's limits. */
#include "crew.h"
#include "failing.h"
#include "rooms.h"
#include "scene/scene_internal.h"

enum { N = 6, VALUES = ROOM_FACES * N * N };

static void room_values(const lcor_solution *solution, double *out)
{
    room_patches(solution, N, LCOR_VALUE_AVERAGE, out);
}

static lcor_scene *box_room(void)
{
    lcor_scene *scene = paper_room(N);

    add_box(scene, paper_box_low, paper_box_high, 0.5, N);
    return scene;
}

/* A parallel-for that runs tasks backwards, as another number of threads might. */
static void run_backwards(void *user, size_t n, void (*task)(void *arg, size_t i), void *arg)
{
    ++*(int *)user;
    while (n-- > 0)
        task(arg, n);
}

static const lcor_engine engines[] = {LCOR_ENGINE_LINKS, LCOR_ENGINE_GATHER, LCOR_ENGINE_PATHS};
enum { ENGINES = sizeof engines / sizeof *engines };

/* All patches of a room are many for paths. */
static lcor_radiosity_options quick_options(lcor_engine engine)
{
    return options_for(engine, engine == LCOR_ENGINE_PATHS ? 0.2 : 0.03);
}

static void bits_do_not_depend_on_the_number_of_threads(void **state)
{
    static const int threads[] = {1, 2, 5};
    double serial[VALUES], values[VALUES];
    lcor_scene *scene = box_room();

    (void)state;
    commit(scene);
    for (int e = 0; e < ENGINES; e++) {
        lcor_radiosity_options options = quick_options(engines[e]);
        lcor_solution *alone = solve_with(scene, &options);

        room_values(alone, serial);
        for (int k = 0; k < 3; k++) {
            crew c = {.threads = threads[k]};
            lcor_solution *solution;

            options.parallel.run = crew_run;
            options.parallel.user = &c;
            solution = solve_with(scene, &options);
            room_values(solution, values);
            assert_true(c.calls > 3);
            assert_memory_equal(serial, values, sizeof serial);
            assert_memory_equal(&lcor_solution_report(alone)->error_rms,
                                &lcor_solution_report(solution)->error_rms, sizeof(double));
            lcor_solution_free(solution);
        }
        lcor_solution_free(alone);
    }
    lcor_scene_free(scene);
}

static void bits_do_not_depend_on_the_order_of_tasks(void **state)
{
    double forward[VALUES], backward[VALUES];
    lcor_scene *scene = box_room();

    (void)state;
    commit(scene);
    for (int e = 0; e < ENGINES; e++) {
        lcor_radiosity_options options = quick_options(engines[e]);
        lcor_solution *one = solve_with(scene, &options), *two;
        int calls = 0;

        options.parallel.run = run_backwards;
        options.parallel.user = &calls;
        two = solve_with(scene, &options);
        room_values(one, forward);
        room_values(two, backward);
        assert_true(calls > 3);
        assert_memory_equal(forward, backward, sizeof forward);
        lcor_solution_free(one);
        lcor_solution_free(two);
    }
    lcor_scene_free(scene);
}

/* Links in the empty room and past a box, as on a machine without wide vectors. */
static void bits_do_not_depend_on_the_instruction_set(void **state)
{
    (void)state;
    for (int box = 0; box < 2; box++) {
        const lcor_radiosity_options options = options_for(LCOR_ENGINE_LINKS, 0.01);
        lcor_scene *scene = box ? box_room() : paper_room(N);
        double wide[VALUES], plain[VALUES];
        lcor_solution *first, *second;
        size_t last = 0;

        commit(scene);
        first = solve_with(scene, &options);
        while (lcor_factor_points_at(last + 1))
            last++;
        scene->factor_points = lcor_factor_points_at(last);
        memset(&scene->cpu, 0, sizeof scene->cpu);
        second = solve_with(scene, &options);
        room_values(first, wide);
        room_values(second, plain);
        assert_memory_equal(wide, plain, sizeof wide);
        lcor_solution_free(first);
        lcor_solution_free(second);
        lcor_scene_free(scene);
    }
}

/* Coordinates that were kept in single precision lie a little before or behind their surface: they
 * are lit as it is. The floor below the board makes the scene one with shadows. */
static void places_may_be_rounded(void **state)
{
    enum { PLACES = 50 };
    const double origin[3] = {0.1, 0.3, 0.2}, u[3] = {0.61, 0.13, 0.17}, v[3] = {-0.11, 0.57, 0.23};
    double points[2][3 * PLACES], normals[3 * PLACES], total[2][PLACES], direct[2][PLACES];
    lcor_scene *scene = NULL;
    uint64_t random = 11;
    lcor_surface look;
    lcor_error err;

    (void)state;
    must(lcor_scene_new(NULL, &scene, &err), &err);
    memset(&look, 0, sizeof look);
    look.two_sided = 1;
    must(lcor_scene_add_quad(scene, origin, u, v, &look, NULL, &err), &err);
    for (int c = 0; c < 3; c++)
        look.reflectance[c] = 0.5;
    must(lcor_scene_add_quad(scene, (double[3]){-1, -1, 0}, (double[3]){3, 0, 0},
                             (double[3]){0, 3, 0}, &look, NULL, &err),
         &err);
    add_lamp(scene, 0.3, 0.4, 1.7, 1);
    add_lamp(scene, 0.6, 0.2, 0.1, 1);
    commit(scene);
    for (int i = 0; i < PLACES; i++) {
        const double s = random_unit(&random), t = random_unit(&random);

        for (int k = 0; k < 3; k++) {
            const int a = (k + 1) % 3, b = (k + 2) % 3;

            points[0][3 * i + k] = origin[k] + s * u[k] + t * v[k];
            points[1][3 * i + k] = (double)(float)points[0][3 * i + k];
            normals[3 * i + k] = (i % 2 ? -1 : 1) * (u[a] * v[b] - u[b] * v[a]);
        }
    }
    for (int e = 0; e < ENGINES; e++) {
        const lcor_radiosity_options options = options_for(engines[e], 0.05);
        lcor_solution *solution = solve_with(scene, &options);

        for (int k = 0; k < 2; k++)
            must(lcor_solution_at(solution, PLACES, points[k], normals, total[k], direct[k], &err),
                 &err);
        for (int i = 0; i < PLACES; i++) {
            assert_true(direct[0][i] > 0.01);
            check_near(direct[1][i], direct[0][i], 1e-5 * direct[0][i], "direct");
            check_near(total[1][i], total[0][i], 1e-2 * total[0][i], "total");
        }
        lcor_solution_free(solution);
    }
    lcor_scene_free(scene);
}

/* The same scene a million times smaller or larger: irradiance goes with 1 / length^2. */
static void results_do_not_depend_on_the_unit_of_length(void **state)
{
    static const double scales[] = {1, 1e-6, 1e6};
    double values[3][VALUES];

    (void)state;
    for (int k = 0; k < 3; k++) {
        const double a = scales[k];
        const double low[3] = {0.45 * a, 0.2 * a, 0}, high[3] = {0.75 * a, 0.5 * a, 0.4 * a};
        lcor_scene *scene = NULL;
        lcor_solution *solution;
        lcor_error err;

        must(lcor_scene_new(NULL, &scene, &err), &err);
        add_room(scene, a, paper_rho, 0, N);
        add_lamp(scene, 0.3 * a, 0.4 * a, 0.7 * a, a * a);
        add_box(scene, low, high, 0.5, N);
        commit(scene);
        solution = solve(scene, 0.03, LCOR_NORM_RMS);
        room_values(solution, values[k]);
        lcor_solution_free(solution);
        lcor_scene_free(scene);
    }
    for (int i = 0; i < VALUES; i++) {
        check_near(values[1][i], values[0][i], 3e-3 * (0.01 + values[0][i]), "1e-6");
        check_near(values[2][i], values[0][i], 3e-3 * (0.01 + values[0][i]), "1e6");
    }
}

/* Light twice as strong, everything twice as bright. */
static void irradiance_is_linear_over_the_whole_range(void **state)
{
    static const double strengths[] = {1, 1e-4, 1e4};
    double values[3][VALUES];

    (void)state;
    for (int k = 0; k < 3; k++) {
        lcor_scene *scene = NULL;
        lcor_solution *solution;
        lcor_error err;

        must(lcor_scene_new(NULL, &scene, &err), &err);
        add_room(scene, 1, paper_rho, 0, N);
        add_lamp(scene, 0.3, 0.4, 0.7, strengths[k]);
        commit(scene);
        solution = solve(scene, 0.01, LCOR_NORM_RMS);
        room_values(solution, values[k]);
        lcor_solution_free(solution);
        lcor_scene_free(scene);
    }
    for (int k = 1; k < 3; k++)
        for (int i = 0; i < VALUES; i++)
            check_near(values[k][i] / strengths[k], values[0][i], 1e-9 * values[0][i], "linear");
}

/* After a light or a reflectance has changed, an update must agree with solving anew. */
static void an_update_agrees_with_a_new_solution(void **state)
{
    double updated[VALUES], fresh[VALUES];
    lcor_scene *scene = box_room(), *other = NULL;
    lcor_solution *solution, *again;
    lcor_surface look;
    lcor_light light;
    lcor_error err;
    double square = 0, mean = 0;

    (void)state;
    commit(scene);
    solution = solve(scene, 0.01, LCOR_NORM_RMS);
    memset(&light, 0, sizeof light);
    light.position[0] = 0.6;
    light.position[1] = 0.7;
    light.position[2] = 0.8;
    light.intensity[0] = light.intensity[1] = light.intensity[2] = 2;
    memset(&look, 0, sizeof look);
    look.reflectance[0] = look.reflectance[1] = look.reflectance[2] = 0.7;
    look.patches[0] = look.patches[1] = N;
    must(lcor_scene_set_light(scene, 0, &light, &err), &err);
    must(lcor_scene_set_surface(scene, 0, &look, &err), &err);
    must(lcor_solution_update(solution, &err), &err);
    room_values(solution, updated);

    other = box_room();
    must(lcor_scene_set_light(other, 0, &light, &err), &err);
    must(lcor_scene_set_surface(other, 0, &look, &err), &err);
    commit(other);
    again = solve(other, 0.01, LCOR_NORM_RMS);
    room_values(again, fresh);
    for (int i = 0; i < VALUES; i++)
        mean += fresh[i] / VALUES;
    for (int i = 0; i < VALUES; i++) { /* under the box it is dark */
        const double d = (updated[i] - fresh[i]) / fmax(fresh[i], 0.02 * mean);

        square += d * d / VALUES;
    }
    assert_true(sqrt(square) < 0.015);
    lcor_solution_free(solution);
    lcor_solution_free(again);
    lcor_scene_free(scene);
    lcor_scene_free(other);
}

/* Light leaves a patch of one room as it arrives at another: sum of A_i E_i is symmetric in where
 * unit emission stands. */
static void exchange_is_reciprocal(void **state)
{
    double flux[2];

    (void)state;
    for (int k = 0; k < 2; k++) {
        lcor_scene *scene = paper_room(1);
        lcor_solution *solution;
        lcor_surface look;
        lcor_light dark;
        lcor_error err;
        double e;

        memset(&dark, 0, sizeof dark);
        must(lcor_scene_set_light(scene, 0, &dark, &err), &err);
        memset(&look, 0, sizeof look);
        look.emission[0] = look.emission[1] = look.emission[2] = 1;
        must(lcor_scene_set_surface(scene, k ? 3 : 0, &look, &err), &err);
        memset(look.emission, 0, sizeof look.emission);
        must(lcor_scene_set_surface(scene, k ? 0 : 3, &look, &err), &err);
        commit(scene);
        solution = solve(scene, 1e-3, LCOR_NORM_RMS);
        must(lcor_solution_patches(solution, k ? 0 : 3, LCOR_VALUE_AVERAGE, &e, NULL, &err), &err);
        flux[k] = e;
        lcor_solution_free(solution);
        lcor_scene_free(scene);
    }
    check_near(flux[0], flux[1], 1e-3 * flux[0], "reciprocity");
}

/* Coloured light asks for three channels; each is what it would be alone. */
static void channels_are_independent(void **state)
{
    double coloured[ROOM_FACES * 3], grey[ROOM_FACES];
    lcor_scene *scene = paper_room(1), *white = paper_room(1);
    lcor_solution *three, *one;
    lcor_light light;
    lcor_error err;

    (void)state;
    memset(&light, 0, sizeof light);
    light.position[0] = 0.3;
    light.position[1] = 0.4;
    light.position[2] = 0.7;
    light.intensity[0] = 1;
    light.intensity[1] = 0.5;
    light.intensity[2] = 0;
    must(lcor_scene_set_light(scene, 0, &light, &err), &err);
    commit(scene);
    commit(white);
    three = solve(scene, 0.01, LCOR_NORM_RMS);
    one = solve(white, 0.01, LCOR_NORM_RMS);
    assert_int_equal(lcor_solution_report(three)->channels, 3);
    assert_int_equal(lcor_solution_report(one)->channels, 1);
    for (size_t f = 0; f < ROOM_FACES; f++) {
        must(lcor_solution_patches(three, f, LCOR_VALUE_AVERAGE, coloured + 3 * f, NULL, &err),
             &err);
        must(lcor_solution_patches(one, f, LCOR_VALUE_AVERAGE, grey + f, NULL, &err), &err);
        check_near(coloured[3 * f], grey[f], 0.02 * grey[f], "red");
        check_near(coloured[3 * f + 1], 0.5 * coloured[3 * f], 1e-9, "green");
        check_near(coloured[3 * f + 2], 0, 0, "blue");
    }
    lcor_solution_free(three);
    lcor_solution_free(one);
    lcor_scene_free(scene);
    lcor_scene_free(white);
}

typedef struct watcher {
    int calls, falling;
    double last;
} watcher;

static int watch(void *user, double done)
{
    watcher *w = user;

    w->falling |= done < w->last;
    w->last = done;
    w->calls++;
    return 0;
}

static void progress_never_falls_and_can_cancel(void **state)
{
    lcor_scene *scene = box_room();
    lcor_radiosity_options options = options_for(LCOR_ENGINE_AUTO, 0.05);
    watcher w = {0, 0, 0};

    (void)state;
    commit(scene);
    options.progress.report = watch;
    options.progress.user = &w;
    lcor_solution_free(solve_with(scene, &options));
    assert_false(w.falling);
    assert_true(w.calls > 3 && w.last == 1);
    for (int stop = 1; stop < w.calls; stop += 1 + w.calls / 5)
        check_cancelled(scene, options, stop);
    lcor_scene_free(scene);
}

static void a_limit_returns_the_best_solution_unconverged(void **state)
{
    lcor_scene *scene = box_room();
    lcor_solution *solution = NULL;
    lcor_radiosity_options options;
    lcor_error err;
    double values[VALUES];

    (void)state;
    commit(scene);
    for (int k = 0; k < 2; k++) {
        double mean = 0;

        memset(&options, 0, sizeof options);
        options.struct_size = sizeof options;
        options.tolerance = 1e-5;
        options.max_bytes = k == 0 ? 2000000 : 0;
        options.max_seconds = k == 1 ? 0.05 : 0;
        must(lcor_radiosity_solve(scene, &options, &solution, &err), &err);
        assert_false(lcor_solution_report(solution)->converged);
        assert_true(lcor_solution_report(solution)->error_rms > 1e-5);
        room_values(solution, values);
        for (int i = 0; i < VALUES; i++) {
            assert_true(values[i] > -0.1 && values[i] < 100);
            mean += values[i] / VALUES;
        }
        assert_true(mean > 3 && mean < 5);
        lcor_solution_free(solution);
    }
    lcor_scene_free(scene);
}

static void every_allocation_may_fail(void **state)
{
    (void)state;
    for (int e = 0; e < ENGINES; e++) {
        failing f = {0, 0};
        lcor_radiosity_options options = options_for(engines[e], 0.5);
        lcor_scene *scene = engines[e] == LCOR_ENGINE_LINKS ? box_room() : paper_room(1);
        lcor_status status = LCOR_ERR_NOMEM;

        commit(scene);
        options.allocator = failing_allocator(&f);
        for (long k = 0; status != LCOR_OK; k += 1 + k / 8) {
            lcor_solution *solution = NULL;
            lcor_error err;

            assert_true(k < 10000);
            f.left = k;
            status = lcor_radiosity_solve(scene, &options, &solution, &err);
            assert_true(status == LCOR_OK || status == LCOR_ERR_NOMEM);
            lcor_solution_free(solution);
            assert_int_equal(f.live, 0);
        }
        lcor_scene_free(scene);
    }
}

static void wrong_options_are_refused(void **state)
{
    lcor_scene *scene = paper_room(2);
    lcor_solution *solution = NULL;
    lcor_radiosity_options options;
    lcor_error err;

    (void)state;
    memset(&options, 0, sizeof options);
    options.struct_size = sizeof options;
    assert_int_equal(lcor_radiosity_solve(scene, &options, &solution, &err), LCOR_ERR_ARG);
    assert_non_null(strstr(err.text, "not committed"));
    commit(scene);
    options.struct_size = 0;
    assert_int_equal(lcor_radiosity_solve(scene, &options, &solution, &err), LCOR_ERR_ARG);
    options.struct_size = sizeof options;
    options.tolerance = 2;
    assert_int_equal(lcor_radiosity_solve(scene, &options, &solution, &err), LCOR_ERR_DOMAIN);
    options.tolerance = (double)NAN;
    assert_int_equal(lcor_radiosity_solve(scene, &options, &solution, &err), LCOR_ERR_DOMAIN);
    options.tolerance = 0;
    options.channels = 2;
    assert_int_equal(lcor_radiosity_solve(scene, &options, &solution, &err), LCOR_ERR_ARG);
    assert_null(solution);
    lcor_scene_free(scene);
}

/* The scene's choice and the engine it did not take give the same light; under the box it is
 * exactly dark, elsewhere nowhere. */
static void the_engine_that_was_chosen_agrees_with_the_other(void **state)
{
    enum { FINE = 20, ALL = FINE * FINE };
    const double tolerance = 0.02;
    lcor_radiosity_options options = options_for(LCOR_ENGINE_AUTO, tolerance);
    lcor_scene *scene = paper_room(FINE);
    lcor_solution *chosen, *other;
    double rms = 0;

    (void)state;
    add_box(scene, paper_box_low, paper_box_high, 0.5, 1);
    commit(scene);
    chosen = solve_with(scene, &options);
    options.engine = lcor_solution_report(chosen)->engine == LCOR_ENGINE_LINKS ? LCOR_ENGINE_GATHER
                                                                               : LCOR_ENGINE_LINKS;
    other = solve_with(scene, &options);
    for (size_t f = 0; f < 6; f++) {
        double a[ALL], b[ALL];

        must(lcor_solution_patches(chosen, f, LCOR_VALUE_CENTRE, a, NULL, NULL), NULL);
        must(lcor_solution_patches(other, f, LCOR_VALUE_CENTRE, b, NULL, NULL), NULL);
        for (int i = 0; i < ALL; i++) {
            const double x = (i / FINE + 0.5) / FINE, y = (i % FINE + 0.5) / FINE;

            if (f == 0 && x > paper_box_low[0] && x < paper_box_high[0] && y > paper_box_low[1] &&
                y < paper_box_high[1]) {
                assert_true(a[i] == 0 && b[i] == 0);
                continue;
            }
            assert_true(a[i] > 0 && b[i] > 0);
            rms += (a[i] / b[i] - 1) * (a[i] / b[i] - 1) / (6 * ALL);
        }
    }
    print_message("engines differ by %.4f (rms)\n", sqrt(rms));
    assert_true(sqrt(rms) < 1.5 * tolerance); /* each within one */
    lcor_solution_free(chosen);
    lcor_solution_free(other);
    lcor_scene_free(scene);
}

/* A square along the axes, from a corner. */
static void add_square(lcor_scene *scene, const double corner[3], const double u[3],
                       const double v[3], double emission, int two_sided)
{
    lcor_surface look;
    lcor_error err;

    memset(&look, 0, sizeof look);
    for (int c = 0; c < 3; c++) {
        look.reflectance[c] = 0.7;
        look.emission[c] = emission;
    }
    look.two_sided = two_sided;
    must(lcor_scene_add_quad(scene, corner, u, v, &look, NULL, &err), &err);
}

static lcor_engine engine_at(lcor_scene *scene, double tolerance, uint64_t points)
{
    lcor_radiosity_options options = options_for(LCOR_ENGINE_AUTO, tolerance);
    lcor_solution *solution;
    lcor_engine engine;

    options.max_seconds = 1e-3; /* the choice is what matters */
    options.points = points;
    solution = solve_with(scene, &options);
    engine = lcor_solution_report(solution)->engine;
    lcor_solution_free(solution);
    return engine;
}

/* As measured: a wall that divides a room takes links 20 ms and gather 300 at 1 %, a lamp that
 * emits a hair below a ceiling, over boxes, takes links more than a second and gather 150 ms. */
static void walls_are_for_links_and_area_lights_over_boxes_for_gather(void **state)
{
    static const double tolerances[] = {0.05, 0.01};
    lcor_scene *divided = paper_room(1), *lamp = NULL;
    lcor_error err;

    (void)state;
    add_square(divided, (double[3]){0.5, 0, 0}, (double[3]){0, 1, 0}, (double[3]){0, 0, 1}, 0, 1);
    commit(divided);
    must(lcor_scene_new(NULL, &lamp, &err), &err);
    add_room(lamp, 1, paper_rho, 0, 1);
    add_box(lamp, (double[3]){0.1, 0.6, 0}, (double[3]){0.4, 0.85, 0.6}, 0.7, 1);
    add_box(lamp, (double[3]){0.55, 0.2, 0}, (double[3]){0.85, 0.5, 0.3}, 0.7, 1);
    add_square(lamp, (double[3]){0.4, 0.4, 0.999}, (double[3]){0, 0.2, 0}, (double[3]){0.2, 0, 0},
               15, 0);
    commit(lamp);
    for (size_t t = 0; t < 2; t++) {
        assert_int_equal(engine_at(divided, tolerances[t], 0), LCOR_ENGINE_LINKS);
        assert_int_equal(engine_at(lamp, tolerances[t], 0), LCOR_ENGINE_GATHER);
    }
    lcor_scene_free(divided);
    lcor_scene_free(lamp);
}

/* A board in mid-air that emits over boxes is nothing for links, a convex room nothing for rays. */
static void paths_are_for_few_places_where_links_take_long(void **state)
{
    lcor_scene *cluttered = paper_room(1), *plain = paper_room(1);

    (void)state;
    add_box(cluttered, (double[3]){0.1, 0.6, 0}, (double[3]){0.4, 0.85, 0.6}, 0.7, 1);
    add_box(cluttered, (double[3]){0.55, 0.2, 0}, (double[3]){0.85, 0.5, 0.3}, 0.7, 1);
    add_square(cluttered, (double[3]){0.3, 0.3, 0.7}, (double[3]){0, 0.2, 0},
               (double[3]){0.2, 0, 0}, 15, 1);
    commit(cluttered);
    commit(plain);
    assert_int_equal(engine_at(cluttered, 0.01, 1), LCOR_ENGINE_PATHS);
    assert_int_equal(engine_at(cluttered, 0.01, 100), LCOR_ENGINE_GATHER);
    assert_int_equal(engine_at(cluttered, 0.01, 0), LCOR_ENGINE_GATHER);
    assert_int_equal(engine_at(plain, 0.01, 1), LCOR_ENGINE_LINKS);
    lcor_scene_free(cluttered);
    lcor_scene_free(plain);
}

static void the_report_says_what_was_switched_off_and_why(void **state)
{
    const lcor_radiosity_options asked = options_for(LCOR_ENGINE_LINKS, 0.05);
    const lcor_radiosity_options chosen = options_for(LCOR_ENGINE_AUTO, 0.05);
    lcor_scene *scene = paper_room(N);
    lcor_solution *solution;
    const lcor_radiosity_report *report;

    (void)state;
    commit(scene);
    solution = solve_with(scene, &chosen);
    report = lcor_solution_report(solution);
    assert_int_equal(report->engine_reason, LCOR_REASON_COST);
    assert_int_equal(report->engine, LCOR_ENGINE_LINKS);
    assert_true(0 < report->links_seconds && report->links_seconds < report->gather_seconds);
    assert_true(isinf(report->paths_seconds)); /* how many places is not known */
    assert_int_equal(report->visibility_reason, LCOR_REASON_CONVEX);
    assert_int_equal(report->channels_reason, LCOR_REASON_GREY);
    assert_int_equal(report->pairs_open, ROOM_FACES * (ROOM_FACES - 1));
    assert_int_equal(report->pairs_apart + report->pairs_tested, 0);
    lcor_solution_free(solution);
    lcor_scene_free(scene);

    scene = box_room();
    commit(scene);
    solution = solve_with(scene, &asked);
    report = lcor_solution_report(solution);
    assert_int_equal(report->engine_reason, LCOR_REASON_ASKED);
    assert_true(report->links_seconds == 0 && report->gather_seconds == 0 &&
                report->paths_seconds == 0);
    assert_int_equal(report->visibility_reason, LCOR_REASON_CLUTTER);
    /* the sides of the box look away from each other, its top sees the ceiling, its sides the floor
     * past nothing, and it stands between the walls */
    assert_true(report->pairs_apart >= 5 * 4);
    assert_true(report->pairs_open >= 2);
    assert_true(report->pairs_tested >= 2 * 2);
    lcor_solution_free(solution);
    lcor_scene_free(scene);
    for (int a = LCOR_REASON_ASKED; a <= LCOR_REASON_COLOURED; a++)
        for (int b = LCOR_REASON_ASKED; b < a; b++)
            assert_string_not_equal(lcor_reason_text((lcor_reason)a),
                                    lcor_reason_text((lcor_reason)b));
    assert_non_null(lcor_reason_text((lcor_reason)-1));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bits_do_not_depend_on_the_number_of_threads),
        cmocka_unit_test(bits_do_not_depend_on_the_order_of_tasks),
        cmocka_unit_test(bits_do_not_depend_on_the_instruction_set),
        cmocka_unit_test(places_may_be_rounded),
        cmocka_unit_test(results_do_not_depend_on_the_unit_of_length),
        cmocka_unit_test(irradiance_is_linear_over_the_whole_range),
        cmocka_unit_test(an_update_agrees_with_a_new_solution),
        cmocka_unit_test(exchange_is_reciprocal),
        cmocka_unit_test(channels_are_independent),
        cmocka_unit_test(progress_never_falls_and_can_cancel),
        cmocka_unit_test(a_limit_returns_the_best_solution_unconverged),
        cmocka_unit_test(every_allocation_may_fail),
        cmocka_unit_test(wrong_options_are_refused),
        cmocka_unit_test(the_engine_that_was_chosen_agrees_with_the_other),
        cmocka_unit_test(walls_are_for_links_and_area_lights_over_boxes_for_gather),
        cmocka_unit_test(paths_are_for_few_places_where_links_take_long),
        cmocka_unit_test(the_report_says_what_was_switched_off_and_why),
    };

    return cmocka_run_group_tests_name("radiosity", tests, NULL, NULL);
}
