/* SPDX-License-Identifier: MIT */
/* RGB, XYZ, L*a*b* against 50-digit vectors. */
#include "testing.h"

#include <lcor/colour.h>

static void space(lcor_colour *c, lcor_lightness lightness)
{
    assert_int_equal(
        lcor_colour_init(c, LCOR_PRIMARIES_NTSC, NULL, LCOR_TRANSFER_LINEAR, 1.0, lightness, NULL),
        LCOR_OK);
}

static void forward(const char *path, lcor_lightness lightness)
{
    csv t = csv_read(path);
    lcor_colour colour;

    space(&colour, lightness);
    for (size_t i = 0; i < t.rows; i++) {
        const double rgb[3] = {csv_number(&t, i, "R"), csv_number(&t, i, "G"),
                               csv_number(&t, i, "B")};
        const double chroma = csv_number(&t, i, "chroma");
        double xyz[3], lab[3], turn;

        lcor_xyz_from_rgb(&colour, rgb, xyz);
        check_near(xyz[0], csv_number(&t, i, "X"), 1e-13, "X");
        check_near(xyz[1], csv_number(&t, i, "Y"), 1e-13, "Y");
        check_near(xyz[2], csv_number(&t, i, "Z"), 1e-13, "Z");
        lcor_lab_from_xyz(&colour, xyz, lab);
        check_near(lab[0], csv_number(&t, i, "L"), 1e-10, "L");
        check_near(lab[1], csv_number(&t, i, "a"), 1e-10, "a");
        check_near(lab[2], csv_number(&t, i, "b"), 1e-10, "b");
        check_near(lcor_chroma(lab), chroma, 1e-10, "chroma");
        turn = fabs(lcor_hue(lab) * (180.0 / 3.14159265358979324) - csv_number(&t, i, "hue_deg"));
        if (chroma > 1e-6)
            check_near(fmin(turn, fabs(turn - 360.0)), 0.0, 1e-10 / chroma * 60.0, "hue");
    }
    assert_true(t.rows > 1000);
    csv_free(&t);
}

static void inverse(const char *path, lcor_lightness lightness)
{
    csv t = csv_read(path);
    lcor_colour colour;

    space(&colour, lightness);
    for (size_t i = 0; i < t.rows; i++) {
        const double lab[3] = {csv_number(&t, i, "L"), csv_number(&t, i, "a"),
                               csv_number(&t, i, "b")};
        double xyz[3], rgb[3];

        lcor_xyz_from_lab(&colour, lab, xyz);
        check_near(xyz[0], csv_number(&t, i, "X"), 1e-13, "X");
        check_near(xyz[1], csv_number(&t, i, "Y"), 1e-13, "Y");
        check_near(xyz[2], csv_number(&t, i, "Z"), 1e-13, "Z");
        lcor_rgb_from_lab_row_f64(&colour, 1, lab, rgb);
        check_near(rgb[0], csv_number(&t, i, "R"), 1e-13, "R");
        check_near(rgb[1], csv_number(&t, i, "G"), 1e-13, "G");
        check_near(rgb[2], csv_number(&t, i, "B"), 1e-13, "B");
    }
    assert_true(t.rows > 500);
    csv_free(&t);
}

static void lab_from_rgb_is_golden(void **state)
{
    (void)state;
    forward(LCOR_TEST_DATA "/golden/rgb_to_lab_cie.csv", LCOR_LIGHTNESS_CIE);
    forward(LCOR_TEST_DATA "/golden/rgb_to_lab_paper.csv", LCOR_LIGHTNESS_PAPER);
}

static void rgb_from_lab_is_golden(void **state)
{
    (void)state;
    inverse(LCOR_TEST_DATA "/golden/lab_to_rgb_cie.csv", LCOR_LIGHTNESS_CIE);
    inverse(LCOR_TEST_DATA "/golden/lab_to_rgb_paper.csv", LCOR_LIGHTNESS_PAPER);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(lab_from_rgb_is_golden),
                                       cmocka_unit_test(rgb_from_lab_is_golden)};

    return cmocka_run_group_tests(tests, NULL, NULL);
}
