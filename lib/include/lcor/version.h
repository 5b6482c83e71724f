/* SPDX-License-Identifier: MIT */
#ifndef LCOR_VERSION_H
#define LCOR_VERSION_H

#include <lcor/export.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The one place of the version; CMake and pyproject.toml read it here. */
#define LCOR_VERSION_STRING "0.1.0"
#define LCOR_VERSION_MAJOR  0
#define LCOR_VERSION_MINOR  1
#define LCOR_VERSION_PATCH  0

/** Version of the library in use, for example "0.1.0".
 *
 *  Memory: static string.  Threads: any. */
LCOR_API const char *lcor_version(void);

#ifdef __cplusplus
}
#endif

#endif
