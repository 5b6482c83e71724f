/* SPDX-License-Identifier: MIT */
/* `lccal export`: a profile for other programs. */
#include "command/export.h"

#include <stdio.h>
#include <string.h>

static const char help[] = "lccal export PROFILE -o FILE(.icc|.json|.csv) [--format icc|json|csv]\n"
                           "\n"
                           "  icc    ICC v2.4 profile of one grey channel; kTRC[0] = 1/contrast\n"
                           "  json   everything a profile holds and what follows from it\n"
                           "  csv    the readings; lccal enter --import reads them back\n"
                           "\n"
                           "  -o, --output FILE   where to; - is standard output\n"
                           "  --format NAME       instead of the ending of FILE\n"
                           "  --json, --quiet, --help, --version\n";

/* The format named, or that of the file's ending; "" if there is none. */
static const char *format_of(const char *format, const char *path)
{
    const char *dot = strrchr(path, '.');
    if (format)
        return format;
    if (dot && strcmp(dot, ".icm") == 0)
        return "icc";
    return dot ? dot + 1 : "";
}

static int save(const buffer *out, const char *path)
{
    if (out->failed)
        return lccal_fail(LCCAL_FAILED, "out of memory");
    if (strcmp(path, "-") != 0)
        return lccal_save_file(path, out->bytes, out->size, false);
    fwrite(out->bytes, 1, out->size, stdout);
    return LCCAL_OK;
}

int cmd_export(int argc, char **argv)
{
    const char *output = NULL, *wanted = NULL;
    const lccal_option options[] = {
        {"--output", "-o", LCCAL_TEXT, &output},
        {"--format", NULL, LCCAL_TEXT, &wanted},
    };
    int status =
        lccal_parse_options(&argc, argv, options, sizeof options / sizeof options[0], help);
    if (status != LCCAL_OK)
        return status < 0 ? LCCAL_OK : status;
    if (argc != 2 || !output)
        return lccal_fail(LCCAL_USAGE, "export wants a profile and -o FILE; --help explains");
    if (strcmp(argv[1], output) == 0)
        return lccal_fail(LCCAL_USAGE, "-o must not name the profile itself");
    const char *format = format_of(wanted, output);
    const bool icc = strcmp(format, "icc") == 0, as_json = strcmp(format, "json") == 0;
    if (!icc && !as_json && strcmp(format, "csv") != 0)
        return lccal_fail(LCCAL_USAGE, "'%s' is no format; --format is icc, json or csv", format);
    lcor_profile *profile = NULL;
    lcor_profile_result result;
    buffer out = {0};
    status = profile_load(argv[1], &profile);
    if (status == LCCAL_OK)
        status = profile_evaluate(profile, &result);
    if (status == LCCAL_OK) {
        if (icc)
            export_icc(profile, &result, &out);
        else if (as_json)
            export_json(profile, &result, &out);
        else
            export_csv(profile, &out);
        status = save(&out, output);
    }
    if (status == LCCAL_OK && strcmp(output, "-") != 0) {
        lccal_say("%s in %s", format, output);
        json event = lccal_event("exported");
        json_text(&event, "format", format);
        json_text(&event, "path", output);
        lccal_event_end(&event);
    }
    buffer_free(&out);
    lcor_profile_free(profile);
    return status;
}
