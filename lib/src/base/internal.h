/* SPDX-License-Identifier: MIT */
/* What every module of liblcor shares. Not installed. */
#ifndef LCOR_BASE_INTERNAL_H
#define LCOR_BASE_INTERNAL_H

#include <lcor/alloc.h>
#include <lcor/status.h>

#include <stddef.h>

#ifdef __FAST_MATH__
#error "lcor needs IEEE arithmetic: build without -ffast-math"
#endif

#if defined(__GNUC__)
#define LCOR_PRINTF(format_at, args_at) __attribute__((format(printf, format_at, args_at)))
#else
#define LCOR_PRINTF(format_at, args_at)
#endif

/* Print drivers count bytes. APART: one copy is enough. COLD: runs once a page, make it small. */
#if defined(__clang__)
#define LCOR_APART __attribute__((noinline))
#define LCOR_COLD  __attribute__((cold))
#elif defined(__GNUC__)
#define LCOR_APART __attribute__((noinline, noclone))
#define LCOR_COLD  __attribute__((cold))
#else
#define LCOR_APART
#define LCOR_COLD
#endif

/* Loops that are compiled once per instruction set must follow their caller's. */
#if defined(__GNUC__)
#define LCOR_INLINE inline __attribute__((always_inline))
#else
#define LCOR_INLINE inline
#endif

/* Fill *err (may be NULL) and return `status`, so that a failure is one return statement.
 * `where` is the index of the offending item or line, or -1. Formats may print integers and
 * strings only: floating-point conversions follow the host's locale. */
lcor_status lcor_internal_fail(lcor_error *err, lcor_status status, long where, const char *format,
                               ...) LCOR_PRINTF(4, 5);

/* The caller's allocator, or malloc and free for NULL or an all-NULL one.
 * LCOR_ERR_ARG if only one of the two functions is there. */
lcor_status lcor_internal_allocator(const lcor_allocator *given, lcor_allocator *out,
                                    lcor_error *err);
void *lcor_internal_alloc(const lcor_allocator *allocator, size_t size);
void lcor_internal_free(const lcor_allocator *allocator, void *ptr); /* NULL does nothing */

/* *out = a * b or a + b; 0 if that does not fit size_t (and *out is left alone), else 1. */
int lcor_internal_size_mul(size_t a, size_t b, size_t *out);
int lcor_internal_size_add(size_t a, size_t b, size_t *out);

#endif
