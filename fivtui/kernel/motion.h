/* Parts of a step of all runs of a block: its length, its end and the next mode.

   A step expands the motion, sets its length, evaluates y at the end, searches for the first switch
   (`search.h`), evaluates x, searches for extremes (`search.h`) and is accepted. */

#ifndef FIVTUI_MOTION_H
#define FIVTUI_MOTION_H

#include <stddef.h>

#include "expansion.h"
#include "field.h"
#include "polynomial.h"

/* `Status` in `fivtui.kernel.status`. */
enum { DONE, OVERFLOW, STALLED, STEP_LIMIT, NO_START, RUNNING, UNBOUNDED };

/* Constants of `fivtui.taylor.stepper` and `fivtui.model.slider_belt`. */
#define LONGEST_STEP 1e3
#define SHORTEST_FLIGHT 0x1p-30
#define MAX_STALLED 64.0
#define MIN_SCALE_RATIO 0x1p-30
#define EXP2_BIAS 0.043
#define BALANCED 0x1p-49
#define LEAST 1e-280
#define INFINITE __builtin_inf()

/* Extremes over a run, and of y in its second half. */
typedef struct {
    V x_low, x_high, y_low, y_high, vx_high, late_low, late_high;
} Extremes;

/* The runs of all lanes; functions call it `w`. `field` belongs to the mode, `side` is 1 off the
   belt and −1 in contact, `remainder` is the exact time less t. xs and ys are the coefficients of
   the step, h is its length; x, vx, y, vy and the bounds for `Ends` are at its end. */
typedef struct {
    Field field;
    V contact_b_x, contact_b_y, contact_d_x, contact_d_y, separated_b_x, separated_b_y;
    V coupling, preload, deflection, frequency, max_step, separation;
    V t, remainder, side, steps, stalled, separations, reattachments, separated_time;
    V separated_remainder, first_switch, last_switch;
    Extremes extremes;
    V h, x, vx, y, vy, x_error, y_error;
    V xs[ROWS + 2], ys[ROWS + 2];
} Block;

/* Rows of a block that persist from step to step. */
#define PERSISTENT_ROWS (offsetof(Block, h) / sizeof(V))

/* Set the lengths of the next steps by Jorba and Zou's rule: the last two coefficients of x and y
   are compared with the scale of the coordinate. */
INLINE void set_step_length(Block *w, double tol, int groups)
{
    const V *x = w->xs, *y = w->ys;
    V scale_x = vmax(vabs(x[1]), vabs(x[0]) * w->frequency);
    V scale_y = vmax(vabs(y[1]), vabs(y[0]) * w->frequency);
    V scale = vmax(vmax(scale_x, scale_y), w->deflection * w->frequency);
    V min_scale = scale * MIN_SCALE_RATIO;
    V allowed_x = vmax(scale_x, min_scale) * tol, allowed_y = vmax(scale_y, min_scale) * tol;
    M limits_x = allowed_x > 0.0, limits_y = allowed_y > 0.0;
    const double no_limit = 200.0 * 0x1p52;
    V exponents[2];
    for (int back = 0; back < 2; back++) {
        int n = 4 * groups + 1 - back;
        V term_x = vabs(x[n]) * (double)n, term_y = vabs(y[n]) * (double)n;
        V exponent_x = bit_difference(allowed_x, term_x) * (1.0 / (n - 1));
        V exponent_y = bit_difference(allowed_y, term_y) * (1.0 / (n - 1));
        exponents[back] = vmin(choose((term_x > 0.0) & limits_x, exponent_x, splat(no_limit)),
                               choose((term_y > 0.0) & limits_y, exponent_y, splat(no_limit)));
    }
    V exponent = vmin(exponents[0], exponents[1]);
    /* Limit the exponent. If coefficients overflow, the end of the step is not finite either. */
    exponent = choose(exponent > -1000.0 * 0x1p52, exponent, splat(-1000.0 * 0x1p52));
    V h = number_from_bits(exponent, (1023LL << 52) - (int64_t)(EXP2_BIAS * 0x1p52));
    w->h = vmin(h, w->max_step);
}

/* The force that lifts the slider at y = 0; zero where its parts balance up to rounding. */
INLINE V lifting_force(V coupling, V preload, V x)
{
    V spring_force = coupling * x, force = spring_force - preload;
    V rounding = (vabs(spring_force) + vabs(preload)) * BALANCED;
    return choose(vabs(force) > vmax(rounding, splat(LEAST)), force, splat(0.0));
}

/* Where the forces balance at a switch, use the acceleration of the damper alone: a rounding error
   of random sign would cause repeated switches. */
INLINE void balance_at_switch(Block *w)
{
    V *y = w->ys;
    M at_switch = (y[0] == 0.0) & (w->separation > 0.0);
    if (!mask_bits(at_switch))
        return;
    M balanced = at_switch & (lifting_force(w->coupling, w->preload, w->xs[0]) == 0.0);
    if (!mask_bits(balanced))
        return;
    const Field *f = &w->field;
    V half_acceleration = f->damping_y * y[1] * 0.5;
    V jerk = f->a_y * w->xs[1] + f->b_y * y[1] + f->damping_y * half_acceleration * 2.0;
    y[2] = choose(balanced, half_acceleration, y[2]);
    y[3] = choose(balanced, jerk * (1.0 / 6.0), y[3]);
}

/* Evaluate y and ẏ at the end of the step, and the distance of y from its cubic. */
INLINE void evaluate_end_y(Block *w, int groups)
{
    Tangent end = tangent_at(w->ys, groups, w->h);
    w->y = end.value, w->vy = end.slope;
    w->y_error = weighted_bound(CUBIC_BOUND, w->ys, groups, w->h);
}

/* Cut the steps that go beyond the horizon, and return which: a switch in one of them lies beyond
   it. The motion up to the horizon does not depend on the horizon, to the last bit. */
INLINE M clip_at_horizon(Block *w, double t_end, int groups)
{
    V remaining = (t_end - w->t) - w->remainder;
    M beyond = w->h > remaining;
    if (mask_bits(beyond)) {
        w->h = choose(beyond, remaining, w->h);
        Tangent end = tangent_at(w->ys, groups, w->h);
        V error = weighted_bound(CUBIC_BOUND, w->ys, groups, w->h);
        w->y = choose(beyond, end.value, w->y), w->vy = choose(beyond, end.slope, w->vy);
        w->y_error = choose(beyond, error, w->y_error);
    }
    return beyond;
}

INLINE void evaluate_end_x(Block *w, int groups, int bounded)
{
    Tangent end = tangent_at(w->xs, groups, w->h);
    w->x = end.value, w->vx = end.slope;
    if (bounded)
        w->x_error = weighted_bound(CUBIC_BOUND, w->xs, groups, w->h);
}

/* Runs whose steps may have a switch. */
INLINE M may_switch(const Block *w)
{
    V slope = w->ys[1] * w->h, end_slope = w->vy * w->h;
    Ends ends = {w->ys[0], w->y, slope, end_slope, w->y_error, w->y_error};
    Range y = value_range(&ends);
    M is_off = w->side > 0.0;
    /* After a switch y starts at zero, and the bounds are those of y/θ. */
    V middle = w->y * 1.5 - end_slope * 0.5;
    V bottom = vmin(vmin(slope, w->y), middle), top = vmax(vmax(slope, w->y), middle);
    V error = w->y_error * DIVIDED_BOUND;
    M away = choose(is_off, bottom, -top) > error;
    M far = choose(is_off, y.low, -y.high) > 0.0;
    M from_zero = w->ys[0] == 0.0;
    return (w->separation > 0.0) & mask_not((from_zero & away) | (mask_not(from_zero) & far));
}

/* Runs whose steps have a finite end. */
INLINE M is_finite_step(const Block *w)
{
    V total = (w->x + w->y) + (w->vx + w->vy);
    return (total - total == 0.0) & (w->h > 0.0);
}

/* 1 if the motion goes on off the belt from y = 0, −1 if in contact: the sign of the first
   derivative of y that is not zero (Eqs. 3 and 4). */
INLINE V side_after(const Block *w, V x, V vx, V vy)
{
    V force = lifting_force(w->coupling, w->preload, x);
    V force_rate = w->coupling * vx;
    V third = choose(vabs(force_rate) > LEAST, force_rate, -(w->coupling * x));
    V direction = choose(vy != 0.0, vy, choose(force != 0.0, force, third));
    return choose(direction > 0.0, splat(1.0), splat(-1.0));
}

/* The mode of a run on a belt that is always faster than the slider. */
INLINE int mode_in_lane(const Block *w, int lane)
{
    return get_lane(&w->side, lane) < 0.0 ? CONTACT : SEPARATED;
}

INLINE void set_field(Block *w)
{
    M is_off = w->side > 0.0;
    w->field.b_x = choose(is_off, w->separated_b_x, w->contact_b_x);
    w->field.b_y = choose(is_off, w->separated_b_y, w->contact_b_y);
    w->field.d_x = choose(is_off, splat(0.0), w->contact_d_x);
    w->field.d_y = choose(is_off, splat(0.0), w->contact_d_y);
}

/* Continue on these sides from the time `end`, and count the switches. */
INLINE void change_side(Block *w, V end, V side)
{
    M separates = (side > 0.0) & (w->side < 0.0), reattaches = (side < 0.0) & (w->side > 0.0);
    M switches = separates | reattaches;
    M is_first = switches & (w->separations + w->reattachments == 0.0);
    w->first_switch = choose(is_first, end, w->first_switch);
    w->last_switch = choose(switches, end, w->last_switch);
    w->separations = w->separations + choose(separates, splat(1.0), splat(0.0));
    w->reattachments = w->reattachments + choose(reattaches, splat(1.0), splat(0.0));
    w->side = side;
    set_field(w);
}

/* Change the side of the runs whose steps are `cut` at a switch at the time `end`. */
INLINE void change_mode(Block *w, V end, M cut)
{
    change_side(w, end, choose(cut, side_after(w, w->x, w->vx, w->vy), w->side));
}

/* Times at the ends of steps. */
typedef struct {
    V t, remainder;
    M at_horizon;
} StepEnd;

/* Times at the ends of steps, of which some are `cut` at a switch. The sum is compensated, so that
   the rounding of t does not grow with the number of steps. */
INLINE StepEnd find_step_end(const Block *w, double t_end, M cut)
{
    M at_horizon = mask_not(cut) & mask_not(w->h < (t_end - w->t) - w->remainder);
    V increment = w->h + w->remainder, t = w->t + increment, lost = t - w->t;
    V remainder = (w->t - (t - lost)) + (increment - lost);
    M is_last = at_horizon | (t >= t_end);
    return (StepEnd){choose(is_last, splat(t_end), t), remainder, is_last};
}

/* Runs that are finished, stalled, or have taken too many steps. */
typedef struct {
    unsigned finished, stalled, over_limit;
} StepFlags;

/* Continue the `live` runs from the ends of their steps, of which some are `cut` at a switch. */
INLINE StepFlags accept_step(Block *w, const StepEnd *step_end, M cut, M live, double max_steps)
{
    M short_flight = cut & (w->h < w->max_step * (SHORTEST_FLIGHT / LONGEST_STEP));
    V added = choose((w->side > 0.0) & live, w->h, splat(0.0)) + w->separated_remainder;
    V total = w->separated_time + added;
    w->separated_remainder = added - (total - w->separated_time);
    w->separated_time = total;
    if (mask_bits(cut))
        change_mode(w, step_end->t, cut);
    M stands_still = short_flight | (step_end->t == w->t);
    w->stalled = choose(stands_still, w->stalled + 1.0, splat(0.0));
    w->steps = w->steps + choose(live, splat(1.0), splat(0.0));
    w->t = choose(live, step_end->t, w->t);
    w->remainder = step_end->remainder;
    w->xs[0] = choose(live, w->x, w->xs[0]), w->xs[1] = choose(live, w->vx, w->xs[1]);
    w->ys[0] = choose(live, w->y, w->ys[0]), w->ys[1] = choose(live, w->vy, w->ys[1]);
    return (StepFlags){mask_bits(step_end->at_horizon & live),
                       mask_bits((w->stalled > MAX_STALLED) & live),
                       mask_bits((w->steps >= max_steps) & live)};
}

#endif
