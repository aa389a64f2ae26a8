/* Parts of a step of all runs of a block: its length, its end and the next mode. In functions `w`
   is the block, and `groups` is the order of expansion divided by 4 (`polynomial.h`).

   A step expands the motion, sets its length, evaluates y at the end, searches for the first switch
   (`search.h`), evaluates x, searches for extremes (`search.h`) and is accepted. */

#ifndef FIVTUI_MOTION_H
#define FIVTUI_MOTION_H

#include <stddef.h>

#include "expansion.h"
#include "field.h"
#include "polynomial.h"

/* `Status` in `fivtui.kernel.runs`, which explains them; `vary.c` sets UNBOUNDED. */
enum { DONE, OVERFLOW, STALLED, STEP_LIMIT, NO_START, RUNNING, UNBOUNDED };

/* Entries of a state (x, ẋ, y, ẏ) in m and m/s. */
enum { S_X, S_VX, S_Y, S_VY, STATE };

/* Equal to the constants of these names in `fivtui.taylor.stepper`. LONGEST_STEP is in
   √(m/stiffness), and so is SHORTEST_CUT_STEP: shorter steps that end at a switch count as stalled.
   A run ends after more than MAX_STALLED stalled steps in a row. MIN_SCALE_RATIO is the smallest
   scale of a coordinate relative to the larger one of x and y. */
#define LONGEST_STEP 1e3
#define SHORTEST_CUT_STEP 0x1p-30
/* Shortest cut step over `max_step`, which is LONGEST_STEP in s. */
#define SHORTEST_CUT_RATIO (SHORTEST_CUT_STEP / LONGEST_STEP)
#define MAX_STALLED 64.0
#define MIN_SCALE_RATIO 0x1p-30
/* `number_from_bits` replaces 2ᶠ, 0 ≤ f < 1, by 1 + f, whose logarithm is greater than f by 0 to
   0.086. To subtract half of this centres the error. */
#define EXP2_BIAS 0.043
/* Equal to the constants of these names in `fivtui.model.slider_belt`: sums of forces are zero
   below BALANCE_TOL times the sizes of their terms, or below MIN_FORCE, N or N/s. */
#define BALANCE_TOL 0x1p-49
#define MIN_FORCE 1e-280
#define INFINITE __builtin_inf()

/* Extremes over a run, and of y in the second half of the run. */
typedef struct {
    V x_low, x_high, y_low, y_high, vx_high, second_half_low, second_half_high;
} Extremes;

/* The runs of all lanes. `field` has the coefficients of the motion in the current mode,

       ẍ = a_x x + b_x y + damping_x ẋ − d_x y³,  ÿ = a_y x + b_y y + damping_y ẏ − d_y y³ − load

   Constants of a run: `contact_…` and `separated_…` are the coefficients that depend on the mode;
   `coupling` is k3/2, N/m, and `preload` F, N; `deflection` |F|/stiffness and `frequency`
   √(stiffness/m) are the scales of the motion; `max_step` is LONGEST_STEP in s; `separation` is 0
   if separation is ignored.

   State: `side` is 1 off the belt and −1 in contact, `remainder` is the exact time less t,
   `stalled` counts consecutive steps that did not advance the motion.

   Step: xs and ys are Taylor coefficients in the time since its start, so xs[0] and xs[1] are x and
   ẋ there; h is its length; x, vx, y and vy are the state at its end. `x_error` and `y_error` bound
   how far x and y are from their cubics over the step (`polynomial.h`). */
typedef struct {
    Field field;
    V contact_b_x, contact_b_y, contact_d_x, contact_d_y, separated_b_x, separated_b_y;
    V coupling, preload, deflection, frequency, max_step, separation;
    V t, remainder, side, steps, stalled, separations, reattachments, separated_time;
    V separated_remainder, first_switch, last_switch;
    Extremes extremes;
    V h, x, vx, y, vy, x_error, y_error;
    V xs[SERIES_LENGTH], ys[SERIES_LENGTH];
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
    /* Exponents of 2 in the unit of `bit_difference`. */
    const double no_limit = 200.0 * EXPONENT_ONE, min_exponent = -1000.0 * EXPONENT_ONE;
    V exponents[2];
    for (int i = 0; i < 2; i++) {
        int n = 4 * groups + 1 - i;
        V term_x = vabs(x[n]) * (double)n, term_y = vabs(y[n]) * (double)n;
        V exponent_x = bit_difference(allowed_x, term_x) * (1.0 / (n - 1));
        V exponent_y = bit_difference(allowed_y, term_y) * (1.0 / (n - 1));
        exponents[i] = vmin(choose((term_x > 0.0) & limits_x, exponent_x, splat(no_limit)),
                            choose((term_y > 0.0) & limits_y, exponent_y, splat(no_limit)));
    }
    V exponent = vmin(exponents[0], exponents[1]);
    /* Limit the exponent. If coefficients overflow, the end of the step is not finite either. */
    exponent = choose(exponent > min_exponent, exponent, splat(min_exponent));
    V h = number_from_bits(exponent, BITS_OF_ONE - (int64_t)(EXP2_BIAS * EXPONENT_ONE));
    w->h = vmin(h, w->max_step);
}

/* The upward force (k3/2) x − F, N, on a slider at rest at y = 0; zero where its parts balance up
   to rounding. `coupling` is k3/2, N/m. */
INLINE V lifting_force(V coupling, V preload, V x)
{
    V spring_force = coupling * x, force = spring_force - preload;
    V rounding = (vabs(spring_force) + vabs(preload)) * BALANCE_TOL;
    return choose(vabs(force) > vmax(rounding, splat(MIN_FORCE)), force, splat(0.0));
}

/* Where coupling and preload balance at y = 0, use the acceleration of the damper alone: a rounding
   error of random sign would cause repeated switches. */
INLINE void balance_vertical_forces(Block *w)
{
    V *y = w->ys;
    M at_zero_height = (y[0] == 0.0) & (w->separation > 0.0);
    if (!mask_bits(at_zero_height))
        return;
    M balanced = at_zero_height & (lifting_force(w->coupling, w->preload, w->xs[0]) == 0.0);
    if (!mask_bits(balanced))
        return;
    const Field *f = &w->field;
    V half_acceleration = f->damping_y * y[1] * 0.5;
    V jerk = f->a_y * w->xs[1] + f->b_y * y[1] + f->damping_y * half_acceleration * 2.0;
    y[2] = choose(balanced, half_acceleration, y[2]);
    y[3] = choose(balanced, jerk * (1.0 / 6.0), y[3]);
}

/* Evaluate y and ẏ at the end of the step, and bound the distance of y from its cubic
   (`polynomial.h`). */
INLINE void evaluate_end_y(Block *w, int groups)
{
    Tangent end = tangent_at(w->ys, groups, w->h);
    w->y = end.value, w->vy = end.slope;
    w->y_error = weighted_bound(CUBIC_BOUND, w->ys, groups, w->h);
}

/* Shorten the steps, which already end at their switches, to the horizon. Returns which: their
   switches lie beyond it, and the caller drops them. The motion up to the horizon does not depend
   on the horizon, to the last bit. */
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

/* Evaluate x and ẋ at the end of the step and, if `bounded`, bound the distance of x from its
   cubic. */
INLINE void evaluate_end_x(Block *w, int groups, int bounded)
{
    Tangent end = tangent_at(w->xs, groups, w->h);
    w->x = end.value, w->vx = end.slope;
    if (bounded)
        w->x_error = weighted_bound(CUBIC_BOUND, w->xs, groups, w->h);
}

/* Runs whose y may reach zero in the step, by bounds over the step. */
INLINE M may_reach_zero_height(const Block *w)
{
    V slope = w->ys[1] * w->h, end_slope = w->vy * w->h;
    Ends ends = {w->ys[0], w->y, slope, end_slope, w->y_error, w->y_error};
    Range y = value_range(&ends);
    M is_separated = w->side > 0.0;
    M stays_beyond_zero = choose(is_separated, y.low, -y.high) > 0.0;
    /* After a switch y starts at zero: bound y/θ, θ = time/h, in place of y. The cubic of y,
       divided by θ, is a parabola with the Bernstein coefficients `slope`, `middle` and y at the
       end. DIVIDED_BOUND times the error of y bounds that of y/θ. */
    V middle = w->y * 1.5 - end_slope * 0.5;
    V bottom = vmin(vmin(slope, w->y), middle), top = vmax(vmax(slope, w->y), middle);
    M moves_away = choose(is_separated, bottom, -top) > w->y_error * DIVIDED_BOUND;
    M from_zero = w->ys[0] == 0.0;
    return (w->separation > 0.0)
        & mask_not((from_zero & moves_away) | (mask_not(from_zero) & stays_beyond_zero));
}

/* Runs whose steps have a finite end. */
INLINE M is_finite_step(const Block *w)
{
    V total = (w->x + w->y) + (w->vx + w->vy);
    /* The difference is NaN if the sum is infinite or NaN. */
    return (total - total == 0.0) & (w->h > 0.0);
}

/* 1 if the motion continues off the belt from y = 0, −1 if in contact: the sign of the first of
   four derivatives of y that is not zero (Eqs. 3 and 4 of the paper). */
INLINE V side_after(const Block *w, V x, V vx, V vy)
{
    V force = lifting_force(w->coupling, w->preload, x);
    V force_rate = w->coupling * vx;
    /* If ẋ = 0 as well, the fourth derivative has the sign of ẍ and hence of −x: at y = 0 there is
       no friction, and only springs act on x. */
    V jerk_or_next = choose(vabs(force_rate) > MIN_FORCE, force_rate, -(w->coupling * x));
    V direction = choose(vy != 0.0, vy, choose(force != 0.0, force, jerk_or_next));
    return choose(direction > 0.0, splat(1.0), splat(-1.0));
}

/* The mode of a run on a belt that is always faster than the slider. On belts of finite speed there
   are further modes (`belt.h`). */
INLINE int mode_in_lane(const Block *w, int lane)
{
    return get_lane(&w->side, lane) < 0.0 ? CONTACT : SEPARATED;
}

/* Set the coefficients of the field that depend on the side. */
INLINE void set_field(Block *w)
{
    M is_separated = w->side > 0.0;
    w->field.b_x = choose(is_separated, w->separated_b_x, w->contact_b_x);
    w->field.b_y = choose(is_separated, w->separated_b_y, w->contact_b_y);
    w->field.d_x = choose(is_separated, splat(0.0), w->contact_d_x);
    w->field.d_y = choose(is_separated, splat(0.0), w->contact_d_y);
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

/* Change the side of the runs whose steps are `cut` at y = 0 at the time `end`. */
INLINE void change_mode(Block *w, V end, M cut)
{
    change_side(w, end, choose(cut, side_after(w, w->x, w->vx, w->vy), w->side));
}

/* Times at the ends of steps: t, the exact time less t (`remainder`), and whether it is the end of
   the run. */
typedef struct {
    V t, remainder;
    M at_horizon;
} StepEnd;

/* Times at the ends of steps, of which some are `cut` at a switch. The sum is compensated, so that
   the rounding of t does not grow with the number of steps. */
INLINE StepEnd find_step_end(const Block *w, double t_end, M cut)
{
    M at_horizon = mask_not(cut) & mask_not(w->h < (t_end - w->t) - w->remainder);
    V increment = w->h + w->remainder, t = w->t + increment, added = t - w->t;
    /* The rounding error of the sum (Knuth). */
    V remainder = (w->t - (t - added)) + (increment - added);
    M is_last = at_horizon | (t >= t_end);
    return (StepEnd){choose(is_last, splat(t_end), t), remainder, is_last};
}

/* Bits of the runs that have reached the horizon, stalled, or taken too many steps. */
typedef struct {
    unsigned finished, stalled, over_limit;
} StepFlags;

/* Continue the runs with a `finite` end from the ends of their steps, of which some are `cut` at
   y = 0. */
INLINE StepFlags accept_step(Block *w, const StepEnd *step_end, M cut, M finite, double max_steps)
{
    M is_short = cut & (w->h < w->max_step * SHORTEST_CUT_RATIO);
    V added = choose((w->side > 0.0) & finite, w->h, splat(0.0)) + w->separated_remainder;
    V total = w->separated_time + added;
    w->separated_remainder = added - (total - w->separated_time);
    w->separated_time = total;
    if (mask_bits(cut))
        change_mode(w, step_end->t, cut);
    M is_stalled = is_short | (step_end->t == w->t);
    w->stalled = choose(is_stalled, w->stalled + 1.0, splat(0.0));
    w->steps = w->steps + choose(finite, splat(1.0), splat(0.0));
    w->t = choose(finite, step_end->t, w->t);
    w->remainder = step_end->remainder;
    w->xs[0] = choose(finite, w->x, w->xs[0]), w->xs[1] = choose(finite, w->vx, w->xs[1]);
    w->ys[0] = choose(finite, w->y, w->ys[0]), w->ys[1] = choose(finite, w->vy, w->ys[1]);
    return (StepFlags){mask_bits(step_end->at_horizon & finite),
                       mask_bits((w->stalled > MAX_STALLED) & finite),
                       mask_bits((w->steps >= max_steps) & finite)};
}

#endif
