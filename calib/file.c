/* SPDX-License-Identifier: MIT */
#define _XOPEN_SOURCE 700
#include "lccal.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { FILE_LIMIT = 64 << 20 };

static int fail_file(const char *what, const char *path, int error)
{
    const char *hint = "";
    if (error == ENOSPC || error == EDQUOT)
        hint = "; free some space and run it again";
    else if (error == EACCES || error == EROFS)
        hint = "; choose a folder you may write to with -o";
    else if (error == ENOENT)
        hint = "; the folder does not exist, make it first";
    const bool denied = error == EACCES || error == EPERM || error == EROFS;
    return lccal_fail(denied ? LCCAL_PERMISSION : LCCAL_FAILED, "cannot %s '%s': %s%s", what, path,
                      strerror(error), hint);
}

static bool write_all(int fd, const char *bytes, size_t size)
{
    while (size > 0) {
        const ssize_t n = write(fd, bytes, size);
        if (n < 0 && errno == EINTR)
            continue;
        if (n < 0)
            return false;
        bytes += n;
        size -= (size_t)n;
    }
    return true;
}

/* Make the renames in the folder of `path` durable. Folders that cannot be synced (some network
 * file systems) are no failure: the rename itself is atomic there too. */
static void sync_folder(const char *path)
{
    char *folder = strdup(path);
    char *slash = folder ? strrchr(folder, '/') : NULL;
    const char *name = ".";
    if (slash) {
        slash[slash == folder ? 1 : 0] = '\0';
        name = folder;
    }
    const int fd = folder ? open(name, O_RDONLY | O_DIRECTORY) : -1;
    if (fd >= 0) {
        (void)fsync(fd);
        close(fd);
    }
    free(folder);
}

/* A second name for the old file, so that it never stops existing under its own. */
static int keep_backup(const char *path, const char *backup)
{
    if (access(path, F_OK) != 0)
        return 0;
    if (unlink(backup) != 0 && errno != ENOENT)
        return errno;
    if (link(path, backup) == 0)
        return 0;
    /* No hard links on this file system: copy. */
    char *bytes = NULL;
    size_t size = 0;
    if (lccal_load_file(path, LCCAL_FAILED, &bytes, &size) != LCCAL_OK)
        return EIO;
    const int status = lccal_save_file(backup, bytes, size, false);
    free(bytes);
    return status == LCCAL_OK ? 0 : EIO;
}

static int replace_file(const char *path, const void *bytes, size_t size, mode_t mode, bool backup)
{
    const size_t length = strlen(path);
    char *temporary = malloc(length + 8);
    char *previous = malloc(length + 2);
    int fd = -1;
    int error = 0;
    const char *step = "write";
    int result = LCCAL_OK;
    if (!temporary || !previous) {
        result = lccal_fail(LCCAL_FAILED, "out of memory while saving '%s'", path);
        goto done;
    }
    snprintf(temporary, length + 8, "%s.XXXXXX", path);
    snprintf(previous, length + 2, "%s~", path);

    fd = mkstemp(temporary);
    if (fd < 0) {
        result = fail_file(step, path, errno);
        goto done;
    }
    if (fchmod(fd, mode) != 0 || /* not mkstemp's private rights */
        !write_all(fd, bytes, size) || fsync(fd) != 0)
        error = errno;
    if (close(fd) != 0 && error == 0)
        error = errno;
    if (error == 0 && backup) {
        step = "keep a backup of";
        error = keep_backup(path, previous);
    }
    if (error == 0) {
        step = "replace";
        if (rename(temporary, path) != 0)
            error = errno;
    }
    if (error != 0) {
        unlink(temporary);
        result = fail_file(step, path, error);
    } else {
        sync_folder(path);
    }
done:
    free(temporary);
    free(previous);
    return result;
}

/* Devices and pipes are written to as they are. */
static int write_device(const char *path, const void *bytes, size_t size)
{
    int error = 0;
    const int fd = open(path, O_WRONLY);
    if (fd < 0)
        return fail_file("write", path, errno);
    if (!write_all(fd, bytes, size))
        error = errno;
    if (close(fd) != 0 && error == 0)
        error = errno;
    return error == 0 ? LCCAL_OK : fail_file("write", path, error);
}

int lccal_check_target(const char *path)
{
    struct stat info;
    if (stat(path, &info) == 0 && S_ISDIR(info.st_mode))
        return lccal_fail(LCCAL_USAGE, "'%s' is a folder; name a file in it", path);
    return LCCAL_OK;
}

int lccal_save_file(const char *path, const void *bytes, size_t size, bool backup)
{
    struct stat info;
    if (stat(path, &info) != 0) {
        const mode_t mask = umask(0);
        umask(mask);
        return replace_file(path, bytes, size, 0666 & ~mask, backup);
    }
    if (S_ISDIR(info.st_mode))
        return lccal_check_target(path);
    if (!S_ISREG(info.st_mode))
        return write_device(path, bytes, size);
    char *target = realpath(path, NULL);
    if (!target)
        return fail_file("write", path, errno);
    const int result = replace_file(target, bytes, size, info.st_mode & 07777, backup);
    free(target);
    return result;
}

int lccal_load_file(const char *path, int missing, char **bytes, size_t *size)
{
    FILE *file = fopen(path, "rb");
    if (!file)
        return lccal_fail(errno == EACCES ? LCCAL_PERMISSION : missing, "cannot read '%s': %s",
                          path, strerror(errno));
    char *text = NULL;
    size_t used = 0, room = 0;
    int result = LCCAL_OK;
    for (;;) {
        if (room - used < 2) {
            room = room ? 2 * room : 65536;
            char *bigger = room <= 2 * (size_t)FILE_LIMIT ? realloc(text, room) : NULL;
            if (!bigger) {
                result = lccal_fail(LCCAL_FAILED, "'%s' is too large (over 64 MiB)", path);
                break;
            }
            text = bigger;
        }
        errno = 0;
        const size_t n = fread(text + used, 1, room - used - 1, file);
        used += n;
        if (n > 0)
            continue;
        if (ferror(file))
            result = lccal_fail(missing, "cannot read '%s': %s", path, strerror(errno));
        break;
    }
    fclose(file);
    if (result != LCCAL_OK || !text) {
        free(text);
        return result;
    }
    text[used] = '\0';
    *bytes = text;
    *size = used;
    return LCCAL_OK;
}
