/* SPDX-License-Identifier: MIT */
/* Plans and rows: options, memory, layouts, types, statistics. */
#include "planning.h"

enum { N = 200 };

static void fill(uint64_t seed, float *rgb, float *light)
{
    for (size_t i = 0; i < 3 * N; i++)
        rgb[i] = (float)random_unit(&seed);
    for (size_t i = 0; i < N; i++)
        light[i] = (float)(2.2 * random_unit(&seed));
}

static void refuse(const lcor_plan_options *o, lcor_status expected, const char *word)
{
    lcor_plan *plan = (lcor_plan *)(void *)&plan;
    lcor_plan *const before = plan;
    lcor_error e;

    assert_int_equal(lcor_plan_new(o, &plan, &e), expected);
    assert_int_equal(e.status, expected);
    if (strstr(e.text, word) == NULL)
        fail_msg("\"%s\" does not name %s", e.text, word);
    assert_ptr_equal(plan, before);
}

static void numbers_outside_the_model_are_refused(void **state)
{
    const double bad[] = {(double)NAN, -1.0, (double)INFINITY};
    lcor_plan_options o;

    (void)state;
    for (size_t i = 0; i < 3; i++) {
        o = plain_options(LCOR_F32);
        o.r_mean = bad[i];
        refuse(&o, LCOR_ERR_DOMAIN, "r_mean");
        o = plain_options(LCOR_F32);
        o.rho = bad[i];
        refuse(&o, LCOR_ERR_DOMAIN, "rho");
        o = plain_options(LCOR_F32);
        o.rho_ratio = bad[i];
        refuse(&o, LCOR_ERR_DOMAIN, "rho_ratio");
        o = plain_options(LCOR_F32);
        o.exponent = bad[i];
        refuse(&o, LCOR_ERR_DOMAIN, "exponent");
    }
    o = plain_options(LCOR_F32);
    o.contrast = 1.0;
    refuse(&o, LCOR_ERR_DOMAIN, "contrast");
    o.contrast = (double)NAN;
    refuse(&o, LCOR_ERR_DOMAIN, "contrast");
    o = plain_options(LCOR_F32);
    o.rho = 1.5;
    refuse(&o, LCOR_ERR_DOMAIN, "rho");
}

static void callers_mistakes_are_refused(void **state)
{
    static const float falling[2] = {1.0f, 0.0f}, above[2] = {0.0f, 1.5f};
    lcor_plan_options o = plain_options(LCOR_F32);

    (void)state;
    o.struct_size = 8;
    refuse(&o, LCOR_ERR_ARG, "struct_size");
    refuse(NULL, LCOR_ERR_ARG, "NULL");
    o = plain_options(LCOR_F32);
    o.reading = (lcor_reading)2;
    refuse(&o, LCOR_ERR_ARG, "reading");
    o = plain_options(LCOR_F32);
    o.gamut = (lcor_gamut)9;
    refuse(&o, LCOR_ERR_ARG, "gamut");
    o = plain_options(LCOR_F32);
    o.in_type = (lcor_sample)4;
    refuse(&o, LCOR_ERR_ARG, "sample type");
    o = plain_options(LCOR_F32);
    o.map_type = LCOR_U8;
    refuse(&o, LCOR_ERR_ARG, "map_type");
    o = plain_options(LCOR_F32);
    o.in_layout = (lcor_layout){2, 1};
    refuse(&o, LCOR_ERR_ARG, "in_layout");
    o = plain_options(LCOR_F32);
    o.out_layout = (lcor_layout){3, 0};
    refuse(&o, LCOR_ERR_ARG, "out_layout");
    o = plain_options(LCOR_F32);
    o.tone_size = 5;
    refuse(&o, LCOR_ERR_ARG, "tone_curve");
    o.tone_curve = falling;
    o.tone_size = 2;
    refuse(&o, LCOR_ERR_DOMAIN, "tone_curve[1]");
    o.tone_curve = above;
    refuse(&o, LCOR_ERR_DOMAIN, "tone_curve[1]");
    o = plain_options(LCOR_F32);
    o.allocator.free = (void (*)(void *, void *))(void (*)(void))refuse;
    refuse(&o, LCOR_ERR_ARG, "allocator");
}

typedef struct counter {
    int allocs, frees, fail;
} counter;

static void *counted_alloc(size_t size, void *user)
{
    counter *c = user;

    c->allocs++;
    return c->fail ? NULL : malloc(size);
}

static void counted_free(void *ptr, void *user)
{
    ((counter *)user)->frees++;
    free(ptr);
}

static void a_plan_is_one_allocation_and_rows_are_none(void **state)
{
    float rgb[3 * N], light[N], tone[3] = {0.0f, 0.4f, 1.0f};
    counter c = {0, 0, 0};
    lcor_plan_options o = plain_options(LCOR_F32);
    lcor_plan *plan;

    (void)state;
    fill(1, rgb, light);
    o.allocator = (lcor_allocator){counted_alloc, counted_free, &c};
    o.tone_curve = tone;
    o.tone_size = 3;
    plan = make_plan(&o);
    for (int i = 0; i < 5; i++)
        lcor_correct_row(plan, 0, N, rgb, light, NULL, rgb, NULL);
    lcor_conventional_row(plan, 0, N, rgb, light, NULL, rgb, NULL);
    assert_int_equal(c.allocs, 1);
    assert_int_equal(c.frees, 0);
    lcor_plan_free(plan);
    assert_int_equal(c.frees, 1);
    lcor_plan_free(NULL);
    c.fail = 1;
    refuse(&o, LCOR_ERR_NOMEM, "memory");
}

/* Every type and layout gives what interleaved float gives; what lies between samples stays. */
static void layouts_and_types_agree(void **state)
{
    static const lcor_layout layouts[] = {{3, 1}, {4, 1}, {1, N}, {1, N + 5}, {6, 2}};
    static const double slack[] = {0.0, 3e-6, 0.5 / 255 + 3e-6, 0.5 / 65535 + 3e-6};
    float rgb[3 * N], light[N], expected[3 * N];
    lcor_plan_options o = plain_options(LCOR_F32);
    lcor_plan *plan = make_plan(&o);

    (void)state;
    fill(2, rgb, light);
    for (size_t i = 0; i < 3 * N; i++)
        rgb[i] = (float)((int)(rgb[i] * 255.0f)) / 255.0f; /* what 8 bits can say */
    lcor_correct_row(plan, 0, N, rgb, light, NULL, expected, NULL);
    lcor_plan_free(plan);
    for (int type = 0; type < 4; type++)
        for (size_t l = 0; l < sizeof layouts / sizeof layouts[0]; l++) {
            const size_t ps = layouts[l].pixel_step, cs = layouts[l].channel_step;
            uint64_t memory[6 * N + 16];
            unsigned char touched[6 * N + 16] = {0};

            memset(memory, 0x5a, sizeof memory);
            o = plain_options((lcor_sample)type);
            o.map_type = LCOR_F32;
            o.in_layout = o.out_layout = layouts[l];
            plan = make_plan(&o);
            for (size_t i = 0; i < 3 * N; i++) {
                const size_t at = i / 3 * ps + i % 3 * cs;

                touched[at] = 1;
                switch ((lcor_sample)type) {
                case LCOR_F32: ((float *)memory)[at] = rgb[i]; break;
                case LCOR_F64: ((double *)memory)[at] = (double)rgb[i]; break;
                case LCOR_U8: ((uint8_t *)memory)[at] = (uint8_t)(rgb[i] * 255.0f + 0.5f); break;
                case LCOR_U16: ((uint16_t *)memory)[at] = (uint16_t)(rgb[i] * 65535.0f + 0.5f);
                }
            }
            lcor_correct_row(plan, 0, N, memory, light, NULL, memory, NULL);
            for (size_t i = 0; i < 3 * N; i++) {
                const size_t at = i / 3 * ps + i % 3 * cs;
                const double v = type == LCOR_F32   ? (double)((float *)memory)[at]
                                 : type == LCOR_F64 ? ((double *)memory)[at]
                                 : type == LCOR_U8  ? ((uint8_t *)memory)[at] / 255.0
                                                    : ((uint16_t *)memory)[at] / 65535.0;

                check_near(v, (double)expected[i], slack[type], "sample");
            }
            for (size_t at = 0; at < 6 * N; at++)
                if (!touched[at] && type == LCOR_U8)
                    assert_int_equal(((uint8_t *)memory)[at], 0x5a);
                else if (!touched[at] && type == LCOR_F32)
                    assert_int_equal(((uint32_t *)memory)[at], 0x5a5a5a5a);
            lcor_plan_free(plan);
        }
}

/* Pixels move in pieces larger than themselves: the last one of a block must not. The sanitizers
 * watch what is read, 16 bytes behind the row what is written. */
static void rows_of_whole_blocks_stay_within_their_ends(void **state)
{
    static const lcor_sample types[] = {LCOR_U8, LCOR_U16, LCOR_F32};
    static const size_t sizes[] = {1, 2, 4};
    float light[LCOR_BLOCK];
    lcor_kernel kernel;

    (void)state;
    for (size_t j = 0; j < LCOR_BLOCK; j++)
        light[j] = 1.0f;
    for (size_t i = 0; i < 3; i++) {
        const lcor_plan_options o = plain_options(types[i]);
        const size_t size = 3 * LCOR_BLOCK * sizes[i];
        lcor_plan *plan = make_plan(&o);
        unsigned char *in = calloc(1, size), *out = malloc(size + 16);

        assert_true(in != NULL && out != NULL);
        for (size_t v = 0; lcor_internal_kernel(v, &kernel); v++) {
            memset(out, 0xA5, size + 16);
            force_kernel(plan, &kernel);
            lcor_correct_row(plan, 0, LCOR_BLOCK, in, light, NULL, out, NULL);
            for (size_t k = 0; k < size + 16; k++)
                assert_int_equal(out[k], k < size ? 0 : 0xA5); /* black stays black */
        }
        free(in);
        free(out);
        lcor_plan_free(plan);
    }
}

static void bad_pixels_are_black_counted_and_located(void **state)
{
    static const float trouble[] = {NAN, INFINITY, -INFINITY, -0.25f};

    (void)state;
    for (int type = 0; type < 2; type++) /* float path and reference */
        for (size_t k = 0; k < 4 * 5; k++) {
            lcor_plan_options o = plain_options((lcor_sample)type);
            float rgb[3 * N], light[N], rho[N], out[3 * N];
            double rgb64[3 * N], out64[3 * N];
            lcor_row_stats stats = {0};
            lcor_plan *plan;

            o.map_type = LCOR_F32;
            plan = make_plan(&o);
            fill(k, rgb, light);
            for (size_t i = 0; i < N; i++)
                rho[i] = 0.3f;
            if (k / 4 < 3)
                rgb[3 * 131 + k / 4] = trouble[k % 4];
            else
                (k / 4 == 3 ? light : rho)[131] = trouble[k % 4];
            rgb[3 * 170] = -1.0f;
            rgb[3 * 10] = -0.0f; /* is 0 */
            rgb[3 * 11] = 1e30f; /* absurd, but a number */
            for (size_t i = 0; i < 3 * N; i++)
                rgb64[i] = (double)rgb[i];
            if (type == LCOR_F32)
                lcor_correct_row(plan, 42, N, rgb, light, rho, out, &stats);
            else
                lcor_correct_row(plan, 42, N, rgb64, light, rho, out64, &stats);
            assert_int_equal(stats.pixels, N);
            assert_int_equal(stats.non_finite, 2);
            assert_int_equal(stats.first_bad_row, 42);
            assert_int_equal(stats.first_bad_pixel, 131);
            for (size_t i = 0; i < 3 * N; i++) {
                const double v = type == LCOR_F32 ? (double)out[i] : out64[i];

                assert_true(v >= 0.0 && v <= 1.0);
                if (i / 3 == 131 || i / 3 == 170)
                    assert_true(v == 0.0);
            }
            lcor_plan_free(plan);
        }
}

/* Counts of the float path are those of the reference but for pixels on the very border. */
static void statistics_agree_between_the_paths(void **state)
{
    (void)state;
    for (int k = 0; k < 8; k++) {
        float rgb[3 * N], light[N], out[3 * N], f[3 * N];
        double rgb64[3 * N];
        lcor_row_stats a = {0}, b = {0}, c = {0};
        lcor_plan_options o = plain_options(LCOR_F32);
        lcor_plan *plan32, *plan64;

        o.reading = k % 2 ? LCOR_READING_TEXEL : LCOR_READING_PATCH;
        o.gamut = k / 2 % 2 ? LCOR_GAMUT_CLIP : LCOR_GAMUT_KEEP_HUE;
        o.exponent = k / 4 ? 1.2 : 1.0;
        plan32 = make_plan(&o);
        o.in_type = o.out_type = LCOR_F64;
        plan64 = make_plan(&o);
        fill((uint64_t)k + 50, rgb, light);
        rgb[30] = NAN;
        light[7] = 0.001f; /* one certainly below J1, one above J2 */
        rgb[24] = rgb[25] = rgb[26] = 1.0f;
        light[8] = 2.2f;
        for (size_t i = 0; i < 3 * N; i++)
            rgb64[i] = (double)rgb[i];
        lcor_plan_texture_row(plan32, N, rgb, f, N);
        lcor_correct_row(plan32, 0, N, rgb, light, NULL, out, &a);
        lcor_correct_row(plan64, 0, N, rgb64, light, NULL, rgb64, &b);
        lcor_correct_texture_row(plan32, 0, N, f, N, light, NULL, out, &c);
        assert_memory_equal(&a, &b, sizeof a);
        assert_memory_equal(&a, &c, sizeof a);
        assert_true(a.clipped_low > 0 && a.clipped_high > 0 && a.non_finite == 1);
        lcor_plan_free(plan32);
        lcor_plan_free(plan64);
    }
}

static void tone_curve_replaces_the_transfer_function(void **state)
{
    const float tone[5] = {0.1f, 0.2f, 0.2f, 0.6f, 0.9f};
    float rgb[3 * N], light[N], out[3 * N], linear[3 * N];
    lcor_plan_options o = plain_options(LCOR_F32);
    lcor_plan *plan = make_plan(&o);

    (void)state;
    fill(5, rgb, light);
    lcor_correct_row(plan, 0, N, rgb, light, NULL, linear, NULL);
    lcor_plan_free(plan);
    for (int type = 0; type < 2; type++) {
        double in64[3 * N];

        o = plain_options((lcor_sample)type);
        o.map_type = LCOR_F32;
        o.tone_curve = tone;
        o.tone_size = 5;
        plan = make_plan(&o);
        for (size_t i = 0; i < 3 * N; i++)
            in64[i] = (double)rgb[i];
        if (type == LCOR_F32)
            lcor_correct_row(plan, 0, N, rgb, light, NULL, out, NULL);
        else
            lcor_correct_row(plan, 0, N, in64, light, NULL, in64, NULL);
        for (size_t i = 0; i < 3 * N; i++) {
            const double x = (double)linear[i] * 4.0;
            const int j = x < 3.0 ? (int)x : 3;
            const double expected =
                (double)tone[j] + ((double)tone[j + 1] - (double)tone[j]) * (x - j);

            check_near(type == LCOR_F32 ? (double)out[i] : in64[i], expected, 1e-5, "tone");
        }
        lcor_plan_free(plan);
    }
}

static void options_left_zero_mean_their_defaults(void **state)
{
    const double rgb[3] = {0.9, 0.3, 0.4}, light = 0.4;
    lcor_plan_options o = plain_options(LCOR_F64);
    double a[3], b[3];
    lcor_plan *plan;

    (void)state;
    o.rho = 0.0;
    plan = make_plan(&o);
    lcor_correct_row(plan, 0, 1, rgb, &light, NULL, a, NULL);
    lcor_plan_free(plan);
    o.rho = 0.5;
    o.exponent = o.rho_ratio = 1.0;
    o.in_layout = o.out_layout = (lcor_layout){3, 1};
    plan = make_plan(&o);
    lcor_correct_row(plan, 0, 1, rgb, &light, NULL, b, NULL);
    lcor_plan_free(plan);
    assert_memory_equal(a, b, sizeof a);
}

static void measured_reflectance_scales_the_texture(void **state)
{
    /* section 5.2: twice as reflective as its texture says; grey so that RGB is Y */
    const double grey[3] = {0.2, 0.2, 0.2}, light = 0.5;
    lcor_plan_options o = plain_options(LCOR_F64);

    (void)state;
    for (int k = 0; k < 2; k++) {
        double a[3], t;
        lcor_plan *plan;

        o.reading = (lcor_reading)k;
        o.rho_ratio = 2.0;
        plan = make_plan(&o);
        lcor_correct_row(plan, 0, 1, grey, &light, NULL, a, NULL);
        lcor_plan_free(plan);
        t = lcor_internal_display(light * (k ? 0.4 : 0.35) / 0.35, 1.0, 0.5 * (1.0 + 2.0 / 22.4));
        check_near(a[0], k ? t : t * 0.4 / 0.35, 1e-14, "Ynew");
    }
}

/* Regression: a colour 1e-13 outside the cube lost all its chroma. */
static void a_colour_barely_outside_keeps_its_chroma(void **state)
{
    const float rgb32[3] = {0.787398994f, 0.000513315f, 0.0278638f}, light = 0.0926245f;
    lcor_plan_options o = plain_options(LCOR_F64);
    lcor_colour colour;
    uint64_t seed = 1;

    (void)state;
    assert_int_equal(lcor_colour_init(&colour, LCOR_PRIMARIES_NTSC, NULL, LCOR_TRANSFER_SRGB, 1.0,
                                      LCOR_LIGHTNESS_CIE, NULL),
                     LCOR_OK);
    o.map_type = LCOR_F32;
    o.colour = &colour;
    for (int i = 0; i < 2000; i++) {
        double kept[3], clipped[3], rgb[3];
        lcor_plan *plan;

        for (int k = 0; k < 3; k++)
            rgb[k] = (double)rgb32[k];
        rgb[2] += (random_unit(&seed) - 0.5) * 1e-6 * i / 1000.0; /* across the border */
        o.gamut = LCOR_GAMUT_KEEP_HUE;
        plan = make_plan(&o);
        lcor_correct_row(plan, 0, 1, rgb, &light, NULL, kept, NULL);
        lcor_plan_free(plan);
        o.gamut = LCOR_GAMUT_CLIP;
        plan = make_plan(&o);
        lcor_correct_row(plan, 0, 1, rgb, &light, NULL, clipped, NULL);
        lcor_plan_free(plan);
        for (int k = 0; k < 3; k++)
            check_near(kept[k], clipped[k], 2e-4, "chroma");
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(numbers_outside_the_model_are_refused),
        cmocka_unit_test(callers_mistakes_are_refused),
        cmocka_unit_test(a_plan_is_one_allocation_and_rows_are_none),
        cmocka_unit_test(layouts_and_types_agree),
        cmocka_unit_test(rows_of_whole_blocks_stay_within_their_ends),
        cmocka_unit_test(bad_pixels_are_black_counted_and_located),
        cmocka_unit_test(statistics_agree_between_the_paths),
        cmocka_unit_test(tone_curve_replaces_the_transfer_function),
        cmocka_unit_test(a_colour_barely_outside_keeps_its_chroma),
        cmocka_unit_test(options_left_zero_mean_their_defaults),
        cmocka_unit_test(measured_reflectance_scales_the_texture)};

    return cmocka_run_group_tests(tests, NULL, NULL);
}
