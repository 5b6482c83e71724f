/* SPDX-License-Identifier: MIT */
/* The tone curve from a grey ramp. */
#include "testing.h"

#include <lcor/profile.h>

static void add(lcor_profile *profile, double level, double luminance)
{
    const lcor_profile_reading r = {.has = LCOR_HAS_RGB | LCOR_HAS_XYZ,
                                    .rgb = {level, level, level},
                                    .xyz = {0.96 * luminance, luminance, 0.82 * luminance}};
    assert_int_equal(lcor_profile_reading_add(profile, &r, NULL), LCOR_OK);
}

static lcor_profile *new_profile(void)
{
    lcor_profile *profile = NULL;
    assert_int_equal(lcor_profile_new(NULL, &profile, NULL), LCOR_OK);
    return profile;
}

/* A device with a black of 1/c and power `gamma` between. */
static double shown(double level, double contrast, double gamma)
{
    return 1.0 / contrast + (1.0 - 1.0 / contrast) * pow(level, gamma);
}

static lcor_profile *ramp(double contrast, double gamma, int steps)
{
    lcor_profile *profile = new_profile();
    for (int i = 0; i <= steps + 1; i++) {
        const double level = floor(255.0 * i / (steps + 1) + 0.5);
        add(profile, level, 90.0 * shown(level / 255.0, contrast, gamma));
    }
    return profile;
}

static double lightness(double y) { return y > 0.008856 ? 116.0 * cbrt(y) - 16.0 : 903.3 * y; }

/* What is sent for fraction f must show Jmin + (Jmax - Jmin) f: worst error in L*. */
static double worst_lightness_error(double contrast, double gamma, int steps)
{
    enum { N = 1025 };
    float curve[N];
    double worst = 0.0;
    lcor_profile *profile = ramp(contrast, gamma, steps);
    assert_int_equal(lcor_profile_grey_levels(profile), steps);
    assert_int_equal(lcor_profile_tone_curve(profile, N, curve, NULL), LCOR_OK);
    for (size_t i = 0; i < N; i++) {
        const double wanted = shown((double)i / (N - 1), contrast, 1.0);
        const double got = shown((double)curve[i], contrast, gamma);
        worst = fmax(worst, fabs(lightness(got) - lightness(wanted)));
    }
    lcor_profile_free(profile);
    return worst;
}

static void the_curve_shows_the_luminance_it_is_asked_for(void **unused)
{
    (void)unused;
    static const double contrasts[] = {6.0, 23.4, 300.0};
    static const double gammas[] = {1.0, 1.8, 2.2, 2.6};
    for (size_t c = 0; c < 3; c++)
        for (size_t g = 0; g < 4; g++) {
            const double worst = worst_lightness_error(contrasts[c], gammas[g], 14);
            print_message("c %5.1f gamma %.1f: %.3f L*\n", contrasts[c], gammas[g], worst);
            /* A linear device leaves its darkest twentieth unsampled: the worst that is met. */
            assert_true(worst < (gammas[g] > 1.5 ? 0.15 : 3.0));
        }
}

static void the_curve_goes_through_the_readings(void **unused)
{
    (void)unused;
    lcor_profile *profile = new_profile();
    add(profile, 0.0, 10.0);
    add(profile, 102.0, 30.0); /* 0.4 shows a quarter of the way */
    add(profile, 255.0, 90.0);
    float curve[5];
    assert_int_equal(lcor_profile_tone_curve(profile, 5, curve, NULL), LCOR_OK);
    check_near((double)curve[0], 0.0, 0.0, "black");
    check_near((double)curve[1], 0.4, 1e-6, "grey");
    check_near((double)curve[4], 1.0, 0.0, "white");
    assert_true(curve[1] < curve[2] && curve[2] < curve[3] && curve[3] < curve[4]);
    lcor_profile_free(profile);
}

static void noise_and_flat_ends_leave_it_monotone(void **unused)
{
    (void)unused;
    uint64_t state = 11;
    for (int trial = 0; trial < 500; trial++) {
        enum { N = 257 };
        float curve[N];
        lcor_profile *profile = new_profile();
        for (int i = 0; i <= 17; i++) { /* flat up to 3 and from 15 on, noise of 5 % */
            const double level = i < 3 ? 3.0 : i > 15 ? 15.0 : i;
            const double noise = 1.0 + 0.05 * (random_unit(&state) - 0.5);
            add(profile, 15.0 * i, noise * 90.0 * shown((level - 3.0) / 12.0, 40.0, 2.2));
        }
        assert_int_equal(lcor_profile_tone_curve(profile, N, curve, NULL), LCOR_OK);
        assert_true(curve[0] == 0.0f && curve[N - 1] == 1.0f);
        for (size_t i = 1; i < N; i++)
            assert_true(curve[i] >= curve[i - 1]);
        lcor_profile_free(profile);
    }
}

static void a_dead_zone_above_black_is_skipped(void **unused)
{
    (void)unused;
    lcor_profile *profile = new_profile();
    const double shows[] = {10.0, 10.0, 10.0, 40.0, 90.0, 90.0};
    for (int i = 0; i < 6; i++)
        add(profile, 51.0 * i, shows[i]);
    float curve[1001];
    assert_int_equal(lcor_profile_tone_curve(profile, 1001, curve, NULL), LCOR_OK);
    assert_true(curve[0] == 0.0f);
    assert_true(curve[1] > 0.4f);   /* 0, 0.2 and 0.4 all show black */
    assert_true(curve[999] < 0.8f); /* 0.8 shows white already */
    lcor_profile_free(profile);
}

static void without_a_ramp_there_is_no_curve(void **unused)
{
    (void)unused;
    float curve[9] = {42.0f};
    lcor_error err;
    lcor_profile *profile = new_profile();
    add(profile, 255.0, 90.0);
    assert_int_equal(lcor_profile_tone_curve(profile, 9, curve, &err), LCOR_ERR_DOMAIN);
    add(profile, 0.0, 10.0);
    assert_int_equal(lcor_profile_tone_curve(profile, 9, curve, &err), LCOR_ERR_DOMAIN);
    assert_non_null(strstr(err.text, "grey ramp"));
    assert_int_equal(lcor_profile_grey_levels(profile), 0);
    add(profile, 128.0, 40.0);
    assert_int_equal(lcor_profile_tone_curve(profile, 1, curve, &err), LCOR_ERR_ARG);
    assert_true(curve[0] == 42.0f);
    assert_int_equal(lcor_profile_tone_curve(profile, 9, curve, &err), LCOR_OK);
    lcor_profile_free(profile);
}

static void a_ramp_that_falls_is_refused(void **unused)
{
    (void)unused;
    float curve[9];
    lcor_error err;
    lcor_profile *profile = new_profile();
    add(profile, 0.0, 90.0);
    add(profile, 128.0, 40.0);
    add(profile, 255.0, 10.0);
    assert_int_equal(lcor_profile_tone_curve(profile, 9, curve, &err), LCOR_ERR_DOMAIN);
    assert_non_null(strstr(err.text, "rise"));
    lcor_profile_free(profile);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_curve_shows_the_luminance_it_is_asked_for),
        cmocka_unit_test(the_curve_goes_through_the_readings),
        cmocka_unit_test(noise_and_flat_ends_leave_it_monotone),
        cmocka_unit_test(a_dead_zone_above_black_is_skipped),
        cmocka_unit_test(without_a_ramp_there_is_no_curve),
        cmocka_unit_test(a_ramp_that_falls_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
