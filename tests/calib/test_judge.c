/* SPDX-License-Identifier: MIT */
#include "session/judge.h"
#include "testing.h"

static void median_does_not_depend_on_the_order(void **state)
{
    (void)state;
    const double odd[] = {3.0, 1.0, 2.0}, even[] = {4.0, 1.0, 3.0, 2.0};
    check_near(judge_median(odd, 3), 2.0, 0.0, "odd");
    check_near(judge_median(even, 4), 2.5, 0.0, "even");
    check_near(judge_median(odd, 1), 3.0, 0.0, "one");
    assert_true(isnan(judge_median(odd, 0)));
}

static verdict judge(size_t n, const double *values, bool *accepted)
{
    return judge_patch(values, n, accepted);
}

static void quiet_readings_all_count(void **state)
{
    (void)state;
    bool ok[5];
    assert_int_equal(judge(5, (const double[]){0.07, 0.08, 0.07, 0.06, 0.07}, ok), VERDICT_GOOD);
    for (int i = 0; i < 5; i++)
        assert_true(ok[i]);
}

static void an_outlier_is_left_out(void **state)
{
    (void)state;
    bool ok[5];
    assert_int_equal(judge(5, (const double[]){0.07, 0.07, 0.18, 0.07, 0.07}, ok), VERDICT_GOOD);
    assert_true(ok[0] && ok[1] && !ok[2] && ok[3] && ok[4]);
}

static void readings_of_two_patches_are_mixed(void **state)
{
    (void)state;
    bool ok[5];
    assert_int_equal(judge(5, (const double[]){0.07, 0.07, 1.44, 0.07, 0.07}, ok), VERDICT_MIXED);
    assert_int_equal(judge(2, (const double[]){0.07, 1.44}, ok), VERDICT_MIXED);
}

static void a_steady_drift_is_no_patch(void **state)
{
    (void)state;
    bool ok[5];
    assert_int_equal(judge(5, (const double[]){0.07, 0.09, 0.11, 0.13, 0.15}, ok),
                     VERDICT_DRIFTING);
    assert_int_equal(judge(5, (const double[]){0.15, 0.13, 0.11, 0.09, 0.07}, ok),
                     VERDICT_DRIFTING);
    /* Up and down is scatter, and a drift of the last digit is none. */
    assert_int_equal(judge(5, (const double[]){0.07, 0.11, 0.09, 0.13, 0.10}, ok), VERDICT_GOOD);
    assert_int_equal(judge(5, (const double[]){0.07, 0.08, 0.09, 0.10, 0.11}, ok), VERDICT_GOOD);
}

static void one_reading_is_a_patch_and_none_is_not(void **state)
{
    (void)state;
    bool ok[1] = {false};
    assert_int_equal(judge(1, (const double[]){0.07}, ok), VERDICT_GOOD);
    assert_true(ok[0]);
    assert_int_equal(judge(0, (const double[]){0.07}, ok), VERDICT_TOO_FEW);
}

static void two_patches_that_look_alike_are_one(void **state)
{
    (void)state;
    assert_int_equal(judge_pair(0.07, 0.07), VERDICT_EQUAL);
    assert_int_equal(judge_pair(0.07, 0.17), VERDICT_EQUAL);
    assert_int_equal(judge_pair(0.07, 0.18), VERDICT_GOOD);
    assert_int_equal(judge_pair(1.44, 0.07), VERDICT_GOOD);
    assert_int_equal(judge_pair((double)NAN, 0.07), VERDICT_EQUAL);
}

static void densities_of_paper_and_film_are_plausible(void **state)
{
    (void)state;
    assert_true(judge_plausible(-0.10) && judge_plausible(0.0) && judge_plausible(6.0));
    assert_false(judge_plausible(-0.11) || judge_plausible(6.01) || judge_plausible(137.0));
    assert_false(judge_plausible((double)NAN));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(median_does_not_depend_on_the_order),
        cmocka_unit_test(quiet_readings_all_count),
        cmocka_unit_test(an_outlier_is_left_out),
        cmocka_unit_test(readings_of_two_patches_are_mixed),
        cmocka_unit_test(a_steady_drift_is_no_patch),
        cmocka_unit_test(one_reading_is_a_patch_and_none_is_not),
        cmocka_unit_test(two_patches_that_look_alike_are_one),
        cmocka_unit_test(densities_of_paper_and_film_are_plausible),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
