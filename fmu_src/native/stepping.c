/* The motion in Taylor steps, with the kernel's functions, for one instruction set.

   `m` is the motion, whose flags and counts are doubles as in saved states; `m->cubic` is whether
   the contact spring has a cubic term. `w` has the kernel's variables in it: `w->side` is −1 in
   contact and 1 off the belt, `w->t` is a rounded time and `w->remainder` the exact time less it.
   Ramps are inputs that change linearly with time; functions of the kernel with `driven` in their
   names compute steps under ramps. `groups` counts groups of GROUP_SIZE coefficients of a
   polynomial. INFINITE as an argument means no limit. */

#include "stepping.h"

#ifndef VARIANT
#define VARIANT baseline
#endif
/* stepping_baseline or stepping_avx2. */
#define JOIN_NAMES(name, variant) name##_##variant
#define VARIANT_NAME(name, variant) JOIN_NAMES(name, variant)

/* Limit of Taylor steps per communication step. */
#ifndef MAX_STEPS
#define MAX_STEPS 100000000
#endif

/* A slider whose speed differs from the new speed of the belt by less than this, relative to the
   scale of the speeds, moves with the belt: the speed at the end of a ramp has rounding errors. */
#define SPEED_TOLERANCE 0x1p-36

/* The inputs as a course of the kernel: linear functions of time from `input_start` on. P_MU_S < 0
   means that static friction follows μ. */
static Course input_course(const Motion *m)
{
    const double *p = m->inputs.p;
    const Rates *rates = &m->inputs.rates;
    const Ramp friction = {p[P_MU], rates->mu}, held = {p[P_MU_S], 0.0};
    return (Course){{p[P_F], rates->F}, friction, p[P_MU_S] < 0.0 ? friction : held,
                    {p[P_V_BELT], rates->v_belt}, m->input_start};
}

/* Expand the step on a belt that is always faster than the slider. */
INLINE void expand_sliding(Motion *m, int order)
{
    Block *w = &m->w;
    if (has_ramps(m)) {
        const Course course = input_course(m);
        /* Between steps only `w->side` is up to date on such a belt: the mode follows from it. */
        m->belt.mode = motion_mode(m);
        set_course_parameters(&m->belt, w, &course, elapsed_time(&course, w->t, w->remainder));
        expand_driven(&m->belt, w->xs, w->ys, order);
    } else {
        const int in_contact = w->side < 0.0;
        expand_block(w, order, m->cubic != 0.0 && in_contact);
        /* If the forces balance at y = 0, rounding errors must not cause repeated switches. */
        balance_vertical_forces(w);
    }
    set_step_length(w, m->tol, order / GROUP_SIZE);
}

/* Expand the step on a belt of finite speed; returns whether the slider certainly keeps sliding. */
INLINE int expand_on_belt(Motion *m, int order)
{
    if (!has_ramps(m))
        return expand_belt_step(&m->belt, &m->w, m->tol, order, m->cubic != 0.0);
    const Course course = input_course(m);
    set_course_parameters(&m->belt, &m->w, &course, elapsed_time(&course, m->w.t, m->w.remainder));
    expand_driven_step(&m->belt, &m->w, m->tol, order, INFINITE);
    return 0;
}

/* Compute the next step of the motion, without advancing to its end; returns a status. */
NOINLINE int compute_motion_step(Motion *m)
{
    Block *w = &m->w;
    const int order = (int)m->order, groups = order / GROUP_SIZE;
    StepCut cut = NOT_CUT;
    /* Set by `cut_step` if the step ends a stick, else unused. */
    int64_t next_mode = STICK;
    if (m->belt.finite) {
        int stays = expand_on_belt(m, order);
        evaluate_end_y(w, groups);
        cut = cut_step(&m->belt, w, groups, stays, &next_mode);
    } else {
        expand_sliding(m, order);
        evaluate_end_y(w, groups);
        if (may_reach_zero_height(w) && cut_at_zero_height(w, groups))
            cut = CUT_AT_ZERO_HEIGHT;
        evaluate_end_x(w, groups, 1);
    }
    if (!is_finite_step(w))
        return OVERFLOW;
    if (cut == CUT_AT_SPEED || m->belt.mode == STICK)
        w->vx = m->belt.p[P_V_BELT];
    StepEnd step_end = find_step_end(w, INFINITE, cut != NOT_CUT);
    m->has_step = 1.0, m->cut = cut, m->next_mode = (double)next_mode;
    m->end = step_end.t, m->end_remainder = step_end.remainder;
    return RUNNING;
}

/* Count a switch at time t if the mode has changed; `before` is the mode before it. */
static void count_switch(Motion *m, int64_t before, double t)
{
    const int64_t mode = m->belt.mode;
    if (mode == before)
        return;
    m->last_belt_switch = t, m->belt_switches += 1.0;
    m->sticks += mode == STICK, m->slips += before == STICK;
    m->reversals += is_sliding(mode) && is_sliding(before);
}

static double switch_count(const Motion *m)
{
    return m->belt.finite ? m->belt_switches : m->w.separations + m->w.reattachments;
}

/* Advance to the end of a step on a belt of finite speed. */
static StepFlags finish_belt_step(Motion *m, const StepEnd *step_end)
{
    const StepCut cut = (StepCut)m->cut;
    const int64_t next_mode = (int64_t)m->next_mode;
    if (!has_ramps(m))
        return accept_belt_step(&m->belt, &m->w, step_end, cut, next_mode);
    const Course course = input_course(m);
    const double speed = end_speed(&course, step_end);
    /* Only at a row of a table the mode changes without a cut. This course has no table. */
    const int at_row = 0;
    return accept_driven_step(&m->belt, &m->w, step_end, cut, next_mode, speed, &course, at_row);
}

/* Extend the extremes by the step, or by the part of it that ends after `w->h`. */
static void observe_step(const Motion *m, Block *w)
{
    const double limit = m->belt.finite ? speed_limit(&m->belt, w->h) : INFINITE;
    /* The motion has no end here, hence no second half. */
    observe_extremes(w, (int)m->order / GROUP_SIZE, INFINITE, limit);
}

/* Advance to the end of the step; returns a status: STALLED after many steps in a row without
   progress. */
static int finish_motion_step(Motion *m)
{
    Block *w = &m->w;
    const StepEnd step_end = {m->end, m->end_remainder, 0};
    m->has_step = 0.0;
    observe_step(m, w);
    if (m->belt.finite) {
        const int64_t before = m->belt.mode;
        const StepFlags flags = finish_belt_step(m, &step_end);
        count_switch(m, before, m->end);
        return flags.stalled ? STALLED : RUNNING;
    }
    /* `accept_step` compares the preload at the end of the step with the force of the coupling. */
    const double *p = m->inputs.p;
    w->preload = load_of(p) + m->inputs.rates.F * (m->end - m->input_start);
    /* On this belt `cut` is NOT_CUT, 0, or CUT_AT_ZERO_HEIGHT, 1. */
    const int is_cut = (int)m->cut, is_finite = 1;
    return accept_step(w, &step_end, is_cut, is_finite, INFINITE).stalled ? STALLED : RUNNING;
}

static void state_at(const Motion *m, double t, double *state)
{
    const Block *w = &m->w;
    if (m->has_step == 0.0) {
        state[S_X] = w->xs[0], state[S_VX] = w->xs[1];
        state[S_Y] = w->ys[0], state[S_VY] = w->ys[1];
        return;
    }
    const int groups = (int)m->order / GROUP_SIZE;
    const double elapsed = (t - w->t) - w->remainder;
    Tangent x = tangent_at(w->xs, groups, elapsed), y = tangent_at(w->ys, groups, elapsed);
    state[S_X] = x.value, state[S_VX] = x.slope, state[S_Y] = y.value, state[S_VY] = y.slope;
}

static void totals_at(const Motion *m, double t, Totals *totals)
{
    /* A copy of the step that ends at t. */
    Block w = m->w;
    const int groups = (int)m->order / GROUP_SIZE;
    w.h = m->has_step != 0.0 ? (t - w.t) - w.remainder : 0.0;
    evaluate_end_y(&w, groups);
    evaluate_end_x(&w, groups, 1);
    observe_step(m, &w);
    const Extremes *extremes = &w.extremes;
    /* The force falls with y; it is zero off the belt. */
    const double highest = w.separation > 0.0 ? 0.0 : INFINITE;
    const Totals part = {
        .x_peak = maximum(extremes->x_high, -extremes->x_low),
        .y_peak = maximum(extremes->y_high, -extremes->y_low),
        .vx_max = extremes->vx_high,
        /* Adding 0.0 makes −0.0 positive. */
        .P_min = spring_force(m->inputs.p, minimum(extremes->y_high, highest)) + 0.0,
        .P_max = spring_force(m->inputs.p, minimum(extremes->y_low, highest)) + 0.0,
        .separated_time =
            w.separated_time + ((w.side > 0.0 ? w.h : 0.0) + w.separated_remainder),
    };
    *totals = m->past;
    extend_totals(totals, &part);
}

/* The order of the polynomials, as `order_for` in `fivtui.taylor.stepper`. By measurement, order n
   is the cheapest down to the tolerance e^(−n/0.655). The numbers are e^(−8/0.655), e^(−12/0.655)
   and so on. Only a friction law needs order 24. */
static double order_for(double tol, int has_friction_law)
{
    return tol >= 4.961807550971286e-06                        ? 8.0
           : tol >= 1.1052483456688395e-08                     ? 12.0
           : tol >= 2.461953417287567e-11                      ? 16.0
           : tol >= 5.484029587238164e-14 || !has_friction_law ? 20.0
                                                               : 24.0;
}

/* Begin a step at time t from a state, with the inputs of `m`. */
static void start_step(Motion *m, const double *state, double t)
{
    m->cubic = m->inputs.p[P_K_NL] > 0.0;
    begin_problem(&m->w, ONLY_LANE, m->inputs.p, m->separation != 0.0, state);
    m->w.t = m->w.last_switch = t;
    m->w.extremes = (Extremes){.x_low = state[S_X], .x_high = state[S_X], .y_low = state[S_Y],
                               .y_high = state[S_Y], .vx_high = state[S_VX]};
    m->has_step = 0.0;
    m->order = order_for(m->tol, 0);
    if (!m->belt.finite) {
        /* Ramps need the constants of `belt` on every belt. */
        if (has_ramps(m))
            begin_belt(&m->belt, &m->w, ONLY_LANE, m->inputs.p, 0);
        return;
    }
    double p[BELT_PARAMETERS];
    memcpy(p, m->inputs.p, sizeof p);
    p[P_MU_S] = p[P_MU_S] < 0.0 ? p[P_MU] : p[P_MU_S];
    /* Static friction equal to μ during the whole step: friction does not fall with the sliding
       speed, which the kernel is told by v_s = 0. */
    if (p[P_MU_S] == p[P_MU] && m->inputs.rates.mu == 0.0)
        p[P_V_S] = 0.0;
    begin_belt(&m->belt, &m->w, ONLY_LANE, p, 1);
    const int has_friction_law = m->belt.by_speed != 0;
    m->order = order_for(m->tol, has_friction_law);
    if (has_ramps(m)) {
        const Course course = input_course(m);
        begin_driven(&m->belt, &m->w, &course);
    }
}

static void begin_motion(Motion *m, const Inputs *inputs, int separation, int finite_belt,
                         const double *state, double t, double tol)
{
    memset(m, 0, sizeof *m);
    m->separation = separation, m->belt.finite = finite_belt, m->tol = tol;
    m->inputs = *inputs, m->input_start = m->last_belt_switch = t;
    start_step(m, state, t);
    m->past = (Totals){.vx_max = -INFINITE, .P_min = INFINITE, .P_max = -INFINITE};
    totals_at(m, t, &m->past);
}

/* Whether the slider has the new speed of the belt, up to rounding. */
static int moves_with_belt(const Motion *m, double vx, double speed)
{
    /* Static deflection times angular frequency: typical speed of the vibration. */
    const double vibration_speed = m->w.deflection * m->w.frequency;
    const double last_speed = m->inputs.p[P_V_BELT];
    const double scale = maximum(maximum(__builtin_fabs(last_speed), __builtin_fabs(speed)),
                                 vibration_speed);
    return m->belt.mode != SEPARATED && __builtin_fabs(vx - speed) <= SPEED_TOLERANCE * scale;
}

/* Begin the motion anew from the state at t, under other inputs. */
static void change_inputs(Motion *m, double t, const Inputs *inputs)
{
    double state[STATE];
    const Block before = m->w;
    const int64_t mode = m->belt.mode;
    state_at(m, t, state);
    totals_at(m, t, &m->past);
    const double speed = inputs->p[P_V_BELT];
    if (m->belt.finite && moves_with_belt(m, state[S_VX], speed))
        state[S_VX] = speed;
    m->inputs = *inputs, m->input_start = t;
    start_step(m, state, t);
    if (m->w.side != before.side && state[S_Y] != 0.0) {
        /* Inputs do not change y, so only rounding changed its side: the slider is at a switch. */
        state[S_Y] = 0.0;
        start_step(m, state, t);
    }
    Block *w = &m->w;
    w->separations = before.separations + (w->side > before.side);
    w->reattachments = before.reattachments + (w->side < before.side);
    w->last_switch = w->side != before.side ? t : before.last_switch;
    if (m->belt.finite)
        count_switch(m, mode, t);
}

/* Advance to *t under inputs that apply from `from` on. If `switched` is not NULL, stop at the
   first switch, with its time in *t and 1 in *switched. Returns a status; after a failure the
   motion is unchanged. */
static int advance(Motion *m, double from, double *t, int *switched, const Inputs *inputs)
{
    /* Equal slopes give the same functions of time only if they begin at the same time. */
    const int same = memcmp(inputs, &m->inputs, sizeof *inputs) == 0
                     && (!has_ramps(m) || from == m->input_start);
    if (same && m->has_step != 0.0 && *t < m->end)
        return RUNNING;
    const Motion before = *m;
    if (!same)
        change_inputs(m, from, inputs);
    /* Finish the current step, if there is one, and compute the next, until a step reaches beyond
       *t. A switch lies at the end of the finished step. */
    for (int count = 0; m->has_step == 0.0 || m->end <= *t; count++) {
        const double switches = switch_count(m), end = m->end;
        int status = count == MAX_STEPS ? STEP_LIMIT : RUNNING;
        if (status == RUNNING && m->has_step != 0.0)
            status = finish_motion_step(m);
        const double state[] = {m->w.x, m->w.vx, m->w.y, m->w.vy};
        if (status == RUNNING)
            status = compute_motion_step(m);
        if (status != RUNNING) {
            /* Messages need the time, and the greatest number of the state, m or m/s. */
            const double failed_at = m->w.t;
            *m = before;
            m->failed_at = failed_at, m->failed_size = 0.0;
            for (int n = 0; n < STATE; n++)
                m->failed_size = __builtin_fmax(m->failed_size, __builtin_fabs(state[n]));
            return status;
        }
        /* The finished step ended at a switch; the step after it is computed already. */
        if (switched && switch_count(m) != switches) {
            *t = end, *switched = 1;
            break;
        }
    }
    return RUNNING;
}

static int expand_motion(Motion *m, double t, const Inputs *inputs)
{
    change_inputs(m, t, inputs);
    return compute_motion_step(m);
}

const Stepping VARIANT_NAME(stepping, VARIANT) = {begin_motion, advance, expand_motion, state_at,
                                                  totals_at, compute_motion_step};
