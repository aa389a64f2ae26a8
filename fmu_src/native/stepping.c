/* The motion a Taylor step at a time, from the kernel's text, for one instruction set. */

#include "stepping.h"
#include "search.h"

#ifndef VARIANT
#define VARIANT baseline
#endif
#define JOINED(name, variant) name##_##variant
#define EXPANDED(name, variant) JOINED(name, variant)

/* Taylor steps after which one communication step is given up. */
#ifndef MOST_STEPS
#define MOST_STEPS 100000000
#endif

/* As `expand`, for inputs that change with time: plain recurrences of Eqs. 2 and 5. */
static void expand_driven(Motion *m, int order)
{
    Block *w = &m->w;
    const double *p = m->p, h = 0.5 * p[P_K3], late = (w->t - m->since) + w->rest;
    const double force[2] = {m->force.value + m->force.slope * late, m->force.slope};
    const double mu[2] = {m->friction.value + m->friction.slope * late, m->friction.slope};
    double *x = w->xs, *y = w->ys, square[ROWS], contact[ROWS + 1] = {0.0};
    for (int n = 0; n < order; n++) {
        double sum = 0.0, cube = 0.0;
        for (int i = 0; i <= n; i++)
            sum += y[i] * y[n - i];
        square[n] = sum;
        for (int i = 0; i <= n; i++)
            cube += y[i] * square[n - i];
        contact[n] = w->side < 0.0 ? -p[P_K2] * y[n] - p[P_KNL] * cube : 0.0;
        double pull = h * (x[n] - y[n]), factor = p[P_M] * (n + 1.0) * (n + 2.0);
        double friction = mu[0] * contact[n] + (n > 0 ? mu[1] * contact[n - 1] : 0.0);
        double load = n < 2 ? force[n] : 0.0;
        x[n + 2] = (friction - p[P_C1] * (n + 1.0) * x[n + 1] - p[P_K1] * x[n] - pull) / factor;
        y[n + 2] = (contact[n] - load - p[P_C2] * (n + 1.0) * y[n + 1] + pull) / factor;
    }
}

static int is_driven(const Motion *m) { return m->force.slope != 0.0 || m->friction.slope != 0.0; }

APART int take_step(Motion *m)
{
    Block *w = &m->w;
    const int order = (int)m->order, groups = order / 4;
    if (is_driven(m)) {
        expand_driven(m, order);
    } else {
        if (m->cubic != 0.0 && w->side < 0.0)
            expand(w->xs, w->ys, &w->field, order, 1);
        else
            expand(w->xs, w->ys, &w->field, order, 0);
        settle_at_switch(w);
    }
    set_length(w, m->tol, groups);
    end_step_y(w, groups);
    int cut = 0;
    if (may_switch(w)
        && first_switch(w->ys, groups, w->side, &w->h, w->y, w->vy, w->y_off, 1)) {
        cut = 1;
        end_step_y(w, groups);
        w->y = 0.0;
    }
    end_step_x(w, groups, 0);
    if (!is_sound(w))
        return OVERFLOW;
    Ending ending = ending_of(w, INFINITE, cut);
    m->stepped = 1.0, m->cut = cut, m->end = ending.t, m->end_rest = ending.rest;
    return RUNNING;
}

/* Go on to the end of the step. */
static int go_over(Motion *m)
{
    Block *w = &m->w;
    const Ending ending = {m->end, m->end_rest, 0};
    w->preload = m->force.value + m->force.slope * (m->end - m->since);
    m->stepped = 0.0;
    return go_on(w, &ending, (int)m->cut, 1, INFINITE).stalled ? STALLED : RUNNING;
}

static void state_at(const Motion *m, double t, double *state)
{
    const Block *w = &m->w;
    if (m->stepped == 0.0) {
        state[0] = w->xs[0], state[1] = w->xs[1], state[2] = w->ys[0], state[3] = w->ys[1];
        return;
    }
    const int groups = (int)m->order / 4;
    const double part = (t - w->t) - w->rest;
    Tangent x = tangent_at(w->xs, groups, part), y = tangent_at(w->ys, groups, part);
    state[0] = x.value, state[1] = x.slope, state[2] = y.value, state[3] = y.slope;
}

static void start(Motion *m, const double *state, double t)
{
    begin(&m->w, 0, m->p, m->separation != 0.0, state);
    m->w.t = m->w.last = t;
    m->stepped = 0.0;
}

static void begin_motion(Motion *m, const double *p, int separation, const double *state, double t,
                         double tol)
{
    memset(m, 0, sizeof *m);
    memcpy(m->p, p, sizeof m->p);
    m->separation = separation, m->tol = tol, m->cubic = p[P_KNL] > 0.0;
    /* `order_for` in `fivtui.taylor.stepper`: e^(−40/3), e^(−20), e^(−80/3). */
    m->order = tol >= 1.6195967923126097e-06 ? 8.0
               : tol >= 2.061153622438558e-09 ? 12.0
               : tol >= 2.6230937696692948e-12 ? 16.0
                                               : 20.0;
    m->since = t;
    m->force = (Ramp){p[P_F], 0.0}, m->friction = (Ramp){p[P_MU], 0.0};
    start(m, state, t);
}

/* Begin anew under other inputs, from the state at t. */
static void change_inputs(Motion *m, double t, Ramp force, Ramp friction)
{
    double state[4];
    const Block before = m->w;
    state_at(m, t, state);
    m->p[P_F] = force.value, m->p[P_MU] = friction.value;
    m->force = force, m->friction = friction, m->since = t;
    start(m, state, t);
    if (m->w.side != before.side && state[2] != 0.0) {
        /* y is on the wrong side by rounding alone: the slider is at the switch. */
        state[2] = 0.0;
        start(m, state, t);
    }
    Block *w = &m->w;
    w->lifts = before.lifts + (w->side > before.side);
    w->landings = before.landings + (w->side < before.side);
    w->last = w->side != before.side ? t : before.last;
}

static int is_same(Ramp a, Ramp b) { return a.value == b.value && a.slope == b.slope; }

static int move(Motion *m, double from, double *t, int *switched, Ramp force, Ramp friction)
{
    if (is_same(force, m->force) && is_same(friction, m->friction) && m->stepped != 0.0
        && *t < m->end && (!is_driven(m) || from == m->since))
        return RUNNING;
    const Motion before = *m;
    if (!is_same(force, m->force) || !is_same(friction, m->friction)
        || (is_driven(m) && from != m->since))
        change_inputs(m, from, force, friction);
    for (int count = 0; m->stepped == 0.0 || m->end <= *t; count++) {
        const double switches = m->w.lifts + m->w.landings, end = m->end;
        int status = count == MOST_STEPS ? STEP_LIMIT : RUNNING;
        if (status == RUNNING && m->stepped != 0.0)
            status = go_over(m);
        if (status == RUNNING)
            status = take_step(m);
        if (status != RUNNING) {
            const double failed_at = m->w.t;
            *m = before;
            m->failed_at = failed_at;
            return status;
        }
        if (switched && m->w.lifts + m->w.landings != switches) {
            *t = end, *switched = 1;
            break;
        }
    }
    return RUNNING;
}

const Stepping EXPANDED(stepping, VARIANT) = {begin_motion, move, state_at, take_step};
