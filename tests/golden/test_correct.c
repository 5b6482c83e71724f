/* SPDX-License-Identifier: MIT */
/* Pixels and images of the correction against 50-digit vectors, through the public calls. */
#include "testing.h"

#include "correct/internal.h"
#include <lcor/adapt.h>
#include <lcor/correct.h>

static lcor_plan *plan_of(double contrast, double r_mean, double rho, lcor_reading reading,
                          lcor_gamut gamut, lcor_lightness lightness)
{
    lcor_plan_options o;
    lcor_colour colour;
    lcor_plan *plan = NULL;
    lcor_error e;

    assert_int_equal(lcor_colour_init(&colour, LCOR_PRIMARIES_NTSC, NULL, LCOR_TRANSFER_LINEAR, 1.0,
                                      lightness, NULL),
                     LCOR_OK);
    memset(&o, 0, sizeof o);
    o.struct_size = sizeof o;
    o.contrast = contrast;
    o.r_mean = r_mean;
    o.rho = rho;
    o.reading = reading;
    o.gamut = gamut;
    o.colour = &colour;
    o.in_type = o.out_type = o.map_type = LCOR_F64;
    if (lcor_plan_new(&o, &plan, &e) != LCOR_OK)
        fail_msg("%s", e.text);
    return plan;
}

static void beta_and_k_are_golden(void **state)
{
    csv t = csv_read(LCOR_TEST_DATA "/golden/beta_k.csv");

    (void)state;
    for (size_t i = 0; i < t.rows; i++) {
        const double c = csv_number(&t, i, "c");
        const double r = csv_number(&t, i, "r"), r_mean = csv_number(&t, i, "rbar");
        const double y = csv_number(&t, i, "y"), ynew = csv_number(&t, i, "Ynew");
        const double gain = 0.5 * (1.0 + 2.0 / (c - 1.0)), q = r / r_mean;
        const double t_display = lcor_internal_display(q, 1.0, gain);
        /* q itself is rounded: half an ulp of it is gain times that of T */
        const double slack = 1e-13 + gain * q * 2.3e-16;

        check_near(t_display, csv_number(&t, i, "T_unclamped"), 1e-14 * fabs(t_display) + slack,
                   "T");
        check_near(lcor_internal_chroma_factor(y, ynew), csv_number(&t, i, "k"), 3e-9, "k");
    }
    csv_free(&t);
}

static void check_pixels(const char *path, lcor_lightness lightness)
{
    csv t = csv_read(path);

    for (size_t i = 0; i < t.rows; i++) {
        const double rgb[3] = {csv_number(&t, i, "R"), csv_number(&t, i, "G"),
                               csv_number(&t, i, "B")};
        const double alpha = csv_number(&t, i, "alpha");
        const char *fin[3] = {"Rfin", "Gfin", "Bfin"}, *raw[3] = {"Rnew", "Gnew", "Bnew"};

        for (int g = 0; g < 2; g++) {
            lcor_row_stats stats = {0};
            double out[3];
            lcor_plan *plan = plan_of(
                csv_number(&t, i, "c"), csv_number(&t, i, "rbar"), csv_number(&t, i, "rho"),
                *csv_text(&t, i, "reading") == 'A' ? LCOR_READING_PATCH : LCOR_READING_TEXEL,
                g == 0 ? LCOR_GAMUT_KEEP_HUE : LCOR_GAMUT_CLIP, lightness);

            lcor_correct_row(plan, 0, 1, rgb, &alpha, NULL, out, &stats);
            for (int k = 0; k < 3; k++)
                if (g == 0)
                    check_near(out[k], csv_number(&t, i, fin[k]), 1e-13, fin[k]);
                else
                    check_near(out[k], fmin(fmax(csv_number(&t, i, raw[k]), 0.0), 1.0), 1e-13,
                               raw[k]);
            if (csv_number(&t, i, "gamut_s") < 1.0 - 1e-9)
                assert_int_equal(stats.out_of_gamut, 1);
            assert_int_equal(stats.clipped_low, csv_number(&t, i, "T_unclamped") < 0.0);
            assert_int_equal(stats.clipped_high, csv_number(&t, i, "T_unclamped") > 1.0);
            lcor_plan_free(plan);
        }
    }
    assert_true(t.rows > 1000);
    csv_free(&t);
}

static void pixels_are_golden(void **state)
{
    (void)state;
    check_pixels(LCOR_TEST_DATA "/golden/pixel_cie.csv", LCOR_LIGHTNESS_CIE);
    check_pixels(LCOR_TEST_DATA "/golden/pixel_paper.csv", LCOR_LIGHTNESS_PAPER);
}

static void check_image(const csv *scalars, size_t s)
{
    const char *reading = csv_text(scalars, s, "reading");
    const double i_max = csv_number(scalars, s, "Imax");
    char path[512];
    csv t;
    lcor_plan *plan;
    double rgb[3 * 256], light[256], out[3 * 256], eq19[3 * 256];
    const char *in[3] = {"R", "G", "B"}, *fin[3] = {"Rfin", "Gfin", "Bfin"};
    const char *conventional[3] = {"Reqn19", "Geqn19", "Beqn19"};

    snprintf(path, sizeof path, LCOR_TEST_DATA "/golden/image_%s_%s.csv",
             csv_text(scalars, s, "scene"), reading);
    t = csv_read(path);
    assert_int_equal(t.rows, 256);
    /* r_mean in the unit of illuminance: Imax of eq 7 cancels */
    plan = plan_of(csv_number(scalars, s, "c"), csv_number(scalars, s, "rbar") * i_max,
                   csv_number(scalars, s, "rho_mean"),
                   *reading == 'A' ? LCOR_READING_PATCH : LCOR_READING_TEXEL, LCOR_GAMUT_KEEP_HUE,
                   LCOR_LIGHTNESS_CIE);
    for (size_t i = 0; i < 256; i++) {
        light[i] = csv_number(&t, i, "I");
        for (size_t k = 0; k < 3; k++)
            rgb[3 * i + k] = csv_number(&t, i, in[k]);
    }
    lcor_correct_row(plan, 0, 256, rgb, light, NULL, out, NULL);
    lcor_conventional_row(plan, 0, 256, rgb, light, NULL, eq19, NULL);
    for (size_t i = 0; i < 256; i++)
        for (size_t k = 0; k < 3; k++) {
            check_near(out[3 * i + k], csv_number(&t, i, fin[k]), 1e-13, fin[k]);
            check_near(eq19[3 * i + k], csv_number(&t, i, conventional[k]), 1e-13, conventional[k]);
        }
    {
        double r[256], m;

        lcor_plan_reflectance_row(plan, 256, rgb, light, NULL, r);
        assert_int_equal(lcor_geometric_mean(256, r, NULL,
                                             strcmp(csv_text(scalars, s, "mean"), "adaptive10") == 0
                                                 ? LCOR_MEAN_ADAPTIVE
                                                 : LCOR_MEAN_LITERAL,
                                             &m, NULL),
                         LCOR_OK);
        check_near(m / i_max, csv_number(scalars, s, "rbar"), 1e-14, "rbar");
    }
    lcor_plan_free(plan);
    csv_free(&t);
}

static void images_are_golden(void **state)
{
    csv scalars = csv_read(LCOR_TEST_DATA "/golden/image_scalars.csv");

    (void)state;
    assert_int_equal(scalars.rows, 8);
    for (size_t s = 0; s < scalars.rows; s++)
        check_image(&scalars, s);
    csv_free(&scalars);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(beta_and_k_are_golden),
                                       cmocka_unit_test(pixels_are_golden),
                                       cmocka_unit_test(images_are_golden)};

    return cmocka_run_group_tests(tests, NULL, NULL);
}
