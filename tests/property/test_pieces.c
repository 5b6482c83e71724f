/* SPDX-License-Identifier: MIT */
/* Walls that come in pieces are solved as whole ones, and answer piece by piece. */
#include "crew.h"
#include "rooms.h"

enum { PATCHES = 8, VALUES = ROOM_FACES * PATCHES * PATCHES };

typedef enum cut { WHOLE, STRIPS, TILES, TURNED_TILES, TRIANGLES } cut;

static void add_look(lcor_surface *look, double rho, size_t nu, size_t nv)
{
    memset(look, 0, sizeof *look);
    look->reflectance[0] = look->reflectance[1] = look->reflectance[2] = rho;
    look->patches[0] = nu;
    look->patches[1] = nv;
}

/* One face of a room, PATCHES by PATCHES of them whatever the cut. */
static void add_pieces(lcor_scene *scene, const double face[9], double rho, cut kind)
{
    const int rows = kind == WHOLE ? 1 : 4, columns = kind == WHOLE || kind == STRIPS ? 1 : 4;
    const double *o = face, *u = face + 3, *v = face + 6;
    lcor_surface look;
    lcor_error err;

    if (kind == TRIANGLES) {
        double b[3], c[3], d[3];

        add_look(&look, rho, PATCHES, PATCHES);
        for (int k = 0; k < 3; k++) {
            b[k] = o[k] + u[k];
            c[k] = b[k] + v[k];
            d[k] = o[k] + v[k];
        }
        must(lcor_scene_add_triangle(scene, o, b, c, &look, NULL, &err), &err);
        must(lcor_scene_add_triangle(scene, o, c, d, &look, NULL, &err), &err);
        return;
    }
    add_look(&look, rho, (size_t)(PATCHES / rows), (size_t)(PATCHES / columns));
    for (int k = 0; k < rows * columns; k++) {
        double p[3], a[3], b[3];
        const int turned = kind == TURNED_TILES && k % 2;

        for (int c = 0; c < 3; c++) {
            a[c] = turned ? v[c] / columns : u[c] / rows;
            b[c] = turned ? -u[c] / rows : v[c] / columns;
            p[c] = o[c] + (k / columns + turned) * u[c] / rows + k % columns * v[c] / columns;
        }
        must(lcor_scene_add_quad(scene, p, a, b, &look, NULL, &err), &err);
    }
}

/* The paper's room, not yet committed; with a box, five faces in the same pieces. */
static lcor_scene *room_in(cut kind, int box)
{
    lcor_scene *scene = NULL;
    lcor_error err;

    must(lcor_scene_new(NULL, &scene, &err), &err);
    for (int f = 0; f < (box ? ROOM_AND_BOX_FACES : ROOM_FACES); f++)
        add_pieces(scene, room_quads[f], f < ROOM_FACES ? paper_rho[f] : 0.5, kind);
    add_lamp(scene, 0.3, 0.4, 0.7, 1);
    return scene;
}

static lcor_solution *solve_links(const lcor_scene *scene, double tolerance)
{
    const lcor_radiosity_options options = options_for(LCOR_ENGINE_LINKS, tolerance);

    return solve_with(scene, &options);
}

/* The centre of every patch against the whole room's solution there. */
static void agree(const lcor_scene *scene, const lcor_solution *pieces, const lcor_solution *whole)
{
    for (size_t s = 0; s < lcor_scene_surface_count(scene); s++) {
        double centres[3 * VALUES], normals[3 * VALUES], normal[3];
        double at[VALUES], here[VALUES], patch[VALUES];
        size_t n;
        lcor_error err;

        must(lcor_scene_patch_count(scene, s, &n, &err), &err);
        must(lcor_scene_patch_geometry(scene, s, centres, NULL, normal, &err), &err);
        for (size_t k = 0; k < 3 * n; k++)
            normals[k] = normal[k % 3];
        must(lcor_solution_at(whole, n, centres, normals, at, NULL, &err), &err);
        must(lcor_solution_at(pieces, n, centres, normals, here, NULL, &err), &err);
        must(lcor_solution_patches(pieces, s, LCOR_VALUE_CENTRE, patch, NULL, &err), &err);
        for (size_t k = 0; k < n; k++) {
            check_near(here[k], at[k], 1e-9 * at[k], "at a point");
            check_near(patch[k], at[k], 1e-9 * at[k], "at a patch's centre");
        }
    }
}

/* Indirect irradiance of a surface's patches: averages of direct light are as accurate as asked
 * for, and their quadrature depends on the surface's size. */
static void indirect_of(const lcor_solution *solution, size_t surface, size_t n, double *out)
{
    double direct[VALUES];
    lcor_error err;

    must(lcor_solution_patches(solution, surface, LCOR_VALUE_AVERAGE, out, direct, &err), &err);
    for (size_t k = 0; k < n; k++)
        out[k] -= direct[k];
}

/* The same, mean over so many surfaces. */
static double mean_of(const lcor_scene *scene, const lcor_solution *solution, size_t first,
                      size_t count)
{
    double sum = 0, area = 0;
    lcor_error err;

    for (size_t s = first; s < first + count; s++) {
        double areas[VALUES], patch[VALUES];
        size_t n;

        must(lcor_scene_patch_count(scene, s, &n, &err), &err);
        must(lcor_scene_patch_geometry(scene, s, NULL, areas, NULL, &err), &err);
        indirect_of(solution, s, n, patch);
        for (size_t k = 0; k < n; k++) {
            sum += patch[k] * areas[k];
            area += areas[k];
        }
    }
    return sum / area;
}

static void walls_in_pieces_are_solved_as_whole_ones(void **state)
{
    static const cut kinds[] = {STRIPS, TILES, TURNED_TILES, TRIANGLES};
    static const unsigned pieces[] = {4, 16, 16, 2};

    (void)state;
    for (int box = 0; box < 2; box++) {
        lcor_scene *scene = room_in(WHOLE, box);
        lcor_solution *whole;

        commit(scene);
        whole = solve_links(scene, 0.02);
        assert_int_equal(lcor_solution_report(whole)->surfaces_merged, 0);
        assert_int_equal(lcor_solution_report(whole)->merged_into, 0);
        for (int k = 0; k < 4; k++) {
            const unsigned faces = box ? 11 : ROOM_FACES;
            lcor_scene *other = room_in(kinds[k], box);
            const lcor_radiosity_report *report;
            lcor_solution *solution;
            char said[64];

            commit(other);
            solution = solve_links(other, 0.02);
            report = lcor_solution_report(solution);
            assert_int_equal(report->surfaces_merged, pieces[k] * faces);
            assert_int_equal(report->merged_into, faces);
            (void)snprintf(said, sizeof said, "%u coplanar surfaces merged into %u",
                           pieces[k] * faces, faces);
            assert_non_null(strstr(report->models, said));
            assert_int_equal(report->links, lcor_solution_report(whole)->links);
            agree(other, solution, whole);
            for (size_t f = 0; f < faces; f++) {
                const double known = mean_of(scene, whole, f, 1);

                check_near(mean_of(other, solution, f * pieces[k], pieces[k]), known, 1e-9 * known,
                           "mean of a wall");
            }
            lcor_solution_free(solution);
            lcor_scene_free(other);
        }
        lcor_solution_free(whole);
        lcor_scene_free(scene);
    }
}

/* Averages of tiles are the whole wall's, patch by patch. */
static void tiles_have_the_patches_of_the_wall(void **state)
{
    lcor_scene *scene = room_in(WHOLE, 1), *tiled = room_in(TILES, 1);
    lcor_solution *whole, *solution;

    (void)state;
    commit(scene);
    commit(tiled);
    whole = solve_links(scene, 0.02);
    solution = solve_links(tiled, 0.02);
    for (size_t f = 0; f < 11; f++) {
        double wall[PATCHES * PATCHES], tile[4];

        indirect_of(whole, f, PATCHES * PATCHES, wall);
        for (size_t k = 0; k < 16; k++) {
            indirect_of(solution, 16 * f + k, 4, tile);
            for (size_t i = 0; i < 4; i++) {
                const double known = wall[(k / 4 * 2 + i / 2) * PATCHES + k % 4 * 2 + i % 2];

                check_near(tile[i], known, 1e-9 * known, "average over a patch");
            }
        }
    }
    lcor_solution_free(solution);
    lcor_solution_free(whole);
    lcor_scene_free(tiled);
    lcor_scene_free(scene);
}

/* A tile gets another colour: its wall falls into pieces; painted back, it is one again. */
static void a_wall_is_whole_while_its_tiles_look_alike(void **state)
{
    lcor_scene *scene = room_in(TILES, 0), *painted = room_in(TILES, 0);
    lcor_surface look;
    lcor_solution *solution, *fresh;
    double before, after, known;
    lcor_error err;

    (void)state;
    commit(scene);
    solution = solve_links(scene, 0.02);
    before = mean_of(scene, solution, 0, 6 * 16);
    add_look(&look, 0.9, 2, 2);
    must(lcor_scene_set_surface(scene, 5, &look, &err), &err);
    must(lcor_scene_set_surface(painted, 5, &look, &err), &err);
    commit(painted);
    fresh = solve_links(painted, 0.02);
    must(lcor_solution_update(solution, &err), &err);
    after = mean_of(scene, solution, 0, 6 * 16);
    known = mean_of(painted, fresh, 0, 6 * 16);
    check_near(after, known, 0.005 * known, "with one tile painted");
    assert_true(after > 1.02 * before);
    assert_int_equal(lcor_solution_report(solution)->surfaces_merged, 5 * 16);
    add_look(&look, paper_rho[0], 2, 2);
    must(lcor_scene_set_surface(scene, 5, &look, &err), &err);
    must(lcor_solution_update(solution, &err), &err);
    check_near(mean_of(scene, solution, 0, 6 * 16), before, 1e-12 * before, "painted back");
    assert_int_equal(lcor_solution_report(solution)->surfaces_merged, 6 * 16);
    lcor_solution_free(solution);
    lcor_solution_free(fresh);
    lcor_scene_free(scene);
    lcor_scene_free(painted);
}

static void a_surface_may_get_a_second_side(void **state)
{
    const double below[3] = {0.5, 0.5, 0.4}, down[3] = {0, 0, -1};
    const double shelf[9] = {0.3, 0.3, 0.4, 0.4, 0, 0, 0, 0.4, 0};
    lcor_scene *scene = room_in(WHOLE, 0);
    lcor_solution *solution, *fresh;
    double updated, known;
    lcor_surface look;
    lcor_error err;

    (void)state;
    add_look(&look, 0.5, 2, 2);
    must(lcor_scene_add_quad(scene, shelf, shelf + 3, shelf + 6, &look, NULL, &err), &err);
    commit(scene);
    solution = solve_links(scene, 0.02);
    look.two_sided = 1;
    must(lcor_scene_set_surface(scene, ROOM_FACES, &look, &err), &err);
    must(lcor_solution_update(solution, &err), &err);
    fresh = solve_links(scene, 0.02);
    must(lcor_solution_at(solution, 1, below, down, &updated, NULL, &err), &err);
    must(lcor_solution_at(fresh, 1, below, down, &known, NULL, &err), &err);
    check_near(updated, known, 1e-12 * known, "below the shelf");
    lcor_solution_free(solution);
    lcor_solution_free(fresh);
    lcor_scene_free(scene);
}

static void bits_of_pieces_do_not_depend_on_the_number_of_threads(void **state)
{
    lcor_scene *scene = room_in(TILES, 1);
    lcor_radiosity_options options = options_for(LCOR_ENGINE_LINKS, 0.05);
    lcor_solution *alone, *together;
    crew c = {.threads = 3};
    lcor_error err;

    (void)state;
    commit(scene);
    alone = solve_with(scene, &options);
    options.parallel.run = crew_run;
    options.parallel.user = &c;
    together = solve_with(scene, &options);
    assert_true(c.calls > 3);
    for (size_t s = 0; s < lcor_scene_surface_count(scene); s++) {
        double a[4], b[4];

        must(lcor_solution_patches(alone, s, LCOR_VALUE_AVERAGE, a, NULL, &err), &err);
        must(lcor_solution_patches(together, s, LCOR_VALUE_AVERAGE, b, NULL, &err), &err);
        assert_memory_equal(a, b, sizeof a);
    }
    lcor_solution_free(alone);
    lcor_solution_free(together);
    lcor_scene_free(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(walls_in_pieces_are_solved_as_whole_ones),
        cmocka_unit_test(tiles_have_the_patches_of_the_wall),
        cmocka_unit_test(a_wall_is_whole_while_its_tiles_look_alike),
        cmocka_unit_test(a_surface_may_get_a_second_side),
        cmocka_unit_test(bits_of_pieces_do_not_depend_on_the_number_of_threads),
    };

    return cmocka_run_group_tests_name("pieces", tests, NULL, NULL);
}
