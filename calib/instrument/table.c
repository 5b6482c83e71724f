/* SPDX-License-Identifier: MIT */
#include "instrument/dektronics-densistick/densistick.h"
#include "instrument/dektronics-printalyzer/printalyzer.h"
#include "instrument/generic-line/line.h"
#include "instrument/hughski-colorhug2/colorhug2.h"
#include "instrument/xrite-rci/rci.h"

#include <stdio.h>
#include <string.h>

enum { IDLE_MS = 500 };

const instrument_driver *const instrument_drivers[] = {
    &printalyzer_driver, &rci_driver, &line_driver, &colorhug2_driver, &densistick_driver,
};
const size_t instrument_driver_count = sizeof instrument_drivers / sizeof instrument_drivers[0];

const instrument_driver *instrument_driver_find(const char *name)
{
    for (size_t i = 0; i < instrument_driver_count; i++)
        if (strcmp(instrument_drivers[i]->name, name) == 0)
            return instrument_drivers[i];
    return NULL;
}

static cal_status set_up(const instrument_driver *driver, const char *preset, int timeout_ms,
                         instrument *in, cal_error *err)
{
    transport *port = in->port;
    memset(in, 0, sizeof *in);
    in->port = port;
    in->driver = driver;
    in->preset = preset;
    in->idle_ms = IDLE_MS;
    if (driver->line) {
        if (!port->ops->configure)
            return cal_fail(err, CAL_UNSUPPORTED, "%s is on a serial port, and '%s' is none",
                            driver->title, port->name);
        const cal_status status = port->ops->configure(port, driver->line);
        if (status != CAL_OK)
            return instrument_fail(in, status, err);
    }
    const cal_status status = driver->identify(in, timeout_ms, err);
    in->noise = 0;
    return status;
}

/* A USB device says what it is. */
static cal_status set_up_known(int timeout_ms, instrument *in, cal_error *err)
{
    const usb_model *model = usb_model_find(in->port->vendor, in->port->product);
    if (model && model->driver)
        return set_up(instrument_driver_find(model->driver), "", timeout_ms, in, err);
    return cal_fail(err, CAL_NO_DEVICE, "'%s' is %s, which lccal cannot use%s%s", in->port->name,
                    model ? model->title : "a USB device", model ? "; " : "",
                    model ? model->advice : "");
}

/* Ask a serial port for each instrument that can say who it is. */
static cal_status set_up_any(int timeout_ms, instrument *in, cal_error *err)
{
    if (in->port->ops->messages)
        return set_up_known(timeout_ms, in, err);
    for (size_t i = 0; i < instrument_driver_count; i++) {
        if (instrument_drivers[i]->silent || instrument_drivers[i]->on_hid)
            continue;
        const cal_status status = set_up(instrument_drivers[i], "", timeout_ms, in, err);
        if (status != CAL_TIMEOUT && status != CAL_PROTOCOL)
            return status;
    }
    return cal_fail(err, CAL_TIMEOUT,
                    "nothing known answers on '%s'; switch the instrument on, or name one that "
                    "only prints: --instrument line:PRESET",
                    in->port->name);
}

cal_status instrument_open(const char *name, transport *port, int timeout_ms, instrument *in,
                           cal_error *err)
{
    memset(in, 0, sizeof *in);
    in->port = port;
    if (strcmp(name, "auto") == 0)
        return set_up_any(timeout_ms, in, err);
    char driver_name[32];
    const size_t length = strcspn(name, ":");
    snprintf(driver_name, sizeof driver_name, "%.*s", (int)(length < 32 ? length : 31), name);
    const instrument_driver *driver = instrument_driver_find(driver_name);
    if (!driver)
        return cal_fail(err, CAL_UNSUPPORTED,
                        "no instrument '%s'; known: auto printalyzer line:PRESET xrite-rci "
                        "colorhug2 densistick",
                        name);
    return set_up(driver, name[length] ? name + length + 1 : "", timeout_ms, in, err);
}
