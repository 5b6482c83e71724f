/* SPDX-License-Identifier: MIT */
/* A program that the machine lets look too late: what came in time is heard all the same. */
#include "instrument/instrument.h"
#include "testing.h"

#include <string.h>

/* A port that says a text over and over in pieces, whenever it is read. The machine is busy for
 * seconds after the first of them. */
typedef struct late_port {
    transport base;
    const char *text;
    size_t at, piece;
    size_t rounds;  /* how often it says its text, */
    size_t answers; /* and how often more after each command */
    int64_t now;
    int reads;
} late_port;

static cal_status late_read(transport *t, void *bytes, size_t capacity, size_t *got, int timeout_ms)
{
    late_port *p = (late_port *)t;
    const size_t size = strlen(p->text);
    const size_t left = size * p->rounds - p->at;
    *got = 0;
    if (left == 0) {
        p->now += timeout_ms;
        return CAL_TIMEOUT;
    }
    while (*got < p->piece && *got < left && *got < capacity)
        ((char *)bytes)[(*got)++] = p->text[p->at++ % size];
    p->now += p->reads++ == 0 ? 5000 : 0;
    return CAL_OK;
}

static cal_status late_write(transport *t, const void *bytes, size_t n, int timeout_ms)
{
    ((late_port *)t)->rounds += ((late_port *)t)->answers;
    (void)bytes;
    (void)n;
    (void)timeout_ms;
    return CAL_OK;
}

static cal_status any_line(transport *t, const line_settings *line)
{
    (void)t;
    (void)line;
    return CAL_OK;
}

static int64_t late_now(transport *t) { return ((late_port *)t)->now; }
static void stay(transport *t) { (void)t; }

static const transport_ops late_ops = {.scheme = "late",
                                       .configure = any_line,
                                       .write = late_write,
                                       .read = late_read,
                                       .now_ms = late_now,
                                       .close = stay};

static cal_status listen(late_port *p, reading *out)
{
    instrument in;
    cal_error err;
    p->base.ops = &late_ops;
    assert_int_equal(instrument_open("line:generic", &p->base, 1000, &in, &err), CAL_OK);
    const cal_status status = in.driver->measure(&in, 1000, out, &err);
    instrument_close(&in);
    return status;
}

static void reading_that_came_in_time_is_heard_late(void **state)
{
    (void)state;
    reading r;
    late_port p = {.text = "Density: 1.37\r\n", .piece = 4, .rounds = 1};
    assert_int_equal(listen(&p, &r), CAL_OK);
    check_near(r.value, 1.37, 1e-12, "density");
}

static void port_that_never_stops_is_left_at_the_deadline(void **state)
{
    (void)state;
    reading r;
    late_port p = {.text = "noise\n", .piece = 6, .rounds = 1000000};
    assert_int_equal(listen(&p, &r), CAL_PROTOCOL);
    assert_true(p.reads < 100);
}

static void half_a_reading_is_none(void **state)
{
    (void)state;
    reading r;
    late_port p = {.text = "Density: 1.37", .piece = 4, .rounds = 1};
    assert_int_equal(listen(&p, &r), CAL_PROTOCOL);
}

/* What the ColorHug2 says is one report after the other; a stream may hold two of them. */
static void old_report_before_the_answer_is_dropped(void **state)
{
    (void)state;
    char reports[128];
    memset(reports, 0x7F, sizeof reports);
    reports[64] = 0x01; /* the code: unknown command, so that no byte is NUL */
    reports[65] = 0x07; /* the answer to the first question */
    char text[129];
    memcpy(text, reports, sizeof reports);
    text[128] = '\0';
    instrument in;
    cal_error err;
    late_port p = {.base = {.ops = &late_ops, .name = "late"},
                   .text = text,
                   .piece = sizeof reports,
                   .answers = 1};
    transport_ops hid = late_ops;
    hid.messages = true;
    p.base.ops = &hid;
    assert_int_equal(instrument_open("colorhug2", &p.base, 1000, &in, &err), CAL_PROTOCOL);
    assert_non_null(strstr(err.text, "error 1"));
    instrument_close(&in);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(reading_that_came_in_time_is_heard_late),
        cmocka_unit_test(port_that_never_stops_is_left_at_the_deadline),
        cmocka_unit_test(half_a_reading_is_none),
        cmocka_unit_test(old_report_before_the_answer_is_dropped),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
