/* SPDX-License-Identifier: MIT */
/* Scenes at the edge of what geometry allows: everything stays finite, bounded and honest. */
#include "rooms.h"

typedef struct outcome {
    double lowest, highest, mean; /* of total irradiance over patches */
    int converged;
} outcome;

/* Solves at 10 % within a second of processor time and looks at every patch of every surface. */
static outcome look(lcor_scene *scene)
{
    lcor_radiosity_options options;
    lcor_solution *solution = NULL;
    lcor_error err;
    outcome o = {1e300, -1e300, 0, 0};
    double area = 0;

    commit(scene);
    memset(&options, 0, sizeof options);
    options.struct_size = sizeof options;
    options.tolerance = 0.1;
    options.max_seconds = 1;
    must(lcor_radiosity_solve(scene, &options, &solution, &err), &err);
    for (size_t s = 0; s < lcor_scene_surface_count(scene); s++) {
        size_t count;
        double *total, *areas;

        must(lcor_scene_patch_count(scene, s, &count, &err), &err);
        total = malloc(count * sizeof *total);
        areas = malloc(count * sizeof *areas);
        assert_true(total && areas);
        must(lcor_solution_patches(solution, s, LCOR_VALUE_AVERAGE, total, NULL, &err), &err);
        must(lcor_scene_patch_geometry(scene, s, NULL, areas, NULL, &err), &err);
        for (size_t k = 0; k < count; k++) {
            assert_true(isfinite(total[k]));
            o.lowest = fmin(o.lowest, total[k]);
            o.highest = fmax(o.highest, total[k]);
            o.mean += total[k] * areas[k];
            area += areas[k];
        }
        free(total);
        free(areas);
    }
    o.mean /= area;
    o.converged = lcor_solution_report(solution)->converged;
    assert_true(isfinite(lcor_solution_report(solution)->error_rms));
    lcor_solution_free(solution);
    lcor_scene_free(scene);
    return o;
}

static lcor_scene *room_of(double rho, double emission)
{
    const double all[ROOM_FACES] = {rho, rho, rho, rho, rho, rho};
    lcor_scene *scene = NULL;
    lcor_error err;

    must(lcor_scene_new(NULL, &scene, &err), &err);
    add_room(scene, 1, all, emission, 4);
    return scene;
}

static void add(lcor_scene *scene, const double quad[9], double rho)
{
    lcor_surface surface;
    lcor_error err;

    memset(&surface, 0, sizeof surface);
    surface.reflectance[0] = surface.reflectance[1] = surface.reflectance[2] = rho;
    surface.patches[0] = surface.patches[1] = 2;
    must(lcor_scene_add_quad(scene, quad, quad + 3, quad + 6, &surface, NULL, &err), &err);
}

/* A lamp of flux 4 pi in a room of 6 faces of reflectance 1/2: every patch's mean is known. */
static const double lamp_mean = 4 * 3.14159265358979 / 6 / 0.5;

static void light_near_a_wall_keeps_its_power(void **state)
{
    static const double heights[] = {1e-2, 1e-6};

    (void)state;
    for (int k = 0; k < 2; k++) {
        lcor_scene *scene = room_of(0.5, 0);
        outcome o;

        add_lamp(scene, 0.5, 0.5, heights[k], 1);
        o = look(scene);
        check_near(o.mean, lamp_mean, 0.05 * lamp_mean, "mean irradiance");
        assert_true(o.lowest > 0);
    }
}

static void light_on_a_surface_is_finite(void **state)
{
    lcor_scene *scene = room_of(0.5, 0);
    outcome o;

    (void)state;
    add_lamp(scene, 0.5, 0.5, 0, 1);
    o = look(scene); /* half of its light goes into the room */
    check_near(o.mean, lamp_mean / 2, 0.05 * lamp_mean, "mean irradiance");
}

static void light_in_a_corner_is_finite(void **state)
{
    lcor_scene *scene = room_of(0.5, 0);
    outcome o;

    (void)state;
    add_lamp(scene, 0, 0, 0, 1);
    o = look(scene); /* an eighth */
    check_near(o.mean, lamp_mean / 8, 0.05 * lamp_mean, "mean irradiance");
}

static void light_outside_a_closed_room_stays_outside(void **state)
{
    lcor_scene *scene = room_of(0.5, 0);
    outcome o;

    (void)state;
    add_lamp(scene, 0.5, 0.5, 1.5, 1);
    o = look(scene);
    check_near(o.highest, 0, 1e-6, "irradiance");
    assert_true(o.converged);
}

static void no_light_is_dark(void **state)
{
    outcome o = look(room_of(0.5, 0));

    (void)state;
    check_near(o.highest, 0, 0, "irradiance");
    assert_true(o.converged);
}

static void black_room_has_direct_light_only(void **state)
{
    lcor_scene *scene = room_of(0, 0);
    outcome o;

    (void)state;
    add_lamp(scene, 0.4, 0.5, 0.6, 1);
    o = look(scene);
    check_near(o.mean, lamp_mean / 2, 1e-3 * lamp_mean, "mean irradiance");
    assert_true(o.converged);
}

static void nearly_white_room_keeps_its_power(void **state)
{
    lcor_scene *scene = room_of(0.9999, 0);
    outcome o;

    (void)state;
    add_lamp(scene, 0.4, 0.5, 0.6, 1);
    o = look(scene);
    check_near(o.mean, lamp_mean * 5000, 0.05 * lamp_mean * 5000, "mean irradiance");
    assert_true(o.converged);
}

static void intensities_may_differ_by_1e8(void **state)
{
    lcor_scene *scene = room_of(0.5, 0);
    outcome o;

    (void)state;
    add_lamp(scene, 0.3, 0.4, 0.7, 1e8);
    add_lamp(scene, 0.7, 0.6, 0.3, 1);
    o = look(scene);
    check_near(o.mean, lamp_mean * 1e8, 0.05 * lamp_mean * 1e8, "mean irradiance");
    assert_true(o.converged);
}

static void touching_and_crossing_quads_are_bounded(void **state)
{
    static const double shelf[9] = {0, 0.2, 0.5, 0.4, 0, 0, 0, 0.5, 0};  /* touches x = 0 */
    static const double fin[9] = {0.2, 0.45, 0.3, 0.5, 0, 0, 0, 0, 0.4}; /* crosses the shelf */
    lcor_scene *scene = room_of(0.5, 0);
    outcome o;

    (void)state;
    add(scene, shelf, 0.5);
    add(scene, fin, 0.5);
    add_lamp(scene, 0.6, 0.7, 0.8, 1);
    o = look(scene);
    assert_true(o.lowest > -0.1 && o.highest < 100 && o.mean > 0.5);
}

static void slivers_of_aspect_1e6_are_bounded(void **state)
{
    static const double sliver[9] = {0.1, 0.3, 0.5, 0.8, 0, 0, 0, 8e-7, 0};
    lcor_scene *scene = room_of(0.5, 0), *bare = room_of(0.5, 0);
    outcome with, without;

    (void)state;
    add(scene, sliver, 0.5);
    add_lamp(scene, 0.6, 0.7, 0.8, 1);
    add_lamp(bare, 0.6, 0.7, 0.8, 1);
    with = look(scene);
    without = look(bare);
    check_near(with.mean, without.mean, 0.02 * without.mean, "a hair changes nothing");
}

static void coplanar_duplicates_are_bounded(void **state)
{
    static const double twin[9] = {0.2, 0.2, 0, 0.5, 0, 0, 0, 0.5, 0}; /* lies on the floor */
    lcor_scene *scene = room_of(0.5, 0);
    outcome o;

    (void)state;
    add(scene, twin, 0.5);
    add(scene, twin, 0.5);
    add_lamp(scene, 0.6, 0.7, 0.8, 1);
    o = look(scene);
    assert_true(o.lowest > -0.1 && o.highest < 100 && o.mean > 0.5);
}

/* The floor as a fan of triangles around one corner, and as one polygon. */
static void a_fan_of_triangles_is_a_floor(void **state)
{
    double mean[3];

    (void)state;
    for (int kind = 0; kind < 3; kind++) {
        const double half[ROOM_FACES] = {0.5, 0.5, 0.5, 0.5, 0.5, 0.5};
        const double outline[] = {0, 0, 0, 1, 0,   0, 1, 0.3, 0, 1, 0.7,
                                  0, 1, 1, 0, 0.4, 1, 0, 0,   1, 0};
        lcor_scene *scene = NULL;
        lcor_surface surface;
        lcor_error err;

        memset(&surface, 0, sizeof surface);
        surface.reflectance[0] = surface.reflectance[1] = surface.reflectance[2] = 0.5;
        surface.patches[0] = surface.patches[1] = 2;
        must(lcor_scene_new(NULL, &scene, &err), &err);
        if (kind == 0) {
            add_room(scene, 1, half, 0, 4);
        } else {
            static const double faces[5][9] = {{0, 0, 1, 0, 1, 0, 1, 0, 0},
                                               {0, 0, 0, 0, 1, 0, 0, 0, 1},
                                               {1, 0, 0, 0, 0, 1, 0, 1, 0},
                                               {0, 0, 0, 0, 0, 1, 1, 0, 0},
                                               {0, 1, 0, 1, 0, 0, 0, 0, 1}};

            for (int f = 0; f < 5; f++)
                add(scene, faces[f], 0.5);
            if (kind == 1)
                for (size_t k = 1; k < 6; k++)
                    must(lcor_scene_add_triangle(scene, outline, outline + 3 * k,
                                                 outline + 3 * (k + 1), &surface, NULL, &err),
                         &err);
            else
                must(lcor_scene_add_polygon(scene, 7, outline, &surface, NULL, &err), &err);
        }
        add_lamp(scene, 0.3, 0.4, 0.7, 1);
        mean[kind] = look(scene).mean;
    }
    check_near(mean[1], mean[0], 0.02 * mean[0], "fan");
    check_near(mean[2], mean[0], 0.02 * mean[0], "polygon");
}

static void an_open_scene_lets_light_escape(void **state)
{
    static const double floor_quad[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    static const double wall[9] = {0, 0, 0, 0, 1, 0, 0, 0, 1};
    lcor_scene *scene = NULL;
    lcor_error err;
    outcome o;

    (void)state;
    must(lcor_scene_new(NULL, &scene, &err), &err);
    add(scene, floor_quad, 0.5);
    add(scene, wall, 0.5);
    add_lamp(scene, 0.5, 0.5, 0.5, 1);
    o = look(scene);
    assert_true(o.converged && o.mean > 1 && o.mean < lamp_mean);
}

/* A lamp of 0.2 x 0.2 under the middle of the ceiling, in gaps down to 1/40 of the least element:
 * above its edges the ceiling goes dark within the gap's width. In the narrowest one it is lit as
 * between endless planes: E = M / (1 - rho^2). */
static void a_lamp_close_under_a_ceiling_lights_it(void **state)
{
    static const double gaps[] = {0.05, 0.02, 0.0016};
    const double u[3] = {0.2, 0, 0}, v[3] = {0, 0.2, 0}, point[3] = {0.5, 0.5, 1};
    const double down[3] = {0, 0, -1};

    (void)state;
    for (int k = 0; k < 3; k++) {
        const double low[3] = {0.4, 0.4, 1 - gaps[k]};
        const lcor_radiosity_options options = options_for(LCOR_ENGINE_LINKS, 0.02);
        lcor_scene *scene = room_of(0.5, 0);
        lcor_solution *solution;
        lcor_surface lamp;
        lcor_error err;
        double total;

        memset(&lamp, 0, sizeof lamp);
        lamp.two_sided = 1;
        for (int c = 0; c < 3; c++) {
            lamp.reflectance[c] = 0.5;
            lamp.emission[c] = 1;
        }
        must(lcor_scene_add_quad(scene, low, u, v, &lamp, NULL, &err), &err);
        commit(scene);
        solution = solve_with(scene, &options);
        print_message("gap %g: estimated %.1e, %lu links\n", gaps[k],
                      lcor_solution_report(solution)->error_rms,
                      (unsigned long)lcor_solution_report(solution)->links);
        assert_true(lcor_solution_report(solution)->converged);
        must(lcor_solution_at(solution, 1, point, down, &total, NULL, &err), &err);
        if (k == 2)
            check_near(total, 4.0 / 3, 0.02 * 4 / 3, "between endless planes");
        lcor_solution_free(solution);
        lcor_scene_free(scene);
    }
}

/* A wall with two sides: the lit side is bright, the other one sees only what comes around it. */
static void a_two_sided_wall_has_two_irradiances(void **state)
{
    static const double wall[9] = {0.5, 0, 0, 0, 1, 0, 0, 0, 1}; /* divides the room, faces +x */
    const double points[6] = {0.5, 0.5, 0.5, 0.5, 0.5, 0.5}, normals[6] = {1, 0, 0, -1, 0, 0};
    lcor_scene *scene = room_of(0.5, 0);
    lcor_solution *solution;
    lcor_surface surface;
    lcor_error err;
    double total[2];

    (void)state;
    memset(&surface, 0, sizeof surface);
    surface.reflectance[0] = surface.reflectance[1] = surface.reflectance[2] = 0.5;
    surface.two_sided = 1;
    must(lcor_scene_add_quad(scene, wall, wall + 3, wall + 6, &surface, NULL, &err), &err);
    add_lamp(scene, 0.8, 0.5, 0.5, 1);
    commit(scene);
    solution = solve(scene, 0.1, LCOR_NORM_RMS);
    must(lcor_solution_at(solution, 2, points, normals, total, NULL, &err), &err);
    assert_true(total[0] > 5);
    check_near(total[1], 0, 1e-6, "behind a wall that closes the room");
    lcor_solution_free(solution);
    lcor_scene_free(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(light_near_a_wall_keeps_its_power),
        cmocka_unit_test(light_on_a_surface_is_finite),
        cmocka_unit_test(light_in_a_corner_is_finite),
        cmocka_unit_test(light_outside_a_closed_room_stays_outside),
        cmocka_unit_test(no_light_is_dark),
        cmocka_unit_test(black_room_has_direct_light_only),
        cmocka_unit_test(nearly_white_room_keeps_its_power),
        cmocka_unit_test(intensities_may_differ_by_1e8),
        cmocka_unit_test(touching_and_crossing_quads_are_bounded),
        cmocka_unit_test(slivers_of_aspect_1e6_are_bounded),
        cmocka_unit_test(coplanar_duplicates_are_bounded),
        cmocka_unit_test(a_fan_of_triangles_is_a_floor),
        cmocka_unit_test(an_open_scene_lets_light_escape),
        cmocka_unit_test(a_lamp_close_under_a_ceiling_lights_it),
        cmocka_unit_test(a_two_sided_wall_has_two_irradiances),
    };

    return cmocka_run_group_tests_name("stability", tests, NULL, NULL);
}
