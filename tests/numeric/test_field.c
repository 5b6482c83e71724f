/* SPDX-License-Identifier: MIT */
/* Irradiance of pixels from interpolation against the solution itself. */
#include "failing.h"
#include "testing.h"

#include <lcor/view.h>

enum { PLACES = 600 };

static const lcor_surface grey = {.reflectance = {0.5, 0.5, 0.5}, .two_sided = 1};

/* The unit cube from inside. */
static lcor_scene *make_walls(void)
{
    static const double origins[6][3] = {{0, 0, 0}, {0, 0, 1}, {0, 0, 0},
                                         {1, 0, 0}, {0, 0, 0}, {0, 1, 0}};
    static const int axes[6][2] = {{0, 1}, {1, 0}, {1, 2}, {2, 1}, {2, 0}, {0, 2}};
    lcor_scene *scene;

    assert_int_equal(lcor_scene_new(NULL, &scene, NULL), LCOR_OK);
    for (int i = 0; i < 6; i++) {
        double u[3] = {0}, v[3] = {0};

        u[axes[i][0]] = v[axes[i][1]] = 1;
        assert_int_equal(lcor_scene_add_quad(scene, origins[i], u, v, &grey, NULL, NULL), LCOR_OK);
    }
    return scene;
}

/* Those walls, a lamp, and with `furnished` a triangle and a pentagon standing between them. */
static lcor_scene *make_room(int furnished)
{
    static const double pentagon[15] = {0.3, 0.5, 0.1, 0.5, 0.5, 0.1, 0.6, 0.6,
                                        0.1, 0.4, 0.8, 0.1, 0.2, 0.6, 0.1};
    static const double a[3] = {0.6, 0.2, 0.2}, b[3] = {0.9, 0.3, 0.25}, c[3] = {0.7, 0.3, 0.6};
    const lcor_light lamp = {.position = {0.3, 0.4, 0.7}, .intensity = {1, 1, 1}};
    lcor_scene *scene = make_walls();

    if (furnished) {
        assert_int_equal(lcor_scene_add_triangle(scene, a, b, c, &grey, NULL, NULL), LCOR_OK);
        assert_int_equal(lcor_scene_add_polygon(scene, 5, pentagon, &grey, NULL, NULL), LCOR_OK);
    }
    assert_int_equal(lcor_scene_add_light(scene, &lamp, NULL, NULL), LCOR_OK);
    assert_int_equal(lcor_scene_commit(scene, NULL, NULL), LCOR_OK);
    return scene;
}

typedef struct setting {
    lcor_scene *scene;
    lcor_solution *solution;
    lcor_view *view;
    lcor_camera camera;
} setting;

static setting make_setting(int furnished, size_t width)
{
    const lcor_radiosity_options options = {.struct_size = sizeof options, .tolerance = 0.01};
    setting s = {.camera = {.position = {0.05, 0.08, 0.6},
                            .forward = {0.8, 0.7, -0.35},
                            .up = {0, 0, 1},
                            .fov_y = 1.3,
                            .size_x = width,
                            .size_y = width * 3 / 4}};

    s.scene = make_room(furnished);
    assert_int_equal(lcor_radiosity_solve(s.scene, &options, &s.solution, NULL), LCOR_OK);
    assert_int_equal(lcor_view_new(s.scene, &s.camera, NULL, &s.view, NULL), LCOR_OK);
    return s;
}

static void free_setting(setting *s)
{
    lcor_view_free(s->view);
    lcor_solution_free(s->solution);
    lcor_scene_free(s->scene);
}

static lcor_field *make_field(const setting *s, const lcor_field_options *options)
{
    lcor_field *field = NULL;

    assert_int_equal(lcor_field_new(s->solution, s->view, options, &field, NULL), LCOR_OK);
    return field;
}

/* The point that pixel (x, y)'s piece stands for, from the camera's ray and the depth alone. */
static void point_of(const setting *s, const lcor_span *span, size_t x, size_t y,
                     const lcor_place *place, double point[3])
{
    double ray[3], ahead = 0, length = 0;

    lcor_camera_ray(&s->camera, (double)x + (double)span->at[0], (double)y + (double)span->at[1],
                    point, ray);
    for (int k = 0; k < 3; k++) {
        ahead += ray[k] * s->camera.forward[k];
        length += s->camera.forward[k] * s->camera.forward[k];
    }
    for (int k = 0; k < 3; k++)
        point[k] += place->depth * sqrt(length) / ahead * ray[k];
}

typedef struct difference {
    double worst, rms, direct;
} difference;

static difference compare(const setting *s, const lcor_field *field)
{
    difference d = {0};
    uint64_t seed = 3;

    for (int i = 0; i < PLACES; i++) {
        const size_t x = (size_t)(random_unit(&seed) * (double)s->camera.size_x);
        const size_t y = (size_t)(random_unit(&seed) * (double)s->camera.size_y);
        size_t count;
        const lcor_span *span = lcor_view_row(s->view, y, &count);
        lcor_place place;
        double point[3], normal[3], total, direct, true_total, true_direct, off;

        while (!(span->x0 <= x && x < span->x1))
            span++;
        lcor_view_places(s->view, y, span, x, 1, &place);
        lcor_view_normal(s->view, span->surface, normal);
        point_of(s, span, x, y, &place, point);
        assert_int_equal(lcor_field_at(field, span->surface, 1, place.uv, &total, &direct, NULL),
                         LCOR_OK);
        assert_int_equal(
            lcor_solution_at(s->solution, 1, point, normal, &true_total, &true_direct, NULL),
            LCOR_OK);
        off = fabs(total - true_total) / true_total;
        d.worst = fmax(d.worst, off);
        d.rms += off * off / PLACES;
        if (fabs(direct - true_direct) > 1e-9 * true_total)
            d.direct += 1.0 / PLACES;
    }
    d.rms = sqrt(d.rms);
    return d;
}

static void interpolation_keeps_the_tolerance_in_a_room(void **state)
{
    const double tolerances[] = {1e-2, 1e-3};
    setting s = make_setting(0, 320);

    (void)state;
    for (int i = 0; i < 2; i++) {
        const lcor_field_options options = {.struct_size = sizeof options,
                                            .tolerance = tolerances[i]};
        lcor_field *field = make_field(&s, &options);
        lcor_field_report report;
        difference d;

        lcor_field_get_report(field, &report);
        d = compare(&s, field);
        check_near(d.direct, 0, 0, "share of pixels with another direct light");
        check_near(d.rms, 0, tolerances[i], "rms error");
        check_near(d.worst, 0, 8 * tolerances[i], "worst error");
        assert_true(report.samples > 25 && report.samples < 40000);
        assert_int_equal(report.channels, 1);
        lcor_field_free(field);
    }
    free_setting(&s);
}

static void triangles_and_polygons_are_interpolated_too(void **state)
{
    const lcor_field_options options = {.struct_size = sizeof options, .tolerance = 2e-3};
    setting s = make_setting(1, 240);
    lcor_field *field = make_field(&s, &options);
    const difference d = compare(&s, field);

    (void)state;
    /* at the outline of a shadow, one point may be lit and the other, 1e-16 away, not */
    check_near(d.direct, 0, 0.01, "share of pixels with another direct light");
    check_near(d.rms, 0, 0.01, "rms error");
    lcor_field_free(field);
    free_setting(&s);
}

/* A wall that is seen through from behind parts the room; the lamp is on its other side. */
static setting make_divided_setting(void)
{
    static const unsigned char cull[7] = {0, 0, 0, 0, 0, 0, 1};
    static const double origin[3] = {0.5, 0, 0}, u[3] = {0, 1, 0}, v[3] = {0, 0, 0.8};
    const lcor_surface facing = {.reflectance = {0.5, 0.5, 0.5}};
    const lcor_light lamp = {.position = {0.8, 0.5, 0.9}, .intensity = {1, 1, 1}};
    const lcor_radiosity_options options = {
        .struct_size = sizeof options, .tolerance = 0.02, .engine = LCOR_ENGINE_LINKS};
    const lcor_view_options through = {.struct_size = sizeof through, .cull_back = cull};
    setting s = {.camera = {.position = {0.02, 0.5, 0.5},
                            .forward = {1, 0.05, -0.1},
                            .up = {0, 0, 1},
                            .fov_y = 1.4,
                            .size_x = 200,
                            .size_y = 150},
                 .scene = make_walls()};

    assert_int_equal(lcor_scene_add_quad(s.scene, origin, u, v, &facing, NULL, NULL), LCOR_OK);
    assert_int_equal(lcor_scene_add_light(s.scene, &lamp, NULL, NULL), LCOR_OK);
    assert_int_equal(lcor_scene_commit(s.scene, NULL, NULL), LCOR_OK);
    assert_int_equal(lcor_radiosity_solve(s.scene, &options, &s.solution, NULL), LCOR_OK);
    assert_int_equal(lcor_view_new(s.scene, &s.camera, &through, &s.view, NULL), LCOR_OK);
    return s;
}

/* Floor and walls are bright on one side of it and dark on the other: neither where cells are
 * split nor where few pixels show them does one side's light reach the other. */
static void light_jumps_where_a_wall_stands(void **state)
{
    const lcor_field_options options = {.struct_size = sizeof options, .tolerance = 2e-3};
    setting s = make_divided_setting();
    lcor_field *field = make_field(&s, &options);
    const difference d = compare(&s, field);

    (void)state;
    print_message("divided room: worst %.1e, rms %.1e\n", d.worst, d.rms);
    assert_true(d.worst <= 0.05);
    assert_true(d.rms <= 5e-3);
    lcor_field_free(field);
    free_setting(&s);
}

static void backwards(void *user, size_t n, void (*task)(void *arg, size_t i), void *arg)
{
    (void)user;
    while (n-- > 0)
        task(arg, n);
}

static void bits_do_not_depend_on_the_order_of_work(void **state)
{
    const lcor_field_options plain = {.struct_size = sizeof plain};
    const lcor_field_options turned = {.struct_size = sizeof turned, .parallel = {backwards, NULL}};
    setting s = make_setting(0, 160);
    lcor_field *a = make_field(&s, &plain), *b = make_field(&s, &turned);

    (void)state;
    for (int i = 0; i < 100; i++) {
        const double uv[2] = {0.1 + i / 125.0, 0.9 - i / 125.0};
        double of_a, of_b;

        assert_int_equal(lcor_field_at(a, 0, 1, uv, &of_a, NULL, NULL), LCOR_OK);
        assert_int_equal(lcor_field_at(b, 0, 1, uv, &of_b, NULL, NULL), LCOR_OK);
        assert_memory_equal(&of_a, &of_b, sizeof of_a);
    }
    lcor_field_free(a);
    lcor_field_free(b);
    free_setting(&s);
}

static int stop(void *user, double done)
{
    (void)user;
    return done >= 0;
}

static void cancelling_and_wrong_arguments_are_reported(void **state)
{
    const lcor_field_options cancelled = {.struct_size = sizeof cancelled,
                                          .progress = {stop, NULL}};
    const lcor_field_options wrong = {.struct_size = sizeof wrong, .tolerance = -1};
    const lcor_field_options fine = {.struct_size = sizeof fine};
    const double uv[2] = {0.5, 0.5};
    setting s = make_setting(0, 40);
    lcor_field *field = NULL;
    double total;

    (void)state;
    assert_int_equal(lcor_field_new(s.solution, s.view, &cancelled, &field, NULL),
                     LCOR_ERR_CANCELLED);
    assert_int_equal(lcor_field_new(s.solution, s.view, &wrong, &field, NULL), LCOR_ERR_DOMAIN);
    assert_int_equal(lcor_field_new(NULL, s.view, &fine, &field, NULL), LCOR_ERR_ARG);
    assert_null(field);
    field = make_field(&s, &fine);
    assert_int_equal(lcor_field_at(field, 99, 1, uv, &total, NULL, NULL), LCOR_ERR_ARG);
    lcor_field_free(field);
    free_setting(&s);
}

static void every_failed_allocation_is_an_error_without_a_leak(void **state)
{
    setting s = make_setting(1, 24);
    int k, failures = 0;

    (void)state;
    for (k = 0; k < 200; k++) {
        failing memory = {k, 0};
        const lcor_allocator allocator = failing_allocator(&memory);
        const lcor_view_options view_options = {.struct_size = sizeof view_options,
                                                .allocator = allocator};
        const lcor_field_options options = {.struct_size = sizeof options, .allocator = allocator};
        lcor_view *view = NULL;
        lcor_field *field = NULL;
        lcor_status status = lcor_view_new(s.scene, &s.camera, &view_options, &view, NULL);

        if (status == LCOR_OK)
            status = lcor_field_new(s.solution, view, &options, &field, NULL);
        failures += status == LCOR_ERR_NOMEM;
        lcor_field_free(field);
        lcor_view_free(view);
        assert_int_equal(memory.live, 0);
        if (status == LCOR_OK)
            break;
        assert_int_equal(status, LCOR_ERR_NOMEM);
    }
    assert_true(k < 200 && failures == k && k > 10);
    free_setting(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(interpolation_keeps_the_tolerance_in_a_room),
        cmocka_unit_test(triangles_and_polygons_are_interpolated_too),
        cmocka_unit_test(light_jumps_where_a_wall_stands),
        cmocka_unit_test(bits_do_not_depend_on_the_order_of_work),
        cmocka_unit_test(cancelling_and_wrong_arguments_are_reported),
        cmocka_unit_test(every_failed_allocation_is_an_error_without_a_leak),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
