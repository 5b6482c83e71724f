/* SPDX-License-Identifier: MIT */
/* `lccal enter`: densities read off an instrument's display, or measured by another program. */
#include "command/import_table.h"
#include "command/profile_file.h"
#include "session/judge.h"
#include "session/prompt.h"
#include "transport/interrupt.h"

#include <lcor/version.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char help[] =
    "lccal enter --dmin D[,D...] --dmax D[,D...] [-o FILE]   densities as arguments\n"
    "lccal enter [-o FILE]                                   densities asked for\n"
    "lccal enter --import MEASUREMENTS [--black k|darkest] [-o FILE]\n"
    "\n"
    "  --dmin LIST, --dmax LIST  readings of white and of black, separated by commas\n"
    "  --import FILE       readings of another program: .ti3, CGATS, i1Profiler text or CSV\n"
    "  --black k|darkest   black is R=G=B=0 or K 100 % [k], or the darkest patch there is\n"
    "  -o, --output FILE   the profile [profile.cgats]\n"
    "  --instrument TEXT, --source TEXT\n"
    "                      which instrument; status and geometry, such as \"ISO visual, 45/0\"\n"
    "  --material TEXT, --backing TEXT, --conditions TEXT\n"
    "                      paper, backing and print settings, kept in the profile\n"
    "  --json, --quiet, --help, --version\n";

enum { READINGS_MAX = 1000, PROBLEM = 160 };

typedef struct patch_entry {
    const char *name, *option;
    double level;
    double values[READINGS_MAX];
    size_t count;
    int decimals; /* the most given */
} patch_entry;

/* One density as a person writes it; its text may hold blanks around. Returns an exit code, and in
 * `problem` what is wrong with it. */
static int add_value(patch_entry *p, const char *text, size_t n, char problem[PROBLEM])
{
    double value;
    while (n > 0 && (*text == ' ' || *text == '\t')) {
        text++;
        n--;
    }
    while (n > 0 && (text[n - 1] == ' ' || text[n - 1] == '\t' || text[n - 1] == '\r'))
        n--;
    if (!lccal_parse_number(text, n, &value)) {
        snprintf(problem, PROBLEM, "%s: '%.*s' is no density; write it like 1.44, with a point",
                 p->name, (int)n, text);
        return LCCAL_USAGE;
    }
    if (!judge_plausible(value)) {
        snprintf(problem, PROBLEM, "%s: %.*s is no density of paper or film (-0.1 to 6)", p->name,
                 (int)n, text);
        return LCCAL_REJECTED;
    }
    if (p->count == READINGS_MAX) {
        snprintf(problem, PROBLEM, "%s: more than %d readings", p->name, READINGS_MAX);
        return LCCAL_USAGE;
    }
    const char *point = memchr(text, '.', n);
    const int decimals = point ? (int)(text + n - point - 1) : 0;
    p->decimals = decimals > p->decimals ? decimals : p->decimals;
    p->values[p->count++] = value;
    return LCCAL_OK;
}

static int add_list(patch_entry *p, const char *list)
{
    char problem[PROBLEM];
    for (const char *at = list;; at++) {
        const size_t n = strcspn(at, ",");
        const int result = add_value(p, at, n, problem);
        if (result != LCCAL_OK)
            return lccal_fail(result, "%s", problem);
        at += n;
        if (*at == '\0')
            return LCCAL_OK;
    }
}

/* Ask for readings until an empty line. A slip of the finger is told and asked for again. */
static int ask(patch_entry *p)
{
    for (;;) {
        char question[96], line[64], problem[PROBLEM];
        snprintf(question, sizeof question, "Density of %s, reading %zu [%sq: quit]:", p->name,
                 p->count + 1, p->count ? "Enter: no more, " : "");
        switch (prompt_line(p->name, question, line, sizeof line)) {
        case ANSWER_GO:
        case ANSWER_REDO: break;
        case ANSWER_QUIT: return lccal_fail(LCCAL_INTERRUPTED, "interrupted; nothing was saved");
        case ANSWER_CLOSED:
            return lccal_fail(LCCAL_USAGE, "nobody answers; give %s LIST instead", p->option);
        }
        if (line[0] == '\0' && p->count > 0)
            return LCCAL_OK;
        if (line[0] == 'q' || line[0] == 'Q')
            return lccal_fail(LCCAL_INTERRUPTED, "interrupted; nothing was saved");
        if (add_value(p, line, strlen(line), problem) != LCCAL_OK)
            lccal_warn("%s", problem);
    }
}

static int judge_entries(patch_entry *p, bool *accepted)
{
    switch (judge_patch(p->values, p->count, accepted)) {
    case VERDICT_GOOD: return LCCAL_OK;
    case VERDICT_MIXED:
    case VERDICT_DRIFTING:
    case VERDICT_TOO_FEW:
    case VERDICT_EQUAL: break;
    }
    return lccal_fail(LCCAL_REJECTED, "%s: the readings do not agree; measure the patch again",
                      p->name);
}

static int add_readings(lcor_profile *profile, patch_entry *p)
{
    bool accepted[READINGS_MAX];
    const int judged = judge_entries(p, accepted);
    if (judged != LCCAL_OK)
        return judged;
    for (size_t i = 0; i < p->count; i++) {
        lcor_error err;
        const lcor_profile_reading r = {.name = p->name,
                                        .has = LCOR_HAS_RGB | LCOR_HAS_VISUAL,
                                        .rejected = !accepted[i],
                                        .rgb = {p->level, p->level, p->level},
                                        .density = {0.0, 0.0, 0.0, p->values[i]}};
        if (!accepted[i])
            lccal_warn("%s: reading %zu does not agree with the others and is left out", p->name,
                       i + 1);
        if (lcor_profile_reading_add(profile, &r, &err) != LCOR_OK)
            return lccal_fail(LCCAL_FAILED, "%s", err.text);
    }
    return LCCAL_OK;
}

/* White is lighter than black by more than readings scatter. */
static int check_pair(const patch_entry *white, const patch_entry *black)
{
    const double d_min = judge_median(white->values, white->count);
    const double d_max = judge_median(black->values, black->count);
    if (judge_pair(d_min, d_max) == VERDICT_EQUAL)
        return lccal_fail(LCCAL_REJECTED, "white and black read the same; D_min is the bare paper, "
                                          "D_max the darkest patch");
    if (d_max < d_min)
        return lccal_fail(LCCAL_REJECTED, "D_max is below D_min; were white and black exchanged?");
    return LCCAL_OK;
}

static int enter_by_hand(const char *d_min, const char *d_max, lcor_profile **out)
{
    static patch_entry white, black; /* too large for a stack */
    white = (patch_entry){.name = "white", .option = "--dmin", .level = 255.0};
    black = (patch_entry){.name = "black", .option = "--dmax", .level = 0.0};
    lcor_error err;
    interrupt_install();
    int result = d_min ? add_list(&white, d_min) : ask(&white);
    if (result == LCCAL_OK)
        result = d_max ? add_list(&black, d_max) : ask(&black);
    if (result == LCCAL_OK)
        result = check_pair(&white, &black);
    if (result != LCCAL_OK)
        return result;
    if (lcor_profile_new(NULL, out, &err) != LCOR_OK)
        return lccal_fail(LCCAL_FAILED, "%s", err.text);
    double step = 1.0;
    for (int i = 0; i < white.decimals || i < black.decimals; i++)
        step /= 10.0;
    result = add_readings(*out, &white);
    if (result == LCCAL_OK)
        result = add_readings(*out, &black);
    if (result == LCCAL_OK && lcor_profile_resolution_set(*out, step, &err) != LCOR_OK)
        result = lccal_fail(LCCAL_FAILED, "%s", err.text);
    return result;
}

static const char *base_name(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

static int import(const char *path, lcor_profile_black black, lcor_profile **out)
{
    char *text;
    size_t size;
    lcor_error err;
    const int loaded = lccal_load_file(path, LCCAL_BAD_PROFILE, &text, &size);
    if (loaded != LCCAL_OK)
        return loaded;
    buffer cgats = {0};
    char problem[160] = "";
    lcor_status status = LCOR_ERR_FORMAT;
    if (import_is_cgats(text, size))
        status = lcor_profile_import(text, size, black, NULL, out, &err);
    else if (!import_table(text, size, &cgats, problem, sizeof problem))
        snprintf(err.text, sizeof err.text, "%s", problem);
    else
        status = lcor_profile_import(cgats.bytes, cgats.size, black, NULL, out, &err);
    buffer_free(&cgats);
    free(text);
    if (status != LCOR_OK)
        return profile_refuse(path, status, &err);
    return profile_describe(*out, "IMPORTED_FROM", base_name(path));
}

static int parse_black(const char *text, lcor_profile_black *black)
{
    if (!text || strcmp(text, "k") == 0)
        *black = LCOR_BLACK_FULL;
    else if (strcmp(text, "darkest") == 0)
        *black = LCOR_BLACK_DARKEST;
    else
        return lccal_fail(LCCAL_USAGE, "--black is k or darkest, not '%s'", text);
    return LCCAL_OK;
}

typedef struct enter_options {
    const char *d_min, *d_max, *import, *black, *output;
    const char *instrument, *source, *material, *backing, *conditions;
} enter_options;

static int describe(lcor_profile *profile, const enter_options *o)
{
    char now[32];
    const struct {
        const char *keyword, *value;
    } facts[] = {{"INSTRUMENTATION", o->instrument},
                 {"MEASUREMENT_SOURCE", o->source},
                 {"MATERIAL", o->material},
                 {"SAMPLE_BACKING", o->backing},
                 {"PRINT_CONDITIONS", o->conditions},
                 {"CREATED", o->import ? NULL : lccal_now(now, sizeof now)},
                 {"ORIGINATOR", o->import ? NULL : "lccal enter " LCOR_VERSION_STRING}};
    int result = LCCAL_OK;
    for (size_t i = 0; i < sizeof facts / sizeof facts[0] && result == LCCAL_OK; i++)
        result = profile_describe(profile, facts[i].keyword, facts[i].value);
    return result;
}

static int run(const enter_options *o)
{
    lcor_profile_black black = LCOR_BLACK_FULL;
    lcor_profile *profile = NULL;
    lcor_profile_result r;
    int result = parse_black(o->black, &black);
    if (result == LCCAL_OK)
        result = o->import ? import(o->import, black, &profile)
                           : enter_by_hand(o->d_min, o->d_max, &profile);
    if (result == LCCAL_OK)
        result = describe(profile, o);
    if (result == LCCAL_OK)
        result = profile_evaluate(profile, &r);
    if (result == LCCAL_OK)
        result = profile_save(profile, o->output);
    if (result == LCCAL_OK)
        profile_tell_result(profile, &r, o->output);
    lcor_profile_free(profile);
    return result;
}

int cmd_enter(int argc, char **argv)
{
    enter_options o = {.output = "profile.cgats"};
    const lccal_option options[] = {
        {"--dmin", NULL, LCCAL_TEXT, &o.d_min},
        {"--dmax", NULL, LCCAL_TEXT, &o.d_max},
        {"--import", NULL, LCCAL_TEXT, &o.import},
        {"--black", NULL, LCCAL_TEXT, &o.black},
        {"--output", "-o", LCCAL_TEXT, &o.output},
        {"--instrument", NULL, LCCAL_TEXT, &o.instrument},
        {"--source", NULL, LCCAL_TEXT, &o.source},
        {"--material", NULL, LCCAL_TEXT, &o.material},
        {"--backing", NULL, LCCAL_TEXT, &o.backing},
        {"--conditions", NULL, LCCAL_TEXT, &o.conditions},
    };
    const int parsed =
        lccal_parse_options(&argc, argv, options, sizeof options / sizeof options[0], help);
    if (parsed != LCCAL_OK)
        return parsed < 0 ? LCCAL_OK : parsed;
    if (argc > 1)
        return lccal_fail(LCCAL_USAGE, "'%s' is one argument too many; --import FILE reads a file",
                          argv[1]);
    if (o.import && (o.d_min || o.d_max))
        return lccal_fail(LCCAL_USAGE, "--import and --dmin/--dmax exclude each other");
    if (o.black && !o.import)
        return lccal_fail(LCCAL_USAGE, "--black goes with --import");
    return run(&o);
}
