/* SPDX-License-Identifier: MIT */
#include "session/judge.h"
#include "session/session.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

double session_density(const lcor_profile_reading *r)
{
    return r->has & LCOR_HAS_VISUAL ? r->density[3] : -log10(r->xyz[1] / 100.0);
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

/* The next reading from the instrument, into the profile. LCCAL_REJECTED: it cannot belong to any
 * patch; it is kept only when the profile can hold it. */
static int take(session *s, const patch *p, double *density)
{
    reading          got;
    cal_error        err;
    const int        wait_ms = (int)(s->options->timeout * 1000.0);
    const cal_status status = s->in.driver->measure(&s->in, wait_ms, &got, &err);
    if (status != CAL_OK)
        return session_fail(&err);
    if (lcor_profile_count(s->profile) == 0)
        s->kind = got.kind;
    if (got.kind != s->kind)
        return lccal_fail(LCCAL_REJECTED, "%s: reflection and transmission readings in one "
                                          "measurement; choose one mode and start again",
                          p->name);
    if (got.kind == READING_LUMINANCE && !(got.value > 0.0))
        return lccal_fail(LCCAL_REJECTED, "%s: the instrument sees no light at all; the patch is "
                                          "too dark for it, or it is covered",
                          p->name);
    lcor_profile_reading r;
    to_profile(&got, p, &r);
    *density = session_density(&r);
    if (!judge_plausible(got.kind == READING_LUMINANCE ? 0.0 : *density)) {
        char text[32];
        lccal_format_number(text, sizeof text, *density, 2);
        return lccal_fail(LCCAL_REJECTED, "%s: density %s is no density of paper or film; check "
                                          "the instrument's zero and its --instrument setting",
                          p->name, text);
    }
    lcor_error why;
    if (lcor_profile_reading_add(s->profile, &r, &why) != LCOR_OK)
        return lccal_fail(LCCAL_REJECTED, "%s: %s", p->name, why.text);
    if (got.clamped)
        lccal_warn("%s: the reading is at the end of the instrument's range", p->name);
    s->step = fmax(s->step, got.step);
    return LCCAL_OK;
}

static void announce(const session *s, const patch *p, double density)
{
    lcor_profile_reading r;
    char                 text[32];
    const bool           display = s->kind == READING_LUMINANCE;
    if (lcor_profile_reading_get(s->profile, p->first + p->count - 1, &r, NULL) != LCOR_OK)
        return;
    lccal_format_number(text, sizeof text, display ? r.xyz[1] : density, 3);
    lccal_say("  %s %zu/%d  %s%s", p->name, p->count, s->options->readings, display ? "" : "D ",
              text);
    lccal_event_begin("reading");
    lccal_event_text("patch", p->name);
    lccal_event_number("number", (double)p->count, 0);
    lccal_event_number(display ? "luminance" : "density", display ? r.xyz[1] : density, 4);
    lccal_event_end();
}

/* Judge a patch's readings and mark those that take no part. */
static int settle(session *s, const patch *p, const double *densities)
{
    bool          accepted[JUDGE_MAX];
    const verdict v = judge_patch(densities, p->count, accepted);
    for (size_t i = 0; i < p->count; i++) {
        const int rejected = v != VERDICT_GOOD || !accepted[i];
        (void)lcor_profile_reading_reject(s->profile, p->first + i, rejected, NULL);
        if (v == VERDICT_GOOD && rejected) {
            char text[32];
            lccal_format_number(text, sizeof text, densities[i], 3);
            lccal_warn("%s: reading %zu (D %s) does not agree with the others and is left out",
                       p->name, i + 1, text);
        }
    }
    switch (v) {
    case VERDICT_GOOD: return LCCAL_OK;
    case VERDICT_MIXED:
        return lccal_fail(LCCAL_REJECTED, "%s: readings of different patches are mixed; read one "
                                          "patch %d times, then the other",
                          p->name, s->options->readings);
    case VERDICT_DRIFTING:
        return lccal_fail(LCCAL_REJECTED, "%s: every reading differs from the one before in the "
                                          "same direction; let instrument and print settle",
                          p->name);
    case VERDICT_TOO_FEW:
    case VERDICT_EQUAL: break;
    }
    return lccal_fail(LCCAL_REJECTED, "%s: the readings do not agree; place the instrument flat "
                                      "on an even patch",
                      p->name);
}

int session_patch(session *s, patch *p)
{
    double densities[JUDGE_MAX];
    p->first = lcor_profile_count(s->profile);
    p->count = 0;
    while (p->count < (size_t)s->options->readings) {
        const int result = take(s, p, &densities[p->count]);
        if (result != LCCAL_OK)
            return result;
        p->count++;
        announce(s, p, densities[p->count - 1]);
    }
    return settle(s, p, densities);
}
