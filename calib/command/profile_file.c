/* SPDX-License-Identifier: MIT */
#include "command/profile_file.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int profile_load(const char *path, lcor_profile **out)
{
    char *text;
    size_t size;
    lcor_error err;
    const int loaded = lccal_load_file(path, LCCAL_BAD_PROFILE, &text, &size);
    if (loaded != LCCAL_OK)
        return loaded;
    const lcor_status status = lcor_profile_parse(text, size, NULL, out, &err);
    free(text);
    return status == LCOR_OK ? LCCAL_OK : profile_refuse(path, status, &err);
}

int profile_refuse(const char *path, lcor_status status, const lcor_error *err)
{
    return lccal_fail(status == LCOR_ERR_NOMEM ? LCCAL_FAILED : LCCAL_BAD_PROFILE, "'%s': %s", path,
                      err->text);
}

int profile_save(const lcor_profile *profile, const char *path)
{
    size_t size = 0;
    lcor_error err;
    if (lcor_profile_format(profile, NULL, 0, &size, &err) != LCOR_OK)
        return lccal_fail(LCCAL_REJECTED, "%s", err.text);
    char *text = malloc(size + 1);
    if (!text || lcor_profile_format(profile, text, size + 1, &size, &err) != LCOR_OK) {
        free(text);
        return lccal_fail(LCCAL_FAILED, "out of memory while saving '%s'", path);
    }
    const int result = lccal_save_file(path, text, size, true);
    free(text);
    return result;
}

int profile_evaluate(const lcor_profile *profile, lcor_profile_result *result)
{
    lcor_error err;
    if (lcor_profile_evaluate(profile, result, &err) != LCOR_OK)
        return lccal_fail(LCCAL_BAD_PROFILE, "%s", err.text);
    return LCCAL_OK;
}

const char *profile_contrast_text(const lcor_profile_result *r, char *text, size_t capacity)
{
    char c[32], u[32];
    const int decimals = r->contrast_u95 > 0.0 && r->contrast_u95 < 0.1 ? 4 : 2;
    lccal_format_number(c, sizeof c, r->contrast, decimals);
    lccal_format_number(u, sizeof u, r->contrast_u95, decimals);
    snprintf(text, capacity, r->contrast_u95 > 0.0 ? "%s +- %s" : "%s", c, u);
    return text;
}

bool profile_is_display(const lcor_profile *profile)
{
    const char *class = lcor_profile_keyword(profile, "DEVICE_CLASS");
    const char *source = lcor_profile_keyword(profile, "MEASUREMENT_SOURCE");
    return (class && strcmp(class, "DISPLAY") == 0) || (source && strstr(source, "cd/m2"));
}

double profile_luminance(double density) { return 100.0 * pow(10.0, -density); }

void profile_tell_result(const lcor_profile *profile, const lcor_profile_result *r,
                         const char *path)
{
    char light[32], dark[32], contrast[80];
    const bool display = profile_is_display(profile);
    const double white = display ? profile_luminance(r->d_min) : r->d_min;
    const double black = display ? profile_luminance(r->d_max) : r->d_max;
    lccal_format_number(light, sizeof light, white, 3);
    lccal_format_number(dark, sizeof dark, black, 3);
    profile_contrast_text(r, contrast, sizeof contrast);
    lccal_say(display ? "J_max %s, J_min %s cd/m2, contrast %s%s; profile in '%s'"
                      : "D_min %s, D_max %s, contrast %s%s; profile in '%s'",
              light, dark, contrast, r->contrast_u95 > 0.0 ? " (95 %)" : "", path);
    json event = lccal_event("result");
    json_number(&event, display ? "j_max" : "d_min", white, 4);
    json_number(&event, display ? "j_min" : "d_max", black, 4);
    json_number(&event, "contrast", r->contrast, 4);
    json_number(&event, "contrast_u95", r->contrast_u95, 4);
    json_text(&event, "profile", path);
    lccal_event_end(&event);
}

int profile_describe(lcor_profile *profile, const char *keyword, const char *value)
{
    lcor_error err;
    if (value && lcor_profile_keyword_set(profile, keyword, value, &err) != LCOR_OK)
        return lccal_fail(LCCAL_USAGE, "%s: %s", keyword, err.text);
    return LCCAL_OK;
}

/* The number of n digits at text, or -1. */
static int digits(const char *text, int n)
{
    int value = 0;
    for (int i = 0; i < n; i++) {
        if (text[i] < '0' || text[i] > '9')
            return -1;
        value = 10 * value + (text[i] - '0');
    }
    return value;
}

/* Days from 1970-01-01 to a date of the Gregorian calendar; years begin in March, so that the leap
 * day is their last. */
static long days_since_1970(long year, long month, long day)
{
    const long y = month > 2 ? year : year - 1, m = month > 2 ? month - 3 : month + 9;
    return 365 * y + y / 4 - y / 100 + y / 400 + (153 * m + 2) / 5 + day - 1 - 719468;
}

double profile_created(const lcor_profile *profile)
{
    const char *text = lcor_profile_keyword(profile, "CREATED");
    if (!text || strlen(text) < 10 || text[4] != '-' || text[7] != '-')
        return -1.0;
    const int year = digits(text, 4), month = digits(text + 5, 2), day = digits(text + 8, 2);
    if (year < 1970 || month < 1 || month > 12 || day < 1 || day > 31)
        return -1.0;
    double seconds = 86400.0 * (double)days_since_1970(year, month, day);
    if (strlen(text) >= 19 && text[10] == 'T' && digits(text + 11, 2) >= 0 &&
        digits(text + 14, 2) >= 0 && digits(text + 17, 2) >= 0)
        seconds +=
            3600.0 * digits(text + 11, 2) + 60.0 * digits(text + 14, 2) + digits(text + 17, 2);
    return seconds;
}
