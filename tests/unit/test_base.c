/* SPDX-License-Identifier: MIT */
#include "testing.h"

#include "base/internal.h"
#include <lcor/version.h>

static void every_status_has_its_name(void **state)
{
    (void)state;
    assert_string_equal(lcor_status_name(LCOR_OK), "LCOR_OK");
    assert_string_equal(lcor_status_name(LCOR_ERR_ARG), "LCOR_ERR_ARG");
    assert_string_equal(lcor_status_name(LCOR_ERR_DOMAIN), "LCOR_ERR_DOMAIN");
    assert_string_equal(lcor_status_name(LCOR_ERR_NOMEM), "LCOR_ERR_NOMEM");
    assert_string_equal(lcor_status_name(LCOR_ERR_CANCELLED), "LCOR_ERR_CANCELLED");
    assert_string_equal(lcor_status_name(LCOR_ERR_FORMAT), "LCOR_ERR_FORMAT");
    assert_string_equal(lcor_status_name((lcor_status)-77), "LCOR_ERR_UNKNOWN");
}

static void version_agrees_with_its_numbers(void **state)
{
    char text[32];

    (void)state;
    snprintf(text, sizeof text, "%d.%d.%d", LCOR_VERSION_MAJOR, LCOR_VERSION_MINOR,
             LCOR_VERSION_PATCH);
    assert_string_equal(lcor_version(), text);
}

static void long_error_texts_are_cut_and_terminated(void **state)
{
    lcor_error e;
    char text[400];

    (void)state;
    memset(text, 'x', sizeof text);
    text[sizeof text - 1] = '\0';
    assert_int_equal(lcor_internal_fail(&e, LCOR_ERR_ARG, 7, "%s", text), LCOR_ERR_ARG);
    assert_int_equal(e.status, LCOR_ERR_ARG);
    assert_int_equal(e.where, 7);
    assert_int_equal(strlen(e.text), sizeof e.text - 1);
    assert_int_equal(lcor_internal_fail(NULL, LCOR_ERR_NOMEM, -1, "no one listens"),
                     LCOR_ERR_NOMEM);
}

static void half_an_allocator_is_refused(void **state)
{
    lcor_allocator given, out;
    lcor_error e;

    (void)state;
    memset(&given, 0, sizeof given);
    assert_int_equal(lcor_internal_allocator(NULL, &given, &e), LCOR_OK); /* malloc and free */
    assert_non_null(given.alloc);
    given.free = NULL;
    assert_int_equal(lcor_internal_allocator(&given, &out, &e), LCOR_ERR_ARG);
    lcor_internal_free(&given, NULL); /* does nothing, so that no one calls through the NULL */
}

static void sizes_that_do_not_fit_are_noticed(void **state)
{
    size_t out = 5;

    (void)state;
    assert_int_equal(lcor_internal_size_mul(SIZE_MAX / 2, 3, &out), 0);
    assert_int_equal(out, 5);
    assert_int_equal(lcor_internal_size_mul(SIZE_MAX, 1, &out), 1);
    assert_true(out == SIZE_MAX);
    assert_int_equal(lcor_internal_size_mul(7, 0, &out), 1);
    assert_int_equal(out, 0);
    assert_int_equal(lcor_internal_size_add(SIZE_MAX, 1, &out), 0);
    assert_int_equal(lcor_internal_size_add(SIZE_MAX - 1, 1, &out), 1);
    assert_true(out == SIZE_MAX);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(every_status_has_its_name),
                                       cmocka_unit_test(version_agrees_with_its_numbers),
                                       cmocka_unit_test(long_error_texts_are_cut_and_terminated),
                                       cmocka_unit_test(half_an_allocator_is_refused),
                                       cmocka_unit_test(sizes_that_do_not_fit_are_noticed)};

    return cmocka_run_group_tests(tests, NULL, NULL);
}
