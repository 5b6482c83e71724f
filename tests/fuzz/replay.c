/* SPDX-License-Identifier: MIT */
/* Stands in for libFuzzer's main: runs every file named, or every file of a folder named, through
 * the target once, so that the kept corpus is a test with any compiler. */
#define _POSIX_C_SOURCE 200809L
#include <dirent.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static int run_file(const char *path)
{
    FILE *f = fopen(path, "rb");
    if (!f) {
        perror(path);
        return 0;
    }
    fseek(f, 0, SEEK_END);
    const long size = ftell(f);
    rewind(f);
    uint8_t *data = malloc(size > 0 ? (size_t)size : 1);
    const int ok = data && size >= 0 && fread(data, 1, (size_t)size, f) == (size_t)size;
    if (ok)
        LLVMFuzzerTestOneInput(data, (size_t)size);
    free(data);
    fclose(f);
    return ok;
}

static int run_folder(const char *path, unsigned long *count)
{
    DIR *dir = opendir(path);
    if (!dir) {
        perror(path);
        return 0;
    }
    int ok = 1;
    for (struct dirent *entry = readdir(dir); entry; entry = readdir(dir)) {
        char name[4096];
        const int n = snprintf(name, sizeof name, "%s/%s", path, entry->d_name);
        if (entry->d_name[0] == '.' || n < 0 || (size_t)n >= sizeof name)
            continue;
        ok &= run_file(name);
        ++*count;
    }
    closedir(dir);
    return ok;
}

int main(int argc, char **argv)
{
    unsigned long count = 0;
    int ok = argc > 1;
    for (int i = 1; i < argc; i++) {
        struct stat info;
        if (stat(argv[i], &info) == 0 && S_ISDIR(info.st_mode)) {
            ok &= run_folder(argv[i], &count);
        } else {
            ok &= run_file(argv[i]);
            count++;
        }
    }
    printf("%lu inputs replayed\n", count);
    return ok && count > 0 ? 0 : 1;
}
