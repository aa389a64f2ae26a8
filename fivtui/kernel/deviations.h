/* Deviations of a motion: its derivatives by numbers on which its start and parameters depend.

   The equation of motion is z̈ = a x + b y + C ż − d y³ − (0, F/m) with z = (x, y), see
   `expansion.h`. With ′ for the derivative of a coefficient by such a number, the variational
   equations are

       δz̈ = a δx + (b − 3 d y²) δy + C δż + a′ x + b′ y + C′ ż − d′ y³ − (0, (F/m)′)

   A deviation oscillates at the system's frequencies even if the motion is slow. So each step of
   the motion is divided into substeps, on which the deviations are expanded. A vector has eight
   deviations. LANES is 1: V is a double. */

#ifndef FIVTUI_DEVIATIONS_H
#define FIVTUI_DEVIATIONS_H

#include "field.h"
#include "motion.h"

#define MAX_DEVIATIONS 16
#define VECTOR_SIZE 8
#define MAX_VECTORS (MAX_DEVIATIONS / VECTOR_SIZE)
/* Largest ratio of the last terms of a substep to its first ones, and the number of first terms. */
#define NEGLIGIBLE 0x1p-54
#define FIRST_TERMS 9
/* Smaller deviations count as zero. */
#define MIN_DEVIATION 1e-280
/* Factor by which a substep is shortened until it is short enough, and how often at most. */
#define SHORTENING 0.8
#define MAX_SHORTENINGS 64

typedef double Eight __attribute__((vector_size(64), aligned(8), may_alias));

#ifdef __clang__
INLINE Eight eight_fma(Eight a, Eight b, Eight c) { return FMA(a, b, c); }
INLINE Eight eight_fma_by(Eight a, double s, Eight c) { return FMA(a, s - (Eight){0}, c); }
#else
INLINE Eight eight_fma(Eight a, Eight b, Eight c)
{
    for (int i = 0; i < 8; i++)
        c[i] = FMA(a[i], b[i], c[i]);
    return c;
}
INLINE Eight eight_fma_by(Eight a, double s, Eight c)
{
    for (int i = 0; i < 8; i++)
        c[i] = FMA(a[i], s, c[i]);
    return c;
}
#endif

/* The greater absolute value of each pair. */
INLINE Eight eight_max_abs(Eight a, Eight b)
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

/* Derivatives ′ of the coefficients of a field (`Field` in `expansion.h`), one for each
   deviation. */
typedef struct {
    Eight a_x, a_y, b_x, b_y, damping_x, damping_y, d_x, d_y, load;
} FieldChange;

/* Taylor coefficients of the motion over a substep, and of y² and y³. All but x begin with
   PADDED_TERMS zeros, so that sums of products need no bounds; then follow MAX_TERMS coefficients,
   filled up with two zeros to PADDED_TERMS, a multiple of VECTOR_SIZE. */
typedef struct {
    double x[PADDED_TERMS], y[2 * PADDED_TERMS], square[2 * PADDED_TERMS], cube[2 * PADDED_TERMS];
} Motion;

/* Taylor coefficients of deviations over a substep. */
typedef struct {
    Eight x[MAX_TERMS], y[MAX_TERMS];
} Series;

/* Set the derivatives of the field of a mode from the derivatives q of its parameters p. */
INLINE void set_field_change(FieldChange *target, int column, const double *p, const double *q,
                             int mode)
{
    const Coefficients values = coefficients_in(mode, p), changes = changes_in(mode, p, q);
    target->a_x[column] = changes.xx, target->a_y[column] = changes.yx;
    target->b_x[column] = changes.xy, target->b_y[column] = changes.yy;
    target->damping_x[column] = changes.xvx, target->damping_y[column] = changes.yvy;
    /* d_x is the product of the friction coefficient and d_y = k_nl/m (`cubic`). */
    target->d_x[column] = changes.friction * values.cubic + values.friction * changes.cubic;
    target->d_y[column] = changes.cubic, target->load[column] = changes.load;
}

/* The product of two polynomials with PADDED_TERMS leading zeros. */
INLINE void multiply(const double *a, const double *b, double *product)
{
    Eight sums[PADDED_TERMS / VECTOR_SIZE] = {{0.0}};
    UNROLL for (int i = 0; i < MAX_TERMS; i++)
        UNROLL for (int n = 0; n < PADDED_TERMS / VECTOR_SIZE; n++)
            sums[n] = eight_fma_by(*(const Eight *)(b + PADDED_TERMS + VECTOR_SIZE * n - i),
                                   a[PADDED_TERMS + i], sums[n]);
    memset(product, 0, PADDED_TERMS * sizeof *product);
    memcpy(product + PADDED_TERMS, sums, sizeof sums);
}

/* Expand the motion from its first two coefficients, with y² and y³ if `cubic`. */
NOINLINE void expand_motion(Motion *m, const Field *f, int cubic)
{
    memset(m->y, 0, PADDED_TERMS * sizeof *m->y);
    if (cubic) {
        expand(m->x, m->y + PADDED_TERMS, f, MAX_ORDER, 1);
        /* PADDED_TERMS is MAX_TERMS + 2. */
        m->y[PADDED_TERMS + MAX_TERMS] = m->y[PADDED_TERMS + MAX_TERMS + 1] = 0.0;
        multiply(m->y, m->y, m->square);
        multiply(m->y, m->square, m->cube);
    } else {
        expand(m->x, m->y + PADDED_TERMS, f, MAX_ORDER, 0);
        memset(m->cube, 0, sizeof m->cube);
    }
}

/* Whether the coefficients of the motion and of its velocity are finite. */
INLINE int is_finite_motion(const Motion *m)
{
    double size = 0.0;
    for (int n = 0; n < MAX_TERMS; n++)
        size += (n + 1.0) * (__builtin_fabs(m->x[n]) + __builtin_fabs(m->y[PADDED_TERMS + n]));
    return is_finite_number(size);
}

/* Expand deviations by the variational equations above; `push` is their right-hand side for the
   n-th coefficient. The newest coefficients come last in the sums. */
NOINLINE void expand_deviations(Series *s, const Deviation *start, const Motion *m, const Field *f,
                                const FieldChange *c, int cubic)
{
    const Eight zero = {0.0};
    const double *ys = m->y + PADDED_TERMS, *square = m->square + PADDED_TERMS;
    const double *cube = m->cube + PADDED_TERMS;
    s->x[0] = start->x, s->x[1] = start->vx, s->y[0] = start->y, s->y[1] = start->vy;
    for (int n = 0; n + 2 < MAX_TERMS; n++) {
        double n_plus_1 = n + 1.0, scale = 1.0 / (n_plus_1 * (n + 2.0));
        double x = m->x[n], y = ys[n], vx = m->x[n + 1] * n_plus_1, vy = ys[n + 1] * n_plus_1;
        Eight push_x = zero, push_y = n == 0 ? -c->load : zero;
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
        push_x = eight_fma_by(s->x[n + 1], f->damping_x * n_plus_1, push_x);
        push_y = eight_fma_by(s->y[n + 1], f->damping_y * n_plus_1, push_y);
        s->x[n + 2] = push_x * scale, s->y[n + 2] = push_y * scale;
    }
}

/* Flush tiny deviations to zero: subnormal numbers are slow. */
INLINE Eight flush_tiny(Eight a)
{
    typedef long long Mask8 __attribute__((vector_size(64), aligned(8), may_alias));
    return (Eight)((Mask8)a & (eight_max_abs(a, a) > MIN_DEVIATION - (Eight){0}));
}

/* Deviations at the time t of a substep. */
INLINE Deviation deviation_at(const Series *s, double t)
{
    Deviation value = {s->x[MAX_TERMS - 1], {0.0}, s->y[MAX_TERMS - 1], {0.0}};
    for (int n = MAX_TERMS - 2; n >= 0; n--) {
        value.vx = eight_fma_by(value.vx, t, value.x),
            value.vy = eight_fma_by(value.vy, t, value.y);
        value.x = eight_fma_by(value.x, t, s->x[n]), value.y = eight_fma_by(value.y, t, s->y[n]);
    }
    return (Deviation){flush_tiny(value.x), flush_tiny(value.vx), flush_tiny(value.y),
                       flush_tiny(value.vy)};
}

INLINE int all_finite(Eight a)
{
    double sum = 0.0;
    for (int i = 0; i < VECTOR_SIZE; i++)
        sum += a[i] - a[i];
    return sum == 0.0;
}

/* Whether the last two terms of a substep of length h are negligible relative to its first
   terms. */
INLINE int is_short(const Eight *first, const Eight *last, double h)
{
    Eight scale = first[0];
    double power = 1.0;
    for (int n = 1; n < FIRST_TERMS; n++)
        power *= h, scale = eight_max_abs(scale, first[n] * power);
    for (int n = FIRST_TERMS; n < MAX_TERMS - 1; n++)
        power *= h;
    Eight tail = eight_max_abs(last[0] * power, last[1] * (power * h));
    /* Tiny deviations may lose digits. */
    int is_too_long = 0;
    for (int i = 0; i < VECTOR_SIZE; i++)
        is_too_long |= (scale[i] > MIN_DEVIATION) & (tail[i] > scale[i] * NEGLIGIBLE);
    return !is_too_long;
}

/* Length of the next substep: the remaining time or an equal part of it. Zero if deviations
   overflow or need too many substeps. */
NOINLINE double substep_length(const Series *s, int vectors, double remaining)
{
    double h = remaining;
    int shortenings = 0;
    for (int i = 0; i < vectors; i++) {
        const Eight *x = s[i].x, *y = s[i].y;
        Eight first[FIRST_TERMS], last[2];
        for (int n = 0; n < FIRST_TERMS; n++)
            first[n] = eight_max_abs(x[n], y[n]);
        for (int n = 0; n < 2; n++)
            last[n] = eight_max_abs(x[MAX_TERMS - 2 + n], y[MAX_TERMS - 2 + n]);
        if (!all_finite(x[MAX_TERMS - 1] + y[MAX_TERMS - 1]))
            return 0.0;
        for (; !is_short(first, last, h); h *= SHORTENING)
            if (shortenings++ == MAX_SHORTENINGS)
                return 0.0;
    }
    /* The number of equal parts of at most this length: the ratio, rounded up. */
    double whole_parts = (double)(int64_t)(remaining / h);
    double parts = whole_parts * h < remaining ? whole_parts + 1.0 : maximum(whole_parts, 1.0);
    return remaining / parts;
}

/* The acceleration of a state in a field (Eqs. 2 and 5 of the paper). */
INLINE Pair accelerations(const Field *f, double x, double vx, double y, double vy)
{
    double ax = FMA(f->a_x, x, FMA(f->b_x, y, FMA(f->damping_x, vx, -(f->d_x * y * y * y))));
    double ay = FMA(f->a_y, x, FMA(f->b_y, y, FMA(f->damping_y, vy, -(f->d_y * y * y * y))));
    return make_pair(ax, ay - f->load);
}

/* Apply a switch to deviations. There a guard g(state, parameters) vanishes and the rate of change
   of the state jumps by f⁺ − f⁻: a deviation δ moves the switch by −(∇g·δ + g′)/(∇g·f⁻), hence

       δ⁺ = δ + (f⁺ − f⁻) (∇g·δ + g′)/(∇g·f⁻),

   the saltation matrix I + (f⁺ − f⁻) ∇gᵀ/(∇g·f⁻) with the term of the parameters. It is the
   identity if the rate does not jump. This is tested first, as ∇g·f⁻ is zero where the motion only
   touches g = 0. `rate` is ∇g·f⁻, `jump` and `gradient` are in the order of the state, `change` is
   g′. */
INLINE void apply_saltation(Deviation *d, const double *jump, const double *gradient, Eight change,
                            double rate)
{
    if (jump[S_X] == 0.0 && jump[S_VX] == 0.0 && jump[S_Y] == 0.0 && jump[S_VY] == 0.0)
        return;
    Eight shift = eight_fma_by(d->x, gradient[S_X], eight_fma_by(d->vx, gradient[S_VX], change));
    shift = eight_fma_by(d->y, gradient[S_Y], eight_fma_by(d->vy, gradient[S_VY], shift));
    shift = shift * (1.0 / rate);
    d->x = eight_fma_by(shift, jump[S_X], d->x), d->vx = eight_fma_by(shift, jump[S_VX], d->vx);
    d->y = eight_fma_by(shift, jump[S_Y], d->y), d->vy = eight_fma_by(shift, jump[S_VY], d->vy);
}

#endif
