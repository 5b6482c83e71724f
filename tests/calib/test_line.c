/* SPDX-License-Identifier: MIT */
#include "instrument/generic-line/line.h"
#include "testing.h"

#include <string.h>

/* The first reading in text, or NAN when everything in it is dropped. */
static double read_line(const char *preset, const char *text, reading *out)
{
    line_preset p;
    uint8_t bytes[1024];
    size_t n = strlen(text), used = 0;
    assert_int_equal(line_preset_parse(preset, &p, NULL), CAL_OK);
    memcpy(bytes, text, n);
    for (size_t at = 0; at < n; at += used) {
        switch (line_parse(&p.format, bytes + at, n - at, &used, out)) {
        case PARSE_OK: return out->value;
        case PARSE_BAD: assert_true(used > 0 && at + used <= n); break;
        case PARSE_MORE: return (double)NAN;
        }
    }
    return (double)NAN;
}

static void each_form_of_line_is_understood(void **state)
{
    (void)state;
    static const struct {
        const char *preset, *line;
        double value;
    } cases[] = {
        {"heiland-trd2", "T+1.53D\r", 1.53},
        {"heiland-trd2", "R-0.05D\r", -0.05},
        {"heiland-trd2", "T+.278D\r", 0.278},
        {"heiland-trd2", "0+....D\rR+1.37D\r", 1.37},
        {"heiland-trd2", "R+0.12Z\rR+12.0%\rR+1.37D\r", 1.37},
        {"xrite-400", "V1.37 C0.05 M0.06 Y0.07 \r\n", 1.37},
        {"xrite-400", "V1.37\r\n", 1.37},
        {"xrite-400", "V137\r\n", 1.37},
        {"xrite-400", "X-RITE 408\r\nV1.37 \r\n", 1.37},
        {"xrite-400", "V1.37 \rC0.05 \rM0.06 \rY0.07 \r", 1.37},
        {"xrite-400", "C0.05 M0.06 Y0.07 V1.37 \r\n", 1.37},
        {"xrite-400", "V-0.02 \r\n", -0.02},
        {"xrite-400,channel=C", "V1.37 C0.05 M0.06 Y0.07 \r\n", 0.05},
        {"xrite-photo", "V1.37 R1.30 G1.35 B1.40 \r\n", 1.37},
        {"xrite-39x", "1.37\r\n", 1.37},
        {"xrite-500", "V 1.37,C 0.05,M 0.06,Y 0.07\r\n", 1.37},
        {"technet", "V137\r", 1.37},
        {"technet", "V137 R130 G135 B140 \r\n", 1.37},
        {"technet-adv", "P137 C005 M006 Y007 \r\n", 1.37},
        {"tobias-tbx", " DenAA +1.47, 0.00, 0.00, 0.00, 0.00\r\n", 1.47},
        {"tobias-tbx", " DenAR +0.31, +1.44, +1.75, 0.00\r\n DenAA +1.47, 0.00\r\n", 1.47},
        {"generic", "R+1.37D\r\n", 1.37},
        {"generic", "Density: 1.37 (V)\r\n", 1.37},
        {"generic", "D = -0.05\r\n", -0.05},
        {"generic,scale=0.5", "Density 2.74\r\n", 1.37},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        reading r;
        check_near(read_line(cases[i].preset, cases[i].line, &r), cases[i].value, 1e-12,
                   cases[i].line);
    }
}

static void what_is_no_reading_is_dropped(void **state)
{
    (void)state;
    static const struct {
        const char *preset, *line;
    } cases[] = {
        {"heiland-trd2", "R+1.3D\r"},
        {"heiland-trd2", "R+1.377D\r"},
        {"heiland-trd2", "0+....D\r"},
        {"heiland-trd2", "R+....D\r"},
        {"heiland-trd2", "R+0.12Z\r"},
        {"heiland-trd2", "V1.37\r"},
        {"xrite-400", "C0.05\r"},
        {"xrite-400", "V1.3\r"},
        {"xrite-400", "V1.37x\r"},
        {"xrite-400", "V EEE\r"},
        {"xrite-400", "V---\r"},
        {"xrite-400", "1.37\r"},
        {"xrite-400", "V1.37 V1.38\r"},
        {"xrite-400", "V1.37 C0.05 M0.0\r"},
        {"xrite-400", "V1.\x01"
                      "37\r"},
        {"xrite-400", "V1,37\r"},
        {"xrite-400", "V1.3.7\r"},
        {"xrite-400", "V1370\r"},
        {"xrite-39x", "V1.37\r"},
        {"xrite-39x", "137\r"},
        {"xrite-39x", "1.37 D\r"},
        {"technet", "V1.37\r"},
        {"technet", "V13\r"},
        {"tobias-tbx", "DenAR +0.31, +1.44\r"},
        {"tobias-tbx", "DenBA +0.31\r"},
        {"tobias-tbx", "1.37\r"},
        {"generic", "SM FORMAT,1.37\r"},
        {"generic", "W/sensor 1.37\r"},
        {"generic", "GS V,\"x\",\"1.10\"\r"},
        {"generic", "v1.1.0\r"},
        {"generic", "R+0.12Z\r"},
        {"generic", "DenAR +0.31, +1.44\r"},
        {"generic", "DenBA +0.31\r"},
        {"generic", "C0.05 M0.06 Y0.07\r"},
        {"generic", "0+1.37D\r"},
        {"generic", "12.5%\r"},
        {"generic", "ready\r"},
        {"generic", "\r\n\r\n"},
        {"generic,max=3", "Density 3.01\r"},
        {"generic,mode=T", "R+1.37D\r"},
        {"xrite-400", "V1.37"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        reading r;
        if (!isnan(read_line(cases[i].preset, cases[i].line, &r)))
            fail_msg("%s took '%s' for a reading", cases[i].preset, cases[i].line);
    }
}

static void colours_come_with_the_visual_density(void **state)
{
    (void)state;
    reading r;
    read_line("xrite-photo", "V1.37 R1.30 G1.35 B1.40 \r\n", &r);
    assert_true(r.has_colour);
    check_near(r.density[0], 1.30, 1e-12, "r.density[0]");
    check_near(r.density[1], 1.35, 1e-12, "r.density[1]");
    check_near(r.density[2], 1.40, 1e-12, "r.density[2]");
    read_line("xrite-photo", "V1.37 R1.30 \r\n", &r);
    assert_false(r.has_colour);
}

static void mode_and_step_come_from_the_line(void **state)
{
    (void)state;
    reading r;
    read_line("heiland-trd2", "T+1.53D\r", &r);
    assert_int_equal(r.kind, READING_TRANSMISSION);
    check_near(r.step, 0.01, 1e-15, "r.step");
    read_line("heiland-trd2", "T+.278D\r", &r);
    check_near(r.step, 0.001, 1e-15, "r.step");
    read_line("xrite-photo,mode=T", "V1.37\r", &r);
    assert_int_equal(r.kind, READING_TRANSMISSION);
    read_line("technet-adv", "v137\r", &r);
    assert_int_equal(r.kind, READING_TRANSMISSION);
}

static void a_line_too_long_is_dropped_with_its_tail(void **state)
{
    (void)state;
    char text[700];
    memset(text, 'x', sizeof text);
    memcpy(text + 600, "V1.37\r", 7); /* the end of the long line, not a line */
    reading r;
    assert_true(isnan(read_line("xrite-400", text, &r)));
    memcpy(text + 606, "V0.07\r", 7);
    check_near(read_line("xrite-400", text, &r), 0.07, 1e-12, "next line");
}

static void every_beginning_of_a_line_waits_for_more(void **state)
{
    (void)state;
    static const char line[] = "V1.37 C0.05 M0.06 Y0.07 \r";
    line_preset p;
    assert_int_equal(line_preset_parse("xrite-400", &p, NULL), CAL_OK);
    for (size_t n = 0; n < sizeof line - 2; n++) {
        size_t used;
        reading r;
        assert_int_equal(line_parse(&p.format, (const uint8_t *)line, n, &used, &r), PARSE_MORE);
    }
}

static void options_of_a_preset_are_read(void **state)
{
    (void)state;
    line_preset p;
    assert_int_equal(line_preset_parse("macbeth-900,baud=1200,frame=7E2,flow=rtscts,dtr=off,"
                                       "rts=on,decimals=written,min=-1,max=4,trigger=READ",
                                       &p, NULL),
                     CAL_OK);
    assert_int_equal(p.line.baud, 1200);
    assert_int_equal(p.line.data_bits, 7);
    assert_int_equal(p.line.parity, 'E');
    assert_int_equal(p.line.stop_bits, 2);
    assert_int_equal(p.line.flow, FLOW_RTSCTS);
    assert_true(p.line.dtr_off && !p.line.rts_off);
    assert_string_equal(p.format.trigger, "READ\r");
    static const char *const bad[] = {"nonesuch",          "",
                                      "generic,",          "generic,baud",
                                      "generic,baud=fast", "generic,frame=9N1",
                                      "generic,flow=dtr",  "generic,dtr=maybe",
                                      "generic,mode=X",    "generic,decimals=2",
                                      "generic,scale=x",   "generic,colour=red"};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        cal_error err;
        assert_int_equal(line_preset_parse(bad[i], &p, &err), CAL_UNSUPPORTED);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_form_of_line_is_understood),
        cmocka_unit_test(what_is_no_reading_is_dropped),
        cmocka_unit_test(colours_come_with_the_visual_density),
        cmocka_unit_test(mode_and_step_come_from_the_line),
        cmocka_unit_test(a_line_too_long_is_dropped_with_its_tail),
        cmocka_unit_test(every_beginning_of_a_line_waits_for_more),
        cmocka_unit_test(options_of_a_preset_are_read),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
