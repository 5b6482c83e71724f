/* SPDX-License-Identifier: MIT */
#include "lccal.h"

#include <stdlib.h>

static const char help[] =
    "lccal --port PORT [options]      measure white and black, store the profile\n"
    "lccal list|doctor|device|enter|show|verify|history|export|target --help\n"
    "\n"
    "  --port PORT         /dev/ttyUSB0, hid:VID:PID[:SERIAL], /dev/hidrawN, script:FILE\n"
    "  --instrument NAME   printalyzer, line:PRESET, xrite-rci, colorhug2, densistick or auto\n"
    "  -o, --output FILE   the profile [profile.cgats]\n"
    "  --readings N        readings of each patch [5]\n"
    "  --timeout S         longest wait for one reading, seconds [120]\n"
    "  --yes               wait for no key, take the readings as they come\n"
    "  --material TEXT, --backing TEXT, --conditions TEXT\n"
    "                      paper, backing and print settings, kept in the profile\n"
    "  --json              events on stdout, one JSON object a line\n"
    "  --quiet             only errors and warnings\n"
    "  --help, --version\n";

/* Tell the result; format the profile and store it. */
static int store(const lcor_profile *profile, const char *path)
{
    lcor_profile_result r;
    lcor_error          err;
    size_t              size = 0;
    if (lcor_profile_evaluate(profile, &r, &err) != LCOR_OK)
        return lccal_fail(LCCAL_REJECTED, "%s", err.text);
    if (lcor_profile_format(profile, NULL, 0, &size, &err) != LCOR_OK)
        return lccal_fail(LCCAL_REJECTED, "%s", err.text);
    char *text = malloc(size + 1);
    if (!text || lcor_profile_format(profile, text, size + 1, &size, &err) != LCOR_OK) {
        free(text);
        return lccal_fail(LCCAL_FAILED, "out of memory");
    }
    const int result = lccal_save_file(path, text, size, true);
    free(text);
    if (result != LCCAL_OK)
        return result;
    char d_min[32], d_max[32], c[32], u[32];
    lccal_say("D_min %s, D_max %s, contrast %s +- %s (95 %%); profile in %s",
              lccal_format_number(d_min, sizeof d_min, r.d_min, 3),
              lccal_format_number(d_max, sizeof d_max, r.d_max, 3),
              lccal_format_number(c, sizeof c, r.contrast, 2),
              lccal_format_number(u, sizeof u, r.contrast_u95, 2), path);
    lccal_event_begin("result");
    lccal_event_number("d_min", r.d_min, 4);
    lccal_event_number("d_max", r.d_max, 4);
    lccal_event_number("contrast", r.contrast, 4);
    lccal_event_number("contrast_u95", r.contrast_u95, 4);
    lccal_event_text("profile", path);
    lccal_event_end();
    return LCCAL_OK;
}

static int describe_print(lcor_profile *profile, const char *name, const char *value)
{
    lcor_error err;
    if (value && lcor_profile_keyword_set(profile, name, value, &err) != LCOR_OK)
        return lccal_fail(LCCAL_USAGE, "%s: %s", name, err.text);
    return LCCAL_OK;
}

int cmd_measure(int argc, char **argv)
{
    lccal_measure_options o = {.readings = 5, .timeout = 120.0};
    const char           *output = "profile.cgats";
    const char           *material = NULL, *backing = NULL, *conditions = NULL;
    const lccal_option    options[] = {
        {"--port", NULL, LCCAL_TEXT, &o.port},
        {"--instrument", NULL, LCCAL_TEXT, &o.instrument},
        {"--output", "-o", LCCAL_TEXT, &output},
        {"--readings", NULL, LCCAL_COUNT, &o.readings},
        {"--timeout", NULL, LCCAL_NUMBER, &o.timeout},
        {"--yes", NULL, LCCAL_FLAG, &o.yes},
        {"--material", NULL, LCCAL_TEXT, &material},
        {"--backing", NULL, LCCAL_TEXT, &backing},
        {"--conditions", NULL, LCCAL_TEXT, &conditions},
    };
    int result =
        lccal_parse_options(&argc, argv, options, sizeof options / sizeof options[0], help);
    if (result != LCCAL_OK)
        return result < 0 ? LCCAL_OK : result;
    if (argc > 1)
        return lccal_fail(LCCAL_USAGE, "'%s' is no subcommand; --help lists them", argv[1]);
    if (o.readings > 1000)
        return lccal_fail(LCCAL_USAGE, "--readings wants 1 to 1000");
    if (!(o.timeout > 0.0) || o.timeout > 86400.0)
        return lccal_fail(LCCAL_USAGE, "--timeout wants seconds, more than 0 and at most a day");
    if (!o.port)
        return lccal_fail(LCCAL_USAGE, "--port says where the instrument is; `lccal list` shows "
                                       "what is plugged in");
    lcor_profile *profile = NULL;
    result = lccal_measure(&o, &profile);
    if (result == LCCAL_OK)
        result = describe_print(profile, "MATERIAL", material);
    if (result == LCCAL_OK)
        result = describe_print(profile, "SAMPLE_BACKING", backing);
    if (result == LCCAL_OK)
        result = describe_print(profile, "PRINT_CONDITIONS", conditions);
    if (result == LCCAL_OK)
        result = store(profile, output);
    lcor_profile_free(profile);
    return result;
}
