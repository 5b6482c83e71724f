/* SPDX-License-Identifier: MIT */
/* Drivers against scripted dialogues: no wire, and a clock of their own. */
#include "instrument/instrument.h"
#include "instrument/xrite-rci/rci.h"
#include "testing.h"

#include <string.h>

enum { WAIT_MS = 60000 };

#define GREETING                                                                                   \
    "w 0 GS V^M^J\nr 5 GS V,\"Printalyzer Densitometer\",\"v1.1.0\"^M^J\n"                         \
    "w 0 SM FORMAT,EXT^M^J\nr 5 SM FORMAT,OK^M^J\n"
#define INTERVIEW                                                                                  \
    "w 0 GS UID^M^J\nr 5 GS UID,0123456789ABCDEF01234567^M^J\n"                                    \
    "w 0 GS B^M^J\nr 5 GS B,\"2023-06-13 10:25\",\"v1\",\"D3C4A5B6\"^M^J\n"                        \
    "w 0 GS ISEN^M^J\nr 5 GS ISEN,3300mV,24.5C^M^J\n"                                              \
    "w 0 GC REFL^M^J\nr 5 GC REFL,3DA3D70A,3EA3E425,3FC00000,3C498C7E^M^J\n"                       \
    "w 0 GC TRAN^M^J\nr 5 GC TRAN,00000000,3F7CAC08,40400000,3A807358^M^J\n"
#define LINE_1_37 "R+1.37D,3FAF5C29,7FC00000,3C23D70A,3C1374BC^M^J"

static cal_status open_script(const char *name, const char *script, instrument *in)
{
    transport *port;
    cal_error err;
    assert_int_equal(script_open_text(script, strlen(script), &port, &err), CAL_OK);
    return instrument_open(name, port, 1000, in, &err);
}

static cal_status measure(instrument *in, reading *out)
{
    cal_error err;
    return in->driver->measure(in, WAIT_MS, out, &err);
}

static void printalyzer_tells_who_it_is_and_reads(void **state)
{
    (void)state;
    instrument in;
    reading r;
    assert_int_equal(open_script("printalyzer", GREETING INTERVIEW "r 3000 " LINE_1_37 "\n", &in),
                     CAL_OK);
    assert_string_equal(instrument_fact_get(&in, "firmware"), "v1.1.0");
    assert_string_equal(instrument_fact_get(&in, "serial"), "0123456789ABCDEF01234567");
    assert_string_equal(instrument_fact_get(&in, "format"), "extended");
    assert_string_equal(instrument_fact_get(&in, "calibration_reflection"),
                        "0.0800/0.320100 1.5000/0.012302");
    assert_int_equal(measure(&in, &r), CAL_OK);
    check_near(r.value, 1.37, 1e-6, "density");
    check_near(r.step, 0.001, 1e-15, "step");
    assert_int_equal(measure(&in, &r), CAL_TIMEOUT);
    instrument_close(&in);
}

static void reply_may_come_in_two_pieces_cut_anywhere(void **state)
{
    (void)state;
    static const char reply[] = "GS V,\"Printalyzer Densitometer\",\"v1.1.0\"";
    for (size_t cut = 1; cut < sizeof reply - 1; cut++) {
        char script[1024];
        snprintf(script, sizeof script,
                 "w 0 GS V^M^J\nr 5 %.*s\nr 5 %s^M\nr 5 ^J\n"
                 "w 0 SM FORMAT,EXT^M^J\nr 5 SM FORMAT,OK^M^J\n",
                 (int)cut, reply, reply + cut);
        instrument in;
        assert_int_equal(open_script("printalyzer", script, &in), CAL_OK);
        assert_string_equal(instrument_fact_get(&in, "model"), "Printalyzer Densitometer");
        instrument_close(&in);
    }
}

static void reply_cut_at_every_byte_is_no_reply(void **state)
{
    (void)state;
    static const char reply[] = "GS V,\"Printalyzer Densitometer\",\"v1.1.0\"";
    for (size_t cut = 0; cut < sizeof reply - 1; cut++) {
        char script[512];
        snprintf(script, sizeof script, "w 0 GS V^M^J\nr 5 %.*s^M^J\n", (int)(cut ? cut : 1),
                 cut ? reply : "x");
        instrument in;
        const cal_status status = open_script("printalyzer", script, &in);
        assert_true(status == CAL_PROTOCOL || status == CAL_TIMEOUT);
        instrument_close(&in);
    }
}

static void reading_cut_at_every_byte_is_no_reading(void **state)
{
    (void)state;
    static const char line[] = "R+1.37D,3FAF5C29,7FC00000,3C23D70A,3C1374BC";
    for (size_t cut = 0; cut < sizeof line - 1; cut++) {
        /* The basic form is whole after 7 bytes, and the one without the last count after 34. */
        char script[2048];
        snprintf(script, sizeof script,
                 GREETING INTERVIEW "r 100 %.*s\nr 2000 " LINE_1_37 "\nr 100 %.*s^M^J\n",
                 (int)(cut ? cut : 1), cut ? line : "R", (int)(cut ? cut : 1), cut ? line : "R");
        instrument in;
        reading r;
        assert_int_equal(open_script("printalyzer", script, &in), CAL_OK);
        /* What the pause broke off is dropped; the whole line after it counts. */
        assert_int_equal(measure(&in, &r), CAL_OK);
        check_near(r.value, 1.37, 1e-6, "density");
        const bool whole = cut == 7 || cut == 34;
        const cal_status next = measure(&in, &r);
        if (whole)
            assert_int_equal(next, CAL_OK);
        else
            assert_true(next == CAL_TIMEOUT || next == CAL_PROTOCOL);
        instrument_close(&in);
    }
}

static void damaged_readings_are_dropped(void **state)
{
    (void)state;
    static const char *const bad[] = {
        "R+1.38D,3FAF5C29,7FC00000,3C23D70A,3C1374BC", /* text and float disagree */
        "R+1.37D,3FAF5C29,7FC00000",                   /* fields missing */
        "R+1.37D,3FAF5C29,7FC00000,3C23D70A,3C1374BC,00000000",
        "R+1.37D,3faf5c29,7fc00000,3c23d70a,3c1374bc", /* not its spelling */
        "R+1.37D,7F800000,7FC00000,3C23D70A,3C1374BC", /* infinite */
        "R+1.37D,3FAF5C29,7F800000,3C23D70A,3C1374BC",
        "R+1.37D;3FAF5C29,7FC00000,3C23D70A,3C1374BC",
        "R+1.37",
        "X+1.37D",
        "R 1.37D",
        "R+1,37D",
        "R+13.7D",
        "R+1.37Z",
    };
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        char script[2048];
        instrument in;
        reading r;
        snprintf(script, sizeof script, GREETING INTERVIEW "r 100 %s^M^J\n", bad[i]);
        assert_int_equal(open_script("printalyzer", script, &in), CAL_OK);
        assert_int_equal(measure(&in, &r), CAL_PROTOCOL);
        instrument_close(&in);
    }
}

static void zero_offset_is_taken_out_of_the_reading(void **state)
{
    (void)state;
    instrument in;
    reading r;
    /* Shown 1.29 = absolute 1.37 - zero 0.08. */
    assert_int_equal(open_script("printalyzer",
                                 GREETING INTERVIEW
                                 "r 100 R+1.29D,3FAF5C29,3DA3D70A,3C23D70A,3C1374BC^M^J\n",
                                 &in),
                     CAL_OK);
    assert_int_equal(measure(&in, &r), CAL_OK);
    check_near(r.value, 1.37, 1e-6, "density");
    instrument_close(&in);
}

static void readings_at_the_ends_of_the_range_are_marked(void **state)
{
    (void)state;
    static const char *const lines[] = {"R+2.50D", "R+0.00D", "T+5.00D", "T+2.50D"};
    for (size_t i = 0; i < 4; i++) {
        char script[2048];
        instrument in;
        reading r;
        snprintf(script, sizeof script, GREETING INTERVIEW "r 100 %s^M^J\n", lines[i]);
        assert_int_equal(open_script("printalyzer", script, &in), CAL_OK);
        assert_int_equal(measure(&in, &r), CAL_OK);
        assert_int_equal(r.clamped, i < 3);
        instrument_close(&in);
    }
}

static void readings_among_the_replies_wait_their_turn(void **state)
{
    (void)state;
    instrument in;
    reading r;
    assert_int_equal(open_script("printalyzer",
                                 "w 0 GS V^M^J\nr 5 R+0.90D^M^J\nr 5 I/main: hello^M^J\n"
                                 "r 5 GS V,\"P\",\"v1\"^M^J\n"
                                 "w 0 SM FORMAT,EXT^M^J\nr 5 R+0.90D^M^J\n"
                                 "r 5 SM FORMAT,OK^M^JR+0.80D^M^J\n"
                                 "w 0 GS UID^M^J\nr 5 " LINE_1_37 "\nr 5 GS UID,01^M^J\n",
                                 &in),
                     CAL_OK);
    /* Those before the format was set are older than anything asked for. */
    assert_int_equal(measure(&in, &r), CAL_OK);
    check_near(r.value, 0.80, 1e-6, "density");
    assert_int_equal(measure(&in, &r), CAL_OK);
    check_near(r.value, 1.37, 1e-6, "density");
    assert_int_equal(measure(&in, &r), CAL_TIMEOUT);
    instrument_close(&in);
}

static void question_is_asked_twice(void **state)
{
    (void)state;
    instrument in;
    assert_int_equal(open_script("printalyzer",
                                 "w 0 GS V^M^J\nw 0 GS V^M^J\nr 5 GS V,\"P\",\"v1\"^M^J\n"
                                 "w 0 SM FORMAT,EXT^M^J\nr 5 SM FORMAT,NAK^M^J\n",
                                 &in),
                     CAL_OK);
    assert_string_equal(instrument_fact_get(&in, "format"), "basic");
    instrument_close(&in);
}

static void hang_up_is_seen_at_once(void **state)
{
    (void)state;
    instrument in;
    reading r;
    assert_int_equal(open_script("printalyzer", GREETING INTERVIEW "r 100 R+1.\nh 50\n", &in),
                     CAL_OK);
    const int64_t before = in.port->ops->now_ms(in.port);
    assert_int_equal(measure(&in, &r), CAL_GONE);
    assert_true(in.port->ops->now_ms(in.port) - before <= 200);
    instrument_close(&in);
}

static void recorded_dialogues_replay(void **state)
{
    (void)state;
    static const struct {
        const char *file, *name;
        double first, last;
    } captures[] = {
        {"printalyzer.script", "printalyzer", 0.07, 1.4392159},
        {"xrite-rci.script", "xrite-rci", 0.07, 1.4392159},
        {"line-xrite-400.script", "line:xrite-400", 0.07, 1.44},
        {"colorhug2.script", "colorhug2", 136.18208, 5.81975},
    };
    for (size_t i = 0; i < sizeof captures / sizeof captures[0]; i++) {
        char port[512];
        transport *t;
        instrument in;
        cal_error err;
        reading r[4];
        snprintf(port, sizeof port, "script:%s/captures/%s", LCOR_TEST_DATA, captures[i].file);
        assert_int_equal(transport_open(port, &t, &err), CAL_OK);
        assert_int_equal(instrument_open(captures[i].name, t, 1000, &in, &err), CAL_OK);
        for (int k = 0; k < 4; k++)
            assert_int_equal(measure(&in, &r[k]), CAL_OK);
        check_near(r[0].value, captures[i].first, 5e-4, captures[i].name);
        check_near(r[3].value, captures[i].last, 5e-4, captures[i].name);
        instrument_close(&in);
    }
}

static void rci_status_is_found_behind_its_data(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        parse_result result;
        int status;
        size_t data;
    } cases[] = {
        {"<00>", PARSE_OK, 0x00, 0},
        {"\r\n<00>", PARSE_OK, 0x00, 2},
        {"X-Rite DTP41\r<00>\r", PARSE_OK, 0x00, 13},
        {"<28>", PARSE_OK, 0x28, 0},
        {"<A1>", PARSE_OK, 0x21, 0},
        {"<a1>", PARSE_OK, 0x21, 0},
        {"<0", PARSE_MORE, 0, 0},
        {"", PARSE_MORE, 0, 0},
        {">", PARSE_BAD, 0, 0},
        {"<0>", PARSE_BAD, 0, 0},
        {"<GG>", PARSE_BAD, 0, 0},
        {"00>", PARSE_BAD, 0, 0},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        size_t used, data;
        int status;
        const parse_result result = rci_status((const uint8_t *)cases[i].text,
                                               strlen(cases[i].text), &used, &data, &status);
        assert_int_equal(result, cases[i].result);
        if (result == PARSE_OK) {
            assert_int_equal(status, cases[i].status);
            assert_int_equal(data, cases[i].data);
        }
    }
}

static void rci_reading_is_xyz_in_percent(void **state)
{
    (void)state;
    size_t used;
    reading r;
    static const char good[] = "9.6420\t10.0000\t8.2490\r<00>";
    assert_int_equal(rci_parse(NULL, (const uint8_t *)good, sizeof good - 1, &used, &r), PARSE_OK);
    check_near(r.value, 1.0, 1e-12, "density");
    check_near(r.step, 1e-4 / (10.0 * log(10.0)), 1e-12, "step");
    static const char *const bad[] = {"9.6420\t10.0000\r<00>",
                                      "9.6420\t0.0000\t8.2490\r<00>",
                                      "9.6420\t-1.0000\t8.2490\r<00>",
                                      "9.6420\t10\t8.2490\r<00>",
                                      "9.6420\t10.0000\t8.2490\t1.0\r<00>",
                                      "9.6420\t1000.0000\t8.2490\r<00>",
                                      "9.6420\t10.0000\t8.2490\r<27>",
                                      "nan\tnan\tnan\r<00>"};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++)
        assert_int_equal(rci_parse(NULL, (const uint8_t *)bad[i], strlen(bad[i]), &used, &r),
                         PARSE_BAD);
}

static void rci_statuses_mean_what_the_user_can_do(void **state)
{
    (void)state;
    assert_int_equal(rci_meaning(0x00), CAL_OK);
    assert_int_equal(rci_meaning(0x27), CAL_MISREAD);
    assert_int_equal(rci_meaning(0x28), CAL_CALIBRATE);
    assert_int_equal(rci_meaning(0x11), CAL_UNSUPPORTED);
    assert_int_equal(rci_meaning(0x31), CAL_PROTOCOL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(printalyzer_tells_who_it_is_and_reads),
        cmocka_unit_test(reply_may_come_in_two_pieces_cut_anywhere),
        cmocka_unit_test(reply_cut_at_every_byte_is_no_reply),
        cmocka_unit_test(reading_cut_at_every_byte_is_no_reading),
        cmocka_unit_test(damaged_readings_are_dropped),
        cmocka_unit_test(zero_offset_is_taken_out_of_the_reading),
        cmocka_unit_test(readings_at_the_ends_of_the_range_are_marked),
        cmocka_unit_test(readings_among_the_replies_wait_their_turn),
        cmocka_unit_test(question_is_asked_twice),
        cmocka_unit_test(hang_up_is_seen_at_once),
        cmocka_unit_test(recorded_dialogues_replay),
        cmocka_unit_test(rci_status_is_found_behind_its_data),
        cmocka_unit_test(rci_reading_is_xyz_in_percent),
        cmocka_unit_test(rci_statuses_mean_what_the_user_can_do),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
