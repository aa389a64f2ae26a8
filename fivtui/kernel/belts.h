/* Blocks of runs on belts of finite speed, side by side: the steps of `belt.h`. LANES is 8. */

#ifndef FIVTUI_BELTS_H
#define FIVTUI_BELTS_H

#include "belt.h"

/* What the modes of the lanes of a block are: in `law`, and `stick` is 1 where the slider sticks.
   `stays` is 1 where it stays in motion over the belt for certain. Then what does not depend on the
   mode: the speed of the belt, 1/v_s, k2/m, b of ẍ where the slider slides backward without a law,
   and what holds it: a, c1 v_belt, and the constants of `Hold`. */
typedef struct {
    Law law;
    V stick, stays, v_belt, per_speed, contact, backward_b_x, a, driven;
    Hold hold;
} Belts;

/* Say what the mode of a lane is. */
INLINE void put_mode(Belts *at, int lane, int64_t mode)
{
    double sign = mode == FORWARD ? 1.0 : mode == BACKWARD ? -1.0 : 0.0;
    put(&at->law.sign, lane, sign);
    put(&at->law.per_speed, lane, sign != 0.0 ? element(&at->per_speed, lane) : 0.0);
    put(&at->law.contact, lane, mode != SEPARATED ? element(&at->contact, lane) : 0.0);
    put(&at->stick, lane, mode == STICK ? 1.0 : 0.0);
}

/* Put a belt that has begun with the parameters `p` into a lane. */
INLINE void put_belt(Belts *at, int lane, const Belt *of, const double *p)
{
    put(&at->law.mu, lane, p[P_MU]), put(&at->law.fall, lane, p[P_MU_S] - p[P_MU]);
    put(&at->v_belt, lane, p[P_V_BELT]);
    put(&at->per_speed, lane, p[P_V_S] > 0.0 ? 1.0 / p[P_V_S] : 0.0);
    put(&at->backward_b_x, lane, backward_coefficients(p).xy);
    put(&at->contact, lane, p[P_K2] / p[P_M]);
    put(&at->a, lane, horizontal_stiffness(p));
    put(&at->driven, lane, holding_force(p, 0.0, 0.0, 0.0));
    put(&at->hold.grip, lane, p[P_MU_S]), put(&at->hold.h, lane, coupling_stiffness(p));
    put(&at->hold.k2, lane, p[P_K2]), put(&at->hold.k_nl, lane, p[P_K_NL]);
    put_mode(at, lane, of->mode);
}

/* Copy what a lane has into another one; from nothing, empty it. */
INLINE void copy_belt(const Belts *from, int one, Belts *to, int other)
{
    const V *rows = (const V *)from;
    V *target = (V *)to;
    for (size_t n = 0; n < sizeof(Belts) / sizeof(V); n++)
        put(target + n, other, from ? element(rows + n, one) : 0.0);
}

/* The fields of the modes of the lanes, as they are for `expand`, or `by_law`. */
INLINE Field field_of(const Block *w, const Belts *at, int by_law)
{
    M off = w->side > 0.0, held = at->stick > 0.0, backward = at->law.sign < 0.0;
    const V none = splat(0.0);
    Field f = w->field;
    f.a_x = choose(held, none, f.a_x), f.damping_x = choose(held, none, f.damping_x);
    V b_x = choose(backward, at->backward_b_x, w->contact_b_x);
    V d_x = choose(backward, -w->contact_d_x, w->contact_d_x);
    f.b_x = choose(held, none, by_law ? w->off_b_x : choose(off, w->off_b_x, b_x));
    f.d_x = choose(off | held, none, d_x);
    f.b_y = choose(off, w->off_b_y, w->contact_b_y), f.d_y = choose(off, none, w->contact_d_y);
    return f;
}

APART void expand_field(Block *w, const Field *f, int order, int cubic)
{
    if (cubic)
        expand(w->xs, w->ys, f, order, 1);
    else
        expand(w->xs, w->ys, f, order, 0);
}

/* Expand the steps of a block, all with a friction law or all without. */
INLINE void expand_on_belts(Block *w, const Belts *at, int order, int cubic, int by_law)
{
    Field f = field_of(w, at, by_law);
    const Start unknown = {splat(INFINITE), splat(0.0)};
    if (by_law)
        expand_by_law(w->xs, w->ys, &f, &at->law, at->v_belt, &unknown, order, cubic);
    else
        expand_field(w, &f, order, cubic);
}

/* The lengths of the next steps of a block whose belts, one by lane, are `belts`. */
INLINE void set_length_on_belts(Block *w, Belts *at, const Belt *belts, double tol, int groups)
{
    const Law *law = &at->law;
    settle_at_switch(w);
    unsigned starting = bits_of((w->xs[1] == at->v_belt) & (law->sign != 0.0));
    for (; starting; starting &= starting - 1) {
        int lane = __builtin_ctz(starting);
        double x = element(w->xs, lane), y = element(w->ys, lane), half = element(w->xs + 2, lane);
        put(w->xs + 2, lane, settled_start(belts + lane, x, y, half));
    }
    set_length(w, tol, groups);
    M stays = mask_of(0);
    if (bits_of(law->per_speed > 0.0))
        w->h = limited(w->h, w->xs, law, law->sign * (at->v_belt - w->xs[1]), groups, &stays);
    at->stays = choose(stays, splat(1.0), splat(0.0));
}

/* The lanes in which the slider may cease to slide, and those in which it may cease to stick. */
INLINE unsigned may_stop_sliding(const Block *w, const Belts *at, int groups)
{
    unsigned open = bits_of((at->law.sign != 0.0) & (at->stays == 0.0));
    return open ? open & ~bits_of(keeps_sliding(w, groups, at->law.sign, at->v_belt, at->v_belt)) : 0;
}
INLINE unsigned may_slip(const Block *w, const Belts *at)
{
    M sticks = at->stick > 0.0;
    if (!bits_of(sticks))
        return 0;
    Hold hold = at->hold;
    hold.first = at->driven + at->a * w->xs[0], hold.last = at->driven + at->a * w->x;
    const Held held = keeps_holding(w, &hold);
    return bits_of(sticks & negated(held.forward & held.backward));
}

/* As `speed_limit`. */
INLINE V speed_limits(const Belts *at)
{
    V ahead = choose(at->law.sign > 0.0, at->v_belt, splat(INFINITE));
    return choose(at->stick > 0.0, splat(-INFINITE), ahead);
}

/* End steps that have been shortened, and those alone. */
INLINE void end_shortened(Block *w, M shortened, int groups)
{
    Tangent end = tangent_at(w->ys, groups, w->h);
    V off = weighed(CUBIC_BOUND, w->ys, groups, w->h);
    w->y = choose(shortened, end.value, w->y), w->vy = choose(shortened, end.slope, w->vy);
    w->y_off = choose(shortened, off, w->y_off);
    end_step_x(w, groups, 1);
}

#endif
