/* SPDX-License-Identifier: MIT */
/* Tables of other programs become CGATS text with the same line numbers. */
#include "testing.h"

#include "command/import_table.h"

#include <lcor/profile.h>

/* Contrast of a table, or 0 after copying why there is none. */
static double contrast_of(const char *text, char *why, size_t capacity)
{
    buffer cgats = {0};
    char problem[160] = "";
    double contrast = 0.0;
    lcor_profile *profile = NULL;
    lcor_error err = {.text = ""};
    assert_false(import_is_cgats(text, strlen(text)));
    if (!import_table(text, strlen(text), &cgats, problem, sizeof problem)) {
        snprintf(why, capacity, "%s", problem);
    } else if (lcor_profile_import(cgats.bytes, cgats.size, LCOR_BLACK_FULL, NULL, &profile,
                                   &err) != LCOR_OK) {
        snprintf(why, capacity, "%s", err.text);
    } else {
        contrast = lcor_profile_contrast(profile);
    }
    lcor_profile_free(profile);
    buffer_free(&cgats);
    return contrast;
}

static void reads_as(const char *text, double contrast)
{
    char why[256] = "";
    const double got = contrast_of(text, why, sizeof why);
    if (!(fabs(got - contrast) <= 1e-6 * contrast))
        fail_msg("%s: contrast %g, expected %g (%s)", text, got, contrast, why);
}

static void refused(const char *text, const char *expected)
{
    char why[256] = "";
    if (contrast_of(text, why, sizeof why) != 0.0)
        fail_msg("read although wrong: %s", text);
    if (!strstr(why, expected))
        fail_msg("'%s', expected '%s'", why, expected);
}

#define D137 23.442288153199225

static void common_tables_are_read(void **unused)
{
    (void)unused;
    reads_as("R,G,B,D\n255,255,255,0.07\n0,0,0,1.44\n", D137);
    reads_as("R;G;B;density\r\n255;255;255;0.07\r\n0;0;0;1.44\r\n", D137);
    reads_as("ID\tR\tG\tB\tVisual\n1\t255\t255\t255\t0.07\n2\t0\t0\t0\t1.44", D137);
    reads_as("\xEF\xBB\xBF\"R\", \"G\" ,B,D_VIS\n\"255\",255,255,\"0.07\"\n0,0,0,1.44\n", D137);
    reads_as("# measured today\n\nSAMPLE_NAME,rgb_r,rgb_g,rgb_b,d_vis,note\n\n"
             "\"a, \"\"b\"\"\",255,255,255,0.07,x\n# between\nblack,0,0,0,1.44,\n,,,,,\n",
             D137);
    reads_as("C,M,Y,K,XYZ_X,XYZ_Y,XYZ_Z\n0,0,0,0,84.48,87.62,74.57\n0,0,0,100,2.02,2.1,1.73\n",
             87.62 / 2.1);
    reads_as("R,G,B,X,Y,Z\n255,255,255,95,100,109\n0,0,0,.95,1,1.09\n", 100.0);
    reads_as("R,G,B,L*,a*,b*\n255,255,255,100,0,0\n0,0,0,8,0,0\n", 24389.0 / 216.0);
}

static void white_and_black_by_name_need_no_device_values(void **unused)
{
    (void)unused;
    reads_as("patch,density\nwhite,0.07\nWhite,0.07\nblack,1.44\n", D137);
    reads_as("density,name\n0.07,Paper\n1.44,BLACK\n", D137);
    refused("patch,density\nwhite,0.07\ngrey,0.6\nblack,1.44\n", "line 3: a patch that is neither");
}

static void rejected_readings_stay_rejected(void **unused)
{
    (void)unused;
    reads_as("R,G,B,D,LCOR_REJECTED\n255,255,255,0.07,0\n255,255,255,0.9,1\n255,255,255,0.8,1\n"
             "0,0,0,1.44,0\n",
             D137);
}

static void what_is_wrong_names_its_line(void **unused)
{
    (void)unused;
    refused("", "empty");
    refused("# only a comment\n", "empty");
    refused("hello world\n", "line 1: neither CGATS text nor a table");
    refused("R,G,B,D\n255,255,255,0.07\n0,0,0\n", "line 3: fewer cells");
    refused("R,G,B,D\n255,255,255,0.07,9\n0,0,0,1.44\n", "line 2: more cells");
    refused("R;G;B;D\n255;255;255;0,07\n0;0;0;1,44\n", "line 2: '0,07' has a comma");
    refused("R,G,B,D\n255,255,255,0.07\n0,0,0,1.44x\n", "line 3: '1.44x' is not a number");
    refused("R,G,B,D\n255,255,255,0.07\n0,0,0,\n", "line 3: '' is not a number");
    refused("R,G,B,D\n255,255,255,\"0.07\n0,0,0,1.44\n", "line 2: a quote");
    refused("R,G,B,D\n\n# x\n255,255,255,0.07\n0,0,0,99\n", "line 5:");
    refused("R,G,B\n255,255,255\n0,0,0\n", "no column D_VIS");
    refused("D,E\n0.07,1\n1.44,1\n", "which patch");
}

static void cgats_text_is_recognised(void **unused)
{
    (void)unused;
    assert_true(import_is_cgats("CTI3\nBEGIN_DATA_FORMAT\n", 23));
    assert_true(import_is_cgats("BEGIN_DATA", 10));
    assert_false(import_is_cgats("BEGIN_DAT", 9));
    assert_false(import_is_cgats("", 0));
    assert_false(import_is_cgats("BBBBBBBB", 8));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(common_tables_are_read),
        cmocka_unit_test(white_and_black_by_name_need_no_device_values),
        cmocka_unit_test(rejected_readings_stay_rejected),
        cmocka_unit_test(what_is_wrong_names_its_line),
        cmocka_unit_test(cgats_text_is_recognised),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
