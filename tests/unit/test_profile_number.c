/* SPDX-License-Identifier: MIT */
#include "testing.h"

#include "profile/number.h"

#include <locale.h>

static int parses(const char *text, double *value)
{
    return lcor_internal_number_parse(text, strlen(text), value, NULL);
}

static void check_text(double value, int digits, const char *expected)
{
    char text[LCOR_NUMBER_SIZE];
    const size_t n = lcor_internal_number_format(value, digits, text);
    assert_string_equal(text, expected);
    assert_int_equal(n, strlen(expected));
}

static void numbers_are_read_exactly(void **unused)
{
    (void)unused;
    static const char *const texts[] = {
        "0",         "1",        "-1.5",   "+0.07",   "1.",
        ".5",        "84.48",    "1e3",    "1E-3",    "1.44e+0",
        "-0",        "1e22",     "2.1e-7", "0.00001", "65535",
        "123456789", "00012.50", "1e-400", "0e999",   "100.000000000000000000000000"};
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; i++) {
        double value = -42.0;
        assert_true(parses(texts[i], &value));
        assert_true(value == strtod(texts[i], NULL));
    }
}

static void many_digits_are_read_to_a_few_units_in_the_last_place(void **unused)
{
    (void)unused;
    static const char *const texts[] = {"3.14159265358979323846264338327950288",
                                        "123456789012345678901234567890", "1.7976931348623157e308",
                                        "0.000000000000000000000000000000123456789012345678"};
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; i++) {
        double value = -42.0;
        const double expected = strtod(texts[i], NULL);
        assert_true(parses(texts[i], &value));
        check_near(value / expected, 1.0, 1e-15, texts[i]);
    }
}

static void what_is_no_number_is_refused(void **unused)
{
    (void)unused;
    static const char *const texts[] = {"",    "-",    "+",    ".",     "e5",  "1e",   "1e+", "1,5",
                                        "nan", "inf",  "0x10", "1.2.3", "1 2", " 1",   "1 ",  "--1",
                                        "1d3", "1e5x", "NAN",  "INF",   "1_0", "1e999"};
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; i++) {
        double value = 42.0;
        assert_false(parses(texts[i], &value));
        assert_true(value == 42.0);
    }
}

static void decimals_are_counted(void **unused)
{
    (void)unused;
    static const struct {
        const char *text;
        int decimals;
    } cases[] = {{"1", 0}, {"1.0", 1}, {"2.10", 2}, {"0.070", 3}, {"144e-2", 2}, {"1.5e1", 0}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        double value;
        int decimals = -1;
        assert_true(
            lcor_internal_number_parse(cases[i].text, strlen(cases[i].text), &value, &decimals));
        assert_int_equal(decimals, cases[i].decimals);
    }
}

static void numbers_are_written_short(void **unused)
{
    (void)unused;
    check_text(0.0, 9, "0");
    check_text(-0.0, 9, "0");
    check_text(1.0, 9, "1");
    check_text(-1.5, 9, "-1.5");
    check_text(255.0, 9, "255");
    check_text(0.07, 9, "0.07");
    check_text(100.0, 1, "100");
    check_text(1234567890.0, 9, "1234567890");
    check_text(1.0 / 3.0, 9, "0.333333333");
    check_text(0.9999999999, 9, "1");
    check_text(999999.5, 6, "1000000");
    check_text(23.4000022, 6, "23.4");
    check_text(1e-6, 9, "0.000001");
    check_text(1.5e-9, 9, "1.5e-9");
    check_text(-2.25e30, 9, "-2.25e30");
}

static void any_number_survives_writing_and_reading(void **unused)
{
    (void)unused;
    uint64_t state = 3;
    for (int i = 0; i < 200000; i++) {
        const double size = pow(10.0, 40.0 * random_unit(&state) - 20.0);
        const double value = (random_unit(&state) - 0.5) * size;
        char text[LCOR_NUMBER_SIZE], again[LCOR_NUMBER_SIZE];
        double back;
        lcor_internal_number_format(value, 9, text);
        assert_true(parses(text, &back));
        check_near(back / value, 1.0, 5.0001e-9, text);
        lcor_internal_number_format(back, 9, again);
        assert_string_equal(text, again);
        assert_true(lcor_internal_number_round(value) == back);
    }
}

static void the_locale_does_not_matter(void **unused)
{
    (void)unused;
    if (!setlocale(LC_ALL, "de_DE.UTF-8") && !setlocale(LC_ALL, "de_DE"))
        print_message("no comma locale here; the functions call nothing that looks at one\n");
    double value;
    assert_true(parses("1.37", &value) && value == 1.37);
    assert_false(parses("1,37", &value));
    check_text(1.37, 9, "1.37");
    setlocale(LC_ALL, "C");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(numbers_are_read_exactly),
        cmocka_unit_test(many_digits_are_read_to_a_few_units_in_the_last_place),
        cmocka_unit_test(what_is_no_number_is_refused),
        cmocka_unit_test(decimals_are_counted),
        cmocka_unit_test(numbers_are_written_short),
        cmocka_unit_test(any_number_survives_writing_and_reading),
        cmocka_unit_test(the_locale_does_not_matter),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
