/* SPDX-License-Identifier: MIT */
/* Serial ports over termios: USB adapters, CDC-ACM devices, pseudo-terminals. */
#define _DEFAULT_SOURCE /* flock, CRTSCTS, cfmakeraw, TIOCM* */
#include "transport/interrupt.h"
#include "transport/transport.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

typedef struct serial {
    transport base;
    int fd;
    bool strip; /* bit 7 is the parity bit of a 7-bit frame read as 8N1 */
    struct termios before;
} serial;

/* Wait until the port is ready for `events`; a hang-up is seen at once, and so is SIGINT. */
static cal_status wait_for(serial *s, short events, int timeout_ms)
{
    struct pollfd fds[2] = {{.fd = s->fd, .events = events},
                            {.fd = interrupt_fd(), .events = POLLIN}};
    const int64_t deadline = transport_clock(&s->base) + timeout_ms;
    for (;;) {
        if (interrupt_pending())
            return CAL_INTERRUPTED;
        const int n = poll(fds, 2, transport_left(&s->base, deadline));
        if (n < 0 && errno != EINTR)
            return CAL_IO;
        if (n < 0 || (n > 0 && fds[1].revents))
            continue;
        if (n == 0)
            return CAL_TIMEOUT;
        if (fds[0].revents & events)
            return CAL_OK; /* bytes that came before a hang-up are still read */
        return CAL_GONE;
    }
}

static cal_status serial_read(transport *t, void *bytes, size_t capacity, size_t *got,
                              int timeout_ms)
{
    serial *s = (serial *)t;
    const int64_t deadline = transport_clock(t) + timeout_ms;
    *got = 0;
    for (;;) {
        const cal_status status = wait_for(s, POLLIN, transport_left(t, deadline));
        if (status != CAL_OK)
            return status;
        const ssize_t n = read(s->fd, bytes, capacity);
        if (n < 0 && (errno == EAGAIN || errno == EINTR))
            continue;
        if (n < 0)
            return errno == EIO ? CAL_GONE : CAL_IO;
        if (n == 0)
            return CAL_GONE;
        *got = (size_t)n;
        break;
    }
    for (size_t i = 0; s->strip && i < *got; i++)
        ((unsigned char *)bytes)[i] &= 0x7F;
    return CAL_OK;
}

static cal_status serial_write(transport *t, const void *bytes, size_t n, int timeout_ms)
{
    serial *s = (serial *)t;
    const char *next = bytes;
    const int64_t deadline = transport_clock(t) + timeout_ms;
    while (n > 0) {
        const cal_status status = wait_for(s, POLLOUT, transport_left(t, deadline));
        if (status != CAL_OK)
            return status;
        const ssize_t sent = write(s->fd, next, n);
        if (sent < 0 && (errno == EAGAIN || errno == EINTR))
            continue;
        if (sent < 0)
            return errno == EIO || errno == ENXIO ? CAL_GONE : CAL_IO;
        next += sent;
        n -= (size_t)sent;
    }
    return CAL_OK;
}

static bool speed_of(int baud, speed_t *speed)
{
    static const struct {
        int baud;
        speed_t speed;
    } table[] = {{110, B110},     {300, B300},     {600, B600},      {1200, B1200},
                 {2400, B2400},   {4800, B4800},   {9600, B9600},    {19200, B19200},
                 {38400, B38400}, {57600, B57600}, {115200, B115200}};
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        if (table[i].baud == baud) {
            *speed = table[i].speed;
            return true;
        }
    }
    return false;
}

static cal_status serial_configure(transport *t, const line_settings *line)
{
    serial *s = (serial *)t;
    speed_t speed;
    struct termios tio;
    if (!speed_of(line->baud, &speed))
        return CAL_UNSUPPORTED;
    if (tcgetattr(s->fd, &tio) != 0)
        return CAL_GONE;
    cfmakeraw(&tio);
    tio.c_cflag |= CLOCAL | CREAD;
    tio.c_cflag &= ~(tcflag_t)(CSTOPB | CRTSCTS);
    if (line->stop_bits == 2)
        tio.c_cflag |= CSTOPB;
    if (line->flow == FLOW_RTSCTS)
        tio.c_cflag |= CRTSCTS;
    if (line->flow == FLOW_XONXOFF)
        tio.c_iflag |= IXON | IXOFF;
    tio.c_cc[VMIN] = 0;
    tio.c_cc[VTIME] = 0;
    /* A 7-bit frame with a parity bit is as long as 8N1: read it as that and drop bit 7, which also
     * works on ports that know only 8 bits. 7N1 is shorter and needs the real thing; so does 8 bits
     * with parity. */
    s->strip = line->data_bits == 7;
    const bool plain = line->data_bits == 7 ? line->parity != 'N' : line->parity == 'N';
    if (!plain && line->data_bits == 7)
        tio.c_cflag = (tio.c_cflag & ~(tcflag_t)CSIZE) | CS7;
    if (!plain && line->data_bits == 8)
        tio.c_cflag |= PARENB | (line->parity == 'O' ? (tcflag_t)PARODD : 0);
    cfsetispeed(&tio, speed);
    cfsetospeed(&tio, speed);
    /* A pseudo-terminal has no frames and answers EINVAL to 7-bit and parity ones. */
    if (tcsetattr(s->fd, TCSANOW, &tio) != 0 && (plain || errno != EINVAL))
        return errno == EIO ? CAL_GONE : CAL_UNSUPPORTED;
    /* Instruments powered by or waiting for these lines need them; ports without them say ENOTTY,
     * which is no failure. */
    int on = (line->dtr_off ? 0 : TIOCM_DTR) | (line->rts_off ? 0 : TIOCM_RTS);
    int off = (TIOCM_DTR | TIOCM_RTS) & ~on;
    (void)ioctl(s->fd, TIOCMBIS, &on);
    (void)ioctl(s->fd, TIOCMBIC, &off);
    (void)tcflush(s->fd, TCIOFLUSH);
    return CAL_OK;
}

static void serial_close(transport *t)
{
    serial *s = (serial *)t;
    (void)tcsetattr(s->fd, TCSANOW, &s->before);
    (void)close(s->fd); /* releases the lock */
    free(s);
}

static const transport_ops serial_ops = {
    .scheme = "serial",
    .configure = serial_configure,
    .write = serial_write,
    .read = serial_read,
    .now_ms = transport_clock,
    .close = serial_close,
};

static cal_status open_failure(const char *path, int error, cal_error *err)
{
    switch (error) {
    case EACCES:
    case EPERM:
        return cal_fail(err, CAL_PERMISSION,
                        "no permission to open '%s'; `lccal doctor` says what to do", path);
    case EBUSY:
    case EWOULDBLOCK:
        return cal_fail(err, CAL_BUSY, "'%s' is in use by another program; close it and try again",
                        path);
    case ENOENT:
    case ENODEV:
    case ENXIO:
        return cal_fail(
            err, CAL_NO_DEVICE,
            "there is no port '%s'; plug the instrument in, `lccal list --all` shows ports", path);
    default: return cal_fail(err, CAL_IO, "cannot open '%s': %s", path, strerror(error));
    }
}

cal_status serial_open(const char *path, transport **out, cal_error *err)
{
    const int fd = open(path, O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    if (fd < 0)
        return open_failure(path, errno, err);
    cal_status status;
    serial *s = calloc(1, sizeof *s);
    if (!s) {
        status = cal_fail(err, CAL_NO_MEMORY, "out of memory");
        goto failed;
    }
    if (tcgetattr(fd, &s->before) != 0) {
        status = cal_fail(err, CAL_NO_DEVICE,
                          "'%s' is not a serial port; `lccal list --all` shows those on USB", path);
        goto failed;
    }
    /* TIOCEXCL does not stop root, and programs that open by hand do not look at locks: take both.
     */
    if (flock(fd, LOCK_EX | LOCK_NB) != 0) {
        status = open_failure(path, errno, err);
        goto failed;
    }
    (void)ioctl(fd, TIOCEXCL);
    s->base.ops = &serial_ops;
    s->fd = fd;
    snprintf(s->base.name, sizeof s->base.name, "%s", path);
    *out = &s->base;
    return CAL_OK;
failed:
    free(s);
    close(fd);
    return status;
}
