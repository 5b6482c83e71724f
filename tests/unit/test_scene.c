/* SPDX-License-Identifier: MIT */
/* Building, committing and asking scenes. */
#include "rooms.h"
#include "scene/scene_internal.h"

static lcor_scene *empty(void)
{
    lcor_scene *scene = NULL;
    lcor_error err;

    must(lcor_scene_new(NULL, &scene, &err), &err);
    return scene;
}

static const double pi = 3.14159265358979323846;
static const double o[3] = {0, 0, 0}, x[3] = {1, 0, 0}, y[3] = {0, 1, 0}, z[3] = {0, 0, 1};

static void refused(lcor_scene *scene, const char *part, long where)
{
    lcor_error err;

    assert_int_equal(lcor_scene_commit(scene, NULL, &err), LCOR_ERR_DOMAIN);
    if (!strstr(err.text, part))
        fail_msg("\"%s\" does not say \"%s\"", err.text, part);
    assert_int_equal(err.where, where);
    lcor_scene_free(scene);
}

static void commit_names_the_first_bad_item(void **state)
{
    const double nan_corner[3] = {(double)NAN, 0, 0}, twice[3] = {2, 0, 0};
    const double bent[12] = {0, 0, 0, 1, 0, 0, 1, 1, 0.1, 0, 1, 0};
    const double dent[15] = {0, 0, 0, 1, 0, 0, 0.3, 0.3, 0, 1, 1, 0, 0, 1, 0};
    const double line[12] = {0, 0, 0, 0.5, 0, 0, 1, 0, 0, 0, 1, 0};
    lcor_surface look;
    lcor_light light;
    lcor_scene *scene;

    (void)state;
    memset(&look, 0, sizeof look);
    memset(&light, 0, sizeof light);
    refused(empty(), "no surface", -1);

    scene = empty();
    (void)lcor_scene_add_quad(scene, o, x, y, NULL, NULL, NULL);
    (void)lcor_scene_add_quad(scene, nan_corner, x, y, NULL, NULL, NULL);
    refused(scene, "surface 1: a corner is not finite", 1);

    scene = empty();
    (void)lcor_scene_add_quad(scene, o, x, twice, NULL, NULL, NULL);
    refused(scene, "surface 0: has no area", 0);

    scene = empty();
    (void)lcor_scene_add_polygon(scene, 4, bent, NULL, NULL, NULL);
    refused(scene, "not in the plane", 0);

    scene = empty();
    (void)lcor_scene_add_polygon(scene, 5, dent, NULL, NULL, NULL);
    refused(scene, "not convex", 0);

    scene = empty();
    (void)lcor_scene_add_polygon(scene, 4, line, NULL, NULL, NULL);
    refused(scene, "lie on a line", 0);

    scene = empty();
    look.reflectance[1] = 1;
    (void)lcor_scene_add_quad(scene, o, x, y, &look, NULL, NULL);
    refused(scene, "0 <= rho < 1", 0);

    scene = empty();
    (void)lcor_scene_add_quad(scene, o, x, y, NULL, NULL, NULL);
    light.intensity[2] = -1;
    (void)lcor_scene_add_light(scene, &light, NULL, NULL);
    refused(scene, "light 0: intensity", 0);

    scene = empty();
    (void)lcor_scene_add_quad(scene, o, x, y, NULL, NULL, NULL);
    light.intensity[2] = 0;
    light.kind = LCOR_LIGHT_SPOT;
    light.direction[0] = 1;
    light.outer_cone = 2;
    (void)lcor_scene_add_light(scene, &light, NULL, NULL);
    refused(scene, "cones", 0);
}

static void a_committed_scene_keeps_its_shapes(void **state)
{
    lcor_scene *scene = empty();
    lcor_surface look;
    lcor_error err;

    (void)state;
    memset(&look, 0, sizeof look);
    must(lcor_scene_add_quad(scene, o, x, y, NULL, NULL, &err), &err);
    commit(scene);
    assert_int_equal(lcor_scene_commit(scene, NULL, &err), LCOR_ERR_ARG);
    assert_int_equal(lcor_scene_add_quad(scene, o, x, y, NULL, NULL, &err), LCOR_ERR_ARG);
    look.reflectance[0] = 1.5;
    assert_int_equal(lcor_scene_set_surface(scene, 0, &look, &err), LCOR_ERR_DOMAIN);
    assert_int_equal(lcor_scene_set_surface(scene, 7, NULL, &err), LCOR_ERR_ARG);
    look.reflectance[0] = 0.5;
    must(lcor_scene_set_surface(scene, 0, &look, &err), &err);
    lcor_scene_free(scene);
}

static void patches_cover_their_surface(void **state)
{
    const double hexagon[18] = {2, 0, 0, 1, 1.7, 0, -1, 1.7, 0, -2, 0, 0, -1, -1.7, 0, 1, -1.7, 0};
    const double areas_known[3] = {1, 0.5, 10.2};
    const size_t counts_known[3] = {15, 25, 100};
    lcor_scene *scene = empty();
    lcor_surface look;
    lcor_error err;

    (void)state;
    memset(&look, 0, sizeof look);
    look.patches[0] = 5;
    look.patches[1] = 3;
    must(lcor_scene_add_quad(scene, o, x, y, &look, NULL, &err), &err);
    must(lcor_scene_add_triangle(scene, o, y, z, &look, NULL, &err), &err);
    must(lcor_scene_add_polygon(scene, 6, hexagon, &look, NULL, &err), &err);
    commit(scene);
    for (size_t s = 0; s < 3; s++) {
        double centres[300], areas[100], normal[3], sum = 0, moment[3] = {0, 0, 0};
        size_t count;

        must(lcor_scene_patch_count(scene, s, &count, &err), &err);
        assert_int_equal(count, counts_known[s]);
        must(lcor_scene_patch_geometry(scene, s, centres, areas, normal, &err), &err);
        for (size_t k = 0; k < count; k++) {
            sum += areas[k];
            for (size_t c = 0; c < 3; c++)
                moment[c] += areas[k] * centres[3 * k + c];
        }
        check_near(sum, areas_known[s], 1e-12, "area");
        check_near(moment[0] / sum, s == 0 ? 0.5 : 0, 1e-12, "centroid x");
        check_near(moment[1] / sum, s == 0 ? 0.5 : s == 1 ? 1.0 / 3 : 0, 1e-12, "centroid y");
        check_near(normal[s == 1 ? 0 : 2], 1, 1e-12, "normal");
    }
    lcor_scene_free(scene);
}

/* Row i of a triangle holds 2 (n - i) - 1 patches, upright and inverted in turn. */
static void triangle_patches_have_the_documented_order(void **state)
{
    const double known[9][2] = {{1, 1}, {2, 2}, {1, 4}, {2, 5}, {1, 7},
                                {4, 1}, {5, 2}, {4, 4}, {7, 1}};
    lcor_scene *scene = empty();
    lcor_surface look;
    lcor_error err;
    double centres[27];

    (void)state;
    memset(&look, 0, sizeof look);
    look.patches[0] = 3;
    must(lcor_scene_add_triangle(scene, o, x, y, &look, NULL, &err), &err);
    commit(scene);
    must(lcor_scene_patch_geometry(scene, 0, centres, NULL, NULL, &err), &err);
    for (int k = 0; k < 9; k++) {
        check_near(centres[3 * k], known[k][0] / 9, 1e-12, "u");
        check_near(centres[3 * k + 1], known[k][1] / 9, 1e-12, "v");
    }
    lcor_scene_free(scene);
}

static void rays_report_surface_place_and_side(void **state)
{
    const double from[3] = {0.25, 0.75, 2}, down[3] = {0, 0, -2}, below[3] = {0.25, 0.75, -1};
    const double up[3] = {0, 0, 1}, square[12] = {0, 0, 1, 2, 0, 1, 2, 2, 1, 0, 2, 1};
    lcor_scene *scene = empty();
    lcor_error err;
    lcor_hit hit;

    (void)state;
    must(lcor_scene_add_quad(scene, o, x, y, NULL, NULL, &err), &err);
    must(lcor_scene_add_polygon(scene, 4, square, NULL, NULL, &err), &err);
    assert_int_equal(lcor_scene_intersect(scene, from, down, HUGE_VAL, &hit), 0);
    commit(scene);
    assert_int_equal(lcor_scene_intersect(scene, from, down, HUGE_VAL, &hit), 1);
    assert_int_equal(hit.surface, 1);
    assert_int_equal(hit.front, 1);
    check_near(hit.t, 0.5, 1e-15, "t");
    check_near(hit.u, 0.125 - 0.375, 1e-12, "u along b - a"); /* c is the opposite corner */
    check_near(hit.v, 0.375, 1e-12, "v along c - a");
    assert_int_equal(lcor_scene_intersect(scene, below, up, HUGE_VAL, &hit), 1);
    assert_int_equal(hit.surface, 0);
    assert_int_equal(hit.front, 0);
    check_near(hit.u, 0.25, 1e-12, "u");
    check_near(hit.v, 0.75, 1e-12, "v");
    assert_int_equal(lcor_scene_intersect(scene, below, up, 0.9, &hit), 0);
    lcor_scene_free(scene);
}

/* A box on the floor is one solid though its bottom is missing; not if more is missing, or if
 * something is inside it. */
static void boxes_stand_in_the_light_as_one(void **state)
{
    static const double inner[3] = {0.5, 0.3, 0.1}, middle[3] = {0.6, 0.35, 0.2};
    static const double step[2][3] = {{0.1, 0, 0}, {0, 0.1, 0}};

    (void)state;
    for (int kind = 0; kind < 3; kind++) {
        lcor_scene *scene = paper_room(1);
        lcor_error err;

        if (kind < 2)
            add_box(scene, paper_box_low, paper_box_high, 0.5, 1);
        if (kind == 1)
            must(lcor_scene_add_quad(scene, inner, step[0], step[1], NULL, NULL, &err), &err);
        if (kind == 2) { /* a floor of its own and two of its sides */
            must(lcor_scene_add_quad(scene, inner, step[1], step[0], NULL, NULL, &err), &err);
            must(lcor_scene_add_quad(scene, inner, z, step[1], NULL, NULL, &err), &err);
            must(lcor_scene_add_quad(scene, inner, step[0], z, NULL, NULL, &err), &err);
        }
        commit(scene);
        assert_int_equal(scene->solids.count, kind == 0);
        if (kind == 0) {
            const scene_solid *solid = scene->solids.items;

            assert_int_equal(solid->member_count, 5);
            assert_int_equal(solid->plane_count, 6);
            assert_int_equal(solid->edge_count, 12);
            assert_int_equal(scene->blockers.count, 7); /* and the room's six faces */
            assert_true(lcor_scene_in_solid(scene, middle));
            assert_false(lcor_scene_in_solid(scene, z));
        }
        lcor_scene_free(scene);
    }
}

/* A ball seen from inside, of 2 n^2 triangles; one of its corners may be moved along its radius. */
static int ball_is_convex(int n, int moved, double radius)
{
    lcor_scene *scene = empty();
    lcor_error err;
    int convex;

    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            double p[4][3];

            for (int c = 0; c < 4; c++) {
                const int row = i + c / 2, column = (j + c % 2) % n;
                const double polar = pi * row / n, around = 2 * pi * column / n;
                const double r = row * n + column == moved ? radius : 1;

                p[c][0] = r * sin(polar) * cos(around);
                p[c][1] = r * sin(polar) * sin(around);
                p[c][2] = r * cos(polar);
            }
            if (i + 1 < n)
                (void)lcor_scene_add_triangle(scene, p[0], p[3], p[2], NULL, NULL, NULL);
            if (i > 0)
                (void)lcor_scene_add_triangle(scene, p[0], p[1], p[3], NULL, NULL, NULL);
        }
    must(lcor_scene_commit(scene, NULL, &err), &err);
    convex = scene->convex;
    lcor_scene_free(scene);
    return convex;
}

static void a_ball_is_convex_until_one_corner_moves(void **state)
{
    (void)state;
    assert_true(ball_is_convex(80, -1, 1));
    assert_false(ball_is_convex(80, 40 * 80 + 33, 0.999));
    assert_false(ball_is_convex(80, 40 * 80 + 33, 1.001));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(commit_names_the_first_bad_item),
        cmocka_unit_test(a_committed_scene_keeps_its_shapes),
        cmocka_unit_test(patches_cover_their_surface),
        cmocka_unit_test(triangle_patches_have_the_documented_order),
        cmocka_unit_test(rays_report_surface_place_and_side),
        cmocka_unit_test(boxes_stand_in_the_light_as_one),
        cmocka_unit_test(a_ball_is_convex_until_one_corner_moves),
    };

    return cmocka_run_group_tests_name("scene", tests, NULL, NULL);
}
