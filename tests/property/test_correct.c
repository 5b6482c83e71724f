/* SPDX-License-Identifier: MIT */
/* What must hold for every colour and every light. */
#include "planning.h"

#include <lcor/adapt.h>

enum { N = 4000 };

static double rgb[3 * N], light[N], out[3 * N];
static float rgb32[3 * N], light32[N], out32[3 * N];

static void fill(uint64_t seed)
{
    for (size_t i = 0; i < 3 * N; i++) {
        rgb32[i] = (float)random_unit(&seed);
        if (i % 7 == 0)
            rgb32[i] = (float)(random_bits(&seed) % 2); /* saturated ones too */
        rgb[i] = (double)rgb32[i];
    }
    for (size_t i = 0; i < N; i++) {
        light32[i] = (float)pow(10.0, -2.0 + 2.5 * random_unit(&seed));
        light[i] = (double)light32[i];
    }
}

static lcor_plan_options options_of(int k, lcor_sample type)
{
    lcor_plan_options o = plain_options(type);

    o.reading = k & 1 ? LCOR_READING_TEXEL : LCOR_READING_PATCH;
    o.exponent = k & 2 ? 0.7 : 1.0;
    return o;
}

static void lab_of(const double c[3], double lab[3])
{
    lcor_colour colour;

    lcor_colour_init(&colour, LCOR_PRIMARIES_NTSC, NULL, LCOR_TRANSFER_LINEAR, 1.0,
                     LCOR_LIGHTNESS_CIE, NULL);
    lcor_lab_from_rgb_row_f64(&colour, 1, c, lab);
}

static void hue_is_kept(void **state)
{
    size_t compared = 0;

    (void)state;
    for (int k = 0; k < 4; k++) {
        const lcor_plan_options o = options_of(k, LCOR_F64);
        lcor_plan *plan = make_plan(&o);

        fill((uint64_t)k + 1);
        lcor_correct_row(plan, 0, N, rgb, light, NULL, out, NULL);
        for (size_t i = 0; i < N; i++) {
            double before[3], after[3], cross, size;

            lab_of(rgb + 3 * i, before);
            lab_of(out + 3 * i, after);
            size = lcor_chroma(before) * lcor_chroma(after);
            if (lcor_chroma(after) <= 1e-6 || lcor_chroma(before) <= 1e-6)
                continue;
            /* sine of the turn; Lab itself carries 1e-13 of rounding */
            cross = (before[1] * after[2] - before[2] * after[1]) / size;
            check_near(cross, 0.0, 1e-9 + 2e-13 / lcor_chroma(after), "hue turn");
            compared++;
        }
        lcor_plan_free(plan);
    }
    assert_true(compared > 2 * N);
}

static void display_luminance_rises_with_light(void **state)
{
    (void)state;
    for (int k = 0; k < 8; k++) {
        lcor_plan_options o = options_of(k & 3, k & 4 ? LCOR_F32 : LCOR_F64);
        lcor_plan *plan;
        uint64_t seed = 99;

        o.in_type = LCOR_F64;
        o.out_type = LCOR_F64;
        if (k & 4)
            o.in_type = o.out_type = LCOR_F32;
        plan = make_plan(&o);
        for (int colour = 0; colour < 40; colour++) {
            float c[3];
            double last = -1.0;

            for (int j = 0; j < 3; j++)
                c[j] = (float)random_unit(&seed);
            for (size_t i = 0; i < N; i++) {
                for (size_t j = 0; j < 3; j++) {
                    rgb32[3 * i + j] = c[j];
                    rgb[3 * i + j] = (double)c[j];
                }
                light32[i] = (float)i / 1000.0f;
                light[i] = (double)light32[i];
            }
            if (k & 4)
                lcor_correct_row(plan, 0, N, rgb32, light32, NULL, out32, NULL);
            else
                lcor_correct_row(plan, 0, N, rgb, light, NULL, out, NULL);
            for (size_t i = 0; i < N; i += 7) {
                double o3[3], lab[3];

                for (size_t j = 0; j < 3; j++)
                    o3[j] = k & 4 ? (double)out32[3 * i + j] : out[3 * i + j];
                lab_of(o3, lab);
                assert_true(lab[0] >= last - (k & 4 ? 3e-5 : 1e-11));
                last = lab[0];
            }
        }
        lcor_plan_free(plan);
    }
}

/* H = Jmin + Ynew (Jmax - Jmin) over the whole range of eq 8, texel reading */
static void display_luminance_is_proportional_to_light(void **state)
{
    const double c = 23.4, j_min = 1.0, j_max = 23.4;
    const lcor_plan_options o = options_of(1, LCOR_F64);
    lcor_plan *plan = make_plan(&o);
    double q1, q2;

    (void)state;
    assert_int_equal(lcor_adapt_range(0.35, j_min, j_max, 1.0, &q1, &q2, NULL), LCOR_OK);
    check_near(q2 / q1, c, 1e-13, "range");
    fill(5);
    for (size_t i = 0; i < N; i++) {
        double lab[3], y;

        lab_of(rgb + 3 * i, lab);
        y = 0.2988 * rgb[3 * i] + 0.5868 * rgb[3 * i + 1] + 0.1144 * rgb[3 * i + 2];
        light[i] = (q1 + (q2 - q1) * (double)i / (N - 1)) / fmax(y, 1e-3);
    }
    lcor_correct_row(plan, 0, N, rgb, light, NULL, out, NULL);
    for (size_t i = 0; i < N; i++) {
        const double *p = out + 3 * i;
        const double y = 0.2988 * rgb[3 * i] + 0.5868 * rgb[3 * i + 1] + 0.1144 * rgb[3 * i + 2];
        const double y_new = 0.2988 * p[0] + 0.5868 * p[1] + 0.1144 * p[2];
        const double h = j_min + y_new * (j_max - j_min), r = light[i] * y;

        if (y > 1e-3)
            check_near(h, r / 0.35 * 0.5 * (j_min + j_max), 1e-12 * h, "H");
    }
    lcor_plan_free(plan);
}

static void output_is_in_gamut_and_in_place_is_apart(void **state)
{
    (void)state;
    for (int k = 0; k < 8; k++) {
        lcor_plan_options o = options_of(k & 3, LCOR_F32);
        lcor_plan *plan32, *plan64;

        o.gamut = k & 4 ? LCOR_GAMUT_CLIP : LCOR_GAMUT_KEEP_HUE;
        plan32 = make_plan(&o);
        o.in_type = o.out_type = o.map_type = LCOR_F64;
        plan64 = make_plan(&o);
        fill((uint64_t)k + 20);
        lcor_correct_row(plan32, 0, N, rgb32, light32, NULL, out32, NULL);
        lcor_correct_row(plan64, 0, N, rgb, light, NULL, out, NULL);
        lcor_correct_row(plan32, 0, N, rgb32, light32, NULL, rgb32, NULL);
        lcor_correct_row(plan64, 0, N, rgb, light, NULL, rgb, NULL);
        for (size_t i = 0; i < 3 * N; i++)
            assert_true(out[i] >= 0.0 && out[i] <= 1.0 && out32[i] >= 0.0f && out32[i] <= 1.0f);
        assert_memory_equal(rgb32, out32, sizeof out32);
        assert_memory_equal(rgb, out, sizeof out);
        lcor_plan_free(plan32);
        lcor_plan_free(plan64);
    }
}

/* ... on every kernel, and every kernel gives the same bytes. */
static void any_split_of_a_row_and_any_kernel_give_the_same_bytes(void **state)
{
    (void)state;
    for (int k = 0; k < 32; k++) {
        static float again[3 * N], rho[N];
        static uint8_t rgb8[3 * N];
        const size_t size = k & 16 ? 1 : sizeof(float);
        const char *texels = k & 16 ? (const char *)rgb8 : (const char *)rgb32;
        lcor_plan_options o = options_of(k & 3, LCOR_F32);
        lcor_row_stats whole = {0}, parts = {0};
        lcor_kernel kernel;
        lcor_colour colour;
        uint64_t seed = 77;
        lcor_plan *plan;

        assert_int_equal(lcor_colour_init(&colour, LCOR_PRIMARIES_SRGB, NULL,
                                          k & 8 ? LCOR_TRANSFER_SRGB : LCOR_TRANSFER_LINEAR, 1.0,
                                          LCOR_LIGHTNESS_CIE, NULL),
                         LCOR_OK);
        o.colour = &colour;
        o.gamut = k & 4 ? LCOR_GAMUT_CLIP : LCOR_GAMUT_KEEP_HUE;
        o.in_type = o.out_type = k & 16 ? LCOR_U8 : LCOR_F32;
        plan = make_plan(&o);
        fill((uint64_t)k + 40);
        for (size_t i = 0; i < 3 * N; i++)
            rgb8[i] = (uint8_t)(255.0f * rgb32[i]);
        rgb32[500] = NAN;
        for (size_t i = 0; i < N; i++)
            rho[i] = (float)random_unit(&seed);
        lcor_correct_row(plan, 0, N, texels, light32, rho, out32, &whole);
        for (size_t v = 0; lcor_internal_kernel(v, &kernel); v++) {
            size_t at = 0;

            force_kernel(plan, &kernel);
            memset(&parts, 0, sizeof parts);
            while (at < N) {
                size_t n = random_bits(&seed) % 200;

                if (n > N - at)
                    n = N - at;
                lcor_correct_row(plan, 0, n, texels + 3 * at * size, light32 + at, rho + at,
                                 (char *)again + 3 * at * size, &parts);
                at += n;
            }
            assert_memory_equal(again, out32, 3 * N * size);
            parts.first_bad_pixel = whole.first_bad_pixel; /* counts from each part's start */
            assert_memory_equal(&parts, &whole, sizeof whole);
        }
        lcor_plan_free(plan);
    }
}

static void white_stays_white_and_black_black(void **state)
{
    (void)state;
    for (int k = 0; k < 4; k++)
        for (int type = 0; type < 4; type++) {
            lcor_plan_options o = options_of(k, (lcor_sample)type);
            uint64_t in[3 * 70 / 2 + 140] = {0}, result[3 * 70 / 2 + 140];
            const size_t size = type == 0 ? 4 : type == 1 ? 8 : type == 2 ? 1 : 2;
            float i32[70];
            lcor_plan *plan;

            o.map_type = LCOR_F32;
            o.rho = 1.0;
            o.r_mean = 0.5;
            plan = make_plan(&o);
            for (int i = 0; i < 70; i++)
                i32[i] = 3.0f; /* far above J2 */
            for (size_t i = 0; i < 3 * 35; i++)
                switch ((lcor_sample)type) {
                case LCOR_F32: ((float *)in)[i] = 1.0f; break;
                case LCOR_F64: ((double *)in)[i] = 1.0; break;
                case LCOR_U8: ((uint8_t *)in)[i] = 255; break;
                case LCOR_U16: ((uint16_t *)in)[i] = 65535;
                }
            lcor_correct_row(plan, 0, 70, in, i32, NULL, result, NULL);
            assert_memory_equal(result, in, 3 * 70 * size);
            lcor_plan_free(plan);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(hue_is_kept),
        cmocka_unit_test(display_luminance_rises_with_light),
        cmocka_unit_test(display_luminance_is_proportional_to_light),
        cmocka_unit_test(output_is_in_gamut_and_in_place_is_apart),
        cmocka_unit_test(any_split_of_a_row_and_any_kernel_give_the_same_bytes),
        cmocka_unit_test(white_stays_white_and_black_black)};

    return cmocka_run_group_tests(tests, NULL, NULL);
}
