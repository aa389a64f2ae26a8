/* Expansion of sliding with the friction law μ + (μ_s − μ) e with e = exp(−v/v_s), where v = |v_r|
   is the sliding speed. The method is that of `expansion.h`. */

#ifndef FIVTUI_FRICTION_H
#define FIVTUI_FRICTION_H

#include "expansion.h"
#include "polynomial.h"

/* Equal to `_MAX_CHANGE` and so on in `fivtui.taylor.belt`: largest change of v/v_s over a step and
   its growth with v/v_s, v/v_s at which e is negligible, and the factor by which a step is
   shortened. */
#define MAX_CHANGE 12.0
#define GROWTH 0.09
#define NEGLIGIBLE 37.0
#define SHRINK_FACTOR 0.75
/* From this v/v_s on, v/v_s stays above NEGLIGIBLE over a full step: E − (MAX_CHANGE + GROWTH
   E) ≥ NEGLIGIBLE, solved for E. So e is negligible there. */
#define FAR_EXPONENT ((NEGLIGIBLE + MAX_CHANGE) / (1.0 - GROWTH))
#define MAX_LAW_TERMS (MAX_LAW_ORDER + 2)
/* Factors n of the terms n cₙ tⁿ⁻¹ of a slope, from n = 2 on: `limit_step` bounds the change of ẋ
   by them. */
static const double DEGREES[MAX_LAW_ORDER] = {
    2.0,  3.0,  4.0,  5.0,  6.0,  7.0,  8.0,  9.0,  10.0, 11.0,
    12.0, 13.0, 14.0, 15.0, 16.0, 17.0, 18.0, 19.0, 20.0, 21.0,
    22.0, 23.0, 24.0, 25.0,
};

/* Friction falls with the speed, is constant, or holds the slider at the speed of the belt. */
typedef enum { FRICTION_FALLS, FRICTION_CONSTANT, FRICTION_STICKS } FrictionKind;

/* A friction law in a mode: sign of friction (0 without sliding), μ, μ_s − μ (`mu_drop`), 1/v_s (0
   for constant friction), and k2/m (0 without contact). */
typedef struct {
    V sign, mu, mu_drop, per_speed, contact;
} Law;

/* State of the recurrence. z has (xₙ, yₙ), w their accelerations (uₙ, vₙ), e the coefficients of
   exp(−v/v_s), p those of P/m, where P is the contact force, and rₙ = −d (3 y₀ yₙ + Σ yᵢ yₙ₋ᵢ):
   that of `expansion.h` times −d. Sums are over 0 < i < n. `y_pairs` has (rₙ, −d yₙ), whose
   products with y sum to Σ rᵢ yₙ₋ᵢ and −d Σ yᵢ yₙ₋ᵢ. `e_pairs` has (pₙ, uₙ₋₁), whose products with
   e sum to Σ pᵢ eₙ₋ᵢ and Σ uᵢ₋₁ eₙ₋ᵢ. Parts of these sums are computed two degrees ahead, so that
   the processor need not wait for them; `pairs` sums all four side by side.

   The n-th coefficient of friction over m has the x-part of contact_factors pₙ. Its rest is mu_drop
   (p₀ eₙ + Σ pᵢ eₙ₋ᵢ), where `mu_drop` has the sign of friction. n times the rest is f, apart from
   a term with uₙ₋₁, which is added to `damping`:

       (pₙ, rₙ) = factors yₙ + Σ y_pairsᵢ yₙ₋ᵢ
       (uₙ, vₙ) = a xₙ + b yₙ + contact_factors pₙ + (damping (uₙ₋₁, vₙ₋₁) + (f, 0))/n
       n eₙ = first_factor uₙ₋₁ + last_factor eₙ₋₁ + rate Σ uᵢ₋₁ eₙ₋ᵢ
       f = force_factor eₙ₋₁ + force_rate Σ uᵢ₋₁ eₙ₋ᵢ + n mu_drop Σ pᵢ eₙ₋ᵢ

   In the last two lines sums are over 1 < i < n: `last_factor` and `force_factor` include the terms
   of i = 1. Hence force_factor = force_rate u₀ + n mu_drop p₁ grows with n by
   `force_factor_step`. */
typedef struct {
    Pair z[MAX_LAW_TERMS], w[MAX_LAW_TERMS], y_pairs[MAX_LAW_TERMS], e_pairs[MAX_LAW_TERMS],
        y_sums_ahead[MAX_LAW_TERMS], e_sums_ahead[MAX_LAW_TERMS];
    Four pairs[MAX_LAW_TERMS], pair_factors[MAX_LAW_TERMS];
    V y[MAX_LAW_TERMS], v[MAX_LAW_TERMS], e[MAX_LAW_TERMS];
    Pair a, b, contact_factors, factors, damping;
    V minus_d, first_factor, last_factor, rate, force_factor, force_factor_step, force_rate,
        mu_drop;
} SlideTerms;

/* Body of a function: Σ aᵢ bₙ₋ᵢ over 2 < i < n − 1, summed from the middle outwards. If n is even,
   there is one term less below the middle than above it. `type` is that of the elements of a,
   `product` and `fma` are the operations on it. */
#define SUM_AHEAD(type, product, fma)                                                             \
    int middle = (n + 1) / 2;                                                                     \
    type sum = product(a[middle], b[n - middle]);                                                 \
    UNROLL for (int i = 1; i < n - middle - 1; i++) {                                             \
        if (middle - i > 2)                                                                       \
            sum = fma(a[middle - i], b[n - middle + i], sum);                                     \
        sum = fma(a[middle + i], b[n - middle - i], sum);                                         \
    }                                                                                             \
    return sum;
INLINE Pair pairs_ahead(const Pair *a, const V *b, int n)
{
    SUM_AHEAD(Pair, pair_times, pair_fma_by)
}
INLINE Four fours_ahead(const Four *a, const Four *b, int n)
{
    SUM_AHEAD(Four, four_product, four_fma)
}
#undef SUM_AHEAD

/* Store the sums of degree n that are computed ahead: those with e if friction falls, those with y
   if the contact spring is cubic. */
INLINE void sum_slide_ahead(SlideTerms *s, int n, int cubic, FrictionKind kind)
{
    if (n < 5)
        return;
    if (cubic && kind == FRICTION_FALLS) {
        Four sums = fours_ahead(s->pairs, s->pair_factors, n);
        s->e_sums_ahead[n] = first_pair(sums), s->y_sums_ahead[n] = second_pair(sums);
    } else if (cubic) {
        s->y_sums_ahead[n] = pairs_ahead(s->y_pairs, s->y, n);
    } else if (kind == FRICTION_FALLS) {
        s->e_sums_ahead[n] = pairs_ahead(s->e_pairs, s->e, n);
    }
}

/* Σ y_pairsᵢ yₙ₋ᵢ for n > 1. */
INLINE Pair sums_with_y(const SlideTerms *s, int n)
{
    const V *y = s->y;
    Pair sums = pair_times(s->y_pairs[1], y[n - 1]);
    if (n > 3)
        sums = pair_fma_by(s->y_pairs[1], y[n - 1], pair_times(s->y_pairs[2], y[n - 2]));
    if (n > 4)
        sums = pair_sum(sums, s->y_sums_ahead[n]);
    return n > 2 ? pair_fma_by(s->y_pairs[n - 1], y[1], sums) : sums;
}

/* Σ e_pairsᵢ eₙ₋ᵢ without the first terms, for n > 2. */
INLINE Pair sums_with_e(const SlideTerms *s, int n)
{
    const V *e = s->e;
    if (n == 3)
        return pair_times(s->e_pairs[2], e[1]);
    Pair sums = n == 4 ? pair_times(s->e_pairs[2], e[2])
                       : pair_fma_by(s->e_pairs[2], e[n - 2], s->e_sums_ahead[n]);
    return pair_fma_by(s->e_pairs[n - 1], e[1], sums);
}

/* Store eₙ; returns damping (uₙ₋₁, vₙ₋₁) + (f, 0). `add_sliding_term` has set force_factor_step. */
INLINE Pair add_exponential_term(SlideTerms *s, int n)
{
    V u = PAIR_X(s->w[n - 1]);
    s->force_factor = s->force_factor + s->force_factor_step;
    if (n == 1) {
        s->e[1] = s->first_factor * u;
        return pair_product(s->damping, s->w[0]);
    }
    V last_e = s->e[n - 1], next = s->last_factor * last_e, f = s->force_factor * last_e;
    if (n > 2) {
        Pair sums = sums_with_e(s, n);
        next = vfma(s->last_factor, last_e, PAIR_Y(sums) * s->rate);
        f = vfma(s->force_factor, last_e,
                 vfma(PAIR_Y(sums), s->force_rate, PAIR_X(sums) * (s->mu_drop * (double)n)));
    }
    s->e[n] = vfma(s->first_factor, u, next) * (1.0 / n);
    return pair_fma(s->damping, s->w[n - 1], make_pair(f, splat(0.0)));
}

/* Store xₙ₊₂ and yₙ₊₂ for n > 0. */
INLINE void add_sliding_term(SlideTerms *s, int n, int cubic, FrictionKind kind)
{
    V x = PAIR_X(s->z[n]), y = PAIR_Y(s->z[n]);
    s->y[n] = y;
    Pair factors = pair_times(s->factors, y);
    if (cubic && n > 1)
        factors = pair_fma_by(s->factors, y, sums_with_y(s, n));
    V p = PAIR_X(factors);
    if (n == 1 && kind == FRICTION_FALLS)
        s->force_factor_step = s->mu_drop * p;
    s->y_pairs[n] = make_pair(PAIR_Y(factors), y * s->minus_d);
    s->e_pairs[n] = make_pair(p, PAIR_X(s->w[n - 1]));
    Pair drag = kind == FRICTION_FALLS ? add_exponential_term(s, n)
        : pair_product(s->damping, s->w[n - 1]);
    Pair force = pair_fma_by(s->contact_factors, p, pair_fma_by(s->b, y, pair_times(s->a, x)));
    s->w[n] = pair_fma_by(drag, splat(1.0 / n), force);
    s->z[n + 2] = pair_times(s->w[n], splat(1.0 / ((n + 1) * (n + 2))));
    if (cubic && kind == FRICTION_FALLS) {
        s->pairs[n] = join_pairs(s->e_pairs[n], s->y_pairs[n]);
        s->pair_factors[n] = join_pairs(make_pair(s->e[n], s->e[n]), make_pair(y, y));
    }
}

/* Store yₙ₊₂ where the slider sticks: x moves with the belt. */
INLINE void add_held_term(SlideTerms *s, int n, int cubic)
{
    V y = s->y[n], force = PAIR_Y(s->b) * y;
    Pair factors = pair_times(s->factors, y);
    if (cubic && n > 1)
        factors = pair_fma_by(s->factors, y, sums_with_y(s, n));
    if (n == 1)
        force = vfma(PAIR_Y(s->b), y, PAIR_Y(s->a) * PAIR_X(s->z[1]));
    s->y_pairs[n] = make_pair(PAIR_Y(factors), y * s->minus_d);
    s->v[n] = vfma(PAIR_Y(s->damping) * s->v[n - 1], splat(1.0 / n), force + PAIR_X(factors));
    s->y[n + 2] = s->v[n] * (1.0 / ((n + 1) * (n + 2)));
}

/* Store the coefficients of degree n + 2 for n > 0. */
INLINE void add_next_term(SlideTerms *s, int n, int cubic, FrictionKind kind)
{
    if (kind == FRICTION_STICKS)
        add_held_term(s, n, cubic);
    else
        add_sliding_term(s, n, cubic, kind);
}

/* Store the coefficients of the degrees n + 2 to n + 5. */
INLINE void add_sliding_terms(SlideTerms *s, int n, int cubic, FrictionKind kind, V *x, V *y)
{
    sum_slide_ahead(s, n, cubic, kind);
    sum_slide_ahead(s, n + 1, cubic, kind);
    if (n > 0)
        add_next_term(s, n, cubic, kind);
    sum_slide_ahead(s, n + 2, cubic, kind);
    add_next_term(s, n + 1, cubic, kind);
    sum_slide_ahead(s, n + 3, cubic, kind);
    add_next_term(s, n + 2, cubic, kind);
    add_next_term(s, n + 3, cubic, kind);
#if LANES == 1
    const Four scale = {1.0 / ((n + 1) * (n + 2)), 1.0 / ((n + 2) * (n + 3)),
                        1.0 / ((n + 3) * (n + 4)), 1.0 / ((n + 4) * (n + 5))};
    if (kind == FRICTION_STICKS) {
        *(FourPacked *)(x + n + 2) = (Four){0.0};
        *(FourPacked *)(y + n + 2) = (Four){s->v[n], s->v[n + 1], s->v[n + 2], s->v[n + 3]} * scale;
        return;
    }
    const Pair *w = s->w + n;
    *(FourPacked *)(x + n + 2) = (Four){w[0][0], w[1][0], w[2][0], w[3][0]} * scale;
    *(FourPacked *)(y + n + 2) = (Four){w[0][1], w[1][1], w[2][1], w[3][1]} * scale;
#else
    UNROLL for (int i = n + 2; i < n + 6; i++)
        x[i] = PAIR_X(s->z[i]), y[i] = PAIR_Y(s->z[i]);
#endif
}

/* Compute the coefficients of x and y from the first two; `e` is exp(−v/v_s) at the start. Contact
   and friction follow from `law` and from d_y of `f`: its b_x is that without contact, its b_y and
   d_x are not used. With mu_drop = 0 FRICTION_FALLS gives the same bits as FRICTION_CONSTANT.
   Without `to_max_order` the order is at most 20. */
INLINE void expand_slide(V *x, V *y, const Field *f, const Law *law, V e, int order,
                         int to_max_order, int cubic, FrictionKind kind)
{
    SlideTerms s;
    V sign = law->sign, y0 = y[0], stiffness = -law->contact, p = stiffness * y0;
    s.minus_d = -f->d_y;
    s.factors = make_pair(stiffness, splat(0.0));
    if (cubic) {
        V square = y0 * y0, triple = s.minus_d * 3.0;
        p = vfma(s.minus_d, square * y0, p);
        s.factors = make_pair(vfma(triple, square, stiffness), triple * y0);
    }
    /* Without contact y enters ÿ by the coupling (k3/2) (x − y)/m alone: with the factor −a_y. */
    s.a = make_pair(f->a_x, f->a_y), s.b = make_pair(f->b_x, -f->a_y);
    s.contact_factors = make_pair(sign * law->mu, splat(1.0));
    s.damping = make_pair(f->damping_x, f->damping_y);
    if (kind == FRICTION_FALLS) {
        s.rate = sign * law->per_speed, s.mu_drop = sign * law->mu_drop;
        s.e[0] = e;
        s.contact_factors =
            make_pair(vfma(s.mu_drop, s.e[0], PAIR_X(s.contact_factors)), splat(1.0));
    }
    s.y[0] = y0, s.z[1] = make_pair(x[1], y[1]);
    Pair force = pair_fma_by(s.b, y0, pair_times(s.a, x[0]));
    force = pair_fma(s.damping, s.z[1], make_pair(PAIR_X(force), PAIR_Y(force) - f->load));
    s.w[0] = pair_fma_by(s.contact_factors, p, force);
    s.z[2] = pair_times(s.w[0], splat(0.5));
    s.y[1] = y[1], s.y[2] = PAIR_Y(s.z[2]), s.v[0] = PAIR_Y(s.w[0]);
    if (kind == FRICTION_FALLS) {
        s.first_factor = s.rate * s.e[0], s.last_factor = s.rate * PAIR_X(s.w[0]);
        s.force_rate = s.mu_drop * p * s.rate, s.force_factor = s.mu_drop * p * s.last_factor;
        /* The term first_factor uₙ₋₁ of n eₙ makes friction act as damping. */
        s.damping = make_pair(vfma(s.mu_drop * p, s.first_factor, f->damping_x), f->damping_y);
    }
    add_sliding_terms(&s, 0, cubic, kind, x, y);
    add_sliding_terms(&s, 4, cubic, kind, x, y);
    if (order == 8)
        return;
    add_sliding_terms(&s, 8, cubic, kind, x, y);
    if (order == 12)
        return;
    add_sliding_terms(&s, 12, cubic, kind, x, y);
    if (order == 16)
        return;
    add_sliding_terms(&s, 16, cubic, kind, x, y);
    if (!to_max_order || order == 20)
        return;
    add_sliding_terms(&s, 20, cubic, kind, x, y);
}

/* Expand to an order. A single run is faster with a function of its own for the greatest order. */
INLINE void expand_slide_to(V *x, V *y, const Field *f, const Law *law, V e, int order, int cubic,
                            FrictionKind kind)
{
    if (LANES == 1 && order == MAX_LAW_ORDER)
        expand_slide(x, y, f, law, e, MAX_LAW_ORDER, 1, cubic, kind);
    else
        expand_slide(x, y, f, law, e, order, LANES > 1, cubic, kind);
}

/* Expand a step in which friction falls with the speed; constant `cubic` gives two specialised
   copies of `expand_slide`. */
ALIGN_STACK NOINLINE void expand_falling(V *x, V *y, const Field *f, const Law *law, V e,
                                         int order, int cubic)
{
    if (cubic)
        expand_slide_to(x, y, f, law, e, order, 1, FRICTION_FALLS);
    else
        expand_slide_to(x, y, f, law, e, order, 0, FRICTION_FALLS);
}

/* The same for constant friction, and where the slider sticks. */
NOINLINE void expand_constant(V *x, V *y, const Field *f, const Law *law, int order, int cubic)
{
    if (cubic)
        expand_slide_to(x, y, f, law, splat(0.0), order, 1, FRICTION_CONSTANT);
    else
        expand_slide_to(x, y, f, law, splat(0.0), order, 0, FRICTION_CONSTANT);
}

#if LANES == 1
NOINLINE void expand_sticking(V *x, V *y, const Field *f, const Law *law, int order, int cubic)
{
    if (cubic)
        expand_slide_to(x, y, f, law, splat(0.0), order, 1, FRICTION_STICKS);
    else
        expand_slide_to(x, y, f, law, splat(0.0), order, 0, FRICTION_STICKS);
}
#endif

/* v/v_s, the exponent of e with its sign changed; 0 where no law applies. */
INLINE V sliding_exponent(const Law *law, V v_belt, V vx)
{
    return law->sign * (v_belt - vx) * law->per_speed;
}

/* An exponent v/v_s, and e = exp(−v/v_s). */
typedef struct {
    V exponent, e;
} LawStart;

/* e at an exponent: the computed one if the exponents are equal in all lanes. */
INLINE V exponential_at(V exponent, const LawStart *computed)
{
    M is_same = exponent == computed->exponent;
    return mask_bits(is_same) == ALL_LANES ? computed->e : exponential(-exponent);
}

/* Expand a step in any mode. Friction is constant far from the speed of the belt and without
   sliding; e is taken from `computed` if its exponent is the same. */
INLINE void expand_by_law(V *x, V *y, const Field *f, const Law *law, V v_belt,
                          const LawStart *computed, int order, int cubic)
{
    V exponent = sliding_exponent(law, v_belt, x[1]);
    M falls = (law->per_speed > 0.0) & mask_not(exponent > FAR_EXPONENT);
    Law step_law = *law;
    step_law.mu_drop = choose(falls, law->mu_drop, splat(0.0));
    if (mask_bits(falls))
        expand_falling(x, y, f, &step_law, exponential_at(exponent, computed), order, cubic);
    else
        expand_constant(x, y, f, &step_law, order, cubic);
}

/* Limit a step of length h to the range where the expansion of the law converges, or e is
   negligible; `speed` is v at its start. `keeps_sliding` says whether v is positive over the step
   for certain. */
INLINE V limit_step(V h, const V *x, const Law *law, V speed, int groups, M *keeps_sliding)
{
    V exponent = vmax(speed * law->per_speed, splat(0.0));
    V allowed = vmax(exponent * GROWTH + MAX_CHANGE, exponent - NEGLIGIBLE);
    for (;;) {
        /* Bound of the change of ẋ over the step, times h. */
        V change_times_h = weighted_bound(DEGREES, x, groups, h);
        M too_far = change_times_h * law->per_speed > allowed * h;
        *keeps_sliding = change_times_h < speed * h;
        if (!mask_bits(too_far))
            return h;
        h = choose(too_far, h * SHRINK_FACTOR, h);
    }
}

#endif
