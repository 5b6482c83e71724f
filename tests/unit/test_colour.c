/* SPDX-License-Identifier: MIT */
#include "testing.h"

#include <lcor/colour.h>

static lcor_colour space(lcor_primaries primaries, lcor_transfer transfer, double gamma)
{
    lcor_colour c;
    lcor_error e;

    if (lcor_colour_init(&c, primaries, NULL, transfer, gamma, LCOR_LIGHTNESS_CIE, &e) != LCOR_OK)
        fail_msg("%s", e.text);
    return c;
}

static void white_of_each_space_is_l_100_and_grey(void **state)
{
    (void)state;
    for (int p = 0; p < 2; p++) {
        const lcor_colour c = space((lcor_primaries)p, LCOR_TRANSFER_SRGB, 1.0);
        const double white[3] = {1.0, 1.0, 1.0};
        double lab[3];

        lcor_lab_from_rgb_row_f64(&c, 1, white, lab);
        check_near(lab[0], 100.0, 1e-12, "L");
        check_near(lab[1], 0.0, 1e-12, "a");
        check_near(lab[2], 0.0, 1e-12, "b");
    }
    {
        const lcor_colour c = space(LCOR_PRIMARIES_SRGB, LCOR_TRANSFER_SRGB, 1.0);

        check_near(c.white[0], 0.3127 / 0.3290, 1e-15, "D65 X");
        check_near(c.white[2], (1.0 - 0.3127 - 0.3290) / 0.3290, 1e-15, "D65 Z");
    }
}

static void transfer_functions_are_inverse_odd_and_known(void **state)
{
    (void)state;
    for (int t = 0; t < 3; t++) {
        const lcor_colour c = space(LCOR_PRIMARIES_NTSC, (lcor_transfer)t, 2.2);

        for (int i = -300; i <= 300; i++) {
            const double v = i / 200.0, linear = lcor_transfer_to_linear(&c, v);

            check_near(lcor_transfer_from_linear(&c, linear), v, 1e-14, "round trip");
            check_near(lcor_transfer_to_linear(&c, -v), -linear, 0.0, "odd");
            if (t == LCOR_TRANSFER_GAMMA)
                check_near(fabs(linear), pow(fabs(v), 2.2), 1e-15, "gamma");
        }
    }
    {
        const lcor_colour c = space(LCOR_PRIMARIES_SRGB, LCOR_TRANSFER_SRGB, 1.0);

        check_near(lcor_transfer_to_linear(&c, 0.5), 0.21404114048223255, 1e-15, "IEC 61966-2-1");
    }
}

static void custom_matrix_is_used_and_inverted(void **state)
{
    const double matrix[9] = {0.5, 0.2, 0.1, 0.25, 0.7, 0.05, 0.0, 0.1, 0.8};
    const double rgb[3] = {0.2, 0.4, 0.9};
    lcor_colour c;
    double xyz[3], back[3];

    (void)state;
    assert_int_equal(lcor_colour_init(&c, LCOR_PRIMARIES_CUSTOM, matrix, LCOR_TRANSFER_LINEAR, 1.0,
                                      LCOR_LIGHTNESS_CIE, NULL),
                     LCOR_OK);
    check_near(c.white[0], 0.8, 1e-15, "white");
    lcor_xyz_from_rgb(&c, rgb, xyz);
    check_near(xyz[0], 0.5 * 0.2 + 0.2 * 0.4 + 0.1 * 0.9, 1e-15, "X");
    lcor_rgb_from_xyz(&c, xyz, back);
    for (int i = 0; i < 3; i++)
        check_near(back[i], rgb[i], 1e-15, "back");
}

static void nonsense_is_refused_and_leaves_the_space_alone(void **state)
{
    const double singular[9] = {1, 2, 3, 2, 4, 6, 1, 1, 1};
    const double no_white[9] = {1, 0, 0, 0, 1, -1, 0, 0, 1};
    const double nan_in[9] = {(double)NAN, 0, 0, 0, 1, 0, 0, 0, 1};
    lcor_colour c = space(LCOR_PRIMARIES_NTSC, LCOR_TRANSFER_LINEAR, 1.0);
    const lcor_colour before = c;
    lcor_error e;

    (void)state;
#define REFUSED(code, p, m, t, g, l)                                                               \
    do {                                                                                           \
        assert_int_equal(lcor_colour_init(&c, (lcor_primaries)(p), m, (lcor_transfer)(t), g,       \
                                          (lcor_lightness)(l), &e),                                \
                         code);                                                                    \
        assert_int_equal(e.status, code);                                                          \
        assert_true(strlen(e.text) > 10);                                                          \
    } while (0)
    REFUSED(LCOR_ERR_DOMAIN, 2, singular, 0, 1.0, 0);
    REFUSED(LCOR_ERR_DOMAIN, 2, no_white, 0, 1.0, 0);
    REFUSED(LCOR_ERR_DOMAIN, 2, nan_in, 0, 1.0, 0);
    REFUSED(LCOR_ERR_ARG, 2, NULL, 0, 1.0, 0);
    REFUSED(LCOR_ERR_ARG, 0, singular, 0, 1.0, 0);
    REFUSED(LCOR_ERR_ARG, 3, NULL, 0, 1.0, 0);
    REFUSED(LCOR_ERR_ARG, 0, NULL, 3, 1.0, 0);
    REFUSED(LCOR_ERR_ARG, 0, NULL, 0, 1.0, 2);
    REFUSED(LCOR_ERR_DOMAIN, 0, NULL, 2, 0.0, 0);
    REFUSED(LCOR_ERR_DOMAIN, 0, NULL, 2, (double)NAN, 0);
#undef REFUSED
    assert_int_equal(lcor_colour_init(NULL, LCOR_PRIMARIES_NTSC, NULL, LCOR_TRANSFER_LINEAR, 1.0,
                                      LCOR_LIGHTNESS_CIE, NULL),
                     LCOR_ERR_ARG);
    assert_memory_equal(&c, &before, sizeof c);
}

static void rows_work_in_place_and_in_float(void **state)
{
    const lcor_colour c = space(LCOR_PRIMARIES_SRGB, LCOR_TRANSFER_SRGB, 1.0);
    double rgb[30], lab[30];
    float rgb32[30], lab32[30];
    uint64_t seed = 3;

    (void)state;
    for (int i = 0; i < 30; i++) {
        rgb32[i] = (float)random_unit(&seed);
        rgb[i] = (double)rgb32[i];
    }
    lcor_lab_from_rgb_row_f64(&c, 10, rgb, lab);
    lcor_lab_from_rgb_row_f32(&c, 10, rgb32, lab32);
    for (int i = 0; i < 30; i++)
        assert_true(lab32[i] == (float)lab[i]);
    lcor_rgb_from_lab_row_f64(&c, 10, lab, lab);
    lcor_rgb_from_lab_row_f32(&c, 10, lab32, lab32);
    for (int i = 0; i < 30; i++) {
        check_near(lab[i], rgb[i], 1e-13, "back");
        check_near((double)lab32[i], rgb[i], 1e-5, "back in float");
    }
}

static void grey_has_hue_0(void **state)
{
    const double grey[3] = {50.0, 0.0, -0.0}, green[3] = {50.0, -3.0, 4.0};

    (void)state;
    assert_true(lcor_hue(grey) == 0.0);
    assert_true(lcor_chroma(grey) == 0.0);
    check_near(lcor_chroma(green), 5.0, 1e-15, "chroma");
    check_near(lcor_hue(green), 3.14159265358979324 - atan(4.0 / 3.0), 1e-15, "hue");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(white_of_each_space_is_l_100_and_grey),
        cmocka_unit_test(transfer_functions_are_inverse_odd_and_known),
        cmocka_unit_test(custom_matrix_is_used_and_inverted),
        cmocka_unit_test(nonsense_is_refused_and_leaves_the_space_alone),
        cmocka_unit_test(rows_work_in_place_and_in_float),
        cmocka_unit_test(grey_has_hue_0)};

    return cmocka_run_group_tests(tests, NULL, NULL);
}
