/* SPDX-License-Identifier: MIT */
/* What the files of this room share. */
#ifndef LCOR_PROFILE_INTERNAL_H
#define LCOR_PROFILE_INTERNAL_H

#include <lcor/profile.h>

#define LCOR_PROFILE_FORMAT_VERSION 1
#define LCOR_PROFILE_MAX_KEYWORDS   256 /* bounds the time of a hostile header */

typedef struct profile_keyword {
    const char *name, *value;
} profile_keyword;

struct lcor_profile {
    lcor_allocator allocator;
    struct profile_block *text; /* every name and value of the profile */
    lcor_profile_reading *readings;
    size_t count, capacity;
    profile_keyword *keywords;
    size_t keyword_count, keyword_capacity;
    double resolution;
    lcor_profile_black black;
};

/* A copy of text[0..n-1] that lives as long as the profile; NULL when memory is short. Bytes that
 * are not UTF-8 are taken as Latin-1, quotes become
 * apostrophes, control characters blanks. */
const char *lcor_internal_profile_text(lcor_profile *profile, const char *text, size_t n);

/* lcor_profile_reading_add with id and name as pieces of a text; an empty id is the number. */
lcor_status lcor_internal_profile_add(lcor_profile *profile, const lcor_profile_reading *reading,
                                      const char *id, size_t id_n, const char *name, size_t name_n,
                                      lcor_error *err);

/* lcor_profile_keyword_set with pieces of a text, for a name that is all right. */
int lcor_internal_keyword_name_ok(const char *name, size_t n);
lcor_status lcor_internal_profile_keep(lcor_profile *profile, const char *name, size_t name_n,
                                       const char *value, size_t value_n, lcor_error *err);

/* Which patch a reading is, from what was sent to the device. */
int lcor_internal_is_white(const lcor_profile_reading *reading);
int lcor_internal_is_full_black(const lcor_profile_reading *reading);

/* Two-sided 95 % quantile of Student's t. */
double lcor_internal_student95(double freedom);

/* Density of visual readings, -log10(Y/100) of XYZ ones. */
double lcor_internal_density(const lcor_profile_reading *reading);

#endif
