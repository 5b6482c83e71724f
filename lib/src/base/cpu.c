/* SPDX-License-Identifier: MIT */
#include "base/cpu.h"

#ifdef LCOR_HAVE_X86
#include <cpuid.h>

/* Sets of vector registers the operating system saves (XCR0): 0 without AVX. */
static unsigned saved_state(unsigned ecx_of_leaf_1)
{
    unsigned low = 0, high;

    if (ecx_of_leaf_1 & bit_OSXSAVE)
        __asm__("xgetbv" : "=a"(low), "=d"(high) : "c"(0));
    return low;
}

lcor_cpu lcor_internal_cpu(void)
{
    const unsigned avx512 = bit_AVX512F | bit_AVX512DQ | bit_AVX512BW | bit_AVX512VL;
    unsigned a, b = 0, c = 0, d, state;
    lcor_cpu cpu = {0, 0};

    if (!__get_cpuid(1, &a, &b, &c, &d))
        return cpu;
    state = saved_state(c);
    if ((state & 0x06) != 0x06 || !__get_cpuid_count(7, 0, &a, &b, &c, &d))
        return cpu;
    cpu.avx2 = (b & bit_AVX2) != 0;
    cpu.avx512 = (state & 0xE6) == 0xE6 && (b & avx512) == avx512;
    return cpu;
}

#else

lcor_cpu lcor_internal_cpu(void)
{
    const lcor_cpu none = {0, 0};

    return none;
}

#endif
