/* SPDX-License-Identifier: MIT */
#define _POSIX_C_SOURCE 200809L
#include "session/judge.h"
#include "session/prompt.h"
#include "session/session.h"
#include "transport/interrupt.h"

#include <stdio.h>
#include <string.h>
#include <time.h>

int session_fail(const cal_error *err)
{
    int code = LCCAL_PROTOCOL;
    switch (err->status) {
    case CAL_OK:
    case CAL_TIMEOUT:
    case CAL_GONE:
    case CAL_PROTOCOL:
    case CAL_UNSUPPORTED:
    case CAL_MISREAD:
    case CAL_CALIBRATE: break;
    case CAL_IO:
    case CAL_NO_MEMORY: code = LCCAL_FAILED; break;
    case CAL_NO_DEVICE: code = LCCAL_NO_INSTRUMENT; break;
    case CAL_PERMISSION:
    case CAL_BUSY: code = LCCAL_PERMISSION; break;
    case CAL_INTERRUPTED: code = LCCAL_INTERRUPTED; break;
    }
    return lccal_fail(code, "%s", err->text);
}

/* "Dektronics Printalyzer Densitometer, serial 0123, firmware v1.1.0" */
static void describe(const instrument *in, char *text, size_t capacity)
{
    const char *model = instrument_fact_get(in, "model");
    const char *serial = instrument_fact_get(in, "serial");
    const char *firmware = instrument_fact_get(in, "firmware");
    snprintf(text, capacity, "%s%s%s%s%s%s%s", instrument_fact_get(in, "maker"),
             *instrument_fact_get(in, "maker") ? " " : "", *model ? model : in->driver->title,
             *serial ? ", serial " : "", serial, *firmware ? ", firmware " : "", firmware);
}

int session_open(session *s, const lccal_measure_options *options)
{
    memset(s, 0, sizeof *s);
    s->options = options;
    cal_error  err;
    transport *port;
    cal_status status = transport_open(options->port, &port, &err);
    if (status != CAL_OK)
        return session_fail(&err);
    status = instrument_open(options->instrument ? options->instrument : "auto", port,
                             (int)(options->timeout * 1000.0), &s->in, &err);
    if (status != CAL_OK) {
        instrument_close(&s->in);
        return session_fail(&err);
    }
    char text[256];
    describe(&s->in, text, sizeof text);
    lccal_say("%s on %s", text, options->port);
    lccal_event_begin("instrument");
    lccal_event_text("driver", s->in.driver->name);
    lccal_event_text("port", options->port);
    for (size_t i = 0; i < s->in.fact_count; i++)
        lccal_event_text(s->in.facts[i].key, s->in.facts[i].value);
    lccal_event_end();
    return LCCAL_OK;
}

static int prompt(session *s, const patch *p)
{
    char text[256];
    snprintf(text, sizeof text, "%s: %s, %d times.", p->name, s->in.driver->how,
             s->options->readings);
    if (s->options->yes) {
        lccal_say("%s", text);
        return LCCAL_OK;
    }
    strncat(text, " [Enter: start, q: quit]", sizeof text - strlen(text) - 1);
    switch (prompt_wait(p->name, text)) {
    case ANSWER_GO:
    case ANSWER_REDO: break;
    case ANSWER_QUIT: return lccal_fail(LCCAL_INTERRUPTED, "interrupted; nothing was saved");
    case ANSWER_CLOSED:
        return lccal_fail(LCCAL_USAGE, "nobody answers the prompt; without a keyboard use --yes");
    }
    /* A reading taken before the prompt must not be taken for this patch. */
    const cal_status status = s->in.driver->discard(&s->in);
    cal_error        err;
    if (status != CAL_OK) {
        instrument_fail(&s->in, status, &err);
        return session_fail(&err);
    }
    return LCCAL_OK;
}

static double patch_density(const session *s, const patch *p)
{
    double values[JUDGE_MAX];
    size_t n = 0;
    for (size_t i = p->first; i < p->first + p->count; i++) {
        lcor_profile_reading r;
        if (lcor_profile_reading_get(s->profile, i, &r, NULL) == LCOR_OK && !r.rejected)
            values[n++] = session_density(&r);
    }
    return judge_median(values, n);
}

/* White was asked for first; people read black first now and then. */
static int sort_out(session *s, patch *white, patch *black)
{
    const double first = patch_density(s, white), second = patch_density(s, black);
    if (judge_pair(first, second) == VERDICT_EQUAL)
        return lccal_fail(LCCAL_REJECTED, "white and black read the same; measure the bare paper "
                                          "and the darkest patch of the print");
    if (first < second)
        return LCCAL_OK;
    lccal_say("The first patch was the black one; taken as such.");
    lcor_profile *sorted;
    lcor_error    err;
    if (lcor_profile_new(NULL, &sorted, &err) != LCOR_OK)
        return lccal_fail(LCCAL_FAILED, "%s", err.text);
    for (size_t i = 0; i < lcor_profile_count(s->profile); i++) {
        lcor_profile_reading r;
        lcor_profile_reading_get(s->profile, i, &r, NULL);
        const patch *p = i < black->first ? black : white;
        r.name = p->name;
        r.id = NULL;
        r.rgb[0] = r.rgb[1] = r.rgb[2] = p->level;
        if (lcor_profile_reading_add(sorted, &r, &err) != LCOR_OK) {
            lcor_profile_free(sorted);
            return lccal_fail(LCCAL_FAILED, "%s", err.text);
        }
    }
    lcor_profile_free(s->profile);
    s->profile = sorted;
    return LCCAL_OK;
}

static int provenance(session *s)
{
    char            text[256], created[32];
    const char     *source = "reflection density, visual";
    const time_t    now = time(NULL);
    const struct tm utc = *gmtime(&now);
    switch (s->kind) {
    case READING_REFLECTION: break;
    case READING_TRANSMISSION: source = "transmission density, visual"; break;
    case READING_LUMINANCE: source = "luminance in cd/m2"; break;
    }
    describe(&s->in, text, sizeof text);
    strftime(created, sizeof created, "%Y-%m-%dT%H:%M:%SZ", &utc);
    lcor_error err;
    if (lcor_profile_keyword_set(s->profile, "INSTRUMENTATION", text, &err) != LCOR_OK ||
        lcor_profile_keyword_set(s->profile, "CREATED", created, &err) != LCOR_OK ||
        lcor_profile_keyword_set(s->profile, "MEASUREMENT_SOURCE", source, &err) != LCOR_OK ||
        lcor_profile_resolution_set(s->profile, s->step, &err) != LCOR_OK)
        return lccal_fail(LCCAL_FAILED, "%s", err.text);
    return LCCAL_OK;
}

static int run(session *s)
{
    patch     white = {.name = "white", .level = 255.0};
    patch     black = {.name = "black", .level = 0.0};
    lcor_error err;
    if (lcor_profile_new(NULL, &s->profile, &err) != LCOR_OK)
        return lccal_fail(LCCAL_FAILED, "%s", err.text);
    int result = prompt(s, &white);
    if (result == LCCAL_OK)
        result = session_patch(s, &white);
    if (result == LCCAL_OK)
        result = prompt(s, &black);
    if (result == LCCAL_OK)
        result = session_patch(s, &black);
    if (result == LCCAL_OK)
        result = sort_out(s, &white, &black);
    return result == LCCAL_OK ? provenance(s) : result;
}

int lccal_measure(const lccal_measure_options *options, lcor_profile **out)
{
    session s;
    interrupt_install();
    int result = session_open(&s, options);
    if (result != LCCAL_OK)
        return result;
    result = run(&s);
    instrument_close(&s.in);
    if (result == LCCAL_OK)
        *out = s.profile;
    else
        lcor_profile_free(s.profile);
    return result;
}
