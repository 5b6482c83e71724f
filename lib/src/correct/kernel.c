/* SPDX-License-Identifier: MIT */
/* The float path for each instruction set this compiler can aim at, and the choice at run time. */
#include "correct/internal.h"
#include "correct/sample.h"

#include "base/cpu.h"
#include "base/internal.h"

#include <string.h>

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
#if defined(__SSE2__) && !defined(__SSE4_1__)
#define POOR 1
#else
#define POOR 0
#endif
#include "correct/kernel_template.h"
#undef ISA
#undef ISA_NAME
#undef TARGET
#undef POOR

#ifdef LCOR_HAVE_X86
#define POOR 0

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

#undef POOR
#endif

const lcor_kernel *lcor_internal_kernel(size_t index)
{
    const lcor_kernel *found[3];
    size_t count = 0;

#ifdef LCOR_HAVE_X86
    const lcor_cpu cpu = lcor_internal_cpu();

    if (cpu.avx512)
        found[count++] = &kernel_avx512;
    if (cpu.avx2)
        found[count++] = &kernel_avx2;
#endif
    found[count++] = &kernel_base;
    return index < count ? found[index] : NULL;
}
