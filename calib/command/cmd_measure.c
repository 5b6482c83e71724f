/* SPDX-License-Identifier: MIT */
#include "command/profile_file.h"
#include "lccal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char help[] =
    "lccal --port PORT [options]      measure white and black, store the profile\n"
    "lccal list|doctor|device|enter|show|verify|history|export|target --help\n"
    "\n"
    "  --port PORT         /dev/ttyUSB0, hid:VID:PID[:SERIAL], /dev/hidrawN, script:FILE\n"
    "                      [the known instrument that is plugged in]\n"
    "  --instrument NAME   printalyzer, line:PRESET, xrite-rci, colorhug2, densistick or auto\n"
    "  -o, --output FILE   the profile [profile.cgats]\n"
    "  --readings N        readings of each patch [5]\n"
    "  --precision P       go on until c is known to P percent (95 %), at most 4 more rounds\n"
    "  --positions 9       one reading at each of nine places of a patch: how even it is\n"
    "  --ramp K            also K grey steps, light to dark: the device's tone curve\n"
    "  --timeout S         longest wait for one reading, seconds [120]\n"
    "  --yes               wait for no key, take the readings as they come\n"
    "  --material TEXT, --backing TEXT, --conditions TEXT\n"
    "                      paper, backing and print settings, kept in the profile\n"
    "  --resume            go on with the measurement that was interrupted\n"
    "  --record FILE       write the dialogue with the instrument down; script:FILE replays it\n"
    "  --json              events on stdout, one JSON object a line\n"
    "  --quiet             only errors and warnings\n"
    "  --help, --version\n";

/* Store the profile and tell what it says. */
static int store(const lcor_profile *profile, const char *path)
{
    lcor_profile_result r;
    lcor_error err;
    if (lcor_profile_evaluate(profile, &r, &err) != LCOR_OK)
        return lccal_fail(LCCAL_REJECTED, "%s", err.text);
    const int result = profile_save(profile, path);
    if (result == LCCAL_OK)
        profile_tell_result(profile, &r, path);
    return result;
}

static int check_options(const lccal_measure_options *o)
{
    if (o->readings > 1000)
        return lccal_fail(LCCAL_USAGE, "--readings wants 1 to 1000");
    if (o->positions != 1 && o->positions != 9)
        return lccal_fail(LCCAL_USAGE, "--positions wants 9, or 1 for none");
    if (o->ramp > 64)
        return lccal_fail(LCCAL_USAGE, "--ramp wants 1 to 64 steps");
    if (!(o->timeout > 0.0) || o->timeout > 86400.0)
        return lccal_fail(LCCAL_USAGE, "--timeout wants seconds, more than 0 and at most a day");
    if (o->precision < 0.0 || (o->precision > 0.0 && o->yes))
        return lccal_fail(LCCAL_USAGE, "--precision wants a percentage above 0, and not --yes: it "
                                       "asks for the patch it needs");
    return LCCAL_OK;
}

static int describe(lcor_profile *profile, const char *const print[3])
{
    static const char *const names[3] = {"MATERIAL", "SAMPLE_BACKING", "PRINT_CONDITIONS"};
    int result = LCCAL_OK;
    for (int i = 0; result == LCCAL_OK && i < 3; i++)
        result = profile_describe(profile, names[i], print[i]);
    return result;
}

/* A text that no profile can hold is refused before anybody measures. */
static int check_description(const char *const print[3])
{
    lcor_profile *profile;
    lcor_error err;
    if (lcor_profile_new(NULL, &profile, &err) != LCOR_OK)
        return lccal_fail(LCCAL_FAILED, "%s", err.text);
    const int result = describe(profile, print);
    lcor_profile_free(profile);
    return result;
}

/* Everything between the open port and the stored profile. */
static int measure_and_store(const lccal_measure_options *o, const char *output,
                             const char *const print[3])
{
    lcor_profile *profile = NULL;
    int result = lccal_measure(o, &profile);
    if (result == LCCAL_OK)
        result = describe(profile, print);
    if (result == LCCAL_OK)
        result = store(profile, output);
    lcor_profile_free(profile);
    if (result == LCCAL_OK)
        (void)remove(o->journal); /* the readings are in the profile now */
    return result;
}

int cmd_measure(int argc, char **argv)
{
    lccal_measure_options o = {.readings = 5, .positions = 1, .timeout = 120.0};
    const char *output = "profile.cgats";
    const char *print[3] = {NULL, NULL, NULL};
    const lccal_option options[] = {
        {"--port", NULL, LCCAL_TEXT, &o.port},
        {"--instrument", NULL, LCCAL_TEXT, &o.instrument},
        {"--output", "-o", LCCAL_TEXT, &output},
        {"--readings", NULL, LCCAL_COUNT, &o.readings},
        {"--precision", NULL, LCCAL_NUMBER, &o.precision},
        {"--positions", NULL, LCCAL_COUNT, &o.positions},
        {"--ramp", NULL, LCCAL_COUNT, &o.ramp},
        {"--timeout", NULL, LCCAL_NUMBER, &o.timeout},
        {"--yes", NULL, LCCAL_FLAG, &o.yes},
        {"--resume", NULL, LCCAL_FLAG, &o.resume},
        {"--record", NULL, LCCAL_TEXT, &o.record},
        {"--material", NULL, LCCAL_TEXT, &print[0]},
        {"--backing", NULL, LCCAL_TEXT, &print[1]},
        {"--conditions", NULL, LCCAL_TEXT, &print[2]},
    };
    int result =
        lccal_parse_options(&argc, argv, options, sizeof options / sizeof options[0], help);
    if (result != LCCAL_OK)
        return result < 0 ? LCCAL_OK : result;
    if (argc > 1)
        return lccal_fail(LCCAL_USAGE, "'%s' is no subcommand; --help lists them", argv[1]);
    result = check_options(&o);
    if (result == LCCAL_OK)
        result = check_description(print);
    if (result == LCCAL_OK)
        result = lccal_check_target(output);
    if (result != LCCAL_OK)
        return result;
    char found[128];
    result = lccal_find_port(&o, found, sizeof found);
    if (result != LCCAL_OK)
        return result;
    const size_t n = strlen(output) + sizeof ".journal";
    char *path = malloc(n);
    if (!path)
        return lccal_fail(LCCAL_FAILED, "out of memory");
    snprintf(path, n, "%s.journal", output);
    o.journal = path;
    result = measure_and_store(&o, output, print);
    free(path);
    return result;
}
