/* SPDX-License-Identifier: MIT */
/* `lccal target`: the chart to print. */
#include "command/target.h"
#include "lccal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char help[] =
    "lccal target [-o NAME] [--steps N] [--page a4|letter] [--dpi N]\n"
    "\n"
    "  Writes NAME.tif (16-bit RGB) and NAME.pdf, or only the one whose ending NAME has: white "
    "and\n"
    "  black at nine positions of a page and a grey ramp, with printing instructions.\n"
    "\n"
    "  -o, --output NAME   [target]\n"
    "  --steps N           greys between black and white, 1 to 28 [14]\n"
    "  --page a4|letter    paper [a4]\n"
    "  --dpi N             of the TIFF, 72 to 1200 [300]\n"
    "  --json, --quiet, --help, --version\n";

static int save(buffer *bytes, const char *name, const char *ending, json *files)
{
    const size_t n = strlen(name) + strlen(ending) + 1;
    char *path = malloc(n);
    int status = LCCAL_OK;
    if (!path || bytes->failed) {
        status = lccal_fail(LCCAL_FAILED, "out of memory");
    } else {
        snprintf(path, n, "%s%s", name, ending);
        status = lccal_save_file(path, bytes->bytes, bytes->size, false);
    }
    if (status == LCCAL_OK) {
        lccal_say("chart in %s", path);
        json_text(files, NULL, path);
    }
    free(path);
    buffer_free(bytes);
    return status;
}

static int write_chart(const target *t, const char *name, double dpi, json *files)
{
    const bool only_tiff = lccal_ends_with(name, ".tif") || lccal_ends_with(name, ".tiff");
    const bool only_pdf = lccal_ends_with(name, ".pdf");
    int status = LCCAL_OK;
    buffer bytes = {0};
    if (!only_pdf) {
        if (!target_tiff(t, dpi, &bytes))
            return lccal_fail(LCCAL_FAILED, "cannot make the TIFF: no memory, or lccal was built "
                                            "without libtiff; -o NAME.pdf writes the PDF alone");
        status = save(&bytes, name, only_tiff ? "" : ".tif", files);
    }
    if (status == LCCAL_OK && !only_tiff) {
        target_pdf(t, &bytes);
        status = save(&bytes, name, only_pdf ? "" : ".pdf", files);
    }
    return status;
}

int cmd_target(int argc, char **argv)
{
    static target chart; /* too large for a stack */
    const char *output = "target", *page = "a4";
    int steps = 14, dpi = 300;
    const lccal_option options[] = {
        {"--output", "-o", LCCAL_TEXT, &output},
        {"--steps", NULL, LCCAL_COUNT, &steps},
        {"--page", NULL, LCCAL_TEXT, &page},
        {"--dpi", NULL, LCCAL_COUNT, &dpi},
    };
    int status =
        lccal_parse_options(&argc, argv, options, sizeof options / sizeof options[0], help);
    if (status != LCCAL_OK)
        return status < 0 ? LCCAL_OK : status;
    const bool letter = strcmp(page, "letter") == 0;
    if (argc > 1)
        return lccal_fail(LCCAL_USAGE, "'%s' is one argument too many; -o names the chart",
                          argv[1]);
    if (!letter && strcmp(page, "a4") != 0)
        return lccal_fail(LCCAL_USAGE, "--page is a4 or letter, not '%s'", page);
    if (steps > TARGET_STEPS_MAX || dpi < 72 || dpi > 1200)
        return lccal_fail(LCCAL_USAGE, "--steps wants 1 to %d, --dpi 72 to 1200", TARGET_STEPS_MAX);
    target_lay_out(&chart, letter ? 215.9 : 210.0, letter ? 279.4 : 297.0, steps);
    json event = lccal_event("target");
    json_open(&event, "paths", '[');
    status = write_chart(&chart, output, dpi, &event);
    if (status == LCCAL_OK) {
        json_close(&event, ']');
        lccal_event_end(&event);
    }
    buffer_free(&event.out);
    for (size_t i = 0; status == LCCAL_OK && target_instructions[i]; i++)
        lccal_say("%s", target_instructions[i]);
    return status;
}
