/* SPDX-License-Identifier: MIT */
/* Means, contrast and the curve of eq 8 against 50-digit vectors. */
#include "testing.h"

#include <lcor/adapt.h>

static size_t parse_values(const char *text, double *out, size_t capacity)
{
    size_t n = 0;

    while (*text != '\0' && n < capacity) {
        char *end;

        out[n++] = strtod(text, &end);
        text = end + (*end == ' ');
    }
    return n;
}

static void means_are_golden(void **state)
{
    csv t = csv_read(LCOR_TEST_DATA "/golden/geomean.csv");

    (void)state;
    for (size_t i = 0; i < t.rows; i++) {
        const double literal = csv_number(&t, i, "literal_floor1e-8");
        const double adaptive = csv_number(&t, i, "adaptive10");
        double r[256], m;
        const size_t n = parse_values(csv_text(&t, i, "values"), r, 256);

        assert_int_equal(n, csv_number(&t, i, "n"));
        assert_int_equal(lcor_geometric_mean(n, r, NULL, LCOR_MEAN_LITERAL, &m, NULL), LCOR_OK);
        check_near(m, literal, 5e-15 * literal, "literal mean");
        assert_int_equal(lcor_geometric_mean(n, r, NULL, LCOR_MEAN_ADAPTIVE, &m, NULL), LCOR_OK);
        check_near(m, adaptive, 5e-15 * adaptive, "adaptive mean");
    }
    csv_free(&t);
}

static void one_pass_keeps_its_bound_and_refining_is_exact(void **state)
{
    csv t = csv_read(LCOR_TEST_DATA "/golden/geomean.csv");
    size_t doubtful = 0;

    (void)state;
    for (size_t i = 0; i < t.rows; i++)
        for (int k = 0; k < 2; k++) {
            const lcor_mean_method method = k == 0 ? LCOR_MEAN_LITERAL : LCOR_MEAN_ADAPTIVE;
            const double golden = csv_number(&t, i, k == 0 ? "literal_floor1e-8" : "adaptive10");
            double r[256], m, bound;
            const size_t n = parse_values(csv_text(&t, i, "values"), r, 256);
            lcor_mean mean;

            lcor_mean_init(&mean);
            for (size_t j = 0; j < n; j++)
                lcor_mean_add(&mean, 1, r + j, NULL);
            bound = lcor_mean_error(&mean, method);
            assert_int_equal(lcor_mean_get(&mean, method, &m, NULL), LCOR_OK);
            check_near(m, golden, (bound * 1.1 + 5e-15) * golden, "one pass");
            for (int pass = 0; pass < 7 && bound > 1e-15; pass++) {
                doubtful++;
                lcor_mean_refine(&mean, method);
                lcor_mean_add(&mean, n, r, NULL);
                assert_int_equal(lcor_mean_get(&mean, method, &m, NULL), LCOR_OK);
                bound = lcor_mean_error(&mean, method);
                check_near(m, golden, (bound * 1.1 + 5e-15) * golden, "refined");
            }
            assert_true(bound <= 1e-15);
        }
    assert_true(doubtful > 10); /* the vectors do put values into the bin in doubt */
    csv_free(&t);
}

static void contrast_from_density_is_golden(void **state)
{
    csv t = csv_read(LCOR_TEST_DATA "/golden/density_contrast.csv");

    (void)state;
    for (size_t i = 0; i < t.rows; i++) {
        const double d_max = csv_number(&t, i, "Dmax"), d_min = csv_number(&t, i, "Dmin");
        const double golden = csv_number(&t, i, "c");
        double c = 0.0;

        if (d_max > d_min) {
            assert_int_equal(lcor_contrast_from_density(d_max, d_min, &c, NULL), LCOR_OK);
            check_near(c, golden, 1e-14 * golden, "contrast");
        } else {
            assert_int_equal(lcor_contrast_from_density(d_max, d_min, &c, NULL), LCOR_ERR_DOMAIN);
        }
    }
    csv_free(&t);
}

static void curve_is_golden(void **state)
{
    csv t = csv_read(LCOR_TEST_DATA "/golden/eq8_adapt.csv");

    (void)state;
    for (size_t i = 0; i < t.rows; i++) {
        const double j = csv_number(&t, i, "J"), mean = csv_number(&t, i, "Jbar");
        const double lo = csv_number(&t, i, "Jmin"), hi = csv_number(&t, i, "Jmax");
        const double e = csv_number(&t, i, "t");
        const double j1 = csv_number(&t, i, "J1"), j2 = csv_number(&t, i, "J2");
        double h, r1, r2, back;

        assert_int_equal(lcor_adapt(j, mean, lo, hi, e, &h, NULL), LCOR_OK);
        check_near(h, csv_number(&t, i, "H"), 1e-14 * hi, "H");
        check_near((h - lo) / (hi - lo), csv_number(&t, i, "Ynew"), 1e-13, "Ynew");
        assert_int_equal(lcor_adapt_range(mean, lo, hi, e, &r1, &r2, NULL), LCOR_OK);
        check_near(r1, j1, 1e-12 * j1, "J1");
        check_near(r2, j2, 1e-12 * j2, "J2");
        if (e > 0.0 && h > lo && h < hi) {
            assert_int_equal(lcor_adapt_inverse(h, mean, lo, hi, e, &back, NULL), LCOR_OK);
            check_near(back, j, 1e-12 * j / e, "inverse");
        }
    }
    csv_free(&t);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(means_are_golden),
        cmocka_unit_test(one_pass_keeps_its_bound_and_refining_is_exact),
        cmocka_unit_test(contrast_from_density_is_golden), cmocka_unit_test(curve_is_golden)};

    return cmocka_run_group_tests(tests, NULL, NULL);
}
