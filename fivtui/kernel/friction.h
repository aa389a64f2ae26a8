/* Expansion of sliding with the friction law μ + (μ_s − μ) exp(−v/v_s), v = |v_r|: by the
   recurrences of `fivtui.taylor.friction`. LANES is 1. */

#ifndef FIVTUI_FRICTION_H
#define FIVTUI_FRICTION_H

#include "expansion.h"
#include "polynomial.h"

/* As in `fivtui.taylor.friction`. */
#define LN2_HIGH 6.93147180369123816490e-01
#define LN2_LOW 1.90821492927058770002e-10
#define LOG2_E 1.44269504088896338700
#define MOST_EXPONENT 700.0
#define MOST_CHANGE 12.0
#define WIDENING 0.09
#define NEGLIGIBLE 37.0
#define FAR ((NEGLIGIBLE + MOST_CHANGE) / (1.0 - WIDENING))
#define SHRINKING 0.75
static const double DEGREES[MAX_ORDER] = {
    2.0,  3.0,  4.0,  5.0,  6.0,  7.0,  8.0,  9.0,  10.0, 11.0,
    12.0, 13.0, 14.0, 15.0, 16.0, 17.0, 18.0, 19.0, 20.0, 21.0,
};

/* How friction goes on: it falls with the speed, or it does not, or it holds the slider. */
typedef enum { FALLING, LEVEL, HOLDING } Friction;

/* The sign of friction, 0 where the slider does not slide, its constant part, its fall, and 1/v_s, 0
   where friction is constant; and k2/m, 0 where there is no contact. */
typedef struct {
    V sign, mu, fall, per_speed, contact;
} Law;

/* exp(−exponent) by arithmetic alone; below zero, where rounding comes, not beyond −700. */
INLINE V decay(V exponent)
{
    const double whole = 0x1.8p52;
    M some = exponent < MOST_EXPONENT;
    V above = choose(some, greatest(exponent, splat(-MOST_EXPONENT)), splat(MOST_EXPONENT));
    V count = (whole - above * LOG2_E) - whole;
    V rest = fma_of(count, splat(-LN2_LOW), fma_of(count, splat(-LN2_HIGH), -above));
    V square = rest * rest, fourth = square * square;
    V term[7];
    UNROLLED for (int n = 0; n < 7; n++)
        term[n] = fma_of(rest, splat(1.0 / FACTORIAL[2 * n + 1]), splat(1.0 / FACTORIAL[2 * n]));
    V low = fma_of(fma_of(term[3], square, term[2]), fourth, fma_of(term[1], square, term[0]));
    V high = fma_of(term[6], fourth, fma_of(term[5], square, term[4]));
    V value = fma_of(high, fourth * fourth, low);
    return choose(some, value * from_bits_beyond_one(count * 0x1p52, 1023LL << 52), splat(0.0));
}

/* What is carried from term to term, with u and v those of ẍ and ÿ and p that of P/m, all of the
   n-th power of time: y; x; e; (pₙ₊₁, uₙ), and the sums of their products with those of e without
   the terms that come last; and factors of pₙ, e₀, e₁, sums, u, v. */
typedef struct {
    Terms of_y;
    V x[ROWS], e[ROWS], u[ROWS], v[ROWS];
    Pair gain[ROWS], ahead[ROWS];
    V stiffness, minus_d, a_x, b_x, a_y, damping_x, damping_y;
    V of_p, of_newest, of_last, fall, rate, by_start, by_first;
} Slide;

/* Σ (pᵢ₊₁, uᵢ) eₙ₋₁₋ᵢ over 0 < i < n − 1. */
INLINE void sum_gains_ahead(Slide *s, int n)
{
    int middle = (n - 1) / 2;
    Pair low = pair_times(s->gain[middle], s->e[n - 1 - middle]);
    UNROLLED for (int i = middle - 1; i > 0; i--)
        low = pair_fma_by(s->gain[i], s->e[n - 1 - i], low);
    if (middle + 1 < n - 1) {
        Pair high = pair_times(s->gain[middle + 1], s->e[n - 2 - middle]);
        UNROLLED for (int i = middle + 2; i < n - 1; i++)
            high = pair_fma_by(s->gain[i], s->e[n - 1 - i], high);
        low = pair_of(X_OF(low) + X_OF(high), Y_OF(low) + Y_OF(high));
    }
    s->ahead[n] = low;
}

/* eₙ, and `along` with what the fall of friction adds to it but for the term of eₙ; for n > 0. */
INLINE V add_fall(Slide *s, int n, V p, V along)
{
    const V *e = s->e;
    const double part = 1.0 / n;
    V last = splat(0.0);
    s->gain[n - 1] = pair_of(p, s->u[n - 1]);
    if (n > 1 && n + 1 < MAX_ORDER)
        sum_gains_ahead(s, n + 1);
    if (n > 2) {
        along = fma_of(s->fall, X_OF(s->ahead[n]), along);
        last = Y_OF(s->ahead[n]) * (s->rate * part);
    }
    if (n > 1) {
        along = fma_of(s->of_last, e[n - 1], along);
        last = fma_of(e[n - 1], s->by_start * part, last);
    } else {
        s->of_last = s->fall * p;
    }
    s->e[n] = fma_of(s->u[n - 1], s->by_first * part, last);
    return along;
}

/* xₙ₊₂ and yₙ₊₂, for n > 0 */
INLINE void add_sliding_term(Slide *s, int n, int cubic, Friction of)
{
    Terms *of_y = &s->of_y;
    const V *y = of_y->y;
    const double part = 1.0 / n, share = 1.0 / ((n + 1) * (n + 2));
    V p = s->stiffness * y[n];
    if (cubic && n > 1)
        p = fma_of(s->minus_d, product_of_terms(of_y, n), p);
    V along = fma_of(s->of_p, p, fma_of(s->a_x, s->x[n], s->b_x * y[n]));
    if (of == FALLING)
        along = add_fall(s, n, p, along);
    along = fma_of(s->damping_x * part, s->u[n - 1], along);
    along = of == FALLING ? fma_of(s->of_newest, s->e[n], along) : along;
    s->u[n] = of == HOLDING ? splat(0.0) : along;
    s->v[n] = fma_of(s->damping_y * part, s->v[n - 1], fma_of(s->a_y, s->x[n] - y[n], p));
    s->x[n + 2] = s->u[n] * share, of_y->y[n + 2] = s->v[n] * share;
    if (cubic)
        add_square(of_y, n);
}

/* Four terms, stored. */
INLINE void add_sliding_terms(Slide *s, int n, int cubic, Friction of, V *x, V *y)
{
    if (n > 0)
        add_sliding_term(s, n, cubic, of);
    add_sliding_term(s, n + 1, cubic, of);
    add_sliding_term(s, n + 2, cubic, of);
    add_sliding_term(s, n + 3, cubic, of);
#if LANES == 1
    const Four share = {1.0 / ((n + 1) * (n + 2)), 1.0 / ((n + 2) * (n + 3)),
                        1.0 / ((n + 3) * (n + 4)), 1.0 / ((n + 4) * (n + 5))};
    *(FourPacked *)(x + n + 2) = (Four){s->u[n], s->u[n + 1], s->u[n + 2], s->u[n + 3]} * share;
    *(FourPacked *)(y + n + 2) = (Four){s->v[n], s->v[n + 1], s->v[n + 2], s->v[n + 3]} * share;
#else
    UNROLLED for (int i = n + 2; i < n + 6; i++)
        x[i] = s->x[i], y[i] = s->of_y.y[i];
#endif
}

/* Continue the first two coefficients of x and y in the field `f` without the contact, but d of ÿ;
   where friction does not fall, with the bits of a fall of 0. */
INLINE void slide(V *x, V *y, const Field *f, const Law *law, V v_belt, int order, int cubic,
                  Friction of)
{
    Slide s;
    Terms *of_y = &s.of_y;
    V sign = law->sign, y0 = y[0], p = -law->contact * y0;
    s.stiffness = -law->contact, s.minus_d = -f->d_y;
    s.a_x = f->a_x, s.b_x = f->b_x, s.a_y = f->a_y;
    s.damping_x = f->damping_x, s.damping_y = f->damping_y;
    of_y->y[0] = y0, of_y->y[1] = y[1];
    if (cubic) {
        V square = y0 * y0;
        p = fma_of(s.minus_d, square * y0, p);
        s.stiffness = fma_of(s.minus_d, square * 3.0, s.stiffness);
        of_y->thrice = y0 * 3.0, of_y->twice = y[1] + y[1];
    }
    s.of_p = sign * law->mu;
    if (of == FALLING) {
        s.rate = sign * law->per_speed, s.fall = sign * law->fall;
        s.e[0] = decay((v_belt - x[1]) * s.rate);
        s.of_p = fma_of(s.fall, s.e[0], s.of_p), s.of_newest = s.fall * p;
    }
    s.x[0] = x[0], s.x[1] = x[1];
    V along = fma_of(s.of_p, p, fma_of(s.a_x, x[0], s.b_x * y0));
    V across = fma_of(s.a_y, x[0] - y0, p) - f->load;
    along = fma_of(s.damping_x, x[1], along);
    s.u[0] = of == HOLDING ? splat(0.0) : along, s.v[0] = fma_of(s.damping_y, y[1], across);
    if (of == FALLING)
        s.by_start = s.rate * s.u[0], s.by_first = s.rate * s.e[0];
    s.x[2] = s.u[0] * 0.5, of_y->y[2] = s.v[0] * 0.5;
    add_sliding_terms(&s, 0, cubic, of, x, y);
    add_sliding_terms(&s, 4, cubic, of, x, y);
    if (order == 8)
        return;
    add_sliding_terms(&s, 8, cubic, of, x, y);
    if (order == 12)
        return;
    add_sliding_terms(&s, 12, cubic, of, x, y);
    if (order == 16)
        return;
    add_sliding_terms(&s, 16, cubic, of, x, y);
}

INLINE void slide_either(V *x, V *y, const Field *f, const Law *law, V v_belt, int order, int cubic,
                         Friction of)
{
    if (cubic)
        slide(x, y, f, law, v_belt, order, 1, of);
    else
        slide(x, y, f, law, v_belt, order, 0, of);
}

APART void expand_falling(V *x, V *y, const Field *f, const Law *law, V v_belt, int order, int cubic)
{
    slide_either(x, y, f, law, v_belt, order, cubic, FALLING);
}

APART void expand_not_falling(V *x, V *y, const Field *f, const Law *law, V v_belt, int order,
                              int cubic)
{
    slide_either(x, y, f, law, v_belt, order, cubic, LEVEL);
}

#if LANES == 1
/* Where the slider sticks, x is on the line of the belt. */
APART void expand_holding(V *x, V *y, const Field *f, const Law *law, V v_belt, int order,
                          int cubic)
{
    slide_either(x, y, f, law, v_belt, order, cubic, HOLDING);
}
#endif

/* Expand a step by a friction law, in whatever mode: where the slider is far from the speed of the
   belt, or does not slide, friction does not fall. */
INLINE void expand_by_law(V *x, V *y, const Field *f, const Law *law, V v_belt, int order, int cubic)
{
    V exponent = law->sign * (v_belt - x[1]) * law->per_speed;
    M falls = (law->per_speed > 0.0) & negated(exponent > FAR);
    Law here = *law;
    here.fall = choose(falls, law->fall, splat(0.0));
    if (bits_of(falls))
        expand_falling(x, y, f, &here, v_belt, order, cubic);
    else
        expand_not_falling(x, y, f, &here, v_belt, order, cubic);
}

/* The part of a step over which the expansion of the law holds, or e stays below rounding; `speed`
   is v at its start. */
INLINE V limited(V h, const V *x, const Law *law, V speed, int groups)
{
    V exponent = greatest(speed * law->per_speed, splat(0.0));
    V allowed = greatest(exponent * WIDENING + MOST_CHANGE, exponent - NEGLIGIBLE);
    for (;;) {
        M far = weighed(DEGREES, x, groups, h) * law->per_speed > allowed * h;
        if (!bits_of(far))
            return h;
        h = choose(far, h * SHRINKING, h);
    }
}

#endif
