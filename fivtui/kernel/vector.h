/* Numbers of one run, or of LANES runs side by side; a lane is the element of one run.

   A source file defines LANES as 1 or 8 before it includes this header. V (vector) has a number and
   M (mask) a truth value for each run. The operations on an element do not depend on the width, and
   only `vfma` fuses products and sums, so that a run has the same bits everywhere. `v…` functions
   act on each lane: `vfma` is a b + c with one rounding, `choose` is a where the mask is set, else
   b. */

#ifndef FIVTUI_VECTOR_H
#define FIVTUI_VECTOR_H

#include <stdint.h>
#include <string.h>

#define INLINE static inline __attribute__((always_inline))
#define NOINLINE static __attribute__((noinline, unused))

/* Aligns the stack: otherwise half of the vectors of four numbers straddle cache lines. */
#if LANES == 1 && defined(__x86_64__)
#define ALIGN_STACK __attribute__((force_align_arg_pointer))
#else
#define ALIGN_STACK
#endif

/* a b + c with one rounding, and a loop to be unrolled. */
#ifdef __clang__
#define FMA(a, b, c) __builtin_elementwise_fma(a, b, c)
#define UNROLL _Pragma("clang loop unroll(full)")
#else
#define FMA(a, b, c) __builtin_fma(a, b, c)
#define UNROLL _Pragma("GCC unroll 24")
#endif

/* The bits of a number. */
typedef union {
    double number;
    int64_t bits;
} Bits;

/* The bits of 1.0, read as an integer. Adding n 2⁵² to the bits of a number multiplies it by 2ⁿ. */
#define BITS_OF_ONE (1023LL << 52)
/* The exponent 1 of a power of 2 as `bit_difference` and `number_from_bits` count exponents. */
#define EXPONENT_ONE 0x1p52

INLINE double minimum(double a, double b) { return a < b ? a : b; }
INLINE double maximum(double a, double b) { return a > b ? a : b; }
INLINE int is_finite_number(double a) { return a - a == 0.0; }

#if LANES == 1

#define ALL_LANES 1
typedef double V;
typedef int M;

INLINE V splat(double a) { return a; }
INLINE V vfma(V a, V b, V c) { return FMA(a, b, c); }
INLINE V choose(M m, V a, V b) { return m ? a : b; }
INLINE M mask_not(M m) { return !m; }
INLINE unsigned mask_bits(M m) { return (unsigned)m; }
INLINE M mask_from_bits(unsigned bits) { return (M)(bits & 1u); }
INLINE V vabs(V a) { return __builtin_fabs(a); }
INLINE V vsqrt(V a) { return __builtin_sqrt(a); }
INLINE double get_lane(const V *a, int lane) { (void)lane; return *a; }
INLINE void set_lane(V *a, int lane, double value) { (void)lane; *a = value; }

/* About EXPONENT_ONE log₂(a/b) for positive numbers: the difference of their bits as integers. */
INLINE V bit_difference(V a, V b)
{
    Bits first = {a}, second = {b};
    return (double)(int64_t)((uint64_t)first.bits - (uint64_t)second.bits);
}

/* The number whose bits, read as an integer, are `bits` + `offset`. */
INLINE V number_from_bits(V bits, int64_t offset)
{
    Bits result;
    result.bits = (int64_t)bits + offset;
    return result.number;
}

#else

/* Bits of the eight lanes. */
#define ALL_LANES 255u
typedef double V __attribute__((vector_size(64), may_alias));
typedef long long M __attribute__((vector_size(64), may_alias));
typedef unsigned long long Unsigned __attribute__((vector_size(64), may_alias));

/* The same number in all lanes: operators extend a scalar to a vector. */
INLINE V splat(double a) { return a - (V){0}; }
INLINE V choose(M m, V a, V b) { return (V)(((M)a & m) | ((M)b & ~m)); }
INLINE M mask_not(M m) { return ~m; }
INLINE V vabs(V a) { return (V)((M)a & INT64_MAX); }
INLINE double get_lane(const V *a, int lane) { return ((const double *)a)[lane]; }
INLINE void set_lane(V *a, int lane, double value) { ((double *)a)[lane] = value; }

#ifdef __clang__
typedef _Bool Flags __attribute__((ext_vector_type(8)));
INLINE V vfma(V a, V b, V c) { return FMA(a, b, c); }
INLINE V vsqrt(V a) { return __builtin_elementwise_sqrt(a); }
INLINE V bit_difference(V a, V b)
{
    return __builtin_convertvector((M)((Unsigned)a - (Unsigned)b), V);
}
INLINE V number_from_bits(V bits, int64_t offset)
{
    return (V)(__builtin_convertvector(bits, M) + offset);
}
INLINE unsigned mask_bits(M m)
{
    Flags flags = __builtin_convertvector(m, Flags);
    uint8_t bits;
    memcpy(&bits, &flags, 1);
    return bits;
}
INLINE M mask_from_bits(unsigned bits)
{
    const M lane_bits = {1, 2, 4, 8, 16, 32, 64, 128};
    return (((long long)bits - (M){0}) & lane_bits) != 0;
}
#else
INLINE V vfma(V a, V b, V c)
{
    V result;
    for (int i = 0; i < LANES; i++)
        result[i] = FMA(a[i], b[i], c[i]);
    return result;
}
INLINE V vsqrt(V a)
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
INLINE V number_from_bits(V bits, int64_t offset)
{
    M result;
    for (int i = 0; i < LANES; i++)
        result[i] = (int64_t)bits[i] + offset;
    return (V)result;
}
INLINE unsigned mask_bits(M m)
{
    unsigned bits = 0;
    for (int i = 0; i < LANES; i++)
        bits |= (unsigned)(m[i] & 1) << i;
    return bits;
}
INLINE M mask_from_bits(unsigned bits)
{
    const M lane_bits = {1, 2, 4, 8, 16, 32, 64, 128};
    return (((long long)bits - (M){0}) & lane_bits) != 0;
}
#endif
#endif

INLINE V vmin(V a, V b) { return choose(a < b, a, b); }
INLINE V vmax(V a, V b) { return choose(a > b, a, b); }

/* Four terms of a polynomial, or four partial sums. Functions in `_by` have a scalar factor. */
#if LANES == 1
typedef double Four __attribute__((vector_size(32), may_alias));
typedef double FourPacked __attribute__((vector_size(32), aligned(8), may_alias));

INLINE Four load_four(const V *c) { return *(const FourPacked *)c; }
INLINE Four four_times(Four a, const double *w) { return a * *(const FourPacked *)w; }
INLINE Four four_abs(Four a)
{
    typedef long long Mask4 __attribute__((vector_size(32)));
    return (Four)((Mask4)a & INT64_MAX);
}
#ifdef __clang__
INLINE Four four_fma_by(Four a, V s, Four b) { return FMA(a, s - (Four){0}, b); }
#else
INLINE Four four_fma_by(Four a, V s, Four b)
{
    for (int i = 0; i < 4; i++)
        b[i] = FMA(a[i], s, b[i]);
    return b;
}
#endif
#define FOUR_ITEM(a, i) ((a)[i])
#else
typedef struct {
    V e[4];
} Four;

INLINE Four load_four(const V *c) { return (Four){{c[0], c[1], c[2], c[3]}}; }
INLINE Four four_times(Four a, const double *w)
{
    return (Four){{a.e[0] * w[0], a.e[1] * w[1], a.e[2] * w[2], a.e[3] * w[3]}};
}
INLINE Four four_abs(Four a)
{
    return (Four){{vabs(a.e[0]), vabs(a.e[1]), vabs(a.e[2]), vabs(a.e[3])}};
}
INLINE Four four_fma_by(Four a, V s, Four b)
{
    return (Four){{vfma(a.e[0], s, b.e[0]), vfma(a.e[1], s, b.e[1]),
                   vfma(a.e[2], s, b.e[2]), vfma(a.e[3], s, b.e[3])}};
}
#define FOUR_ITEM(a, i) ((a).e[i])
#endif

/* a₀ + a₁ t + a₂ t² + a₃ t³ */
INLINE V cubic_value(Four a, V t, V square)
{
    V low = vfma(FOUR_ITEM(a, 1), t, FOUR_ITEM(a, 0)),
        high = vfma(FOUR_ITEM(a, 3), t, FOUR_ITEM(a, 2));
    return vfma(high, square, low);
}

/* A pair of x and y. */
#if LANES == 1
typedef double Pair __attribute__((vector_size(16), may_alias));
INLINE Pair make_pair(V x, V y) { return (Pair){x, y}; }
INLINE Pair pair_times(Pair a, V s) { return a * s; }
INLINE Pair pair_product(Pair a, Pair b) { return a * b; }
INLINE Pair pair_sum(Pair a, Pair b) { return a + b; }
#define PAIR_X(a) ((a)[0])
#define PAIR_Y(a) ((a)[1])
#ifdef __clang__
INLINE Pair pair_fma(Pair a, Pair b, Pair c) { return FMA(a, b, c); }
INLINE Pair pair_fma_by(Pair a, V s, Pair c) { return FMA(a, s - (Pair){0}, c); }
#else
INLINE Pair pair_fma(Pair a, Pair b, Pair c)
{
    return (Pair){FMA(a[0], b[0], c[0]), FMA(a[1], b[1], c[1])};
}
INLINE Pair pair_fma_by(Pair a, V s, Pair c)
{
    return (Pair){FMA(a[0], s, c[0]), FMA(a[1], s, c[1])};
}
#endif
#else
typedef struct {
    V x, y;
} Pair;
INLINE Pair make_pair(V x, V y) { return (Pair){x, y}; }
INLINE Pair pair_times(Pair a, V s) { return (Pair){a.x * s, a.y * s}; }
INLINE Pair pair_product(Pair a, Pair b) { return (Pair){a.x * b.x, a.y * b.y}; }
INLINE Pair pair_sum(Pair a, Pair b) { return (Pair){a.x + b.x, a.y + b.y}; }
INLINE Pair pair_fma(Pair a, Pair b, Pair c)
{
    return (Pair){vfma(a.x, b.x, c.x), vfma(a.y, b.y, c.y)};
}
INLINE Pair pair_fma_by(Pair a, V s, Pair c)
{
    return (Pair){vfma(a.x, s, c.x), vfma(a.y, s, c.y)};
}
#define PAIR_X(a) ((a).x)
#define PAIR_Y(a) ((a).y)
#endif

/* Two pairs side by side. */
#if LANES == 1
INLINE Four join_pairs(Pair a, Pair b) { return (Four){a[0], a[1], b[0], b[1]}; }
INLINE Pair first_pair(Four a) { return (Pair){a[0], a[1]}; }
INLINE Pair second_pair(Four a) { return (Pair){a[2], a[3]}; }
INLINE Four four_product(Four a, Four b) { return a * b; }
#ifdef __clang__
INLINE Four four_fma(Four a, Four b, Four c) { return FMA(a, b, c); }
#else
INLINE Four four_fma(Four a, Four b, Four c)
{
    for (int i = 0; i < 4; i++)
        c[i] = FMA(a[i], b[i], c[i]);
    return c;
}
#endif
#else
INLINE Four join_pairs(Pair a, Pair b) { return (Four){{a.x, a.y, b.x, b.y}}; }
INLINE Pair first_pair(Four a) { return (Pair){a.e[0], a.e[1]}; }
INLINE Pair second_pair(Four a) { return (Pair){a.e[2], a.e[3]}; }
INLINE Four four_product(Four a, Four b)
{
    return (Four){{a.e[0] * b.e[0], a.e[1] * b.e[1], a.e[2] * b.e[2], a.e[3] * b.e[3]}};
}
INLINE Four four_fma(Four a, Four b, Four c)
{
    return (Four){{vfma(a.e[0], b.e[0], c.e[0]), vfma(a.e[1], b.e[1], c.e[1]),
                   vfma(a.e[2], b.e[2], c.e[2]), vfma(a.e[3], b.e[3], c.e[3])}};
}
#endif

#endif
