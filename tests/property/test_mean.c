/* SPDX-License-Identifier: MIT */
/* The running mean: bits independent of order and split, and the definition it must meet. */
#include "testing.h"

#include <lcor/adapt.h>

enum { N = 20000 };

static double r[N], w[N];

/* Scenes of wide and narrow range, with zeros and repeated values. */
static void fill(uint64_t seed, double decades, double zeros)
{
    for (int i = 0; i < N; i++) {
        r[i] = pow(10.0, -decades * random_unit(&seed));
        if (random_unit(&seed) < 0.2)
            r[i] = 0.0123;
        if (random_unit(&seed) < zeros)
            r[i] = 0.0;
        w[i] = random_unit(&seed) * 1e-3;
    }
}

static double mean_of(const lcor_mean *mean, lcor_mean_method method)
{
    double m = -1.0;

    assert_int_equal(lcor_mean_get(mean, method, &m, NULL), LCOR_OK);
    return m;
}

static void bits_depend_neither_on_order_nor_on_split(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= 6; seed++) {
        const double *weights = seed % 2 ? w : NULL;
        lcor_mean whole, backwards, parts[7];

        fill(seed, (double)seed * 6.0, 0.1 * (double)(seed % 3));
        lcor_mean_init(&whole);
        lcor_mean_init(&backwards);
        for (int p = 0; p < 7; p++)
            lcor_mean_init(&parts[p]);
        lcor_mean_add(&whole, N, r, weights);
        for (int i = N - 1; i >= 0; i--)
            lcor_mean_add(&backwards, 1, r + i, weights != NULL ? weights + i : NULL);
        for (int i = 0; i < N; i++)
            lcor_mean_add(&parts[i * i % 7], 1, r + i, weights != NULL ? weights + i : NULL);
        for (int p = 5; p >= 0; p--)
            assert_int_equal(lcor_mean_merge(&parts[6], &parts[p], NULL), LCOR_OK);
        assert_memory_equal(&whole, &backwards, sizeof whole);
        assert_memory_equal(&whole, &parts[6], sizeof whole);
        /* a second pass likewise */
        lcor_mean_refine(&whole, LCOR_MEAN_ADAPTIVE);
        lcor_mean_refine(&parts[6], LCOR_MEAN_ADAPTIVE);
        parts[5] = parts[6];
        lcor_mean_add(&whole, N, r, weights);
        lcor_mean_add(&parts[5], 300, r, weights);
        lcor_mean_add(&parts[6], N - 300, r + 300, weights != NULL ? weights + 300 : NULL);
        assert_int_equal(lcor_mean_merge(&parts[6], &parts[5], NULL), LCOR_OK);
        assert_memory_equal(&whole, &parts[6], sizeof whole);
    }
}

/* Rule S3 word by word, in long double: sum of w max(ln r - ln m, -ln 10) = 0 */
static long double defect(long double ln_m, const double *weights)
{
    long double sum = 0.0L;

    for (int i = 0; i < N; i++) {
        const long double l = r[i] > 0.0 ? logl((long double)r[i]) - ln_m : -1e30L;

        sum += (long double)(weights != NULL ? weights[i] : 1.0) * fmaxl(l, -2.302585092994045684L);
    }
    return sum;
}

static void adaptive_mean_solves_its_equation(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= 6; seed++) {
        const double *weights = seed % 2 ? w : NULL;
        const double decades = (double)seed * 2.0;
        long double lo = -300.0L, hi = 10.0L;
        lcor_mean mean;
        double m, one_pass;

        fill(seed, decades, 0.2 * (double)(seed % 3));
        for (int i = 0; i < 70; i++) {
            const long double x = 0.5L * (lo + hi);

            if (defect(x, weights) > 0.0L)
                lo = x;
            else
                hi = x;
        }
        assert_int_equal(lcor_geometric_mean(N, r, weights, LCOR_MEAN_ADAPTIVE, &m, NULL), LCOR_OK);
        check_near(m / (double)expl(lo), 1.0, 3e-15, "adaptive mean");
        lcor_mean_init(&mean);
        lcor_mean_add(&mean, N, r, weights);
        one_pass = mean_of(&mean, LCOR_MEAN_ADAPTIVE);
        assert_true(lcor_mean_error(&mean, LCOR_MEAN_ADAPTIVE) < 0.02);
        check_near(one_pass / m, 1.0, lcor_mean_error(&mean, LCOR_MEAN_ADAPTIVE) * 1.01 + 3e-15,
                   "one pass");
    }
}

static void mean_scales_with_its_values_and_ignores_the_unit_of_weights(void **state)
{
    (void)state;
    for (int k = 0; k < 2; k++) {
        const lcor_mean_method method = (lcor_mean_method)k;
        double a, b;

        fill(9, 5.0, 0.1);
        assert_int_equal(lcor_geometric_mean(N, r, w, method, &a, NULL), LCOR_OK);
        for (int i = 0; i < N; i++) {
            r[i] *= 1099511627776.0; /* 2^40: exact */
            w[i] *= 1024.0;
        }
        assert_int_equal(lcor_geometric_mean(N, r, w, method, &b, NULL), LCOR_OK);
        check_near(b / (a * 1099511627776.0), 1.0, 4e-15, "scaled");
    }
}

static void no_weights_are_weights_of_one(void **state)
{
    lcor_mean without, with;

    (void)state;
    fill(13, 6.0, 0.1);
    for (int i = 0; i < N; i++)
        w[i] = 1.0;
    lcor_mean_init(&without);
    lcor_mean_init(&with);
    lcor_mean_add(&without, N, r, NULL);
    lcor_mean_add(&with, N, r, w);
    assert_memory_equal(&without, &with, sizeof with);
}

/* 10^8 values: 5000 copies of 20,000, which merging must treat as adding does. */
static void a_hundred_million_values_lose_nothing(void **state)
{
    lcor_mean once, many;
    double a, b;

    (void)state;
    fill(11, 3.0, 0.05);
    lcor_mean_init(&once);
    lcor_mean_init(&many);
    lcor_mean_add(&once, N, r, NULL);
    for (int i = 0; i < 5000; i++)
        assert_int_equal(lcor_mean_merge(&many, &once, NULL), LCOR_OK);
    a = mean_of(&once, LCOR_MEAN_LITERAL);
    b = mean_of(&many, LCOR_MEAN_LITERAL);
    check_near(a, b, 1e-16, "literal");
    a = mean_of(&once, LCOR_MEAN_ADAPTIVE);
    b = mean_of(&many, LCOR_MEAN_ADAPTIVE);
    check_near(a, b, 1e-16, "adaptive");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bits_depend_neither_on_order_nor_on_split),
        cmocka_unit_test(adaptive_mean_solves_its_equation),
        cmocka_unit_test(mean_scales_with_its_values_and_ignores_the_unit_of_weights),
        cmocka_unit_test(no_weights_are_weights_of_one),
        cmocka_unit_test(a_hundred_million_values_lose_nothing)};

    return cmocka_run_group_tests(tests, NULL, NULL);
}
