/* SPDX-License-Identifier: MIT */
/* The float path for each instruction set this compiler can aim at, and the choice at run time. */
#include "correct/internal.h"
#include "correct/sample.h"

#include <math.h>
#include <string.h>

#if defined(__GNUC__)
#    define LCOR_INLINE inline __attribute__((always_inline))
#else
#    define LCOR_INLINE inline
#endif

/* What every processor of the architecture has: SSE2 on x86-64, NEON on aarch64, or plain C. */
#define ISA(name) name##_base
#define TARGET
#define INT_ORDER 0
#include "correct/kernel_template.h"
#undef ISA
#undef TARGET
#undef INT_ORDER

#if defined(__x86_64__) && defined(__GNUC__)
#    define LCOR_HAVE_X86

#    define ISA(name) name##_avx2
#    define TARGET    __attribute__((target("avx2")))
#    define INT_ORDER 1
#    include "correct/kernel_template.h"
#    undef ISA
#    undef TARGET

#    define ISA(name) name##_avx512
#    if defined(__clang__)
#        define TARGET __attribute__((target("avx512f,avx512bw,avx512dq,avx512vl")))
#    else
#        define TARGET                                                                            \
            __attribute__((target("avx512f,avx512bw,avx512dq,avx512vl,prefer-vector-width=512")))
#    endif
#    include "correct/kernel_template.h"
#    undef ISA
#    undef TARGET
#    undef INT_ORDER
#endif

static const lcor_kernel base = { "base", row_base, cube_root_base };

#ifdef LCOR_HAVE_X86
static const lcor_kernel avx2 = { "avx2", row_avx2, cube_root_avx2 };
static const lcor_kernel avx512 = { "avx512", row_avx512, cube_root_avx512 };
#endif

const lcor_kernel *lcor_internal_kernel(size_t index)
{
    const lcor_kernel *found[3];
    size_t             count = 0;

#ifdef LCOR_HAVE_X86
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
        __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl"))
        found[count++] = &avx512;
    if (__builtin_cpu_supports("avx2"))
        found[count++] = &avx2;
#endif
    found[count++] = &base;
    return index < count ? found[index] : NULL;
}
