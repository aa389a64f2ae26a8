/* Steps of blocks of runs on belts of finite speed, by the functions of `belt.h`. LANES is 8. */

#ifndef FIVTUI_BELTS_H
#define FIVTUI_BELTS_H

#include "belt.h"

/* Belts of a block. By mode: `law`, and 1 in `stick` and in `slides` where the slider sticks, or
   keeps sliding for certain. Constants: speed of the belt, 1/v_s, k2/m, b of ẍ for backward slip
   without a law, and for the hold a, c1 v_belt and the constants of `Hold`. */
typedef struct {
    Law law;
    V stick, slides, v_belt, per_speed, contact, backward_b_x, a, damper_force;
    Hold hold;
} BeltLanes;

/* Set the mode of a lane. */
INLINE void set_lane_mode(BeltLanes *lanes, int lane, int64_t mode)
{
    double sign = mode == FORWARD ? 1.0 : mode == BACKWARD ? -1.0 : 0.0;
    set_lane(&lanes->law.sign, lane, sign);
    set_lane(&lanes->law.per_speed, lane, sign != 0.0 ? get_lane(&lanes->per_speed, lane) : 0.0);
    set_lane(&lanes->law.contact, lane, mode != SEPARATED ? get_lane(&lanes->contact, lane) : 0.0);
    set_lane(&lanes->stick, lane, mode == STICK ? 1.0 : 0.0);
}

/* Set the belt of a lane, which has begun with the parameters `p`. */
INLINE void set_lane_belt(BeltLanes *lanes, int lane, const Belt *belt, const double *p)
{
    set_lane(&lanes->law.mu, lane, p[P_MU]), set_lane(&lanes->law.fall, lane, p[P_MU_S] - p[P_MU]);
    set_lane(&lanes->v_belt, lane, p[P_V_BELT]);
    set_lane(&lanes->per_speed, lane, p[P_V_S] > 0.0 ? 1.0 / p[P_V_S] : 0.0);
    set_lane(&lanes->backward_b_x, lane, backward_coefficients(p).xy);
    set_lane(&lanes->contact, lane, p[P_K2] / p[P_M]);
    set_lane(&lanes->a, lane, horizontal_stiffness(p));
    set_lane(&lanes->damper_force, lane, holding_force(p, 0.0, 0.0, 0.0));
    set_lane(&lanes->hold.mu_s, lane, p[P_MU_S]),
        set_lane(&lanes->hold.h, lane, coupling_stiffness(p));
    set_lane(&lanes->hold.k2, lane, p[P_K2]), set_lane(&lanes->hold.k_nl, lane, p[P_K_NL]);
    set_lane_mode(lanes, lane, belt->mode);
}

/* Copy a lane; NULL clears it. */
INLINE void copy_lane_belt(const BeltLanes *from, int source, BeltLanes *to, int target_lane)
{
    const V *rows = (const V *)from;
    V *target = (V *)to;
    for (size_t n = 0; n < sizeof(BeltLanes) / sizeof(V); n++)
        set_lane(target + n, target_lane, from ? get_lane(rows + n, source) : 0.0);
}

/* The fields of the modes of the lanes, for `expand` or `by_law` for `expand_by_law`. */
INLINE Field lane_fields(const Block *w, const BeltLanes *lanes, int by_law)
{
    M is_off = w->side > 0.0, sticks = lanes->stick > 0.0, backward = lanes->law.sign < 0.0;
    const V zero = splat(0.0);
    Field f = w->field;
    f.a_x = choose(sticks, zero, f.a_x), f.damping_x = choose(sticks, zero, f.damping_x);
    V b_x = choose(backward, lanes->backward_b_x, w->contact_b_x);
    V d_x = choose(backward, -w->contact_d_x, w->contact_d_x);
    f.b_x = choose(sticks, zero, by_law ? w->separated_b_x : choose(is_off, w->separated_b_x, b_x));
    f.d_x = choose(is_off | sticks, zero, d_x);
    f.b_y = choose(is_off, w->separated_b_y, w->contact_b_y),
        f.d_y = choose(is_off, zero, w->contact_d_y);
    return f;
}

NOINLINE void expand_field(Block *w, const Field *f, int order, int cubic)
{
    if (cubic)
        expand(w->xs, w->ys, f, order, 1);
    else
        expand(w->xs, w->ys, f, order, 0);
}

/* Expand the steps of a block, all with or all without a friction law. */
INLINE void expand_on_belts(Block *w, const BeltLanes *lanes, int order, int cubic, int by_law)
{
    Field f = lane_fields(w, lanes, by_law);
    const LawStart unknown = {splat(INFINITE), splat(0.0)};
    if (by_law)
        expand_by_law(w->xs, w->ys, &f, &lanes->law, lanes->v_belt, &unknown, order, cubic);
    else
        expand_field(w, &f, order, cubic);
}

/* Set the lengths of the next steps of a block; `belts` has a belt for each lane. */
INLINE void set_length_on_belts(Block *w, BeltLanes *lanes, const Belt *belts, double tol,
                                int groups)
{
    const Law *law = &lanes->law;
    balance_at_switch(w);
    unsigned starting = mask_bits((w->xs[1] == lanes->v_belt) & (law->sign != 0.0));
    for (; starting; starting &= starting - 1) {
        int lane = __builtin_ctz(starting);
        double x = get_lane(w->xs, lane), y = get_lane(w->ys, lane),
            half_acceleration = get_lane(w->xs + 2, lane);
        set_lane(w->xs + 2, lane, start_half_acceleration(belts + lane, x, y, half_acceleration));
    }
    set_step_length(w, tol, groups);
    M slides = mask_from_bits(0);
    if (mask_bits(law->per_speed > 0.0))
        w->h = limit_step(w->h, w->xs, law, law->sign * (lanes->v_belt - w->xs[1]), groups,
                          &slides);
    lanes->slides = choose(slides, splat(1.0), splat(0.0));
}

/* Lanes in which the slider may stop sliding, and lanes in which it may stop sticking. */
INLINE unsigned may_stop_sliding(const Block *w, const BeltLanes *lanes, int groups)
{
    unsigned open_lanes = mask_bits((lanes->law.sign != 0.0) & (lanes->slides == 0.0));
    return open_lanes ? open_lanes
        & ~mask_bits(keeps_sliding(w, groups, lanes->law.sign, lanes->v_belt, lanes->v_belt)) : 0;
}
INLINE unsigned may_slip(const Block *w, const BeltLanes *lanes)
{
    M sticks = lanes->stick > 0.0;
    if (!mask_bits(sticks))
        return 0;
    Hold hold = lanes->hold;
    hold.start = lanes->damper_force + lanes->a * w->xs[0],
        hold.end = lanes->damper_force + lanes->a * w->x;
    const HeldSides held = keeps_holding(w, &hold);
    return mask_bits(sticks & mask_not(held.forward & held.backward));
}

/* Upper bounds of ẋ, as `speed_limit`. */
INLINE V speed_limits(const BeltLanes *lanes)
{
    V limit = choose(lanes->law.sign > 0.0, lanes->v_belt, splat(INFINITE));
    return choose(lanes->stick > 0.0, splat(-INFINITE), limit);
}

/* Evaluate y again at the ends of shortened steps, and x at those of all. */
INLINE void reevaluate_ends(Block *w, M is_shortened, int groups)
{
    Tangent end = tangent_at(w->ys, groups, w->h);
    V is_off = weighted_bound(CUBIC_BOUND, w->ys, groups, w->h);
    w->y = choose(is_shortened, end.value, w->y), w->vy = choose(is_shortened, end.slope, w->vy);
    w->y_error = choose(is_shortened, is_off, w->y_error);
    evaluate_end_x(w, groups, 1);
}

#endif
