/* SPDX-License-Identifier: MIT */
/* Which vector instructions this processor has and its system keeps. No fused multiply-add is among
 * them: code for them gives the same bits as any other. */
#ifndef LCOR_BASE_CPU_H
#define LCOR_BASE_CPU_H

#if defined(__x86_64__) && defined(__GNUC__)
#define LCOR_HAVE_X86
#endif

typedef struct lcor_cpu {
    int avx2;
    int avx512; /* F, DQ, BW and VL */
} lcor_cpu;

lcor_cpu lcor_internal_cpu(void);

#endif
