/* SPDX-License-Identifier: MIT */
/* The course of a measurement: which patch when, and what follows from them. */
#define _POSIX_C_SOURCE 200809L
#include "session/judge.h"
#include "session/prompt.h"
#include "session/session.h"
#include "transport/interrupt.h"

#include <stdio.h>
#include <string.h>

enum { AGAIN = -1, REFINE_ROUNDS = 4 };

/* "white, the bare paper: lower the head ..., 5 times." */
static void question(const session *s, const patch *p, char *text, size_t capacity)
{
    const bool displays = s->in.driver->displays;
    const int times = s->options->positions > 1 ? s->options->positions : s->options->readings;
    const char *what = "";
    if (p->level >= 255.0)
        what = displays ? ", a white screen" : ", the bare paper";
    else if (p->level <= 0.0)
        what = displays ? ", a black screen" : ", the darkest print";
    snprintf(text, capacity, "%s%s: %s, %d time%s.", p->name, what, s->in.driver->how, times,
             times == 1 ? "" : "s");
}

int session_ask(session *s, const patch *p)
{
    char text[384];
    if (journal_peek(&s->log, 'R'))
        return LCCAL_OK;
    if (journal_peek(&s->log, 'U')) {
        reading unused;
        (void)journal_next(&s->log, &unused);
        return AGAIN;
    }
    question(s, p, text, sizeof text);
    if (s->options->yes) {
        lccal_say("%s", text);
        return LCCAL_OK;
    }
    const size_t n = strlen(text);
    snprintf(text + n, sizeof text - n, " [Enter: start, r: the patch before again, q: quit]");
    switch (prompt_wait(p->name, text)) {
    case ANSWER_GO: break;
    case ANSWER_REDO: journal_undo(&s->log); return AGAIN;
    case ANSWER_QUIT: return lccal_fail(LCCAL_INTERRUPTED, "interrupted; no profile was written");
    case ANSWER_CLOSED:
        return lccal_fail(LCCAL_USAGE, "nobody answers the prompt; without a keyboard use --yes");
    }
    /* A reading taken before the prompt must not be taken for this patch. */
    const cal_status status = s->in.driver->discard(&s->in);
    cal_error err;
    if (status != CAL_OK) {
        instrument_fail(&s->in, status, &err);
        return session_fail(&err);
    }
    json event = lccal_event("ready"); /* readings are taken from now on */
    json_text(&event, "patch", p->name);
    lccal_event_end(&event);
    return LCCAL_OK;
}

int session_sort(session *s)
{
    const double white = session_patch_density(s, &s->patches[WHITE]);
    const double black = session_patch_density(s, &s->patches[BLACK]);
    if (judge_pair(white, black) == VERDICT_EQUAL)
        return session_reject(s, "white and black read the same; measure the bare paper and the "
                                 "darkest patch of the print");
    if (white < black)
        return LCCAL_OK;
    lccal_say("The first patch was the black one; both are taken for what they are.");
    return session_exchange(s);
}

int session_check_step(session *s, size_t i)
{
    const size_t lighter = i > FIRST_STEP ? i - 1 : WHITE;
    const double before = session_patch_density(s, &s->patches[lighter]);
    const double here = session_patch_density(s, &s->patches[i]);
    const double black = session_patch_density(s, &s->patches[BLACK]);
    if (here > before && here < black)
        return LCCAL_OK;
    return session_reject(s,
                          "%s does not lie between '%s' and black; read the steps from light to "
                          "dark",
                          s->patches[i].name, s->patches[lighter].name);
}

int session_refine(session *s)
{
    patch extra[2] = {s->patches[WHITE], s->patches[BLACK]};
    for (int round = 0; s->options->precision > 0.0; round++) {
        lcor_profile_result r;
        lcor_error err;
        if (lcor_profile_evaluate(s->profile, &r, &err) != LCOR_OK)
            return lccal_fail(LCCAL_REJECTED, "%s", err.text);
        char text[32];
        const double percent = 100.0 * r.contrast_u95 / r.contrast;
        lccal_format_number(text, sizeof text, percent, 2);
        if (percent <= s->options->precision)
            return LCCAL_OK;
        if (round == REFINE_ROUNDS) {
            lccal_warn("the contrast is known to %s %% only; the profile is stored all the same",
                       text);
            return LCCAL_OK;
        }
        lccal_say("The contrast is known to %s %% so far; more readings.", text);
        patch *p = &extra[r.u_max > r.u_min ? BLACK : WHITE];
        const int result = session_ask(s, p);
        if (result != LCCAL_OK && result != AGAIN)
            return result;
        const int taken = session_patch(s, p);
        if (taken == LCCAL_REJECTED && !s->options->yes)
            continue;
        if (taken != LCCAL_OK)
            return taken;
    }
    return LCCAL_OK;
}

/* What to do with the i-th patch once it is measured. */
static int follow_up(session *s, size_t i)
{
    if (i == BLACK)
        return session_sort(s);
    return i >= FIRST_STEP ? session_check_step(s, i) : LCCAL_OK;
}

/* The patch that is measured as the i-th. */
static patch *patch_at(session *s, size_t i)
{
    return &s->patches[i < FIRST_STEP && s->black_first ? 1 - i : i];
}

/* Strike out what was measured of the patch that is next. */
static void start_over(session *s)
{
    session_strike(s, patch_at(s, s->at));
    if (s->at == 0)
        s->black_first = false;
}

static int run(session *s)
{
    while (s->at < s->patch_count) {
        const int asked = session_ask(s, patch_at(s, s->at));
        if (asked == AGAIN) {
            s->at -= s->at > 0;
            start_over(s);
            continue;
        }
        if (asked != LCCAL_OK)
            return asked;
        int result = session_patch(s, patch_at(s, s->at));
        if (result == LCCAL_OK)
            result = follow_up(s, s->at);
        if (result == LCCAL_REJECTED && !s->options->yes) {
            start_over(s);
            continue;
        }
        if (result != LCCAL_OK)
            return result;
        s->at++;
    }
    return session_refine(s);
}

static void plan_patches(session *s)
{
    const int steps = s->options->ramp;
    s->patches[WHITE] = (patch){.name = "white", .level = 255.0};
    s->patches[BLACK] = (patch){.name = "black", .level = 0.0};
    s->patch_count = FIRST_STEP;
    for (int k = steps; k >= 1; k--) {
        patch *p = &s->patches[s->patch_count++];
        *p = (patch){.level = (double)(int)(255.0 * k / (steps + 1) + 0.5)};
        snprintf(p->name, sizeof p->name, "grey %d", (int)p->level);
    }
}

static int provenance(session *s)
{
    char text[256], now[32];
    const char *source = "reflection density, visual";
    switch (s->kind) {
    case READING_REFLECTION: break;
    case READING_TRANSMISSION: source = "transmission density, visual"; break;
    case READING_LUMINANCE: source = "luminance, cd/m2"; break;
    }
    session_describe(&s->in, text, sizeof text);
    lcor_error err;
    if (lcor_profile_keyword_set(s->profile, "INSTRUMENTATION", text, &err) != LCOR_OK ||
        lcor_profile_keyword_set(s->profile, "CREATED", lccal_now(now, sizeof now), &err) !=
            LCOR_OK ||
        lcor_profile_keyword_set(s->profile, "MEASUREMENT_SOURCE", source, &err) != LCOR_OK ||
        lcor_profile_resolution_set(s->profile, s->step, &err) != LCOR_OK)
        return lccal_fail(LCCAL_FAILED, "%s", err.text);
    return LCCAL_OK;
}

static int start_journal(session *s)
{
    char header[256];
    snprintf(header, sizeof header, "lccal journal 1 %s %s readings=%d positions=%d ramp=%d\n",
             s->in.driver->name, instrument_fact_get(&s->in, "serial"), s->options->readings,
             s->options->positions, s->options->ramp);
    return journal_open(&s->log, s->options->journal, header, s->options->resume);
}

int lccal_measure(const lccal_measure_options *options, lcor_profile **out)
{
    session s;
    lcor_error err;
    interrupt_install();
    int result = session_open(&s, options);
    if (result != LCCAL_OK)
        return result;
    if (lcor_profile_new(NULL, &s.profile, &err) != LCOR_OK)
        result = lccal_fail(LCCAL_FAILED, "%s", err.text);
    if (result == LCCAL_OK)
        result = start_journal(&s);
    if (result == LCCAL_OK) {
        plan_patches(&s);
        result = run(&s);
    }
    if (result == LCCAL_OK)
        result = provenance(&s);
    instrument_close(&s.in);
    /* Readings that were rejected as a whole would be rejected again. */
    const bool keep = result != LCCAL_REJECTED;
    if (result != LCCAL_OK && keep && s.log.entries > 0)
        lccal_say("The readings so far are in '%s'; the same command with --resume goes on.",
                  s.log.path);
    journal_close(&s.log, keep);
    if (result == LCCAL_OK)
        *out = s.profile;
    else
        lcor_profile_free(s.profile);
    return result;
}
