/* SPDX-License-Identifier: MIT */
/* FTDI FT260: I2C and a few pins behind USB HID reports. The first byte of a report is its number.
 * Devices are addressed by their 7-bit I2C address, registers by one byte. */
#ifndef LCCAL_FT260_H
#define LCCAL_FT260_H

#include "transport/transport.h"

enum { FT260_PAYLOAD = 60, FT260_ANSWER_MS = 500 };

/* Ask for the chip's version (4 bytes: chip, chip, major, minor) and set the bus to 400 kHz. */
cal_status ft260_start(transport *t, uint8_t version[4]);
/* Pins F and H: `lamp` drives H, which switches the DensiStick's light. */
cal_status ft260_lamp(transport *t, bool lamp);
/* n bytes from or to consecutive registers, 1 <= n <= FT260_PAYLOAD. */
cal_status ft260_read(transport *t, uint8_t address, uint8_t reg, uint8_t *bytes, size_t n);
cal_status ft260_write(transport *t, uint8_t address, uint8_t reg, const uint8_t *bytes, size_t n);
/* One byte to a device without registers. */
cal_status ft260_write_raw(transport *t, uint8_t address, uint8_t byte);

#endif
