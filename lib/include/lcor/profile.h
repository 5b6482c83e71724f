/* SPDX-License-Identifier: MIT */
/** @file
 *  Device profile: readings of patches, where they come from, and what follows from them (contrast,
 *  its uncertainty, the tone curve). CGATS.17 text in memory; reading and writing files is the
 *  caller's. Numbers are read and printed in C notation whatever the locale. The format and every
 *  rule for derived values: docs/PROFILE.md.
 *
 *  | call                            | may run at the same time as            |
 *  |---------------------------------|----------------------------------------|
 *  | calls on a const lcor_profile   | any const calls on the same profile    |
 *  | calls on a non-const one        | calls on other profiles                |
 *  | lcor_profile_free               | nothing on that profile                | */
#ifndef LCOR_PROFILE_H
#define LCOR_PROFILE_H

#include <lcor/alloc.h>
#include <lcor/status.h>

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct lcor_profile lcor_profile;

/** Which fields of a reading are known. */
enum {
    LCOR_HAS_RGB = 1,            /**< rgb: what was sent to the device */
    LCOR_HAS_CMYK = 2,           /**< cmyk: what was sent to the device */
    LCOR_HAS_VISUAL = 4,         /**< density[3] */
    LCOR_HAS_COLOUR_DENSITY = 8, /**< density[0..2] */
    LCOR_HAS_XYZ = 16            /**< xyz */
};

/** One reading of one patch. Zero it, then set what is known. */
typedef struct lcor_profile_reading {
    const char *id;    /**< SAMPLE_ID; NULL on adding: the reading's number from 1 */
    const char *name;  /**< SAMPLE_NAME, UTF-8; NULL or "": none */
    unsigned has;      /**< LCOR_HAS_... */
    int rejected;      /**< kept, but takes no part in derived values */
    double rgb[3];     /**< 0..255; white is 255 255 255, black 0 0 0 */
    double cmyk[4];    /**< 0..100 % */
    double density[4]; /**< red, green, blue, visual [1], -1..8 */
    double xyz[3];     /**< Y > 0: percent of a perfect diffuser, or cd/m2 of a display */
} lcor_profile_reading;

/** Which readings are the device's black. */
typedef enum lcor_profile_black {
    LCOR_BLACK_FULL = 0,   /**< R = G = B = 0, or K 100 % alone */
    LCOR_BLACK_DARKEST = 1 /**< the darkest patch measured, such as C 100 M 100 K 100 */
} lcor_profile_black;

/** What follows from the readings that are not rejected. */
typedef struct lcor_profile_result {
    double contrast;     /**< c = Jmax/Jmin [1], > 1 (eq 13a) */
    double contrast_u95; /**< half-width of the 95 % interval of c; 0: not known */
    double d_min, d_max; /**< median density of white and of black [1]; of luminance for displays:
                              -log10(Y/100), where only the difference means anything */
    double u_min, u_max; /**< their standard uncertainties [1]; 0: not known */
    size_t n_min, n_max; /**< readings they rest on */
} lcor_profile_result;

/** An empty profile.  Memory: through `allocator`, copied. */
LCOR_API lcor_status lcor_profile_new(const lcor_allocator *allocator, lcor_profile **out,
                                      lcor_error *err);
LCOR_API void lcor_profile_free(lcor_profile *profile);

/** Read CGATS.17 text of `size` bytes: a profile of lccal's, or measurements of other programs
 *  (.ti3, i1Profiler and other CGATS text). Any line ends, byte order mark, comments and bytes
 *  outside ASCII are understood. LCOR_CONTRAST and LCOR_CONTRAST_U95 are computed again from the
 *  readings and compared.
 *
 *  Errors: LCOR_ERR_FORMAT with the line in err->where and what to do in err->text;
 *  LCOR_ERR_NOMEM.  Memory and time: bounded by a multiple of `size`. */
LCOR_API lcor_status lcor_profile_parse(const char *text, size_t size,
                                        const lcor_allocator *allocator, lcor_profile **out,
                                        lcor_error *err);

/** lcor_profile_parse with another choice of black for texts that make none.
 *
 *  Errors: as there; LCOR_ERR_FORMAT also for LCOR_BLACK_DARKEST and a text that holds fewer
 *  readings than it declares: the darkest may be missing. */
LCOR_API lcor_status lcor_profile_import(const char *text, size_t size, lcor_profile_black black,
                                         const lcor_allocator *allocator, lcor_profile **out,
                                         lcor_error *err);

/** Write the profile as CGATS.17 text. `*size` gets the length without the final NUL; `buffer`
 *  (may be NULL) gets as much as fits in `capacity`, always terminated. Parsing the text and
 *  writing it again gives the same bytes.
 *
 *  Errors: LCOR_ERR_DOMAIN the readings give no contrast (see lcor_profile_evaluate). */
LCOR_API lcor_status lcor_profile_format(const lcor_profile *profile, char *buffer, size_t capacity,
                                         size_t *size, lcor_error *err);

/** c = Jmax/Jmin (eq 13a) and the half-width of its 95 % interval (0: not known). Both 0 while the
 *  readings give no contrast; a profile that was parsed always gives one. */
LCOR_API double lcor_profile_contrast(const lcor_profile *profile);
LCOR_API double lcor_profile_contrast_u95(const lcor_profile *profile);

/** Contrast, densities and their uncertainty: median of each patch, Student's t over the spread of
 *  its readings, never better than the resolution allows.
 *
 *  Errors: LCOR_ERR_DOMAIN white or black is missing, or black is no darker than white.
 *  Cost: O(n log n) in the readings; fit for asking after every reading. */
LCOR_API lcor_status lcor_profile_evaluate(const lcor_profile *profile, lcor_profile_result *out,
                                           lcor_error *err);

/** The device value for each displayed luminance, for lcor_plan_options.tone_curve: out[i] is
 *  what to send, 0..1, to show luminance Jmin + (Jmax - Jmin) i / (n - 1); non-decreasing,
 *  out[0] = 0 and out[n-1] = 1. From the grey readings (R = G = B), at least one between black and
 *  white; monotone interpolation.
 *
 *  Errors: LCOR_ERR_ARG n < 2; LCOR_ERR_DOMAIN no grey ramp, or one that does not rise. */
LCOR_API lcor_status lcor_profile_tone_curve(const lcor_profile *profile, size_t n, float *out,
                                             lcor_error *err);
/** Number of different grey levels between black and white; 0: there is no tone curve. */
LCOR_API size_t lcor_profile_grey_levels(const lcor_profile *profile);

/** Readings, in the order they were added; pointers in them live until the profile changes.
 *  Errors: LCOR_ERR_DOMAIN a number outside its range above; LCOR_ERR_ARG an index that is not
 *  there, neither VISUAL nor XYZ, or a name that a line of text cannot hold; LCOR_ERR_NOMEM. */
LCOR_API size_t lcor_profile_count(const lcor_profile *profile);
LCOR_API lcor_status lcor_profile_reading_add(lcor_profile *profile,
                                              const lcor_profile_reading *reading, lcor_error *err);
LCOR_API lcor_status lcor_profile_reading_get(const lcor_profile *profile, size_t index,
                                              lcor_profile_reading *out, lcor_error *err);
LCOR_API lcor_status lcor_profile_reading_reject(lcor_profile *profile, size_t index, int rejected,
                                                 lcor_error *err);

/** Provenance: INSTRUMENTATION, CREATED, MATERIAL, MEASUREMENT_SOURCE, SAMPLE_BACKING,
 *  PRINT_CONDITIONS, or a name of the caller's own (capitals, digits, _). NULL removes it; names
 *  starting with LCOR_ belong to the library. A value is one line of UTF-8 without quotes.
 *  lcor_profile_keyword returns NULL for one that is not there. */
LCOR_API lcor_status lcor_profile_keyword_set(lcor_profile *profile, const char *name,
                                              const char *value, lcor_error *err);
LCOR_API const char *lcor_profile_keyword(const lcor_profile *profile, const char *name);
LCOR_API size_t lcor_profile_keyword_count(const lcor_profile *profile);
LCOR_API const char *lcor_profile_keyword_name(const lcor_profile *profile, size_t index);

/** Step of the instrument's display or interface, in density for visual readings and in the unit
 *  of Y for XYZ: readings closer than this are not told apart. 0: not known (the default; a parsed
 *  text without LCOR_RESOLUTION has the step its digits show).
 *  Errors: LCOR_ERR_DOMAIN negative or not finite. */
LCOR_API lcor_status lcor_profile_resolution_set(lcor_profile *profile, double step,
                                                 lcor_error *err);
LCOR_API double lcor_profile_resolution(const lcor_profile *profile);

/** Which readings are black: LCOR_BLACK_FULL unless lcor_profile_import or the text said otherwise.
 */
LCOR_API lcor_profile_black lcor_profile_black_get(const lcor_profile *profile);

#ifdef __cplusplus
}
#endif

#endif
