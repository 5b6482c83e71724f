/* SPDX-License-Identifier: MIT */
/* What keeps an instrument from being used on this machine, and what to do about it. */
#define _DEFAULT_SOURCE /* flock, getgrgid */
#include "command/find.h"
#include "lccal.h"

#include <errno.h>
#include <fcntl.h>
#include <grp.h>
#include <stdio.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

static const char help[] =
    "lccal doctor [--port PORT] [--rules] [--json]   why an instrument cannot be used, and the "
    "remedy\n"
    "\n"
    "Looks at the udev rules, at every known instrument that is plugged in and at PORT: is there "
    "a\n"
    "node, may this user open it, does another program hold it. Never waits for a port.\n"
    "Exit code: 0 all is well, 3 no instrument, 4 not allowed or busy.\n"
    "\n"
    "  --rules   print the udev rules that let this machine's users open the instruments\n";

/* The rules are made from the table of models, and so always fit this lccal. */
static void print_rules(void)
{
    printf("# SPDX-License-Identifier: MIT\n"
           "# Lets whoever is logged in at the machine use the instruments lccal knows, and keeps\n"
           "# ModemManager from talking to them. Goes to /etc/udev/rules.d/69-lccal.rules.\n");
    for (size_t i = 0; i < usb_model_count; i++) {
        const usb_model *m = &usb_models[i];
        const instrument_driver *driver = m->driver ? instrument_driver_find(m->driver) : NULL;
        if (!driver)
            continue;
        printf("\n# %s\nACTION!=\"remove\", SUBSYSTEM==\"%s\", ATTRS{idVendor}==\"%04x\", "
               "ATTRS{idProduct}==\"%04x\", TAG+=\"uaccess\", ENV{ID_MM_DEVICE_IGNORE}=\"1\"\n",
               m->title, driver->on_hid ? "hidraw" : "tty", m->vendor, m->product);
    }
}

/* What was looked at, what was found, and the remedy if that is bad. */
static void report(json *checks, const char *subject, bool good, const char *text,
                   const char *remedy)
{
    json_open(checks, NULL, '{');
    json_text(checks, "subject", subject);
    json_bool(checks, "good", good);
    json_text(checks, "text", text);
    json_text(checks, "remedy", good ? "" : remedy);
    json_close(checks, '}');
    if (lccal_json())
        return;
    printf("%-4s %s: %s\n", good ? "ok" : "BAD", subject, text);
    if (!good)
        printf("     -> %s\n", remedy);
}

static void check_rules(json *checks)
{
    static const char *const folders[] = {"/etc/udev/rules.d", "/run/udev/rules.d",
                                          "/usr/local/lib/udev/rules.d", "/usr/lib/udev/rules.d",
                                          "/lib/udev/rules.d"};
    for (size_t i = 0; i < sizeof folders / sizeof folders[0]; i++) {
        char path[96];
        snprintf(path, sizeof path, "%s/69-lccal.rules", folders[i]);
        if (access(path, F_OK) == 0) {
            report(checks, "udev rules", true, path, "");
            return;
        }
    }
    report(
        checks, "udev rules", false, "69-lccal.rules is not installed",
        "paste: lccal doctor --rules | sudo tee /etc/udev/rules.d/69-lccal.rules && sudo udevadm "
        "control --reload && sudo udevadm trigger");
}

/* A node this user may not open: which group may, and how to join it. */
static int check_permission(json *checks, const char *path)
{
    struct stat info;
    char text[160], remedy[256];
    if (stat(path, &info) != 0) {
        report(checks, path, false, "there is no such port",
               "plug the instrument in and switch it on; `lccal list --all` shows those on USB");
        return LCCAL_NO_INSTRUMENT;
    }
    if (access(path, R_OK | W_OK) == 0) {
        report(checks, path, true, "this user may open it", "");
        return LCCAL_OK;
    }
    const struct group *group = getgrgid(info.st_gid);
    const char *name = group ? group->gr_name : "its group";
    const bool by_group = (info.st_mode & (S_IRGRP | S_IWGRP)) == (S_IRGRP | S_IWGRP);
    snprintf(text, sizeof text, "this user may not open it (owner %ld, group %s, mode %03o)",
             (long)info.st_uid, name, (unsigned)(info.st_mode & 0777));
    if (by_group)
        snprintf(remedy, sizeof remedy,
                 "install the udev rules, or: sudo usermod -aG %s $USER, then log in again", name);
    else
        snprintf(remedy, sizeof remedy, "install the udev rules and plug the instrument in again");
    report(checks, path, false, text, remedy);
    return LCCAL_PERMISSION;
}

/* lccal locks the ports it uses, and so do other well-behaved programs. */
static int check_use(json *checks, const char *path)
{
    const int fd = open(path, O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    if (fd < 0) {
        const bool busy = errno == EBUSY;
        report(checks, path, false, busy ? "another program has it for itself" : strerror(errno),
               busy ? "close that program (ModemManager is one that takes serial ports)"
                    : "plug the instrument in again");
        return busy ? LCCAL_PERMISSION : LCCAL_NO_INSTRUMENT;
    }
    if (!isatty(fd) && strncmp(path, "/dev/hidraw", 11) != 0) {
        close(fd);
        report(checks, path, false, "it is no serial port",
               "name the instrument's port; `lccal list --all` shows those on USB");
        return LCCAL_NO_INSTRUMENT;
    }
    const bool free_to_use = flock(fd, LOCK_EX | LOCK_NB) == 0;
    close(fd);
    report(checks, path, free_to_use,
           free_to_use ? "no other program holds it" : "another program holds it",
           "close that program, for instance another lccal");
    return free_to_use ? LCCAL_OK : LCCAL_PERMISSION;
}

static int check_port(json *checks, const char *path)
{
    const int result = check_permission(checks, path);
    return result == LCCAL_OK ? check_use(checks, path) : result;
}

static int check_device(json *checks, const port_info *port, const usb_model *model)
{
    if (!model->driver) {
        report(checks, model->title, false, "lccal cannot use it", model->advice);
        return LCCAL_OK;
    }
    report(checks, model->title, true, "is plugged in", "");
    if (*port->path)
        return check_port(checks, port->path);
    report(
        checks, model->title, false, "the kernel gave it no port",
        "load its driver: sudo modprobe cdc_acm (serial) or usbhid (HID), then plug it in again");
    return LCCAL_NO_INSTRUMENT;
}

static int check_all_devices(json *checks)
{
    static port_info ports[PORTS_MAX];
    const size_t count = ports_scan(ports, PORTS_MAX);
    int worst = LCCAL_OK;
    size_t known = 0;
    for (size_t i = 0; i < count; i++) {
        const usb_model *model = usb_model_find(ports[i].vendor, ports[i].product);
        if (!model)
            continue;
        known += model->driver != NULL;
        const int result = check_device(checks, &ports[i], model);
        worst = result > worst ? result : worst;
    }
    if (known > 0)
        return worst;
    report(checks, "instruments", false, "none that lccal knows is plugged in",
           "connect one, or check the port of one on a serial adapter: lccal doctor --port PORT");
    return LCCAL_NO_INSTRUMENT;
}

int cmd_doctor(int argc, char **argv)
{
    const char *port = NULL;
    bool rules = false;
    const lccal_option options[] = {{"--port", NULL, LCCAL_TEXT, &port},
                                    {"--rules", NULL, LCCAL_FLAG, &rules}};
    const int parsed = lccal_parse_options(&argc, argv, options, 2, help);
    if (parsed != LCCAL_OK)
        return parsed < 0 ? LCCAL_OK : parsed;
    if (argc > 1)
        return lccal_fail(LCCAL_USAGE, "doctor takes no '%s'", argv[1]);
    if (rules) {
        print_rules();
        return LCCAL_OK;
    }
    json event = lccal_event("doctor");
    json_open(&event, "checks", '[');
    check_rules(&event);
    const int result = port ? check_port(&event, port) : check_all_devices(&event);
    json_close(&event, ']');
    lccal_event_end(&event);
    return result;
}
