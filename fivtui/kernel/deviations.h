/* Deviations from a motion: its derivatives by numbers on which its start and parameters depend.

   With the symbols of `expansion.h`, and ′ for the change of a coefficient with such a number, the
   variational equations are

       δz̈ = a δx + (b − 3 d y²) δy + C δż + a′ x + b′ y + C′ ż − d′ y³ − (0, (F/m)′)

   A deviation oscillates at the system's frequencies however slow the motion is: within a step of
   the motion it takes pieces of its own, along the polynomials of that step. Eight deviations stand
   side by side. LANES is 1. */

#ifndef FIVTUI_DEVIATIONS_H
#define FIVTUI_DEVIATIONS_H

#include "field.h"
#include "motion.h"

#define MOST_DEVIATIONS 16
#define EIGHTS (MOST_DEVIATIONS / 8)
/* The last terms of a piece over the greatest of its first ones, and how many these are. */
#define NEGLIGIBLE 0x1p-54
#define FIRST_TERMS 9
#define SHORTENED 0.8
#define MOST_SHORTENINGS 64

typedef double Eight __attribute__((vector_size(64), aligned(8), may_alias));

#ifdef __clang__
INLINE Eight eight_fma(Eight a, Eight b, Eight c) { return FUSED(a, b, c); }
INLINE Eight eight_fma_by(Eight a, double s, Eight c) { return FUSED(a, s - (Eight){0}, c); }
#else
INLINE Eight eight_fma(Eight a, Eight b, Eight c)
{
    for (int i = 0; i < 8; i++)
        c[i] = FUSED(a[i], b[i], c[i]);
    return c;
}
INLINE Eight eight_fma_by(Eight a, double s, Eight c)
{
    for (int i = 0; i < 8; i++)
        c[i] = FUSED(a[i], s, c[i]);
    return c;
}
#endif

INLINE Eight eight_size(Eight a, Eight b)
{
    typedef long long Mask8 __attribute__((vector_size(64), aligned(8), may_alias));
    a = (Eight)((Mask8)a & INT64_MAX), b = (Eight)((Mask8)b & INT64_MAX);
    Mask8 first = a > b;
    return (Eight)(((Mask8)a & first) | ((Mask8)b & ~first));
}

/* Deviations of x, ẋ, y and ẏ. */
typedef struct {
    Eight x, vx, y, vy;
} Deviation;

/* How the coefficients of a field change: ′. */
typedef struct {
    Eight a_x, a_y, b_x, b_y, damping_x, damping_y, d_x, d_y, load;
} Change;

/* Taylor coefficients over a piece: of the motion with y² and y³, these two and y behind zeros; and
   of deviations from it. */
typedef struct {
    double x[PADDED], y[2 * PADDED], square[2 * PADDED], cube[2 * PADDED];
} Motion;

typedef struct {
    Eight x[ROWS], y[ROWS];
} Series;

/* The change of the field of a mode with parameters p that change by q. */
INLINE void put_change(Change *c, int place, const double *p, const double *q, int mode)
{
    const Coefficients of = coefficients_in(mode, p), by = changes_in(mode, p, q);
    c->a_x[place] = by.xx, c->a_y[place] = by.yx;
    c->b_x[place] = by.xy, c->b_y[place] = by.yy;
    c->damping_x[place] = by.xvx, c->damping_y[place] = by.yvy;
    c->d_x[place] = by.friction * of.cubic + of.friction * by.cubic;
    c->d_y[place] = by.cubic, c->load[place] = by.load;
}

/* The product of two polynomials, from PADDED on. */
INLINE void multiply(const double *a, const double *b, double *product)
{
    Eight sums[PADDED / 8] = {{0.0}};
    UNROLLED for (int i = 0; i < ROWS; i++)
        UNROLLED for (int n = 0; n < PADDED / 8; n++)
            sums[n] = eight_fma_by(*(const Eight *)(b + PADDED + 8 * n - i), a[PADDED + i], sums[n]);
    memset(product, 0, PADDED * sizeof *product);
    memcpy(product + PADDED, sums, sizeof sums);
}

/* Continue the motion from its first two coefficients, with y² and y³ if these play a part. */
APART void expand_motion(Motion *m, const Field *f, int cubic)
{
    memset(m->y, 0, PADDED * sizeof *m->y);
    if (cubic) {
        expand(m->x, m->y + PADDED, f, MAX_ORDER, 1);
        m->y[PADDED + ROWS] = m->y[PADDED + ROWS + 1] = 0.0;
        multiply(m->y, m->y, m->square);
        multiply(m->y, m->square, m->cube);
    } else {
        expand(m->x, m->y + PADDED, f, MAX_ORDER, 0);
        memset(m->cube, 0, sizeof m->cube);
    }
}

/* Whether the motion is far enough within the range of numbers. */
INLINE int is_finite(const Motion *m)
{
    double size = 0.0;
    for (int n = 0; n < ROWS; n++)
        size += (n + 1.0) * (__builtin_fabs(m->x[n]) + __builtin_fabs(m->y[PADDED + n]));
    return finite_number(size);
}

/* The Taylor coefficients of deviations; the newest of them comes last into the sums. */
APART void expand_deviations(Series *s, const Deviation *start, const Motion *m, const Field *f,
                             const Change *c, int cubic)
{
    const Eight none = {0.0};
    const double *ys = m->y + PADDED, *square = m->square + PADDED, *cube = m->cube + PADDED;
    s->x[0] = start->x, s->x[1] = start->vx, s->y[0] = start->y, s->y[1] = start->vy;
    for (int n = 0; n + 2 < ROWS; n++) {
        double next = n + 1.0, share = 1.0 / (next * (n + 2.0));
        double x = m->x[n], y = ys[n], vx = m->x[n + 1] * next, vy = ys[n + 1] * next;
        Eight push_x = none, push_y = n == 0 ? -c->load : none;
        push_x = eight_fma_by(c->a_x, x, eight_fma_by(c->b_x, y, push_x));
        push_y = eight_fma_by(c->a_y, x, eight_fma_by(c->b_y, y, push_y));
        push_x = eight_fma_by(c->damping_x, vx, eight_fma_by(c->d_x, -cube[n], push_x));
        push_y = eight_fma_by(c->damping_y, vy, eight_fma_by(c->d_y, -cube[n], push_y));
        push_x = eight_fma_by(s->x[n], f->a_x, eight_fma_by(s->y[n], f->b_x, push_x));
        push_y = eight_fma_by(s->x[n], f->a_y, eight_fma_by(s->y[n], f->b_y, push_y));
        if (cubic) {
            Eight product = s->y[0] * square[n];
            for (int i = 1; i <= n; i++)
                product = eight_fma_by(s->y[i], square[n - i], product);
            push_x = eight_fma_by(product, -3.0 * f->d_x, push_x);
            push_y = eight_fma_by(product, -3.0 * f->d_y, push_y);
        }
        push_x = eight_fma_by(s->x[n + 1], f->damping_x * next, push_x);
        push_y = eight_fma_by(s->y[n + 1], f->damping_y * next, push_y);
        s->x[n + 2] = push_x * share, s->y[n + 2] = push_y * share;
    }
}

/* Next to nothing is nothing, lest it creep towards the least of numbers, with which all is slow. */
INLINE Eight settled(Eight a)
{
    typedef long long Mask8 __attribute__((vector_size(64), aligned(8), may_alias));
    return (Eight)((Mask8)a & (eight_size(a, a) > LEAST - (Eight){0}));
}

/* Deviations at the time t of a piece. */
INLINE Deviation deviation_at(const Series *s, double t)
{
    Deviation at = {s->x[ROWS - 1], {0.0}, s->y[ROWS - 1], {0.0}};
    for (int n = ROWS - 2; n >= 0; n--) {
        at.vx = eight_fma_by(at.vx, t, at.x), at.vy = eight_fma_by(at.vy, t, at.y);
        at.x = eight_fma_by(at.x, t, s->x[n]), at.y = eight_fma_by(at.y, t, s->y[n]);
    }
    return (Deviation){settled(at.x), settled(at.vx), settled(at.y), settled(at.vy)};
}

INLINE int all_finite(Eight a)
{
    double sum = 0.0;
    for (int i = 0; i < 8; i++)
        sum += a[i] - a[i];
    return sum == 0.0;
}

/* Whether the last terms of a piece of length h are negligible. */
INLINE int is_short(const Eight *first, const Eight *last, double h)
{
    Eight scale = first[0];
    double power = 1.0;
    for (int n = 1; n < FIRST_TERMS; n++)
        power *= h, scale = eight_size(scale, first[n] * power);
    for (int n = FIRST_TERMS; n < ROWS - 1; n++)
        power *= h;
    Eight rest = eight_size(last[0] * power, last[1] * (power * h));
    /* What is next to nothing may lose digits. */
    int longer = 0;
    for (int i = 0; i < 8; i++)
        longer |= (scale[i] > LEAST) & (rest[i] > scale[i] * NEGLIGIBLE);
    return !longer;
}

/* The length of the next piece of equal ones that make up the time `left`; zero where the deviations
   are out of the range of numbers or take too many pieces. */
APART double piece_length(const Series *s, int eights, double left)
{
    double h = left;
    int shortenings = 0;
    for (int g = 0; g < eights; g++) {
        Eight first[FIRST_TERMS], last[2];
        for (int n = 0; n < FIRST_TERMS; n++)
            first[n] = eight_size(s[g].x[n], s[g].y[n]);
        for (int n = 0; n < 2; n++)
            last[n] = eight_size(s[g].x[ROWS - 2 + n], s[g].y[ROWS - 2 + n]);
        if (!all_finite(s[g].x[ROWS - 1] + s[g].y[ROWS - 1]))
            return 0.0;
        for (; !is_short(first, last, h); h *= SHORTENED)
            if (shortenings++ == MOST_SHORTENINGS)
                return 0.0;
    }
    double parts = (double)(int64_t)(left / h);
    return left / (parts * h < left ? parts + 1.0 : larger(parts, 1.0));
}

/* The acceleration of a state in a field (Eqs. 2 and 5). */
INLINE Pair acceleration_of(const Field *f, double x, double vx, double y, double vy)
{
    double ax = FUSED(f->a_x, x, FUSED(f->b_x, y, FUSED(f->damping_x, vx, -(f->d_x * y * y * y))));
    double ay = FUSED(f->a_y, x, FUSED(f->b_y, y, FUSED(f->damping_y, vy, -(f->d_y * y * y * y))));
    return pair_of(ax, ay - f->load);
}

/* Deviations behind a switch where a guard g(state, parameters) vanishes and the rate of change of
   the state jumps by f⁺ − f⁻. A deviation δ moves the switch by −(∇g·δ + g′)/(∇g·f⁻), hence

       δ⁺ = δ + (f⁺ − f⁻) (∇g·δ + g′)/(∇g·f⁻),

   the saltation matrix I + (f⁺ − f⁻) ∇gᵀ/(∇g·f⁻) with its part by parameters. Where the rate does
   not jump it is the identity, also where the guard is touched only. `rate` is ∇g·f⁻, `jump` and
   `gradient` are in the order of the state, `change` is g′. */
INLINE void pass_switch(Deviation *d, const double *jump, const double *gradient, Eight change,
                        double rate)
{
    if (jump[0] == 0.0 && jump[1] == 0.0 && jump[2] == 0.0 && jump[3] == 0.0)
        return;
    Eight moved = eight_fma_by(d->x, gradient[0], eight_fma_by(d->vx, gradient[1], change));
    moved = eight_fma_by(d->y, gradient[2], eight_fma_by(d->vy, gradient[3], moved)) * (1.0 / rate);
    d->x = eight_fma_by(moved, jump[0], d->x), d->vx = eight_fma_by(moved, jump[1], d->vx);
    d->y = eight_fma_by(moved, jump[2], d->y), d->vy = eight_fma_by(moved, jump[3], d->vy);
}

#endif
