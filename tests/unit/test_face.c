/* SPDX-License-Identifier: MIT */
/* The faces that surfaces are cut into. */
#include "base/internal.h"
#include "radiosity/face.h"
#include "rooms.h"

#include <math.h>

/* A wall of height 1/2 that stands on the floor between two of its points. */
static void add_screen(lcor_scene *scene, const double from[2], const double to[2])
{
    const double corner[3] = {from[0], from[1], 0}, up[3] = {0, 0, 0.5};
    const double along[3] = {to[0] - from[0], to[1] - from[1], 0};
    const lcor_surface look = {.patches = {1, 1}, .two_sided = 1};
    lcor_error err;

    must(lcor_scene_add_quad(scene, corner, along, up, &look, NULL, &err), &err);
}

/* Area of the faces in the floor's plane that look up and are not covered. */
static double floor_area(lcor_scene *scene)
{
    const cell all = {0, 0, 1, 1};
    face_range *sides = calloc(2 * lcor_scene_surface_count(scene), sizeof *sides);
    lcor_array faces = {0};
    lcor_allocator allocator;
    lcor_error err;
    double area = 0;

    commit(scene);
    must(lcor_internal_allocator(NULL, &allocator, &err), &err);
    assert_non_null(sides);
    assert_true(face_build(scene, &allocator, &faces, sides));
    for (size_t i = 0; i < faces.count; i++) {
        const face *f = (const face *)faces.items + i;

        if (f->normal[2] > 0.5 && fabs(f->origin[2]) < 1e-12 && !f->covered)
            area += face_cell_area(f, &all);
    }
    lcor_array_clear(&allocator, &faces);
    free(sides);
    return area;
}

static void faces_below_a_stall_divided_from_corner_to_corner_cover_the_floor_once(void **state)
{
    uint64_t random = 1;

    (void)state;
    for (int round = 0; round < 200; round++) {
        const double rho[ROOM_FACES] = {0};
        double at[4][2];
        lcor_scene *scene = NULL;
        lcor_error err;

        must(lcor_scene_new(NULL, &scene, &err), &err);
        add_room(scene, 1, rho, 0, 8);
        for (int k = 0; k < 2; k++) {
            at[0][k] = random_unit(&random);
            at[2][k] = random_unit(&random);
            at[1 + 2 * k][k] = at[0][k];
            at[3 - 2 * k][k] = at[2][k];
        }
        for (int i = 0; i < 4; i++)
            add_screen(scene, at[i], at[(i + 1) % 4]);
        add_screen(scene, at[0], at[2]);
        check_near(floor_area(scene), 1, 1e-9, "area of the faces");
        lcor_scene_free(scene);
    }
}

static void every_place_of_a_floor_with_carpets_is_the_face_of_one_surface(void **state)
{
    uint64_t random = 2;

    (void)state;
    for (int round = 0; round < 200; round++) {
        const double rho[ROOM_FACES] = {0};
        lcor_scene *scene = NULL;
        lcor_error err;

        must(lcor_scene_new(NULL, &scene, &err), &err);
        add_room(scene, 1, rho, 0, 8);
        for (int i = 0; i < 3; i++) {
            const double x = 0.3 + 0.3 * random_unit(&random), y = 0.3 + 0.3 * random_unit(&random);
            const double u = 0.2 * random_unit(&random), v = 0.2 * random_unit(&random) - 0.1;
            const double corner[3] = {x - u, y - v, 0}, along[3] = {u + 0.1, v, 0};
            const double across[3] = {-v, u + 0.1, 0};
            const lcor_surface look = {.patches = {1, 1}, .two_sided = i == 1};

            must(lcor_scene_add_quad(scene, corner, along, across, &look, NULL, &err), &err);
        }
        check_near(floor_area(scene), 1, 1e-9, "area of the faces");
        lcor_scene_free(scene);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(faces_below_a_stall_divided_from_corner_to_corner_cover_the_floor_once),
        cmocka_unit_test(every_place_of_a_floor_with_carpets_is_the_face_of_one_surface),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
