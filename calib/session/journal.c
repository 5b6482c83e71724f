/* SPDX-License-Identifier: MIT */
#define _POSIX_C_SOURCE 200809L
#include "session/journal.h"
#include "lccal.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { FIELDS = 12, DIGITS = 9 };

static void set_aside(const char *path)
{
    char *old = malloc(strlen(path) + 2);
    if (!old)
        return;
    sprintf(old, "%s~", path);
    if (rename(path, old) == 0)
        lccal_say("An unfinished measurement was set aside as '%s'; --resume would have taken it "
                  "up.",
                  old);
    free(old);
}

static int load(journal *j, const char *header)
{
    const int result = lccal_load_file(j->path, LCCAL_FAILED, &j->text, &j->size);
    if (result != LCCAL_OK)
        return result;
    const size_t n = strlen(header);
    if (j->size < n || memcmp(j->text, header, n) != 0)
        return lccal_fail(LCCAL_USAGE,
                          "'%s' is no journal of this instrument with these --readings, "
                          "--positions and --ramp; repeat them, or start anew without --resume",
                          j->path);
    j->at = n;
    /* A line that was being written when the power went is no entry. */
    while (j->size > 0 && j->text[j->size - 1] != '\n')
        j->size--;
    return LCCAL_OK;
}

static int fail_open(const char *path)
{
    const bool denied = errno == EACCES || errno == EPERM || errno == EROFS;
    return lccal_fail(denied ? LCCAL_PERMISSION : LCCAL_FAILED,
                      "cannot write '%s': %s; choose another place for the profile with -o", path,
                      strerror(errno));
}

int journal_open(journal *j, const char *path, const char *header, bool resume)
{
    memset(j, 0, sizeof *j);
    if (!path)
        return LCCAL_OK;
    j->path = strdup(path);
    if (!j->path)
        return lccal_fail(LCCAL_FAILED, "out of memory");
    const bool exists = access(path, F_OK) == 0;
    if (resume && !exists)
        return lccal_fail(LCCAL_USAGE, "there is no journal '%s' to resume; start without --resume",
                          path);
    if (resume) {
        const int result = load(j, header);
        if (result != LCCAL_OK)
            return result;
        /* Cut off a half-written line, then go on behind it. */
        if (truncate(path, (off_t)j->size) != 0)
            return fail_open(path);
    } else if (exists) {
        set_aside(path);
    }
    j->file = fopen(path, resume ? "a" : "w");
    if (!j->file)
        return fail_open(path);
    if (!resume && (fputs(header, j->file) < 0 || fflush(j->file) != 0))
        return fail_open(path);
    return LCCAL_OK;
}

bool journal_peek(const journal *j, char entry)
{
    return j->text && j->at < j->size && (entry == 0 || j->text[j->at] == entry);
}

/* The numbers of an R line. */
static bool parse_entry(const char *line, size_t n, double fields[FIELDS])
{
    size_t at = 1;
    for (int i = 0; i < FIELDS; i++) {
        if (at >= n || line[at] != ' ')
            return false;
        const size_t start = ++at;
        while (at < n && line[at] != ' ')
            at++;
        if (!lccal_parse_number(line + start, at - start, &fields[i]))
            return false;
    }
    return at == n && fields[0] >= 0.0 && fields[0] <= (double)READING_LUMINANCE;
}

char journal_next(journal *j, reading *out)
{
    while (journal_peek(j, 0)) {
        const char *line = j->text + j->at;
        const char *end = memchr(line, '\n', j->size - j->at);
        const size_t n = (size_t)(end - line);
        double f[FIELDS];
        j->at += n + 1;
        if (n == 1 && line[0] == 'U') {
            j->entries++;
            return 'U';
        }
        if (n == 0 || line[0] != 'R' || !parse_entry(line, n, f)) {
            lccal_warn("'%s' holds a line that is no reading; it is left out", j->path);
            continue;
        }
        memset(out, 0, sizeof *out);
        out->kind = (reading_kind)f[0];
        out->value = f[1];
        out->step = f[2];
        out->clamped = f[3] != 0.0;
        out->has_colour = f[4] != 0.0;
        out->has_xyz = f[5] != 0.0;
        memcpy(out->density, f + 6, sizeof out->density);
        memcpy(out->xyz, f + 9, sizeof out->xyz);
        j->entries++;
        return 'R';
    }
    return 0;
}

static void flush(journal *j, bool written)
{
    j->entries++;
    if (written && fflush(j->file) == 0 && fsync(fileno(j->file)) == 0)
        return;
    if (!j->failed)
        lccal_warn("cannot write the journal '%s': %s; this measurement cannot be resumed", j->path,
                   strerror(errno));
    j->failed = true;
}

void journal_reading(journal *j, const reading *r)
{
    const double f[FIELDS] = {(double)r->kind, r->value,   r->step,       r->clamped,
                              r->has_colour,   r->has_xyz, r->density[0], r->density[1],
                              r->density[2],   r->xyz[0],  r->xyz[1],     r->xyz[2]};
    if (!j->file)
        return;
    bool good = fputc('R', j->file) != EOF;
    for (int i = 0; i < FIELDS; i++) {
        char text[48];
        good = good &&
               fprintf(j->file, " %s", lccal_format_number(text, sizeof text, f[i], DIGITS)) > 0;
    }
    flush(j, good && fputc('\n', j->file) != EOF);
}

void journal_undo(journal *j)
{
    if (j->file)
        flush(j, fputs("U\n", j->file) >= 0);
}

void journal_close(journal *j, bool keep)
{
    if (j->file) {
        fclose(j->file);
        if (!keep || j->entries == 0)
            unlink(j->path);
    }
    free(j->path);
    free(j->text);
    memset(j, 0, sizeof *j);
}
