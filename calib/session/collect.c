/* SPDX-License-Identifier: MIT */
/* Readings into the profile, one patch at a time. */
#include "session/judge.h"
#include "session/prompt.h"
#include "session/session.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

/* Film base and the darkest papers stay below this, blacks worth the name above. */
#define D_SURELY_BLACK 0.7

int session_reject(const session *s, const char *format, ...)
{
    char text[512];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    if (s->options->yes)
        return lccal_fail(LCCAL_REJECTED, "%s", text);
    lccal_warn("%s", text);
    return LCCAL_REJECTED;
}

/* Displays are judged by their luminance as a density, where only differences mean something. */
static double density_of(const lcor_profile_reading *r)
{
    return r->has & LCOR_HAS_VISUAL ? r->density[3] : -log10(r->xyz[1] / 100.0);
}

double session_patch_density(const session *s, const patch *p)
{
    double values[JUDGE_MAX];
    size_t n = 0;
    for (size_t i = p->first; i < p->first + p->count; i++) {
        lcor_profile_reading r;
        if (lcor_profile_reading_get(s->profile, i, &r, NULL) == LCOR_OK && !r.rejected)
            values[n++] = density_of(&r);
    }
    return judge_median(values, n);
}

void session_strike(session *s, const patch *p)
{
    for (size_t i = p->first; i < p->first + p->count; i++)
        (void)lcor_profile_reading_reject(s->profile, i, 1, NULL);
}

static void to_profile(const reading *in, const patch *p, lcor_profile_reading *out)
{
    memset(out, 0, sizeof *out);
    out->name = p->name;
    out->has = LCOR_HAS_RGB;
    for (int i = 0; i < 3; i++)
        out->rgb[i] = p->level;
    if (in->kind == READING_LUMINANCE) {
        out->has |= LCOR_HAS_XYZ;
        memcpy(out->xyz, in->xyz, sizeof out->xyz);
        return;
    }
    out->has |= LCOR_HAS_VISUAL | (in->has_colour ? (unsigned)LCOR_HAS_COLOUR_DENSITY : 0U);
    memcpy(out->density, in->density, sizeof in->density);
    out->density[3] = in->value;
}

/* The next reading, from the journal while there is one, else from the instrument. */
static int fetch(session *s, reading *out)
{
    const int wait_ms = (int)(s->options->timeout * 1000.0 + 0.999);
    while (journal_peek(&s->log, 0))
        if (journal_next(&s->log, out) == 'R')
            return LCCAL_OK;
    for (;;) {
        cal_error err;
        const cal_status status = s->in.driver->measure(&s->in, wait_ms, out, &err);
        if (status == CAL_OK) {
            journal_reading(&s->log, out);
            return LCCAL_OK;
        }
        if (s->options->yes || (status != CAL_MISREAD && status != CAL_CALIBRATE))
            return session_fail(&err);
        lccal_warn("%s", err.text);
        switch (prompt_wait("again", "When that is done: [Enter: read again, q: quit]")) {
        case ANSWER_GO:
        case ANSWER_REDO: break;
        case ANSWER_QUIT:
        case ANSWER_CLOSED: return lccal_fail(LCCAL_INTERRUPTED, "interrupted");
        }
    }
}

/* Can this be a reading of any patch at all? */
static int check(session *s, const patch *p, const reading *got, const lcor_profile_reading *r)
{
    if (got->kind == READING_LUMINANCE)
        return got->value > 0.0
                   ? LCCAL_OK
                   : session_reject(s,
                                    "%s: the instrument sees no light at all; the patch is too "
                                    "dark for it, or it is covered",
                                    p->name);
    if (got->kind != s->kind)
        return session_reject(
            s, "%s: a %s reading among %s ones; choose one mode at the instrument", p->name,
            got->kind == READING_REFLECTION ? "reflection" : "transmission",
            s->kind == READING_REFLECTION ? "reflection" : "transmission");
    if ((r->has & s->has) != s->has)
        return session_reject(s,
                              "%s: the instrument stopped sending colour densities; choose one "
                              "mode at the instrument",
                              p->name);
    if (!judge_plausible(got->value)) {
        char text[32];
        lccal_format_number(text, sizeof text, got->value, 2);
        return session_reject(s,
                              "%s: %s is no density of paper or film; check the instrument's "
                              "zero and the --instrument setting",
                              p->name, text);
    }
    return LCCAL_OK;
}

/* Take one reading into the profile. What cannot be a reading of any patch stays out of p's count,
 * and out of the profile where that cannot hold it. */
static int take(session *s, patch *p, double *density)
{
    reading got;
    const int fetched = fetch(s, &got);
    if (fetched != LCCAL_OK)
        return fetched;
    lcor_profile_reading r;
    to_profile(&got, p, &r);
    if (lcor_profile_count(s->profile) == 0) {
        s->kind = got.kind;
        s->has = r.has;
    }
    const int checked = check(s, p, &got, &r);
    r.has &= s->has;
    r.rejected = checked != LCCAL_OK;
    lcor_error why;
    const lcor_status added = lcor_profile_reading_add(s->profile, &r, &why);
    if (checked != LCCAL_OK)
        return checked;
    if (added != LCOR_OK)
        return session_reject(s, "%s: %s", p->name, why.text);
    if (got.clamped)
        lccal_warn("%s: this reading is at the end of the instrument's range", p->name);
    s->step = fmax(s->step, got.step);
    *density = density_of(&r);
    return LCCAL_OK;
}

/* The readings of one attempt at a patch that may count. */
typedef struct attempt {
    double densities[JUDGE_MAX];
    size_t where[JUDGE_MAX]; /* in the profile */
    size_t count;
} attempt;

static void announce(const session *s, const patch *p, const attempt *a, size_t wanted)
{
    char text[32];
    const bool display = s->kind == READING_LUMINANCE;
    const double density = a->densities[a->count - 1];
    const double shown = display ? 100.0 * pow(10.0, -density) : density;
    lccal_format_number(text, sizeof text, shown, 3);
    lccal_say("  %s %zu/%zu  %s%s%s", p->name, a->count, wanted, display ? "" : "D ", text,
              display ? " cd/m2" : "");
    json event = lccal_event("reading");
    json_text(&event, "patch", p->name);
    json_number(&event, "number", (double)a->count, 0);
    json_number(&event, display ? "luminance" : "density", shown, 4);
    lccal_event_end(&event);
}

/* Judge a patch's readings and mark those that take no part. Over several positions the patch
 * itself may vary, so only readings of other patches are out of place there. */
static int settle(session *s, const patch *p, const attempt *a)
{
    bool accepted[JUDGE_MAX];
    const bool spread = s->options->positions > 1;
    const verdict v = judge_patch(a->densities, a->count, accepted);
    const bool good = v == VERDICT_GOOD || (spread && v != VERDICT_MIXED);
    for (size_t i = 0; i < a->count; i++) {
        const bool left_out = !good || (!accepted[i] && !spread);
        (void)lcor_profile_reading_reject(s->profile, a->where[i], left_out, NULL);
        if (good && left_out) {
            char text[32];
            lccal_format_number(text, sizeof text, a->densities[i], 3);
            lccal_warn("%s: reading %zu (D %s) does not agree with the others and is left out",
                       p->name, i + 1, text);
        }
    }
    if (good)
        return LCCAL_OK;
    if (v == VERDICT_MIXED)
        return session_reject(s,
                              "%s: readings of different patches are mixed; read one patch %zu "
                              "times, then the other",
                              p->name, a->count);
    if (v == VERDICT_DRIFTING)
        return session_reject(s,
                              "%s: every reading differs from the one before in the same "
                              "direction; let instrument and print settle",
                              p->name);
    return session_reject(s,
                          "%s: the readings do not agree; place the instrument flat on an even "
                          "patch",
                          p->name);
}

/* How even the patch is over its positions. */
static void report_evenness(const patch *p, const attempt *a)
{
    char text[32];
    double lowest = a->densities[0], highest = a->densities[0];
    for (size_t i = 1; i < a->count; i++) {
        lowest = fmin(lowest, a->densities[i]);
        highest = fmax(highest, a->densities[i]);
    }
    lccal_format_number(text, sizeof text, highest - lowest, 3);
    lccal_say("  %s varies by D %s over %zu positions", p->name, text, a->count);
    json event = lccal_event("evenness");
    json_text(&event, "patch", p->name);
    json_number(&event, "lowest", lowest, 4);
    json_number(&event, "highest", highest, 4);
    lccal_event_end(&event);
}

int session_exchange(session *s)
{
    lcor_profile *swapped;
    lcor_error err;
    if (lcor_profile_new(NULL, &swapped, &err) != LCOR_OK)
        return lccal_fail(LCCAL_FAILED, "%s", err.text);
    for (size_t i = 0; i < lcor_profile_count(s->profile); i++) {
        lcor_profile_reading r;
        (void)lcor_profile_reading_get(s->profile, i, &r, NULL);
        const bool was_white = strcmp(r.name, "white") == 0;
        r.name = was_white ? "black" : "white";
        r.id = NULL;
        r.rgb[0] = r.rgb[1] = r.rgb[2] = was_white ? 0.0 : 255.0;
        if (lcor_profile_reading_add(swapped, &r, &err) != LCOR_OK) {
            lcor_profile_free(swapped);
            return lccal_fail(LCCAL_FAILED, "%s", err.text);
        }
    }
    lcor_profile_free(s->profile);
    s->profile = swapped;
    const patch first = s->patches[WHITE];
    s->patches[WHITE].first = s->patches[BLACK].first;
    s->patches[WHITE].count = s->patches[BLACK].count;
    s->patches[BLACK].first = first.first;
    s->patches[BLACK].count = first.count;
    s->black_first = !s->black_first;
    return LCCAL_OK;
}

/* The first reading of all tells whether white or black is under the instrument. */
static int recognise(session *s, patch **p, double density)
{
    if (s->at > 0 || s->kind == READING_LUMINANCE || density < D_SURELY_BLACK)
        return LCCAL_OK;
    lccal_say("  This is the black patch, it seems; then white is next.");
    *p = &s->patches[BLACK];
    return session_exchange(s);
}

int session_patch(session *s, patch *p)
{
    static const char *const positions[POSITIONS_MAX] = {
        "top left",     "top centre",  "top right",     "middle left",  "centre",
        "middle right", "bottom left", "bottom centre", "bottom right",
    };
    attempt a = {.count = 0};
    const bool spread = s->options->positions > 1;
    const size_t wanted = (size_t)(spread ? s->options->positions : s->options->readings);
    p->first = lcor_profile_count(s->profile);
    while (a.count < wanted) {
        if (spread)
            lccal_say("  %s, position %zu: %s", p->name, a.count + 1, positions[a.count]);
        const int result = take(s, p, &a.densities[a.count]);
        p->count = lcor_profile_count(s->profile) - p->first;
        if (result == LCCAL_REJECTED && !s->options->yes)
            continue; /* it was said why; the same patch again */
        if (result != LCCAL_OK)
            return result;
        const int known = a.count > 0 ? LCCAL_OK : recognise(s, &p, a.densities[0]);
        if (known != LCCAL_OK)
            return known;
        a.where[a.count++] = p->first + p->count - 1;
        announce(s, p, &a, wanted);
    }
    if (spread)
        report_evenness(p, &a);
    return settle(s, p, &a);
}
