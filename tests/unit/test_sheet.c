/* SPDX-License-Identifier: MIT */
/* Which surfaces a commit merges. */
#include "failing.h"
#include "rooms.h"
#include "scene/scene_internal.h"

static lcor_scene *empty(const lcor_allocator *allocator)
{
    lcor_scene *scene = NULL;
    lcor_error err;

    must(lcor_scene_new(allocator, &scene, &err), &err);
    return scene;
}

/* The rectangle from (x0, y0) to (x1, y1) of the plane z = 0.3 x + 0.1 y, facing up. */
static void lift(double x, double y, double out[3])
{
    out[0] = x;
    out[1] = y;
    out[2] = 0.3 * x + 0.1 * y;
}

static void add_tile(lcor_scene *scene, double x0, double y0, double x1, double y1,
                     const lcor_surface *look)
{
    double corner[3], end[3], u[3], v[3];
    lcor_error err;

    lift(x0, y0, corner);
    lift(x1, y0, end);
    for (int k = 0; k < 3; k++)
        u[k] = end[k] - corner[k];
    lift(x0, y1, end);
    for (int k = 0; k < 3; k++)
        v[k] = end[k] - corner[k];
    must(lcor_scene_add_quad(scene, corner, u, v, look, NULL, &err), &err);
}

static void add_triangle(lcor_scene *scene, const double xy[6], const lcor_surface *look)
{
    double a[3], b[3], c[3];
    lcor_error err;

    lift(xy[0], xy[1], a);
    lift(xy[2], xy[3], b);
    lift(xy[4], xy[5], c);
    must(lcor_scene_add_triangle(scene, a, b, c, look, NULL, &err), &err);
}

static lcor_surface look_of(double rho)
{
    lcor_surface look;

    memset(&look, 0, sizeof look);
    for (int c = 0; c < 3; c++)
        look.reflectance[c] = rho;
    return look;
}

/* Commits, and expects so many sheets of so many surfaces, and so many shapes; frees the scene. */
static void expect(lcor_scene *scene, size_t sheets, size_t members, size_t shapes)
{
    double area = 0, in_shapes = 0;

    commit(scene);
    assert_int_equal(scene->sheets.count, sheets);
    assert_int_equal(scene->sheet_members.count, members);
    assert_int_equal(scene->shapes.count, shapes);
    for (size_t i = 0; i < scene->surfaces.count; i++)
        area += scene_surface_at(scene, i)->area;
    for (size_t i = 0; i < shapes; i++) {
        const scene_surface *s = scene_shape_at(scene, ((uint32_t *)scene->shapes.items)[i]);

        in_shapes += s->area;
        assert_true(s->normal[2] > 0); /* as all of them face */
    }
    check_near(in_shapes, area, 1e-9 * area, "area of the shapes");
    lcor_scene_free(scene);
}

static void tiles_of_a_wall_are_one_sheet(void **state)
{
    (void)state;
    for (int order = 0; order < 2; order++) { /* row by row, and strewn */
        lcor_scene *scene = empty(NULL);
        const lcor_surface look = look_of(0.5);

        for (int k = 0; k < 15; k++) {
            const int i = (order ? 7 * k % 15 : k) / 5, j = (order ? 7 * k % 15 : k) % 5;

            add_tile(scene, i / 3.0, j / 5.0, (i + 1) / 3.0, (j + 1) / 5.0, &look);
        }
        expect(scene, 1, 15, 1);
    }
}

/* Halves along either diagonal, a fan around the middle, bricks. */
static void whatever_makes_up_a_parallelogram_is_one_sheet(void **state)
{
    static const double halves[2][2][6] = {{{0, 0, 1, 0, 1, 1}, {0, 0, 1, 1, 0, 1}},
                                           {{0, 0, 1, 0, 0, 1}, {1, 0, 1, 1, 0, 1}}};
    static const double rim[5][2] = {{0, 0}, {2, 0.3}, {2, 1.3}, {0, 1}, {0, 0}};
    const lcor_surface look = look_of(0.5);
    lcor_scene *scene;

    (void)state;
    for (int k = 0; k < 2; k++) {
        scene = empty(NULL);
        add_triangle(scene, halves[k][0], &look);
        add_triangle(scene, halves[k][1], &look);
        expect(scene, 1, 2, 1);
    }
    scene = empty(NULL);
    for (int k = 0; k < 4; k++) {
        const double fan[6] = {0.9, 0.7, rim[k][0], rim[k][1], rim[k + 1][0], rim[k + 1][1]};

        add_triangle(scene, fan, &look);
    }
    expect(scene, 1, 4, 1);
    scene = empty(NULL);
    add_tile(scene, 0, 0, 0.4, 1, &look);
    add_tile(scene, 0.4, 0, 1, 1, &look);
    add_tile(scene, 0, 1, 0.7, 2, &look);
    add_tile(scene, 0.7, 1, 1, 2, &look);
    expect(scene, 1, 4, 1);
}

/* Eight tiles around a door: a row of three, two of two, and one alone. */
static void a_wall_around_a_door_is_merged_in_strips(void **state)
{
    const lcor_surface wall = look_of(0.5), door = look_of(0.2);
    lcor_scene *scene = empty(NULL);

    (void)state;
    for (int k = 0; k < 9; k++)
        add_tile(scene, k / 3, k % 3, k / 3 + 1, k % 3 + 1, k == 4 ? &door : &wall);
    expect(scene, 3, 7, 5);
}

static void what_looks_or_faces_otherwise_stays_apart(void **state)
{
    static const double tile[3][3] = {{1, 0, 0.3}, {0, 1, 0.1}, {1, 0, 0.3}};

    (void)state;
    for (int kind = 0; kind < 6; kind++) {
        lcor_surface one = look_of(0.5), other = one;
        lcor_scene *scene = empty(NULL);
        lcor_error err;

        other.reflectance[1] -= kind == 0 ? 0.1 : 0;
        other.emission[2] = kind == 1;
        other.two_sided = kind == 2;
        other.patches[0] = 7; /* does not matter */
        add_tile(scene, 0, 0, 1, 1, &one);
        if (kind == 3) /* facing down */
            must(lcor_scene_add_quad(scene, tile[0], tile[1], tile[2], &other, NULL, &err), &err);
        else if (kind == 4) /* apart */
            add_tile(scene, 1.001, 0, 2, 1, &other);
        else if (kind == 5) /* one behind the other */
            add_tile(scene, 1, 0.5, 2, 1.5, &other);
        else
            add_tile(scene, 1, 0, 2, 1, &other);
        commit(scene);
        assert_int_equal(scene->sheets.count, 0);
        assert_int_equal(scene->shapes.count, 2);
        lcor_scene_free(scene);
    }
}

/* A duplicate over a hole of its size would make the areas right. */
static void surfaces_on_each_other_are_not_merged(void **state)
{
    const lcor_surface look = look_of(0.5);
    lcor_scene *scene = empty(NULL);

    (void)state;
    add_tile(scene, 0, 0, 1, 1, &look);
    add_tile(scene, 2, 0, 3, 1, &look);
    add_tile(scene, 2, 0, 3, 1, &look);
    add_tile(scene, 0, 0, 1, 1, &look);
    expect(scene, 0, 0, 4);
    scene = empty(NULL);
    add_tile(scene, 0, 0, 1, 1, &look);
    add_tile(scene, 1, 0, 2, 1, &look);
    add_tile(scene, 1.5, 0.5, 1.7, 0.7, &look); /* lies on the second one */
    expect(scene, 0, 0, 3);
}

/* Five faces of a box in 16 tiles each are one solid of five. */
static void a_box_in_tiles_is_one_solid(void **state)
{
    lcor_scene *scene = empty(NULL), *whole = empty(NULL);
    lcor_error err;

    (void)state;
    add_box(whole, paper_box_low, paper_box_high, 0.5, 1);
    commit(whole);
    add_room(scene, 1, paper_rho, 0, 1);
    for (size_t f = 0; f < 5; f++)
        for (int k = 0; k < 16; k++) {
            const scene_surface *s = scene_surface_at(whole, f);
            const lcor_surface look = look_of(0.5);
            double corner[3], u[3], v[3];

            for (int c = 0; c < 3; c++) {
                u[c] = 0.25 * s->edge_u[c];
                v[c] = 0.25 * s->edge_v[c];
                corner[c] = s->origin[c] + k / 4 * u[c] + k % 4 * v[c];
            }
            must(lcor_scene_add_quad(scene, corner, u, v, &look, NULL, &err), &err);
        }
    commit(scene);
    assert_int_equal(scene->sheets.count, 5);
    assert_int_equal(scene->shapes.count, 11);
    assert_int_equal(scene->solids.count, 1);
    assert_int_equal(((scene_solid *)scene->solids.items)->member_count, 5);
    assert_int_equal(scene->blockers.count, 7);
    lcor_scene_free(scene);
    lcor_scene_free(whole);
}

static void a_commit_without_memory_may_be_tried_again(void **state)
{
    failing f = {0, 0};
    const lcor_allocator allocator = failing_allocator(&f);
    const lcor_surface look = look_of(0.5);
    lcor_status status = LCOR_ERR_NOMEM;
    lcor_scene *scene;
    lcor_error err;

    (void)state;
    f.left = 1000;
    scene = empty(&allocator);
    add_tile(scene, 0, 0, 1, 1, &look);
    add_tile(scene, 1, 0, 2, 1, &look);
    for (long k = 0; status != LCOR_OK; k++) {
        assert_true(k < 100);
        f.left = k;
        status = lcor_scene_commit(scene, NULL, &err);
        assert_true(status == LCOR_OK || status == LCOR_ERR_NOMEM);
    }
    assert_int_equal(scene->sheets.count, 1);
    lcor_scene_free(scene);
    assert_int_equal(f.live, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tiles_of_a_wall_are_one_sheet),
        cmocka_unit_test(whatever_makes_up_a_parallelogram_is_one_sheet),
        cmocka_unit_test(a_wall_around_a_door_is_merged_in_strips),
        cmocka_unit_test(what_looks_or_faces_otherwise_stays_apart),
        cmocka_unit_test(surfaces_on_each_other_are_not_merged),
        cmocka_unit_test(a_box_in_tiles_is_one_solid),
        cmocka_unit_test(a_commit_without_memory_may_be_tried_again),
    };

    return cmocka_run_group_tests_name("sheet", tests, NULL, NULL);
}
