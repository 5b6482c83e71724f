/* SPDX-License-Identifier: MIT */
/* USB HID over hidapi's hidraw backend, which leaves the kernel's driver in place. As hidapi has
 * it, the first byte of what is written is the report's number, 0 where reports have none. */
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
#include <unistd.h>
#include <wchar.h>

enum { SLICE_MS = 50 };

/* Where a device is: its node, or the numbers to find it by. */
typedef struct hid_place {
    unsigned short vendor, product; /* 0: any */
    const char *serial;             /* "": any */
    char node[96];                  /* "": not known yet */
} hid_place;

typedef struct hid {
    transport base;
    hid_device *device;
} hid;

static cal_status hid_port_write(transport *t, const void *bytes, size_t n, int timeout_ms)
{
    (void)timeout_ms; /* hidraw queues the report in the kernel and returns */
    return hid_write(((hid *)t)->device, bytes, n) < 0 ? CAL_GONE : CAL_OK;
}

/* hidapi waits on nothing but its own device, so SIGINT is looked for between short waits. An
 * empty report is no answer (seen from the libusb backend). */
static cal_status hid_port_read(transport *t, void *bytes, size_t capacity, size_t *got,
                                int timeout_ms)
{
    hid *h = (hid *)t;
    const int64_t deadline = transport_clock(t) + timeout_ms;
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
    .now_ms = transport_clock,
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

/* hid:VID:PID[:SERIAL] */
static bool parse_ids(const char *port, hid_place *out)
{
    const char *ids = port + 4;
    if (strlen(ids) < 9 || !parse_hex4(ids, &out->vendor) || ids[4] != ':' ||
        !parse_hex4(ids + 5, &out->product) || (ids[9] != '\0' && ids[9] != ':'))
        return false;
    out->serial = ids[9] ? ids + 10 : "";
    return true;
}

/* Is it the device asked for: by its node, or by its numbers and the first of its interfaces? */
static bool is_wanted(const struct hid_device_info *d, const hid_place *place)
{
    char serial[128];
    if (place->node[0] != '\0')
        return strcmp(d->path, place->node) == 0;
    if (!d->serial_number || wcstombs(serial, d->serial_number, sizeof serial) >= sizeof serial)
        serial[0] = '\0';
    return d->interface_number <= 0 &&
           (place->serial[0] == '\0' || strcmp(place->serial, serial) == 0);
}

/* Fill in what the system knows about the place. False: it knows no such device. */
static bool look_up(hid_place *place)
{
    bool found = false;
    struct hid_device_info *all = hid_enumerate(place->vendor, place->product);
    for (const struct hid_device_info *d = all; d && !found; d = d->next) {
        if (!is_wanted(d, place))
            continue;
        found = true;
        place->vendor = d->vendor_id;
        place->product = d->product_id;
        snprintf(place->node, sizeof place->node, "%s", d->path);
    }
    hid_free_enumeration(all);
    return found;
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

static cal_status find_device(const char *port, hid_place *place, cal_error *err)
{
    memset(place, 0, sizeof *place);
    place->serial = "";
    if (strncmp(port, "hid:", 4) != 0) {
        snprintf(place->node, sizeof place->node, "%s", port);
        (void)look_up(place); /* one that cannot be looked up can be opened all the same */
    } else if (!parse_ids(port, place)) {
        return cal_fail(err, CAL_NO_DEVICE,
                        "'%s' should be hid:VID:PID[:SERIAL] with four hex digits each", port);
    } else if (!look_up(place)) {
        return cal_fail(err, CAL_NO_DEVICE,
                        "no USB device '%s' is plugged in; `lccal list` shows what is", port);
    }
    return check_access(place->node, err);
}

cal_status hid_open_port(const char *port, transport **out, cal_error *err)
{
    hid_place place;
    if (hid_init() != 0)
        return cal_fail(err, CAL_UNSUPPORTED, "the system's USB HID support does not start");
    hid *h = NULL;
    cal_status status = find_device(port, &place, err);
    if (status != CAL_OK)
        goto failed;
    h = calloc(1, sizeof *h);
    if (!h) {
        status = cal_fail(err, CAL_NO_MEMORY, "out of memory");
        goto failed;
    }
    h->device = hid_open_path(place.node);
    if (!h->device) {
        status = cal_fail(err, CAL_NO_DEVICE, "'%s' is no USB HID device", place.node);
        goto failed;
    }
    h->base.ops = &hid_ops;
    h->base.vendor = place.vendor;
    h->base.product = place.product;
    snprintf(h->base.name, sizeof h->base.name, "%s", port);
    *out = &h->base;
    return CAL_OK;
failed:
    free(h);
    hid_exit();
    return status;
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
