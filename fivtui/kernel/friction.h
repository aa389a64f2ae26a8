/* Expansion of sliding with the friction law μ + (μ_s − μ) exp(−v/v_s), v = |v_r|: by the
   recurrences of `fivtui.taylor.friction`. LANES is 1. */

#ifndef FIVTUI_FRICTION_H
#define FIVTUI_FRICTION_H

#include "expansion.h"

/* As in `fivtui.taylor.friction`. */
#define LN2_HIGH 6.93147180369123816490e-01
#define LN2_LOW 1.90821492927058770002e-10
#define LOG2_E 1.44269504088896338700
#define MOST_EXPONENT 700.0
#define MOST_CHANGE 1.5
#define WIDENING 0.09
#define NEGLIGIBLE 37.0
#define FAR ((NEGLIGIBLE + MOST_CHANGE) / (1.0 - WIDENING))
#define SHRINKING 0.75

/* The sign of friction, its constant part, its fall, and 1/v_s; 0 where friction is constant. */
typedef struct {
    double sign, mu, fall, per_speed;
} Law;

/* exp(−exponent) of an exponent ≥ 0 by arithmetic alone, and without fused operations. */
INLINE double decay(double exponent)
{
    if (!(exponent < MOST_EXPONENT))
        return 0.0;
    double place = 0.5 - exponent * LOG2_E;
    int64_t count = (int64_t)place;
    count -= (double)count > place;
    double rest = (-exponent - (double)count * LN2_HIGH) - (double)count * LN2_LOW;
    double value = 1.0 / FACTORIAL[13];
    for (int n = 12; n >= 0; n--)
        value = value * rest + 1.0 / FACTORIAL[n];
    Bits power;
    power.bits = (count + 1023) << 52;
    return value * power.number;
}

/* A series, and the same backwards: products of series then read both in ascending order. What is
   not yet known is zero. */
#define SERIES 24
typedef struct {
    double c[SERIES], back[2 * SERIES];
} Series;

INLINE void put_term(Series *s, int n, double value) { s->c[n] = value, s->back[SERIES - n] = value; }

/* The n-th coefficient of a product. */
INLINE double product_of(const Series *a, const Series *b, int n)
{
    Four sum = {0.0};
    for (int i = 0; i <= n; i += 4) {
        Four one = four_at(a->c + i), other = four_at(b->back + SERIES - n + i);
        for (int k = 0; k < 4; k++)
            sum[k] = FUSED(one[k], other[k], sum[k]);
    }
    return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

/* Continue the first two coefficients of x and y; `f` is the field of the constant part, and
   `contact` is k2/m. */
APART void expand_by_law(V *x, V *y, const Field *f, const Law *law, double contact, double v_belt,
                         int order, int cubic)
{
    Series e = {{0.0}}, height = {{0.0}}, square = {{0.0}}, force = {{0.0}}, ax = {{0.0}};
    const double cube = f->d_y, rate = law->sign * law->per_speed;
    put_term(&e, 0, decay(law->sign * (v_belt - x[1]) * law->per_speed));
    put_term(&height, 0, y[0]), put_term(&height, 1, y[1]);
    for (int n = 0; n < order; n++) {
        double share = 1.0 / ((n + 1) * (n + 2)), pressing = -contact * y[n];
        if (cubic) {
            put_term(&square, n, product_of(&height, &height, n));
            pressing = FUSED(-cube, product_of(&height, &square, n), pressing);
        }
        put_term(&force, n, pressing);
        if (n > 0)
            put_term(&e, n, rate * product_of(&ax, &e, n - 1) * (1.0 / n));
        double friction = law->sign * FUSED(law->fall, product_of(&e, &force, n), law->mu * pressing);
        double other = FUSED(f->a_x, x[n], f->a_y * y[n]);
        double along = friction + FUSED(f->damping_x, (n + 1) * x[n + 1], other);
        double across = FUSED(f->damping_y, (n + 1) * y[n + 1], f->a_y * (x[n] - y[n])) + pressing;
        put_term(&ax, n, along);
        x[n + 2] = along * share;
        y[n + 2] = (n == 0 ? across - f->load : across) * share;
        put_term(&height, n + 2, y[n + 2]);
    }
}

/* The part of a step over which the expansion of the law holds, or e stays below rounding; `speed`
   is v at its start. */
INLINE double limited(double h, const V *x, const Law *law, double speed, int order)
{
    double exponent = speed * law->per_speed;
    double allowed = larger(MOST_CHANGE + WIDENING * exponent, exponent - NEGLIGIBLE) / law->per_speed;
    for (;;) {
        double change = 0.0;
        for (int n = order + 1; n > 1; n--)
            change = (change + n * __builtin_fabs(x[n])) * h;
        if (!(change > allowed))
            return h;
        h *= SHRINKING;
    }
}

#endif
