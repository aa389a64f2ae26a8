/* Roots and extreme values of one polynomial on [0, 1], none passed over.

   Roots are isolated by the variation of signs of the Bernstein coefficients (Descartes' rule on an
   interval): none means no root, one exactly one, more are resolved by subdivision. A polynomial is
   its ROWS coefficients, constant term first. */

#ifndef FIVTUI_ROOTS_H
#define FIVTUI_ROOTS_H

#include "tables.h"
#include "vector.h"

/* Two roots closer than 2^-MAX_DEPTH are one to double precision. */
#define MAX_DEPTH 48
#define MAX_NEWTON 100
#define PRECISE 0x1p-53

typedef struct {
    double b[PADDED], left, right;
    int depth;
} Interval;

INLINE void to_bernstein(const double *p, double *b)
{
    double sums[PADDED] = {0.0};
    for (int n = 0; n < ROWS; n++)
        for (int i = 0; i < PADDED; i++)
            sums[i] = FUSED(p[n], TO_BERNSTEIN[n][i], sums[i]);
    memcpy(b, sums, sizeof sums);
}

INLINE int variations(const double *b)
{
    int count = 0, sign = 0;
    for (int i = 0; i < ROWS; i++) {
        int new = (b[i] > 0.0) - (b[i] < 0.0);
        count += new != 0 && new == -sign;
        sign = new != 0 ? new : sign;
    }
    return count;
}

INLINE double value_of(const double *p, double t)
{
    double value = p[ROWS - 1];
    for (int n = ROWS - 2; n >= 0; n--)
        value = FUSED(value, t, p[n]);
    return value;
}

/* The root in (left, right), over which the sign changes once: Newton's method, kept inside. */
INLINE double refined(const double *p, double left, double right, int negative)
{
    double t = 0.5 * (left + right);
    for (int i = 0; i < MAX_NEWTON; i++) {
        double value = p[ROWS - 1], slope = 0.0;
        for (int n = ROWS - 2; n >= 0; n--) {
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
INLINE double split(double *b, double *lower)
{
    static const double PARTS[3] = {0.5, 0.4375, 0.5625};
    double upper[PADDED], part = 0.5;
    for (int attempt = 0; attempt < 3; attempt++) {
        part = PARTS[attempt];
        memcpy(upper, b, sizeof upper);
        for (int level = 0; level < ROWS; level++) {
            lower[level] = upper[0];
            for (int i = 0; i < ROWS - 1 - level; i++)
                upper[i] = (1.0 - part) * upper[i] + part * upper[i + 1];
        }
        if (lower[ROWS - 1] != 0.0)
            break;
    }
    memcpy(b, upper, sizeof upper);
    return part;
}

/* Roots in (0, 1] at which the sign changes, ascending, at most `limit` of them; a root at 0 does
   not count, whatever its multiplicity. Returns how many. */
APART int sign_roots(const double *given, int limit, double *found)
{
    double p[ROWS] = {0.0}, others = 0.0;
    int zeros = 0, count = 0, waiting = 1;
    while (zeros < ROWS && given[zeros] == 0.0)
        zeros++;
    for (int n = zeros; n < ROWS; n++)
        p[n - zeros] = given[n];
    for (int n = 1; n < ROWS; n++)
        others += __builtin_fabs(p[n]);
    if (zeros >= ROWS - 1 || !(__builtin_fabs(p[0]) <= others))
        return 0;
    Interval stack[MAX_DEPTH + 4];
    to_bernstein(p, stack[0].b);
    stack[0].left = 0.0, stack[0].right = 1.0, stack[0].depth = 0;
    int negative = p[0] < 0.0, at_end = stack[0].b[ROWS - 1] == 0.0;
    while (waiting > 0 && count < limit) {
        Interval *here = &stack[--waiting];
        int changes = variations(here->b);
        if (changes > 1 && here->depth < MAX_DEPTH) {
            /* The lower part is taken first: it goes on top. */
            Interval *lower = here + 1;
            double part = split(here->b, lower->b);
            lower->left = here->left;
            here->left = lower->right = here->left + part * (here->right - here->left);
            lower->depth = ++here->depth;
            waiting += 2;
        } else if (changes % 2 == 1) {
            found[count++] = refined(p, here->left, here->right, negative);
            negative = !negative;
        }
    }
    if (at_end && count < limit)
        found[count++] = 1.0;
    return count;
}

/* The least and the greatest value where the slope changes its sign; none leaves both as they are.*/
APART void turning_values(const double *p, double *low, double *high)
{
    double slope[ROWS] = {0.0}, places[ROWS];
    for (int n = 1; n < ROWS; n++)
        slope[n - 1] = n * p[n];
    int count = sign_roots(slope, ROWS, places);
    for (int i = 0; i < count; i++) {
        double value = value_of(p, places[i]);
        *low = smaller(value, *low);
        *high = larger(value, *high);
    }
}

#endif
