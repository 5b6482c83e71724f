/* SPDX-License-Identifier: MIT */
/* Building a profile reading by reading, and what follows from the readings. */
#include "testing.h"

#include "profile/internal.h"

#include <lcor/profile.h>

#define LN10 2.302585092994046

static lcor_profile *new_profile(void)
{
    lcor_profile *profile = NULL;
    lcor_error err;
    assert_int_equal(lcor_profile_new(NULL, &profile, &err), LCOR_OK);
    return profile;
}

static void add(lcor_profile *profile, double level, double density)
{
    lcor_error err = {.text = ""};
    const lcor_profile_reading r = {.has = LCOR_HAS_RGB | LCOR_HAS_VISUAL,
                                    .rgb = {level, level, level},
                                    .density = {0.0, 0.0, 0.0, density}};
    if (lcor_profile_reading_add(profile, &r, &err) != LCOR_OK)
        fail_msg("%s", err.text);
}

static lcor_profile_result evaluate(const lcor_profile *profile)
{
    lcor_profile_result r;
    lcor_error err = {.text = ""};
    if (lcor_profile_evaluate(profile, &r, &err) != LCOR_OK)
        fail_msg("%s", err.text);
    return r;
}

static char *format(const lcor_profile *profile)
{
    size_t size = 0;
    lcor_error err;
    assert_int_equal(lcor_profile_format(profile, NULL, 0, &size, &err), LCOR_OK);
    char *text = malloc(size + 1);
    assert_non_null(text);
    assert_int_equal(lcor_profile_format(profile, text, size + 1, &size, &err), LCOR_OK);
    assert_int_equal(strlen(text), size);
    return text;
}

static void contrast_is_of_the_medians(void **unused)
{
    (void)unused;
    lcor_profile *profile = new_profile();
    const double white[] = {0.07, 0.06, 0.09}, black[] = {1.40, 1.50, 1.44, 1.46};
    for (size_t i = 0; i < 4; i++)
        add(profile, 0.0, black[i]);
    for (size_t i = 0; i < 3; i++)
        add(profile, 255.0, white[i]);
    const lcor_profile_result r = evaluate(profile);
    check_near(r.d_min, 0.07, 1e-12, "d_min");
    check_near(r.d_max, 1.45, 1e-12, "d_max");
    check_near(r.contrast, pow(10.0, 1.38), 1e-9, "contrast");
    assert_int_equal(r.n_min, 3);
    assert_int_equal(r.n_max, 4);
    assert_true(lcor_profile_contrast(profile) == r.contrast);
    assert_true(lcor_profile_contrast_u95(profile) == r.contrast_u95);
    lcor_profile_free(profile);
}

static void rejected_readings_are_kept_and_take_no_part(void **unused)
{
    (void)unused;
    lcor_profile *profile = new_profile();
    add(profile, 255.0, 0.07);
    add(profile, 255.0, 0.50);
    add(profile, 0.0, 1.44);
    assert_int_equal(lcor_profile_reading_reject(profile, 1, 1, NULL), LCOR_OK);
    check_near(lcor_profile_contrast(profile), pow(10.0, 1.37), 1e-9, "contrast");
    char *text = format(profile);
    lcor_profile *again = NULL;
    assert_int_equal(lcor_profile_parse(text, strlen(text), NULL, &again, NULL), LCOR_OK);
    lcor_profile_reading r;
    assert_int_equal(lcor_profile_count(again), 3);
    assert_int_equal(lcor_profile_reading_get(again, 1, &r, NULL), LCOR_OK);
    assert_true(r.rejected && r.density[3] == 0.5);
    assert_int_equal(lcor_profile_reading_reject(profile, 3, 1, NULL), LCOR_ERR_ARG);
    assert_int_equal(lcor_profile_reading_get(profile, 3, &r, NULL), LCOR_ERR_ARG);
    free(text);
    lcor_profile_free(again);
    lcor_profile_free(profile);
}

/* By hand, for three readings of each patch, step 0: spread of 0.01 and 0.02, the median's variance
 * 0.4487 of one reading's, Welch's 2.94 degrees of freedom. */
static void the_interval_is_students(void **unused)
{
    (void)unused;
    lcor_profile *profile = new_profile();
    for (int i = -1; i <= 1; i++)
        add(profile, 255.0, 0.07 + 0.01 * i);
    for (int i = -1; i <= 1; i++)
        add(profile, 0.0, 1.44 + 0.02 * i);
    const lcor_profile_result r = evaluate(profile);
    check_near(r.u_min, 0.01 * sqrt(0.4487), 1e-7, "u_min");
    check_near(r.u_max, 0.02 * sqrt(0.4487), 1e-7, "u_max");
    const double t = lcor_internal_student95(25.0 / (1.0 / 2.0 + 16.0 / 2.0));
    check_near(r.contrast_u95, r.contrast * LN10 * t * sqrt(5e-4 * 0.4487), 1e-6, "u95");
    lcor_profile_free(profile);
}

static void equal_readings_are_no_better_than_the_resolution(void **unused)
{
    (void)unused;
    lcor_profile *profile = new_profile();
    for (int i = 0; i < 5; i++)
        add(profile, 255.0, 0.07);
    for (int i = 0; i < 5; i++)
        add(profile, 0.0, 1.44);
    assert_true(evaluate(profile).contrast_u95 == 0.0); /* resolution not known */
    assert_int_equal(lcor_profile_resolution_set(profile, 0.01, NULL), LCOR_OK);
    const lcor_profile_result r = evaluate(profile);
    check_near(r.u_min, 0.01 / sqrt(12.0), 1e-12, "u_min");
    check_near(r.contrast_u95, 1.959963985 * r.contrast * LN10 * 0.01 / sqrt(6.0), 1e-9, "u95");
    assert_int_equal(lcor_profile_resolution_set(profile, -0.01, NULL), LCOR_ERR_DOMAIN);
    assert_int_equal(lcor_profile_resolution_set(profile, (double)NAN, NULL), LCOR_ERR_DOMAIN);
    lcor_profile_free(profile);
}

static void one_reading_has_no_interval(void **unused)
{
    (void)unused;
    lcor_profile *profile = new_profile();
    add(profile, 255.0, 0.07);
    add(profile, 0.0, 1.44);
    add(profile, 0.0, 1.45);
    assert_true(evaluate(profile).contrast_u95 == 0.0);
    lcor_profile_free(profile);
}

static void students_quantile_is_that_of_the_tables(void **unused)
{
    (void)unused;
    static const double table[][2] = {{1, 12.7062}, {2, 4.3027},  {3, 3.1824},   {4, 2.7764},
                                      {5, 2.5706},  {6, 2.4469},  {8, 2.3060},   {10, 2.2281},
                                      {20, 2.0860}, {60, 2.0003}, {1e9, 1.95996}};
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++)
        check_near(lcor_internal_student95(table[i][0]) / table[i][1], 1.0, 0.002, "t");
    double last = lcor_internal_student95(0.5);
    for (double f = 0.6; f < 100.0; f += 0.1) { /* it falls all the way */
        assert_true(lcor_internal_student95(f) <= last);
        last = lcor_internal_student95(f);
    }
}

static void what_gives_no_contrast_is_told(void **unused)
{
    (void)unused;
    lcor_profile *profile = new_profile();
    lcor_profile_result r = {.contrast = 42.0};
    lcor_error err;
    size_t size;
    assert_int_equal(lcor_profile_evaluate(profile, &r, &err), LCOR_ERR_DOMAIN);
    assert_int_equal(lcor_profile_format(profile, NULL, 0, &size, &err), LCOR_ERR_DOMAIN);
    add(profile, 255.0, 0.07);
    assert_int_equal(lcor_profile_evaluate(profile, &r, &err), LCOR_ERR_DOMAIN);
    assert_non_null(strstr(err.text, "black"));
    add(profile, 0.0, 0.07);
    assert_int_equal(lcor_profile_evaluate(profile, &r, &err), LCOR_ERR_DOMAIN);
    assert_true(r.contrast == 42.0);
    assert_true(lcor_profile_contrast(profile) == 0.0);
    assert_true(lcor_profile_contrast(NULL) == 0.0 && lcor_profile_count(NULL) == 0);
    lcor_profile_free(profile);
    lcor_profile_free(NULL);
}

static void wrong_readings_are_refused(void **unused)
{
    (void)unused;
    lcor_profile *profile = new_profile();
    const lcor_profile_reading good = {.has = LCOR_HAS_RGB | LCOR_HAS_VISUAL,
                                       .density = {0, 0, 0, 1}};
    lcor_profile_reading r = good;
    lcor_error err;
    r.has = LCOR_HAS_RGB;
    assert_int_equal(lcor_profile_reading_add(profile, &r, &err), LCOR_ERR_ARG);
    r.has = 64 | LCOR_HAS_VISUAL;
    assert_int_equal(lcor_profile_reading_add(profile, &r, &err), LCOR_ERR_ARG);
    r = good;
    r.density[3] = (double)NAN;
    assert_int_equal(lcor_profile_reading_add(profile, &r, &err), LCOR_ERR_DOMAIN);
    r = good;
    r.rgb[1] = 256.0;
    assert_int_equal(lcor_profile_reading_add(profile, &r, &err), LCOR_ERR_DOMAIN);
    r = good;
    r.has = LCOR_HAS_XYZ;
    assert_int_equal(lcor_profile_reading_add(profile, &r, &err), LCOR_ERR_DOMAIN); /* Y = 0 */
    r = good;
    r.name = "two\nlines";
    assert_int_equal(lcor_profile_reading_add(profile, &r, &err), LCOR_ERR_ARG);
    assert_int_equal(lcor_profile_reading_add(profile, &good, &err), LCOR_OK);
    r = good;
    r.has |= LCOR_HAS_COLOUR_DENSITY;
    assert_int_equal(lcor_profile_reading_add(profile, &r, &err),
                     LCOR_ERR_ARG); /* not like the first */
    assert_int_equal(lcor_profile_count(profile), 1);
    lcor_profile_free(profile);
}

static void keywords_are_set_replaced_and_removed(void **unused)
{
    (void)unused;
    lcor_profile *profile = new_profile();
    lcor_error err;
    add(profile, 255.0, 0.07);
    add(profile, 0.0, 1.44);
    assert_int_equal(lcor_profile_keyword_set(profile, "MATERIAL", "matt", &err), LCOR_OK);
    assert_int_equal(lcor_profile_keyword_set(profile, "MY_OWN", "caf\xC3\xA9", &err), LCOR_OK);
    assert_int_equal(lcor_profile_keyword_set(profile, "MATERIAL", "glossy", &err), LCOR_OK);
    assert_int_equal(lcor_profile_keyword_count(profile), 2);
    assert_string_equal(lcor_profile_keyword(profile, "MATERIAL"), "glossy");
    char *text = format(profile);
    assert_non_null(strstr(text, "\nMATERIAL \"glossy\"\n"));
    assert_non_null(strstr(text, "KEYWORD \"MY_OWN\"\nMY_OWN \"caf\xC3\xA9\"\n"));
    free(text);
    assert_int_equal(lcor_profile_keyword_set(profile, "MATERIAL", NULL, &err), LCOR_OK);
    assert_null(lcor_profile_keyword(profile, "MATERIAL"));
    assert_string_equal(lcor_profile_keyword_name(profile, 0), "MY_OWN");
    assert_null(lcor_profile_keyword_name(profile, 1));
    static const char *const names[] = {"",         "lower",  "WITH SPACE", "1ST", "LCOR_CONTRAST",
                                        "END_DATA", "KEYWORD"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++)
        assert_int_equal(lcor_profile_keyword_set(profile, names[i], "x", &err), LCOR_ERR_ARG);
    assert_int_equal(lcor_profile_keyword_set(profile, "A", "quote\"", &err), LCOR_ERR_ARG);
    assert_int_equal(lcor_profile_keyword_set(profile, "A", "two\nlines", &err), LCOR_ERR_ARG);
    lcor_profile_free(profile);
}

static void a_small_buffer_gets_what_fits(void **unused)
{
    (void)unused;
    lcor_profile *profile = new_profile();
    add(profile, 255.0, 0.07);
    add(profile, 0.0, 1.44);
    char *whole = format(profile);
    char part[20];
    size_t size = 0;
    memset(part, 'x', sizeof part);
    assert_int_equal(lcor_profile_format(profile, part, sizeof part, &size, NULL), LCOR_OK);
    assert_int_equal(size, strlen(whole));
    assert_int_equal(strlen(part), sizeof part - 1);
    assert_memory_equal(part, whole, sizeof part - 1);
    lcor_profile *again = NULL;
    assert_int_equal(lcor_profile_parse(whole, size, NULL, &again, NULL), LCOR_OK);
    char *text = format(again);
    assert_string_equal(text, whole);
    free(text);
    free(whole);
    lcor_profile_free(again);
    lcor_profile_free(profile);
}

/* Else the derived values of the text would not be those of its readings. */
static void a_profile_holds_what_its_text_will_hold(void **unused)
{
    (void)unused;
    lcor_profile *profile = new_profile();
    lcor_profile_reading r;
    add(profile, 255.0, 0.0712345678912345);
    add(profile, 0.0, 1.4412345678912345);
    assert_int_equal(lcor_profile_reading_get(profile, 1, &r, NULL), LCOR_OK);
    assert_true(r.density[3] == 1.44123457);
    char *text = format(profile);
    lcor_profile *again = NULL;
    assert_int_equal(lcor_profile_parse(text, strlen(text), NULL, &again, NULL), LCOR_OK);
    assert_true(lcor_profile_contrast(again) == lcor_profile_contrast(profile));
    free(text);
    lcor_profile_free(again);
    lcor_profile_free(profile);
}

/* ---- memory ---- */

typedef struct ration {
    long left; /* allocations that still succeed */
    long live;
} ration;

static void *ration_alloc(size_t size, void *user)
{
    ration *r = user;
    if (r->left-- <= 0)
        return NULL;
    r->live++;
    return malloc(size);
}

static void ration_free(void *ptr, void *user)
{
    ((ration *)user)->live--;
    free(ptr);
}

static void short_memory_at_any_allocation_is_told_and_leaks_nothing(void **unused)
{
    (void)unused;
    char text[2048] = "ORIGINATOR \"x\"\nMATERIAL \"y\"\nBEGIN_DATA_FORMAT RGB_R RGB_G RGB_B D_VIS "
                      "END_DATA_FORMAT BEGIN_DATA\n255 255 255 .07\n";
    for (int i = 0; i < 40; i++) /* more readings than fit the first time */
        strcat(text, "99 99 99 .6\n");
    strcat(text, "0 0 0 1.44\nEND_DATA\n");
    lcor_status status = LCOR_ERR_NOMEM;
    for (long k = 0; status != LCOR_OK; k++) {
        ration r = {.left = k};
        const lcor_allocator allocator = {ration_alloc, ration_free, &r};
        lcor_profile *profile = NULL;
        lcor_error err = {.status = LCOR_OK};
        float curve[9];
        assert_in_range(k, 0, 100);
        status = lcor_profile_parse(text, strlen(text), &allocator, &profile, &err);
        if (status == LCOR_OK)
            status = lcor_profile_tone_curve(profile, 9, curve, &err);
        assert_true(status == LCOR_OK || err.status == LCOR_ERR_NOMEM);
        lcor_profile_free(profile);
        assert_int_equal(r.live, 0);
    }
}

static void memory_is_bounded_by_the_text(void **unused)
{
    (void)unused;
    /* Numbers in the text must not decide how much is allocated. */
    static const char text[] = "NUMBER_OF_SETS 99999999999\nNUMBER_OF_FIELDS 99999999999\n"
                               "BEGIN_DATA_FORMAT RGB_R RGB_G RGB_B D_VIS END_DATA_FORMAT "
                               "BEGIN_DATA\n255 255 255 .07\n0 0 0 1.44\nEND_DATA\n";
    ration r = {.left = 10};
    const lcor_allocator allocator = {ration_alloc, ration_free, &r};
    lcor_profile *profile = NULL;
    assert_int_equal(lcor_profile_parse(text, sizeof text - 1, &allocator, &profile, NULL),
                     LCOR_OK);
    lcor_profile_free(profile);
    assert_int_equal(r.live, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(contrast_is_of_the_medians),
        cmocka_unit_test(rejected_readings_are_kept_and_take_no_part),
        cmocka_unit_test(the_interval_is_students),
        cmocka_unit_test(equal_readings_are_no_better_than_the_resolution),
        cmocka_unit_test(one_reading_has_no_interval),
        cmocka_unit_test(students_quantile_is_that_of_the_tables),
        cmocka_unit_test(what_gives_no_contrast_is_told),
        cmocka_unit_test(wrong_readings_are_refused),
        cmocka_unit_test(keywords_are_set_replaced_and_removed),
        cmocka_unit_test(a_small_buffer_gets_what_fits),
        cmocka_unit_test(a_profile_holds_what_its_text_will_hold),
        cmocka_unit_test(short_memory_at_any_allocation_is_told_and_leaks_nothing),
        cmocka_unit_test(memory_is_bounded_by_the_text),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
