/* SPDX-License-Identifier: MIT */
/* The float path for each instruction set this compiler can aim at, and the choice at run time. */
#include "correct/lanes.h"
#include "correct/sample.h"

#include "base/cpu.h"
#include "base/internal.h"
#include "colour/internal.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* A loop over a block. Known to be short, it would be unrolled to many times its size for nothing.
 */
#if defined(__clang__)
#define EACH(j, n)                                                                                 \
    _Pragma("clang loop unroll(disable)") for (size_t j = 0; (j) < (size_t)(n); (j)++)
#elif defined(__GNUC__)
#define EACH(j, n) _Pragma("GCC unroll 1") for (size_t j = 0; (j) < (size_t)(n); (j)++)
#else
#define EACH(j, n) for (size_t j = 0; (j) < (size_t)(n); (j)++)
#endif

/* A loop that only moves pixels, where counting would cost as much. */
#if defined(__clang__)
#define MOVE_EACH(j, n)                                                                            \
    _Pragma("clang loop unroll_count(4)") for (size_t j = 0; (j) < (size_t)(n); (j)++)
#elif defined(__GNUC__)
#define MOVE_EACH(j, n) _Pragma("GCC unroll 4") for (size_t j = 0; (j) < (size_t)(n); (j)++)
#else
#define MOVE_EACH(j, n) EACH (j, n)
#endif

/* What numbers are kept above or below. */
typedef struct limits {
    float zero, one, tiny, huge;
    float knee, f_knee; /* of eqs 2-4: (6/29)^3 and 6/29 */
    float near_white;
} limits;

#define LIMITS                                                                                     \
    {                                                                                              \
        0.0f, 1.0f, 1e-30f, 1e30f, 0.00885645207f, 0.206896558f, 1e-9f                             \
    }

#define INNER static TARGET LCOR_INLINE
#define STAGE static TARGET LCOR_APART /* one copy: the code stays small */

/* The table of one set; `few` is the set whose narrow_template.h and lanes_template.h it takes. */
#define KERNEL(set, few)                                                                           \
    static const lcor_kernel kernel_##set = {#set,                                                 \
                                             maps_##few,                                           \
                                             power_##few,                                          \
                                             from_srgb_##few,                                      \
                                             to_srgb_##few,                                        \
                                             lightness_##set,                                      \
                                             lightness_of_planes_##few,                            \
                                             lightness_of_bytes_##few,                             \
                                             lightness_of_f_##few,                                 \
                                             count_##few,                                          \
                                             g_##set,                                              \
                                             chroma_##set,                                         \
                                             find_outside_##few,                                   \
                                             clamp_planes_##few,                                   \
                                             interleave_##few,                                     \
                                             interleave_bytes_##few,                               \
                                             widen_##few,                                          \
                                             narrow_##few,                                         \
                                             lanes_to_f_##few,                                     \
                                             lanes_to_rgb_##few};

/* What every processor of the architecture has: SSE2 on x86-64, NEON on aarch64, or plain C. */
#define ISA(name) name##_base
#define TARGET
#if defined(__SSE2__) && !defined(__SSE4_1__)
#define POOR 1
#else
#define POOR 0
#endif
#include "correct/kernel_arithmetic.h"
#include "correct/kernel_template.h"
#include "correct/lanes_template.h"
#include "correct/narrow_template.h"
KERNEL(base, base)
#undef ISA
#undef G_BLACK
#undef TARGET
#undef POOR

#ifdef LCOR_HAVE_X86
#define POOR 0

#define ISA(name) name##_avx2
#define TARGET    __attribute__((target("avx2")))
#include "correct/kernel_arithmetic.h"
#include "correct/kernel_template.h"
#include "correct/lanes_template.h"
#include "correct/narrow_template.h"
KERNEL(avx2, avx2)
#undef ISA
#undef G_BLACK
#undef TARGET

#define ISA(name) name##_avx512
#if defined(__clang__)
#define TARGET __attribute__((target("avx512f,avx512bw,avx512dq,avx512vl")))
#else
#define TARGET __attribute__((target("avx512f,avx512bw,avx512dq,avx512vl,prefer-vector-width=512")))
#endif
#include "correct/kernel_arithmetic.h"
#include "correct/kernel_template.h"
KERNEL(avx512, avx2)
#undef ISA
#undef G_BLACK
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
