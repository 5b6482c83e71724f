/* SPDX-License-Identifier: MIT */
#include "testing.h"

#include <lcor/adapt.h>

static void contrast_needs_two_ordered_finite_densities(void **state)
{
    double c = 7.0;
    lcor_error e;

    (void)state;
    assert_int_equal(lcor_contrast_from_density(1.439216, 0.07, &c, &e), LCOR_OK);
    check_near(c, pow(10.0, 1.369216), 1e-13, "c");
    c = 7.0;
    assert_int_equal(lcor_contrast_from_density(0.1, 0.1, &c, &e), LCOR_ERR_DOMAIN);
    assert_int_equal(lcor_contrast_from_density(0.1, 1.4, &c, &e), LCOR_ERR_DOMAIN);
    assert_int_equal(lcor_contrast_from_density((double)NAN, 0.1, &c, &e), LCOR_ERR_DOMAIN);
    assert_int_equal(lcor_contrast_from_density((double)INFINITY, 0.1, &c, &e), LCOR_ERR_DOMAIN);
    assert_int_equal(lcor_contrast_from_density(400.0, 0.0, &c, &e), LCOR_ERR_DOMAIN);
    assert_int_equal(lcor_contrast_from_density(1e-17, 0.0, &c, NULL), LCOR_ERR_DOMAIN);
    assert_true(c == 7.0); /* left alone */
    check_near(lcor_contrast_u95(23.4, 0.03, 0.04), 1.96 * 23.4 * log(10.0) * 0.05, 1e-13, "u95");
}

static void curve_refuses_what_eq_8_does_not_cover(void **state)
{
    double a = 5.0, b = 6.0;

    (void)state;
    assert_int_equal(lcor_adapt(-1.0, 1, 1, 2, 1, &a, NULL), LCOR_ERR_DOMAIN);
    assert_int_equal(lcor_adapt((double)NAN, 1, 1, 2, 1, &a, NULL), LCOR_ERR_DOMAIN);
    assert_int_equal(lcor_adapt(1, 0, 1, 2, 1, &a, NULL), LCOR_ERR_DOMAIN);
    assert_int_equal(lcor_adapt(1, 1, 2, 2, 1, &a, NULL), LCOR_ERR_DOMAIN);
    assert_int_equal(lcor_adapt(1, 1, -1, 2, 1, &a, NULL), LCOR_ERR_DOMAIN);
    assert_int_equal(lcor_adapt(1, 1, 1, 2, -1, &a, NULL), LCOR_ERR_DOMAIN);
    assert_int_equal(lcor_adapt_range(1, 1, (double)INFINITY, 1, &a, &b, NULL), LCOR_ERR_DOMAIN);
    assert_int_equal(lcor_adapt_inverse(1.5, 1, 1, 2, 0, &a, NULL), LCOR_ERR_DOMAIN);
    assert_int_equal(lcor_adapt_inverse(2.5, 1, 1, 2, 1, &a, NULL), LCOR_ERR_DOMAIN);
    assert_true(a == 5.0 && b == 6.0);
    assert_int_equal(lcor_adapt((double)INFINITY, 1, 1, 2, 1, &a, NULL), LCOR_OK);
    assert_true(a == 2.0);
    assert_int_equal(lcor_adapt_range(3, 1, 2, 1e-320, &a, &b, NULL), LCOR_OK);
    assert_true(a == 0.0 && isinf(b));
}

static void mean_leaves_out_and_counts_what_is_no_reflectance(void **state)
{
    const double r[6] = {0.5, (double)NAN, -0.1, (double)INFINITY, 0.5, 0.5};
    const double w[6] = {1.0, 1.0, 1.0, 1.0, (double)NAN, 2e7};
    lcor_mean mean;
    double m;

    (void)state;
    lcor_mean_init(&mean);
    lcor_mean_add(&mean, 6, r, w);
    assert_int_equal(mean.rejected, 5);
    assert_int_equal(lcor_mean_get(&mean, LCOR_MEAN_ADAPTIVE, &m, NULL), LCOR_OK);
    check_near(m, 0.5, 1e-16, "mean");
}

static void empty_and_all_black_means_differ(void **state)
{
    const double black[3] = {0.0, 0.0, -0.0}, none = 0.0;
    lcor_mean mean;
    double m = 4.0;
    lcor_error e;

    (void)state;
    lcor_mean_init(&mean);
    assert_int_equal(lcor_mean_get(&mean, LCOR_MEAN_ADAPTIVE, &m, &e), LCOR_ERR_DOMAIN);
    assert_true(m == 4.0);
    lcor_mean_add(&mean, 1, black, &none); /* weight 0: still nothing */
    assert_int_equal(lcor_mean_get(&mean, LCOR_MEAN_LITERAL, &m, &e), LCOR_ERR_DOMAIN);
    lcor_mean_add(&mean, 3, black, NULL);
    assert_true(lcor_mean_error(&mean, LCOR_MEAN_ADAPTIVE) == 0.0);
    lcor_mean_refine(&mean, LCOR_MEAN_ADAPTIVE);
    assert_int_equal(lcor_mean_get(&mean, LCOR_MEAN_ADAPTIVE, &m, &e), LCOR_OK);
    assert_true(m == 0.0);
    assert_int_equal(lcor_mean_get(&mean, (lcor_mean_method)2, &m, &e), LCOR_ERR_ARG);
    assert_int_equal(lcor_geometric_mean(0, NULL, NULL, LCOR_MEAN_ADAPTIVE, &m, &e),
                     LCOR_ERR_DOMAIN);
    assert_int_equal(lcor_geometric_mean(1, NULL, NULL, LCOR_MEAN_ADAPTIVE, &m, &e), LCOR_ERR_ARG);
}

static void means_of_different_passes_do_not_mix(void **state)
{
    const double r[2] = {0.2, 0.02};
    lcor_mean fresh, refined;
    lcor_error e;
    double m;

    (void)state;
    lcor_mean_init(&fresh);
    lcor_mean_add(&fresh, 2, r, NULL);
    refined = fresh;
    lcor_mean_refine(&refined, LCOR_MEAN_ADAPTIVE);
    assert_int_equal(lcor_mean_merge(&fresh, &refined, &e), LCOR_ERR_ARG);
    assert_int_equal(lcor_mean_get(&refined, LCOR_MEAN_LITERAL, &m, &e), LCOR_ERR_ARG);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(contrast_needs_two_ordered_finite_densities),
        cmocka_unit_test(curve_refuses_what_eq_8_does_not_cover),
        cmocka_unit_test(mean_leaves_out_and_counts_what_is_no_reflectance),
        cmocka_unit_test(empty_and_all_black_means_differ),
        cmocka_unit_test(means_of_different_passes_do_not_mix)};

    return cmocka_run_group_tests(tests, NULL, NULL);
}
