/* SPDX-License-Identifier: MIT */
/* Serial ports on a pseudo-terminal of this process. */
#define _XOPEN_SOURCE 700
#include "testing.h"
#include "transport/transport.h"

#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <string.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

typedef struct line_pair {
    int master;
    int watcher; /* sees what lies in the port and takes nothing */
    transport *port;
} line_pair;

static const line_settings plain = {.baud = 9600, .data_bits = 8, .parity = 'N', .stop_bits = 1};

static void open_pair(line_pair *p)
{
    p->master = posix_openpt(O_RDWR | O_NOCTTY);
    assert_true(p->master >= 0);
    assert_int_equal(grantpt(p->master), 0);
    assert_int_equal(unlockpt(p->master), 0);
    p->watcher = open(ptsname(p->master), O_RDWR | O_NOCTTY);
    cal_error err;
    assert_int_equal(serial_open(ptsname(p->master), &p->port, &err), CAL_OK);
    assert_int_equal(p->port->ops->configure(p->port, &plain), CAL_OK);
}

static void close_pair(line_pair *p)
{
    p->port->ops->close(p->port);
    close(p->watcher);
    if (p->master >= 0)
        close(p->master);
}

static void say(const line_pair *p, const char *bytes, size_t n)
{
    assert_int_equal(write(p->master, bytes, n), (ssize_t)n);
}

/* A pseudo-terminal carries bytes over a moment later: wait until some lie in the port. */
static void await(const line_pair *p)
{
    struct pollfd fd = {.fd = p->watcher, .events = POLLIN};
    assert_int_equal(poll(&fd, 1, 60000), 1);
}

/* Read exactly n bytes. */
static void hear(const line_pair *p, char *bytes, size_t n)
{
    size_t have = 0;
    while (have < n) {
        size_t got;
        assert_int_equal(p->port->ops->read(p->port, bytes + have, n - have, &got, 60000), CAL_OK);
        have += got;
    }
}

static void every_byte_comes_through(void **state)
{
    (void)state;
    line_pair p;
    char all[256], back[256];
    for (int i = 0; i < 256; i++)
        all[i] = (char)i;
    open_pair(&p);
    say(&p, all, sizeof all);
    hear(&p, back, sizeof back);
    assert_memory_equal(all, back, sizeof all);
    assert_int_equal(p.port->ops->write(p.port, all, sizeof all, 1000), CAL_OK);
    for (size_t have = 0; have < sizeof back;) {
        const ssize_t n = read(p.master, back + have, sizeof back - have);
        assert_true(n > 0);
        have += (size_t)n;
    }
    assert_memory_equal(all, back, sizeof all);
    close_pair(&p);
}

static void parity_bit_of_a_seven_bit_frame_is_taken_off(void **state)
{
    (void)state;
    static const char even[] = {'V', (char)('1' | 0x80), '.', '3', (char)('7' | 0x80)};
    const char parities[] = "EOSM";
    for (const char *parity = parities; *parity; parity++) {
        line_pair p;
        char text[sizeof even];
        line_settings line = plain;
        line.data_bits = 7;
        line.parity = *parity;
        open_pair(&p);
        assert_int_equal(p.port->ops->configure(p.port, &line), CAL_OK);
        say(&p, even, sizeof even);
        hear(&p, text, sizeof even);
        assert_memory_equal(text, "V1.37", sizeof even);
        close_pair(&p);
    }
}

static void frames_a_pty_cannot_have_are_no_failure(void **state)
{
    (void)state;
    line_pair p;
    line_settings line = {.baud = 300, .data_bits = 7, .parity = 'N', .stop_bits = 2};
    open_pair(&p);
    assert_int_equal(p.port->ops->configure(p.port, &line), CAL_OK);
    assert_int_equal(p.port->ops->configure(p.port, &line), CAL_OK);
    line.baud = 12345;
    assert_int_equal(p.port->ops->configure(p.port, &line), CAL_UNSUPPORTED);
    close_pair(&p);
}

static void silence_ends_at_the_deadline(void **state)
{
    (void)state;
    line_pair p;
    char byte;
    size_t got;
    open_pair(&p);
    const int64_t before = p.port->ops->now_ms(p.port);
    assert_int_equal(p.port->ops->read(p.port, &byte, 1, &got, 60), CAL_TIMEOUT);
    assert_true(p.port->ops->now_ms(p.port) - before >= 60);
    assert_int_equal(p.port->ops->read(p.port, &byte, 1, &got, 0), CAL_TIMEOUT);
    close_pair(&p);
}

static void hang_up_while_idle_is_seen(void **state)
{
    (void)state;
    line_pair p;
    char byte;
    size_t got;
    open_pair(&p);
    close(p.master);
    p.master = -1;
    assert_int_equal(p.port->ops->read(p.port, &byte, 1, &got, 60000), CAL_GONE);
    assert_int_equal(p.port->ops->write(p.port, "x", 1, 60000), CAL_GONE);
    assert_int_equal(p.port->ops->configure(p.port, &plain), CAL_GONE);
    close_pair(&p);
}

static void hang_up_in_the_middle_of_a_line_gives_what_came_before(void **state)
{
    (void)state;
    line_pair p;
    char text[4], byte;
    size_t got;
    open_pair(&p);
    say(&p, "R+1.", 4);
    hear(&p, text, 4);
    assert_memory_equal(text, "R+1.", 4);
    close(p.master);
    p.master = -1;
    assert_int_equal(p.port->ops->read(p.port, &byte, 1, &got, 60000), CAL_GONE);
    close_pair(&p);
}

static void *unplug_soon(void *arg)
{
    const struct timespec while_reading = {0, 50000000};
    nanosleep(&while_reading, NULL);
    close(*(int *)arg);
    return NULL;
}

static void hang_up_while_waiting_ends_the_wait(void **state)
{
    (void)state;
    line_pair p;
    pthread_t thread;
    char byte;
    size_t got;
    open_pair(&p);
    assert_int_equal(pthread_create(&thread, NULL, unplug_soon, &p.master), 0);
    assert_int_equal(p.port->ops->read(p.port, &byte, 1, &got, 60000), CAL_GONE);
    pthread_join(thread, NULL);
    p.master = -1;
    close_pair(&p);
}

static void what_lay_in_the_port_before_is_thrown_away(void **state)
{
    (void)state;
    line_pair p;
    char text[5];
    open_pair(&p);
    say(&p, "stale\n", 6);
    await(&p);
    assert_int_equal(p.port->ops->configure(p.port, &plain), CAL_OK);
    say(&p, "fresh", 5);
    hear(&p, text, 5);
    assert_memory_equal(text, "fresh", 5);
    say(&p, "noise", 5);
    await(&p);
    assert_int_equal(transport_drain(p.port, 30, 1000), CAL_OK);
    say(&p, "after", 5);
    hear(&p, text, 5);
    assert_memory_equal(text, "after", 5);
    close_pair(&p);
}

static void second_program_finds_the_port_busy(void **state)
{
    (void)state;
    line_pair p;
    transport *second;
    cal_error err;
    open_pair(&p);
    const cal_status status = serial_open(ptsname(p.master), &second, &err);
    assert_int_equal(status, CAL_BUSY);
    assert_non_null(strstr(err.text, "in use"));
    p.port->ops->close(p.port);
    assert_int_equal(serial_open(ptsname(p.master), &p.port, &err), CAL_OK);
    close_pair(&p);
}

static void settings_are_put_back(void **state)
{
    (void)state;
    struct termios before, after;
    cal_error err;
    transport *port;
    const int master = posix_openpt(O_RDWR | O_NOCTTY);
    assert_int_equal(grantpt(master), 0);
    assert_int_equal(unlockpt(master), 0);
    const int watcher = open(ptsname(master), O_RDWR | O_NOCTTY);
    assert_int_equal(tcgetattr(watcher, &before), 0);
    assert_int_equal(serial_open(ptsname(master), &port, &err), CAL_OK);
    assert_int_equal(port->ops->configure(port, &plain), CAL_OK);
    port->ops->close(port);
    assert_int_equal(tcgetattr(watcher, &after), 0);
    assert_int_equal(before.c_lflag, after.c_lflag);
    assert_int_equal(before.c_iflag, after.c_iflag);
    close(watcher);
    close(master);
}

static void names_that_are_no_ports(void **state)
{
    (void)state;
    transport *port;
    cal_error err;
    assert_int_equal(transport_open("/dev/ttyNONE", &port, &err), CAL_NO_DEVICE);
    assert_int_equal(transport_open("/dev/null", &port, &err), CAL_NO_DEVICE);
    assert_int_equal(transport_open("", &port, &err), CAL_NO_DEVICE);
    assert_int_equal(transport_open("script:/none", &port, &err), CAL_NO_DEVICE);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_byte_comes_through),
        cmocka_unit_test(parity_bit_of_a_seven_bit_frame_is_taken_off),
        cmocka_unit_test(frames_a_pty_cannot_have_are_no_failure),
        cmocka_unit_test(silence_ends_at_the_deadline),
        cmocka_unit_test(hang_up_while_idle_is_seen),
        cmocka_unit_test(hang_up_in_the_middle_of_a_line_gives_what_came_before),
        cmocka_unit_test(hang_up_while_waiting_ends_the_wait),
        cmocka_unit_test(what_lay_in_the_port_before_is_thrown_away),
        cmocka_unit_test(second_program_finds_the_port_busy),
        cmocka_unit_test(settings_are_put_back),
        cmocka_unit_test(names_that_are_no_ports),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
