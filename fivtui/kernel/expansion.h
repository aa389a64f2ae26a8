/* Taylor coefficients of the motion, by the recurrences of `fivtui.taylor.series`.

   With z = (x, y), Eqs. 2 and 5 of the paper divided by the mass read

       z̈ = a x + b y + C ż − d y³ − (0, F/m)

   Derivatives of z at the start of the step are Zₙ, coefficients zₙ = Zₙ/n!. Where n! is large Zₙ
   could overflow although zₙ does not: all Zₙ are multiplied by a small power of two, SCALE. With
   s = y y, q = y s and rₙ = sₙ + y₀ yₙ they are, sums being over 0 < i < n,

       Zₙ₊₂ = C Zₙ₊₁ + a Xₙ + (b − 3 d y₀²) Yₙ − n! d pₙ − (0, F/m) δₙ₀
       rₙ = 3 y₀ yₙ + Σ yᵢ yₙ₋ᵢ,   pₙ = Σ yᵢ rₙ₋ᵢ

   as sₙ = 2 y₀ yₙ + Σ yᵢ yₙ₋ᵢ. Terms are summed from the middle outwards: the newest coefficients
   come last. Parts of the sums are computed two degrees ahead, so that the processor need not wait
   for them. */

#ifndef FIVTUI_EXPANSION_H
#define FIVTUI_EXPANSION_H

#include "exponential.h"
#include "tables.h"

/* a, b, the diagonal of C, d and F/m in the mode of the step, as in the equation above: `damping_x`
   is the factor of ẋ in ẍ, hence negative, and `load` is F/m. */
typedef struct {
    V a_x, a_y, b_x, b_y, damping_x, damping_y, d_x, d_y, load;
} Field;

/* State of the recurrence: factors of the field, derivatives Zₙ, the pairs (yₙ, rₙ) and (rₙ, yₙ),
   yₙ, rₙ, the parts of Σ yᵢ yₙ₋ᵢ and Σ yᵢ rₙ₋ᵢ that are computed ahead, 3 y₀ and 2 y₁. */
typedef struct {
    Pair a, b, damping, minus_d, derivative[MAX_TERMS_WITHOUT_LAW], yr[MAX_TERMS_WITHOUT_LAW],
        ry[MAX_TERMS_WITHOUT_LAW];
    V y[MAX_TERMS_WITHOUT_LAW], r[MAX_TERMS_WITHOUT_LAW], square_ahead[MAX_TERMS_WITHOUT_LAW],
        product_ahead[MAX_TERMS_WITHOUT_LAW], triple_y0, double_y1;
} Terms;

/* Factor of all derivatives, see above. */
#define SCALE 0x1p-64

/* Store Σ yᵢ yₙ₋ᵢ and Σ yᵢ rₙ₋ᵢ over 1 < i < n − 1, the parts that are computed ahead. */
INLINE void sum_ahead(Terms *s, int n)
{
    V middle_square = s->y[n / 2] * s->y[n - n / 2];
    if (n % 2 == 1) {
        UNROLL for (int i = n / 2 - 1; i > 1; i--)
            middle_square = vfma(s->y[i], s->y[n - i], middle_square);
        s->square_ahead[n] = middle_square + middle_square;
    } else if (n == 4) {
        s->square_ahead[n] = middle_square;
    } else {
        V mixed = s->y[n / 2 - 1] * s->y[n / 2 + 1];
        UNROLL for (int i = n / 2 - 2; i > 1; i--)
            mixed = vfma(s->y[i], s->y[n - i], mixed);
        s->square_ahead[n] = vfma(mixed, splat(2.0), middle_square);
    }
    V middle = s->y[n / 2] * s->r[n / 2];
    if (n == 4) {
        s->product_ahead[n] = middle;
        return;
    }
    /* The products of a pair are yₙ₋ᵢ rᵢ and rₙ₋ᵢ yᵢ. */
    int first = (n - 1) / 2;
    Pair sums = pair_product(s->yr[n - first], s->ry[first]);
    UNROLL for (int i = first - 1; i > 1; i--)
        sums = pair_fma(s->yr[n - i], s->ry[i], sums);
    V sum = PAIR_X(sums) + PAIR_Y(sums);
    if (n % 2 == 0)
        sum = sum + middle;
    s->product_ahead[n] = sum;
}

/* pₙ = Σ yᵢ rₙ₋ᵢ for n > 1. */
INLINE V product_of_terms(const Terms *s, int n)
{
    if (n == 2)
        return s->y[1] * s->r[1];
    if (n == 3)
        return vfma(s->y[1], s->r[2], s->y[2] * s->r[1]);
    return vfma(s->y[1], s->r[n - 1], vfma(s->y[n - 1], s->r[1], s->product_ahead[n]));
}

/* Store rₙ, and the sums that are computed ahead. */
INLINE void add_square(Terms *s, int n)
{
    if (n == 1)
        s->r[1] = s->triple_y0 * s->y[1];
    else if (n == 2)
        s->r[2] = vfma(s->triple_y0, s->y[2], s->y[1] * s->y[1]);
    else if (n == 3)
        s->r[3] = vfma(s->triple_y0, s->y[3], s->double_y1 * s->y[2]);
    else
        s->r[n] = vfma(s->triple_y0, s->y[n], vfma(s->double_y1, s->y[n - 1], s->square_ahead[n]));
    s->yr[n] = make_pair(s->y[n], s->r[n]);
    s->ry[n] = make_pair(s->r[n], s->y[n]);
    /* Sums of index n + 2 enter the coefficient of degree n + 4, which is at most MAX_ORDER + 1.
       Those up to index 3 have no part that is computed ahead. */
    if (n > 1 && n + 2 < MAX_ORDER)
        sum_ahead(s, n + 2);
}

/* Store Zₙ₊₂ and yₙ₊₂. */
INLINE void add_term(Terms *s, int n, int cubic)
{
    Pair force = pair_fma_by(s->b, PAIR_Y(s->derivative[n]),
                             pair_times(s->a, PAIR_X(s->derivative[n])));
    if (cubic && n > 1)
        force = pair_fma_by(s->minus_d, product_of_terms(s, n) * (FACTORIAL[n] * SCALE), force);
    s->derivative[n + 2] = pair_fma(s->damping, s->derivative[n + 1], force);
    s->y[n + 2] = PAIR_Y(s->derivative[n + 2]) * (1.0 / (FACTORIAL[n + 2] * SCALE));
    if (cubic)
        add_square(s, n);
}

/* Store the coefficients of the degrees n + 2 to n + 5; `expand` has set degree 2. */
INLINE void add_terms(Terms *s, int n, int cubic, V *x, V *y)
{
    if (n > 0)
        add_term(s, n, cubic);
    add_term(s, n + 1, cubic);
    add_term(s, n + 2, cubic);
    add_term(s, n + 3, cubic);
#if LANES == 1
    const Pair *z = s->derivative + n + 2;
    const Four scale = {1.0 / (FACTORIAL[n + 2] * SCALE), 1.0 / (FACTORIAL[n + 3] * SCALE),
                        1.0 / (FACTORIAL[n + 4] * SCALE), 1.0 / (FACTORIAL[n + 5] * SCALE)};
    *(FourPacked *)(x + n + 2) = (Four){z[0][0], z[1][0], z[2][0], z[3][0]} * scale;
    *(FourPacked *)(y + n + 2) = (Four){z[0][1], z[1][1], z[2][1], z[3][1]} * scale;
#else
    UNROLL for (int i = n + 2; i < n + 6; i++) {
        x[i] = s->derivative[i].x * (1.0 / (FACTORIAL[i] * SCALE));
        y[i] = s->y[i];
    }
#endif
}

/* Compute the coefficients of x and y from the first two up to the degree `order` + 1; `order` is
   8, 12, 16 or 20. `cubic` may be 0 where the field is linear. */
INLINE void expand(V *x, V *y, const Field *f, int order, int cubic)
{
    Terms s;
    s.a = make_pair(f->a_x, f->a_y);
    s.b = make_pair(f->b_x, f->b_y);
    s.damping = make_pair(f->damping_x, f->damping_y);
    s.minus_d = make_pair(-f->d_x, -f->d_y);
    s.derivative[0] = make_pair(x[0] * SCALE, y[0] * SCALE);
    s.derivative[1] = make_pair(x[1] * SCALE, y[1] * SCALE);
    s.y[0] = y[0], s.y[1] = y[1];
    Pair force = pair_fma_by(s.b, y[0] * SCALE, pair_times(s.a, x[0] * SCALE));
    force = make_pair(PAIR_X(force), PAIR_Y(force) - f->load * SCALE);
    if (cubic) {
        V square = y[0] * y[0];
        force = pair_fma_by(s.minus_d, square * y[0] * SCALE, force);
        s.b = pair_fma_by(s.minus_d, square * 3.0, s.b);
        s.triple_y0 = y[0] * 3.0;
        s.double_y1 = y[1] + y[1];
    }
    s.derivative[2] = pair_fma(s.damping, s.derivative[1], force);
    s.y[2] = PAIR_Y(s.derivative[2]) * (0.5 / SCALE);
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
