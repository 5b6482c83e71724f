/* SPDX-License-Identifier: MIT */
/* Worst errors of the double functions against the C library's long double ones, where that is
 * wider than double; elsewhere against double, with room for its own rounding. */
#include "testing.h"

#include "base/elementary.h"

#include <float.h>

#if LDBL_MANT_DIG > DBL_MANT_DIG
static const double OWN = 0.0;
#else
static const double OWN = 1.0; /* an ulp of the yardstick */
#endif

static double ulps(double x, long double exact)
{
    const double near = (double)exact;

    return (double)(fabsl((long double)x - exact) /
                    ((long double)nextafter(fabs(near), HUGE_VAL) - fabsl((long double)near)));
}

static double any_positive(uint64_t *seed)
{
    for (;;) {
        const uint64_t u = random_bits(seed) & UINT64_C(0x7FFFFFFFFFFFFFFF);
        double x;

        memcpy(&x, &u, sizeof x);
        if (x > 0.0 && x <= DBL_MAX)
            return x;
    }
}

static void cube_root_is_within_an_ulp(void **state)
{
    uint64_t seed = 5;

    (void)state;
    for (int i = 0; i < 300000; i++) {
        const double x = i % 2 ? any_positive(&seed) : 8.0 * random_unit(&seed);

        assert_true(ulps(lcor_internal_cbrt(x), cbrtl((long double)x)) < 1.0 + OWN);
        assert_true(lcor_internal_cbrt(-x) == -lcor_internal_cbrt(x));
    }
    assert_true(ulps(lcor_internal_cbrt(5e-324), cbrtl((long double)5e-324)) < 1.0 + OWN);
    assert_true(ulps(lcor_internal_cbrt(DBL_MAX), cbrtl((long double)DBL_MAX)) < 1.0 + OWN);
    assert_true(lcor_internal_cbrt(1.0) == 1.0 && lcor_internal_cbrt(0.0) == 0.0);
    assert_true(isinf(lcor_internal_cbrt((double)INFINITY)) &&
                isnan(lcor_internal_cbrt((double)NAN)));
}

static void inverse_fifth_root_is_within_5_ulp(void **state)
{
    uint64_t seed = 11;

    (void)state;
    for (int i = 0; i < 100000; i++) {
        const double x = fmax(i % 2 ? any_positive(&seed) : 8.0 * random_unit(&seed), DBL_MIN);

        assert_true(ulps(lcor_internal_inverse_fifth_root(x), powl((long double)x, -0.2L)) <
                    5.0 + OWN);
    }
    assert_true(lcor_internal_inverse_fifth_root(1.0) == 1.0); /* white stays white */
}

static void logarithm_is_within_2_3e_16(void **state)
{
    uint64_t seed = 6;

    (void)state;
    for (int i = 0; i < 300000; i++) {
        const double x = i % 2 ? any_positive(&seed) : 1.0 + (random_unit(&seed) - 0.5) * 1e-3;
        int e;
        const double f = lcor_internal_log2_parts(x, &e);

        assert_true(f >= -0.5000001 && f <= 0.5000001);
        check_near((double)(log2l((long double)x) - (long double)e - (long double)f), 0.0,
                   2.3e-16 * (1.0 + 1000.0 * OWN), "log2");
    }
}

static void power_of_two_is_within_1_5_ulps(void **state)
{
    uint64_t seed = 7;

    (void)state;
    for (int i = 0; i < 300000; i++) {
        const double x = (random_unit(&seed) - 0.5) * (i % 2 ? 2040.0 : 2.0);

        assert_true(ulps(lcor_internal_exp2(x), exp2l((long double)x)) < 1.5 + OWN);
    }
    assert_true(lcor_internal_exp2(0.0) == 1.0 && lcor_internal_exp2(-1074.0) == 5e-324);
    assert_true(isinf(lcor_internal_exp2(1024.0)) && lcor_internal_exp2(-2000.0) == 0.0);
    assert_true(isnan(lcor_internal_exp2((double)NAN)));
}

static void power_keeps_its_bound(void **state)
{
    uint64_t seed = 8;

    (void)state;
    for (int i = 0; i < 300000; i++) {
        const double x = 4.0 * random_unit(&seed), t = 5.0 * random_unit(&seed) + 0.01;
        const double exact = (double)powl((long double)x, (long double)t);

        check_near(lcor_internal_pow(x, t), exact,
                   (1.0 + fabs(t * log2(x))) * 5e-16 * exact + 5e-324, "pow");
    }
    assert_true(lcor_internal_pow(0.0, 0.3) == 0.0 && lcor_internal_pow(0.7, 1.0) == 0.7);
    assert_true(isinf(lcor_internal_pow((double)INFINITY, 2.0)));
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(cube_root_is_within_an_ulp),
                                       cmocka_unit_test(inverse_fifth_root_is_within_5_ulp),
                                       cmocka_unit_test(logarithm_is_within_2_3e_16),
                                       cmocka_unit_test(power_of_two_is_within_1_5_ulps),
                                       cmocka_unit_test(power_keeps_its_bound)};

    return cmocka_run_group_tests(tests, NULL, NULL);
}
