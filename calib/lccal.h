/* SPDX-License-Identifier: MIT */
/* What every subcommand of lccal shares: exit codes, options, messages, files. */
#ifndef LCCAL_H
#define LCCAL_H

#include "json.h"
#include "number.h"

#include <lcor/profile.h>

#include <stdbool.h>
#include <stddef.h>

/* The program's exit codes; also what the calls below return when they have told the user. */
typedef enum lccal_exit {
    LCCAL_OK = 0,
    LCCAL_FAILED = 1,        /* the system refused: disk full, no memory, unreadable file */
    LCCAL_USAGE = 2,         /* command line */
    LCCAL_NO_INSTRUMENT = 3, /* no such port, or nothing known is plugged in */
    LCCAL_PERMISSION = 4,    /* port or file may not be opened, or another program has it */
    LCCAL_PROTOCOL = 5,      /* the instrument was silent, vanished or spoke nonsense */
    LCCAL_REJECTED = 6,      /* readings are equal, mixed or implausible */
    LCCAL_BAD_PROFILE = 7,
    LCCAL_VERIFY_FAILED = 8,
    LCCAL_INTERRUPTED = 130
} lccal_exit;

/* ---- subcommands: argv[0] is the subcommand's name; each returns an exit code ---- */

int cmd_measure(int argc, char **argv); /* `lccal --port ...`, no subcommand */
int cmd_list(int argc, char **argv);
int cmd_doctor(int argc, char **argv);
int cmd_device(int argc, char **argv);
int cmd_enter(int argc, char **argv);
int cmd_show(int argc, char **argv);
int cmd_verify(int argc, char **argv);
int cmd_history(int argc, char **argv);
int cmd_export(int argc, char **argv);
int cmd_target(int argc, char **argv);

/* ---- options ---- */

typedef enum lccal_option_kind {
    LCCAL_FLAG,   /* out: bool * */
    LCCAL_TEXT,   /* out: const char ** */
    LCCAL_NUMBER, /* out: double * */
    LCCAL_COUNT   /* out: int *, 1..1000000 */
} lccal_option_kind;

typedef struct lccal_option {
    const char *name;  /* "--readings" */
    const char *alias; /* "-n", or NULL */
    lccal_option_kind kind;
    void *out;
} lccal_option;

/* Read `--name value`, `--name=value` and `-x value` in any order; what is left over (operands) is
 * moved to argv[1..] and *argc becomes their number + 1. `--json`, `--quiet`, `--help` and
 * `--version` are understood everywhere and need no entry.
 *
 * Returns LCCAL_OK, LCCAL_USAGE after telling the user what is wrong, or -1 after --help or
 * --version was answered on stdout (the command then returns 0). `help` is the text of --help. */
int lccal_parse_options(int *argc, char **argv, const lccal_option *options, size_t count,
                        const char *help);

/* ---- messages: people read stderr, programs read stdout ---- */

#if defined(__GNUC__)
#define LCCAL_PRINTF(a, b) __attribute__((format(printf, a, b)))
#else
#define LCCAL_PRINTF(a, b)
#endif

bool lccal_json(void);  /* --json was given */
bool lccal_quiet(void); /* --quiet was given */

/* "lccal: ..." on stderr, and an event {"event":"error","code":N,"text":"..."} with --json.
 * Says what, where and what to do next, in one line. Returns code. */
int lccal_fail(int code, const char *format, ...) LCCAL_PRINTF(2, 3);
/* The same, but the event is the caller's, which is completed with code and text and ended. */
int lccal_fail_as(json *event, int code, const char *format, ...) LCCAL_PRINTF(3, 4);
void lccal_warn(const char *format, ...) LCCAL_PRINTF(1, 2); /* "lccal: warning: ..." */
void lccal_say(const char *format, ...) LCCAL_PRINTF(1, 2);  /* silenced by --quiet */

/* {"event":"name" of an object that the caller goes on with; the end writes it to stdout as one
 * line, or drops it without --json. One that is not to be sent, or was already, may be dropped. */
json lccal_event(const char *name);
void lccal_event_end(json *event);
void lccal_event_drop(json *event);

/* ---- text ---- */

/* UTC as profiles have it, 2026-11-22T03:04:05Z. Returns text. */
const char *lccal_now(char *text, size_t capacity);
/* Is `end` the end of text, and not all of it? */
bool lccal_ends_with(const char *text, const char *end);

/* ---- files ---- */

/* Put `size` bytes at `path` so that a crash at any moment leaves either the whole old file or the
 * whole new one: temporary file beside it, fsync, rename, fsync of the folder. A file already there
 * keeps its rights, and its content as `path~` when `backup` is set; what a link leads to is
 * replaced, not the link, and devices are written to. Failure is told to the user; returns an exit
 * code. */
int lccal_save_file(const char *path, const void *bytes, size_t size, bool backup);

/* Refuses what lccal_save_file() would, as far as that can be told before the work. */
int lccal_check_target(const char *path);

/* The whole file at `path` (at most 64 MiB), NUL-terminated, from malloc. Failure is told to the
 * user; returns an exit code: `missing` for a file that is not there or is none. */
int lccal_load_file(const char *path, int missing, char **bytes, size_t *size);

/* ---- measuring ---- */

typedef struct lccal_measure_options {
    const char *port;       /* never NULL; lccal_find_port finds one */
    const char *instrument; /* NULL: auto */
    const char *record;     /* NULL, or where to write the dialogue with the instrument */
    const char *journal;    /* NULL: none */
    int readings;           /* per patch */
    int positions;          /* 1, or 9 for evenness */
    int ramp;               /* grey steps between white and black, 0: none */
    double timeout;         /* seconds for one reading */
    double precision;       /* percent of c at which a patch has enough readings; 0: never */
    bool yes;               /* take readings as they come */
    bool resume;            /* take up the journal */
} lccal_measure_options;

/* Where the options name no port: that of the only known instrument that is plugged in and usable,
 * kept in `port`, and its driver. Failure is told to the user; returns an exit code. */
int lccal_find_port(lccal_measure_options *options, char *port, size_t capacity);

/* Guide the user through the patches and return the readings as a profile (free it). The journal is
 * left for the caller to remove once the profile is stored. Failure is told to the user; returns an
 * exit code. */
int lccal_measure(const lccal_measure_options *options, lcor_profile **out);

#endif
