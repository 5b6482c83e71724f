/* SPDX-License-Identifier: MIT */
/* Tables of other programs on any bytes: CGATS text that the reader takes or refuses. */
#include "command/import_table.h"

#include <lcor/profile.h>

#include <stdlib.h>
#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    buffer cgats = {0};
    char problem[160] = "";
    lcor_error err = {.text = ""};
    lcor_profile *profile = NULL;
    char *text = malloc(size > 0 ? size : 1);
    if (!text)
        abort();
    if (size > 0)
        memcpy(text, data, size);
    if (!import_is_cgats(text, size)) {
        if (!import_table(text, size, &cgats, problem, sizeof problem)) {
            if (problem[0] == '\0')
                abort();
        } else if (lcor_profile_parse(cgats.bytes, cgats.size, NULL, &profile, &err) == LCOR_OK) {
            if (!(lcor_profile_contrast(profile) > 1.0))
                abort();
        } else if (err.text[0] == '\0') {
            abort();
        }
    }
    lcor_profile_free(profile);
    buffer_free(&cgats);
    free(text);
    return 0;
}
