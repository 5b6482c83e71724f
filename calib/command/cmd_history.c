/* SPDX-License-Identifier: MIT */
/* `lccal history`: how a device changed from profile to profile. */
#define _POSIX_C_SOURCE 200809L
#include "command/profile_file.h"

#include <dirent.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

static const char help[] =
    "lccal history PROFILE|FOLDER ...\n"
    "\n"
    "  Profiles in the order of their CREATED dates, with the change of contrast since the first\n"
    "  and a * where it is more than both uncertainties explain. White and black are densities, "
    "or\n"
    "  cd/m2 of a display. A folder stands for its *.cgats files; the backup that lccal keeps\n"
    "  beside a profile (PROFILE~) is listed with it.\n"
    "\n"
    "  --json              one object with the list \"profiles\"\n"
    "  --quiet, --help, --version\n";

typedef struct entry {
    char *path;
    double created; /* seconds since 1970, or -1 */
    char date[40];
    lcor_profile_result result;
    bool display; /* then white and black are cd/m2, else densities */
    double white, black;
} entry;

typedef struct history {
    entry *entries;
    size_t count, room;
} history;

static int add_profile(history *h, const char *path)
{
    lcor_profile *profile = NULL;
    int status = profile_load(path, &profile);
    if (status != LCCAL_OK)
        return status;
    entry e = {.created = profile_created(profile)};
    const char *date = lcor_profile_keyword(profile, "CREATED");
    snprintf(e.date, sizeof e.date, "%s", date ? date : "no date");
    status = profile_evaluate(profile, &e.result);
    e.display = profile_is_display(profile);
    lcor_profile_free(profile);
    if (status != LCCAL_OK)
        return status;
    e.white = e.display ? profile_luminance(e.result.d_min) : e.result.d_min;
    e.black = e.display ? profile_luminance(e.result.d_max) : e.result.d_max;
    if (h->count == h->room) {
        const size_t room = h->room ? 2 * h->room : 16;
        entry *larger = realloc(h->entries, room * sizeof *larger);
        if (!larger)
            return lccal_fail(LCCAL_FAILED, "out of memory");
        h->entries = larger;
        h->room = room;
    }
    e.path = strdup(path);
    if (!e.path)
        return lccal_fail(LCCAL_FAILED, "out of memory");
    h->entries[h->count++] = e;
    return LCCAL_OK;
}

static int add_folder(history *h, const char *path)
{
    DIR *dir = opendir(path);
    if (!dir)
        return lccal_fail(LCCAL_FAILED, "cannot read the folder '%s'", path);
    int status = LCCAL_OK;
    for (struct dirent *d = readdir(dir); d && status == LCCAL_OK; d = readdir(dir)) {
        char file[4096];
        const int n = snprintf(file, sizeof file, "%s/%s", path, d->d_name);
        const bool ours =
            lccal_ends_with(d->d_name, ".cgats") || lccal_ends_with(d->d_name, ".cgats~");
        if (ours && n > 0 && (size_t)n < sizeof file)
            status = add_profile(h, file);
    }
    closedir(dir);
    return status;
}

static int add_operand(history *h, const char *path)
{
    struct stat info;
    char backup[4096];
    if (stat(path, &info) == 0 && S_ISDIR(info.st_mode))
        return add_folder(h, path);
    const int status = add_profile(h, path);
    const int n = snprintf(backup, sizeof backup, "%s~", path);
    if (status == LCCAL_OK && n > 0 && (size_t)n < sizeof backup && stat(backup, &info) == 0)
        return add_profile(h, backup);
    return status;
}

static int by_date(const void *a, const void *b)
{
    const entry *const x = a, *const y = b;
    if (x->created != y->created)
        return x->created < y->created ? -1 : 1;
    return strcmp(x->path, y->path);
}

static void tell(const entry *e, const entry *first, json *list)
{
    const double change = 100.0 * (e->result.contrast / first->result.contrast - 1.0);
    const double u = hypot(e->result.contrast_u95, first->result.contrast_u95);
    const bool known = e->result.contrast_u95 > 0.0 && first->result.contrast_u95 > 0.0;
    const bool drifted = known && fabs(e->result.contrast - first->result.contrast) > u;
    json_open(list, NULL, '{');
    json_text(list, "path", e->path);
    json_text(list, "created", e->date);
    json_number(list, "contrast", e->result.contrast, 4);
    json_number(list, "contrast_u95", e->result.contrast_u95, 4);
    json_number(list, e->display ? "j_max" : "d_min", e->white, 4);
    json_number(list, e->display ? "j_min" : "d_max", e->black, 4);
    json_number(list, "change_percent", change, 2);
    json_bool(list, "significant", drifted);
    json_close(list, '}');
    if (lccal_json())
        return;
    char c[80], white[32], black[32], percent[32];
    lccal_format_number(white, sizeof white, e->white, 3);
    lccal_format_number(black, sizeof black, e->black, 3);
    lccal_format_number(percent, sizeof percent, change, 1);
    printf("%-20s  %-17s  %6s  %6s  %6s %%%s  %s\n", e->date,
           profile_contrast_text(&e->result, c, sizeof c), white, black, percent,
           drifted ? " *" : "  ", e->path);
}

int cmd_history(int argc, char **argv)
{
    history h = {0};
    int status = lccal_parse_options(&argc, argv, NULL, 0, help);
    if (status != LCCAL_OK)
        return status < 0 ? LCCAL_OK : status;
    if (argc < 2)
        return lccal_fail(LCCAL_USAGE,
                          "history wants profiles or a folder of them; --help explains");
    for (int i = 1; i < argc && status == LCCAL_OK; i++)
        status = add_operand(&h, argv[i]);
    if (status == LCCAL_OK && !h.entries)
        status = lccal_fail(LCCAL_FAILED, "no profile (*.cgats) found there");
    if (status == LCCAL_OK && h.entries) {
        qsort(h.entries, h.count, sizeof *h.entries, by_date);
        if (!lccal_json())
            printf("%-20s  %-17s  %6s  %6s  %8s\n", "created", "contrast", "white", "black",
                   "change");
        json event = lccal_event("history");
        json_open(&event, "profiles", '[');
        for (size_t i = 0; i < h.count; i++)
            tell(&h.entries[i], &h.entries[0], &event);
        json_close(&event, ']');
        lccal_event_end(&event);
    }
    for (size_t i = 0; h.entries && i < h.count; i++)
        free(h.entries[i].path);
    free(h.entries);
    return status;
}
