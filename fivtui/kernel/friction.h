/* Expansion of sliding with the friction law μ + (μ_s − μ) exp(−v/v_s), v = |v_r|: by the
   recurrences of `fivtui.taylor.friction`. */

#ifndef FIVTUI_FRICTION_H
#define FIVTUI_FRICTION_H

#include "expansion.h"
#include "polynomial.h"

/* As in `fivtui.taylor.friction`. */
#define MOST_CHANGE 12.0
#define WIDENING 0.09
#define NEGLIGIBLE 37.0
#define FAR ((NEGLIGIBLE + MOST_CHANGE) / (1.0 - WIDENING))
#define SHRINKING 0.75
#define TERMS (MAX_LAW_ORDER + 2)
static const double DEGREES[MAX_LAW_ORDER] = {
    2.0,  3.0,  4.0,  5.0,  6.0,  7.0,  8.0,  9.0,  10.0, 11.0,
    12.0, 13.0, 14.0, 15.0, 16.0, 17.0, 18.0, 19.0, 20.0, 21.0,
    22.0, 23.0, 24.0, 25.0,
};

/* How friction goes on: it falls with the speed, or it does not, or it holds the slider. */
typedef enum { FALLING, LEVEL, HOLDING } Friction;

/* The sign of friction, 0 where the slider does not slide, its constant part, its fall, and 1/v_s, 0
   where friction is constant; and k2/m, 0 where there is no contact. */
typedef struct {
    V sign, mu, fall, per_speed, contact;
} Law;

/* What is carried from term to term: (xₙ, yₙ) and their coefficients (uₙ, vₙ) of ẍ and ÿ; eₙ; with p
   that of P/m and rₙ = −d (3 y₀ yₙ + Σ yᵢ yₙ₋ᵢ), all sums being over 0 < i < n, (rₙ, −d yₙ) in
   `bent`, which times y makes Σ rᵢ yₙ₋ᵢ and −d Σ yᵢ yₙ₋ᵢ, and (pₙ, uₙ₋₁) in `driven`, which times e
   makes Σ pᵢ eₙ₋ᵢ and Σ uᵢ₋₁ eₙ₋ᵢ; parts of these sums that are known two degrees ahead, so that the
   processor need not wait for them, and `both`, in which all four are summed side by side. Then the
   factors of

       (pₙ, rₙ) = own yₙ + Σ bentᵢ yₙ₋ᵢ
       (uₙ, vₙ) = a xₙ + b yₙ + of_p pₙ + (damping (uₙ₋₁, vₙ₋₁) + (f, 0))/n
       n eₙ = first uₙ₋₁ + slow eₙ₋₁ + rate Σ uᵢ₋₁ eₙ₋ᵢ
       f = swift eₙ₋₁ + turn Σ uᵢ₋₁ eₙ₋ᵢ + n fall Σ pᵢ eₙ₋ᵢ

   where the first terms of the sums with e are in the factors: `swift` grows with n by `more`. */
typedef struct {
    Pair z[TERMS], w[TERMS], bent[TERMS], driven[TERMS], bent_ahead[TERMS], driven_ahead[TERMS];
    Four both[TERMS], by_both[TERMS];
    V y[TERMS], v[TERMS], e[TERMS];
    Pair a, b, of_p, own, damping;
    V minus_d, first, slow, rate, swift, more, turn, fall;
} Slide;

/* Σ aᵢ bₙ₋ᵢ over 2 < i < n − 1, from the middle outwards. */
#define SUM_AHEAD(type, product, fma)                                                             \
    int low = (n + 1) / 2;                                                                        \
    type sum = product(a[low], b[n - low]);                                                       \
    UNROLLED for (int i = 1; i < n - low - 1; i++) {                                              \
        if (low - i > 2)                                                                          \
            sum = fma(a[low - i], b[n - low + i], sum);                                           \
        sum = fma(a[low + i], b[n - low - i], sum);                                               \
    }                                                                                             \
    return sum;
INLINE Pair pairs_ahead(const Pair *a, const V *b, int n)
{
    SUM_AHEAD(Pair, pair_times, pair_fma_by)
}
INLINE Four fours_ahead(const Four *a, const Four *b, int n)
{
    SUM_AHEAD(Four, four_product, four_fma_each)
}
#undef SUM_AHEAD

INLINE void sum_ahead_of(Slide *s, int n, int cubic, Friction of)
{
    if (n < 5)
        return;
    if (cubic && of == FALLING) {
        Four sums = fours_ahead(s->both, s->by_both, n);
        s->driven_ahead[n] = first_pair(sums), s->bent_ahead[n] = second_pair(sums);
    } else if (cubic) {
        s->bent_ahead[n] = pairs_ahead(s->bent, s->y, n);
    } else if (of == FALLING) {
        s->driven_ahead[n] = pairs_ahead(s->driven, s->e, n);
    }
}

/* Σ bentᵢ yₙ₋ᵢ, for n > 1 */
INLINE Pair bent_sums(const Slide *s, int n)
{
    const V *y = s->y;
    Pair sums = pair_times(s->bent[1], y[n - 1]);
    if (n > 3)
        sums = pair_fma_by(s->bent[1], y[n - 1], pair_times(s->bent[2], y[n - 2]));
    if (n > 4)
        sums = pair_sum(sums, s->bent_ahead[n]);
    return n > 2 ? pair_fma_by(s->bent[n - 1], y[1], sums) : sums;
}

/* Σ drivenᵢ eₙ₋ᵢ but for the first terms, for n > 2 */
INLINE Pair driven_sums(const Slide *s, int n)
{
    const V *e = s->e;
    if (n == 3)
        return pair_times(s->driven[2], e[1]);
    Pair sums = n == 4 ? pair_times(s->driven[2], e[2])
                       : pair_fma_by(s->driven[2], e[n - 2], s->driven_ahead[n]);
    return pair_fma_by(s->driven[n - 1], e[1], sums);
}

/* eₙ; returns damping (uₙ₋₁, vₙ₋₁) + (f, 0). */
INLINE Pair add_fall(Slide *s, int n)
{
    V u = X_OF(s->w[n - 1]);
    s->swift = s->swift + s->more;
    if (n == 1) {
        s->e[1] = s->first * u;
        return pair_product(s->damping, s->w[0]);
    }
    V last = s->e[n - 1], next = s->slow * last, f = s->swift * last;
    if (n > 2) {
        Pair sums = driven_sums(s, n);
        next = fma_of(s->slow, last, Y_OF(sums) * s->rate);
        f = fma_of(s->swift, last, fma_of(Y_OF(sums), s->turn, X_OF(sums) * (s->fall * (double)n)));
    }
    s->e[n] = fma_of(s->first, u, next) * (1.0 / n);
    return pair_fma(s->damping, s->w[n - 1], pair_of(f, splat(0.0)));
}

/* xₙ₊₂ and yₙ₊₂, for n > 0 */
INLINE void add_sliding_term(Slide *s, int n, int cubic, Friction of)
{
    V x = X_OF(s->z[n]), y = Y_OF(s->z[n]);
    s->y[n] = y;
    Pair own = pair_times(s->own, y);
    if (cubic && n > 1)
        own = pair_fma_by(s->own, y, bent_sums(s, n));
    V p = X_OF(own);
    if (n == 1 && of == FALLING)
        s->more = s->fall * p;
    s->bent[n] = pair_of(Y_OF(own), y * s->minus_d);
    s->driven[n] = pair_of(p, X_OF(s->w[n - 1]));
    Pair drag = of == FALLING ? add_fall(s, n) : pair_product(s->damping, s->w[n - 1]);
    Pair pull = pair_fma_by(s->of_p, p, pair_fma_by(s->b, y, pair_times(s->a, x)));
    s->w[n] = pair_fma_by(drag, splat(1.0 / n), pull);
    s->z[n + 2] = pair_times(s->w[n], splat(1.0 / ((n + 1) * (n + 2))));
    if (cubic && of == FALLING) {
        s->both[n] = joined(s->driven[n], s->bent[n]);
        s->by_both[n] = joined(pair_of(s->e[n], s->e[n]), pair_of(y, y));
    }
}

/* The same of y alone where the slider sticks: x is on the line of the belt. */
INLINE void add_held_term(Slide *s, int n, int cubic)
{
    V y = s->y[n], pull = Y_OF(s->b) * y;
    Pair own = pair_times(s->own, y);
    if (cubic && n > 1)
        own = pair_fma_by(s->own, y, bent_sums(s, n));
    if (n == 1)
        pull = fma_of(Y_OF(s->b), y, Y_OF(s->a) * X_OF(s->z[1]));
    s->bent[n] = pair_of(Y_OF(own), y * s->minus_d);
    s->v[n] = fma_of(Y_OF(s->damping) * s->v[n - 1], splat(1.0 / n), pull + X_OF(own));
    s->y[n + 2] = s->v[n] * (1.0 / ((n + 1) * (n + 2)));
}

INLINE void add_next_term(Slide *s, int n, int cubic, Friction of)
{
    if (of == HOLDING)
        add_held_term(s, n, cubic);
    else
        add_sliding_term(s, n, cubic, of);
}

/* Four terms, stored. */
INLINE void add_sliding_terms(Slide *s, int n, int cubic, Friction of, V *x, V *y)
{
    sum_ahead_of(s, n, cubic, of);
    sum_ahead_of(s, n + 1, cubic, of);
    if (n > 0)
        add_next_term(s, n, cubic, of);
    sum_ahead_of(s, n + 2, cubic, of);
    add_next_term(s, n + 1, cubic, of);
    sum_ahead_of(s, n + 3, cubic, of);
    add_next_term(s, n + 2, cubic, of);
    add_next_term(s, n + 3, cubic, of);
#if LANES == 1
    const Four share = {1.0 / ((n + 1) * (n + 2)), 1.0 / ((n + 2) * (n + 3)),
                        1.0 / ((n + 3) * (n + 4)), 1.0 / ((n + 4) * (n + 5))};
    if (of == HOLDING) {
        *(FourPacked *)(x + n + 2) = (Four){0.0};
        *(FourPacked *)(y + n + 2) = (Four){s->v[n], s->v[n + 1], s->v[n + 2], s->v[n + 3]} * share;
        return;
    }
    Pair i = s->w[n], j = s->w[n + 1], k = s->w[n + 2], l = s->w[n + 3];
    *(FourPacked *)(x + n + 2) = (Four){i[0], j[0], k[0], l[0]} * share;
    *(FourPacked *)(y + n + 2) = (Four){i[1], j[1], k[1], l[1]} * share;
#else
    UNROLLED for (int i = n + 2; i < n + 6; i++)
        x[i] = X_OF(s->z[i]), y[i] = Y_OF(s->z[i]);
#endif
}

/* Continue the first two coefficients of x and y in the field `f` without the contact, but d of ÿ,
   from e at the start; where friction does not fall, with the bits of a fall of 0. Without `highest`
   the order is 20 at most. */
INLINE void slide(V *x, V *y, const Field *f, const Law *law, V e, int order, int highest,
                  int cubic, Friction of)
{
    Slide s;
    V sign = law->sign, y0 = y[0], stiffness = -law->contact, p = stiffness * y0;
    s.minus_d = -f->d_y;
    s.own = pair_of(stiffness, splat(0.0));
    if (cubic) {
        V square = y0 * y0, thrice = s.minus_d * 3.0;
        p = fma_of(s.minus_d, square * y0, p);
        s.own = pair_of(fma_of(thrice, square, stiffness), thrice * y0);
    }
    s.a = pair_of(f->a_x, f->a_y), s.b = pair_of(f->b_x, -f->a_y);
    s.of_p = pair_of(sign * law->mu, splat(1.0));
    s.damping = pair_of(f->damping_x, f->damping_y);
    if (of == FALLING) {
        s.rate = sign * law->per_speed, s.fall = sign * law->fall;
        s.e[0] = e;
        s.of_p = pair_of(fma_of(s.fall, s.e[0], X_OF(s.of_p)), splat(1.0));
    }
    s.y[0] = y0, s.z[1] = pair_of(x[1], y[1]);
    Pair pull = pair_fma_by(s.b, y0, pair_times(s.a, x[0]));
    pull = pair_fma(s.damping, s.z[1], pair_of(X_OF(pull), Y_OF(pull) - f->load));
    s.w[0] = pair_fma_by(s.of_p, p, pull);
    s.z[2] = pair_times(s.w[0], splat(0.5));
    s.y[1] = y[1], s.y[2] = Y_OF(s.z[2]), s.v[0] = Y_OF(s.w[0]);
    if (of == FALLING) {
        s.first = s.rate * s.e[0], s.slow = s.rate * X_OF(s.w[0]);
        s.turn = s.fall * p * s.rate, s.swift = s.fall * p * s.slow;
        s.damping = pair_of(fma_of(s.fall * p, s.first, f->damping_x), f->damping_y);
    }
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
    if (!highest || order == 20)
        return;
    add_sliding_terms(&s, 20, cubic, of, x, y);
}

/* A run of its own is quicker by an expansion to the highest order without tests for lower ones, and
   one to these that ends with the next one. */
INLINE void slide_to(V *x, V *y, const Field *f, const Law *law, V e, int order, int cubic,
                     Friction of)
{
    if (LANES == 1 && order == MAX_LAW_ORDER)
        slide(x, y, f, law, e, MAX_LAW_ORDER, 1, cubic, of);
    else
        slide(x, y, f, law, e, order, LANES > 1, cubic, of);
}

ON_ALIGNED_STACK APART void expand_falling(V *x, V *y, const Field *f, const Law *law, V e,
                                           int order, int cubic)
{
    if (cubic)
        slide_to(x, y, f, law, e, order, 1, FALLING);
    else
        slide_to(x, y, f, law, e, order, 0, FALLING);
}

APART void expand_not_falling(V *x, V *y, const Field *f, const Law *law, int order, int cubic)
{
    if (cubic)
        slide_to(x, y, f, law, splat(0.0), order, 1, LEVEL);
    else
        slide_to(x, y, f, law, splat(0.0), order, 0, LEVEL);
}

#if LANES == 1
/* Where the slider sticks. */
APART void expand_holding(V *x, V *y, const Field *f, const Law *law, int order, int cubic)
{
    if (cubic)
        slide_to(x, y, f, law, splat(0.0), order, 1, HOLDING);
    else
        slide_to(x, y, f, law, splat(0.0), order, 0, HOLDING);
}
#endif

/* v/v_s, 0 where the slider does not slide by a law. */
INLINE V exponent_of(const Law *law, V v_belt, V vx) { return law->sign * (v_belt - vx) * law->per_speed; }

/* e at a speed, where its exponent may be `known`, and e there. */
typedef struct {
    V exponent, e;
} Start;

INLINE V start_of(V exponent, const Start *known)
{
    M same = exponent == known->exponent;
    return bits_of(same) == ALL_LANES ? known->e : exponential(-exponent);
}

/* Expand a step by a friction law, in whatever mode: where the slider is far from the speed of the
   belt, or does not slide, friction does not fall. */
INLINE void expand_by_law(V *x, V *y, const Field *f, const Law *law, V v_belt, const Start *known,
                          int order, int cubic)
{
    V exponent = exponent_of(law, v_belt, x[1]);
    M falls = (law->per_speed > 0.0) & negated(exponent > FAR);
    Law here = *law;
    here.fall = choose(falls, law->fall, splat(0.0));
    if (bits_of(falls))
        expand_falling(x, y, f, &here, start_of(exponent, known), order, cubic);
    else
        expand_not_falling(x, y, f, &here, order, cubic);
}

/* The part of a step over which the expansion of the law holds, or e stays below rounding; `speed`
   is v at its start. `stays` says whether v stays positive in it for certain. */
INLINE V limited(V h, const V *x, const Law *law, V speed, int groups, M *stays)
{
    V exponent = greatest(speed * law->per_speed, splat(0.0));
    V allowed = greatest(exponent * WIDENING + MOST_CHANGE, exponent - NEGLIGIBLE);
    for (;;) {
        V change = weighed(DEGREES, x, groups, h);
        M far = change * law->per_speed > allowed * h;
        *stays = change < speed * h;
        if (!bits_of(far))
            return h;
        h = choose(far, h * SHRINKING, h);
    }
}

#endif
