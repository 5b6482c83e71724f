/* SPDX-License-Identifier: MIT */
#define _POSIX_C_SOURCE 200809L
#include "command/find.h"
#include "instrument/instrument.h"
#include "lccal.h"
#include "transport/ports.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

static const char help[] =
    "lccal list [--all] [--json]   known instruments on USB, with their ports\n"
    "\n"
    "No port is opened. An instrument that is listed but cannot be used has the reason after it.\n"
    "Instruments on plain serial adapters cannot be told apart: name --port and --instrument.\n"
    "\n"
    "  --all    other USB serial ports and HID devices too\n";

const char *find_obstacle(const port_info *port, const usb_model *model)
{
    if (!model)
        return "not known; name it with --port and --instrument";
    if (!model->driver)
        return model->advice;
    if (!*port->path)
        return "the kernel gave it no port; `lccal doctor` says more";
    if (access(port->path, R_OK | W_OK) != 0)
        return "no permission; `lccal doctor` says what to do";
    return NULL;
}

/* The port option to say for it: HID instruments by their numbers, which outlive replugging. */
static const char *port_name(const port_info *port, char *text, size_t capacity)
{
    if (strncmp(port->path, "/dev/hidraw", 11) != 0)
        return port->path;
    snprintf(text, capacity, "hid:%04x:%04x%s%s", port->vendor, port->product,
             *port->serial ? ":" : "", port->serial);
    return text;
}

static void show(const port_info *port, const usb_model *model, json *list)
{
    char text[96];
    const char *name = port_name(port, text, sizeof text);
    const char *obstacle = find_obstacle(port, model);
    const char *title = model ? model->title : *port->title ? port->title : "USB device";
    json_open(list, NULL, '{');
    json_text(list, "port", name);
    json_text(list, "node", port->path);
    json_text(list, "title", title);
    json_text(list, "serial", port->serial);
    json_text(list, "instrument", model && model->driver ? model->driver : "");
    json_text(list, "obstacle", obstacle ? obstacle : "");
    json_close(list, '}');
    if (lccal_json())
        return;
    printf("%-28s %s%s%s", *name ? name : "(no port)", title, *port->serial ? ", serial " : "",
           port->serial);
    if (obstacle)
        printf("  [%s]", obstacle);
    printf("\n");
}

/* A HID device with several interfaces has as many nodes; the first one names it. */
static bool is_repeated(const port_info *ports, size_t i)
{
    return i > 0 && ports[i].vendor == ports[i - 1].vendor &&
           ports[i].product == ports[i - 1].product &&
           strcmp(ports[i].serial, ports[i - 1].serial) == 0 &&
           strncmp(ports[i].path, "/dev/hidraw", 11) == 0;
}

int cmd_list(int argc, char **argv)
{
    static port_info ports[PORTS_MAX];
    bool all = false;
    const lccal_option options[] = {{"--all", NULL, LCCAL_FLAG, &all}};
    const int parsed = lccal_parse_options(&argc, argv, options, 1, help);
    if (parsed != LCCAL_OK)
        return parsed < 0 ? LCCAL_OK : parsed;
    if (argc > 1)
        return lccal_fail(LCCAL_USAGE, "list takes no '%s'", argv[1]);
    const size_t count = ports_scan(ports, PORTS_MAX);
    size_t shown = 0;
    json event = lccal_event("list");
    json_open(&event, "devices", '[');
    for (size_t i = 0; i < count; i++) {
        const usb_model *model = usb_model_find(ports[i].vendor, ports[i].product);
        if (is_repeated(ports, i) || (!model && (!all || !*ports[i].path)))
            continue;
        show(&ports[i], model, &event);
        shown++;
    }
    json_close(&event, ']');
    lccal_event_end(&event);
    if (shown == 0)
        lccal_say(
            all ? "No serial port and no HID device is plugged in on USB."
                : "No known instrument is plugged in; --all shows other ports on USB. One on a "
                  "serial adapter must be named: lccal --port /dev/ttyUSB0 --instrument "
                  "line:PRESET");
    return LCCAL_OK;
}

int lccal_find_port(lccal_measure_options *options, char *port, size_t capacity)
{
    if (options->port)
        return LCCAL_OK;
    static port_info ports[PORTS_MAX];
    const size_t count = ports_scan(ports, PORTS_MAX);
    size_t usable = 0, known = 0;
    const char *why = NULL, *driver = NULL;
    for (size_t i = 0; i < count; i++) {
        const usb_model *model = usb_model_find(ports[i].vendor, ports[i].product);
        if (!model || is_repeated(ports, i))
            continue;
        known++;
        const char *obstacle = find_obstacle(&ports[i], model);
        if (obstacle) {
            why = obstacle;
            continue;
        }
        if (usable++ == 0) {
            port_name(&ports[i], port, capacity);
            driver = model->driver;
        }
    }
    if (usable == 1) {
        options->port = port;
        options->instrument = options->instrument ? options->instrument : driver;
        return LCCAL_OK;
    }
    if (usable > 1)
        return lccal_fail(LCCAL_USAGE,
                          "%zu instruments are plugged in; choose one of `lccal list` "
                          "with --port",
                          usable);
    if (known > 0)
        return lccal_fail(LCCAL_NO_INSTRUMENT,
                          "the instrument that is plugged in cannot be used: "
                          "%s",
                          why);
    return lccal_fail(LCCAL_NO_INSTRUMENT, "no known instrument is plugged in; connect it, or name "
                                           "its --port and --instrument");
}
