/* Values and bounds of polynomials on a step.

   A polynomial is c₀ + c₁ t + t² G(t). G has `groups` groups of four terms, which are summed as
   four polynomials in t⁴. */

#ifndef FIVTUI_POLYNOMIAL_H
#define FIVTUI_POLYNOMIAL_H

#include "tables.h"
#include "vector.h"

/* A polynomial at both ends of a step of length h: values, slopes times h, and bounds of the
   distance of it and of its slope times h from the cubic with these values and slopes. */
typedef struct {
    V start, end, start_slope, end_slope, error, slope_error;
} Ends;

typedef struct {
    V value, slope;
} Tangent;

/* Factors of the four polynomials in t⁴ in the derivatives below. */
static const double SLOPE_FACTORS[4] = {2.0, 3.0, 4.0, 5.0};
static const double ZEROS[4];
static const double SECOND_FACTORS[4] = {1.0, 3.0, 6.0, 10.0};
static const double MIXED_FACTORS[4] = {14.0, 18.0, 22.0, 26.0};

/* Value and slope at t; with polynomials pⱼ(t⁴) the slope is c₁ + Σ tʲ⁺¹ ((2 + j) pⱼ + 4 t⁴
   pⱼ'). */
INLINE Tangent tangent_at(const V *c, int groups, V t)
{
    V square = t * t, fourth = square * square;
    Four p = load_four(c + 4 * groups - 2), d = p;
    p = four_fma_by(p, fourth, load_four(c + 4 * groups - 6));
    for (int k = groups - 3; k >= 0; k--) {
        d = four_fma_by(d, fourth, p);
        p = four_fma_by(p, fourth, load_four(c + 4 * k + 2));
    }
    V value = cubic_value(p, t, square);
    V slope = cubic_value(four_fma_by(d, fourth * 4.0, four_times(p, SLOPE_FACTORS)), t, square);
    return (Tangent){vfma(value, square, vfma(c[1], t, c[0])), vfma(slope, t, c[1])};
}

/* Value, slope and half the second derivative. */
typedef struct {
    V value, slope, half_d2;
} Curve;

INLINE Curve curve_at(const V *c, int groups, V t)
{
    V square = t * t, fourth = square * square;
    Four p = load_four(c + 4 * groups - 2), d = p, e = four_times(p, ZEROS);
    p = four_fma_by(p, fourth, load_four(c + 4 * groups - 6));
    for (int k = groups - 3; k >= 0; k--) {
        e = four_fma_by(e, fourth, d);
        d = four_fma_by(d, fourth, p);
        p = four_fma_by(p, fourth, load_four(c + 4 * k + 2));
    }
    V value = cubic_value(p, t, square);
    V slope = cubic_value(four_fma_by(d, fourth * 4.0, four_times(p, SLOPE_FACTORS)), t, square);
    Four bends = four_fma_by(four_times(d, MIXED_FACTORS), fourth, four_times(p, SECOND_FACTORS));
    V half_d2 = cubic_value(four_fma_by(e, fourth * fourth * 16.0, bends), t, square);
    return (Curve){vfma(value, square, vfma(c[1], t, c[0])), vfma(slope, t, c[1]), half_d2};
}

/* Bound Σ wₙ |cₙ| tⁿ over n > 1. */
INLINE V weighted_bound(const double *weights, const V *c, int groups, V t)
{
    V square = t * t, fourth = square * square;
    const double *w = weights + 4 * groups - 4;
    Four sum = four_times(four_abs(load_four(c + 4 * groups - 2)), w);
    for (int k = groups - 2; k >= 0; k--) {
        Four term = four_times(four_abs(load_four(c + 4 * k + 2)), weights + 4 * k);
        sum = four_fma_by(sum, fourth, term);
    }
    return cubic_value(sum, t, square) * square;
}

/* Middle Bernstein coefficient of the slope of the cubic; its slopes at the ends are the others. */
INLINE V middle_slope(const Ends *p)
{
    V near = p->start + p->start_slope * (1.0 / 3.0), far = p->end - p->end_slope * (1.0 / 3.0);
    return (far - near) * 3.0;
}

/* Lower and upper bound of the polynomial. */
typedef struct {
    V low, high;
} Range;

INLINE Range value_range(const Ends *p)
{
    V near = p->start + p->start_slope * (1.0 / 3.0), far = p->end - p->end_slope * (1.0 / 3.0);
    return (Range){vmin(vmin(p->start, p->end), vmin(near, far)) - p->error,
                   vmax(vmax(p->start, p->end), vmax(near, far)) + p->error};
}

/* Whether the slope has one sign for certain. */
INLINE M is_monotone(const Ends *p)
{
    V middle = middle_slope(p);
    V lowest = vmin(vmin(p->start_slope, p->end_slope), middle);
    V highest = vmax(vmax(p->start_slope, p->end_slope), middle);
    return (lowest > p->slope_error) | (highest < -p->slope_error);
}

/* Whether the slope rises or falls throughout for certain. */
INLINE M has_monotone_slope(const Ends *p, const V *c, int groups, V h)
{
    return vabs(p->end_slope - p->start_slope) > weighted_bound(CURVATURE_BOUND, c, groups, h);
}

#endif
