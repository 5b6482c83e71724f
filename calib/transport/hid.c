/* SPDX-License-Identifier: MIT */
/* USB HID over hidapi's hidraw backend, which leaves the kernel's driver in place. Reports here
 * have no numbers: hidapi wants a 0 in front of each one written. */
#define _POSIX_C_SOURCE 200809L
#include "transport/interrupt.h"
#include "transport/transport.h"

#ifdef LCCAL_HIDAPI

#include <errno.h>
#include <fcntl.h>
#include <hidapi.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>
#include <wchar.h>

enum { REPORT_MAX = 64, SLICE_MS = 50 };

typedef struct hid {
    transport base;
    hid_device *device;
} hid;

static int64_t now_ms(transport *t)
{
    (void)t;
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (int64_t)now.tv_sec * 1000 + now.tv_nsec / 1000000;
}

static cal_status hid_port_write(transport *t, const void *bytes, size_t n, int timeout_ms)
{
    hid *h = (hid *)t;
    unsigned char report[1 + REPORT_MAX] = {0};
    (void)timeout_ms; /* hidraw queues the report in the kernel and returns */
    if (n > REPORT_MAX)
        return CAL_UNSUPPORTED;
    memcpy(report + 1, bytes, n);
    return hid_write(h->device, report, n + 1) < 0 ? CAL_GONE : CAL_OK;
}

/* hidapi waits on nothing but its own device, so SIGINT is looked for between short waits. An
 * empty report is no answer (seen from the libusb backend). */
static cal_status hid_port_read(transport *t, void *bytes, size_t capacity, size_t *got,
                                int timeout_ms)
{
    hid *h = (hid *)t;
    const int64_t deadline = now_ms(t) + timeout_ms;
    *got = 0;
    for (;;) {
        if (interrupt_pending())
            return CAL_INTERRUPTED;
        const int left = transport_left(t, deadline);
        const int n =
            hid_read_timeout(h->device, bytes, capacity, left < SLICE_MS ? left : SLICE_MS);
        if (n > 0) {
            *got = (size_t)n;
            return CAL_OK;
        }
        if (n < 0 && !interrupt_pending())
            return CAL_GONE;
        if (n == 0 && left == 0)
            return CAL_TIMEOUT;
    }
}

static cal_status hid_port_set_feature(transport *t, const uint8_t *report, size_t n)
{
    return hid_send_feature_report(((hid *)t)->device, report, n) < 0 ? CAL_GONE : CAL_OK;
}

static cal_status hid_port_get_feature(transport *t, uint8_t *report, size_t n)
{
    return hid_get_feature_report(((hid *)t)->device, report, n) < 0 ? CAL_GONE : CAL_OK;
}

static void hid_port_close(transport *t)
{
    hid_close(((hid *)t)->device);
    free(t);
    hid_exit();
}

static const transport_ops hid_ops = {
    .scheme = "hid",
    .messages = true,
    .write = hid_port_write,
    .read = hid_port_read,
    .set_feature = hid_port_set_feature,
    .get_feature = hid_port_get_feature,
    .now_ms = now_ms,
    .close = hid_port_close,
};

static bool parse_hex4(const char *text, unsigned short *out)
{
    unsigned value = 0;
    for (int i = 0; i < 4; i++) {
        static const char digits[] = "0123456789abcdef";
        const char lower = (char)(text[i] | 0x20);
        const char *at = text[i] ? strchr(digits, lower) : NULL;
        if (!at || !*at)
            return false;
        value = value << 4 | (unsigned)(at - digits);
    }
    *out = (unsigned short)value;
    return true;
}

/* The node of hid:VID:PID[:SERIAL], first interface that answers. */
static cal_status find_node(const char *port, char *node, size_t capacity, cal_error *err)
{
    unsigned short vendor, product;
    const char *ids = port + 4;
    if (strlen(ids) < 9 || !parse_hex4(ids, &vendor) || ids[4] != ':' ||
        !parse_hex4(ids + 5, &product) || (ids[9] != '\0' && ids[9] != ':'))
        return cal_fail(err, CAL_NO_DEVICE,
                        "'%s' should be hid:VID:PID[:SERIAL] with four hex digits each", port);
    const char *serial = ids[9] ? ids + 10 : "";
    struct hid_device_info *all = hid_enumerate(vendor, product);
    const char *found = NULL;
    for (const struct hid_device_info *d = all; d && !found; d = d->next) {
        char name[128];
        if (!d->serial_number || wcstombs(name, d->serial_number, sizeof name) >= sizeof name)
            name[0] = '\0';
        if (*serial == '\0' || strcmp(serial, name) == 0)
            found = d->path;
    }
    if (found)
        snprintf(node, capacity, "%s", found);
    hid_free_enumeration(all);
    return found ? CAL_OK
                 : cal_fail(err, CAL_NO_DEVICE,
                            "no USB device '%s' is plugged in; `lccal list` shows what is", port);
}

static cal_status check_access(const char *node, cal_error *err)
{
    const int fd = open(node, O_RDWR | O_CLOEXEC);
    if (fd >= 0) {
        close(fd);
        return CAL_OK;
    }
    if (errno == EACCES || errno == EPERM)
        return cal_fail(err, CAL_PERMISSION,
                        "no permission to open '%s'; `lccal doctor` says what to do", node);
    return cal_fail(err, CAL_NO_DEVICE,
                    "cannot open '%s': %s; `lccal list` shows what is plugged in", node,
                    strerror(errno));
}

cal_status hid_open_port(const char *port, transport **out, cal_error *err)
{
    char node[96];
    cal_status status = CAL_OK;
    if (hid_init() != 0)
        return cal_fail(err, CAL_UNSUPPORTED, "the system's USB HID support does not start");
    snprintf(node, sizeof node, "%s", port);
    if (strncmp(port, "hid:", 4) == 0)
        status = find_node(port, node, sizeof node, err);
    if (status == CAL_OK)
        status = check_access(node, err);
    hid *h = status == CAL_OK ? calloc(1, sizeof *h) : NULL;
    if (status == CAL_OK && !h)
        status = cal_fail(err, CAL_NO_MEMORY, "out of memory");
    if (status == CAL_OK) {
        h->device = hid_open_path(node);
        if (!h->device)
            status = cal_fail(err, CAL_NO_DEVICE, "'%s' is no USB HID device", node);
    }
    if (status != CAL_OK) {
        free(h);
        hid_exit();
        return status;
    }
    h->base.ops = &hid_ops;
    snprintf(h->base.name, sizeof h->base.name, "%s", port);
    *out = &h->base;
    return CAL_OK;
}

#else

cal_status hid_open_port(const char *port, transport **out, cal_error *err)
{
    (void)out;
    return cal_fail(err, CAL_UNSUPPORTED,
                    "this lccal was built without USB HID, so it cannot use '%s'; build it with "
                    "libhidapi-dev installed",
                    port);
}

#endif
