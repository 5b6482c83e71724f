/* SPDX-License-Identifier: MIT */
/* Rays through the hierarchy against every primitive in turn, in scenes of any size and place. */
#include "base/internal.h"
#include "geometry/bvh_internal.h"
#include "geometry/vec.h"
#include "testing.h"

enum { PRIMS = 600, RAYS = 400 };

static int brute_force(const lcor_bvh_prim *prims, const lcor_ray *ray, double *nearest)
{
    int found = 0;

    *nearest = ray->t_max;
    for (size_t i = 0; i < PRIMS; i++) {
        const lcor_bvh_prim *p = &prims[i];
        double n[3], d[3], a[3], b[3], t, u, v, nn;

        if (p->owner == ray->skip)
            continue;
        vec_cross(p->edge_u, p->edge_v, n);
        nn = vec_dot(n, n);
        if (!(nn > 0))
            continue;
        vec_sub(p->origin, ray->origin, d);
        t = vec_dot(d, n) / vec_dot(ray->direction, n);
        if (!(t > ray->t_min && t < *nearest))
            continue;
        vec_add_scaled(ray->origin, t, ray->direction, a);
        vec_sub(a, p->origin, d);
        vec_cross(d, p->edge_v, b);
        u = vec_dot(b, n) / nn;
        vec_cross(p->edge_u, d, b);
        v = vec_dot(b, n) / nn;
        if (u < 0 || v < 0 || u > 1 || (p->parallelogram ? v : u + v) > 1)
            continue;
        *nearest = t;
        found = 1;
    }
    return found;
}

static void fill(lcor_bvh_prim *prims, double size, double place, uint64_t *state)
{
    for (uint32_t i = 0; i < PRIMS; i++) {
        const double reach = size * (i % 7 == 0 ? 0.6 : i % 11 == 0 ? 1e-4 : 0.05);

        prims[i].owner = i / 2;
        prims[i].parallelogram = i % 3 == 0;
        for (int k = 0; k < 3; k++) {
            prims[i].origin[k] = place + size * random_unit(state);
            prims[i].edge_u[k] = reach * (random_unit(state) - 0.5);
            prims[i].edge_v[k] = reach * (random_unit(state) - 0.5);
        }
    }
}

static void check_rays(const lcor_bvh_prim *prims, double size, double place)
{
    lcor_allocator allocator;
    lcor_bvh *bvh = NULL;
    uint64_t state = 54321;
    uint32_t cache = LCOR_BVH_NONE;
    int hits = 0;

    assert_int_equal(lcor_internal_allocator(NULL, &allocator, NULL), LCOR_OK);
    assert_int_equal(lcor_bvh_new(PRIMS, prims, &allocator, NULL, &bvh, NULL), LCOR_OK);
    for (int r = 0; r < RAYS; r++) {
        lcor_ray ray;
        lcor_bvh_hit hit;
        double nearest;
        int found;

        for (int k = 0; k < 3; k++) {
            /* Every fourth ray comes from far outside. */
            ray.origin[k] =
                place + size * (r % 4 ? random_unit(&state) : 1e3 * random_unit(&state));
            ray.direction[k] = place + size * random_unit(&state) - ray.origin[k];
        }
        ray.t_min = 0;
        ray.t_max = r % 3 ? HUGE_VAL : 0.7;
        ray.skip = r % 5 ? LCOR_BVH_NONE : (uint32_t)(r % (PRIMS / 2));
        found = brute_force(prims, &ray, &nearest);
        hits += found;
        assert_int_equal(lcor_bvh_closest(bvh, &ray, &hit), found);
        assert_int_equal(lcor_bvh_occluded(bvh, &ray, &cache), found);
        if (found)
            check_near(hit.t, nearest, 1e-9 * fmax(1, fabs(place) / size) * nearest, "distance");
    }
    assert_true(hits > RAYS / 4);
    lcor_bvh_free(bvh);
}

static void check_scene(double size, double place)
{
    static lcor_bvh_prim prims[PRIMS];
    uint64_t state = 12345;

    fill(prims, size, place, &state);
    check_rays(prims, size, place);
}

static void hits_agree_with_brute_force(void **state)
{
    (void)state;
    check_scene(1, 0);
}

static void tiny_and_huge_scenes_are_no_different(void **state)
{
    (void)state;
    check_scene(1e-6, 0);
    check_scene(1e6, 0);
    check_scene(1e-30, 0);
}

static void scenes_far_from_the_origin_are_no_different(void **state)
{
    (void)state;
    check_scene(1, 1e4);
}

/* Nothing can be told apart by where it lies: all coincide, or lie one inside the other. */
static void primitives_about_one_centre_are_no_different(void **state)
{
    static lcor_bvh_prim prims[PRIMS];
    uint64_t seed = 7;

    (void)state;
    for (int nested = 0; nested < 2; nested++) {
        for (uint32_t i = 0; i < PRIMS; i++) {
            const double reach = nested ? pow(0.99, i) : 1;

            prims[i] = (lcor_bvh_prim){.owner = i / 2, .parallelogram = 1};
            for (int k = 0; k < 3; k++) {
                prims[i].edge_u[k] = nested ? reach * (random_unit(&seed) - 0.5) : k == 0;
                prims[i].edge_v[k] = nested ? reach * (random_unit(&seed) - 0.5) : k != 0;
                prims[i].origin[k] = 0.5 - 0.5 * (prims[i].edge_u[k] + prims[i].edge_v[k]);
            }
        }
        check_rays(prims, 1, 0);
    }
}

/* Needles across the whole scene, some without any area, before a wall. */
static void needles_are_no_different(void **state)
{
    static lcor_bvh_prim prims[PRIMS];
    uint64_t seed = 8;

    (void)state;
    fill(prims, 1, 0, &seed);
    for (uint32_t i = 0; i < PRIMS; i++)
        for (int k = 0; k < 3; k++) {
            prims[i].edge_u[k] = (uint32_t)k == i % 3 ? 1 - prims[i].origin[k] : 1e-7;
            prims[i].edge_v[k] = i % 5 ? 1e-5 * prims[i].edge_v[k] : 0.5 * prims[i].edge_u[k];
        }
    prims[0] = (lcor_bvh_prim){{-1, -1, 0.5}, {3, 0, 0}, {0, 3, 0}, 0, 1};
    check_rays(prims, 1, 0);
}

/* Every instruction set gives the same bits, hits at edges and of grazing rays included. */
static void instruction_sets_agree(void **state)
{
    static lcor_bvh_prim prims[PRIMS];
    lcor_allocator allocator;
    lcor_bvh *bvh = NULL;
    uint64_t seed = 2024;
    int hits = 0;

    (void)state;
    assert_int_equal(lcor_internal_allocator(NULL, &allocator, NULL), LCOR_OK);
    fill(prims, 1, 0, &seed);
    assert_int_equal(lcor_bvh_new(PRIMS, prims, &allocator, NULL, &bvh, NULL), LCOR_OK);
    for (int r = 0; r < 20 * RAYS; r++) {
        const lcor_bvh_prim *aim = &prims[r % PRIMS];
        const double u = r % 3 ? random_unit(&seed) : 0, v = r % 4 ? random_unit(&seed) : 0;
        lcor_ray ray = {{0, 0, 0}, {0, 0, 0}, 0, HUGE_VAL, LCOR_BVH_NONE};
        lcor_bvh_hit first, hit;
        int found;

        for (int k = 0; k < 3; k++) {
            /* Every other ray starts in the plane of what it aims at. */
            ray.origin[k] = r % 2 ? aim->origin[k] + 3 * aim->edge_u[k] + 2 * aim->edge_v[k]
                                  : random_unit(&seed);
            ray.direction[k] =
                aim->origin[k] + u * aim->edge_u[k] + v * aim->edge_v[k] - ray.origin[k];
        }
        bvh->walk = bvh_walk_at(0);
        memset(&first, 0, sizeof first);
        found = lcor_bvh_closest(bvh, &ray, &first);
        hits += found;
        for (size_t i = 0; bvh_walk_at(i); i++) {
            bvh->walk = bvh_walk_at(i);
            memset(&hit, 0, sizeof hit);
            assert_int_equal(lcor_bvh_closest(bvh, &ray, &hit), found);
            assert_memory_equal(&hit, &first, sizeof hit);
            assert_int_equal(lcor_bvh_occluded(bvh, &ray, NULL), found);
        }
    }
    assert_true(hits > 10 * RAYS);
    lcor_bvh_free(bvh);
}

/* A sure hit by the float test is one: t_min and t_max an ulp before and behind a wall. */
static void ends_of_the_ray_are_exact(void **state)
{
    const lcor_bvh_prim wall = {{-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, 0, 1};
    lcor_allocator allocator;
    lcor_bvh *bvh = NULL;
    lcor_bvh_hit hit;

    (void)state;
    assert_int_equal(lcor_internal_allocator(NULL, &allocator, NULL), LCOR_OK);
    assert_int_equal(lcor_bvh_new(1, &wall, &allocator, NULL, &bvh, NULL), LCOR_OK);
    for (size_t i = 0; bvh_walk_at(i); i++) {
        lcor_ray ray = {{0.1, 0.2, 0.5}, {0, 0, -1}, 0, HUGE_VAL, LCOR_BVH_NONE};

        bvh->walk = bvh_walk_at(i);
        for (int k = -1; k <= 1; k++) {
            ray.t_max = 0.5 + k * 1e-12;
            ray.t_min = 0;
            assert_int_equal(lcor_bvh_closest(bvh, &ray, &hit), k > 0);
            assert_int_equal(lcor_bvh_occluded(bvh, &ray, NULL), k > 0);
            ray.t_min = ray.t_max;
            ray.t_max = 2;
            assert_int_equal(lcor_bvh_closest(bvh, &ray, &hit), k < 0);
            assert_int_equal(lcor_bvh_occluded(bvh, &ray, NULL), k < 0);
        }
    }
    lcor_bvh_free(bvh);
}

/* A direction is often the negative of a normal, with zeros of either sign. */
static void zeros_of_either_sign_are_one_direction(void **state)
{
    const lcor_bvh_prim wall = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 0, 1};
    lcor_allocator allocator;
    lcor_bvh *bvh = NULL;

    (void)state;
    assert_int_equal(lcor_internal_allocator(NULL, &allocator, NULL), LCOR_OK);
    assert_int_equal(lcor_bvh_new(1, &wall, &allocator, NULL, &bvh, NULL), LCOR_OK);
    for (int i = 0; i < 4; i++) {
        const lcor_ray ray = {
            {0.25, 0.75, 1}, {i & 1 ? -0.0 : 0.0, i & 2 ? -0.0 : 0.0, -1}, 0, 2, LCOR_BVH_NONE};
        lcor_bvh_hit hit;

        assert_true(lcor_bvh_closest(bvh, &ray, &hit));
        assert_true(lcor_bvh_occluded(bvh, &ray, NULL));
    }
    lcor_bvh_free(bvh);
}

/* Two triangles that share an edge: no ray may slip through. */
static void shared_edges_are_closed(void **state)
{
    const lcor_bvh_prim prims[2] = {{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, 0, 0},
                                    {{0, 0, 0}, {1, 1, 0}, {0, 1, 0}, 1, 0}};
    lcor_allocator allocator;
    lcor_bvh *bvh = NULL;
    uint64_t seed = 99;

    (void)state;
    assert_int_equal(lcor_internal_allocator(NULL, &allocator, NULL), LCOR_OK);
    assert_int_equal(lcor_bvh_new(2, prims, &allocator, NULL, &bvh, NULL), LCOR_OK);
    for (int r = 0; r < 2000; r++) {
        const double on = 0.001 + 0.998 * random_unit(&seed);
        lcor_ray ray = {{0, 0, 0}, {0, 0, 0}, 0, 2, LCOR_BVH_NONE};
        lcor_bvh_hit hit;

        for (int k = 0; k < 3; k++) {
            ray.origin[k] = random_unit(&seed) + (k == 2 ? 0.1 : 0);
            ray.direction[k] = (k < 2 ? on : 0) - ray.origin[k];
        }
        assert_int_equal(lcor_bvh_closest(bvh, &ray, &hit), 1);
    }
    lcor_bvh_free(bvh);
}

static void an_empty_hierarchy_is_never_hit(void **state)
{
    const lcor_bvh_prim flat = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, 0, 1};
    const lcor_ray ray = {{0.5, 0, 1}, {0, 0, -1}, 0, 10, LCOR_BVH_NONE};
    lcor_allocator allocator;
    lcor_bvh *bvh = NULL;
    lcor_bvh_hit hit;

    (void)state;
    assert_int_equal(lcor_internal_allocator(NULL, &allocator, NULL), LCOR_OK);
    for (size_t n = 0; n < 2; n++) {
        assert_int_equal(lcor_bvh_new(n, &flat, &allocator, NULL, &bvh, NULL), LCOR_OK);
        assert_int_equal(lcor_bvh_closest(bvh, &ray, &hit), 0);
        lcor_bvh_free(bvh);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(hits_agree_with_brute_force),
        cmocka_unit_test(tiny_and_huge_scenes_are_no_different),
        cmocka_unit_test(scenes_far_from_the_origin_are_no_different),
        cmocka_unit_test(primitives_about_one_centre_are_no_different),
        cmocka_unit_test(needles_are_no_different),
        cmocka_unit_test(instruction_sets_agree),
        cmocka_unit_test(ends_of_the_ray_are_exact),
        cmocka_unit_test(zeros_of_either_sign_are_one_direction),
        cmocka_unit_test(shared_edges_are_closed),
        cmocka_unit_test(an_empty_hierarchy_is_never_hit),
    };

    return cmocka_run_group_tests_name("bvh", tests, NULL, NULL);
}
