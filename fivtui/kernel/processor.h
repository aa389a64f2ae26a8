/* The best instruction set of this processor among those for which the kernel is compiled. */

#ifndef FIVTUI_PROCESSOR_H
#define FIVTUI_PROCESSOR_H

#if defined(__x86_64__) || defined(_M_X64)
#include <cpuid.h>

/* Bits of the sets of registers that the operating system saves (XCR0). */
static unsigned enabled_registers(void)
{
    unsigned low, high;
    __asm__ volatile("xgetbv" : "=a"(low), "=d"(high) : "c"(0));
    (void)high;
    return low;
}

/* Bits of XCR0: SSE and AVX; these and the three sets of AVX-512. */
#define AVX_REGISTERS 0x6u
#define AVX512_REGISTERS 0xe6u
/* Leaves of the instruction CPUID. */
#define FEATURES 1
#define EXTENDED_FEATURES 7
#define FURTHER_FEATURES 0x80000001u

/* Whether all bits are set in a word. */
#define HAS(word, bits) (((word) & (bits)) == (bits))

/* An index of INSTRUCTION_SETS in `fivtui.kernel.native`: 0 for the baseline, 1 for x86-64-v3 (AVX2
   and fused operations), 2 for x86-64-v4 (AVX-512). */
static int instruction_set(void)
{
    /* FMA, MOVBE, OSXSAVE, AVX, F16C; AVX2, BMI1, BMI2; LZCNT; AVX-512 F, DQ, CD, BW, VL. */
    const unsigned avx_bits = 1u << 12 | 1u << 22 | 1u << 27 | 1u << 28 | 1u << 29;
    const unsigned avx2_bits = 1u << 5 | 1u << 3 | 1u << 8, lzcnt_bits = 1u << 5;
    const unsigned avx512_bits = 1u << 16 | 1u << 17 | 1u << 28 | 1u << 30 | 1u << 31;
    unsigned a, b, c, d, extended_b;
    if (!__get_cpuid(FEATURES, &a, &b, &c, &d) || !HAS(c, avx_bits)
        || !HAS(enabled_registers(), AVX_REGISTERS))
        return 0;
    if (!__get_cpuid_count(EXTENDED_FEATURES, 0, &a, &extended_b, &c, &d)
        || !HAS(extended_b, avx2_bits))
        return 0;
    if (!__get_cpuid(FURTHER_FEATURES, &a, &b, &c, &d) || !HAS(c, lzcnt_bits))
        return 0;
    return HAS(extended_b, avx512_bits) && HAS(enabled_registers(), AVX512_REGISTERS) ? 2 : 1;
}
#else
static int instruction_set(void) { return 0; }
#endif

#endif
