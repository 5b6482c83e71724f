/* SPDX-License-Identifier: MIT */
/* The float path for each instruction set this compiler can aim at, and the choice at run time. */
#include "correct/internal.h"
#include "correct/sample.h"

#include "base/internal.h"

#include <string.h>

#if defined(__x86_64__) && defined(__GNUC__)
#define LCOR_HAVE_X86
#include <cpuid.h>
#endif

#if defined(__GNUC__)
#define LCOR_INLINE inline __attribute__((always_inline))
#else
#define LCOR_INLINE inline
#endif

/* A loop over a block. Known to be short, it would be unrolled to many times its size for nothing.
 */
#if defined(__clang__)
#define EACH(j, n) _Pragma("clang loop unroll(disable)") for (size_t j = 0; j < (size_t)(n); j++)
#elif defined(__GNUC__)
#define EACH(j, n) _Pragma("GCC unroll 1") for (size_t j = 0; j < (size_t)(n); j++)
#else
#define EACH(j, n) for (size_t j = 0; j < (size_t)(n); j++)
#endif

/* What every processor of the architecture has: SSE2 on x86-64, NEON on aarch64, or plain C. */
#define ISA(name) name##_base
#define ISA_NAME  "base"
#define TARGET
#define INT_ORDER 1
#include "correct/kernel_template.h"
#undef ISA
#undef ISA_NAME
#undef TARGET

#ifdef LCOR_HAVE_X86

#define ISA(name) name##_avx2
#define ISA_NAME  "avx2"
#define TARGET    __attribute__((target("avx2")))
#include "correct/kernel_template.h"
#undef ISA
#undef ISA_NAME
#undef TARGET

#define ISA(name) name##_avx512
#define ISA_NAME  "avx512"
#if defined(__clang__)
#define TARGET __attribute__((target("avx512f,avx512bw,avx512dq,avx512vl")))
#else
#define TARGET __attribute__((target("avx512f,avx512bw,avx512dq,avx512vl,prefer-vector-width=512")))
#endif
#include "correct/kernel_template.h"
#undef ISA
#undef ISA_NAME
#undef TARGET

#undef INT_ORDER
#endif

#ifdef LCOR_HAVE_X86

/* Sets of vector registers the operating system saves (XCR0): 0 without AVX. */
static unsigned saved_state(unsigned ecx_of_leaf_1)
{
    unsigned low = 0, high;

    if (ecx_of_leaf_1 & bit_OSXSAVE)
        __asm__("xgetbv" : "=a"(low), "=d"(high) : "c"(0));
    return low;
}

static void find_sets(int *has_avx2, int *has_avx512)
{
    const unsigned avx512 = bit_AVX512F | bit_AVX512DQ | bit_AVX512BW | bit_AVX512VL;
    unsigned a, b = 0, c = 0, d, state;

    *has_avx2 = *has_avx512 = 0;
    if (!__get_cpuid(1, &a, &b, &c, &d))
        return;
    state = saved_state(c);
    if ((state & 0x06) != 0x06 || !__get_cpuid_count(7, 0, &a, &b, &c, &d))
        return;
    *has_avx2 = (b & bit_AVX2) != 0;
    *has_avx512 = (state & 0xE6) == 0xE6 && (b & avx512) == avx512;
}

#endif

const lcor_kernel *lcor_internal_kernel(size_t index)
{
    const lcor_kernel *found[3];
    size_t count = 0;

#ifdef LCOR_HAVE_X86
    int has_avx2, has_avx512;

    find_sets(&has_avx2, &has_avx512);
    if (has_avx512)
        found[count++] = &kernel_avx512;
    if (has_avx2)
        found[count++] = &kernel_avx2;
#endif
    found[count++] = &kernel_base;
    return index < count ? found[index] : NULL;
}
