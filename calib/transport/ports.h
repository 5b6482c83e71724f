/* SPDX-License-Identifier: MIT */
/* What is plugged in, read from the kernel's tables: no port is opened, so nothing can block. */
#ifndef LCCAL_PORTS_H
#define LCCAL_PORTS_H

#include <stdbool.h>
#include <stddef.h>

typedef struct port_info {
    char path[64]; /* /dev/ttyACM0, /dev/hidraw3; "" for a USB device without a port */
    unsigned vendor, product;
    char serial[64];
    char title[96]; /* maker and product as the device says */
} port_info;

/* Serial ports and HID devices on USB, then USB devices that have neither. Returns how many, at
 * most capacity. */
size_t ports_scan(port_info *out, size_t capacity);

#endif
