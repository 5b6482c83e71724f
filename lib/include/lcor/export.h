/* SPDX-License-Identifier: MIT */
#ifndef LCOR_EXPORT_H
#define LCOR_EXPORT_H

/* LCOR_API marks what liblcor exports; everything else in it is hidden. Clients of a static
 * Windows library define LCOR_STATIC (CMake and pkg-config do so for them). */
#if defined(LCOR_STATIC)
#define LCOR_API
#elif defined(_WIN32)
#ifdef LCOR_BUILDING
#define LCOR_API __declspec(dllexport)
#else
#define LCOR_API __declspec(dllimport)
#endif
#elif defined(__GNUC__)
#define LCOR_API __attribute__((visibility("default")))
#else
#define LCOR_API
#endif

#endif
