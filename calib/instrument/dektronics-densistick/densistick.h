/* SPDX-License-Identifier: MIT */
#ifndef LCCAL_DENSISTICK_H
#define LCCAL_DENSISTICK_H

#include "instrument/instrument.h"

extern const instrument_driver densistick_driver;

enum { DENSISTICK_GAINS = 10, DENSISTICK_CALIBRATION = 112, DENSISTICK_SAMPLE = 7 };

/* What the EEPROM holds from 0x110 on. */
typedef struct densistick_calibration {
    double gain[DENSISTICK_GAINS]; /* of 0.5x, 1x .. 256x */
    double low_density, low_reading, high_density, high_reading;
} densistick_calibration;

/* Read the EEPROM's bytes. False: another version, a wrong checksum or impossible numbers. Pure. */
bool densistick_calibration_parse(const uint8_t bytes[DENSISTICK_CALIBRATION],
                                  densistick_calibration *out);

/* Checksum of n words as the instrument's maker computes it. */
uint32_t densistick_checksum(const uint8_t *bytes, size_t words);

/* Density of a count at a gain. */
double densistick_density(const densistick_calibration *c, double count, unsigned gain);

#endif
