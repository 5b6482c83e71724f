/* SPDX-License-Identifier: MIT */
/* Profiles in files, as every subcommand reads, writes and tells them. */
#ifndef LCCAL_PROFILE_FILE_H
#define LCCAL_PROFILE_FILE_H

#include "lccal.h"

/* Failure is told to the user; both return an exit code. Saving keeps the old file as `path~`. */
int profile_load(const char *path, lcor_profile **out);
int profile_save(const lcor_profile *profile, const char *path);
/* Tell why the text at `path` is no profile; returns the exit code. */
int profile_refuse(const char *path, lcor_status status, const lcor_error *err);

/* What follows from the readings; LCCAL_BAD_PROFILE after telling the user when nothing does. */
int profile_evaluate(const lcor_profile *profile, lcor_profile_result *result);

/* The line and the event "result" that every command which stores a profile ends with. */
void profile_tell_result(const lcor_profile *profile, const lcor_profile_result *result,
                         const char *path);

/* Luminances of a display, not densities or XYZ of a print. */
bool profile_is_display(const lcor_profile *profile);
/* Y of a density of lcor_profile_result, for displays in cd/m2. */
double profile_luminance(double density);

/* "23.40 +- 0.52", or "23.40" where the interval is not known. Returns text. */
const char *profile_contrast_text(const lcor_profile_result *result, char *text, size_t capacity);

/* Set a provenance keyword; NULL leaves it. Returns an exit code. */
int profile_describe(lcor_profile *profile, const char *keyword, const char *value);

/* CREATED as seconds since 1970 (UTC), or -1 if it is no ISO 8601 date. */
double profile_created(const lcor_profile *profile);

#endif
