/* The exponential function of one number per run, by the arithmetic of `fivtui.model.field`. V is a
   vector of the numbers of all runs, M a mask with a truth value for each: see vector.h. */

#ifndef FIVTUI_EXPONENTIAL_H
#define FIVTUI_EXPONENTIAL_H

#include "vector.h"

/* ln 2 in two parts, the first short enough that its multiples are exact. */
#define LN2_HIGH 6.93147180369123816490e-01
#define LN2_LOW 1.90821492927058770002e-10
#define LOG2_E 1.44269504088896338700
#define MAX_EXPONENT 700.0
/* n!, for all files that include this one: the series below ends with 13!. */
static const double FACTORIAL[] = {
    1.0, 1.0, 2.0, 6.0, 24.0, 120.0, 720.0, 5040.0, 40320.0, 362880.0, 3628800.0, 39916800.0,
    479001600.0, 6227020800.0, 87178291200.0, 1307674368000.0, 20922789888000.0,
    355687428096000.0, 6402373705728000.0, 121645100408832000.0, 2432902008176640000.0,
    51090942171709440000.0,
};

/* exp(exponent); 0 up to −700, and exp(700) from 700 on. */
INLINE V exponential(V exponent)
{
    /* Adding and subtracting this number rounds to an integer. */
    const double round_shift = 0x1.8p52;
    /* Whether the result is above zero. */
    M is_nonzero = exponent > -MAX_EXPONENT;
    V clamped = choose(is_nonzero, vmin(exponent, splat(MAX_EXPONENT)), splat(-MAX_EXPONENT));
    V count = (round_shift + clamped * LOG2_E) - round_shift;
    /* exp(clamped) = 2^count exp(reduced) with |reduced| ≤ ln 2/2. */
    V reduced = vfma(count, splat(-LN2_LOW), vfma(count, splat(-LN2_HIGH), clamped));
    V square = reduced * reduced, fourth = square * square;
    /* The exponential series up to degree 13: the terms of degrees 2n and 2n + 1 are `term[n]`
       square^n. `low` has the terms up to degree 7, and `high` the others, divided by square^4. */
    V term[7];
    UNROLL for (int n = 0; n < 7; n++)
        term[n] = vfma(reduced, splat(1.0 / FACTORIAL[2 * n + 1]), splat(1.0 / FACTORIAL[2 * n]));
    V low = vfma(vfma(term[3], square, term[2]), fourth, vfma(term[1], square, term[0]));
    V high = vfma(term[6], fourth, vfma(term[5], square, term[4]));
    V value = vfma(high, fourth * fourth, low);
    /* A number's exponent begins at bit 52. So 2^52 count, as an integer, added to the bits of 1
       makes 2^count. */
    V power = number_from_bits(count * 0x1p52, BITS_OF_ONE);
    return choose(is_nonzero, value * power, splat(0.0));
}

#endif
