/* A slider on a belt of finite speed: its modes, their guards and the next modes, by the table in
   `fivtui.model.modes`. A guard is positive while its mode lasts. v_r = v_belt − ẋ is the speed of
   the belt relative to the slider, P the contact force. The belt holds a slider that sticks by the
   holding force f, while |f| ≤ μ_s P. V is a number and M a truth value of each run (`vector.h`).
   With LANES = 1 this header also has the steps of a single run; `belts.h` has those of blocks of
   runs (`Block` in `motion.h`, here `w`). */

#ifndef FIVTUI_BELT_H
#define FIVTUI_BELT_H

#include "friction.h"
#include "problem.h"
#include "recurrence.h"
#include "search.h"
#if LANES == 1
#include "run.h"
#endif

/* Equal to the constants of these names in `fivtui.taylor.belt`: distance of simultaneous roots
   relative to the step, and shortest step of a creeping motion relative to t. */
#define SIMULTANEOUS 0x1p-40
#define UNRESOLVED 0x1p-50

/* A belt: coefficients of the motion (`Field` in `expansion.h`) and friction law of each mode,
   exponential at the start of the next step, parameters at the start of a step (v_s = 0 for
   constant friction), √(stiffness/m), rates of parameters, and the mode. `smooth` says that
   friction does not jump at v_r = 0, `finite` that the speed is finite, `by_speed` that friction
   follows a law. Guards of stick within `hold_tolerance`, relative to their terms, count as
   zero. */
typedef struct {
#if LANES == 1
    Field fields[MODES];
    Law laws[MODES];
    LawStart next_start;
#endif
    double p[BELT_PARAMETERS], frequency;
    Rates rates;
    double hold_tolerance;
    int64_t mode, smooth, finite, by_speed;
} Belt;

INLINE int is_sliding(int64_t mode) { return mode == FORWARD || mode == BACKWARD; }

/* Sign of v_r and of friction in a mode on a belt of finite speed; 0 without sliding. */
INLINE double friction_sign(int64_t mode)
{
    if (mode == FORWARD)
        return 1.0;
    return mode == BACKWARD ? -1.0 : 0.0;
}

/* A function of time and its first two derivatives are in arrays of this length. */
#define DERIVATIVES 3

/* Whether a function is or becomes negative: the sign of the first of its value and derivatives
   that exceeds rounding (`BALANCE_TOL` in `motion.h`), relative to `sizes`; the value has the
   tolerance `hold_tolerance`. */
INLINE int is_falling(double hold_tolerance, const double *derivatives, const double *sizes)
{
    for (int n = 0; n < DERIVATIVES; n++) {
        double zero = (n == 0 ? hold_tolerance : BALANCE_TOL) * sizes[n];
        if (__builtin_fabs(derivatives[n]) > maximum(zero, MIN_FORCE))
            return derivatives[n] < 0.0;
    }
    return 0;
}

/* The product of a function and a linear function, with first and second derivative. */
INLINE void multiply_by_line(double value, double slope, const double *function, double *result)
{
    result[0] = value * function[0];
    result[1] = slope * function[0] + value * function[1];
    result[2] = 2.0 * slope * function[1] + value * function[2];
}

/* The mode in contact: `_contact_mode` in `fivtui.model.slider_belt`. A slider at the speed of the
   belt sticks unless P, μ_s P − f or μ_s P + f is or becomes negative. */
NOINLINE int64_t mode_on_belt(const Belt *belt, double x, double vx, double y, double vy)
{
    const double *p = belt->p, v = p[P_V_BELT], horizontal = horizontal_stiffness(p),
        coupling = coupling_stiffness(p);
    const Rates *rates = &belt->rates;
    /* A belt that is always faster than the slider: the only mode in contact. */
    if (!belt->finite)
        return CONTACT;
    if (vx != v)
        return vx < v ? FORWARD : BACKWARD;
    double force = spring_force(p, y), kt = tangent_stiffness(p, y);
    double ay = vertical_acceleration(p, x, y, vy, force - load_of(p));
    double slope_term = tangent_slope(p, y) * vy * vy, damper_rate = p[P_C1] * rates->v_belt;
    const double held[DERIVATIVES] = {holding_force(p, x, y, rates->v_belt),
                                      holding_force_rate(p, rates->v_belt, v, vy),
                                      holding_force_rate(p, 0.0, rates->v_belt, ay)};
    const double forces[DERIVATIVES] = {force, -kt * vy, -kt * ay - slope_term};
    /* Sizes are sums of absolute terms, to which rounding is relative. They include the preload: y
       follows from sums with it, so that even a small P has a rounding error relative to it. */
    const double load = __builtin_fabs(load_of(p)),
        vy_scale = load / total_stiffness(p) * belt->frequency;
    const double force_sizes[DERIVATIVES] = {
        __builtin_fabs(force) + load,
        kt * (__builtin_fabs(vy) + vy_scale),
        kt * (__builtin_fabs(ay) + load / p[P_M]) + __builtin_fabs(slope_term)};
    const double held_sizes[DERIVATIVES] = {
        __builtin_fabs(p[P_C1] * v) + __builtin_fabs(p[P_M] * rates->v_belt)
            + __builtin_fabs(horizontal * x) + __builtin_fabs(coupling * y),
        __builtin_fabs(damper_rate) + __builtin_fabs(horizontal * v) + __builtin_fabs(coupling * vy),
        __builtin_fabs(horizontal * rates->v_belt) + __builtin_fabs(coupling * ay)};
    double grips[DERIVATIVES], sizes[DERIVATIVES], margin[DERIVATIVES];
    multiply_by_line(belt->p[P_MU_S], __builtin_fabs(rates->mu_static), force_sizes, sizes);
    for (int n = 0; n < DERIVATIVES; n++)
        sizes[n] = held_sizes[n] + sizes[n];
    if (is_falling(belt->hold_tolerance, forces, force_sizes))
        return is_falling(belt->hold_tolerance, held, sizes) ? BACKWARD : FORWARD;
    multiply_by_line(belt->p[P_MU_S], rates->mu_static, forces, grips);
    for (int n = 0; n < DERIVATIVES; n++)
        margin[n] = grips[n] - held[n];
    if (is_falling(belt->hold_tolerance, margin, sizes))
        return FORWARD;
    for (int n = 0; n < DERIVATIVES; n++)
        margin[n] = grips[n] + held[n];
    return is_falling(belt->hold_tolerance, margin, sizes) ? BACKWARD : STICK;
}

/* Half the acceleration of a slider that begins to slide: the Taylor coefficient xs[2], `expanded`
   by the recurrences. Where friction balances the other forces, or the slider would pass the belt,
   it is half the acceleration of the belt: otherwise a rounding error would make the slider stick
   again at once. */
INLINE double start_half_acceleration(const Belt *belt, double x, double y, double expanded)
{
    const double *p = belt->p;
    double grip = p[P_MU_S] * spring_force(p, y), held = holding_force(p, x, y, belt->rates.v_belt);
    double size = __builtin_fabs(p[P_C1] * p[P_V_BELT]) + __builtin_fabs(p[P_M] * belt->rates.v_belt)
                  + __builtin_fabs(horizontal_stiffness(p) * x)
                  + __builtin_fabs(coupling_stiffness(p) * y) + __builtin_fabs(grip);
    double belt_half = 0.5 * belt->rates.v_belt;
    int forward = belt->mode == FORWARD;
    double margin = forward ? grip - held : grip + held;
    int balanced = belt->smooth && __builtin_fabs(margin) <= BALANCE_TOL * size;
    int passes_belt = forward ? expanded > belt_half : expanded < belt_half;
    return balanced || passes_belt ? belt_half : expanded;
}

/* A guard over a step: its polynomial in the time since the start, filled up with zeros, and its
   value at the end. */
typedef struct {
    double c[SERIES_LENGTH], end;
} Guard;

/* At the start of a mode its guard is positive, or zero and rising: clear what differs by rounding.
   The search for the next zero excludes a simple zero at the start. Make a double zero a simple
   one: divide the guard by time. */
INLINE void normalize_guard(Guard *guard, double h)
{
    double *c = guard->c;
    if (c[0] > 0.0)
        return;
    c[0] = 0.0, c[1] = maximum(c[1], 0.0);
    if (c[1] == 0.0) {
        memmove(c, c + 1, (SERIES_LENGTH - 1) * sizeof *c);
        guard->end /= h;
    }
}

/* Set the guard `sign` v_r of one lane. */
INLINE void set_speed_guard(const Belt *belt, const Block *w, int lane, int groups, double sign,
                            Guard *guard)
{
    double *c = guard->c, v = belt->p[P_V_BELT], rate = belt->rates.v_belt;
    /* The coefficients of −`sign` ẋ; then those of v_belt enter the first two. */
    for (int n = 0; n <= 4 * groups; n++)
        c[n] = -sign * (n + 1) * get_lane(w->xs + n + 1, lane);
    c[0] = sign * (v - get_lane(w->xs + 1, lane)), c[1] += sign * rate;
    memset(c + 4 * groups + 1, 0, (SERIES_LENGTH - 1 - 4 * groups) * sizeof *c);
    guard->end = sign * (v + rate * get_lane(&w->h, lane) - get_lane(&w->vx, lane));
}

/* Whether `sign` v_r stays positive for certain while the belt's speed changes from v to end_v.
   Speeds are compared times h, as the slopes in `Ends` are. */
INLINE M keeps_sliding(const Block *w, int groups, V sign, V v, V end_v)
{
    Ends x = ends_of_x(w);
    V error = weighted_bound(CUBIC_SLOPE_BOUND, w->xs, groups, w->h);
    V max_slope = vmax(vmax(sign * x.start_slope, sign * x.end_slope), sign * middle_slope(&x));
    return vmin(sign * v, sign * end_v) * w->h > max_slope + error;
}

/* Set the guards μ_s P − f and μ_s P + f of one lane; f is the holding force of the belt. The
   expansions of x and y give P = m ÿ + c2 ẏ + F − h (x − y), h = k3/2. Coefficients of P, μ_s P and
   f are `force`, `grip` and `held`. */
INLINE void set_hold_guards(const Belt *belt, const Block *w, int lane, int groups,
                            Guard *forward_guard, Guard *backward_guard)
{
    const Rates *rates = &belt->rates;
    const double *p = belt->p, m = p[P_M];
    const double horizontal = horizontal_stiffness(p), coupling = coupling_stiffness(p);
    const double duration = get_lane(&w->h, lane), mu_change = rates->mu_static * duration;
    double force[SERIES_LENGTH], grip[SERIES_LENGTH], held[SERIES_LENGTH];
    for (int n = 0; n < 4 * groups; n++) {
        double y = get_lane(w->ys + n, lane);
        /* The n-th coefficient of c2 ẏ + m ÿ, divided by n + 1. */
        double damper_and_inertia = p[P_C2] * get_lane(w->ys + n + 1, lane)
            + m * (n + 2) * get_lane(w->ys + n + 2, lane);
        force[n] = (n + 1) * damper_and_inertia + coupling * y;
        grip[n] = p[P_MU_S] * force[n], held[n] = -coupling * y;
    }
    /* Where the slider sticks x is of the second degree. */
    const int x_rows = 3;
    force[0] = spring_force(p, get_lane(w->ys, lane)), force[1] += rates->F;
    for (int n = 1; n < x_rows; n++) {
        double x = get_lane(w->xs + n, lane);
        force[n] -= coupling * x, grip[n] = p[P_MU_S] * force[n], held[n] += horizontal * x;
    }
    grip[0] = p[P_MU_S] * force[0];
    held[0] = holding_force(p, get_lane(w->xs, lane), get_lane(w->ys, lane), rates->v_belt);
    held[1] += p[P_C1] * rates->v_belt;
    if (mu_change != 0.0)
        for (int n = 1; n < 4 * groups; n++)
            grip[n] += rates->mu_static * force[n - 1];
    memset(forward_guard, 0, sizeof *forward_guard);
    memset(backward_guard, 0, sizeof *backward_guard);
    for (int n = 0; n < 4 * groups; n++)
        forward_guard->c[n] = grip[n] - held[n], backward_guard->c[n] = grip[n] + held[n];
    double y = get_lane(&w->y, lane), end_grip = (p[P_MU_S] + mu_change) * spring_force(p, y);
    double end_held = holding_force(p, get_lane(&w->x, lane), y, rates->v_belt)
        + p[P_C1] * rates->v_belt * duration;
    forward_guard->end = end_grip - end_held, backward_guard->end = end_grip + end_held;
}

/* Bounds over a step in which the slider sticks: least μ_s, stiffnesses of contact and coupling,
   the holding force for y = 0 at both ends, and the greatest distance of that force from its
   chord. */
typedef struct {
    V mu_s, k2, k_nl, coupling, start, end, chord_error;
} Hold;

/* Whether the belt holds the slider for certain over the step against forward and backward slip. */
typedef struct {
    M forward, backward;
} HeldSides;

INLINE HeldSides keeps_holding(const Block *w, const Hold *bounds)
{
    Ends ends = ends_of_y(w);
    Range y = value_range(&ends);
    /* The least contact force. */
    V force = -bounds->k2 * y.high - bounds->k_nl * y.high * y.high * y.high;
    /* Against forward slip the margin is μ_s P + (k3/2) y less a force without y. With μ_s
       k2 ≥ k3/2 it is least at the greatest y, where P is least; else bound μ_s P and (k3/2) y
       apart. */
    V worst_y = choose(bounds->mu_s * bounds->k2 >= bounds->coupling, y.high, y.low);
    V margin = bounds->mu_s * force - bounds->chord_error;
    return (HeldSides){margin > vmax(bounds->start, bounds->end) - bounds->coupling * worst_y,
                       margin > bounds->coupling * y.high - vmin(bounds->start, bounds->end)};
}

/* The zero that cuts a step: none, that of y, of v_r, or of a guard of stick. */
typedef enum { NOT_CUT, CUT_AT_ZERO_HEIGHT, CUT_AT_SPEED, CUT_AT_HOLD } StepCut;

/* Time at which stick ends, from the times at which both guards fall to zero; sets the next
   mode. */
INLINE double first_release_time(double forward_time, double backward_time, int64_t *mode)
{
    int backward = backward_time < forward_time * (1.0 - SIMULTANEOUS);
    *mode = backward ? BACKWARD : FORWARD;
    return backward ? backward_time : forward_time;
}

/* Whether a guard that falls to zero at `fall_time` ends the step, which may be `cut` already:
   CUT_AT_ZERO_HEIGHT precedes other guards that fall to zero at the same time. */
INLINE int ends_step(double fall_time, double h, StepCut cut)
{
    return fall_time <= h
        && !(cut == CUT_AT_ZERO_HEIGHT && fall_time >= h * (1.0 - SIMULTANEOUS));
}

#if LANES == 1

/* Time at which a guard falls to zero in the step; infinite if it does not. */
INLINE double guard_fall_time(Guard *guard, double h, int groups)
{
    const unsigned lanes = 1;
    const double side = 1.0;
    normalize_guard(guard, h);
    const double *c = guard->c, slope = tangent_at(c, groups, h).slope;
    const double error = weighted_bound(CUBIC_BOUND, c, groups, h);
    return find_first_switch(c, groups, side, &h, guard->end, slope, error, lanes) ? h : INFINITE;
}

/* The time at which v_r falls to zero. */
NOINLINE double speed_fall_time(const Belt *belt, const Block *w, int groups, double sign)
{
    Guard guard;
    set_speed_guard(belt, w, 0, groups, sign, &guard);
    return guard_fall_time(&guard, w->h, groups);
}

/* The time at which stick ends, by the guards not in `held`; sets the next mode. */
NOINLINE double hold_fall_time(const Belt *belt, const Block *w, int groups, const HeldSides *held,
                               int64_t *mode)
{
    Guard forward_guard, backward_guard;
    set_hold_guards(belt, w, 0, groups, &forward_guard, &backward_guard);
    double forward = held->forward ? INFINITE : guard_fall_time(&forward_guard, w->h, groups);
    double backward = held->backward ? INFINITE : guard_fall_time(&backward_guard, w->h, groups);
    return first_release_time(forward, backward, mode);
}

/* Upper bound of ẋ inside a step of length h; in stick the greatest ẋ is at an end of the step. */
INLINE double speed_limit(const Belt *belt, double h)
{
    if (belt->mode == STICK)
        return -INFINITE;
    return belt->mode == FORWARD
        ? maximum(belt->p[P_V_BELT], belt->p[P_V_BELT] + belt->rates.v_belt * h) : INFINITE;
}

/* The first time at which a guard of the mode falls to zero, infinite without one. `slides` says
   that the slider keeps sliding for certain. */
INLINE double first_fall_time(const Belt *belt, const Block *w, int groups, int slides,
                              int64_t *next_mode)
{
    if (is_sliding(belt->mode)) {
        if (slides)
            return INFINITE;
        double sign = friction_sign(belt->mode), v = belt->p[P_V_BELT];
        return keeps_sliding(w, groups, sign, v, v + belt->rates.v_belt * w->h)
                   ? INFINITE
                   : speed_fall_time(belt, w, groups, sign);
    }
    if (belt->mode != STICK)
        return INFINITE;
    const double *p = belt->p, acceleration = belt->rates.v_belt;
    const Hold hold = {
        .mu_s = minimum(p[P_MU_S], p[P_MU_S] + belt->rates.mu_static * w->h),
        .k2 = p[P_K2], .k_nl = p[P_K_NL], .coupling = coupling_stiffness(p),
        .start = holding_force(p, w->xs[0], 0.0, acceleration),
        .end = holding_force(p, w->x, 0.0, acceleration) + p[P_C1] * acceleration * w->h,
        .chord_error =
            0.125 * horizontal_stiffness(p) * __builtin_fabs(acceleration) * (w->h * w->h)};
    const HeldSides held = keeps_holding(w, &hold);
    return held.forward && held.backward ? INFINITE
        : hold_fall_time(belt, w, groups, &held, next_mode);
}

/* Shorten the step to the first zero of a guard; sets `next_mode` where stick ends. */
INLINE StepCut cut_step(const Belt *belt, Block *w, int groups, int slides, int64_t *next_mode)
{
    StepCut cut = NOT_CUT;
    if (may_reach_zero_height(w) && cut_at_zero_height(w, groups))
        cut = CUT_AT_ZERO_HEIGHT;
    evaluate_end_x(w, groups, 1);
    double fall_time = first_fall_time(belt, w, groups, slides, next_mode);
    if (!ends_step(fall_time, w->h, cut))
        return cut;
    w->h = fall_time;
    evaluate_end_y(w, groups);
    evaluate_end_x(w, groups, 1);
    return belt->mode == STICK ? CUT_AT_HOLD : CUT_AT_SPEED;
}

/* Expand a step by recurrences that `field_text` generates from the equations. LAW_IS_TUNED says
   that they are not needed: `friction.h` has hand-written recurrences for this friction law. */
INLINE void expand_generated(const Belt *belt, V *x, V *y, int order)
{
#if !LAW_IS_TUNED
    if (belt->mode == FORWARD)
        expand_forward(belt->p, &belt->rates, x, y, order);
    else
        expand_backward(belt->p, &belt->rates, x, y, order);
#endif
}

/* Expand a step and set its length; returns whether the slider keeps sliding for certain. */
INLINE int expand_belt_step(const Belt *belt, Block *w, double tol, int order, int cubic)
{
    const Law *law = belt->laws + belt->mode;
    w->field = belt->fields[belt->mode];
    /* `per_speed` is positive only where the slider slides under a friction law. */
    if (!LAW_IS_TUNED && law->per_speed > 0.0)
        expand_generated(belt, w->xs, w->ys, order);
    else if (belt->by_speed && belt->mode == STICK)
        expand_sticking(w->xs, w->ys, &w->field, law, order, cubic);
    else if (belt->by_speed)
        expand_by_law(w->xs, w->ys, &w->field, law, belt->p[P_V_BELT], &belt->next_start, order,
                      cubic);
    else
        expand_block(w, order, cubic && belt->mode != SEPARATED);
    balance_vertical_forces(w);
    if (w->xs[1] == belt->p[P_V_BELT] && is_sliding(belt->mode))
        w->xs[2] = start_half_acceleration(belt, w->xs[0], w->ys[0], w->xs[2]);
    set_step_length(w, tol, order / GROUP_SIZE);
    M slides = 0;
    if (law->per_speed > 0.0)
        w->h = limit_step(w->h, w->xs, law, law->sign * (belt->p[P_V_BELT] - w->xs[1]),
                          order / GROUP_SIZE, &slides);
    return slides;
}

/* Compute exp(−v/v_s) for the start of the next step, while the processor also computes the
   extremes. */
INLINE void prepare_exponential(Belt *belt, const Block *w)
{
    const Law *law = belt->laws + belt->mode;
    if (law->per_speed > 0.0) {
        double exponent = sliding_exponent(law, belt->p[P_V_BELT], w->vx);
        belt->next_start = (LawStart){exponent, exponential(-exponent)};
    }
}

/* Accept the step and set the next mode. */
INLINE StepFlags accept_belt_step(Belt *belt, Block *w, const StepEnd *step_end, StepCut cut,
                                  int64_t next_mode)
{
    double stalled_before = w->stalled, shortest = w->max_step * SHORTEST_CUT_RATIO;
    const int is_creeping = belt->laws[belt->mode].per_speed > 0.0 && w->h < w->t * UNRESOLVED;
    StepFlags flags = accept_step(w, step_end, cut == CUT_AT_ZERO_HEIGHT, 1, INFINITE);
    if (((cut == CUT_AT_SPEED || cut == CUT_AT_HOLD) && w->h < shortest) || is_creeping) {
        w->stalled = stalled_before + 1.0;
        flags.stalled = w->stalled > MAX_STALLED;
    }
    if (cut == CUT_AT_HOLD)
        belt->mode = next_mode;
    else if (cut != NOT_CUT)
        belt->mode = w->side > 0.0 ? SEPARATED : mode_on_belt(belt, w->x, w->vx, w->y, w->vy);
    return flags;
}

#endif

#if LANES == 1
/* Set a field from the coefficients of a mode. */
INLINE void set_belt_field(Field *f, const Coefficients *c)
{
    f->a_x = c->xx, f->a_y = c->yx, f->b_x = c->xy, f->b_y = c->yy;
    f->damping_x = c->xvx, f->damping_y = c->yvy;
    f->d_x = c->friction * c->cubic, f->d_y = c->cubic, f->load = c->load;
}

/* Set field and friction law of each mode from the parameters. */
INLINE void set_belt_fields(Belt *belt)
{
    const double *p = belt->p;
    for (int mode = 0; mode < MODES; mode++) {
        const Coefficients c = coefficients_in(mode, p);
        set_belt_field(belt->fields + mode, &c);
        if (!belt->by_speed)
            continue;
        double sign = friction_sign(mode);
        belt->laws[mode] = (Law){.sign = sign, .mu = p[P_MU], .mu_drop = p[P_MU_S] - p[P_MU],
                                 .per_speed = sign != 0.0 ? 1.0 / p[P_V_S] : 0.0,
                                 .contact = mode == SEPARATED ? 0.0 : p[P_K2] / p[P_M]};
        /* `expand_slide` adds contact and friction itself: b_x is that of the coupling alone. */
        belt->fields[mode].b_x = mode == STICK ? 0.0 : separated_coefficients(p).xy;
    }
}
#endif

/* Begin with the parameters `p` in a lane whose problem has begun. Columns of the belt are read
   only if its speed is finite. */
INLINE void begin_belt(Belt *belt, const Block *w, int lane, const double *p, int finite)
{
    memset(belt, 0, sizeof *belt);
    belt->finite = finite, belt->hold_tolerance = BALANCE_TOL;
    memcpy(belt->p, p, sizeof(double) * (size_t)(finite ? BELT_PARAMETERS : PARAMETERS));
    if (!finite)
        belt->p[P_MU_S] = p[P_MU];
    belt->frequency = get_lane(&w->frequency, lane);
    belt->by_speed = belt->p[P_V_S] > 0.0;
#if LANES == 1
    belt->next_start = (LawStart){.exponent = 0.0, .e = 1.0};
    set_belt_fields(belt);
#endif
    belt->smooth = belt->p[P_MU_S] == p[P_MU] || belt->by_speed;
    belt->mode = get_lane(&w->side, lane) > 0.0
                   ? SEPARATED
                   : mode_on_belt(belt, get_lane(w->xs, lane), get_lane(w->xs + 1, lane),
                                  get_lane(w->ys, lane), get_lane(w->ys + 1, lane));
}

#endif
