/* Taylor coefficients of the motion, by the recurrences of `fivtui.taylor.recurrences`.

   With z = (x, y), Eqs. 2 and 5 divided by the mass read

       z̈ = a x + b y + C ż − d y³ − (0, F/m)

   Derivatives of z at the start of the step are Zₙ, coefficients zₙ = Zₙ/n!; a power of two, SCALE,
   keeps the derivatives within the range of the coefficients. With s = y y, q = y s
   and rₙ = sₙ + y₀ yₙ they are, sums being over 0 < i < n,

       Zₙ₊₂ = C Zₙ₊₁ + a Xₙ + (b − 3 d y₀²) Yₙ − n! d pₙ − (0, F/m) δₙ₀
       rₙ = 3 y₀ yₙ + Σ yᵢ yₙ₋ᵢ,   pₙ = Σ yᵢ rₙ₋ᵢ

   Terms are summed from the middle outwards: what becomes known last comes last. What two terms
   later needs of the sums is added up ahead, so that the processor need not wait for it. */

#ifndef FIVTUI_EXPANSION_H
#define FIVTUI_EXPANSION_H

#include "exponential.h"
#include "tables.h"

/* a, b, the diagonal of C, d and F/m of the field that governs the step. */
typedef struct {
    V a_x, a_y, b_x, b_y, damping_x, damping_y, d_x, d_y, load;
} Field;

/* What is carried from term to term: derivatives, yₙ, rₙ, both in a pair and the other way round,
   3 y₀, 2 y₁, and both sums without the terms that come last. */
typedef struct {
    Pair a, b, damping, minus_d, derivative[FEWER_ROWS], yr[FEWER_ROWS], ry[FEWER_ROWS];
    V y[FEWER_ROWS], r[FEWER_ROWS], square[FEWER_ROWS], product[FEWER_ROWS], thrice, twice;
} Terms;

#define SCALE 0x1p-64

/* Σ yᵢ yₙ₋ᵢ and Σ yᵢ rₙ₋ᵢ over 1 < i < n − 1. */
INLINE void sum_ahead(Terms *s, int n)
{
    V middle_square = s->y[n / 2] * s->y[n - n / 2];
    if (n % 2 == 1) {
        UNROLLED for (int i = n / 2 - 1; i > 1; i--)
            middle_square = fma_of(s->y[i], s->y[n - i], middle_square);
        s->square[n] = middle_square + middle_square;
    } else if (n == 4) {
        s->square[n] = middle_square;
    } else {
        V mixed = s->y[n / 2 - 1] * s->y[n / 2 + 1];
        UNROLLED for (int i = n / 2 - 2; i > 1; i--)
            mixed = fma_of(s->y[i], s->y[n - i], mixed);
        s->square[n] = fma_of(mixed, splat(2.0), middle_square);
    }
    V middle = s->y[n / 2] * s->r[n / 2];
    if (n == 4) {
        s->product[n] = middle;
        return;
    }
    int first = (n - 1) / 2;
    Pair both = pair_product(s->yr[n - first], s->ry[first]);
    UNROLLED for (int i = first - 1; i > 1; i--)
        both = pair_fma(s->yr[n - i], s->ry[i], both);
    V sum = X_OF(both) + Y_OF(both);
    if (n % 2 == 0)
        sum = sum + middle;
    s->product[n] = sum;
}

/* pₙ for n > 1 */
INLINE V product_of_terms(const Terms *s, int n)
{
    if (n == 2)
        return s->y[1] * s->r[1];
    if (n == 3)
        return fma_of(s->y[1], s->r[2], s->y[2] * s->r[1]);
    return fma_of(s->y[1], s->r[n - 1], fma_of(s->y[n - 1], s->r[1], s->product[n]));
}

/* rₙ, and what is added up ahead. */
INLINE void add_square(Terms *s, int n)
{
    if (n == 1)
        s->r[1] = s->thrice * s->y[1];
    else if (n == 2)
        s->r[2] = fma_of(s->thrice, s->y[2], s->y[1] * s->y[1]);
    else if (n == 3)
        s->r[3] = fma_of(s->thrice, s->y[3], s->twice * s->y[2]);
    else
        s->r[n] = fma_of(s->thrice, s->y[n], fma_of(s->twice, s->y[n - 1], s->square[n]));
    s->yr[n] = pair_of(s->y[n], s->r[n]);
    s->ry[n] = pair_of(s->r[n], s->y[n]);
    if (n > 1 && n + 2 < MAX_ORDER)
        sum_ahead(s, n + 2);
}

/* Zₙ₊₂ */
INLINE void add_term(Terms *s, int n, int cubic)
{
    Pair force = pair_fma_by(s->b, Y_OF(s->derivative[n]), pair_times(s->a, X_OF(s->derivative[n])));
    if (cubic && n > 1)
        force = pair_fma_by(s->minus_d, product_of_terms(s, n) * (FACTORIAL[n] * SCALE), force);
    s->derivative[n + 2] = pair_fma(s->damping, s->derivative[n + 1], force);
    s->y[n + 2] = Y_OF(s->derivative[n + 2]) * (1.0 / (FACTORIAL[n + 2] * SCALE));
    if (cubic)
        add_square(s, n);
}

/* Four terms, stored. */
INLINE void add_terms(Terms *s, int n, int cubic, V *x, V *y)
{
    if (n > 0)
        add_term(s, n, cubic);
    add_term(s, n + 1, cubic);
    add_term(s, n + 2, cubic);
    add_term(s, n + 3, cubic);
#if LANES == 1
    Pair i = s->derivative[n + 2], j = s->derivative[n + 3];
    Pair k = s->derivative[n + 4], l = s->derivative[n + 5];
    const Four share = {1.0 / (FACTORIAL[n + 2] * SCALE), 1.0 / (FACTORIAL[n + 3] * SCALE),
                        1.0 / (FACTORIAL[n + 4] * SCALE), 1.0 / (FACTORIAL[n + 5] * SCALE)};
    *(FourPacked *)(x + n + 2) = (Four){i[0], j[0], k[0], l[0]} * share;
    *(FourPacked *)(y + n + 2) = (Four){i[1], j[1], k[1], l[1]} * share;
#else
    UNROLLED for (int i = n + 2; i < n + 6; i++) {
        x[i] = s->derivative[i].x * (1.0 / (FACTORIAL[i] * SCALE));
        y[i] = s->y[i];
    }
#endif
}

/* Continue the first two coefficients of x and y to the degree `order` + 1; `order` is 8, 12, 16 or
   20. Where the field is linear the cubic terms may be left out: they are zero. */
INLINE void expand(V *x, V *y, const Field *f, int order, int cubic)
{
    Terms s;
    s.a = pair_of(f->a_x, f->a_y);
    s.b = pair_of(f->b_x, f->b_y);
    s.damping = pair_of(f->damping_x, f->damping_y);
    s.minus_d = pair_of(-f->d_x, -f->d_y);
    s.derivative[0] = pair_of(x[0] * SCALE, y[0] * SCALE);
    s.derivative[1] = pair_of(x[1] * SCALE, y[1] * SCALE);
    s.y[0] = y[0], s.y[1] = y[1];
    Pair force = pair_fma_by(s.b, y[0] * SCALE, pair_times(s.a, x[0] * SCALE));
    force = pair_of(X_OF(force), Y_OF(force) - f->load * SCALE);
    if (cubic) {
        V square = y[0] * y[0];
        force = pair_fma_by(s.minus_d, square * y[0] * SCALE, force);
        s.b = pair_fma_by(s.minus_d, square * 3.0, s.b);
        s.thrice = y[0] * 3.0;
        s.twice = y[1] + y[1];
    }
    s.derivative[2] = pair_fma(s.damping, s.derivative[1], force);
    s.y[2] = Y_OF(s.derivative[2]) * (0.5 / SCALE);
    add_terms(&s, 0, cubic, x, y);
    add_terms(&s, 4, cubic, x, y);
    if (order == 8)
        return;
    add_terms(&s, 8, cubic, x, y);
    if (order == 12)
        return;
    add_terms(&s, 12, cubic, x, y);
    if (order == 16)
        return;
    add_terms(&s, 16, cubic, x, y);
}

#endif
