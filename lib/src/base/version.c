/* SPDX-License-Identifier: MIT */
#include <lcor/version.h>

const char *lcor_version(void) { return LCOR_VERSION_STRING; }
