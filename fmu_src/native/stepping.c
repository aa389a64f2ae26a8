/* The motion a Taylor step at a time, from the kernel's text, for one instruction set. */

#include "stepping.h"

#ifndef VARIANT
#define VARIANT baseline
#endif
#define JOINED(name, variant) name##_##variant
#define EXPANDED(name, variant) JOINED(name, variant)

/* Taylor steps after which one communication step is given up. */
#ifndef MOST_STEPS
#define MOST_STEPS 100000000
#endif

/* A slider whose speed differs from that of the belt by less than this part of the scale of speeds,
   where the belt's speed is given anew, has that speed: the difference is rounding of the ramps. */
#define SAME_SPEED 0x1p-36

static Course course_of(const Motion *m)
{
    const double mu_s = m->p[P_MU_S];
    const Ramp held = {mu_s, 0.0};
    return (Course){m->force, m->friction, mu_s < 0.0 ? m->friction : held, m->speed, m->since};
}

/* Expand the step, on a belt that is always faster or of finite speed. */
INLINE void expand_free(Motion *m, int order)
{
    Block *w = &m->w;
    if (is_driven(m)) {
        const Course course = course_of(m);
        m->belt.mode = mode_of_motion(m);
        set_course_parameters(&m->belt, w, &course, elapsed_time(&course, w->t, w->remainder));
        expand_driven(&m->belt, w->xs, w->ys, order);
    } else {
        expand_block(w, order, m->cubic != 0.0 && w->side < 0.0);
        balance_at_switch(w);
    }
    set_step_length(w, m->tol, order / 4);
}

/* Returns whether a slider stays in motion over the belt for certain. */
INLINE int expand_on_belt(Motion *m, int order)
{
    if (!is_driven(m))
        return expand_belt_step(&m->belt, &m->w, m->tol, order, m->cubic != 0.0);
    const Course course = course_of(m);
    set_course_parameters(&m->belt, &m->w, &course, elapsed_time(&course, m->w.t, m->w.remainder));
    expand_driven_step(&m->belt, &m->w, m->tol, order, INFINITE);
    return 0;
}

NOINLINE int take_step(Motion *m)
{
    Block *w = &m->w;
    const int order = (int)m->order, groups = order / 4;
    StepCut cut = NOT_CUT;
    int64_t then = STICK;
    if (m->belt.finite) {
        int stays = expand_on_belt(m, order);
        evaluate_end_y(w, groups);
        cut = cut_step(&m->belt, w, groups, stays, &then);
    } else {
        expand_free(m, order);
        evaluate_end_y(w, groups);
        if (may_switch(w) && cut_at_switch(w, groups))
            cut = CUT_AT_SWITCH;
        evaluate_end_x(w, groups, 0);
    }
    if (!is_finite_step(w))
        return OVERFLOW;
    if (cut == CUT_AT_SPEED || m->belt.mode == STICK)
        w->vx = m->belt.p[P_V_BELT];
    StepEnd step_end = find_step_end(w, INFINITE, cut != NOT_CUT);
    m->stepped = 1.0, m->cut = cut, m->then = (double)then;
    m->end = step_end.t, m->end_rest = step_end.remainder;
    return RUNNING;
}

static void count_change(Motion *m, int64_t before, double t)
{
    const int64_t mode = m->belt.mode;
    if (mode == before)
        return;
    m->changed_at = t, m->changes += 1.0;
    m->sticks += mode == STICK, m->slips += before == STICK;
    m->reversals += is_sliding(mode) && is_sliding(before);
}

static double switches_of(const Motion *m)
{
    return m->belt.finite ? m->changes : m->w.separations + m->w.reattachments;
}

static StepFlags go_over_on_belt(Motion *m, const StepEnd *step_end)
{
    const StepCut cut = (StepCut)m->cut;
    const int64_t then = (int64_t)m->then;
    if (!is_driven(m))
        return accept_belt_step(&m->belt, &m->w, step_end, cut, then);
    const Course course = course_of(m);
    const double speed = end_speed(&course, step_end);
    return accept_driven_step(&m->belt, &m->w, step_end, cut, then, speed, &course, 0);
}

/* Go on to the end of the step. */
static int go_over(Motion *m)
{
    Block *w = &m->w;
    const StepEnd step_end = {m->end, m->end_rest, 0};
    m->stepped = 0.0;
    if (m->belt.finite) {
        const int64_t before = m->belt.mode;
        const StepFlags flags = go_over_on_belt(m, &step_end);
        count_change(m, before, m->end);
        return flags.stalled ? STALLED : RUNNING;
    }
    w->preload = m->force.value + m->force.slope * (m->end - m->since);
    return accept_step(w, &step_end, (int)m->cut, 1, INFINITE).stalled ? STALLED : RUNNING;
}

static void state_at(const Motion *m, double t, double *state)
{
    const Block *w = &m->w;
    if (m->stepped == 0.0) {
        state[0] = w->xs[0], state[1] = w->xs[1], state[2] = w->ys[0], state[3] = w->ys[1];
        return;
    }
    const int groups = (int)m->order / 4;
    const double part = (t - w->t) - w->remainder;
    Tangent x = tangent_at(w->xs, groups, part), y = tangent_at(w->ys, groups, part);
    state[0] = x.value, state[1] = x.slope, state[2] = y.value, state[3] = y.slope;
}

/* `order_for` in `fivtui.taylor.stepper`: the least tolerances at which 8, 12, 16 and 20 are enough,
   e^(−n/0.655). */
static double order_for(double tol, int by_law)
{
    return tol >= 4.961807550971286e-06                ? 8.0
           : tol >= 1.1052483456688395e-08             ? 12.0
           : tol >= 2.461953417287567e-11              ? 16.0
           : tol >= 5.484029587238164e-14 || !by_law   ? 20.0
                                                       : 24.0;
}

static void start(Motion *m, const double *state, double t)
{
    begin_problem(&m->w, 0, m->p, m->separation != 0.0, state);
    m->w.t = m->w.last_switch = t;
    m->stepped = 0.0;
    m->order = order_for(m->tol, 0);
    if (!m->belt.finite)
        return;
    double p[BELT_PARAMETERS];
    memcpy(p, m->p, sizeof p);
    p[P_MU_S] = p[P_MU_S] < 0.0 ? p[P_MU] : p[P_MU_S];
    if (p[P_MU_S] == p[P_MU] && m->friction.slope == 0.0)
        p[P_V_S] = 0.0;
    begin_belt(&m->belt, &m->w, 0, p, 1);
    m->order = order_for(m->tol, m->belt.by_speed != 0);
    if (is_driven(m)) {
        const Course course = course_of(m);
        begin_driven(&m->belt, &m->w, &course);
    }
}

static void begin_motion(Motion *m, const double *p, int separation, int finite_belt,
                         const double *state, double t, double tol)
{
    memset(m, 0, sizeof *m);
    memcpy(m->p, p, sizeof(double) * (size_t)(finite_belt ? BELT_PARAMETERS : PARAMETERS));
    if (!finite_belt)
        m->p[P_MU_S] = -1.0;
    m->separation = separation, m->tol = tol, m->cubic = p[P_K_NL] > 0.0;
    m->since = m->changed_at = t;
    m->force = (Ramp){p[P_F], 0.0}, m->friction = (Ramp){p[P_MU], 0.0};
    m->speed = (Ramp){finite_belt ? p[P_V_BELT] : 0.0, 0.0};
    /* On a belt that is always faster: its springs and masses, for inputs that change with time. */
    begin_problem(&m->w, 0, m->p, m->separation != 0.0, state);
    begin_belt(&m->belt, &m->w, 0, m->p, finite_belt);
    start(m, state, t);
}

/* Whether the slider moves with a belt that had the speed of the step, and now has another one. */
static int is_of_speed(const Motion *m, double vx, double speed)
{
    const double scale = maximum(maximum(__builtin_fabs(m->speed.value), __builtin_fabs(speed)),
                                 m->w.deflection * m->w.frequency);
    return m->belt.mode != SEPARATED && __builtin_fabs(vx - speed) <= SAME_SPEED * scale;
}

/* Begin anew under other inputs, from the state at t. */
static void change_inputs(Motion *m, double t, Ramp force, Ramp friction, Ramp speed)
{
    double state[4];
    const Block before = m->w;
    const int64_t mode = m->belt.mode;
    state_at(m, t, state);
    if (m->belt.finite && is_of_speed(m, state[1], speed.value))
        state[1] = speed.value;
    m->p[P_F] = force.value, m->p[P_MU] = friction.value, m->p[P_V_BELT] = speed.value;
    m->force = force, m->friction = friction, m->speed = speed, m->since = t;
    start(m, state, t);
    if (m->w.side != before.side && state[2] != 0.0) {
        /* y is on the wrong side by rounding alone: the slider is at the switch. */
        state[2] = 0.0;
        start(m, state, t);
    }
    Block *w = &m->w;
    w->separations = before.separations + (w->side > before.side);
    w->reattachments = before.reattachments + (w->side < before.side);
    w->last_switch = w->side != before.side ? t : before.last_switch;
    if (m->belt.finite)
        count_change(m, mode, t);
}

static int is_same(Ramp a, Ramp b) { return a.value == b.value && a.slope == b.slope; }

static int are_those(const Motion *m, Ramp force, Ramp friction, Ramp speed)
{
    return is_same(force, m->force) && is_same(friction, m->friction) && is_same(speed, m->speed);
}

static int move(Motion *m, double from, double *t, int *switched, Ramp force, Ramp friction,
                Ramp speed)
{
    if (!m->belt.finite)
        speed = m->speed;
    const int same = are_those(m, force, friction, speed) && (!is_driven(m) || from == m->since);
    if (same && m->stepped != 0.0 && *t < m->end)
        return RUNNING;
    const Motion before = *m;
    if (!same)
        change_inputs(m, from, force, friction, speed);
    for (int count = 0; m->stepped == 0.0 || m->end <= *t; count++) {
        const double switches = switches_of(m), end = m->end;
        int status = count == MOST_STEPS ? STEP_LIMIT : RUNNING;
        if (status == RUNNING && m->stepped != 0.0)
            status = go_over(m);
        const double state[] = {m->w.x, m->w.vx, m->w.y, m->w.vy};
        if (status == RUNNING)
            status = take_step(m);
        if (status != RUNNING) {
            const double failed_at = m->w.t;
            *m = before;
            m->failed_at = failed_at, m->failed_size = 0.0;
            for (int n = 0; n < 4; n++)
                m->failed_size = __builtin_fmax(m->failed_size, __builtin_fabs(state[n]));
            return status;
        }
        if (switched && switches_of(m) != switches) {
            *t = end, *switched = 1;
            break;
        }
    }
    return RUNNING;
}

const Stepping EXPANDED(stepping, VARIANT) = {begin_motion, move, state_at, take_step};
