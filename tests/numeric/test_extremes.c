/* SPDX-License-Identifier: MIT */
/* The rules S1-S10 at and around their singular points, one test a rule. */
#include "planning.h"

static const double TINY = 4.9406564584124654e-324;

/* One pixel in double; checks that RGB is defined and in gamut. */
static void correct(const lcor_plan_options *o, const double rgb[3], double light, double out[3])
{
    lcor_plan *plan = make_plan(o);

    lcor_correct_row(plan, 0, 1, rgb, &light, NULL, out, NULL);
    for (int k = 0; k < 3; k++)
        assert_true(out[k] >= 0.0 && out[k] <= 1.0);
    lcor_plan_free(plan);
}

static double luminance(const double rgb[3])
{
    return 0.2988 * rgb[0] + 0.5868 * rgb[1] + 0.1144 * rgb[2];
}

static const double PINK[3] = {250 / 255.0, 50 / 255.0, 150 / 255.0}; /* the paper's colour */

static void s1_negative_beta_gives_black_continuously(void **state)
{
    lcor_plan_options o = plain_options(LCOR_F64);
    const double q1 = 2.0 / (o.contrast + 1.0); /* T = 0 */
    double out[3];

    (void)state;
    correct(&o, PINK, q1 * (1.0 - 1e-12), out);
    assert_true(out[0] == 0.0 && out[1] == 0.0 && out[2] == 0.0);
    correct(&o, PINK, q1 * (1.0 + 1e-12), out);
    assert_true(luminance(out) > 0.0 && luminance(out) < 1e-11);
    correct(&o, PINK, 0.0, out);
    assert_true(luminance(out) == 0.0);
}

static void s2_no_reflectance_is_black_not_a_division(void **state)
{
    const double rhos[] = {0.0, TINY, 1e-300, 1e-12, 1.0};

    (void)state;
    for (size_t i = 0; i < 5; i++)
        for (int k = 0; k < 2; k++) {
            lcor_plan_options o = plain_options(k ? LCOR_F32 : LCOR_F64);
            const float rgb32[3] = {0.9f, 0.2f, 0.6f}, light32 = 0.3f, rho32 = (float)rhos[i];
            const double rgb[3] = {0.9, 0.2, 0.6}, light = 0.3;
            double out[3];
            float out32[3];
            lcor_row_stats stats = {0};
            lcor_plan *plan = make_plan(&o);

            if (k) {
                lcor_correct_row(plan, 0, 1, rgb32, &light32, &rho32, out32, &stats);
                for (int c = 0; c < 3; c++)
                    out[c] = (double)out32[c];
            } else {
                lcor_correct_row(plan, 0, 1, rgb, &light, rhos + i, out, &stats);
            }
            assert_int_equal(stats.non_finite, 0);
            assert_true(rhos[i] > 0.5 ? luminance(out) > 0.01 : luminance(out) == 0.0);
            lcor_plan_free(plan);
        }
}

static void s2_rho_from_0_to_1_follows_eq_11(void **state)
{
    const double y = luminance(PINK);

    (void)state;
    for (int i = 0; i <= 120; i++) {
        const double rho = i < 60 ? pow(10.0, i / 5.0 - 12.0) : (i - 59) / 61.0;
        const double q = 0.3 + i / 100.0;
        lcor_plan_options o = plain_options(LCOR_F64);
        const double light = q * o.r_mean / rho,
                     t = lcor_internal_display(q, 1.0, 0.5 + 1.0 / 22.4);
        const float light32 = (float)light, rho32 = (float)rho;
        const float rgb32[3] = {(float)PINK[0], (float)PINK[1], (float)PINK[2]};
        double out[3];
        float out32[3];
        lcor_plan *plan = make_plan(&o);

        lcor_correct_row(plan, 0, 1, PINK, &light, &rho, out, NULL);
        check_near(luminance(out), fmin(t * y / rho, 1.0), 1e-14, "double");
        lcor_plan_free(plan);
        o = plain_options(LCOR_F32);
        plan = make_plan(&o);
        lcor_correct_row(plan, 0, 1, rgb32, &light32, &rho32, out32, NULL);
        for (int k = 0; k < 3; k++)
            out[k] = (double)out32[k];
        check_near(luminance(out), fmin(t * y / rho, 1.0), 1e-6, "float");
        lcor_plan_free(plan);
    }
}

static void s3_all_dark_images_come_out_black(void **state)
{
    (void)state;
    for (int k = 0; k < 4; k++) {
        lcor_plan_options o = plain_options(k & 1 ? LCOR_F32 : LCOR_F64);
        const float rgb32[3] = {1.0f, 0.5f, 0.0f}, light32[2] = {0.0f, 5.0f};
        const double rgb[3] = {1.0, 0.5, 0.0}, light[2] = {0.0, 5.0};
        lcor_plan *plan;

        o.r_mean = 0.0; /* what the mean of an unlit picture is */
        if (k & 2)
            o.contrast = (double)INFINITY;
        plan = make_plan(&o);
        for (int i = 0; i < 2; i++) {
            double out[3] = {1, 1, 1};
            float out32[3] = {1, 1, 1};

            if (k & 1)
                lcor_correct_row(plan, 0, 1, rgb32, light32 + i, NULL, out32, NULL);
            else
                lcor_correct_row(plan, 0, 1, rgb, light + i, NULL, out, NULL);
            assert_true(k & 1 ? out32[0] == 0.0f && out32[1] == 0.0f : luminance(out) == 0.0);
        }
        lcor_plan_free(plan);
    }
}

static void s4_q_from_1e_300_to_1e300_is_clamped(void **state)
{
    (void)state;
    for (int e = -300; e <= 300; e += 25) {
        lcor_plan_options o = plain_options(LCOR_F64);
        const double light = pow(10.0, e);
        const float light32 = e < -38 ? 0.0f : e > 38 ? 3e38f : (float)light;
        const float rgb32[3] = {0.9f, 0.2f, 0.6f};
        double out[3];
        float out32[3];
        lcor_plan *plan;

        o.r_mean = o.rho; /* q = light */
        correct(&o, PINK, light, out);
        check_near(luminance(out),
                   e < 0   ? 0.0
                   : e > 0 ? 1.0
                           : luminance(PINK) / 0.35 * 0.5,
                   1e-12, "clamped");
        o.r_mean = o.rho * 1e-300; /* q overflows */
        correct(&o, PINK, light, out);
        o.r_mean = 0.35;
        o.in_type = o.out_type = o.map_type = LCOR_F32;
        plan = make_plan(&o);
        lcor_correct_row(plan, 0, 1, rgb32, &light32, NULL, out32, NULL);
        for (int k = 0; k < 3; k++)
            assert_true(out32[k] == (e < 0 ? 0.0f : 1.0f) || e == 0);
        lcor_plan_free(plan);
    }
}

static void s5_chroma_factor_is_tame_around_l_0_and_8(void **state)
{
    const double lightness[] = {0.0, TINY, 1e-300, 1e-30, 1e-9, 7.999999, 8.0, 8.000001};

    (void)state;
    for (size_t i = 0; i < 8; i++)
        for (size_t j = 0; j < 8; j++) {
            const double y = lightness[i] * 27.0 / 24389.0, y_new = lightness[j] * 27.0 / 24389.0;
            const double k = lcor_internal_chroma_factor(y, y_new);

            assert_true(k >= 0.0 && k <= 1.0);
            if (y_new <= y && y > 1e-15) /* L*new / L*, straight line below 8 */
                check_near(k, y_new / y, 1e-6 + 2e-16 / y, "k");
        }
    check_near(lcor_internal_chroma_factor(0.0, 0.0), 1.0, 0.0, "black stays as it is");
}

static void s6_chroma_factor_is_tame_around_l_100(void **state)
{
    const double y[] = {1.0 - 1e-9, 1.0 - 1.2e-16, 1.0, 1.0 + 2.3e-16, 1.0 + 1e-9, 1.5};

    (void)state;
    for (size_t i = 0; i < 6; i++) {
        assert_true(lcor_internal_chroma_factor(y[i], 1.0) >= 0.0);
        assert_true(lcor_internal_chroma_factor(y[i], 1.0) <= 1.0);
        check_near(lcor_internal_chroma_factor(y[i], 0.0), 0.0, 0.0, "to black");
    }
    check_near(lcor_internal_chroma_factor(1.0, 1.0), 1.0, 0.0, "white stays white");
}

static void s7_saturation_comes_only_at_white(void **state)
{
    lcor_plan_options o = plain_options(LCOR_F64);
    double out[3], last = 2.0;

    (void)state;
    for (double light = 1.0; light < 6.0; light += 0.01) {
        double spread;

        correct(&o, PINK, light, out);
        spread = fmax(out[0], fmax(out[1], out[2])) - fmin(out[0], fmin(out[1], out[2]));
        assert_true(spread <= last + 1e-12);
        last = spread;
    }
    assert_true(out[0] == 1.0 && out[1] == 1.0 && out[2] == 1.0);
}

/* Whatever the texel, even beyond white: its own luminance and chroma play no part. */
static void s7_light_above_the_end_is_exactly_white(void **state)
{
    static const float texels[][3] = {
        {1, 1, 1},    {1, 0, 0},       {0, 1, 0},     {0, 0, 1},    {1, 1, 0},
        {2, 0.6f, 0}, {0.9f, 1.1f, 1}, {1e-3f, 0, 0}, {1e6f, 1, 0}, {1, 1.0000001f, 0.9999999f}};

    (void)state;
    for (size_t i = 0; i < 10; i++)
        for (int g = 0; g < 2; g++) {
            lcor_plan_options o = plain_options(LCOR_F32);
            const float light = 1e9f;
            float out[3];
            lcor_plan *plan;

            o.gamut = g == 0 ? LCOR_GAMUT_KEEP_HUE : LCOR_GAMUT_CLIP;
            plan = make_plan(&o);
            lcor_correct_row(plan, 0, 1, texels[i], &light, NULL, out, NULL);
            for (int k = 0; k < 3; k++)
                assert_true(out[k] == 1.0f);
            lcor_plan_free(plan);
        }
}

static void s8_contrast_from_1_to_infinity(void **state)
{
    const double contrasts[] = {1.0 + 2.3e-16, 1.0 + 1e-9, 1.0 + 1e-6, 1.1,   2.0,
                                23.4,          1e6,        1e12,       1e308, (double)INFINITY};

    (void)state;
    for (size_t i = 0; i < 10; i++)
        for (int k = 0; k < 4; k++) {
            lcor_plan_options o = plain_options(k & 1 ? LCOR_F32 : LCOR_F64);
            const float grey32[3] = {0.25f, 0.25f, 0.25f};
            const double grey[3] = {0.25, 0.25, 0.25};
            double y;
            lcor_plan *plan;

            o.contrast = contrasts[i];
            o.reading = k & 2 ? LCOR_READING_TEXEL : LCOR_READING_PATCH;
            o.rho = 0.25; /* so that both readings agree */
            o.r_mean = 0.25;
            plan = make_plan(&o);
            /* at the mean every contrast shows the middle; far from it black or white */
            for (int side = -1; side <= 1; side++) {
                const double light = side < 0 ? 1e-6 : side > 0 ? 4.0 : 1.0;
                const float light32 = (float)light;
                double out[3];
                float out32[3];

                if (k & 1)
                    lcor_correct_row(plan, 0, 1, grey32, &light32, NULL, out32, NULL);
                else
                    lcor_correct_row(plan, 0, 1, grey, &light, NULL, out, NULL);
                y = k & 1 ? (double)out32[1] : out[1];
                if (side < 0 && contrasts[i] > 1e5) /* such a device shows even that */
                    check_near(y, 5e-7, 5e-7, "faint");
                else
                    check_near(y, 0.5 + 0.5 * side, k & 1 ? 2e-6 : 1e-14, "Ynew");
            }
            lcor_plan_free(plan);
        }
}

static void s8_follows_the_stable_form_at_contrast_1_plus_1e_9(void **state)
{
    const double c = 1.000000001, gain = 0.5 * (1.0 + 2.0 / (c - 1.0));

    (void)state;
    for (int i = -40; i <= 40; i++) {
        const double q = 1.0 + i * 2.220446049250313e-16 * 50000.0; /* exact */
        const double exact = 0.5 + (double)i * (2.220446049250313e-16 * 50000.0) * gain;

        check_near(lcor_internal_display(q, 1.0, gain), exact, 2.3e-16, "T");
    }
}

static void s10_subnormal_numbers_are_numbers(void **state)
{
    const double inputs[] = {TINY, 1e-310, 2.3e-308};
    const float inputs32[] = {1e-45f, 1e-40f, 1.2e-38f};

    (void)state;
    for (int i = 0; i < 3; i++) {
        lcor_plan_options o = plain_options(LCOR_F64);
        const double rgb[3] = {inputs[i], inputs[i], 0.0};
        const float rgb32[3] = {inputs32[i], inputs32[i], 0.0f}, light32 = 1.0f;
        float out32[3];
        double out[3];
        lcor_row_stats stats = {0};
        lcor_plan *plan;

        correct(&o, rgb, 1.0, out);
        assert_true(luminance(out) < 1e-300);
        correct(&o, PINK, inputs[i], out);
        assert_true(luminance(out) == 0.0);
        o = plain_options(LCOR_F32);
        plan = make_plan(&o);
        lcor_correct_row(plan, 0, 1, rgb32, &light32, NULL, out32, &stats);
        assert_true(out32[0] < 1e-30f && out32[1] < 1e-30f && out32[2] < 1e-30f);
        assert_int_equal(stats.non_finite, 0);
        lcor_plan_free(plan);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(s1_negative_beta_gives_black_continuously),
        cmocka_unit_test(s2_no_reflectance_is_black_not_a_division),
        cmocka_unit_test(s2_rho_from_0_to_1_follows_eq_11),
        cmocka_unit_test(s3_all_dark_images_come_out_black),
        cmocka_unit_test(s4_q_from_1e_300_to_1e300_is_clamped),
        cmocka_unit_test(s5_chroma_factor_is_tame_around_l_0_and_8),
        cmocka_unit_test(s6_chroma_factor_is_tame_around_l_100),
        cmocka_unit_test(s7_saturation_comes_only_at_white),
        cmocka_unit_test(s7_light_above_the_end_is_exactly_white),
        cmocka_unit_test(s8_contrast_from_1_to_infinity),
        cmocka_unit_test(s8_follows_the_stable_form_at_contrast_1_plus_1e_9),
        cmocka_unit_test(s10_subnormal_numbers_are_numbers)};

    return cmocka_run_group_tests(tests, NULL, NULL);
}
