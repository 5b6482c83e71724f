/* SPDX-License-Identifier: MIT */
/* Replaying and recording dialogues. */
#define _XOPEN_SOURCE 700
#include "testing.h"
#include "transport/transport.h"

#include <string.h>
#include <unistd.h>

static transport *open_script(const char *text)
{
    transport *t;
    cal_error err;
    assert_int_equal(script_open_text(text, strlen(text), &t, &err), CAL_OK);
    return t;
}

static void dialogue_is_replayed(void **state)
{
    (void)state;
    transport *t = open_script("# two words\nd 0 /dev/ttyACM0\nw 0 A^M\nr 30 ^@^_^`~\xff\n");
    char bytes[8];
    size_t got;
    assert_int_equal(t->ops->read(t, bytes, sizeof bytes, &got, 100), CAL_TIMEOUT);
    assert_int_equal(t->ops->now_ms(t), 100);
    assert_int_equal(t->ops->write(t, "A\r", 2, 100), CAL_OK);
    assert_int_equal(t->ops->read(t, bytes, sizeof bytes, &got, 29), CAL_TIMEOUT);
    assert_int_equal(t->ops->read(t, bytes, 2, &got, 10), CAL_OK);
    assert_int_equal(t->ops->now_ms(t), 130);
    assert_int_equal(got, 2);
    assert_memory_equal(bytes, "\0\x1f", 2);
    assert_int_equal(t->ops->read(t, bytes, sizeof bytes, &got, 10), CAL_OK);
    assert_int_equal(got, 3);
    assert_memory_equal(bytes, "^~\xff", 3);
    assert_int_equal(t->ops->read(t, bytes, sizeof bytes, &got, 1000), CAL_TIMEOUT);
    t->ops->close(t);
}

static void what_was_not_recorded_may_not_be_said(void **state)
{
    (void)state;
    transport *t = open_script("w 0 ABC\n");
    assert_int_equal(t->ops->write(t, "A", 1, 100), CAL_OK);
    assert_int_equal(t->ops->write(t, "BX", 2, 100), CAL_PROTOCOL);
    assert_int_equal(t->ops->write(t, "BC", 2, 100), CAL_OK);
    assert_int_equal(t->ops->write(t, "to nobody", 9, 100), CAL_OK);
    t->ops->close(t);
}

static void hang_up_ends_everything(void **state)
{
    (void)state;
    transport *t = open_script("r 10 A\nh 20\n");
    char byte;
    size_t got;
    assert_int_equal(t->ops->read(t, &byte, 1, &got, 100), CAL_OK);
    assert_int_equal(t->ops->read(t, &byte, 1, &got, 10), CAL_TIMEOUT);
    assert_int_equal(t->ops->read(t, &byte, 1, &got, 100), CAL_GONE);
    assert_int_equal(t->ops->now_ms(t), 30);
    assert_int_equal(t->ops->write(t, "x", 1, 100), CAL_GONE);
    t->ops->close(t);
}

static void lines_that_are_no_steps_are_refused(void **state)
{
    (void)state;
    static const char *const bad[] = {"x 0 A\n",    "w A\n",     "w -1 A\n",       "r 1\n",
                                      "r 1 \n",     "r 1 ^\n",   "r 1 ^a\n",       "w\n",
                                      "nonsense\n", "r 1e3 A\n", "r 999999999 A\n"};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        transport *t;
        cal_error err;
        char text[64];
        snprintf(text, sizeof text, "# first\n%s", bad[i]);
        assert_int_equal(script_open_text(text, strlen(text), &t, &err), CAL_NO_DEVICE);
        assert_non_null(strstr(err.text, "line 2"));
    }
}

static void recording_reads_back_as_it_was(void **state)
{
    (void)state;
    char path[] = "/tmp/lccal-record-XXXXXX", all[256], back[256];
    const int fd = mkstemp(path);
    assert_true(fd >= 0);
    close(fd);
    cal_error err;
    size_t got;
    transport *t = open_script("w 0 ^@^M^`x\nr 7 ^J^`\xfe y\nh 3\n");
    assert_int_equal(record_open(t, path, &t, &err), CAL_OK);
    assert_int_equal(t->ops->write(t, "\0\r^x", 4, 100), CAL_OK);
    assert_int_equal(t->ops->read(t, back, sizeof back, &got, 100), CAL_OK);
    assert_int_equal(t->ops->read(t, back, sizeof back, &got, 100), CAL_GONE);
    t->ops->close(t);
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    got = fread(all, 1, sizeof all, file);
    fclose(file);
    static const char expected[] = "d 0 \nw 0 ^@^M^`x\nr 7 ^J^`\xfe y\nh 3 \n";
    assert_int_equal(got, sizeof expected - 1);
    assert_memory_equal(all, expected, got);
    char port[64];
    snprintf(port, sizeof port, "script:%s", path);
    assert_int_equal(transport_open(port, &t, &err), CAL_OK);
    assert_int_equal(t->ops->write(t, "\0\r^x", 4, 100), CAL_OK);
    assert_int_equal(t->ops->read(t, back, sizeof back, &got, 100), CAL_OK);
    assert_int_equal(got, 5);
    assert_memory_equal(back, "\n^\xfe y", 5);
    t->ops->close(t);
    unlink(path);
}

static void recording_that_cannot_be_written_is_told(void **state)
{
    (void)state;
    cal_error err;
    transport *t = open_script("");
    assert_int_equal(record_open(t, "/none/record", &t, &err), CAL_IO);
    assert_non_null(strstr(err.text, "/none/record"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(dialogue_is_replayed),
        cmocka_unit_test(what_was_not_recorded_may_not_be_said),
        cmocka_unit_test(hang_up_ends_everything),
        cmocka_unit_test(lines_that_are_no_steps_are_refused),
        cmocka_unit_test(recording_reads_back_as_it_was),
        cmocka_unit_test(recording_that_cannot_be_written_is_told),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
