/* SPDX-License-Identifier: MIT */
#include "instrument/dektronics-densistick/ft260.h"

#include <string.h>

enum {
    REPORT_VERSION = 0xA0,
    REPORT_SETTING = 0xA1,
    SETTING_I2C_CLOCK = 0x22,
    I2C_KILOHERTZ = 400,
    REPORT_GPIO = 0xB0,
    PIN_F = 0x20,
    PIN_H = 0x80,
    REPORT_READ = 0xC2,
    REPORT_DATA = 0xD0, /* to 0xDE: room for 4, 8, .. 60 bytes */
    I2C_START = 0x02,
    I2C_STOP = 0x04,
    I2C_START_STOP = 0x06,
    I2C_RESTART_STOP = 0x07,
    HEADER = 4,
    REPORT_MAX = 64
};

cal_status ft260_start(transport *t, uint8_t version[4])
{
    static const uint8_t clock[] = {REPORT_SETTING, SETTING_I2C_CLOCK, I2C_KILOHERTZ & 0xFF,
                                    I2C_KILOHERTZ >> 8};
    uint8_t report[REPORT_MAX] = {REPORT_VERSION};
    cal_status status = t->ops->get_feature(t, report, sizeof report);
    if (status != CAL_OK)
        return status;
    memcpy(version, report + 1, 4);
    return t->ops->set_feature(t, clock, sizeof clock);
}

cal_status ft260_lamp(transport *t, bool lamp)
{
    /* Pins 0-5 off and inputs; F high; H output. */
    const uint8_t report[] = {REPORT_GPIO, 0, 0, (uint8_t)(lamp ? PIN_F | PIN_H : PIN_F), PIN_H};
    return t->ops->set_feature(t, report, sizeof report);
}

static cal_status send(transport *t, uint8_t address, uint8_t flags, const uint8_t *bytes, size_t n)
{
    const size_t groups = (n + 3) / 4;
    uint8_t report[REPORT_MAX] = {(uint8_t)(REPORT_DATA + groups - 1), address, flags, (uint8_t)n};
    memcpy(report + HEADER, bytes, n);
    return t->ops->write(t, report, HEADER + 4 * groups, FT260_ANSWER_MS);
}

cal_status ft260_read(transport *t, uint8_t address, uint8_t reg, uint8_t *bytes, size_t n)
{
    cal_status status = send(t, address, I2C_START, &reg, 1);
    if (status != CAL_OK)
        return status;
    const uint8_t request[] = {REPORT_READ, address, I2C_RESTART_STOP, (uint8_t)n, 0};
    status = t->ops->write(t, request, sizeof request, FT260_ANSWER_MS);
    if (status != CAL_OK)
        return status;
    uint8_t report[REPORT_MAX];
    size_t got;
    status = t->ops->read(t, report, sizeof report, &got, FT260_ANSWER_MS);
    if (status != CAL_OK)
        return status;
    if (got < 2 + n || (report[0] & 0xF0) != REPORT_DATA || report[1] != n)
        return CAL_PROTOCOL;
    memcpy(bytes, report + 2, n);
    return CAL_OK;
}

cal_status ft260_write(transport *t, uint8_t address, uint8_t reg, const uint8_t *bytes, size_t n)
{
    const cal_status status = send(t, address, I2C_START, &reg, 1);
    return status == CAL_OK ? send(t, address, I2C_STOP, bytes, n) : status;
}

cal_status ft260_write_raw(transport *t, uint8_t address, uint8_t byte)
{
    return send(t, address, I2C_START_STOP, &byte, 1);
}
