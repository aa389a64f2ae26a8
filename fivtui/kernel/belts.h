/* Steps of blocks of runs on belts of finite speed, by the functions of `belt.h`. LANES is 8; `w`
   is a block (`Block` in `motion.h`). `splat` gives a number to all lanes, `choose` selects lane by
   lane (`vector.h`). */

#ifndef FIVTUI_BELTS_H
#define FIVTUI_BELTS_H

#include "belt.h"

/* Belts of a block, one in each lane. `law` is the friction law of the lane's mode. `stick` is 1
   where the slider sticks, `slides` 1 where it keeps sliding over the step for certain, else 0. The
   others are constants: speed of the belt, 1/v_s, k2/m, coefficient of y in ẍ for backward slip
   without a law, k1 + k3/2 (`horizontal`), c1 v_belt, and the constants of `Hold`. */
typedef struct {
    Law law;
    V stick, slides, v_belt, per_speed, contact, backward_b_x, horizontal, damper_force;
    Hold hold;
} BeltLanes;

/* Set the mode of a lane. */
INLINE void set_lane_mode(BeltLanes *lanes, int lane, int64_t mode)
{
    double sign = friction_sign(mode);
    set_lane(&lanes->law.sign, lane, sign);
    set_lane(&lanes->law.per_speed, lane, sign != 0.0 ? get_lane(&lanes->per_speed, lane) : 0.0);
    set_lane(&lanes->law.contact, lane, mode != SEPARATED ? get_lane(&lanes->contact, lane) : 0.0);
    set_lane(&lanes->stick, lane, mode == STICK ? 1.0 : 0.0);
}

/* Set the belt of a lane, which has begun with the parameters `p`. */
INLINE void set_lane_belt(BeltLanes *lanes, int lane, const Belt *belt, const double *p)
{
    set_lane(&lanes->law.mu, lane, p[P_MU]);
    set_lane(&lanes->law.mu_drop, lane, p[P_MU_S] - p[P_MU]);
    set_lane(&lanes->v_belt, lane, p[P_V_BELT]);
    set_lane(&lanes->per_speed, lane, p[P_V_S] > 0.0 ? 1.0 / p[P_V_S] : 0.0);
    set_lane(&lanes->backward_b_x, lane, backward_coefficients(p).xy);
    set_lane(&lanes->contact, lane, p[P_K2] / p[P_M]);
    set_lane(&lanes->horizontal, lane, horizontal_stiffness(p));
    set_lane(&lanes->damper_force, lane, holding_force(p, 0.0, 0.0, 0.0));
    set_lane(&lanes->hold.mu_s, lane, p[P_MU_S]);
    set_lane(&lanes->hold.coupling, lane, coupling_stiffness(p));
    set_lane(&lanes->hold.k2, lane, p[P_K2]), set_lane(&lanes->hold.k_nl, lane, p[P_K_NL]);
    set_lane_mode(lanes, lane, belt->mode);
}

/* Copy a lane; clear it if `from` is NULL. */
INLINE void copy_lane_belt(const BeltLanes *from, int from_lane, BeltLanes *to, int to_lane)
{
    const V *from_rows = (const V *)from;
    V *to_rows = (V *)to;
    for (size_t n = 0; n < sizeof(BeltLanes) / sizeof(V); n++)
        set_lane(to_rows + n, to_lane, from ? get_lane(from_rows + n, from_lane) : 0.0);
}

/* The fields of the lanes in their modes, for `expand`; `by_law` those for `expand_by_law`, which
   adds contact and friction itself. */
INLINE Field lane_fields(const Block *w, const BeltLanes *lanes, int by_law)
{
    M is_separated = w->side > 0.0, sticks = lanes->stick > 0.0;
    M backward = lanes->law.sign < 0.0;
    const V zero = splat(0.0);
    Field f = w->field;
    f.a_x = choose(sticks, zero, f.a_x), f.damping_x = choose(sticks, zero, f.damping_x);
    /* Factors of y and y³ in ẍ: those of forward or backward slip; without contact that of the
       coupling alone, to which `expand_by_law` adds; in stick none. */
    V b_x = choose(backward, lanes->backward_b_x, w->contact_b_x);
    V d_x = choose(backward, -w->contact_d_x, w->contact_d_x);
    b_x = by_law ? w->separated_b_x : choose(is_separated, w->separated_b_x, b_x);
    f.b_x = choose(sticks, zero, b_x);
    f.d_x = choose(is_separated | sticks, zero, d_x);
    f.b_y = choose(is_separated, w->separated_b_y, w->contact_b_y);
    f.d_y = choose(is_separated, zero, w->contact_d_y);
    return f;
}

/* Expand steps; constant `cubic` gives two specialised copies of `expand`. */
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
    /* `expand_by_law` reuses an exponential that has been computed for the same exponent. There is
       none here, and no exponent is infinite. */
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
    balance_vertical_forces(w);
    /* Lanes in which the slider begins to slide. */
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
    unsigned undecided = mask_bits((lanes->law.sign != 0.0) & (lanes->slides == 0.0));
    if (!undecided)
        return 0;
    return undecided
        & ~mask_bits(keeps_sliding(w, groups, lanes->law.sign, lanes->v_belt, lanes->v_belt));
}

INLINE unsigned may_slip(const Block *w, const BeltLanes *lanes)
{
    M sticks = lanes->stick > 0.0;
    if (!mask_bits(sticks))
        return 0;
    Hold hold = lanes->hold;
    hold.start = lanes->damper_force + lanes->horizontal * w->xs[0];
    hold.end = lanes->damper_force + lanes->horizontal * w->x;
    const HeldSides held = keeps_holding(w, &hold);
    return mask_bits(sticks & mask_not(held.forward & held.backward));
}

/* Upper bounds of ẋ inside a step, as `speed_limit`. */
INLINE V speed_limits(const BeltLanes *lanes)
{
    V limit = choose(lanes->law.sign > 0.0, lanes->v_belt, splat(INFINITE));
    return choose(lanes->stick > 0.0, splat(-INFINITE), limit);
}

/* Evaluate y again at the ends of shortened steps, and x at those of all. */
INLINE void reevaluate_ends(Block *w, M is_shortened, int groups)
{
    Tangent end = tangent_at(w->ys, groups, w->h);
    V error = weighted_bound(CUBIC_BOUND, w->ys, groups, w->h);
    w->y = choose(is_shortened, end.value, w->y), w->vy = choose(is_shortened, end.slope, w->vy);
    w->y_error = choose(is_shortened, error, w->y_error);
    evaluate_end_x(w, groups, 1);
}

#endif
