/* SPDX-License-Identifier: MIT */
/* A profile in the formats of other programs, in memory. */
#ifndef LCCAL_EXPORT_H
#define LCCAL_EXPORT_H

#include "buffer.h"
#include "command/profile_file.h"

/* Members of an object: what a profile says, and the list of its readings. */
void json_profile(json *j, const lcor_profile *profile, const lcor_profile_result *result);
void json_readings(json *j, const lcor_profile *profile);

void export_json(const lcor_profile *profile, const lcor_profile_result *result, buffer *out);
/* The names of CGATS in the first line; `lccal enter --import` reads it back. */
void export_csv(const lcor_profile *profile, buffer *out);
/* ICC.1:2001-04 (v2.4), one grey channel: kTRC is the luminance of each device value relative to
 * white, so its first entry is 1/c. Straight where the profile holds no grey ramp. */
void export_icc(const lcor_profile *profile, const lcor_profile_result *result, buffer *out);

#endif
