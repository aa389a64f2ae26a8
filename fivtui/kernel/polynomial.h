/* Values and bounds of polynomials on a step.

   A polynomial is c₀ + c₁ t + t² G(t). G has `groups` groups of four terms, which are summed as
   four polynomials in t⁴: term 4 k + j of G belongs to polynomial j. So groups is the order of
   expansion divided by GROUP_SIZE.

   "The cubic" of a polynomial is the one with the same values and slopes at both ends of a step. */

#ifndef FIVTUI_POLYNOMIAL_H
#define FIVTUI_POLYNOMIAL_H

#include "tables.h"
#include "vector.h"

#define GROUP_SIZE 4

/* A polynomial at both ends of a step of length h: its values, and its slopes times h. `error`
   bounds the distance of the polynomial from its cubic, `slope_error` that of their slopes, times
   h. */
typedef struct {
    V start, end, start_slope, end_slope, error, slope_error;
} Ends;

/* Value and slope of a polynomial at a time. */
typedef struct {
    V value, slope;
} Tangent;

/* Factors in derivatives of the four parts t²⁺ʲ p of G, where p = pⱼ(t⁴) and ′ is the derivative by
   t⁴. The slope of a part, and half its second derivative, are

       t¹⁺ʲ ((2 + j) p + 4 t⁴ p′)
       tʲ ((1 + j) (2 + j)/2 p + (14 + 4 j) t⁴ p′ + 8 t⁸ p″) */
static const double SLOPE_FACTORS[4] = {2.0, 3.0, 4.0, 5.0};
static const double ZEROS[4];
static const double SECOND_FACTORS[4] = {1.0, 3.0, 6.0, 10.0};
static const double MIXED_FACTORS[4] = {14.0, 18.0, 22.0, 26.0};

/* Value and slope at t. */
INLINE Tangent tangent_at(const V *c, int groups, V t)
{
    V square = t * t, fourth = square * square;
    /* The polynomials in t⁴ and their derivatives d by t⁴ (Horner). */
    Four p = load_four(c + 4 * groups - 2), d = p;
    p = four_fma_by(p, fourth, load_four(c + 4 * groups - 6));
    for (int k = groups - 3; k >= 0; k--) {
        /* With p before its own update. */
        d = four_fma_by(d, fourth, p);
        p = four_fma_by(p, fourth, load_four(c + 4 * k + 2));
    }
    V value = cubic_value(p, t, square);
    V slope = cubic_value(four_fma_by(d, fourth * 4.0, four_times(p, SLOPE_FACTORS)), t, square);
    return (Tangent){vfma(value, square, vfma(c[1], t, c[0])), vfma(slope, t, c[1])};
}

/* Value, slope and half the second derivative of a polynomial at a time. */
typedef struct {
    V value, slope, half_d2;
} Curve;

INLINE Curve curve_at(const V *c, int groups, V t)
{
    V square = t * t, fourth = square * square;
    /* The polynomials in t⁴, their derivatives d by t⁴ and half their second derivatives e
       (Horner). With e = p″/2 the factor 8 of p″ above is 16. */
    Four p = load_four(c + 4 * groups - 2), d = p, e = four_times(p, ZEROS);
    p = four_fma_by(p, fourth, load_four(c + 4 * groups - 6));
    for (int k = groups - 3; k >= 0; k--) {
        e = four_fma_by(e, fourth, d);
        d = four_fma_by(d, fourth, p);
        p = four_fma_by(p, fourth, load_four(c + 4 * k + 2));
    }
    V value = cubic_value(p, t, square);
    V slope = cubic_value(four_fma_by(d, fourth * 4.0, four_times(p, SLOPE_FACTORS)), t, square);
    Four terms = four_fma_by(four_times(d, MIXED_FACTORS), fourth, four_times(p, SECOND_FACTORS));
    V half_d2 = cubic_value(four_fma_by(e, fourth * fourth * 16.0, terms), t, square);
    return (Curve){vfma(value, square, vfma(c[1], t, c[0])), vfma(slope, t, c[1]), half_d2};
}

/* Bound Σ weightₙ |cₙ| tⁿ over n > 1; `weights` begin at n = 2. */
INLINE V weighted_bound(const double *weights, const V *c, int groups, V t)
{
    V square = t * t, fourth = square * square;
    const double *last_weights = weights + 4 * groups - 4;
    Four sum = four_times(four_abs(load_four(c + 4 * groups - 2)), last_weights);
    for (int k = groups - 2; k >= 0; k--) {
        Four term = four_times(four_abs(load_four(c + 4 * k + 2)), weights + 4 * k);
        sum = four_fma_by(sum, fourth, term);
    }
    return cubic_value(sum, t, square) * square;
}

/* Middle Bernstein coefficient of the slope of the cubic; its slopes at the ends are the others. */
INLINE V middle_slope(const Ends *ends)
{
    V near = ends->start + ends->start_slope * (1.0 / 3.0);
    V far = ends->end - ends->end_slope * (1.0 / 3.0);
    return (far - near) * 3.0;
}

typedef struct {
    V low, high;
} Range;

/* Lower and upper bound of the polynomial, by the Bernstein coefficients of the cubic: its values
   at both ends, `near` and `far`. */
INLINE Range value_range(const Ends *ends)
{
    V near = ends->start + ends->start_slope * (1.0 / 3.0);
    V far = ends->end - ends->end_slope * (1.0 / 3.0);
    return (Range){vmin(vmin(ends->start, ends->end), vmin(near, far)) - ends->error,
                   vmax(vmax(ends->start, ends->end), vmax(near, far)) + ends->error};
}

/* Whether the slope has one sign for certain. */
INLINE M is_monotone(const Ends *ends)
{
    V middle = middle_slope(ends);
    V lowest = vmin(vmin(ends->start_slope, ends->end_slope), middle);
    V highest = vmax(vmax(ends->start_slope, ends->end_slope), middle);
    return (lowest > ends->slope_error) | (highest < -ends->slope_error);
}

/* Whether the slope rises or falls over the full step for certain. The second derivative differs
   from its mean, which is the change of the slope, by no more than the bound. */
INLINE M has_monotone_slope(const Ends *ends, const V *c, int groups, V h)
{
    V change = ends->end_slope - ends->start_slope;
    return vabs(change) > weighted_bound(CURVATURE_BOUND, c, groups, h);
}

#endif
