/* SPDX-License-Identifier: MIT */
/* Engine gather against closed forms, engine links, and what must hold for any scene. */
#include "geometry/factor.h"
#include "rooms.h"

enum { N = 6, VALUES = ROOM_FACES * N * N };

static lcor_solution *gather(const lcor_scene *scene, double tolerance)
{
    const lcor_radiosity_options options = options_for(LCOR_ENGINE_GATHER, tolerance);

    return solve_with(scene, &options);
}

static void add_square(lcor_scene *scene, const double origin[3], const double u[3],
                       const double v[3], double rho, double emission, int two_sided)
{
    lcor_surface look;
    lcor_error err;

    memset(&look, 0, sizeof look);
    for (int c = 0; c < 3; c++) {
        look.reflectance[c] = rho;
        look.emission[c] = emission;
    }
    look.two_sided = two_sided;
    must(lcor_scene_add_quad(scene, origin, u, v, &look, NULL, &err), &err);
}

static lcor_scene *new_scene(void)
{
    lcor_scene *scene = NULL;
    lcor_error err;

    must(lcor_scene_new(NULL, &scene, &err), &err);
    return scene;
}

/* As lcor_norm defines it. */
static double rms_between(const double *a, const double *truth, size_t n)
{
    double mean = 0, square = 0;

    for (size_t i = 0; i < n; i++)
        mean += truth[i] / (double)n;
    for (size_t i = 0; i < n; i++) {
        const double d = (a[i] - truth[i]) / fmax(truth[i], 0.02 * mean);

        square += d * d / (double)n;
    }
    return sqrt(square);
}

/* Closed room, emission 1 everywhere: E = 1 / (1 - rho). */
static void a_white_furnace_is_within_the_tolerance(void **state)
{
    static const double rhos[] = {0.5, 0.9, 0.999};

    (void)state;
    for (size_t r = 0; r < 3; r++) {
        const double rho[ROOM_FACES] = {rhos[r], rhos[r], rhos[r], rhos[r], rhos[r], rhos[r]};
        double values[VALUES], truth[VALUES];
        lcor_scene *scene = new_scene();
        lcor_solution *solution;

        add_room(scene, 1, rho, 1, N);
        commit(scene);
        solution = gather(scene, 0.01);
        room_patches(solution, N, LCOR_VALUE_AVERAGE, values);
        for (int i = 0; i < VALUES; i++)
            truth[i] = 1 / (1 - rhos[r]);
        print_message("furnace %g: rms %.1e\n", rhos[r], rms_between(values, truth, VALUES));
        assert_true(rms_between(values, truth, VALUES) <= 0.01);
        lcor_solution_free(solution);
        lcor_scene_free(scene);
    }
}

/* Mean of the errors of which rms_between takes the root mean square. */
static double bias_between(const double *values, const double *truth, int n)
{
    double mean = 0, sum = 0;

    for (int i = 0; i < n; i++)
        mean += truth[i] / n;
    for (int i = 0; i < n; i++)
        sum += (values[i] - truth[i]) / fmax(truth[i], 0.02 * mean) / n;
    return sum;
}

/* The room of the paper, and its box: true and reported errors, of averages and centres, and what
 * they have in common. */
static void requests_are_met_where_links_know_the_answer(void **state)
{
    static const double tolerances[] = {0.02, 0.01, 0.005};

    (void)state;
    for (int box = 0; box < 2; box++) {
        lcor_scene *scene = paper_room(N);
        lcor_solution *reference;
        double truth[2][VALUES];

        if (box) /* clear of the patches' centres */
            add_box(scene, (double[3]){0.46, 0.21, 0}, (double[3]){0.73, 0.48, 0.4}, 0.5, N);
        commit(scene);
        reference = solve(scene, 2e-3, LCOR_NORM_RMS);
        room_patches(reference, N, LCOR_VALUE_AVERAGE, truth[0]);
        room_patches(reference, N, LCOR_VALUE_CENTRE, truth[1]);
        for (int t = 0; t < (box ? 1 : 3); t++) {
            lcor_solution *solution = gather(scene, tolerances[t]);
            const lcor_radiosity_report *report = lcor_solution_report(solution);

            assert_true(report->converged);
            for (int value = 0; value < 2; value++) {
                double values[VALUES], rms;

                room_patches(solution, N, (lcor_value)value, values);
                rms = rms_between(values, truth[value], VALUES);
                print_message("request %g: true rms %.2e, estimated %.2e, bias %.1e\n",
                              tolerances[t], rms, report->error_rms,
                              bias_between(values, truth[value], VALUES));
                assert_true(fabs(bias_between(values, truth[value], VALUES)) <=
                            0.25 * tolerances[t]);
                assert_true(rms <= 1.2 * tolerances[t]);
                assert_true(report->error_rms >= 0.6 * rms && report->error_rms <= 2.5 * rms);
            }
            lcor_solution_free(solution);
        }
        lcor_solution_free(reference);
        lcor_scene_free(scene);
    }
}

/* Squares that emit, large and small, over points of a black floor: Lambert's formula. */
static void emitters_agree_with_closed_forms(void **state)
{
    static const double sizes[] = {4, 0.5, 0.02};

    (void)state;
    for (size_t k = 0; k < 3; k++) {
        const double a = sizes[k], power = 1 / (a * a);
        const double low[3] = {-a / 2, -a / 2, 1};
        const double corners[12] = {low[0],     low[1],     1, low[0],     low[1] + a, 1,
                                    low[0] + a, low[1] + a, 1, low[0] + a, low[1],     1};
        double points[60], normals[60], total[20], direct[20], truth[20];
        lcor_scene *scene = new_scene();
        lcor_solution *solution;
        lcor_error err;

        add_square(scene, (double[3]){-5, -5, 0}, (double[3]){10, 0, 0}, (double[3]){0, 10, 0}, 0,
                   0, 0);
        add_square(scene, low, (double[3]){0, a, 0}, (double[3]){a, 0, 0}, 0, power, 0);
        commit(scene);
        solution = gather(scene, 0.01);
        for (int i = 0; i < 20; i++) {
            const double x[3] = {0.15 * i, 0.05 * i, 0}, up[3] = {0, 0, 1};

            memcpy(points + 3 * i, x, sizeof x);
            memcpy(normals + 3 * i, up, sizeof up);
            truth[i] = power * lcor_factor_point(x, up, 4, corners);
        }
        must(lcor_solution_at(solution, 20, points, normals, total, direct, &err), &err);
        print_message("emitter of %g: rms %.1e\n", a, rms_between(total, truth, 20));
        assert_true(rms_between(total, truth, 20) <= 0.02);
        for (int i = 0; i < 20; i++)
            check_near(direct[i], 0, 0, "direct");
        lcor_solution_free(solution);
        lcor_scene_free(scene);
    }
}

/* A wall as thin as can be: nothing of the light on one side is on the other. */
static void no_light_leaks_through_a_thin_wall(void **state)
{
    const double rho[ROOM_FACES] = {0.7, 0.7, 0.7, 0.7, 0.7, 0.7};
    lcor_scene *scene = new_scene();
    double points[2][90], normals[90], total[30];
    lcor_solution *solution;
    lcor_error err;

    (void)state;
    add_room(scene, 1, rho, 0, 1);
    add_square(scene, (double[3]){0.5, 0, 0}, (double[3]){0, 1, 0}, (double[3]){0, 0, 1}, 0.7, 0,
               1);
    add_lamp(scene, 0.2, 0.4, 0.6, 1);
    commit(scene);
    solution = gather(scene, 0.03);
    for (int i = 0; i < 30; i++)
        for (int k = 0; k < 3; k++) {
            /* on the floor, and on the wall's two sides */
            const double floor[3] = {0.01 + 0.016 * i, 0.03 * i, 0};
            const double wall[3] = {0.5, 0.01 + 0.03 * i, 0.3};

            points[0][3 * i + k] = i % 2 ? floor[k] : wall[k];
            points[1][3 * i + k] = i % 2 && k == 0 ? 1 - floor[0] : points[0][3 * i + k];
            normals[3 * i + k] = i % 2 ? k == 2 : -(k == 0);
        }
    must(lcor_solution_at(solution, 30, points[0], normals, total, NULL, &err), &err);
    for (int i = 0; i < 30; i++)
        assert_true(total[i] > 1);
    for (int i = 0; i < 30; i += 2)
        normals[3 * i] = 1;
    must(lcor_solution_at(solution, 30, points[1], normals, total, NULL, &err), &err);
    for (int i = 0; i < 30; i++)
        check_near(total[i], 0, 0, "behind the wall");
    lcor_solution_free(solution);
    lcor_scene_free(scene);
}

/* Between a lamp and the ceiling close above it light goes to and fro as between endless planes.
 * The two must not fill the field with leaves that only they see. */
static void a_slit_does_not_eat_the_field(void **state)
{
    const double rho[ROOM_FACES] = {0.5, 0.5, 0.5, 0.5, 0.5, 0.5};
    const double points[6] = {0.5, 0.5, 1, 0.2, 0.2, 0}, normals[6] = {0, 0, -1, 0, 0, 1};
    lcor_scene *scene = new_scene();
    const lcor_radiosity_report *report;
    lcor_solution *solution;
    double total[2];
    lcor_error err;

    (void)state;
    add_room(scene, 1, rho, 0, 1);
    add_square(scene, (double[3]){0.4, 0.4, 0.9984}, (double[3]){0.2, 0, 0}, (double[3]){0, 0.2, 0},
               0.5, 1, 1);
    commit(scene);
    solution = gather(scene, 0.02);
    must(lcor_solution_at(solution, 2, points, normals, total, NULL, &err), &err);
    assert_true(fabs(total[0] - 4.0 / 3) < 0.03 * 4 / 3);
    assert_true(total[1] > 0.01 && total[1] < 0.1);
    report = lcor_solution_report(solution);
    print_message("%lu leaves, %lu rays\n", (unsigned long)report->elements,
                  (unsigned long)report->rays);
    assert_true(report->converged && report->elements < 1000);
    lcor_solution_free(solution);
    lcor_scene_free(scene);
}

/* Under a board a hair above the floor it is dark, to the request in parts of 2 % of the mean:
 * about 0.005 here. */
static void a_slit_is_dark_inside(void **state)
{
    const double rho[ROOM_FACES] = {0.8, 0.8, 0.8, 0.8, 0.8, 0.8};
    const double points[6] = {0.5, 0.5, 0, 0.505, 0.49, 0.0001}, normals[6] = {0, 0, 1, 0, 0, -1};
    lcor_scene *scene = new_scene();
    lcor_solution *solution;
    double total[2];
    lcor_error err;

    (void)state;
    add_room(scene, 1, rho, 0, 1);
    add_square(scene, (double[3]){0.45, 0.45, 0.0001}, (double[3]){0.1, 0, 0},
               (double[3]){0, 0.1, 0}, 0.8, 0, 1);
    add_lamp(scene, 0.3, 0.4, 0.7, 1);
    commit(scene);
    solution = gather(scene, 0.02);
    must(lcor_solution_at(solution, 2, points, normals, total, NULL, &err), &err);
    print_message("in the slit: %.1e and %.1e\n", total[0], total[1]);
    for (int i = 0; i < 2; i++)
        assert_true(total[i] >= 0 && total[i] < 0.02);
    lcor_solution_free(solution);
    lcor_scene_free(scene);
}

/* Thousands of slivers, as files have them: a board over the floor as a fan of thin triangles. */
static void slivers_change_nothing(void **state)
{
    double values[2][5 * N * N];

    (void)state;
    for (int pass = 0; pass < 2; pass++) {
        lcor_scene *scene = paper_room(N);
        lcor_solution *solution;
        lcor_surface look;
        lcor_error err;

        memset(&look, 0, sizeof look);
        for (int c = 0; c < 3; c++)
            look.reflectance[c] = 0.5;
        for (int i = 0; pass == 1 && i < 2500; i++) {
            const double a[3] = {0.2, 0.2, 0.1}, b[3] = {0.2 + i * 2e-4, 0.8, 0.1};
            const double c[3] = {0.2 + (i + 1) * 2e-4, 0.8, 0.1};

            must(lcor_scene_add_triangle(scene, a, c, b, &look, NULL, &err), &err);
        }
        if (pass == 0)
            must(lcor_scene_add_triangle(scene, (double[3]){0.2, 0.2, 0.1},
                                         (double[3]){0.7, 0.8, 0.1}, (double[3]){0.2, 0.8, 0.1},
                                         &look, NULL, &err),
                 &err);
        commit(scene);
        solution = gather(scene, 0.02);
        for (size_t f = 1; f < ROOM_FACES; f++)
            must(lcor_solution_patches(solution, f, LCOR_VALUE_AVERAGE,
                                       values[pass] + (f - 1) * N * N, NULL, &err),
                 &err);
        lcor_solution_free(solution);
        lcor_scene_free(scene);
    }
    assert_true(rms_between(values[1], values[0], 5 * N * N) <= 0.03);
}

/* A knee hole that opens away from the lamp, dark down to 2 % of the mean: a request for the
 * largest error holds there too. */
static void the_largest_error_holds_in_the_dark(void **state)
{
    enum { ACROSS = 8, DEEP = 6, PLACES = ACROSS * DEEP };
    static const double corner[3] = {0.25, 0.1, 0.2}, width[3] = {0.35, 0, 0},
                        depth[3] = {0, 0.4, 0}, height[3] = {0, 0, 0.2}, down[3] = {0, 0, -1};
    lcor_radiosity_options options = options_for(LCOR_ENGINE_LINKS, 2e-3);
    double points[3 * PLACES], normals[3 * PLACES], truth[PLACES], values[PLACES], worst = 0;
    lcor_scene *scene = new_scene();
    const lcor_radiosity_report *report;
    lcor_solution *solution;
    lcor_error err;

    (void)state;
    add_room(scene, 1, paper_rho, 0, 1);
    add_lamp(scene, 0.38, 0.8, 0.6, 1);
    add_square(scene, corner, width, depth, 0.5, 0, 1);
    add_square(scene, (double[3]){0.25, 0.5, 0}, width, height, 0.5, 0, 1);
    add_square(scene, (double[3]){0.25, 0.1, 0}, depth, height, 0.5, 0, 1);
    add_square(scene, (double[3]){0.6, 0.1, 0}, depth, height, 0.5, 0, 1);
    commit(scene);
    for (int i = 0; i < PLACES; i++)
        for (int k = 0; k < 3; k++) {
            points[3 * i + k] = corner[k] + width[k] * (i % ACROSS + 0.5) / ACROSS +
                                depth[k] * (i / ACROSS + 0.5) / DEEP;
            normals[3 * i + k] = down[k];
        }
    solution = solve_with(scene, &options);
    must(lcor_solution_at(solution, PLACES, points, normals, truth, NULL, &err), &err);
    lcor_solution_free(solution);
    options = options_for(LCOR_ENGINE_GATHER, 0.03);
    options.norm = LCOR_NORM_MAX;
    solution = solve_with(scene, &options);
    must(lcor_solution_at(solution, PLACES, points, normals, values, NULL, &err), &err);
    for (int i = 0; i < PLACES; i++)
        worst = fmax(worst, fabs(values[i] / truth[i] - 1));
    report = lcor_solution_report(solution);
    print_message("dark: worst %.1e, reported %.1e, %lu leaves\n", worst, report->error_max,
                  (unsigned long)report->elements);
    assert_true(report->converged);
    assert_true(worst <= options.tolerance);
    lcor_solution_free(solution);
    lcor_scene_free(scene);
}

static lcor_scene *box_room(void)
{
    lcor_scene *scene = paper_room(N);

    add_box(scene, paper_box_low, paper_box_high, 0.5, N);
    return scene;
}

/* The same lamp and floor for each of two scenes. */
static void change_lamp_and_floor(lcor_scene *scene, double red)
{
    lcor_surface look;
    lcor_light light;
    lcor_error err;

    memset(&light, 0, sizeof light);
    light.position[0] = 0.6;
    light.position[1] = 0.7;
    light.position[2] = 0.8;
    light.intensity[0] = red;
    light.intensity[1] = light.intensity[2] = 1;
    memset(&look, 0, sizeof look);
    look.reflectance[0] = look.reflectance[1] = look.reflectance[2] = 0.7;
    look.patches[0] = look.patches[1] = N;
    must(lcor_scene_set_surface(scene, 0, &look, &err), &err);
    must(lcor_scene_set_light(scene, 0, &light, &err), &err);
}

/* After a lamp and a reflectance have changed, an update must agree with solving anew; with a
 * coloured lamp there are more channels than before. */
static void an_update_agrees_with_a_new_solution(void **state)
{
    (void)state;
    for (int coloured = 0; coloured < 2; coloured++) {
        const double red = coloured ? 2 : 1;
        const size_t channels = coloured ? 3 : 1;
        double updated[VALUES], fresh[VALUES];
        lcor_scene *scene = box_room(), *other = box_room();
        lcor_solution *solution, *again;
        lcor_error err;

        commit(scene);
        solution = gather(scene, 0.02);
        change_lamp_and_floor(scene, red);
        change_lamp_and_floor(other, red);
        must(lcor_solution_update(solution, &err), &err);
        commit(other);
        again = gather(other, 0.02);
        assert_int_equal(lcor_solution_report(solution)->channels, channels);
        for (size_t f = 0; f < ROOM_FACES; f++) {
            double light[2][3 * N * N];

            must(lcor_solution_patches(solution, f, LCOR_VALUE_AVERAGE, light[0], NULL, &err),
                 &err);
            must(lcor_solution_patches(again, f, LCOR_VALUE_AVERAGE, light[1], NULL, &err), &err);
            for (size_t i = 0; i < N * N; i++) {
                updated[f * N * N + i] = light[0][channels * i];
                fresh[f * N * N + i] = light[1][channels * i];
                if (coloured)
                    check_near(light[0][3 * i + 1], 0.5 * light[0][3 * i],
                               1e-5 * fresh[f * N * N + i], "green is half of red");
            }
        }
        print_message("updated: rms %.2e\n", rms_between(updated, fresh, VALUES));
        assert_true(rms_between(updated, fresh, VALUES) < 0.04);
        lcor_solution_free(solution);
        lcor_solution_free(again);
        lcor_scene_free(scene);
        lcor_scene_free(other);
    }
}

static void it_can_be_cancelled(void **state)
{
    lcor_scene *scene = box_room();

    (void)state;
    commit(scene);
    check_cancelled(scene, options_for(LCOR_ENGINE_GATHER, 0.02), 3);
    lcor_scene_free(scene);
}

static void a_limit_returns_the_best_solution_unconverged(void **state)
{
    lcor_scene *scene = box_room();
    lcor_solution *reference;
    double truth[VALUES];

    (void)state;
    commit(scene);
    reference = solve(scene, 5e-3, LCOR_NORM_RMS);
    room_patches(reference, N, LCOR_VALUE_AVERAGE, truth);
    lcor_solution_free(reference);
    for (int k = 0; k < 2; k++) {
        lcor_radiosity_options options = options_for(LCOR_ENGINE_GATHER, 1e-4);
        double values[VALUES];
        lcor_solution *solution;

        options.max_bytes = k == 0 ? 100000 : 0;
        options.max_seconds = k == 1 ? 0.02 : 0;
        solution = solve_with(scene, &options);
        assert_false(lcor_solution_report(solution)->converged);
        assert_true(lcor_solution_report(solution)->error_rms > 1e-4);
        room_patches(solution, N, LCOR_VALUE_AVERAGE, values);
        print_message("limited: true rms %.2e, estimated %.2e\n",
                      rms_between(values, truth, VALUES),
                      lcor_solution_report(solution)->error_rms);
        assert_true(rms_between(values, truth, VALUES) <=
                    3 * lcor_solution_report(solution)->error_rms);
        assert_true(rms_between(values, truth, VALUES) <= 0.1);
        lcor_solution_free(solution);
    }
    lcor_scene_free(scene);
}

static void a_dark_scene_is_no_error(void **state)
{
    lcor_scene *scene = new_scene();
    double values[VALUES];
    lcor_solution *solution;

    (void)state;
    add_room(scene, 1, paper_rho, 0, N);
    commit(scene);
    solution = gather(scene, 0.01);
    assert_true(lcor_solution_report(solution)->converged);
    room_patches(solution, N, LCOR_VALUE_AVERAGE, values);
    for (int i = 0; i < VALUES; i++)
        check_near(values[i], 0, 0, "dark");
    lcor_solution_free(solution);
    lcor_scene_free(scene);
}

/* One light stands for all of them by chance: never one that sends nothing. */
static void a_light_without_power_changes_nothing(void **state)
{
    double values[2][VALUES];

    (void)state;
    for (int k = 0; k < 2; k++) {
        lcor_scene *scene = box_room();
        lcor_solution *solution;
        lcor_light light;
        lcor_error err;

        memset(&light, 0, sizeof light);
        light.position[0] = light.position[1] = 0.2;
        light.position[2] = 0.9;
        if (k == 1)
            must(lcor_scene_add_light(scene, &light, NULL, &err), &err);
        commit(scene);
        solution = gather(scene, 0.02);
        room_patches(solution, N, LCOR_VALUE_AVERAGE, values[k]);
        lcor_solution_free(solution);
        lcor_scene_free(scene);
    }
    assert_memory_equal(values[0], values[1], sizeof values[0]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_white_furnace_is_within_the_tolerance),
        cmocka_unit_test(requests_are_met_where_links_know_the_answer),
        cmocka_unit_test(emitters_agree_with_closed_forms),
        cmocka_unit_test(no_light_leaks_through_a_thin_wall),
        cmocka_unit_test(a_slit_does_not_eat_the_field),
        cmocka_unit_test(a_slit_is_dark_inside),
        cmocka_unit_test(slivers_change_nothing),
        cmocka_unit_test(the_largest_error_holds_in_the_dark),
        cmocka_unit_test(an_update_agrees_with_a_new_solution),
        cmocka_unit_test(it_can_be_cancelled),
        cmocka_unit_test(a_limit_returns_the_best_solution_unconverged),
        cmocka_unit_test(a_dark_scene_is_no_error),
        cmocka_unit_test(a_light_without_power_changes_nothing),
    };

    return cmocka_run_group_tests_name("gather", tests, NULL, NULL);
}
