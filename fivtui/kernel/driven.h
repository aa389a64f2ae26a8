/* The motion while F, μ and the belt's speed change linearly with time, on a belt of finite speed
   or one that is always faster than the slider. A course has these parameters as functions of time.
   LANES is 1: the block `w` has one run. */

#ifndef FIVTUI_DRIVEN_H
#define FIVTUI_DRIVEN_H

#include "belt.h"

/* A linear function of time: its value at a start time, and its slope. */
typedef struct {
    double value, slope;
} Ramp;

/* F, μ, μ_s and the belt's speed from the time `start` on. */
typedef struct {
    Ramp force, friction, mu_static, speed;
    double start;
} Course;

INLINE double ramp_at(Ramp ramp, double elapsed) { return ramp.value + ramp.slope * elapsed; }

/* Time since the start of a course; `remainder` is the exact time less t. */
INLINE double elapsed_time(const Course *course, double t, double remainder)
{
    return (t - course->start) + remainder;
}

/* Set the parameters at a time of a course, and their rates. */
INLINE void set_course_parameters(Belt *belt, Block *w, const Course *course, double elapsed)
{
    double *p = belt->p;
    p[P_F] = ramp_at(course->force, elapsed), p[P_MU] = ramp_at(course->friction, elapsed);
    p[P_MU_S] = ramp_at(course->mu_static, elapsed), p[P_V_BELT] = ramp_at(course->speed, elapsed);
    w->preload = load_of(p);
    belt->rates = (Rates){course->force.slope, course->friction.slope, course->mu_static.slope,
                          course->speed.slope};
    for (int mode = FORWARD; mode <= BACKWARD; mode++)
        belt->laws[mode].mu = p[P_MU], belt->laws[mode].mu_drop = p[P_MU_S] - p[P_MU];
    belt->smooth = p[P_MU_S] == p[P_MU] || belt->laws[FORWARD].per_speed > 0.0;
}

/* Sliding speed in a mode, without negative rounding errors. */
INLINE double speed_by_law(const Belt *belt, const Law *law, double vx)
{
    return maximum(law->sign * (belt->p[P_V_BELT] - vx), 0.0);
}

/* Compute the coefficients of x and y from the first two: Eqs. 2 and 5 of the paper, with or
   without a friction law. */
NOINLINE void expand_driven(const Belt *belt, V *x, V *y, int order)
{
    const Law *law = belt->laws + belt->mode;
    const Rates *rates = &belt->rates;
    const double *p = belt->p;
    const int in_contact = belt->mode != SEPARATED, by_speed = law->per_speed > 0.0;
    const double sign = belt->mode == BACKWARD ? -1.0 : 1.0, rate = law->sign * law->per_speed;
    /* Linear functions of time: μ, F and μ_s − μ, the factor of e in μ(v) = μ + (μ_s − μ) e. */
    const double force[2] = {load_of(p), rates->F}, mu[2] = {p[P_MU], rates->mu};
    const double mu_drop[2] = {law->mu_drop, rates->mu_static - rates->mu};
    /* Coefficients of y², the contact force P, e = exp(−v/v_s), μ(v), and ẍ less the acceleration
       of the belt. */
    double square[MAX_TERMS], contact[MAX_TERMS], e[MAX_TERMS], mu_of_v[MAX_TERMS],
        slip_rate[MAX_TERMS];
    for (int n = 0; n < order; n++) {
        square[n] = product(y, y, n);
        contact[n] = in_contact ? -p[P_K2] * y[n] - p[P_K_NL] * product(y, square, n) : 0.0;
        double friction = mu[0] * contact[n] + (n > 0 ? mu[1] * contact[n - 1] : 0.0);
        /* e satisfies ė = rate · slip_rate · e. */
        if (by_speed) {
            e[n] = n > 0 ? rate * product(slip_rate, e, n - 1) / n
                         : exponential(-speed_by_law(belt, law, x[1]) * law->per_speed);
            mu_of_v[n] = (n < 2 ? mu[n] : 0.0) + mu_drop[0] * e[n]
                + (n > 0 ? mu_drop[1] * e[n - 1] : 0.0);
            friction = product(mu_of_v, contact, n);
        }
        double coupling_force = coupling_stiffness(p) * (x[n] - y[n]),
            factor = p[P_M] * (n + 1.0) * (n + 2.0);
        double load = n < 2 ? force[n] : 0.0;
        x[n + 2] = (sign * friction - p[P_C1] * (n + 1.0) * x[n + 1] - p[P_K1] * x[n]
                    - coupling_force) / factor;
        if (belt->mode == STICK)
            x[n + 2] = n == 0 ? 0.5 * rates->v_belt : 0.0;
        y[n + 2] = (contact[n] - load - p[P_C2] * (n + 1.0) * y[n + 1] + coupling_force) / factor;
        slip_rate[n] = x[n + 2] * (n + 1.0) * (n + 2.0) - (n == 0 ? rates->v_belt : 0.0);
    }
}

/* Expand a step of at most `max_step`; the parameters of the belt are set. */
INLINE void expand_driven_step(const Belt *belt, Block *w, double tol, int order, double max_step)
{
    const Law *law = belt->laws + belt->mode;
    w->field = belt->fields[belt->mode];
    /* Without hand-written recurrences (LAW_IS_TUNED) a friction law has generated ones. */
    if (!LAW_IS_TUNED && law->per_speed > 0.0)
        expand_generated(belt, w->xs, w->ys, order);
    else
        expand_driven(belt, w->xs, w->ys, order);
    balance_vertical_forces(w);
    /* It has taken the load as constant. A load with the rate Ḟ adds −Ḟ/m to the third derivative
       of y; ys[3] is a sixth of that. */
    if (w->ys[0] == 0.0 && w->separation > 0.0
        && lifting_force(w->coupling, w->preload, w->xs[0]) == 0.0)
        w->ys[3] -= belt->rates.F / (6.0 * belt->p[P_M]);
    if (w->xs[1] == belt->p[P_V_BELT] && is_sliding(belt->mode))
        w->xs[2] = start_half_acceleration(belt, w->xs[0], w->ys[0], w->xs[2]);
    set_step_length(w, tol, order / GROUP_SIZE);
    if (law->per_speed > 0.0) {
        /* v_r also changes with the speed of the belt: for a moment xs is the motion relative to
           it. */
        const double half_acceleration = w->xs[2];
        M slides;
        w->xs[2] -= 0.5 * belt->rates.v_belt;
        w->h = limit_step(w->h, w->xs, law, speed_by_law(belt, law, w->xs[1]), order / GROUP_SIZE,
                          &slides);
        w->xs[2] = half_acceleration;
    }
    w->h = minimum(w->h, max_step);
}

/* 1 if the motion continues off the belt, −1 in contact: `_separates` in
   `fivtui.model.slider_belt`. */
INLINE double driven_side(const Belt *belt, const Block *w)
{
    if (!(w->separation > 0.0))
        return -1.0;
    if (w->y != 0.0)
        return w->y > 0.0 ? 1.0 : -1.0;
    double force = lifting_force(w->coupling, w->preload, w->x);
    double force_rate = w->coupling * w->vx - belt->rates.F;
    /* The sign of the first of four derivatives of y that is not zero. The fourth has that of
       (k3/2) ẍ; unlike in `side_after` ẋ need not be zero, as the load changes. */
    double direction = w->vy;
    if (direction == 0.0)
        direction = force;
    if (direction == 0.0 && __builtin_fabs(force_rate) > MIN_FORCE)
        direction = force_rate;
    if (direction == 0.0)
        direction = w->coupling * horizontal_acceleration(belt->p, w->x, w->vx, 0.0, 0.0);
    return direction > 0.0 ? 1.0 : -1.0;
}

/* Set the next mode at the end of a step; the parameters are those at that time. */
INLINE void change_course_mode(Belt *belt, Block *w, double end, StepCut cut, int64_t next_mode)
{
    change_side(w, end, driven_side(belt, w));
    if (cut == CUT_AT_HOLD)
        belt->mode = next_mode;
    else
        belt->mode = w->side > 0.0 ? SEPARATED : mode_on_belt(belt, w->x, w->vx, w->y, w->vy);
}

/* Begin a course; the block and the belt have begun. */
INLINE void begin_driven(Belt *belt, Block *w, const Course *course)
{
    w->x = w->xs[0], w->vx = w->xs[1], w->y = w->ys[0], w->vy = w->ys[1];
    set_course_parameters(belt, w, course, elapsed_time(course, w->t, w->remainder));
    w->side = driven_side(belt, w);
    set_field(w);
    belt->mode = w->side > 0.0 ? SEPARATED : mode_on_belt(belt, w->x, w->vx, w->y, w->vy);
}

/* Accept a step at whose end the belt has `speed`, and continue with `course`. At a row of the
   table the mode may change without a cut. */
INLINE StepFlags accept_driven_step(Belt *belt, Block *w, const StepEnd *step_end, StepCut cut,
                                    int64_t next_mode, double speed, const Course *course,
                                    int at_row)
{
    double stalled_before = w->stalled, shortest = w->max_step * SHORTEST_CUT_RATIO;
    if (cut == CUT_AT_SPEED || belt->mode == STICK)
        w->vx = speed;
    /* `change_course_mode` sets the side below, not this call. */
    const M changes_side = 0, finite = 1;
    const double max_steps = INFINITE;
    StepFlags flags = accept_step(w, step_end, changes_side, finite, max_steps);
    if (cut != NOT_CUT && w->h < shortest) {
        w->stalled = stalled_before + 1.0;
        flags.stalled = w->stalled > MAX_STALLED;
    }
    set_course_parameters(belt, w, course, elapsed_time(course, step_end->t, step_end->remainder));
    if (cut != NOT_CUT || at_row)
        change_course_mode(belt, w, step_end->t, cut, next_mode);
    return flags;
}

/* The belt's speed at the end of a step over a course. */
INLINE double end_speed(const Course *course, const StepEnd *step_end)
{
    return ramp_at(course->speed, elapsed_time(course, step_end->t, step_end->remainder));
}

#endif
