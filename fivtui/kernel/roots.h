/* All roots and extreme values of one polynomial on [0, 1].

   Roots are isolated by the sign changes of the Bernstein coefficients (Descartes' rule on an
   interval): none means no root, one means exactly one root, and with more the interval is
   subdivided. A polynomial has `rows` coefficients, constant term first: FEWER_ROWS or ROWS. */

#ifndef FIVTUI_ROOTS_H
#define FIVTUI_ROOTS_H

#include "tables.h"
#include "vector.h"

/* Two roots closer than 2^-MAX_DEPTH count as one root. */
#define MAX_DEPTH 48
#define MAX_NEWTON_STEPS 100
/* Relative tolerance of a root. */
#define ROOT_TOLERANCE 0x1p-53
/* Greatest number of Bernstein coefficients, filled up with zeros: the tables have full vectors. */
#define MAX_PADDED (ROWS > FEWER_ROWS ? PADDED_BY_LAW : PADDED)

/* An interval with the Bernstein coefficients on it, after `depth` subdivisions. */
typedef struct {
    double b[MAX_PADDED], left, right;
    int depth;
} Interval;

/* Set b to the sum of the table's rows, row n times p[n]. */
INLINE void apply_table(const double *p, const double *table, int rows, int padded, double *b)
{
    double sums[MAX_PADDED] = {0.0};
    for (int n = 0; n < rows; n++)
        for (int i = 0; i < padded; i++)
            sums[i] = FMA(p[n], table[padded * n + i], sums[i]);
    memcpy(b, sums, sizeof sums);
}

/* Set b to the Bernstein coefficients of a polynomial on [0, 1]. */
INLINE void to_bernstein(const double *p, int rows, double *b)
{
    if (rows == FEWER_ROWS)
        apply_table(p, TO_BERNSTEIN[0], FEWER_ROWS, PADDED, b);
    else
        apply_table(p, TO_BERNSTEIN_BY_LAW[0], MAX_LAW_ORDER + 2, PADDED_BY_LAW, b);
}

INLINE int count_sign_changes(const double *b, int rows)
{
    int count = 0, sign = 0;
    for (int i = 0; i < rows; i++) {
        int next_sign = (b[i] > 0.0) - (b[i] < 0.0);
        count += next_sign != 0 && next_sign == -sign;
        sign = next_sign != 0 ? next_sign : sign;
    }
    return count;
}

INLINE double polynomial_value(const double *p, int rows, double t)
{
    double value = p[rows - 1];
    for (int n = rows - 2; n >= 0; n--)
        value = FMA(value, t, p[n]);
    return value;
}

/* The root in (left, right), where the sign changes once, to positive if `negative`: Newton's
   method with this bracket. */
INLINE double refine_root(const double *p, int rows, double left, double right, int negative)
{
    double t = 0.5 * (left + right);
    for (int i = 0; i < MAX_NEWTON_STEPS; i++) {
        double value = p[rows - 1], slope = 0.0;
        for (int n = rows - 2; n >= 0; n--) {
            slope = FMA(slope, t, value);
            value = FMA(value, t, p[n]);
        }
        if (value == 0.0)
            break;
        if ((value < 0.0) == negative)
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
INLINE double subdivide(double *b, int rows, double *lower)
{
    enum { ATTEMPTS = 3 };
    static const double CUT_FRACTIONS[ATTEMPTS] = {0.5, 0.4375, 0.5625};
    double upper[MAX_PADDED], cut = 0.5;
    for (int attempt = 0; attempt < ATTEMPTS; attempt++) {
        cut = CUT_FRACTIONS[attempt];
        memcpy(upper, b, sizeof upper);
        for (int level = 0; level < rows; level++) {
            lower[level] = upper[0];
            for (int i = 0; i < rows - 1 - level; i++)
                upper[i] = (1.0 - cut) * upper[i] + cut * upper[i + 1];
        }
        if (lower[rows - 1] != 0.0)
            break;
    }
    memcpy(b, upper, sizeof upper);
    return cut;
}

/* Roots in (0, 1] at which the sign changes, ascending, at most `limit` of them; a root at 0 does
   not count, whatever its multiplicity. Returns their number. */
NOINLINE int find_roots(const double *coefficients, int rows, int limit, double *roots)
{
    double p[ROWS] = {0.0}, sum = 0.0;
    int zeros = 0, count = 0, stack_size = 1;
    while (zeros < rows && coefficients[zeros] == 0.0)
        zeros++;
    for (int n = zeros; n < rows; n++)
        p[n - zeros] = coefficients[n];
    for (int n = 1; n < rows; n++)
        sum += __builtin_fabs(p[n]);
    /* There is no root if the first term outweighs all others. */
    if (zeros >= rows - 1 || !(__builtin_fabs(p[0]) <= sum))
        return 0;
    Interval stack[MAX_DEPTH + 4];
    to_bernstein(p, rows, stack[0].b);
    stack[0].left = 0.0, stack[0].right = 1.0, stack[0].depth = 0;
    int negative = p[0] < 0.0, root_at_end = stack[0].b[rows - 1] == 0.0;
    while (stack_size > 0 && count < limit) {
        Interval *interval = &stack[--stack_size];
        int changes = count_sign_changes(interval->b, rows);
        if (changes > 1 && interval->depth < MAX_DEPTH) {
            /* The lower part goes on top of the stack, so that it is searched first. */
            Interval *lower = interval + 1;
            double cut = subdivide(interval->b, rows, lower->b);
            lower->left = interval->left;
            interval->left = lower->right = interval->left + cut
                * (interval->right - interval->left);
            lower->depth = ++interval->depth;
            stack_size += 2;
        } else if (changes % 2 == 1) {
            roots[count++] = refine_root(p, rows, interval->left, interval->right, negative);
            negative = !negative;
        }
    }
    if (root_at_end && count < limit)
        roots[count++] = 1.0;
    return count;
}

/* Extend `low` and `high` to the values at which the slope changes its sign. */
NOINLINE void include_extrema(const double *p, int rows, double *low, double *high)
{
    double slope[ROWS] = {0.0}, thetas[ROWS];
    for (int n = 1; n < rows; n++)
        slope[n - 1] = n * p[n];
    int count = find_roots(slope, rows, rows, thetas);
    for (int i = 0; i < count; i++) {
        double value = polynomial_value(p, rows, thetas[i]);
        *low = minimum(value, *low);
        *high = maximum(value, *high);
    }
}

#endif
