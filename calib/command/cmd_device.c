/* SPDX-License-Identifier: MIT */
/* What an instrument tells of itself, kept in a file and compared with it: has it been calibrated
 * since, is it the same one, has its firmware changed. */
#define _POSIX_C_SOURCE 200809L
#include "lccal.h"
#include "session/prompt.h"
#include "session/session.h"
#include "transport/interrupt.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const char help[] =
    "lccal device [--port PORT] [--instrument NAME] [--save FILE] [--compare FILE]\n"
    "\n"
    "Prints identity, firmware, temperature and calibration of the instrument.\n"
    "\n"
    "  --save FILE      keep them, with the date since when the calibration is as it is\n"
    "  --compare FILE   what changed since they were saved; exit code 8 if anything did\n"
    "  --recalibrate    guide through the instrument's own calibration; needs --save, which gets\n"
    "                   the old values first\n"
    "  --timeout S      longest wait for an answer, seconds [2]\n";

static const char since_key[] = "calibration_unchanged_since";

/* Changes by itself. */
static bool is_volatile(const char *key)
{
    return strcmp(key, "temperature") == 0 || strcmp(key, "format") == 0;
}

static bool is_calibration(const char *key) { return strncmp(key, "calibration", 11) == 0; }

/* The value after "key: " in a saved file; its length in *n. */
static const char *saved_value(const char *text, const char *key, size_t *n)
{
    const size_t length = strlen(key);
    for (const char *line = text; line && *line;) {
        if (strncmp(line, key, length) == 0 && strncmp(line + length, ": ", 2) == 0) {
            *n = strcspn(line + length + 2, "\r\n");
            return line + length + 2;
        }
        line = strchr(line, '\n');
        line = line ? line + 1 : NULL;
    }
    return NULL;
}

static bool is_as_saved(const instrument_fact *fact, const char *text)
{
    size_t n;
    const char *value = saved_value(text, fact->key, &n);
    return value && strlen(fact->value) == n && memcmp(fact->value, value, n) == 0;
}

/* Since when the calibration is what it is: the saved date while nothing changed, else today. */
static void calibration_since(const instrument *in, const char *text, char since[24])
{
    size_t n;
    lccal_now(since, 24);
    since[10] = '\0'; /* the date alone */
    const char *saved = text ? saved_value(text, since_key, &n) : NULL;
    if (!saved || n >= 24)
        return;
    for (size_t i = 0; i < in->fact_count; i++)
        if (is_calibration(in->facts[i].key) && !is_as_saved(&in->facts[i], text))
            return;
    memcpy(since, saved, n);
    since[n] = '\0';
}

static int save(const instrument *in, const char *path)
{
    char since[24], text[INSTRUMENT_FACTS * 128];
    char *old = NULL;
    size_t size;
    if (access(path, F_OK) == 0 && lccal_load_file(path, LCCAL_FAILED, &old, &size) != LCCAL_OK)
        return LCCAL_FAILED;
    calibration_since(in, old, since);
    free(old);
    size_t n = 0;
    for (size_t i = 0; i < in->fact_count; i++)
        n += (size_t)snprintf(text + n, sizeof text - n, "%s: %s\n", in->facts[i].key,
                              in->facts[i].value);
    n += (size_t)snprintf(text + n, sizeof text - n, "%s: %s\n", since_key, since);
    return lccal_save_file(path, text, n, true);
}

/* Tell what is not as saved. */
static int compare(const instrument *in, const char *path)
{
    char *text;
    size_t size, changes = 0;
    const int loaded = lccal_load_file(path, LCCAL_FAILED, &text, &size);
    if (loaded != LCCAL_OK)
        return loaded;
    for (size_t i = 0; i < in->fact_count; i++) {
        const instrument_fact *fact = &in->facts[i];
        if (is_volatile(fact->key) || is_as_saved(fact, text))
            continue;
        size_t n = 0;
        const char *was = saved_value(text, fact->key, &n);
        lccal_warn("%s is '%s' and was '%.*s'", fact->key, fact->value, (int)n, was ? was : "");
        changes++;
    }
    free(text);
    if (changes == 0)
        return LCCAL_OK;
    return lccal_fail(LCCAL_VERIFY_FAILED, "the instrument is not as it was in '%s'; changes: %zu",
                      path, changes);
}

static void print_facts(const instrument *in)
{
    if (lccal_json())
        return; /* session_open told them as an event */
    for (size_t i = 0; i < in->fact_count; i++)
        printf("%s: %s\n", in->facts[i].key, in->facts[i].value);
}

static int recalibrate(session *s, const char *path)
{
    if (!s->in.driver->recalibrate)
        return lccal_fail(LCCAL_USAGE, "%s cannot be calibrated by its user", s->in.driver->title);
    int result = save(&s->in, path);
    if (result != LCCAL_OK)
        return result;
    lccal_say("The present calibration is kept in '%s'.\nNow %s.", path, s->in.driver->recalibrate);
    if (prompt_wait("calibrate", "[Enter: done, q: quit]") != ANSWER_GO)
        return lccal_fail(LCCAL_INTERRUPTED, "interrupted; '%s' holds the calibration as it was",
                          path);
    cal_error err;
    const cal_status status =
        s->in.driver->identify(&s->in, (int)(s->options->timeout * 1000.0), &err);
    if (status != CAL_OK)
        return session_fail(&err);
    result = compare(&s->in, path);
    if (result == LCCAL_OK)
        return lccal_fail(LCCAL_VERIFY_FAILED, "the calibration is the same as before");
    return result == LCCAL_VERIFY_FAILED ? save(&s->in, path) : result;
}

int cmd_device(int argc, char **argv)
{
    lccal_measure_options o = {.readings = 1, .positions = 1, .timeout = 2.0};
    const char *save_path = NULL, *compare_path = NULL;
    bool calibrate = false;
    const lccal_option options[] = {
        {"--port", NULL, LCCAL_TEXT, &o.port},
        {"--instrument", NULL, LCCAL_TEXT, &o.instrument},
        {"--save", NULL, LCCAL_TEXT, &save_path},
        {"--compare", NULL, LCCAL_TEXT, &compare_path},
        {"--recalibrate", NULL, LCCAL_FLAG, &calibrate},
        {"--timeout", NULL, LCCAL_NUMBER, &o.timeout},
    };
    int result =
        lccal_parse_options(&argc, argv, options, sizeof options / sizeof options[0], help);
    if (result != LCCAL_OK)
        return result < 0 ? LCCAL_OK : result;
    if (argc > 1 || (calibrate && !save_path) || !(o.timeout > 0.0 && o.timeout <= 86400.0))
        return lccal_fail(LCCAL_USAGE,
                          argc > 1    ? "device takes no operand; --help lists its options"
                          : calibrate ? "--recalibrate needs --save FILE for the old values"
                                      : "--timeout wants seconds, more than 0");
    char found[128];
    result = lccal_find_port(&o, found, sizeof found);
    if (result != LCCAL_OK)
        return result;
    session s;
    interrupt_install();
    result = session_open(&s, &o);
    if (result != LCCAL_OK)
        return result;
    print_facts(&s.in);
    if (compare_path)
        result = compare(&s.in, compare_path);
    if (result == LCCAL_OK && calibrate)
        result = recalibrate(&s, save_path);
    else if (result == LCCAL_OK && save_path)
        result = save(&s.in, save_path);
    instrument_close(&s.in);
    return result;
}
