/* SPDX-License-Identifier: MIT */
/* Engine paths: rays without a field, for few places. */
#include "rooms.h"

/* Sanitizers make every ray ten times as slow. */
#ifdef __SANITIZE_ADDRESS__
enum { N = 2, PLACES = 12 };
#else
enum { N = 3, PLACES = 48 };
#endif

static lcor_radiosity_options paths_for(double tolerance, uint64_t points)
{
    lcor_radiosity_options options = options_for(LCOR_ENGINE_PATHS, tolerance);

    options.points = points;
    return options;
}

/* Places on the walls and the ceiling: none is dark. */
static void room_places(double points[3 * PLACES], double normals[3 * PLACES])
{
    static const double facing[5][3] = {{0, 0, -1}, {1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}};

    for (int i = 0; i < PLACES; i++)
        for (int k = 0; k < 3; k++) {
            const double *n = facing[i % 5];
            const double free = fmod(0.37 + 0.618034 * (i + 11 * k), 1);

            points[3 * i + k] = n[k] > 0 ? 0 : n[k] < 0 ? 1 : 0.05 + 0.9 * free;
            normals[3 * i + k] = n[k];
        }
}

/* Channel `channel` at the places. */
static void ask(const lcor_solution *solution, int channel, double values[PLACES])
{
    const int channels = lcor_solution_report(solution)->channels;
    double points[3 * PLACES], normals[3 * PLACES], all[3 * PLACES];
    lcor_error err;

    room_places(points, normals);
    must(lcor_solution_at(solution, PLACES, points, normals, all, NULL, &err), &err);
    for (int i = 0; i < PLACES; i++)
        values[i] = all[i * channels + channel];
}

static double rms_between(const double *a, const double *truth, size_t n)
{
    double square = 0;

    for (size_t i = 0; i < n; i++)
        square += (a[i] / truth[i] - 1) * (a[i] / truth[i] - 1) / (double)n;
    return sqrt(square);
}

static lcor_scene *box_room(void)
{
    lcor_scene *scene = paper_room(N);

    add_box(scene, paper_box_low, paper_box_high, 0.5, N);
    return scene;
}

/* Closed room, emission 1 everywhere: E = 1 / (1 - rho). Paths are ended by chance, hence without
 * bias however long they are. */
static void a_white_furnace_is_within_the_tolerance(void **state)
{
    static const double rhos[] = {0.5, 0.9, 0.97};
    static const double tolerances[] = {0.02, 0.03, 0.05};

    (void)state;
    for (size_t r = 0; r < 3; r++) {
        const double rho[ROOM_FACES] = {rhos[r], rhos[r], rhos[r], rhos[r], rhos[r], rhos[r]};
        const lcor_radiosity_options options = paths_for(tolerances[r], 1);
        double values[PLACES], truth[PLACES];
        lcor_scene *scene = NULL;
        lcor_solution *solution;
        lcor_error err;

        must(lcor_scene_new(NULL, &scene, &err), &err);
        add_room(scene, 1, rho, 1, 1);
        commit(scene);
        solution = solve_with(scene, &options);
        ask(solution, 0, values);
        for (int i = 0; i < PLACES; i++)
            truth[i] = 1 / (1 - rhos[r]);
        print_message("furnace %g: rms %.1e, reported %.1e\n", rhos[r],
                      rms_between(values, truth, PLACES),
                      lcor_solution_report(solution)->error_rms);
        assert_true(rms_between(values, truth, PLACES) <= tolerances[r]);
        lcor_solution_free(solution);
        lcor_scene_free(scene);
    }
}

/* At points and over patches, by links as the truth; what is reported is no less than three
 * quarters of what is true. */
static void requests_are_met_and_reported(void **state)
{
    static const double tolerances[] = {0.03, 0.01};
    lcor_scene *scene = box_room();
    lcor_solution *exact;
    double truth[PLACES], patches[2][ROOM_FACES * N * N];

    (void)state;
    commit(scene);
    exact = solve(scene, 1e-3, LCOR_NORM_RMS);
    assert_int_equal(lcor_solution_report(exact)->engine, LCOR_ENGINE_LINKS);
    ask(exact, 0, truth);
    room_patches(exact, N, LCOR_VALUE_AVERAGE, patches[0]);
    for (size_t t = 0; t < 2; t++) {
        const lcor_radiosity_options options = paths_for(tolerances[t], 10);
        lcor_solution *solution = solve_with(scene, &options);
        const lcor_radiosity_report *report = lcor_solution_report(solution);
        double values[PLACES], rms[2];

        ask(solution, 0, values);
        room_patches(solution, N, LCOR_VALUE_AVERAGE, patches[1]);
        rms[0] = rms_between(values, truth, PLACES);
        rms[1] = rms_between(patches[1], patches[0], ROOM_FACES * N * N);
        print_message("%g: points %.4f, patches %.4f, reported %.4f\n", tolerances[t], rms[0],
                      rms[1], report->error_rms);
        assert_int_equal(report->engine, LCOR_ENGINE_PATHS);
        assert_true(report->converged && report->error_rms <= tolerances[t]);
        assert_int_equal(report->elements, 0);
        for (int k = 0; k < 2; k++)
            assert_true(0.75 * rms[k] <= report->error_rms);
        lcor_solution_free(solution);
    }
    lcor_solution_free(exact);
    lcor_scene_free(scene);
}

/* For the largest error too, of which a promise counts at every place. */
static void the_largest_error_is_within_the_tolerance(void **state)
{
    lcor_radiosity_options options = paths_for(0.05, 4);
    lcor_scene *scene = box_room();
    lcor_solution *exact, *solution;
    double truth[PLACES], values[PLACES];

    (void)state;
    options.norm = LCOR_NORM_MAX;
    commit(scene);
    exact = solve(scene, 3e-3, LCOR_NORM_RMS);
    ask(exact, 0, truth);
    solution = solve_with(scene, &options);
    ask(solution, 0, values);
    assert_true(lcor_solution_report(solution)->converged);
    for (int i = 0; i < PLACES; i++)
        assert_true(fabs(values[i] / truth[i] - 1) <= 0.05);
    lcor_solution_free(solution);
    lcor_solution_free(exact);
    lcor_scene_free(scene);
}

/* A report that costs more than the answers would be absurd. */
static void fewer_places_take_less(void **state)
{
    static const uint64_t points[] = {0, 40, 1};
    uint64_t rays[3];
    lcor_scene *scene = box_room();

    (void)state;
    commit(scene);
    for (size_t i = 0; i < 3; i++) {
        const lcor_radiosity_options options = paths_for(0.02, points[i]);
        lcor_solution *solution = solve_with(scene, &options);

        rays[i] = lcor_solution_report(solution)->rays;
        lcor_solution_free(solution);
    }
    print_message("%lu, %lu, %lu rays\n", (unsigned long)rays[0], (unsigned long)rays[1],
                  (unsigned long)rays[2]);
    assert_true(rays[1] < rays[0] && rays[2] < rays[0] / 2);
    lcor_scene_free(scene);
}

/* After a lamp has moved, and got a colour, an update gives the bits of solving anew. */
static void an_update_is_a_new_solution(void **state)
{
    const lcor_radiosity_options options = paths_for(0.05, 10);

    (void)state;
    for (int coloured = 0; coloured < 2; coloured++) {
        lcor_scene *scene = box_room();
        lcor_solution *solution, *again;
        double values[2][PLACES];
        lcor_light light;
        lcor_error err;

        commit(scene);
        solution = solve_with(scene, &options);
        memset(&light, 0, sizeof light);
        light.position[0] = light.position[1] = 0.6;
        light.position[2] = 0.8;
        light.intensity[0] = coloured ? 2 : 1;
        light.intensity[1] = light.intensity[2] = 1;
        must(lcor_scene_set_light(scene, 0, &light, &err), &err);
        must(lcor_solution_update(solution, &err), &err);
        again = solve_with(scene, &options);
        assert_int_equal(lcor_solution_report(solution)->channels, coloured ? 3 : 1);
        for (int c = 0; c < lcor_solution_report(solution)->channels; c++) {
            ask(solution, c, values[0]);
            ask(again, c, values[1]);
            assert_memory_equal(values[0], values[1], sizeof values[0]);
        }
        ask(solution, 0, values[0]);
        for (int i = 0; coloured && i < PLACES; i++) /* the last asked for is blue */
            check_near(values[0][i], 2 * values[1][i], 1e-9 * values[0][i], "red is twice blue");
        lcor_solution_free(solution);
        lcor_solution_free(again);
        lcor_scene_free(scene);
    }
}

static void it_can_be_cancelled(void **state)
{
    lcor_scene *scene = box_room();

    (void)state;
    commit(scene);
    check_cancelled(scene, paths_for(0.05, 1), 2);
    lcor_scene_free(scene);
}

static void a_limit_returns_what_there_is_and_says_so(void **state)
{
    lcor_scene *scene = box_room();
    lcor_solution *exact;
    double truth[PLACES];

    (void)state;
    commit(scene);
    exact = solve(scene, 3e-3, LCOR_NORM_RMS);
    ask(exact, 0, truth);
    for (int k = 0; k < 2; k++) {
        lcor_radiosity_options options = paths_for(1e-3, 1);
        lcor_solution *solution;
        double values[PLACES];

        options.max_bytes = k == 0 ? 100 : 0;
        options.max_seconds = k == 1 ? 0.02 : 0;
        solution = solve_with(scene, &options);
        ask(solution, 0, values);
        print_message("limited: true rms %.4f, reported %.4f\n", rms_between(values, truth, PLACES),
                      lcor_solution_report(solution)->error_rms);
        assert_false(lcor_solution_report(solution)->converged);
        assert_true(lcor_solution_report(solution)->error_rms > 1e-3);
        assert_true(rms_between(values, truth, PLACES) <=
                    3 * lcor_solution_report(solution)->error_rms);
        lcor_solution_free(solution);
    }
    lcor_solution_free(exact);
    lcor_scene_free(scene);
}

static void a_dark_scene_is_no_error(void **state)
{
    const lcor_radiosity_options options = paths_for(0.01, 1);
    lcor_scene *scene = NULL;
    lcor_solution *solution;
    double values[PLACES];
    lcor_error err;

    (void)state;
    must(lcor_scene_new(NULL, &scene, &err), &err);
    add_room(scene, 1, paper_rho, 0, N);
    commit(scene);
    solution = solve_with(scene, &options);
    assert_true(lcor_solution_report(solution)->converged);
    ask(solution, 0, values);
    for (int i = 0; i < PLACES; i++)
        check_near(values[i], 0, 0, "dark");
    lcor_solution_free(solution);
    lcor_scene_free(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_white_furnace_is_within_the_tolerance),
        cmocka_unit_test(requests_are_met_and_reported),
        cmocka_unit_test(the_largest_error_is_within_the_tolerance),
        cmocka_unit_test(fewer_places_take_less),
        cmocka_unit_test(an_update_is_a_new_solution),
        cmocka_unit_test(it_can_be_cancelled),
        cmocka_unit_test(a_limit_returns_what_there_is_and_says_so),
        cmocka_unit_test(a_dark_scene_is_no_error),
    };

    return cmocka_run_group_tests_name("paths", tests, NULL, NULL);
}
