/* SPDX-License-Identifier: MIT */
#include "number.h"
#include "testing.h"

#include <locale.h>
#include <string.h>

static void numbers_are_read(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        double value;
    } good[] = {{"0", 0.0},
                {"1.37", 1.37},
                {"-0.05", -0.05},
                {"+1.37", 1.37},
                {".278", 0.278},
                {"5.", 5.0},
                {"123456789012345", 123456789012345.0},
                {"007", 7.0},
                {"-.5", -0.5},
                {"0.000000001", 1e-9}};
    for (size_t i = 0; i < sizeof good / sizeof good[0]; i++) {
        double value = 99.0;
        assert_true(lccal_parse_number(good[i].text, strlen(good[i].text), &value));
        assert_true(value == good[i].value);
    }
}

static void what_is_no_number_is_refused(void **state)
{
    (void)state;
    static const char *const bad[] = {"",
                                      "-",
                                      "+",
                                      ".",
                                      "-.",
                                      "1,37",
                                      "1e3",
                                      "nan",
                                      "inf",
                                      "0x10",
                                      "1.3.7",
                                      " 1",
                                      "1 ",
                                      "--1",
                                      "1-",
                                      "EEE",
                                      "---",
                                      "....",
                                      "1.3x",
                                      "\xff",
                                      "1.37D",
                                      "+-1",
                                      "1234567890123456"};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        double value = 99.0;
        assert_false(lccal_parse_number(bad[i], strlen(bad[i]), &value));
        assert_true(value == 99.0);
    }
}

static void only_the_given_length_is_read(void **state)
{
    (void)state;
    double value;
    assert_true(lccal_parse_number("1.379", 4, &value));
    assert_true(value == 1.37);
    assert_false(lccal_parse_number("1", 0, &value));
}

static void numbers_are_written(void **state)
{
    (void)state;
    static const struct {
        double value;
        int decimals;
        const char *text;
    } cases[] = {{1.37, 2, "1.37"},          {0.0, 3, "0.000"},
                 {-0.001, 2, "0.00"},        {-0.05, 2, "-0.05"},
                 {23.4000022, 4, "23.4000"}, {1e11, 0, "100000000000"},
                 {0.999, 2, "1.00"},         {123.0, 0, "123"},
                 {-12.5, 0, "-13"},          {99999999.5, 9, "99999999.5000000"}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        char text[64];
        assert_string_equal(
            lccal_format_number(text, sizeof text, cases[i].value, cases[i].decimals),
            cases[i].text);
    }
}

static void text_that_does_not_fit_is_cut(void **state)
{
    (void)state;
    char text[4] = "xxx";
    assert_string_equal(lccal_format_number(text, sizeof text, 123.45, 2), "123");
}

static void what_is_written_reads_back(void **state)
{
    (void)state;
    uint64_t seed = 1;
    for (int i = 0; i < 100000; i++) {
        char text[64];
        double back;
        const double value = (random_unit(&seed) - 0.5) * 20000.0;
        lccal_format_number(text, sizeof text, value, 9);
        assert_true(lccal_parse_number(text, strlen(text), &back));
        assert_true(back - value < 6e-10 && value - back < 6e-10);
    }
}

static void the_locale_changes_nothing(void **state)
{
    if (!setlocale(LC_ALL, "de_DE.UTF-8") && !setlocale(LC_ALL, "de_DE.utf8") &&
        !setlocale(LC_ALL, "fr_FR.UTF-8")) {
        print_message("skipped: no locale with a decimal comma is installed\n");
        skip();
    }
    numbers_are_read(state);
    what_is_no_number_is_refused(state);
    numbers_are_written(state);
    setlocale(LC_ALL, "C");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(numbers_are_read),
        cmocka_unit_test(what_is_no_number_is_refused),
        cmocka_unit_test(only_the_given_length_is_read),
        cmocka_unit_test(numbers_are_written),
        cmocka_unit_test(text_that_does_not_fit_is_cut),
        cmocka_unit_test(what_is_written_reads_back),
        cmocka_unit_test(the_locale_changes_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
