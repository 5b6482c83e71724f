/* SPDX-License-Identifier: MIT */
/* What other programs get of a profile, and the chart they print. */
#include "testing.h"

#include "command/export.h"
#include "command/import_table.h"
#include "command/target.h"

static void add(lcor_profile *profile, double level, double density, const char *name)
{
    const lcor_profile_reading r = {.name = name,
                                    .has = LCOR_HAS_RGB | LCOR_HAS_VISUAL,
                                    .rgb = {level, level, level},
                                    .density = {0.0, 0.0, 0.0, density}};
    assert_int_equal(lcor_profile_reading_add(profile, &r, NULL), LCOR_OK);
}

/* Black, a grey that shows a quarter of the way from black to white, white. */
static lcor_profile *device(bool ramp)
{
    lcor_profile *profile = NULL;
    assert_int_equal(lcor_profile_new(NULL, &profile, NULL), LCOR_OK);
    add(profile, 255.0, 0.1, "white, bare");
    if (ramp)
        add(profile, 102.0, 0.1 - log10(0.05 + 0.95 * 0.25), "grey");
    add(profile, 0.0, 0.1 + log10(20.0), "black");
    assert_int_equal(lcor_profile_keyword_set(profile, "CREATED", "2026-11-22T03:04:05Z", NULL),
                     LCOR_OK);
    return profile;
}

static uint32_t big_endian(const char *bytes, int n)
{
    uint32_t value = 0;
    for (int i = 0; i < n; i++)
        value = value << 8 | (unsigned char)bytes[i];
    return value;
}

static const char *find_tag(const buffer *icc, const char *name, uint32_t *size)
{
    const uint32_t count = big_endian(icc->bytes + 128, 4);
    for (uint32_t i = 0; i < count; i++) {
        const char *entry = icc->bytes + 132 + 12 * i;
        if (memcmp(entry, name, 4) == 0) {
            *size = big_endian(entry + 8, 4);
            return icc->bytes + big_endian(entry + 4, 4);
        }
    }
    fail_msg("no tag %s", name);
    return NULL;
}

static double curve_at(const buffer *icc, double v)
{
    uint32_t size;
    const char *tag = find_tag(icc, "kTRC", &size);
    const uint32_t n = big_endian(tag + 8, 4);
    assert_memory_equal(tag, "curv", 4);
    assert_int_equal(size, 12 + 2 * n);
    return big_endian(tag + 12 + 2 * (size_t)(v * (n - 1) + 0.5), 2) / 65535.0;
}

static buffer make_icc(bool ramp)
{
    buffer icc = {0};
    lcor_profile_result r;
    lcor_profile *profile = device(ramp);
    assert_int_equal(profile_evaluate(profile, &r), LCCAL_OK);
    export_icc(profile, &r, &icc);
    lcor_profile_free(profile);
    assert_false(icc.failed);
    return icc;
}

static void the_icc_profile_is_well_formed(void **unused)
{
    (void)unused;
    buffer icc = make_icc(true);
    assert_int_equal(big_endian(icc.bytes, 4), icc.size);
    assert_int_equal(big_endian(icc.bytes + 8, 4), 0x02400000);
    assert_memory_equal(icc.bytes + 12, "prtrGRAYXYZ ", 12);
    static const unsigned char date[] = {0x07, 0xEA, 0, 11, 0, 22, 0, 3, 0, 4, 0, 5};
    assert_memory_equal(icc.bytes + 24, date, sizeof date);
    assert_memory_equal(icc.bytes + 36, "acsp", 4);
    uint32_t size;
    assert_memory_equal(find_tag(&icc, "desc", &size), "desc", 4);
    assert_memory_equal(find_tag(&icc, "cprt", &size), "text", 4);
    assert_memory_equal(find_tag(&icc, "wtpt", &size), "XYZ ", 4);
    for (uint32_t i = 0; i < 5; i++)
        assert_int_equal(big_endian(icc.bytes + 132 + 12 * i + 4, 4) % 4, 0);
    buffer_free(&icc);
}

static void its_curve_starts_at_one_over_c_and_follows_the_ramp(void **unused)
{
    (void)unused;
    buffer icc = make_icc(true);
    check_near(curve_at(&icc, 0.0), 1.0 / 20.0, 1.0 / 65535.0, "kTRC[0]");
    check_near(curve_at(&icc, 0.4), 0.05 + 0.95 * 0.25, 3e-4, "grey");
    check_near(curve_at(&icc, 1.0), 1.0, 0.0, "white");
    buffer_free(&icc);
    icc = make_icc(false);
    check_near(curve_at(&icc, 0.0), 1.0 / 20.0, 1.0 / 65535.0, "kTRC[0] without a ramp");
    check_near(curve_at(&icc, 0.5), 0.525, 3e-4, "straight");
    buffer_free(&icc);
}

static void csv_is_read_back(void **unused)
{
    (void)unused;
    buffer table = {0}, cgats = {0};
    char problem[160];
    lcor_profile *profile = device(true), *again = NULL;
    export_csv(profile, &table);
    assert_true(import_table(table.bytes, table.size, &cgats, problem, sizeof problem));
    assert_int_equal(
        lcor_profile_import(cgats.bytes, cgats.size, LCOR_BLACK_FULL, NULL, &again, NULL), LCOR_OK);
    assert_int_equal(lcor_profile_count(again), 3);
    assert_true(lcor_profile_contrast(again) == lcor_profile_contrast(profile));
    lcor_profile_reading r;
    assert_int_equal(lcor_profile_reading_get(again, 0, &r, NULL), LCOR_OK);
    assert_string_equal(r.name, "white, bare");
    lcor_profile_free(again);
    lcor_profile_free(profile);
    buffer_free(&cgats);
    buffer_free(&table);
}

static void json_escapes_what_it_must(void **unused)
{
    (void)unused;
    buffer out = {0};
    lcor_profile_result r;
    lcor_profile *profile = device(false);
    assert_int_equal(lcor_profile_keyword_set(profile, "MATERIAL", "a\\b caf\xC3\xA9", NULL),
                     LCOR_OK);
    assert_int_equal(profile_evaluate(profile, &r), LCCAL_OK);
    export_json(profile, &r, &out);
    assert_non_null(strstr(out.bytes, "\"MATERIAL\":\"a\\u005cb caf\xC3\xA9\""));
    assert_non_null(strstr(out.bytes, "\"d_min\":0.1,"));
    lcor_profile_free(profile);
    buffer_free(&out);
}

/* Figures, frames and patches of the chart stay on the page and do not cover each other's patch. */
static void the_chart_fits_its_page(void **unused)
{
    (void)unused;
    static target t;
    static const double pages[][2] = {{210.0, 297.0}, {215.9, 279.4}};
    for (size_t p = 0; p < 2; p++)
        for (int steps = 1; steps <= TARGET_STEPS_MAX; steps++) {
            target_lay_out(&t, pages[p][0], pages[p][1], steps);
            size_t patches = 0;
            assert_true(t.count < TARGET_RECTANGLES);
            for (size_t i = 0; i < t.count; i++) {
                const rectangle *a = &t.rectangles[i];
                assert_true(a->x >= 10.0 && a->x + a->width <= t.width - 10.0);
                assert_true(a->y >= 10.0 && a->y + a->height <= t.height - 25.0);
                patches += a->width > 10.0 && a->height > 10.0;
                for (size_t k = 0; k < i; k++) {
                    const rectangle *b = &t.rectangles[k];
                    /* an instrument's foot covers no second patch */
                    const double apart = a->width > 10.0 && a->height > 10.0 ? 2.5 : 0.0;
                    if (b->width <= 10.0 || b->height <= 10.0)
                        continue;
                    assert_false(a->x < b->x + b->width + apart && b->x < a->x + a->width + apart &&
                                 a->y < b->y + b->height + 3.0 * apart &&
                                 b->y < a->y + a->height + 3.0 * apart);
                }
            }
            assert_int_equal(patches, 9 + steps);
        }
}

static void created_dates_are_understood(void **unused)
{
    (void)unused;
    static const struct {
        const char *text;
        double seconds;
    } cases[] = {{"1970-01-01", 0.0},
                 {"2000-02-29T12:00:00Z", 951825600.0},
                 {"2026-11-22T03:04:05Z", 1795316645.0},
                 {"December 2006", -1.0},
                 {"2026-13-01", -1.0},
                 {"8/28/2006", -1.0}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        lcor_profile *profile = device(false);
        assert_int_equal(lcor_profile_keyword_set(profile, "CREATED", cases[i].text, NULL),
                         LCOR_OK);
        check_near(profile_created(profile), cases[i].seconds, 0.0, cases[i].text);
        lcor_profile_free(profile);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_icc_profile_is_well_formed),
        cmocka_unit_test(its_curve_starts_at_one_over_c_and_follows_the_ramp),
        cmocka_unit_test(csv_is_read_back),
        cmocka_unit_test(json_escapes_what_it_must),
        cmocka_unit_test(the_chart_fits_its_page),
        cmocka_unit_test(created_dates_are_understood),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
