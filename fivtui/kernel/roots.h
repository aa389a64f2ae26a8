/* Roots and extreme values of one polynomial on [0, 1], none passed over.

   Roots are isolated by the variation of signs of the Bernstein coefficients (Descartes' rule on an
   interval): none means no root, one exactly one, more are resolved by subdivision. A polynomial is
   its `rows` coefficients, constant term first: FEWER_ROWS or ROWS. */

#ifndef FIVTUI_ROOTS_H
#define FIVTUI_ROOTS_H

#include "tables.h"
#include "vector.h"

/* Two roots closer than 2^-MAX_DEPTH are one to double precision. */
#define MAX_DEPTH 48
#define MAX_NEWTON 100
#define PRECISE 0x1p-53
#define MOST_PADDED (ROWS > FEWER_ROWS ? PADDED_BY_LAW : PADDED)

typedef struct {
    double b[MOST_PADDED], left, right;
    int depth;
} Interval;

INLINE void product_of_table(const double *p, const double *table, int rows, int padded, double *b)
{
    double sums[MOST_PADDED] = {0.0};
    for (int n = 0; n < rows; n++)
        for (int i = 0; i < padded; i++)
            sums[i] = FUSED(p[n], table[padded * n + i], sums[i]);
    memcpy(b, sums, sizeof sums);
}

INLINE void to_bernstein(const double *p, int rows, double *b)
{
    if (rows == FEWER_ROWS)
        product_of_table(p, TO_BERNSTEIN[0], FEWER_ROWS, PADDED, b);
    else
        product_of_table(p, TO_BERNSTEIN_BY_LAW[0], MAX_LAW_ORDER + 2, PADDED_BY_LAW, b);
}

INLINE int variations(const double *b, int rows)
{
    int count = 0, sign = 0;
    for (int i = 0; i < rows; i++) {
        int new = (b[i] > 0.0) - (b[i] < 0.0);
        count += new != 0 && new == -sign;
        sign = new != 0 ? new : sign;
    }
    return count;
}

INLINE double value_of(const double *p, int rows, double t)
{
    double value = p[rows - 1];
    for (int n = rows - 2; n >= 0; n--)
        value = FUSED(value, t, p[n]);
    return value;
}

/* The root in (left, right), over which the sign changes once: Newton's method, kept inside. */
INLINE double refined(const double *p, int rows, double left, double right, int negative)
{
    double t = 0.5 * (left + right);
    for (int i = 0; i < MAX_NEWTON; i++) {
        double value = p[rows - 1], slope = 0.0;
        for (int n = rows - 2; n >= 0; n--) {
            slope = FUSED(slope, t, value);
            value = FUSED(value, t, p[n]);
        }
        if (value == 0.0)
            break;
        if ((value < 0.0) == negative)
            left = t;
        else
            right = t;
        double new = slope != 0.0 ? t - value / slope : left;
        if (__builtin_fabs(new - t) <= PRECISE * t)
            return smaller(larger(new, left), right);
        if (!(left < new && new < right)) {
            new = 0.5 * (left + right);
            if (new <= left || new >= right)
                break;
        }
        t = new;
    }
    return t;
}

/* De Casteljau's rule, away from a root: the signs at every cut must be known. `b` becomes the
   upper part; returns where it was cut. */
INLINE double split(double *b, int rows, double *lower)
{
    static const double PARTS[3] = {0.5, 0.4375, 0.5625};
    double upper[MOST_PADDED], part = 0.5;
    for (int attempt = 0; attempt < 3; attempt++) {
        part = PARTS[attempt];
        memcpy(upper, b, sizeof upper);
        for (int level = 0; level < rows; level++) {
            lower[level] = upper[0];
            for (int i = 0; i < rows - 1 - level; i++)
                upper[i] = (1.0 - part) * upper[i] + part * upper[i + 1];
        }
        if (lower[rows - 1] != 0.0)
            break;
    }
    memcpy(b, upper, sizeof upper);
    return part;
}

/* Roots in (0, 1] at which the sign changes, ascending, at most `limit` of them; a root at 0 does
   not count, whatever its multiplicity. Returns how many. */
APART int sign_roots(const double *given, int rows, int limit, double *found)
{
    double p[ROWS] = {0.0}, others = 0.0;
    int zeros = 0, count = 0, waiting = 1;
    while (zeros < rows && given[zeros] == 0.0)
        zeros++;
    for (int n = zeros; n < rows; n++)
        p[n - zeros] = given[n];
    for (int n = 1; n < rows; n++)
        others += __builtin_fabs(p[n]);
    if (zeros >= rows - 1 || !(__builtin_fabs(p[0]) <= others))
        return 0;
    Interval stack[MAX_DEPTH + 4];
    to_bernstein(p, rows, stack[0].b);
    stack[0].left = 0.0, stack[0].right = 1.0, stack[0].depth = 0;
    int negative = p[0] < 0.0, at_end = stack[0].b[rows - 1] == 0.0;
    while (waiting > 0 && count < limit) {
        Interval *here = &stack[--waiting];
        int changes = variations(here->b, rows);
        if (changes > 1 && here->depth < MAX_DEPTH) {
            /* The lower part is taken first: it goes on top. */
            Interval *lower = here + 1;
            double part = split(here->b, rows, lower->b);
            lower->left = here->left;
            here->left = lower->right = here->left + part * (here->right - here->left);
            lower->depth = ++here->depth;
            waiting += 2;
        } else if (changes % 2 == 1) {
            found[count++] = refined(p, rows, here->left, here->right, negative);
            negative = !negative;
        }
    }
    if (at_end && count < limit)
        found[count++] = 1.0;
    return count;
}

/* The least and the greatest value where the slope changes its sign; none leaves both as they are.*/
APART void turning_values(const double *p, int rows, double *low, double *high)
{
    double slope[ROWS] = {0.0}, places[ROWS];
    for (int n = 1; n < rows; n++)
        slope[n - 1] = n * p[n];
    int count = sign_roots(slope, rows, rows, places);
    for (int i = 0; i < count; i++) {
        double value = value_of(p, rows, places[i]);
        *low = smaller(value, *low);
        *high = larger(value, *high);
    }
}

#endif
