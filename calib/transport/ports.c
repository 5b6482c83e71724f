/* SPDX-License-Identifier: MIT */
#define _XOPEN_SOURCE 700 /* realpath */
#include "transport/ports.h"

#include <dirent.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* First line of folder/name, without what a text file cannot hold. */
static bool read_attribute(const char *folder, const char *name, char *out, size_t capacity)
{
    char path[PATH_MAX];
    if (snprintf(path, sizeof path, "%s/%s", folder, name) >= (int)sizeof path)
        return false;
    FILE *file = fopen(path, "r");
    if (!file)
        return false;
    const size_t n = fread(out, 1, capacity - 1, file);
    fclose(file);
    out[n] = '\0';
    out[strcspn(out, "\r\n")] = '\0';
    for (char *c = out; *c; c++)
        if (*c < 0x20 || *c == 0x7F || *c == '"')
            *c = '?';
    return true;
}

static bool read_hex4(const char *folder, const char *name, unsigned *out)
{
    char text[16];
    if (!read_attribute(folder, name, text, sizeof text) || strlen(text) != 4)
        return false;
    *out = 0;
    for (int i = 0; i < 4; i++) {
        const char *digits = "0123456789abcdef";
        const char *at = strchr(digits, text[i] | 0x20);
        if (!at)
            return false;
        *out = *out << 4 | (unsigned)(at - digits);
    }
    return true;
}

/* Fill in what the USB device in `folder` says of itself. */
static bool read_usb(const char *folder, port_info *out)
{
    char maker[48] = "", product[48] = "";
    if (!read_hex4(folder, "idVendor", &out->vendor) ||
        !read_hex4(folder, "idProduct", &out->product))
        return false;
    (void)read_attribute(folder, "serial", out->serial, sizeof out->serial);
    (void)read_attribute(folder, "manufacturer", maker, sizeof maker);
    (void)read_attribute(folder, "product", product, sizeof product);
    snprintf(out->title, sizeof out->title, "%s%s%s", maker, *maker && *product ? " " : "",
             product);
    return true;
}

/* Go up from /sys/class/CLASS/NAME/device to the USB device that carries it. */
static bool find_usb(const char *class_folder, const char *name, port_info *out)
{
    char link[PATH_MAX], folder[PATH_MAX];
    if (snprintf(link, sizeof link, "%s/%s/device", class_folder, name) >= (int)sizeof link ||
        !realpath(link, folder))
        return false;
    for (char *slash = strrchr(folder, '/'); slash && slash > folder + 4;
         slash = strrchr(folder, '/')) {
        if (read_usb(folder, out))
            return true;
        *slash = '\0';
    }
    return false;
}

static size_t scan_class(const char *class_folder, port_info *out, size_t capacity)
{
    size_t count = 0;
    DIR *dir = opendir(class_folder);
    for (struct dirent *e = dir ? readdir(dir) : NULL; e && count < capacity; e = readdir(dir)) {
        port_info *p = &out[count];
        memset(p, 0, sizeof *p);
        if (e->d_name[0] == '.' || strlen(e->d_name) > 32 || !find_usb(class_folder, e->d_name, p))
            continue;
        snprintf(p->path, sizeof p->path, "/dev/%.32s", e->d_name);
        count++;
    }
    if (dir)
        closedir(dir);
    return count;
}

static int by_path(const void *a, const void *b)
{
    return strcmp(((const port_info *)a)->path, ((const port_info *)b)->path);
}

static bool has_port(const port_info *ports, size_t count, const port_info *device)
{
    for (size_t i = 0; i < count; i++)
        if (ports[i].vendor == device->vendor && ports[i].product == device->product &&
            strcmp(ports[i].serial, device->serial) == 0)
            return true;
    return false;
}

size_t ports_scan(port_info *out, size_t capacity)
{
    static const char usb[] = "/sys/bus/usb/devices";
    size_t count = scan_class("/sys/class/tty", out, capacity);
    count += scan_class("/sys/class/hidraw", out + count, capacity - count);
    qsort(out, count, sizeof *out, by_path);
    const size_t with_port = count;
    DIR *dir = opendir(usb);
    for (struct dirent *e = dir ? readdir(dir) : NULL; e && count < capacity; e = readdir(dir)) {
        char folder[PATH_MAX];
        port_info *p = &out[count];
        memset(p, 0, sizeof *p);
        if (e->d_name[0] == '.' ||
            snprintf(folder, sizeof folder, "%s/%s", usb, e->d_name) >= (int)sizeof folder)
            continue;
        if (read_usb(folder, p) && !has_port(out, with_port, p))
            count++;
    }
    if (dir)
        closedir(dir);
    return count;
}
