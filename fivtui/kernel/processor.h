/* The best instruction set of this processor among those for which the kernel is compiled. */

#ifndef FIVTUI_PROCESSOR_H
#define FIVTUI_PROCESSOR_H

#if defined(__x86_64__) || defined(_M_X64)
#include <cpuid.h>

static unsigned enabled_registers(void)
{
    unsigned low, high;
    __asm__ volatile("xgetbv" : "=a"(low), "=d"(high) : "c"(0));
    (void)high;
    return low;
}

#define HAS(word, bits) (((word) & (bits)) == (bits))

/* 0: baseline, 1: x86-64-v3 (AVX2 and fused operations), 2: x86-64-v4 (AVX-512). */
static int instruction_set(void)
{
    /* FMA, MOVBE, OSXSAVE, AVX, F16C; AVX2, BMI1, BMI2; LZCNT; AVX-512 F, DQ, CD, BW, VL. */
    const unsigned avx_bits = 1u << 12 | 1u << 22 | 1u << 27 | 1u << 28 | 1u << 29;
    const unsigned avx2_bits = 1u << 5 | 1u << 3 | 1u << 8, lzcnt_bits = 1u << 5;
    const unsigned avx512_bits = 1u << 16 | 1u << 17 | 1u << 28 | 1u << 30 | 1u << 31;
    unsigned a, b, c, d, extended_b;
    if (!__get_cpuid(1, &a, &b, &c, &d) || !HAS(c, avx_bits) || !HAS(enabled_registers(), 0x6u))
        return 0;
    if (!__get_cpuid_count(7, 0, &a, &extended_b, &c, &d) || !HAS(extended_b, avx2_bits))
        return 0;
    if (!__get_cpuid(0x80000001u, &a, &b, &c, &d) || !HAS(c, lzcnt_bits))
        return 0;
    return HAS(extended_b, avx512_bits) && HAS(enabled_registers(), 0xe6u) ? 2 : 1;
}
#else
static int instruction_set(void) { return 0; }
#endif

#endif
