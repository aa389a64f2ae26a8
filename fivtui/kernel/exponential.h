/* The exponential function by arithmetic alone: as in `fivtui.model.field`. */

#ifndef FIVTUI_EXPONENTIAL_H
#define FIVTUI_EXPONENTIAL_H

#include "vector.h"

#define LN2_HIGH 6.93147180369123816490e-01
#define LN2_LOW 1.90821492927058770002e-10
#define LOG2_E 1.44269504088896338700
#define MOST_EXPONENT 700.0
static const double FACTORIAL[] = {
    1.0, 1.0, 2.0, 6.0, 24.0, 120.0, 720.0, 5040.0, 40320.0, 362880.0, 3628800.0, 39916800.0,
    479001600.0, 6227020800.0, 87178291200.0, 1307674368000.0, 20922789888000.0,
    355687428096000.0, 6402373705728000.0, 121645100408832000.0, 2432902008176640000.0,
    51090942171709440000.0,
};

/* Zero from −700 down, and not more than exp(700). */
INLINE V exponential(V exponent)
{
    const double whole = 0x1.8p52;
    M some = exponent > -MOST_EXPONENT;
    V above = choose(some, least(exponent, splat(MOST_EXPONENT)), splat(-MOST_EXPONENT));
    V count = (whole + above * LOG2_E) - whole;
    V rest = fma_of(count, splat(-LN2_LOW), fma_of(count, splat(-LN2_HIGH), above));
    V square = rest * rest, fourth = square * square;
    V term[7];
    UNROLLED for (int n = 0; n < 7; n++)
        term[n] = fma_of(rest, splat(1.0 / FACTORIAL[2 * n + 1]), splat(1.0 / FACTORIAL[2 * n]));
    V low = fma_of(fma_of(term[3], square, term[2]), fourth, fma_of(term[1], square, term[0]));
    V high = fma_of(term[6], fourth, fma_of(term[5], square, term[4]));
    V value = fma_of(high, fourth * fourth, low);
    return choose(some, value * from_bits_beyond_one(count * 0x1p52, 1023LL << 52), splat(0.0));
}

#endif
