/* Values and bounds of polynomials on a step.

   A polynomial is c₀ + c₁ t + t² G(t) with G in `groups` groups of four terms, which are summed in
   four chains in t⁴. */

#ifndef FIVTUI_POLYNOMIAL_H
#define FIVTUI_POLYNOMIAL_H

#include "tables.h"
#include "vector.h"

/* A polynomial at both ends of a step of length h: values, slopes times h, and how far it and its
   slope times h leave those of the cubic with these values and slopes. */
typedef struct {
    V first, final, slope, last_slope, off, slope_off;
} Ends;

typedef struct {
    V value, slope;
} Tangent;

/* j + 2 of the j-th chain, and other factors of the derivatives below. */
static const double FIRST[4] = {2.0, 3.0, 4.0, 5.0};
static const double NOTHING[4];
static const double SECOND[4] = {1.0, 3.0, 6.0, 10.0};
static const double MIXED[4] = {14.0, 18.0, 22.0, 26.0};

/* Value and slope at t; with pⱼ(t⁴) the chains, the slope is c₁ + Σ tʲ⁺¹ ((2 + j) pⱼ + 4 t⁴ pⱼ'). */
INLINE Tangent tangent_at(const V *c, int groups, V t)
{
    V square = t * t, fourth = square * square;
    Four p = four_at(c + 4 * groups - 2), d = p;
    p = four_fma(p, fourth, four_at(c + 4 * groups - 6));
    for (int k = groups - 3; k >= 0; k--) {
        d = four_fma(d, fourth, p);
        p = four_fma(p, fourth, four_at(c + 4 * k + 2));
    }
    V value = folded(p, t, square);
    V slope = folded(four_fma(d, fourth * 4.0, four_scaled(p, FIRST)), t, square);
    return (Tangent){fma_of(value, square, fma_of(c[1], t, c[0])), fma_of(slope, t, c[1])};
}

/* Value, slope and half the second derivative. */
typedef struct {
    V value, slope, bend;
} Curve;

INLINE Curve curve_at(const V *c, int groups, V t)
{
    V square = t * t, fourth = square * square;
    Four p = four_at(c + 4 * groups - 2), d = p, e = four_scaled(p, NOTHING);
    p = four_fma(p, fourth, four_at(c + 4 * groups - 6));
    for (int k = groups - 3; k >= 0; k--) {
        e = four_fma(e, fourth, d);
        d = four_fma(d, fourth, p);
        p = four_fma(p, fourth, four_at(c + 4 * k + 2));
    }
    V value = folded(p, t, square);
    V slope = folded(four_fma(d, fourth * 4.0, four_scaled(p, FIRST)), t, square);
    Four bends = four_fma(four_scaled(d, MIXED), fourth, four_scaled(p, SECOND));
    V bend = folded(four_fma(e, fourth * fourth * 16.0, bends), t, square);
    return (Curve){fma_of(value, square, fma_of(c[1], t, c[0])), fma_of(slope, t, c[1]), bend};
}

/* Σ wₙ |cₙ| tⁿ from the second degree on. */
INLINE V weighed(const double *weights, const V *c, int groups, V t)
{
    V square = t * t, fourth = square * square;
    const double *w = weights + 4 * groups - 4;
    Four sum = four_scaled(four_absolute(four_at(c + 4 * groups - 2)), w);
    for (int k = groups - 2; k >= 0; k--) {
        Four term = four_scaled(four_absolute(four_at(c + 4 * k + 2)), weights + 4 * k);
        sum = four_fma(sum, fourth, term);
    }
    return folded(sum, t, square) * square;
}

/* The Bernstein coefficients of the slope of the cubic are slope, this and last_slope. */
INLINE V middle_slope(const Ends *p)
{
    V near = p->first + p->slope * (1.0 / 3.0), far = p->final - p->last_slope * (1.0 / 3.0);
    return (far - near) * 3.0;
}

/* Numbers between which the polynomial lies. */
typedef struct {
    V low, high;
} Range;

INLINE Range hull(const Ends *p)
{
    V near = p->first + p->slope * (1.0 / 3.0), far = p->final - p->last_slope * (1.0 / 3.0);
    return (Range){least(least(p->first, p->final), least(near, far)) - p->off,
                   greatest(greatest(p->first, p->final), greatest(near, far)) + p->off};
}

/* Whether the slope keeps its sign. */
INLINE M is_monotone(const Ends *p)
{
    V middle = middle_slope(p);
    V lowest = least(least(p->slope, p->last_slope), middle);
    V highest = greatest(greatest(p->slope, p->last_slope), middle);
    return (lowest > p->slope_off) | (highest < -p->slope_off);
}

/* Whether the slope rises or falls throughout. */
INLINE M is_bent(const Ends *p, const V *c, int groups, V h)
{
    return absolute(p->last_slope - p->slope) > weighed(CURVATURE_BOUND, c, groups, h);
}

#endif
