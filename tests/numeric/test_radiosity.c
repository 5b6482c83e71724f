/* SPDX-License-Identifier: MIT */
/* The solver against the reference solution of the paper's room and against closed forms. */
#include "rooms.h"

enum { N = 50, ALL = ROOM_FACES * N * N };

typedef struct errors {
    double rms, max;
} errors;

/* Errors over all patches, as lcor_norm defines them. */
static errors compare(const lcor_solution *solution, lcor_value value)
{
    csv t = csv_read(LCOR_TEST_DATA "/reference/paper_room_50x50.csv");
    double *total = malloc(ALL * sizeof *total), mean = 0;
    errors e = {0, 0};

    assert_non_null(total);
    assert_int_equal(t.rows, ALL);
    room_patches(solution, N, value, total);
    for (size_t k = 0; k < ALL; k++)
        mean += total[k] / ALL;
    for (size_t row = 0; row < t.rows; row++) {
        const size_t f = (size_t)room_face_number(csv_text(&t, row, "face"));
        const size_t i = (size_t)csv_number(&t, row, "i"), j = (size_t)csv_number(&t, row, "j");
        const double truth =
            csv_number(&t, row, value == LCOR_VALUE_AVERAGE ? "E_avg" : "E_centre");
        const double d = (total[(f * N + i) * N + j] - truth) / fmax(truth, 0.02 * mean);

        e.rms += d * d / ALL;
        e.max = fmax(e.max, fabs(d));
    }
    e.rms = sqrt(e.rms);
    free(total);
    csv_free(&t);
    return e;
}

/* Solves at a tolerance and checks the promise and the estimate against the truth. */
static void check_request(double tolerance, lcor_norm norm, lcor_value value)
{
    lcor_scene *scene = paper_room(N);
    lcor_solution *solution;
    const lcor_radiosity_report *report;
    errors e;

    commit(scene);
    solution = solve(scene, tolerance, norm);
    report = lcor_solution_report(solution);
    e = compare(solution, value);
    print_message("request %g: true rms %.2e max %.2e, estimated rms %.2e max %.2e, %lu links, "
                  "%.2f MB\n",
                  tolerance, e.rms, e.max, report->error_rms, report->error_max,
                  (unsigned long)report->links, (double)report->bytes * 1e-6);
    assert_true(report->converged);
    assert_true((norm == LCOR_NORM_RMS ? e.rms : e.max) <= tolerance);
    assert_true(report->error_rms >= 0.8 * e.rms);
    assert_true(tolerance < 1e-3 || norm != LCOR_NORM_RMS || report->bytes <= 10000000);
    assert_true(report->energy_defect < tolerance);
    lcor_solution_free(solution);
    lcor_scene_free(scene);
}

static void a_request_of_one_percent_is_met(void **state)
{
    (void)state;
    check_request(1e-2, LCOR_NORM_RMS, LCOR_VALUE_AVERAGE);
}

static void a_request_of_one_permille_is_met(void **state)
{
    (void)state;
    check_request(1e-3, LCOR_NORM_RMS, LCOR_VALUE_AVERAGE);
}

/* Where the promise is hard: between the requests that were looked at most, and at 1e-4. */
static void requests_between_and_below_are_met(void **state)
{
    static const double tolerances[] = {5e-3, 2e-3, 5e-4, 1e-4};

    (void)state;
    for (size_t i = 0; i < sizeof tolerances / sizeof tolerances[0]; i++)
        check_request(tolerances[i], LCOR_NORM_RMS, LCOR_VALUE_AVERAGE);
}

static void centre_values_are_met_too(void **state)
{
    (void)state;
    check_request(1e-3, LCOR_NORM_RMS, LCOR_VALUE_CENTRE);
}

static void a_request_for_the_worst_patch_is_met(void **state)
{
    (void)state;
    check_request(1e-2, LCOR_NORM_MAX, LCOR_VALUE_AVERAGE);
}

/* Closed room, emission 1 everywhere: B = 1 / (1 - rho). */
static void a_white_furnace_is_exact(void **state)
{
    static const double rhos[] = {0.5, 0.9, 0.99, 0.999};

    (void)state;
    for (size_t r = 0; r < sizeof rhos / sizeof rhos[0]; r++) {
        const double rho[ROOM_FACES] = {rhos[r], rhos[r], rhos[r], rhos[r], rhos[r], rhos[r]};
        double total[ROOM_FACES * 100], worst = 0;
        lcor_scene *scene = NULL;
        lcor_solution *solution;
        lcor_error err;

        must(lcor_scene_new(NULL, &scene, &err), &err);
        add_room(scene, 1, rho, 1, 10);
        commit(scene);
        solution = solve(scene, 0.01, LCOR_NORM_RMS);
        room_patches(solution, 10, LCOR_VALUE_AVERAGE, total);
        for (size_t k = 0; k < ROOM_FACES * 100; k++)
            worst = fmax(worst, fabs((1 + rhos[r] * total[k]) * (1 - rhos[r]) - 1));
        print_message("furnace %g: worst %.1e after %d iterations\n", rhos[r], worst,
                      lcor_solution_report(solution)->iterations);
        assert_true(worst <= 1e-8);
        assert_true(lcor_solution_report(solution)->iterations <= 15);
        lcor_solution_free(solution);
        lcor_scene_free(scene);
    }
}

/* The room with a box, at the patches of an independent path tracing (bench/reference_box_room.c).
 */
static void occlusion_agrees_with_path_tracing(void **state)
{
    csv t = csv_read(LCOR_TEST_DATA "/reference/box_room_50x50.csv");
    double *total = malloc(ALL * sizeof *total), square = 0, noise = 0, worst = 0, mean = 0;
    double beside = 0, patches_beside = 0;
    lcor_scene *scene = paper_room(N);
    lcor_solution *solution;

    (void)state;
    assert_non_null(total);
    add_box(scene, paper_box_low, paper_box_high, 0.5, 10);
    commit(scene);
    solution = solve(scene, 3e-3, LCOR_NORM_RMS);
    room_patches(solution, N, LCOR_VALUE_AVERAGE, total);
    for (size_t k = 0; k < ALL; k++)
        mean += total[k] / ALL;
    for (size_t row = 0; row < t.rows; row++) {
        const size_t f = (size_t)room_face_number(csv_text(&t, row, "face"));
        const size_t i = (size_t)csv_number(&t, row, "i"), j = (size_t)csv_number(&t, row, "j");
        const double truth = csv_number(&t, row, "E_avg"), scale = fmax(truth, 0.02 * mean);
        const double d = (total[(f * N + i) * N + j] - truth) / scale;
        const double s = csv_number(&t, row, "sigma") / scale;

        square += d * d / (double)t.rows;
        noise += s * s / (double)t.rows;
        worst = fmax(worst, fabs(d));
        /* between the box and the wall, where it hides parts of the ceiling and of walls: errors
         * of what is left of these do not cancel from patch to patch */
        if (f == 0 && i >= 24 && i <= 40 && j >= 2 && j <= 9) {
            beside += d;
            patches_beside++;
        }
    }
    /* A third of the patches lie where it is hardest: around the box and at shadow edges. */
    print_message("box: rms %.2e with noise %.2e, worst %.2e, mean beside it %.2e\n", sqrt(square),
                  sqrt(noise), worst, beside / patches_beside);
    assert_true(sqrt(square) <= 3e-3);
    assert_true(worst <= 2e-2);
    assert_true(fabs(beside / patches_beside) <= 5e-3);
    free(total);
    csv_free(&t);
    lcor_solution_free(solution);
    lcor_scene_free(scene);
}

static void points_agree_with_patch_centres(void **state)
{
    lcor_scene *scene = paper_room(8);
    lcor_solution *solution;
    lcor_error err;

    (void)state;
    add_box(scene, paper_box_low, paper_box_high, 0.5, 8);
    commit(scene);
    solution = solve(scene, 0.05, LCOR_NORM_RMS);
    for (size_t s = 0; s < lcor_scene_surface_count(scene); s++) {
        double centres[64 * 3], normal[3], normals[64 * 3], patch[64], patch_direct[64], at[64],
            direct[64];

        must(lcor_scene_patch_geometry(scene, s, centres, NULL, normal, &err), &err);
        for (int k = 0; k < 64 * 3; k++)
            normals[k] = normal[k % 3];
        must(lcor_solution_patches(solution, s, LCOR_VALUE_CENTRE, patch, patch_direct, &err),
             &err);
        must(lcor_solution_at(solution, 64, centres, normals, at, direct, &err), &err);
        for (int k = 0; k < 64; k++) {
            check_near(at[k], patch[k], 1e-9 * (1 + patch[k]), "total");
            check_near(direct[k], patch_direct[k], 1e-12 * (1 + patch[k]), "direct");
        }
    }
    lcor_solution_free(solution);
    lcor_scene_free(scene);
}

/* A box's lit side on the border of an element much longer than it: places along it, as elements
 * have them and gathered a hair above. */
static void a_short_wall_lights_the_long_strip_beside_it(void **state)
{
    static const double edge[3] = {2.612, 2.946, 1.231};
    static const double rho[ROOM_FACES] = {0.44, 0.79, 0.66, 0.73, 0.48, 0.63};
    static const double low[3] = {0.422, 1.229, 0}, high[3] = {0.693, 1.651, 0.22};
    lcor_scene *scene = NULL;
    lcor_solution *solution;
    lcor_error err;

    (void)state;
    must(lcor_scene_new(NULL, &scene, &err), &err);
    for (int f = 0; f < ROOM_FACES; f++) {
        const lcor_surface look = {.reflectance = {rho[f], rho[f], rho[f]}, .patches = {32, 32}};
        double quad[9];

        for (int k = 0; k < 9; k++)
            quad[k] = edge[k % 3] * room_quads[f][k];
        must(lcor_scene_add_quad(scene, quad, quad + 3, quad + 6, &look, NULL, &err), &err);
    }
    add_box(scene, low, high, 0.36, 8);
    add_lamp(scene, 2.084, 1.354, 1.076, 1);
    commit(scene);
    solution = solve(scene, 3e-3, LCOR_NORM_RMS);
    for (int i = 0; i < 20; i++) {
        const double x = high[0] + 0.01 + 0.01 * (i % 5), y = low[1] + 0.06 + 0.1 * (i / 5);
        const double points[6] = {x, y, 0, x, y, 1e-4}, normals[6] = {0, 0, 1, 0, 0, 1};
        double total[2];

        must(lcor_solution_at(solution, 2, points, normals, total, NULL, &err), &err);
        check_near(total[0] / total[1], 1, 0.03, "beside the lit side of a box");
    }
    lcor_solution_free(solution);
    lcor_scene_free(scene);
}

/* A point in free space has no element: it is gathered, and must agree with its neighbourhood. */
static void points_in_space_are_gathered(void **state)
{
    const double point[6] = {0.5, 0.5, 1e-4, 0.5, 0.5, 0}, normal[6] = {0, 0, 1, 0, 0, 1};
    double total[2];
    lcor_scene *scene = paper_room(10);
    lcor_solution *solution;
    lcor_error err;

    (void)state;
    commit(scene);
    solution = solve(scene, 1e-3, LCOR_NORM_RMS);
    must(lcor_solution_at(solution, 2, point, normal, total, NULL, &err), &err);
    check_near(total[0], total[1], 5e-3 * total[1], "gathered against interpolated");
    lcor_solution_free(solution);
    lcor_scene_free(scene);
}

static void normals_of_any_length_are_taken_and_nonsense_is_refused(void **state)
{
    const double points[6] = {0.5, 0.5, 0, 0.5, 0.5, 0}, normals[6] = {0, 0, 1, 0, 0, 1e-200};
    double total[2] = {-1, -1};
    lcor_scene *scene = paper_room(2);
    lcor_solution *solution;
    lcor_error err;

    (void)state;
    commit(scene);
    solution = solve(scene, 0.05, LCOR_NORM_RMS);
    must(lcor_solution_at(solution, 2, points, normals, total, NULL, &err), &err);
    assert_true(total[0] > 0 && total[0] == total[1]);
    for (int k = 0; k < 6; k++) {
        const double bad[3] = {(double)NAN, HUGE_VAL, -HUGE_VAL};
        double p[6], n[6];

        memcpy(p, points, sizeof p);
        memcpy(n, normals, sizeof n);
        (k < 3 ? p : n)[3 + k % 3] = bad[k % 3];
        assert_int_equal(lcor_solution_at(solution, 2, p, n, total, NULL, &err), LCOR_ERR_DOMAIN);
        assert_int_equal(err.where, 1);
    }
    assert_int_equal(lcor_solution_at(solution, 2, points, (double[6]){0, 0, 1}, total, NULL, &err),
                     LCOR_ERR_DOMAIN);
    assert_non_null(strstr(err.text, "normal 1 has no direction"));
    lcor_solution_free(solution);
    lcor_scene_free(scene);
}

/* Direct averages next to a shadow's edge are areas, not samples: a fine grid's mean is the coarse
 * grid's value. */
static void shadow_edges_are_exact_in_averages(void **state)
{
    double sum[2] = {0, 0};

    (void)state;
    for (int pass = 0; pass < 2; pass++) {
        const size_t n = pass ? 24 : 3;
        double *direct = malloc(n * n * sizeof *direct);
        lcor_scene *scene = paper_room(n);
        lcor_solution *solution;
        lcor_error err;

        assert_non_null(direct);
        add_box(scene, paper_box_low, paper_box_high, 0.5, 1);
        commit(scene);
        solution = solve(scene, 0.01, LCOR_NORM_RMS);
        must(lcor_solution_patches(solution, 0, LCOR_VALUE_AVERAGE, NULL, direct, &err), &err);
        for (size_t i = 2 * n / 3; i < n; i++) /* the third behind the box */
            for (size_t j = 2 * n / 3; j < n; j++)
                sum[pass] += direct[i * n + j] / (double)(n * n / 9);
        free(direct);
        lcor_solution_free(solution);
        lcor_scene_free(scene);
    }
    assert_true(sum[0] > 0.1);
    check_near(sum[0], sum[1], 1e-4 * sum[1], "average of direct light");
}

/* A triangle of area 1/2, alone. */
static lcor_scene *triangle_scene(void)
{
    lcor_scene *scene = NULL;
    lcor_surface look;
    lcor_error err;

    must(lcor_scene_new(NULL, &scene, &err), &err);
    memset(&look, 0, sizeof look);
    must(lcor_scene_add_triangle(scene, (double[3]){0, 0, 0}, (double[3]){1, 0, 0},
                                 (double[3]){0, 1, 0}, &look, NULL, &err),
         &err);
    return scene;
}

/* Its average is the mean over its points, not what one of them sees. Frees the scene. */
static void check_triangle_average(lcor_scene *scene, double accuracy)
{
    enum { POINTS = 100000 };
    const double up[3] = {0, 0, 1};
    double average, mean = 0;
    lcor_solution *solution;
    lcor_error err;

    commit(scene);
    solution = solve(scene, 0.01, LCOR_NORM_RMS);
    must(lcor_solution_patches(solution, 0, LCOR_VALUE_AVERAGE, NULL, &average, &err), &err);
    for (int i = 0; i < POINTS; i++) { /* a sequence of low discrepancy, folded into the triangle */
        double s = fmod((i + 1) * 0.7548776662466927, 1), t = fmod((i + 1) * 0.5698402909980532, 1);
        double x[3], direct;

        x[0] = s + t > 1 ? 1 - s : s;
        x[1] = s + t > 1 ? 1 - t : t;
        x[2] = 0;
        must(lcor_solution_at(solution, 1, x, up, NULL, &direct, &err), &err);
        mean += direct / POINTS;
    }
    print_message("off by %.1e of %g\n", fabs(average / mean - 1), mean);
    check_near(average, mean, accuracy * mean, "direct light of the triangle");
    lcor_solution_free(solution);
    lcor_scene_free(scene);
}

/* Gratings of so many slats that they are not clipped at once, or not at all. */
static void many_occluders_shade_a_triangle_in_part(void **state)
{
    static const struct {
        int side; /* slats along it */
        double width, lamp;
    } gratings[] = {{20, 0.5, 1}, {100, 0.9, 0.4}};

    (void)state;
    for (size_t k = 0; k < 2; k++) {
        const int side = gratings[k].side;
        const double u[3] = {gratings[k].width / side, 0, 0}, v[3] = {0, 0.6 / side, 0};
        lcor_scene *scene = triangle_scene();
        lcor_surface look;
        lcor_error err;

        memset(&look, 0, sizeof look);
        for (int i = 0; i < side * side; i++) {
            const double x = (i % side + 0.3) / side, y = ((double)(i / side) + 0.2) / side;

            must(lcor_scene_add_quad(scene, (double[3]){x, y, 0.2}, u, v, &look, NULL, &err), &err);
        }
        add_lamp(scene, 0.4, 0.3, gratings[k].lamp, 1);
        check_triangle_average(scene, k == 0 ? 2e-3 : 1e-2);
    }
}

/* The edges of a spotlight's cone and the end of a light's range cross the triangle. */
static void beams_are_averaged_over_a_triangle(void **state)
{
    static const double cones[][2] = {{0.2, 0.5}, {0.3, 0.301}, {0, 1.2}};

    (void)state;
    for (size_t k = 0; k < 4; k++) {
        lcor_scene *scene = triangle_scene();
        lcor_light light;
        lcor_error err;

        memset(&light, 0, sizeof light);
        light.position[0] = 0.4;
        light.position[1] = 0.3;
        light.position[2] = 0.7;
        light.intensity[0] = light.intensity[1] = light.intensity[2] = 1;
        if (k < 3) {
            light.kind = LCOR_LIGHT_SPOT;
            light.direction[0] = 0.1;
            light.direction[2] = -1;
            light.inner_cone = cones[k][0];
            light.outer_cone = cones[k][1];
        } else {
            light.range = 0.85;
        }
        must(lcor_scene_add_light(scene, &light, NULL, &err), &err);
        check_triangle_average(scene, 1e-3);
    }
}

/* A shelf a quarter of a patch above the floor. Twenty gaps away from its edge the floor is as good
 * as dark: whatever irradiance is left there is error, and the estimate must know of it. */
static void a_gap_narrower_than_a_patch_is_not_missed(void **state)
{
    const double low[3] = {0.45, 0.2, 0.005}, u[3] = {0.3, 0, 0}, v[3] = {0, 0.3, 0};
    lcor_scene *scene = paper_room(N);
    lcor_radiosity_options options;
    lcor_solution *solution = NULL;
    lcor_surface shelf;
    lcor_error err;
    double floor[N * N], mean = 0, square = 0;

    (void)state;
    memset(&shelf, 0, sizeof shelf);
    shelf.two_sided = 1;
    shelf.reflectance[0] = shelf.reflectance[1] = shelf.reflectance[2] = 0.5;
    must(lcor_scene_add_quad(scene, low, u, v, &shelf, NULL, &err), &err);
    commit(scene);
    memset(&options, 0, sizeof options);
    options.struct_size = sizeof options;
    options.tolerance = 0.01;
    options.engine = LCOR_ENGINE_LINKS;
    must(lcor_radiosity_solve(scene, &options, &solution, &err), &err);
    must(lcor_solution_patches(solution, 0, LCOR_VALUE_AVERAGE, floor, NULL, &err), &err);
    for (int i = 0; i < N * N; i++)
        mean += floor[i] / (N * N);
    for (int i = 28; i < 32; i++)
        for (int j = 16; j < 19; j++)
            square += pow(floor[i * N + j] / (0.02 * mean), 2) / (ROOM_FACES * N * N);
    printf("gap: in the dark %.2e of the rms, estimated %.2e, %s\n", sqrt(square),
           lcor_solution_report(solution)->error_rms,
           lcor_solution_report(solution)->converged ? "converged" : "not converged");
    assert_true(lcor_solution_report(solution)->converged);
    assert_true(0.8 * sqrt(square) <= lcor_solution_report(solution)->error_rms);
    lcor_solution_free(solution);
    lcor_scene_free(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_request_of_one_percent_is_met),
        cmocka_unit_test(a_request_of_one_permille_is_met),
        cmocka_unit_test(requests_between_and_below_are_met),
        cmocka_unit_test(centre_values_are_met_too),
        cmocka_unit_test(a_request_for_the_worst_patch_is_met),
        cmocka_unit_test(a_white_furnace_is_exact),
        cmocka_unit_test(occlusion_agrees_with_path_tracing),
        cmocka_unit_test(points_agree_with_patch_centres),
        cmocka_unit_test(a_short_wall_lights_the_long_strip_beside_it),
        cmocka_unit_test(points_in_space_are_gathered),
        cmocka_unit_test(normals_of_any_length_are_taken_and_nonsense_is_refused),
        cmocka_unit_test(shadow_edges_are_exact_in_averages),
        cmocka_unit_test(many_occluders_shade_a_triangle_in_part),
        cmocka_unit_test(a_gap_narrower_than_a_patch_is_not_missed),
        cmocka_unit_test(beams_are_averaged_over_a_triangle),
    };

    return cmocka_run_group_tests_name("radiosity", tests, NULL, NULL);
}
