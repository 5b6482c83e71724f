/* SPDX-License-Identifier: MIT */
/* Dektronics DensiStick, a reflection densitometer on USB HID: an FT260 bridge with an EEPROM, a
 * TSL2585 or TSL2522 light sensor and a lamp. There is no protocol document; this follows the
 * maker's own program. Experimental: never met a real one. */
#include "instrument/dektronics-densistick/densistick.h"
#include "instrument/dektronics-densistick/ft260.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum {
    EEPROM = 0x50, /* bits 8 and 9 of an EEPROM address are bits 0 and 1 of the I2C address */
    EEPROM_HEADER = 0x100,
    EEPROM_CALIBRATION = 0x110,
    EEPROM_STEP = 32,
    LAMP_CURRENT = 0x2F, /* potentiometer: 0 brightest, 127 idle */
    LAMP_FULL = 0,
    LAMP_IDLE = 127,
    SENSOR = 0x39,
    SENSOR_ID = 0x5C,
    AUX_TSL2585 = 6,
    AUX_TSL2522 = 5
};

/* Registers of the sensor. */
enum {
    R_MODULATORS = 0x40,
    R_ENABLE = 0x80,
    R_MODE0 = 0x81,
    R_MODE1 = 0x82,
    R_SAMPLE_TIME = 0x83,
    R_SAMPLES = 0x85,
    R_AUX_ID = 0x90,
    R_ID = 0x92,
    R_CFG4 = 0xA5,
    R_CFG8 = 0xA9,
    R_AGC_SAMPLES = 0xAC,
    R_CONTROL = 0xB1,
    R_RESIDUAL0 = 0xD2,
    R_RESIDUAL1 = 0xD3,
    R_GAIN = 0xD4,
    R_PHOTODIODES = 0xDC,
    R_CALIBRATE_EACH = 0xE4,
    R_CALIBRATION = 0xE6,
    R_GAIN_TABLE = 0xED,
    R_FIFO_DATA0 = 0xF9,
    R_FIFO_STATUS = 0xFD,
    R_FIFO = 0xFF
};

enum {
    ENABLE_ON = 0x03, /* oscillator and light measurement */
    SOFT_RESET = 0x08,
    FIFO_CLEAR = 0x02,
    FIFO_OVERFLOW = 0x80,
    SATURATED = 0x20,
    GAIN_256X = 9,
    GAIN_STEP = 2,
    SAMPLE_TIME = 719,
    SAMPLES = 199,
    MEAN_OF = 2,
    POLL_MS = 20,
    SAMPLE_MS = 1000
};

static uint32_t get_u32be(const uint8_t *b)
{
    return (uint32_t)b[0] << 24 | (uint32_t)b[1] << 16 | (uint32_t)b[2] << 8 | (uint32_t)b[3];
}

static uint32_t get_u32le(const uint8_t *b)
{
    return (uint32_t)b[3] << 24 | (uint32_t)b[2] << 16 | (uint32_t)b[1] << 8 | (uint32_t)b[0];
}

static double get_float(const uint8_t *b)
{
    const uint32_t bits = get_u32be(b);
    float value;
    memcpy(&value, &bits, sizeof value);
    return (double)value;
}

uint32_t densistick_checksum(const uint8_t *bytes, size_t words)
{
    uint32_t crc = 0xFFFFFFFFU;
    for (size_t i = 0; i < words; i++) {
        crc ^= get_u32le(bytes + 4 * i);
        for (int bit = 0; bit < 32; bit++)
            crc = crc & 0x80000000U ? crc << 1 ^ 0x04C11DB7U : crc << 1;
    }
    return crc;
}

bool densistick_calibration_parse(const uint8_t bytes[DENSISTICK_CALIBRATION],
                                  densistick_calibration *out)
{
    enum { VERSION = 1, GAINS = 16, GAINS_CRC = 60, TARGETS = 80, TARGETS_CRC = 108 };
    if (get_u32be(bytes) != VERSION ||
        get_u32be(bytes + GAINS_CRC) !=
            densistick_checksum(bytes + GAINS, (GAINS_CRC - GAINS) / 4) ||
        get_u32be(bytes + TARGETS_CRC) !=
            densistick_checksum(bytes + TARGETS, (TARGETS_CRC - TARGETS) / 4))
        return false;
    for (size_t i = 0; i < DENSISTICK_GAINS; i++) {
        out->gain[i] = get_float(bytes + GAINS + 4 * i);
        if (!(out->gain[i] > 0.0 && out->gain[i] <= 512.0))
            return false;
    }
    out->low_density = get_float(bytes + TARGETS);
    out->low_reading = get_float(bytes + TARGETS + 4);
    out->high_density = get_float(bytes + TARGETS + 8);
    out->high_reading = get_float(bytes + TARGETS + 12);
    return out->low_density >= -0.1 && out->high_density > out->low_density &&
           out->high_density < 6.0 && out->high_reading > 0.0 &&
           out->low_reading > out->high_reading && out->low_reading < 1e9;
}

double densistick_density(const densistick_calibration *c, double count, unsigned gain)
{
    const double milliseconds = (SAMPLES + 1) * (SAMPLE_TIME + 1) * 1.388889e-3;
    const double basic = count / 16.0 / (milliseconds * c->gain[gain]);
    const double slope =
        (c->high_density - c->low_density) / (log10(c->high_reading) - log10(c->low_reading));
    return c->low_density + slope * (log10(basic) - log10(c->low_reading));
}

static cal_status read_eeprom(transport *t, unsigned from, uint8_t *bytes, size_t n)
{
    for (size_t done = 0; done < n; done += EEPROM_STEP) {
        const unsigned at = from + (unsigned)done;
        const size_t part = n - done < EEPROM_STEP ? n - done : EEPROM_STEP;
        const cal_status status =
            ft260_read(t, (uint8_t)(EEPROM | (at >> 8 & 3)), (uint8_t)at, bytes + done, part);
        if (status != CAL_OK)
            return status;
    }
    return CAL_OK;
}

static cal_status put(transport *t, uint8_t reg, uint8_t value)
{
    return ft260_write(t, SENSOR, reg, &value, 1);
}

/* Change the bits of a register that `mask` names. */
static cal_status change(transport *t, uint8_t reg, uint8_t mask, uint8_t bits)
{
    uint8_t value;
    const cal_status status = ft260_read(t, SENSOR, reg, &value, 1);
    return status == CAL_OK ? put(t, reg, (uint8_t)((value & ~mask) | bits)) : status;
}

/* One sensor channel with both photopic diodes, 32-bit results with residuals into the FIFO, gains
 * up to 256x, calibration in every round, no automatic gain. */
static cal_status configure(transport *t, uint8_t aux_id)
{
    static const struct {
        uint8_t reg, mask, bits;
    } changes[] = {
        {R_MODE0, 0x10, 0x10},          {R_FIFO_DATA0, 0x80, 0x80}, {R_FIFO_DATA0 + 1, 0x80, 0},
        {R_FIFO_DATA0 + 2, 0x80, 0},    {R_CFG4, 0xFC, 0x03},       {R_MODE1, 0x1F, 0x06},
        {R_RESIDUAL0, 0xFF, 0xFF},      {R_RESIDUAL1, 0x0F, 0x0F},  {R_GAIN_TABLE, 0x30, 0x30},
        {R_CFG8, 0xF0, GAIN_256X << 4}, {R_MODULATORS, 0xFF, 0x02}, {R_CALIBRATE_EACH, 0xFF, 0x01},
        {R_CALIBRATION, 0x20, 0x00}};
    /* Two bits a diode, 1: modulator 0. Diodes 1 and 5, or 1, 2, 3 and 4 of the TSL2522. */
    static const uint8_t tsl2585[] = {0x04, 0x04}, tsl2522[] = {0x54, 0x01};
    const uint8_t *diodes = aux_id == AUX_TSL2585 ? tsl2585 : tsl2522;
    static const uint8_t none[] = {0, 0};
    static const uint8_t time[] = {SAMPLE_TIME & 0xFF, SAMPLE_TIME >> 8};
    static const uint8_t samples[] = {SAMPLES & 0xFF, SAMPLES >> 8};
    cal_status status = CAL_OK;
    for (size_t i = 0; status == CAL_OK && i < sizeof changes / sizeof changes[0]; i++)
        status = change(t, changes[i].reg, changes[i].mask, changes[i].bits);
    if (status == CAL_OK)
        status = put(t, R_PHOTODIODES, diodes[0]);
    if (status == CAL_OK)
        status = change(t, R_PHOTODIODES + 1, 0x0F, diodes[1]);
    if (status == CAL_OK)
        status = ft260_write(t, SENSOR, R_AGC_SAMPLES, none, 2);
    if (status == CAL_OK)
        status = ft260_write(t, SENSOR, R_SAMPLE_TIME, time, 2);
    return status == CAL_OK ? ft260_write(t, SENSOR, R_SAMPLES, samples, 2) : status;
}

/* The next sample of the running sensor. */
static cal_status next_sample(transport *t, uint8_t sample[DENSISTICK_SAMPLE])
{
    const int64_t deadline = t->ops->now_ms(t) + SAMPLE_MS;
    for (;;) {
        uint8_t fifo[2];
        cal_status status = ft260_read(t, SENSOR, R_FIFO_STATUS, fifo, 2);
        if (status != CAL_OK)
            return status;
        if (fifo[1] & FIFO_OVERFLOW) {
            status = put(t, R_CONTROL, FIFO_CLEAR);
            if (status != CAL_OK)
                return status;
        } else if ((fifo[0] << 2 | (fifo[1] & 3)) >= DENSISTICK_SAMPLE) {
            return ft260_read(t, SENSOR, R_FIFO, sample, DENSISTICK_SAMPLE);
        }
        if (transport_left(t, deadline) == 0)
            return CAL_TIMEOUT;
        /* Nothing is sent unasked, so waiting for it is a pause that SIGINT and unplugging end. */
        uint8_t unasked[64];
        size_t got;
        status = t->ops->read(t, unasked, sizeof unasked, &got, POLL_MS);
        if (status != CAL_OK && status != CAL_TIMEOUT)
            return status;
    }
}

/* Samples at the highest gain that does not saturate; the one after a change of gain is not used.
 */
static cal_status sample(transport *t, double *count, unsigned *gain)
{
    uint8_t bytes[DENSISTICK_SAMPLE];
    for (int g = GAIN_256X;; g -= GAIN_STEP) {
        if (g < 0)
            return CAL_MISREAD;
        cal_status status = change(t, R_GAIN, 0x0F, (uint8_t)g);
        double sum = 0.0;
        bool saturated = false;
        for (int i = -1; status == CAL_OK && i < MEAN_OF && !saturated; i++) {
            status = next_sample(t, bytes);
            saturated = i >= 0 && (bytes[4] & SATURATED);
            sum += i >= 0 ? (double)get_u32le(bytes) : 0.0;
        }
        if (status != CAL_OK)
            return status;
        if (saturated)
            continue;
        *gain = bytes[5] & 0x0F;
        *count = sum / MEAN_OF;
        return *gain<DENSISTICK_GAINS && * count> 0.0 ? CAL_OK : CAL_MISREAD;
    }
}

static cal_status sensor_start(transport *t, uint8_t *aux_id)
{
    uint8_t ids[3]; /* auxiliary, revision, device */
    cal_status status = ft260_read(t, SENSOR, R_AUX_ID, ids, sizeof ids);
    if (status != CAL_OK)
        return status;
    *aux_id = ids[0] & 0x0F;
    if (ids[R_ID - R_AUX_ID] != SENSOR_ID || (*aux_id != AUX_TSL2585 && *aux_id != AUX_TSL2522))
        return CAL_PROTOCOL;
    status = put(t, R_ENABLE, ENABLE_ON);
    if (status == CAL_OK)
        status = put(t, R_CONTROL, SOFT_RESET);
    return status == CAL_OK ? put(t, R_ENABLE, 0) : status;
}

static cal_status read_calibration(instrument *in, densistick_calibration *out, cal_error *err)
{
    uint8_t bytes[DENSISTICK_CALIBRATION];
    const cal_status status = read_eeprom(in->port, EEPROM_CALIBRATION, bytes, sizeof bytes);
    if (status != CAL_OK)
        return instrument_fail(in, status, err);
    return densistick_calibration_parse(bytes, out) ? CAL_OK
                                                    : instrument_fail(in, CAL_CALIBRATE, err);
}

static cal_status identify(instrument *in, int timeout_ms, cal_error *err)
{
    uint8_t version[4], header[8], aux_id;
    (void)timeout_ms;
    if (!in->port->ops->set_feature)
        return cal_fail(err, CAL_UNSUPPORTED, "a DensiStick is on hid:16d0:1382, not on '%s'",
                        in->port->name);
    cal_status status = ft260_start(in->port, version);
    if (status == CAL_OK)
        status = read_eeprom(in->port, EEPROM_HEADER, header, sizeof header);
    if (status == CAL_OK && memcmp(header, "DPD\1", 4) != 0)
        status = CAL_PROTOCOL;
    if (status == CAL_OK)
        status = sensor_start(in->port, &aux_id);
    if (status == CAL_OK)
        status = ft260_lamp(in->port, true);
    if (status == CAL_OK)
        status = ft260_write_raw(in->port, LAMP_CURRENT, LAMP_IDLE);
    if (status != CAL_OK)
        return instrument_fail(in, status, err);
    char text[64];
    int n = snprintf(text, sizeof text, "type %u revision %u.%u", header[4], header[5], header[6]);
    instrument_fact_set(in, "maker", "Dektronics", 10);
    instrument_fact_set(in, "model", "DensiStick", 10);
    instrument_fact_set(in, "hardware", text, (size_t)n);
    n = snprintf(text, sizeof text, "FT260 %02x%02x-%u.%u", version[0], version[1], version[2],
                 version[3]);
    instrument_fact_set(in, "firmware", text, (size_t)n);
    instrument_fact_set(in, "sensor", aux_id == AUX_TSL2585 ? "TSL2585" : "TSL2522", 7);
    densistick_calibration calibration;
    return read_calibration(in, &calibration, err);
}

static cal_status measure(instrument *in, int timeout_ms, reading *out, cal_error *err)
{
    densistick_calibration calibration = {.low_density = 0.0};
    transport *t = in->port;
    double count = 0.0;
    unsigned gain = 0;
    uint8_t aux_id;
    (void)timeout_ms;
    cal_status status = read_calibration(in, &calibration, err);
    if (status != CAL_OK)
        return status;
    status = sensor_start(t, &aux_id);
    if (status == CAL_OK)
        status = ft260_write_raw(t, LAMP_CURRENT, LAMP_FULL);
    if (status == CAL_OK)
        status = configure(t, aux_id);
    if (status == CAL_OK)
        status = put(t, R_ENABLE, ENABLE_ON);
    if (status == CAL_OK)
        status = sample(t, &count, &gain);
    /* The lamp does not stay hot, whatever happened. */
    (void)put(t, R_ENABLE, 0);
    (void)ft260_write_raw(t, LAMP_CURRENT, LAMP_IDLE);
    if (status != CAL_OK)
        return instrument_fail(in, status, err);
    memset(out, 0, sizeof *out);
    out->kind = READING_REFLECTION;
    out->value = densistick_density(&calibration, count, gain);
    out->step = FLOAT_DENSITY_STEP;
    return CAL_OK;
}

static cal_status discard(instrument *in)
{
    in->have = 0;
    return CAL_OK;
}

static void leave(instrument *in) { (void)ft260_lamp(in->port, false); }

const instrument_driver densistick_driver = {
    .name = "densistick",
    .title = "DensiStick",
    .on_hid = true,
    .experimental = true,
    .how = "hold the DensiStick on the patch; it reads by itself",
    .identify = identify,
    .measure = measure,
    .discard = discard,
    .leave = leave,
};
