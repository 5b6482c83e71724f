/* SPDX-License-Identifier: MIT */
/* Irradiance of pixels where the solution's answers have noise: against answers that took long, at
 * walls without thickness, in corners and at the feet of what stands on a floor. */
#include "crew.h"
#include "failing.h"
#include "rooms.h"

#include <lcor/view.h>

enum { WIDTH = 120, HEIGHT = 90 };

/* The paper's room with a box on its floor, and a wall without thickness through its middle that
 * reaches up to `top`. */
static lcor_scene *divided_room(double top)
{
    const lcor_surface both = {.reflectance = {0.5, 0.5, 0.5}, .two_sided = 1};
    const double foot[3] = {0.5, 0, 0}, along[3] = {0, 1, 0}, up[3] = {0, 0, top};
    lcor_scene *scene = NULL;
    lcor_error err;

    must(lcor_scene_new(NULL, &scene, &err), &err);
    add_room(scene, 1, paper_rho, 0, 1);
    add_lamp(scene, 0.3, 0.4, 0.7, 1);
    add_box(scene, (double[3]){0.15, 0.55, 0}, (double[3]){0.35, 0.75, 0.25}, 0.5, 1);
    must(lcor_scene_add_quad(scene, foot, along, up, &both, NULL, &err), &err);
    commit(scene);
    return scene;
}

/* Towards the lit half from under its ceiling, or from the dark one. */
static lcor_camera camera_in(int lit)
{
    lcor_camera camera = {.position = {lit ? 0.05 : 0.95, 0.05, 0.9},
                          .forward = {lit ? 0.4 : -0.4, 0.7, -0.75},
                          .up = {0, 0, 1},
                          .fov_y = 1.4,
                          .size_x = WIDTH,
                          .size_y = HEIGHT};

    return camera;
}

static lcor_solution *gather(const lcor_scene *scene, double tolerance)
{
    const lcor_radiosity_options options = {
        .struct_size = sizeof options, .tolerance = tolerance, .engine = LCOR_ENGINE_GATHER};
    lcor_solution *solution = NULL;
    lcor_error err;

    must(lcor_radiosity_solve(scene, &options, &solution, &err), &err);
    return solution;
}

static lcor_view *look(const lcor_scene *scene, int lit)
{
    const lcor_camera camera = camera_in(lit);
    lcor_view *view = NULL;
    lcor_error err;

    must(lcor_view_new(scene, &camera, NULL, &view, &err), &err);
    return view;
}

static lcor_field *light(const lcor_solution *solution, const lcor_view *view,
                         const lcor_parallel *parallel, uint64_t samples)
{
    lcor_field_options options = {.struct_size = sizeof options, .max_samples = samples};
    lcor_field *field = NULL;
    lcor_error err;

    if (parallel)
        options.parallel = *parallel;
    must(lcor_field_new(solution, view, &options, &field, &err), &err);
    return field;
}

/* Total irradiance of each pixel's first piece and the surface seen there. */
static void picture(const lcor_view *view, const lcor_field *field, double *total, size_t *surface)
{
    for (size_t y = 0; y < HEIGHT; y++) {
        size_t count;
        const lcor_span *spans = lcor_view_row(view, y, &count);

        for (size_t i = count; i-- > 0;)
            for (size_t x = spans[i].x0; x < spans[i].x1; x++) {
                lcor_place place;

                lcor_view_places(view, y, &spans[i], x, 1, &place);
                surface[y * WIDTH + x] = spans[i].surface;
                assert_int_equal(lcor_field_at(field, spans[i].surface, 1, place.uv,
                                               &total[y * WIDTH + x], NULL, NULL),
                                 LCOR_OK);
            }
    }
}

/* The room is closed: every pixel shows something. */
static void behind_a_wall_without_thickness_it_is_exactly_dark(void **state)
{
    static double total[WIDTH * HEIGHT];
    static size_t surface[WIDTH * HEIGHT];
    lcor_scene *scene = divided_room(1);
    lcor_solution *solution = gather(scene, 0.02);

    (void)state;
    for (int lit = 0; lit < 2; lit++) {
        lcor_view *view = look(scene, lit);
        lcor_field *field = light(solution, view, NULL, 0);

        picture(view, field, total, surface);
        for (int i = 0; i < WIDTH * HEIGHT; i++)
            assert_true(lit ? total[i] > 0 : total[i] == 0);
        lcor_field_free(field);
        lcor_view_free(view);
    }
    lcor_solution_free(solution);
    lcor_scene_free(scene);
}

/* From above, through the ceiling's back, the floor is seen on both sides of the wall at once. */
static void estimates_are_not_used_across_a_wall(void **state)
{
    unsigned char cull[ROOM_FACES + 6];
    const lcor_view_options options = {.struct_size = sizeof options, .cull_back = cull};
    const lcor_camera camera = {.position = {0.5, 0.5, 2},
                                .forward = {0, 0, -1},
                                .up = {0, 1, 0},
                                .height = 1,
                                .size_x = WIDTH,
                                .size_y = WIDTH};
    lcor_scene *scene = divided_room(1);
    lcor_solution *solution = gather(scene, 0.03);
    lcor_view *view = NULL;
    lcor_field *field;
    int lit = 0, dark = 0;
    lcor_error err;

    (void)state;
    memset(cull, 1, sizeof cull);
    must(lcor_view_new(scene, &camera, &options, &view, &err), &err);
    field = light(solution, view, NULL, 0);
    for (size_t y = 0; y < WIDTH; y++) {
        size_t count;
        const lcor_span *spans = lcor_view_row(view, y, &count);

        for (size_t i = 0; i < count; i++)
            for (size_t x = spans[i].x0; x < spans[i].x1 && spans[i].surface == 0; x++) {
                lcor_place place;
                double total;

                lcor_view_places(view, y, &spans[i], x, 1, &place);
                assert_int_equal(lcor_field_at(field, 0, 1, place.uv, &total, NULL, NULL), LCOR_OK);
                assert_true(place.uv[0] < 0.5 ? total > 0 : total == 0);
                lit += place.uv[0] < 0.5;
                dark += place.uv[0] > 0.5;
            }
    }
    assert_true(lit > WIDTH * WIDTH / 3 && dark > WIDTH * WIDTH / 3);
    lcor_field_free(field);
    lcor_view_free(view);
    lcor_solution_free(solution);
    lcor_scene_free(scene);
}

typedef struct comparison {
    double rms, worst;
    int compared;
} comparison;

/* Each 41st pixel against the solution's own answer to a quarter of the tolerance. */
static comparison compare(const lcor_scene *scene, const lcor_solution *reference, int lit,
                          const double *total)
{
    const lcor_camera camera = camera_in(lit);
    lcor_view *view = look(scene, lit);
    comparison result = {0, 0, 0};
    double mean = 0;

    for (int i = 0; i < WIDTH * HEIGHT; i++)
        mean += total[i] / (WIDTH * HEIGHT);
    for (size_t i = 0; i < WIDTH * HEIGHT; i += 41) {
        size_t count;
        const size_t x = i % WIDTH, y = i / WIDTH;
        const lcor_span *span = lcor_view_row(view, y, &count);
        double point[3], ray[3], normal[3], truth, off;
        lcor_hit hit;

        while (!(span->x0 <= x && x < span->x1))
            span++;
        if (span->coverage < 1)
            continue;
        lcor_camera_ray(&camera, (double)x + 0.5, (double)y + 0.5, point, ray);
        assert_true(lcor_scene_intersect(scene, point, ray, HUGE_VAL, &hit));
        assert_int_equal(hit.surface, span->surface);
        for (int k = 0; k < 3; k++)
            point[k] += hit.t * ray[k];
        (void)lcor_view_normal(view, span->surface, normal);
        assert_int_equal(lcor_solution_at(reference, 1, point, normal, &truth, NULL, NULL),
                         LCOR_OK);
        off = fabs(total[i] - truth) / fmax(truth, 0.02 * mean);
        result.worst = fmax(result.worst, off);
        result.rms += off * off;
        result.compared++;
    }
    result.rms = sqrt(result.rms / result.compared);
    lcor_view_free(view);
    return result;
}

/* Light comes over a wall; corners and the box's foot are in the picture. Of the tolerance the
 * deviation is about one on average, and six nowhere. */
static void pixels_agree_with_answers_that_took_long(void **state)
{
    static double total[WIDTH * HEIGHT];
    static size_t surface[WIDTH * HEIGHT];
    const double tolerance = 0.03;
    lcor_scene *scene = divided_room(0.8);
    lcor_solution *solution = gather(scene, tolerance), *reference = gather(scene, tolerance / 4);

    (void)state;
    for (int lit = 0; lit < 2; lit++) {
        lcor_view *view = look(scene, lit);
        lcor_field *field = light(solution, view, NULL, 0);
        lcor_field_report report;
        comparison c;

        lcor_field_get_report(field, &report);
        picture(view, field, total, surface);
        c = compare(scene, reference, lit, total);
        print_message("%s half: rms %.4f, worst %.4f of %d pixels; %lu estimates, error %.4f\n",
                      lit ? "lit" : "dark", c.rms, c.worst, c.compared,
                      (unsigned long)report.samples, report.error);
        assert_true(c.compared > 200);
        assert_true(c.rms <= 1.3 * tolerance);
        assert_true(c.worst <= 6 * tolerance);
        assert_true(report.error >= 0.5 * c.rms && report.error <= 3 * c.rms);
        assert_true(report.samples < WIDTH * HEIGHT / 12); /* few along the room's edges */
        lcor_field_free(field);
        lcor_view_free(view);
    }
    lcor_solution_free(solution);
    lcor_solution_free(reference);
    lcor_scene_free(scene);
}

/* A room with a box, lit by both sides of a square that hangs at `height`. */
static lcor_scene *room_under_a_square(double rho, double height)
{
    const double rhos[ROOM_FACES] = {rho, rho, rho, rho, rho, rho};
    const lcor_surface lamp = {.emission = {10, 10, 10}, .two_sided = 1};
    const double corner[3] = {0.4, 0.4, height}, u[3] = {0, 0.2, 0}, v[3] = {0.2, 0, 0};
    lcor_scene *scene = NULL;
    lcor_error err;

    must(lcor_scene_new(NULL, &scene, &err), &err);
    add_room(scene, 1, rhos, 0, 1);
    add_box(scene, (double[3]){0.15, 0.55, 0}, (double[3]){0.35, 0.75, 0.25}, rho, 1);
    must(lcor_scene_add_quad(scene, corner, u, v, &lamp, NULL, &err), &err);
    commit(scene);
    return scene;
}

/* Irradiance by that square alone: a sum over its points, each seen or not. */
static double square_at(const lcor_scene *scene, double height, const double x[3],
                        const double normal[3])
{
    enum { GRID = 100 };
    double sum = 0;

    for (int i = 0; i < GRID * GRID; i++) {
        const double to[3] = {0.4 + 0.2 * (i / GRID + 0.5) / GRID - x[0],
                              0.4 + 0.2 * (i % GRID + 0.5) / GRID - x[1], height - x[2]};
        const double square = to[0] * to[0] + to[1] * to[1] + to[2] * to[2];
        const double cosines =
            fabs(to[2]) * (to[0] * normal[0] + to[1] * normal[1] + to[2] * normal[2]);
        const double from[3] = {x[0] + 1e-7 * normal[0], x[1] + 1e-7 * normal[1],
                                x[2] + 1e-7 * normal[2]};
        lcor_hit hit;

        if (cosines > 0 && !lcor_scene_intersect(scene, from, to, 1 - 1e-5, &hit))
            sum += 10 * cosines / (3.14159265358979 * square * square) * 0.04 / (GRID * GRID);
    }
    return sum;
}

/* Nothing reflects: what pixels get is the square's light, half-shadows included. */
static void half_shadows_of_emitting_surfaces_have_no_noise(void **state)
{
    static double total[WIDTH * HEIGHT];
    static size_t surface[WIDTH * HEIGHT];
    const double height = 0.7;
    const lcor_camera camera = camera_in(1);
    lcor_scene *scene = room_under_a_square(0, height);
    lcor_solution *solution = gather(scene, 0.05);
    lcor_view *view = look(scene, 1);
    lcor_field *field = light(solution, view, NULL, 0);
    double worst = 0, most = 0;

    (void)state;
    picture(view, field, total, surface);
    for (int i = 0; i < WIDTH * HEIGHT; i++)
        most = fmax(most, total[i]);
    for (size_t i = 0; i < WIDTH * HEIGHT; i += 41) {
        const size_t x = i % WIDTH, y = i / WIDTH;
        double point[3], ray[3], normal[3];
        size_t count;
        lcor_hit hit;
        const lcor_span *span = lcor_view_row(view, y, &count);

        while (!(span->x0 <= x && x < span->x1))
            span++;
        lcor_camera_ray(&camera, (double)x + 0.5, (double)y + 0.5, point, ray);
        assert_true(lcor_scene_intersect(scene, point, ray, HUGE_VAL, &hit));
        if (span->coverage < 1 || hit.surface != span->surface)
            continue;
        for (int k = 0; k < 3; k++)
            point[k] += hit.t * ray[k];
        (void)lcor_view_normal(view, span->surface, normal);
        worst = fmax(worst, fabs(total[i] - square_at(scene, height, point, normal)) / most);
    }
    print_message("half-shadows: worst %.1e of the brightest pixel\n", worst);
    assert_true(worst < 2e-3); /* the sum's own error at a shadow's edge is 1 / GRID of a part */
    lcor_field_free(field);
    lcor_view_free(view);
    lcor_solution_free(solution);
    lcor_scene_free(scene);
}

/* A lamp a hair below the ceiling: much of the light on the ceiling's neighbours comes from the
 * bright slit around it. */
static void a_lamp_close_to_a_ceiling_leaves_no_dots(void **state)
{
    static double total[WIDTH * HEIGHT];
    static size_t surface[WIDTH * HEIGHT];
    const double tolerance = 0.03;
    lcor_scene *scene = room_under_a_square(0.5, 0.995);
    lcor_solution *solution = gather(scene, tolerance), *reference = gather(scene, tolerance / 4);
    lcor_view *view = look(scene, 1);
    lcor_field *field = light(solution, view, NULL, 0);
    comparison c;

    (void)state;
    picture(view, field, total, surface);
    c = compare(scene, reference, 1, total);
    print_message("lamp at a ceiling: rms %.4f, worst %.4f of %d pixels\n", c.rms, c.worst,
                  c.compared);
    assert_true(c.rms <= 0.5 * tolerance);
    assert_true(c.worst <= 2 * tolerance);
    lcor_field_free(field);
    lcor_view_free(view);
    lcor_solution_free(solution);
    lcor_solution_free(reference);
    lcor_scene_free(scene);
}

/* A pixel of a wall without shadows differs less from its neighbours than the tolerance: noise is
 * not that of single pixels. */
static void smooth_surfaces_have_no_speckle(void **state)
{
    static double total[WIDTH * HEIGHT];
    static size_t surface[WIDTH * HEIGHT];
    const double tolerance = 0.03;
    lcor_scene *scene = divided_room(1);
    lcor_solution *solution = gather(scene, tolerance);
    lcor_view *view = look(scene, 1);
    lcor_field *field = light(solution, view, NULL, 0);
    double worst = 0;
    int compared = 0;

    (void)state;
    picture(view, field, total, surface);
    for (int y = 1; y < HEIGHT - 1; y++)
        for (int x = 1; x < WIDTH - 1; x++) {
            const int i = y * WIDTH + x, around[4] = {i - 1, i + 1, i - WIDTH, i + WIDTH};
            double mean = 0;
            int same = 1;

            for (int k = 0; k < 4; k++) {
                same &= surface[around[k]] == 5 && surface[i] == 5;
                mean += total[around[k]] / 4;
            }
            if (!same)
                continue;
            compared++;
            worst = fmax(worst, fabs(total[i] - mean) / mean);
        }
    print_message("worst of %d pixels against their neighbours: %.4f\n", compared, worst);
    assert_true(compared > 500);
    assert_true(worst < tolerance);
    lcor_field_free(field);
    lcor_view_free(view);
    lcor_solution_free(solution);
    lcor_scene_free(scene);
}

static void threads_and_limits_leave_the_same_bits(void **state)
{
    static double total[3][WIDTH * HEIGHT];
    static size_t surface[WIDTH * HEIGHT];
    lcor_scene *scene = divided_room(0.8);
    lcor_solution *solution = gather(scene, 0.05);
    lcor_view *view = look(scene, 1);

    (void)state;
    for (int limited = 0; limited < 2; limited++) {
        for (int i = 0; i < 3; i++) {
            crew threads = {.threads = i == 0 ? 1 : i == 1 ? 2 : 5};
            const lcor_parallel parallel = {crew_run, &threads};
            lcor_field *field = light(solution, view, &parallel, limited ? 300 : 0);
            lcor_field_report report;

            lcor_field_get_report(field, &report);
            assert_true(!limited || report.samples <= 300);
            picture(view, field, total[i], surface);
            lcor_field_free(field);
        }
        assert_memory_equal(total[0], total[1], sizeof total[0]);
        assert_memory_equal(total[0], total[2], sizeof total[0]);
        for (int i = 0; i < WIDTH * HEIGHT; i++)
            assert_true(total[0][i] > 0);
    }
    lcor_view_free(view);
    lcor_solution_free(solution);
    lcor_scene_free(scene);
}

static int stop(void *user, double done)
{
    (void)user;
    return done >= 0;
}

static void failed_allocations_and_cancelling_are_errors(void **state)
{
    lcor_scene *scene = divided_room(0.8);
    lcor_solution *solution = gather(scene, 0.2);
    lcor_view *view = look(scene, 1);
    const lcor_field_options cancelled = {.struct_size = sizeof cancelled,
                                          .progress = {stop, NULL}};
    lcor_field *field = NULL;
    int k = 0;

    (void)state;
    assert_int_equal(lcor_field_new(solution, view, &cancelled, &field, NULL), LCOR_ERR_CANCELLED);
    for (lcor_status status = LCOR_ERR_NOMEM; status != LCOR_OK; k++) {
        failing memory = {k, 0};
        const lcor_field_options options = {.struct_size = sizeof options,
                                            .max_samples = 150,
                                            .allocator = failing_allocator(&memory)};

        assert_true(k < 100);
        status = lcor_field_new(solution, view, &options, &field, NULL);
        assert_true((status == LCOR_OK) == (field != NULL));
        assert_true(status == LCOR_OK || status == LCOR_ERR_NOMEM);
        lcor_field_free(field);
        assert_int_equal(memory.live, 0);
        field = NULL;
    }
    assert_true(k > 6);
    lcor_view_free(view);
    lcor_solution_free(solution);
    lcor_scene_free(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(behind_a_wall_without_thickness_it_is_exactly_dark),
        cmocka_unit_test(estimates_are_not_used_across_a_wall),
        cmocka_unit_test(pixels_agree_with_answers_that_took_long),
        cmocka_unit_test(half_shadows_of_emitting_surfaces_have_no_noise),
        cmocka_unit_test(a_lamp_close_to_a_ceiling_leaves_no_dots),
        cmocka_unit_test(smooth_surfaces_have_no_speckle),
        cmocka_unit_test(threads_and_limits_leave_the_same_bits),
        cmocka_unit_test(failed_allocations_and_cancelling_are_errors),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
