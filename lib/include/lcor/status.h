/* SPDX-License-Identifier: MIT */
#ifndef LCOR_STATUS_H
#define LCOR_STATUS_H

#include <lcor/export.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Result of every call that can fail: 0 is success, negative is failure, sorted by who can act.
 *  Numbers never change meaning and are never reused. */
typedef enum lcor_status {
    LCOR_OK = 0,
    LCOR_ERR_ARG = -1,       /**< the caller's bug: NULL, a size, contradictory options */
    LCOR_ERR_DOMAIN = -2,    /**< a number lies outside the model: NaN, c <= 1, rho >= 1 */
    LCOR_ERR_NOMEM = -3,     /**< the allocator returned NULL, or a size does not fit size_t */
    LCOR_ERR_CANCELLED = -4, /**< the caller's progress callback asked to stop */
    LCOR_ERR_FORMAT = -5     /**< a text (device profile) is not what it claims to be */
} lcor_status;

/** Detail of a failure. The caller owns it and may pass NULL where one is taken; a call that
 *  succeeds leaves it alone. */
typedef struct lcor_error {
    lcor_status status;
    long where;     /**< index of the offending item or line, or -1 */
    char text[256]; /**< one line of English, always terminated */
} lcor_error;

/** Name of a status, for example "LCOR_ERR_DOMAIN"; "LCOR_ERR_UNKNOWN" for other numbers.
 *
 *  Memory: static string, never NULL.  Threads: any. */
LCOR_API const char *lcor_status_name(lcor_status status);

#ifdef __cplusplus
}
#endif

#endif
