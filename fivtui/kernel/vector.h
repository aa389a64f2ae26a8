/* Numbers of one run, or of LANES runs side by side: one text for both widths.

   A source file defines LANES as 1 or 8 before it includes this. V is a number of every run and M
   a truth value of every run. Each element goes through the same operations whatever the width,
   and products and sums are fused only by `fma_of`, so that a run has the same bits everywhere. */

#ifndef FIVTUI_VECTOR_H
#define FIVTUI_VECTOR_H

#include <stdint.h>
#include <string.h>

#define INLINE static inline __attribute__((always_inline))
#define APART static __attribute__((noinline, unused))

/* Where runs of four numbers are kept on a stack that is not aligned to them, half of them lie on two
   lines of the cache. */
#if LANES == 1 && defined(__x86_64__)
#define ON_ALIGNED_STACK __attribute__((force_align_arg_pointer))
#else
#define ON_ALIGNED_STACK
#endif

#ifdef __clang__
#define FUSED(a, b, c) __builtin_elementwise_fma(a, b, c)
#define UNROLLED _Pragma("clang loop unroll(full)")
#else
#define FUSED(a, b, c) __builtin_fma(a, b, c)
#define UNROLLED _Pragma("GCC unroll 24")
#endif

typedef union {
    double number;
    int64_t bits;
} Bits;

INLINE double smaller(double a, double b) { return a < b ? a : b; }
INLINE double larger(double a, double b) { return a > b ? a : b; }
INLINE int finite_number(double a) { return a - a == 0.0; }

#if LANES == 1

#define ALL_LANES 1
typedef double V;
typedef int M;

INLINE V splat(double a) { return a; }
INLINE V fma_of(V a, V b, V c) { return FUSED(a, b, c); }
INLINE V choose(M m, V a, V b) { return m ? a : b; }
INLINE M negated(M m) { return !m; }
INLINE unsigned bits_of(M m) { return (unsigned)m; }
INLINE M mask_of(unsigned bits) { return (M)(bits & 1u); }
INLINE V absolute(V a) { return __builtin_fabs(a); }
INLINE V root_of(V a) { return __builtin_sqrt(a); }
INLINE double element(const V *a, int lane) { (void)lane; return *a; }
INLINE void put(V *a, int lane, double value) { (void)lane; *a = value; }

/* The difference of the bits of two positive numbers, read as integers: 2⁵² times what straight
   lines between powers of two make of the logarithm of their ratio. */
INLINE V bit_difference(V a, V b)
{
    Bits one = {a}, other = {b};
    return (double)(int64_t)((uint64_t)one.bits - (uint64_t)other.bits);
}

/* The number whose bits are those of 1 and so many more. */
INLINE V from_bits_beyond_one(V more, int64_t shift)
{
    Bits result;
    result.bits = (int64_t)more + shift;
    return result.number;
}

#else

#define ALL_LANES 255u
typedef double V __attribute__((vector_size(64), may_alias));
typedef long long M __attribute__((vector_size(64), may_alias));
typedef unsigned long long Unsigned __attribute__((vector_size(64), may_alias));

INLINE V splat(double a) { return a - (V){0}; }
INLINE V choose(M m, V a, V b) { return (V)(((M)a & m) | ((M)b & ~m)); }
INLINE M negated(M m) { return ~m; }
INLINE V absolute(V a) { return (V)((M)a & INT64_MAX); }
INLINE double element(const V *a, int lane) { return ((const double *)a)[lane]; }
INLINE void put(V *a, int lane, double value) { ((double *)a)[lane] = value; }

#ifdef __clang__
typedef _Bool Flags __attribute__((ext_vector_type(8)));
INLINE V fma_of(V a, V b, V c) { return FUSED(a, b, c); }
INLINE V root_of(V a) { return __builtin_elementwise_sqrt(a); }
INLINE V bit_difference(V a, V b)
{
    return __builtin_convertvector((M)((Unsigned)a - (Unsigned)b), V);
}
INLINE V from_bits_beyond_one(V more, int64_t shift)
{
    return (V)(__builtin_convertvector(more, M) + shift);
}
INLINE unsigned bits_of(M m)
{
    Flags flags = __builtin_convertvector(m, Flags);
    uint8_t bits;
    memcpy(&bits, &flags, 1);
    return bits;
}
INLINE M mask_of(unsigned bits)
{
    const M one = {1, 2, 4, 8, 16, 32, 64, 128};
    return (((long long)bits - (M){0}) & one) != 0;
}
#else
INLINE V fma_of(V a, V b, V c)
{
    V result;
    for (int i = 0; i < LANES; i++)
        result[i] = FUSED(a[i], b[i], c[i]);
    return result;
}
INLINE V root_of(V a)
{
    for (int i = 0; i < LANES; i++)
        a[i] = __builtin_sqrt(a[i]);
    return a;
}
INLINE V bit_difference(V a, V b)
{
    M d = (M)((Unsigned)a - (Unsigned)b);
    V result;
    for (int i = 0; i < LANES; i++)
        result[i] = (double)d[i];
    return result;
}
INLINE V from_bits_beyond_one(V more, int64_t shift)
{
    M result;
    for (int i = 0; i < LANES; i++)
        result[i] = (int64_t)more[i] + shift;
    return (V)result;
}
INLINE unsigned bits_of(M m)
{
    unsigned bits = 0;
    for (int i = 0; i < LANES; i++)
        bits |= (unsigned)(m[i] & 1) << i;
    return bits;
}
INLINE M mask_of(unsigned bits)
{
    const M one = {1, 2, 4, 8, 16, 32, 64, 128};
    return (((long long)bits - (M){0}) & one) != 0;
}
#endif
#endif

INLINE V least(V a, V b) { return choose(a < b, a, b); }
INLINE V greatest(V a, V b) { return choose(a > b, a, b); }

/* Four terms of a polynomial, or the sums of four chains of them. */
#if LANES == 1
typedef double Four __attribute__((vector_size(32), may_alias));
typedef double FourPacked __attribute__((vector_size(32), aligned(8), may_alias));

INLINE Four four_at(const V *c) { return *(const FourPacked *)c; }
INLINE Four four_scaled(Four a, const double *w) { return a * *(const FourPacked *)w; }
INLINE Four four_absolute(Four a)
{
    typedef long long Mask4 __attribute__((vector_size(32)));
    return (Four)((Mask4)a & INT64_MAX);
}
#ifdef __clang__
INLINE Four four_fma(Four a, V s, Four b) { return FUSED(a, s - (Four){0}, b); }
#else
INLINE Four four_fma(Four a, V s, Four b)
{
    for (int i = 0; i < 4; i++)
        b[i] = FUSED(a[i], s, b[i]);
    return b;
}
#endif
#define PART(a, i) ((a)[i])
#else
typedef struct {
    V e[4];
} Four;

INLINE Four four_at(const V *c) { return (Four){{c[0], c[1], c[2], c[3]}}; }
INLINE Four four_scaled(Four a, const double *w)
{
    return (Four){{a.e[0] * w[0], a.e[1] * w[1], a.e[2] * w[2], a.e[3] * w[3]}};
}
INLINE Four four_absolute(Four a)
{
    return (Four){{absolute(a.e[0]), absolute(a.e[1]), absolute(a.e[2]), absolute(a.e[3])}};
}
INLINE Four four_fma(Four a, V s, Four b)
{
    return (Four){{fma_of(a.e[0], s, b.e[0]), fma_of(a.e[1], s, b.e[1]),
                   fma_of(a.e[2], s, b.e[2]), fma_of(a.e[3], s, b.e[3])}};
}
#define PART(a, i) ((a).e[i])
#endif

/* a₀ + a₁ t + a₂ t² + a₃ t³ */
INLINE V folded(Four a, V t, V square)
{
    V low = fma_of(PART(a, 1), t, PART(a, 0)), high = fma_of(PART(a, 3), t, PART(a, 2));
    return fma_of(high, square, low);
}

/* A pair of x and y. */
#if LANES == 1
typedef double Pair __attribute__((vector_size(16), may_alias));
INLINE Pair pair_of(V x, V y) { return (Pair){x, y}; }
INLINE Pair pair_times(Pair a, V s) { return a * s; }
INLINE Pair pair_product(Pair a, Pair b) { return a * b; }
INLINE Pair pair_sum(Pair a, Pair b) { return a + b; }
#define X_OF(a) ((a)[0])
#define Y_OF(a) ((a)[1])
#ifdef __clang__
INLINE Pair pair_fma(Pair a, Pair b, Pair c) { return FUSED(a, b, c); }
INLINE Pair pair_fma_by(Pair a, V s, Pair c) { return FUSED(a, s - (Pair){0}, c); }
#else
INLINE Pair pair_fma(Pair a, Pair b, Pair c)
{
    return (Pair){FUSED(a[0], b[0], c[0]), FUSED(a[1], b[1], c[1])};
}
INLINE Pair pair_fma_by(Pair a, V s, Pair c)
{
    return (Pair){FUSED(a[0], s, c[0]), FUSED(a[1], s, c[1])};
}
#endif
#else
typedef struct {
    V x, y;
} Pair;
INLINE Pair pair_of(V x, V y) { return (Pair){x, y}; }
INLINE Pair pair_times(Pair a, V s) { return (Pair){a.x * s, a.y * s}; }
INLINE Pair pair_product(Pair a, Pair b) { return (Pair){a.x * b.x, a.y * b.y}; }
INLINE Pair pair_sum(Pair a, Pair b) { return (Pair){a.x + b.x, a.y + b.y}; }
INLINE Pair pair_fma(Pair a, Pair b, Pair c)
{
    return (Pair){fma_of(a.x, b.x, c.x), fma_of(a.y, b.y, c.y)};
}
INLINE Pair pair_fma_by(Pair a, V s, Pair c)
{
    return (Pair){fma_of(a.x, s, c.x), fma_of(a.y, s, c.y)};
}
#define X_OF(a) ((a).x)
#define Y_OF(a) ((a).y)
#endif

/* Two pairs side by side. */
#if LANES == 1
INLINE Four joined(Pair a, Pair b) { return (Four){a[0], a[1], b[0], b[1]}; }
INLINE Pair first_pair(Four a) { return (Pair){a[0], a[1]}; }
INLINE Pair second_pair(Four a) { return (Pair){a[2], a[3]}; }
INLINE Four four_product(Four a, Four b) { return a * b; }
#ifdef __clang__
INLINE Four four_fma_each(Four a, Four b, Four c) { return FUSED(a, b, c); }
#else
INLINE Four four_fma_each(Four a, Four b, Four c)
{
    for (int i = 0; i < 4; i++)
        c[i] = FUSED(a[i], b[i], c[i]);
    return c;
}
#endif
#else
INLINE Four joined(Pair a, Pair b) { return (Four){{a.x, a.y, b.x, b.y}}; }
INLINE Pair first_pair(Four a) { return (Pair){a.e[0], a.e[1]}; }
INLINE Pair second_pair(Four a) { return (Pair){a.e[2], a.e[3]}; }
INLINE Four four_product(Four a, Four b)
{
    return (Four){{a.e[0] * b.e[0], a.e[1] * b.e[1], a.e[2] * b.e[2], a.e[3] * b.e[3]}};
}
INLINE Four four_fma_each(Four a, Four b, Four c)
{
    return (Four){{fma_of(a.e[0], b.e[0], c.e[0]), fma_of(a.e[1], b.e[1], c.e[1]),
                   fma_of(a.e[2], b.e[2], c.e[2]), fma_of(a.e[3], b.e[3], c.e[3])}};
}
#endif

#endif
