/* All roots and extreme values of one polynomial on [0, 1].

   Roots are isolated by the sign changes of the Bernstein coefficients (Descartes' rule on an
   interval): none means no root, one means exactly one root, and with more the interval is
   subdivided. A polynomial has `terms` coefficients, constant term first. Their number is
   MAX_TERMS_WITHOUT_LAW, or MAX_TERMS for an order that only a friction law has (`tables.h`). */

#ifndef FIVTUI_ROOTS_H
#define FIVTUI_ROOTS_H

#include "tables.h"
#include "vector.h"

/* Intervals of the length 2^-MAX_DEPTH are not subdivided: an odd number of sign changes on one
   counts as one root, an even number as none. */
#define MAX_DEPTH 48
#define MAX_NEWTON_STEPS 100
/* Relative tolerance of a root. */
#define ROOT_TOLERANCE 0x1p-53
/* Greatest number of Bernstein coefficients, filled up with zeros: the tables have full vectors. */
#define MAX_PADDED_TERMS                                                                          \
    (MAX_TERMS > MAX_TERMS_WITHOUT_LAW ? PADDED_TERMS_WITH_LAW : PADDED_TERMS)

/* An interval with the Bernstein coefficients on it, after `depth` subdivisions. */
typedef struct {
    double b[MAX_PADDED_TERMS], left, right;
    int depth;
} Interval;

/* Set b to the sum of the table's rows, row n times p[n]. */
INLINE void apply_table(const double *p, const double *table, int terms, int padded, double *b)
{
    double sums[MAX_PADDED_TERMS] = {0.0};
    for (int n = 0; n < terms; n++)
        for (int i = 0; i < padded; i++)
            sums[i] = FMA(p[n], table[padded * n + i], sums[i]);
    memcpy(b, sums, sizeof sums);
}

/* Set b to the Bernstein coefficients of a polynomial on [0, 1]. */
INLINE void to_bernstein(const double *p, int terms, double *b)
{
    if (terms == MAX_TERMS_WITHOUT_LAW)
        apply_table(p, TO_BERNSTEIN[0], MAX_TERMS_WITHOUT_LAW, PADDED_TERMS, b);
    else
        apply_table(p, TO_BERNSTEIN_WITH_LAW[0], MAX_LAW_ORDER + 2, PADDED_TERMS_WITH_LAW, b);
}

INLINE int count_sign_changes(const double *b, int terms)
{
    int count = 0, sign = 0;
    for (int i = 0; i < terms; i++) {
        int next_sign = (b[i] > 0.0) - (b[i] < 0.0);
        count += next_sign != 0 && next_sign == -sign;
        sign = next_sign != 0 ? next_sign : sign;
    }
    return count;
}

INLINE double polynomial_value(const double *p, int terms, double t)
{
    double value = p[terms - 1];
    for (int n = terms - 2; n >= 0; n--)
        value = FMA(value, t, p[n]);
    return value;
}

/* The root in (left, right), where the sign changes once; it is negative before the root if
   `starts_negative`. Newton's method with this bracket. */
INLINE double refine_root(const double *p, int terms, double left, double right,
                          int starts_negative)
{
    double t = 0.5 * (left + right);
    for (int i = 0; i < MAX_NEWTON_STEPS; i++) {
        double value = p[terms - 1], slope = 0.0;
        for (int n = terms - 2; n >= 0; n--) {
            slope = FMA(slope, t, value);
            value = FMA(value, t, p[n]);
        }
        if (value == 0.0)
            break;
        if ((value < 0.0) == starts_negative)
            left = t;
        else
            right = t;
        double new = slope != 0.0 ? t - value / slope : left;
        if (__builtin_fabs(new - t) <= ROOT_TOLERANCE * t)
            return minimum(maximum(new, left), right);
        if (!(left < new && new < right)) {
            new = 0.5 * (left + right);
            if (new <= left || new >= right)
                break;
        }
        t = new;
    }
    return t;
}

/* Cut an interval in two by De Casteljau's rule. The cut must not be a root, because the sign there
   is needed. `b` becomes the upper part; returns the cut as a fraction. */
INLINE double subdivide(double *b, int terms, double *lower)
{
    enum { ATTEMPTS = 3 };
    static const double CUT_FRACTIONS[ATTEMPTS] = {0.5, 0.4375, 0.5625};
    double upper[MAX_PADDED_TERMS], cut = 0.5;
    for (int attempt = 0; attempt < ATTEMPTS; attempt++) {
        cut = CUT_FRACTIONS[attempt];
        memcpy(upper, b, sizeof upper);
        for (int level = 0; level < terms; level++) {
            lower[level] = upper[0];
            for (int i = 0; i < terms - 1 - level; i++)
                upper[i] = (1.0 - cut) * upper[i] + cut * upper[i + 1];
        }
        if (lower[terms - 1] != 0.0)
            break;
    }
    memcpy(b, upper, sizeof upper);
    return cut;
}

/* Roots in (0, 1] at which the sign changes, ascending, at most `limit` of them; a root at 0 does
   not count, whatever its multiplicity. Returns their number. */
NOINLINE int find_roots(const double *coefficients, int terms, int limit, double *roots)
{
    double p[MAX_TERMS] = {0.0}, sum = 0.0;
    int zeros = 0, count = 0, stack_size = 1;
    while (zeros < terms && coefficients[zeros] == 0.0)
        zeros++;
    for (int n = zeros; n < terms; n++)
        p[n - zeros] = coefficients[n];
    for (int n = 1; n < terms; n++)
        sum += __builtin_fabs(p[n]);
    /* There is no root if the first term outweighs all others. */
    if (zeros >= terms - 1 || !(__builtin_fabs(p[0]) <= sum))
        return 0;
    Interval stack[MAX_DEPTH + 4];
    to_bernstein(p, terms, stack[0].b);
    stack[0].left = 0.0, stack[0].right = 1.0, stack[0].depth = 0;
    int starts_negative = p[0] < 0.0, root_at_end = stack[0].b[terms - 1] == 0.0;
    while (stack_size > 0 && count < limit) {
        Interval *interval = &stack[--stack_size];
        int changes = count_sign_changes(interval->b, terms);
        if (changes > 1 && interval->depth < MAX_DEPTH) {
            /* The lower part goes on top of the stack, so that it is searched first. */
            Interval *lower = interval + 1;
            double cut = subdivide(interval->b, terms, lower->b);
            lower->left = interval->left;
            interval->left = lower->right = interval->left + cut
                * (interval->right - interval->left);
            lower->depth = ++interval->depth;
            stack_size += 2;
        } else if (changes % 2 == 1) {
            roots[count++] = refine_root(p, terms, interval->left, interval->right,
                                         starts_negative);
            starts_negative = !starts_negative;
        }
    }
    if (root_at_end && count < limit)
        roots[count++] = 1.0;
    return count;
}

/* Extend `low` and `high` to the values at which the slope changes its sign. */
NOINLINE void include_extrema(const double *p, int terms, double *low, double *high)
{
    double slope[MAX_TERMS] = {0.0}, thetas[MAX_TERMS];
    for (int n = 1; n < terms; n++)
        slope[n - 1] = n * p[n];
    int count = find_roots(slope, terms, terms, thetas);
    for (int i = 0; i < count; i++) {
        double value = polynomial_value(p, terms, thetas[i]);
        *low = minimum(value, *low);
        *high = maximum(value, *high);
    }
}

#endif
