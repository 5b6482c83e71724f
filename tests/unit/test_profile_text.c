/* SPDX-License-Identifier: MIT */
/* Texts as lccal and other programs write them: the right value, or an error that names the line.
 */
#include "testing.h"

#include <lcor/profile.h>

#include <locale.h>

#define HEAD   "CGATS.17\n"
#define FORMAT "BEGIN_DATA_FORMAT\nSAMPLE_ID RGB_R RGB_G RGB_B D_VIS\nEND_DATA_FORMAT\n"
#define ROWS   "BEGIN_DATA\n1 255 255 255 0.07\n2 0 0 0 1.44\nEND_DATA\n"
#define XYZ_FORMAT                                                                                 \
    "BEGIN_DATA_FORMAT\nCMYK_C CMYK_M CMYK_Y CMYK_K XYZ_X XYZ_Y XYZ_Z\nEND_DATA_FORMAT\n"

#define CONTRAST 23.442288153199225 /* 10^1.37 */

static lcor_profile *parse_bytes(const char *text, size_t n)
{
    lcor_error err = {.text = ""};
    lcor_profile *profile = NULL;
    if (lcor_profile_parse(text, n, NULL, &profile, &err) != LCOR_OK)
        fail_msg("not read: %s", err.text);
    return profile;
}

static void reads_as(const char *text, double contrast)
{
    lcor_profile *profile = parse_bytes(text, strlen(text));
    check_near(lcor_profile_contrast(profile), contrast, 1e-9 * contrast, text);
    lcor_profile_free(profile);
}

static void refused_as(const char *text, lcor_profile_black black, long line, const char *why)
{
    lcor_error err = {.text = ""};
    lcor_profile *profile = NULL;
    if (lcor_profile_import(text, strlen(text), black, NULL, &profile, &err) != LCOR_ERR_FORMAT)
        fail_msg("read although wrong: %s", text);
    assert_null(profile);
    assert_int_equal(err.status, LCOR_ERR_FORMAT);
    if (err.where != line || !strstr(err.text, why))
        fail_msg("line %ld '%s', expected line %ld '%s'", err.where, err.text, line, why);
    assert_null(strchr(err.text, '\n'));
}

static void refused(const char *text, long line, const char *why)
{
    refused_as(text, LCOR_BLACK_FULL, line, why);
}

static char *load(const char *name, size_t *size)
{
    char path[512];
    snprintf(path, sizeof path, "%s/device/%s", LCOR_TEST_DATA, name);
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    char *text = calloc(1, 1 << 20);
    assert_non_null(text);
    *size = fread(text, 1, 1 << 20, file);
    fclose(file);
    return text;
}

static void check_device(const char *name, lcor_profile_black black, double d_min, double d_max,
                         double contrast)
{
    size_t size;
    lcor_error err;
    lcor_profile *profile = NULL;
    lcor_profile_result r;
    char *text = load(name, &size);
    assert_int_equal(lcor_profile_import(text, size, black, NULL, &profile, &err), LCOR_OK);
    assert_int_equal(lcor_profile_count(profile), 1617);
    assert_int_equal(lcor_profile_evaluate(profile, &r, &err), LCOR_OK);
    check_near(r.d_min, d_min, 0.00005, name);
    check_near(r.d_max, d_max, 0.00005, name);
    check_near(r.contrast, contrast, 0.005, name);
    lcor_profile_free(profile);
    free(text);
}

static void real_printing_conditions_give_their_contrast(void **unused)
{
    (void)unused;
    check_device("FOGRA39L.ti3", LCOR_BLACK_FULL, 0.0574, 1.6778, 41.72);
    check_device("TR006.ti3", LCOR_BLACK_FULL, 0.0574, 1.7212, 46.116);
    check_device("FOGRA39L.ti3", LCOR_BLACK_DARKEST, 0.0574, 2.0605, 100.71);
}

/* The bytes of a real file cut anywhere: its value, or an error; a cut never makes another value.
 */
static void a_file_cut_anywhere_is_refused_or_right(void **unused)
{
    (void)unused;
    size_t size;
    char *text = load("FOGRA39L.ti3", &size);
    size_t read = 0;
    uint64_t state = 5;
    for (int i = 0; i < 400; i++) {
        const size_t n = i < 40 ? size - (size_t)i : (size_t)(random_unit(&state) * (double)size);
        lcor_error err;
        lcor_profile *profile = NULL;
        if (lcor_profile_parse(text, n, NULL, &profile, &err) == LCOR_OK) {
            check_near(lcor_profile_contrast(profile), 41.72, 0.005, "cut");
            read++;
        } else {
            assert_int_equal(err.status, LCOR_ERR_FORMAT);
        }
        lcor_profile_free(profile);
    }
    assert_in_range(read, 1, 4); /* only without the last line end or the carriage return */
    free(text);
}

static void line_ends_marks_and_comments_do_not_matter(void **unused)
{
    (void)unused;
    reads_as(HEAD FORMAT ROWS, CONTRAST);
    reads_as("CTI3\r\nDESCRIPTOR \"x\"\r\nBEGIN_DATA_FORMAT\r\nRGB_R RGB_G RGB_B D_VIS\r\n"
             "END_DATA_FORMAT\r\nBEGIN_DATA\r\n100 100 100 0.07\r\n0 0 0 1.44\r\nEND_DATA\r\n",
             CONTRAST);
    reads_as("IT8.7/1\rBEGIN_DATA_FORMAT\rRGB_R RGB_G RGB_B D_VIS\rEND_DATA_FORMAT\rBEGIN_DATA\r"
             "255 255 255 0.07\r0 0 0 1.44\rEND_DATA\r",
             CONTRAST);
    reads_as("\xEF\xBB\xBF" HEAD FORMAT ROWS, CONTRAST);
    reads_as(HEAD "# comment \"with a quote\nKEYWORD \"X\" # trailing\nX \"y\" trailing words\n"
                  "NUMBER_OF_FIELDS 5 # five\n" FORMAT "# between\nNUMBER_OF_SETS 2\t# two\n"
                  "BEGIN_DATA\n# inside\n1\t255\t255\t255\t0.07\t# white\n\n2 0 0 0 1.44\n"
                  "END_DATA  \n",
             CONTRAST);
    reads_as(FORMAT ROWS, CONTRAST); /* no first line at all */
    reads_as("BEGIN_DATA_FORMAT rgb_r rgb_g rgb_b d_vis END_DATA_FORMAT BEGIN_DATA\n"
             "255 255 255 0.07\n0 0 0 1.44\nEND_DATA",
             CONTRAST);
}

static void a_missing_end_of_the_format_is_seen(void **unused)
{
    (void)unused;
    reads_as(HEAD "BEGIN_DATA_FORMAT\nSAMPLE_ID RGB_R RGB_G RGB_B D_VIS\n" ROWS, CONTRAST);
    reads_as(HEAD "BEGIN_DATA_FORMAT\nSAMPLE_ID RGB_R RGB_G RGB_B D_VIS\nNUMBER_OF_SETS 2\n" ROWS,
             CONTRAST);
    reads_as(HEAD "BEGIN_DATA_FORMAT\nSAMPLE_ID RGB_R RGB_G RGB_B D_VIS\nKEYWORD \"N\"\n" ROWS,
             CONTRAST);
}

static void the_number_of_sets_of_other_programs_is_not_trusted(void **unused)
{
    (void)unused;
    reads_as(HEAD FORMAT "NUMBER_OF_SETS 99999999999999999999\n" ROWS, CONTRAST);
    reads_as(HEAD FORMAT "NUMBER_OF_SETS 1\n" ROWS, CONTRAST);
    reads_as(HEAD "NUMBER_OF_FIELDS 4294967296\n" FORMAT ROWS, CONTRAST);
    refused(HEAD FORMAT "NUMBER_OF_SETS many\n" ROWS, 5, "is not the number");
    refused(HEAD FORMAT "NUMBER_OF_SETS -2\n" ROWS, 5, "is not the number");
    refused_as(HEAD FORMAT "NUMBER_OF_SETS 3\n" ROWS, LCOR_BLACK_DARKEST, -1, "darkest");
}

static void scales_of_device_values_are_recognised(void **unused)
{
    (void)unused;
    static const char *const full[] = {"255", "100", "1", "1.0", "65535", "1023"};
    for (size_t i = 0; i < sizeof full / sizeof full[0]; i++) {
        char text[512];
        snprintf(text, sizeof text,
                 HEAD FORMAT "BEGIN_DATA\n1 %s %s %s 0.07\n2 0 0 0 1.44\nEND_DATA\n", full[i],
                 full[i], full[i]);
        reads_as(text, CONTRAST);
    }
    refused(HEAD FORMAT "BEGIN_DATA\n1 200 200 200 0.07\n2 0 0 0 1.44\nEND_DATA\n", 8, "RGB");
}

static void luminance_and_lightness_give_densities(void **unused)
{
    (void)unused;
    reads_as(HEAD XYZ_FORMAT "BEGIN_DATA\n0 0 0 0 84.48 87.62 74.57\n0 0 0 100 2.02 2.10 1.73\n"
                             "END_DATA\n",
             87.62 / 2.10);
    reads_as(HEAD XYZ_FORMAT "BEGIN_DATA\n0 0 0 0 .8448 .8762 .7457\n0 0 0 100 .0202 .0210 .0173\n"
                             "END_DATA\n",
             87.62 / 2.10); /* Y in 0..1 */
    reads_as("CTI3\nKEYWORD \"DEVICE_CLASS\"\nDEVICE_CLASS \"DISPLAY\"\nBEGIN_DATA_FORMAT\n"
             "RGB_R RGB_G RGB_B XYZ_X XYZ_Y XYZ_Z\nEND_DATA_FORMAT\nBEGIN_DATA\n"
             "100 100 100 95 100 109\n0 0 0 .1 .125 .2\nEND_DATA\n",
             800.0);
    reads_as(HEAD "BEGIN_DATA_FORMAT\nRGB_R RGB_G RGB_B LAB_L LAB_A LAB_B\nEND_DATA_FORMAT\n"
                  "BEGIN_DATA\n255 255 255 100 0 0\n0 0 0 8 0 0\nEND_DATA\n",
             24389.0 / 216.0); /* L* = 8 is Y/Yn = (6/29)^3 */
}

static void luminance_from_0_to_1_gives_the_same_densities(void **unused)
{
    (void)unused;
    static const char text[] = HEAD XYZ_FORMAT "BEGIN_DATA\n0 0 0 0 .8448 .8762 .7457\n"
                                               "0 0 0 100 .0202 .0210 .0173\nEND_DATA\n";
    lcor_profile_result r;
    lcor_profile *profile = parse_bytes(text, sizeof text - 1);
    assert_int_equal(lcor_profile_evaluate(profile, &r, NULL), LCOR_OK);
    check_near(r.d_min, -log10(0.8762), 1e-9, "d_min");
    check_near(lcor_profile_resolution(profile), 0.01, 1e-12, "resolution");
    lcor_profile_free(profile);
}

static void mislabelled_columns_are_refused(void **unused)
{
    (void)unused;
    refused(HEAD FORMAT "BEGIN_DATA\n1 255 255 255 84.48\n2 0 0 0 2.02\nEND_DATA\n", 6,
            "no density");
    refused(HEAD
            "BEGIN_DATA_FORMAT\nRGB_R RGB_G RGB_B D_RED D_GREEN D_BLUE\nEND_DATA_FORMAT\n" ROWS,
            5, "no column D_VIS");
    refused(HEAD "BEGIN_DATA_FORMAT\nRGB_R RGB_G RGB_B XYZ_X XYZ_Y\nEND_DATA_FORMAT\n" ROWS, 5,
            "some are missing");
    refused(HEAD "BEGIN_DATA_FORMAT\nSAMPLE_ID D_VIS\nEND_DATA_FORMAT\n" ROWS, 5, "which patch");
    refused(HEAD "BEGIN_DATA_FORMAT\nD_VIS D_VIS RGB_R RGB_G RGB_B\nEND_DATA_FORMAT\n" ROWS, 3,
            "twice");
    /* L*a*b* under the names of XYZ */
    refused(HEAD XYZ_FORMAT "BEGIN_DATA\n0 0 0 0 95.0 -0.02 -1.96\n0 0 0 100 16 0 0\nEND_DATA\n", 6,
            "XYZ_Y");
    refused(HEAD XYZ_FORMAT "BEGIN_DATA\n0 0 0 0 95.0 1.9 -1.96\n0 0 0 100 16 .1 0\nEND_DATA\n", -1,
            "no white");
    refused(HEAD XYZ_FORMAT "BEGIN_DATA\n0 0 0 0 84 87 74\n0 0 0 100 2 -0.01 1\nEND_DATA\n", 7,
            "not greater than 0");
    /* XYZ_X and XYZ_Y exchanged, told by L* */
    refused(HEAD "BEGIN_DATA_FORMAT\nRGB_R RGB_G RGB_B XYZ_Y XYZ_X XYZ_Z LAB_L LAB_A LAB_B\n"
                 "END_DATA_FORMAT\nBEGIN_DATA\n255 255 255 84.48 87.62 74.57 95 0 -2\n"
                 "0 0 0 2.02 2.10 1.73 16 0 0\nEND_DATA\n",
            6, "contradict");
    /* densities that do not belong to the XYZ beside them */
    refused(HEAD
            "BEGIN_DATA_FORMAT\nRGB_R RGB_G RGB_B D_VIS XYZ_X XYZ_Y XYZ_Z\nEND_DATA_FORMAT\n"
            "BEGIN_DATA\n255 255 255 0.06 84.48 87.62 74.57\n0 0 0 1.1 2.02 2.10 1.73\nEND_DATA\n",
            -1, "different contrasts");
    /* black and white exchanged */
    refused(HEAD FORMAT "BEGIN_DATA\n1 255 255 255 1.44\n2 0 0 0 0.07\nEND_DATA\n", -1,
            "lighter than white");
    refused(HEAD FORMAT "BEGIN_DATA\n1 255 255 255 0.07\n2 9 0 0 0.01\n3 0 0 0 1.4\nEND_DATA\n", -1,
            "lighter than white");
}

static void broken_rows_name_their_line(void **unused)
{
    (void)unused;
    refused(HEAD FORMAT "BEGIN_DATA\n1 255 255 255 0,07\n2 0 0 0 1.44\nEND_DATA\n", 6, "comma");
    refused(HEAD FORMAT "BEGIN_DATA\n1 255 255 255 nan\n2 0 0 0 1.44\nEND_DATA\n", 6,
            "not a number");
    refused(HEAD FORMAT "BEGIN_DATA\n1 255 255 255 0x1\n2 0 0 0 1.44\nEND_DATA\n", 6,
            "not a number");
    refused(HEAD FORMAT "BEGIN_DATA\n1 255 255 255\n2 0 0 0 1.44\nEND_DATA\n", 6, "4 fields");
    refused(HEAD FORMAT "BEGIN_DATA\n1 255 255 255 0.07 3\n2 0 0 0 1.44\nEND_DATA\n", 6,
            "more fields");
    refused(HEAD FORMAT "BEGIN_DATA\n1 255 255 255 0.07\n2 0 0 0 \"1.44\nEND_DATA\n", 7, "quote");
    refused(HEAD FORMAT "BEGIN_DATA\n1 255 255 255 0.07\n2 -1 0 0 1.44\nEND_DATA\n", 7, "negative");
    refused(HEAD FORMAT "BEGIN_DATA\n1 255 255 255 0.07\n2 0 0 0 1.44\n", 8, "cut short");
    refused(HEAD FORMAT "BEGIN_DATA\nEND_DATA\n", 6, "no readings");
    refused(HEAD FORMAT "BEGIN_DATA\n1 255 255 255 0.07\nEND_DATA\n", -1, "no reading of black");
    refused(HEAD FORMAT "BEGIN_DATA\n1 0 0 0 1.4\n2 255 0 0 0.9\nEND_DATA\n", -1,
            "no reading of white");
}

static void lines_are_counted_whatever_ends_them(void **unused)
{
    (void)unused;
    refused("CTI3\r\nNUMBER_OF_SETS 1\r\nNUMBER_OF_SETS x\r\n", 3, "line 3:");
    refused("CTI3\rNUMBER_OF_SETS 1\r\rNUMBER_OF_SETS x\r", 4, "line 4:");
    refused("CTI3\nNUMBER_OF_SETS 1\n\nNUMBER_OF_SETS x\n", 4, "line 4:");
}

static void what_is_no_profile_is_refused(void **unused)
{
    (void)unused;
    refused("", 1, "not CGATS");
    refused("hello\nworld\n", 3, "not CGATS");
    refused("\xFF\xFE"
            "C\0G\0",
            1, "UTF-16");
    refused(HEAD "BEGIN_DATA\n", 2, "without a data format");
    refused(HEAD FORMAT FORMAT ROWS, 5, "second");
    refused(HEAD "BEGIN_DATA_FORMAT\nRGB_R", 3, "ends inside");
    lcor_error err;
    lcor_profile *profile = NULL;
    assert_int_equal(lcor_profile_parse("\0\0\0\0", 4, NULL, &profile, &err), LCOR_ERR_FORMAT);
    assert_int_equal(lcor_profile_parse(NULL, 4, NULL, &profile, &err), LCOR_ERR_ARG);
    assert_int_equal(lcor_profile_parse("x", 1, NULL, NULL, &err), LCOR_ERR_ARG);
}

static void provenance_is_kept_as_utf8(void **unused)
{
    (void)unused;
    static const char text[] =
        HEAD "ORIGINATOR \"M\xFCller \"\"A\"\"\"\nMATERIAL  glossy paper # note\n"
             "SERIAL \"\xC3\xA9\"\nodd-name \"dropped\"\n" FORMAT ROWS;
    lcor_profile *profile = parse_bytes(text, sizeof text - 1);
    assert_string_equal(lcor_profile_keyword(profile, "ORIGINATOR"), "M\xC3\xBCller 'A'");
    assert_string_equal(lcor_profile_keyword(profile, "MATERIAL"), "glossy paper");
    assert_string_equal(lcor_profile_keyword(profile, "SERIAL"), "\xC3\xA9");
    assert_null(lcor_profile_keyword(profile, "odd-name"));
    assert_int_equal(lcor_profile_keyword_count(profile), 3);
    lcor_profile_free(profile);
}

/* A profile as lccal writes it, made by hand so that the format cannot drift unnoticed. */
#define OWN(contrast, u95)                                                                         \
    HEAD "KEYWORD \"LCOR_PROFILE_VERSION\"\nLCOR_PROFILE_VERSION \"1\"\n"                          \
         "KEYWORD \"LCOR_CONTRAST\"\nLCOR_CONTRAST \"" contrast "\"\n"                             \
         "KEYWORD \"LCOR_CONTRAST_U95\"\nLCOR_CONTRAST_U95 \"" u95 "\"\n" FORMAT                   \
         "NUMBER_OF_SETS 2\n"

static void derived_values_are_compared(void **unused)
{
    (void)unused;
    reads_as(OWN("23.4423", "0") ROWS, CONTRAST);
    refused(OWN("23.5", "0") ROWS, -1, "edited");
    refused(OWN("23.4423", "0.5") ROWS, -1, "edited");
    refused(OWN("23.4423", "0") "BEGIN_DATA\n1 255 255 255 0.07\nEND_DATA\n", 14, "cut or edited");
    refused(HEAD "LCOR_PROFILE_VERSION \"2\"\n" FORMAT ROWS, 2, "another version");
    refused(HEAD "LCOR_BLACK \"GREY\"\n" FORMAT ROWS, 2, "neither FULL nor DARKEST");
}

static void a_comma_locale_changes_nothing(void **unused)
{
    (void)unused;
    if (!setlocale(LC_ALL, "de_DE.UTF-8") && !setlocale(LC_ALL, "de_DE"))
        skip();
    reads_as(HEAD FORMAT ROWS, CONTRAST);
    setlocale(LC_ALL, "C");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(real_printing_conditions_give_their_contrast),
        cmocka_unit_test(a_file_cut_anywhere_is_refused_or_right),
        cmocka_unit_test(line_ends_marks_and_comments_do_not_matter),
        cmocka_unit_test(a_missing_end_of_the_format_is_seen),
        cmocka_unit_test(the_number_of_sets_of_other_programs_is_not_trusted),
        cmocka_unit_test(scales_of_device_values_are_recognised),
        cmocka_unit_test(luminance_and_lightness_give_densities),
        cmocka_unit_test(luminance_from_0_to_1_gives_the_same_densities),
        cmocka_unit_test(mislabelled_columns_are_refused),
        cmocka_unit_test(broken_rows_name_their_line),
        cmocka_unit_test(lines_are_counted_whatever_ends_them),
        cmocka_unit_test(what_is_no_profile_is_refused),
        cmocka_unit_test(provenance_is_kept_as_utf8),
        cmocka_unit_test(derived_values_are_compared),
        cmocka_unit_test(a_comma_locale_changes_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
