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

/* WIDE: the loops of kernel_template.h of a set. NARROW: those of the other templates, which
 * AVX-512 takes from AVX2. Assigned by code, as each address in a table costs 32 bytes in a shared
 * library.
 */
#define WIDE(set)                                                                                  \
    static LCOR_COLD void wide_##set(lcor_kernel *k)                                               \
    {                                                                                              \
        k->name = #set;                                                                            \
        k->lightness = lightness_##set;                                                            \
        k->g = g_##set;                                                                            \
        k->chroma = chroma_##set;                                                                  \
    }

#define NARROW(set)                                                                                \
    static LCOR_COLD void narrow_all_##set(lcor_kernel *k)                                         \
    {                                                                                              \
        k->maps = maps_##set;                                                                      \
        k->power = power_##set;                                                                    \
        k->from_srgb = from_srgb_##set;                                                            \
        k->to_srgb = to_srgb_##set;                                                                \
        k->lightness_of_planes = lightness_of_planes_##set;                                        \
        k->lightness_of_bytes = lightness_of_bytes_##set;                                          \
        k->lightness_of_f = lightness_of_f_##set;                                                  \
        k->count = count_##set;                                                                    \
        k->find_outside = find_outside_##set;                                                      \
        k->clamp_planes = clamp_planes_##set;                                                      \
        k->interleave = interleave_##set;                                                          \
        k->interleave_bytes = interleave_bytes_##set;                                              \
        k->widen = widen_##set;                                                                    \
        k->narrow = narrow_##set;                                                                  \
        k->lanes_to_f = lanes_to_f_##set;                                                          \
        k->lanes_to_rgb = lanes_to_rgb_##set;                                                      \
    }

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
WIDE(base)
NARROW(base)
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
WIDE(avx2)
NARROW(avx2)
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
WIDE(avx512)
#undef ISA
#undef G_BLACK
#undef TARGET

#undef POOR
#endif

LCOR_COLD int lcor_internal_kernel(size_t index, lcor_kernel *kernel)
{
#ifdef LCOR_HAVE_X86
    const lcor_cpu cpu = lcor_internal_cpu();

    narrow_all_avx2(kernel);
    if (cpu.avx512 && index-- == 0) {
        wide_avx512(kernel);
        return 1;
    }
    if (cpu.avx2 && index-- == 0) {
        wide_avx2(kernel);
        return 1;
    }
#endif
    narrow_all_base(kernel);
    wide_base(kernel);
    return index == 0;
}
