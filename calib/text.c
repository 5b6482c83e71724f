/* SPDX-License-Identifier: MIT */
#define _POSIX_C_SOURCE 200809L
#include "lccal.h"

#include <string.h>
#include <time.h>

const char *lccal_now(char *text, size_t capacity)
{
    const time_t now = time(NULL);
    struct tm utc;
    if (!gmtime_r(&now, &utc) || strftime(text, capacity, "%Y-%m-%dT%H:%M:%SZ", &utc) == 0)
        text[0] = '\0';
    return text;
}

bool lccal_ends_with(const char *text, const char *end)
{
    const size_t n = strlen(text), m = strlen(end);
    return n > m && strcmp(text + n - m, end) == 0;
}
