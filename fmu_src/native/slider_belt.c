/* The slider-belt model: its motion in co-simulation, its equations in model exchange. */

#include <float.h>
#include <string.h>

#include "build.h"
#include "instance.h"
#include "stepping.h"
#include "rest.h"
#include "slider_belt_table.h"

/* An importer stops within this part of the extent of the motion of a switch, on either side. */
#define AT_SWITCH 1e-8
/* One of a low tolerance has gone past v_r = 0 by no more than this part of the speeds. */
#define GONE_PAST 1e-2
/* `_SMALL` in `fivtui.taylor.stepper`. */
#define SMALL 1e30
/* `local_tolerance` in `fivtui.taylor.stepper`. */
#define LOCAL_TOLERANCE 3e-3
/* A lesser speed is zero: `_LEAST` in `fivtui.model.parameters`. */
#define LEAST_SPEED 1e-12

enum { X, Y, VX, VY, STATES };
static const uint32_t STATE_REFERENCES[STATES] = {V_x, V_y, V_vx, V_vy};
static const uint32_t DERIVATIVE_REFERENCES[STATES] = {V_vx, V_vy, V_ax, V_ay};

/* y, v_r, and the margins of the hold. */
enum { AT_HEIGHT, AT_SLIDING, HELD_FORWARD, HELD_BACKWARD, INDICATORS };

/* In an instance's room for a motion: `mode` is as in `fivtui.model.modes`; the slider sticks at the
   start, or does not (`first_sticks`). `speed` is that of the belt at the last look for a mode in
   model exchange, `acceleration` the belt's in the outputs. */
typedef struct {
    double mode, separations, reattachments, switches, sticks, last_event;
    double first_sticks, speed, acceleration;
    Motion motion;
} Content;

_Static_assert(sizeof(Content) <= sizeof(double) * MOTION_ROOM, "there is no room for the motion");
_Static_assert(VARIABLE_COUNT <= (int)MOST_VARIABLES, "there is no room for the values");
_Static_assert(INDICATORS <= (int)MOST_INDICATORS, "there is no room for the event indicators");

static Content *content_of(Instance *i) { return (Content *)i->s.motion; }
static const Content *content_in(const Instance *i) { return (const Content *)i->s.motion; }

static const Stepping *stepping_of(Instance *i)
{
    i->stepping = i->stepping ? i->stepping : stepping();
    return i->stepping;
}

static int is_finite_belt(const State *s) { return s->values[V_finite_belt] != 0.0; }

static double speed_of(const State *s, int variable)
{
    const double speed = s->values[variable];
    return speed < LEAST_SPEED ? 0.0 : speed;
}

/* BELT_PARAMETERS columns, as `Stepping` takes them. */
static void parameters_of(const State *s, double *p)
{
    for (int n = 0; n < PARAMETERS; n++)
        p[n] = s->values[PARAMETER_REFERENCES[n]];
    const double mu_s = s->values[V_mu_s];
    p[P_V_BELT] = speed_of(s, V_v_belt);
    p[P_MU_S] = mu_s > 0.0 ? mu_s : -1.0, p[P_V_S] = mu_s > 0.0 ? speed_of(s, V_v_s) : 0.0;
}

/* How they change with the variables. */
static void changes_of(const double *d, double *q)
{
    for (int n = 0; n < PARAMETERS; n++)
        q[n] = d[PARAMETER_REFERENCES[n]];
    q[P_V_BELT] = d[V_v_belt], q[P_MU_S] = d[V_mu_s], q[P_V_S] = d[V_v_s];
}

static double static_friction(const State *s)
{
    return s->values[V_mu_s] > 0.0 ? s->values[V_mu_s] : s->values[V_mu];
}

/* Why a value of an input that is in its range is not possible beside the other values. */
static const char *fits(Instance *i, uint32_t reference, double value)
{
    const State *s = &i->s;
    const double mu_s = s->values[V_mu_s];
    if (!is_finite_belt(s))
        return NULL;
    if (reference == V_mu && mu_s > 0.0 && value > mu_s)
        return because(i, "mu = %g: must be at most mu_s = %g", value, mu_s);
    if (reference == V_v_belt && s->phase == CONTINUOUS && content_in(i)->mode == STICK
        && value != s->values[V_v_belt])
        return because(i, "v_belt = %g: while the slider sticks it must stay %g but in event mode",
                       value, s->values[V_v_belt]);
    return NULL;
}

/* Which values of the belt are given and have no effect. */
static const char *remark(Instance *i)
{
    static const uint32_t REFERENCES[] = {V_v_belt, V_mu_s, V_v_s};
    const State *s = &i->s;
    char names[TEXT] = "";
    int count = 0;
    if (is_finite_belt(s))
        return s->values[V_v_s] > 0.0 && s->values[V_mu_s] == 0.0
                   ? because(i, "v_s has no effect without mu_s")
                   : NULL;
    for (size_t n = 0; n < sizeof REFERENCES / sizeof *REFERENCES; n++) {
        const Variable *v = &COMPONENT.variables[REFERENCES[n]];
        if (s->values[REFERENCES[n]] == v->start)
            continue;
        strcat(strcat(names, count++ ? ", " : ""), v->name);
    }
    return count ? because(i, "%s %s no effect without finite_belt", names,
                           count == 1 ? "has" : "have")
                 : NULL;
}

static const char *begin_motion(Instance *i)
{
    State *s = &i->s;
    Content *at = content_of(i);
    const double *v = s->values;
    const int separation = v[V_separation] != 0.0;
    const char *why = fits(i, V_mu, v[V_mu]);
    double p[BELT_PARAMETERS], state[4] = {v[V_x_start], v[V_vx_start], v[V_y_start], v[V_vy_start]};
    if (why)
        return why;
    parameters_of(s, p);
    if (v[V_start_static] != 0.0)
        resting_state(p, separation, state);
    if (!is_finite_number(state[2]))
        return because(i, "no equilibrium: F = %g N lifts the slider and no spring holds it "
                          "vertically; use F >= 0, a larger k3, or ignore separation", p[P_F]);
    stepping_of(i)->begin(&at->motion, p, separation, is_finite_belt(s), state, s->start_time,
                          s->tolerance * LOCAL_TOLERANCE);
    at->mode = mode_of_motion(&at->motion), at->last_event = s->start_time;
    at->separations = at->reattachments = at->switches = 0.0;
    at->sticks = at->first_sticks = at->mode == STICK;
    at->speed = p[P_V_BELT], at->acceleration = 0.0;
    s->states[X] = state[0], s->states[VX] = state[1];
    s->states[Y] = state[2], s->states[VY] = state[3];
    return NULL;
}

/* Whether friction falls with the sliding speed. */
static int follows_law(const State *s)
{
    const double *v = s->values;
    return is_finite_belt(s) && speed_of(s, V_v_s) > 0.0 && v[V_mu_s] > v[V_mu];
}

/* As `overflow_error` in `fivtui.taylor.stepper`. */
static const char *overflow(Instance *i, double t, double size)
{
    const State *s = &i->s;
    const double *v = s->values;
    const Remedy for_small[] = {
        {"a larger v_s", follows_law(s)},
        {"a softer contact", 1},
        {"less damping", v[V_c1] > 0.0 || v[V_c2] > 0.0},
        {"a greater mass", 1},
    };
    const Remedy for_large[] = {
        {"separation", v[V_separation] == 0.0},
        {"a cubic contact (k_nl above 0)", v[V_k_nl] == 0.0},
        {"a shorter run", 1},
    };
    if (size < SMALL) {
        because(i, "the motion changes faster than floating-point numbers resolve at t = %g s", t);
        return advise(i, for_small, sizeof for_small / sizeof *for_small);
    }
    because(i, "the motion grows beyond the floating-point range at t = %g s", t);
    return advise(i, for_large, sizeof for_large / sizeof *for_large);
}

/* As `stall_error` in `fivtui.taylor.stepper`. */
static const char *stall(Instance *i, double t)
{
    const Remedy remedies[] = {
        {"a less stiff contact", 1},
        {"more damping", 1},
        {"a larger v_s", follows_law(&i->s)},
    };
    because(i, "at t = %.17g s the motion changes faster than floating-point time resolves", t);
    return advise(i, remedies, sizeof remedies / sizeof *remedies);
}

static const char *move_on(Instance *i, double from, double *t, int *switched)
{
    const State *s = &i->s;
    Motion *m = &content_of(i)->motion;
    const Ramp force = {s->values[V_F], s->slopes[V_F]}, mu = {s->values[V_mu], s->slopes[V_mu]};
    const Ramp speed = {speed_of(s, V_v_belt), s->slopes[V_v_belt]};
    switch (stepping_of(i)->move(m, from, t, switched, force, mu, speed)) {
    case OVERFLOW:
        return overflow(i, m->failed_at, m->failed_size);
    case STALLED:
        return stall(i, m->failed_at);
    case STEP_LIMIT:
        return needs_too_much(i, m->failed_at);
    default:
        return NULL;
    }
}

static double known_until(const Instance *i)
{
    const Motion *m = &content_in(i)->motion;
    /* After a ramp the inputs are held: another motion. */
    return is_driven(m) ? -INFINITE : m->end;
}

static double part_end(Instance *i)
{
    double t = i->s.t;
    Motion *m = &content_of(i)->motion;
    const Motion before = *m;
    /* What goes wrong is told by the step. */
    const double end = move_on(i, t, &t, NULL) ? INFINITE : m->end;
    /* A belt that holds may not hold if it is held at its speed: such a mode is not to be counted. */
    if (i->updates_inputs && is_finite_belt(&i->s))
        *m = before;
    return end;
}

/* The state at the time reached; its mode and the switches so far, unless one is still pending. */
static void look(Instance *i)
{
    State *s = &i->s;
    Content *at = content_of(i);
    const Motion *m = &at->motion;
    const Block *w = &m->w;
    double state[4];
    stepping_of(i)->state(m, s->t, state);
    s->states[X] = state[0], s->states[VX] = state[1];
    s->states[Y] = state[2], s->states[VY] = state[3];
    if (s->is_pending)
        return;
    at->mode = mode_of_motion(m), at->last_event = is_finite_belt(s) ? m->changed_at : w->last_switch;
    at->separations = w->separations, at->reattachments = w->reattachments;
    at->switches = is_finite_belt(s) ? m->changes : w->separations + w->reattachments;
    at->sticks = m->sticks + at->first_sticks;
}

/* On a belt of finite speed, the mode under the present inputs, and the belt's acceleration: the
   step's where they are as it left them, else those with which the next one begins. */
static void look_at_belt(Instance *i)
{
    const State *s = &i->s;
    Content *at = content_of(i);
    const Motion *m = &at->motion;
    at->acceleration = s->are_left ? m->speed.slope : s->slopes[V_v_belt];
    if (s->are_left || s->is_pending)
        return;
    const Motion before = *m;
    double t = s->t;
    /* What goes wrong is told by the step. */
    if (!move_on(i, t, &t, NULL))
        at->mode = mode_of_motion(m);
    at->motion = before;
}

/* The speed by which the slider slides in a mode; not less than zero by rounding. */
static double sliding_speed(const State *s, double mode)
{
    const double ahead = speed_of(s, V_v_belt) - s->states[VX];
    return maximum(mode == BACKWARD ? -ahead : ahead, 0.0);
}

/* The friction force on the slider, given that of the contact. */
static double friction_on_slider(const Instance *i, const double *p, double force)
{
    const Content *at = content_in(i);
    const double mode = at->mode;
    if (mode == STICK)
        return holding_force(p, i->s.states[X], i->s.states[Y], at->acceleration);
    if (mode != FORWARD && mode != BACKWARD)
        return i->s.values[V_mu] * force;
    const double friction = friction_coefficient(p, sliding_speed(&i->s, mode)) * force;
    return mode == BACKWARD ? -friction : friction;
}

static void publish(Instance *i)
{
    if (i->type == fmi2CoSimulation) {
        look(i);
        if (is_finite_belt(&i->s))
            look_at_belt(i);
    }
    const Content *at = content_in(i);
    const double *states = i->s.states;
    double *v = i->s.values, x = states[X], y = states[Y], vx = states[VX], vy = states[VY];
    double p[BELT_PARAMETERS];
    parameters_of(&i->s, p);
    const double force = at->mode != SEPARATED ? spring_force(p, y) + 0.0 : 0.0;
    const double friction = friction_on_slider(i, p, force);
    v[V_x] = x, v[V_vx] = vx, v[V_y] = v[V_switching] = y, v[V_vy] = vy;
    v[V_P] = force;
    v[V_friction_slider] = friction, v[V_friction_belt] = -friction;
    v[V_ax] = horizontal_acceleration(p, x, vx, y, friction);
    if (at->mode == STICK)
        v[V_ax] = at->acceleration;
    v[V_ay] = vertical_acceleration(p, x, y, vy, force - load_of(p));
    v[V_mode] = v[V_mode_integer] = v[V_mode_enumeration] = at->mode;
    v[V_separations] = at->separations, v[V_reattachments] = at->reattachments;
    v[V_switches] = at->switches, v[V_sticks] = at->sticks;
    v[V_last_event] = at->last_event;
}

/* A value, or where that is zero one on a side. */
static double on_side(double value, double side) { return value != 0.0 ? value : side * DBL_MIN; }

/* Each is y, v_r or a margin of the hold where its zero ends the mode, else a constant; where it is
   zero it is on the side of the mode. */
static void indicate(const Instance *i, double *indicators)
{
    const State *s = &i->s;
    const Content *at = content_in(i);
    const double mode = at->mode, y = s->states[Y];
    for (int n = 0; n < INDICATORS; n++)
        indicators[n] = 1.0;
    indicators[AT_HEIGHT] = on_side(y, mode == SEPARATED ? 1.0 : -1.0);
    if (mode == FORWARD || mode == BACKWARD) {
        const double side = mode == FORWARD ? 1.0 : -1.0;
        indicators[AT_SLIDING] = on_side(speed_of(s, V_v_belt) - s->states[VX], side);
    } else if (mode == STICK) {
        double p[BELT_PARAMETERS];
        parameters_of(s, p);
        const double grip = static_friction(s) * spring_force(p, y);
        const double held = holding_force(p, s->states[X], y, at->acceleration);
        indicators[HELD_FORWARD] = on_side(grip - held, 1.0);
        indicators[HELD_BACKWARD] = on_side(grip + held, 1.0);
    }
}

static double largest(double a, double b) { return a > b ? a : b; }

/* The mode on a belt of finite speed at a state that is not at y = 0, or has been put there; v_r is
   made zero where its sign is rounding, or the importer has gone past its zero. */
static double mode_at(const Instance *i, Block *w, double *p, double *state, double reach)
{
    const Content *at = content_in(i);
    const double vx = state[1], speed = p[P_V_BELT], ahead = speed - vx;
    const int past = (at->mode == FORWARD && ahead < 0.0) || (at->mode == BACKWARD && ahead > 0.0);
    const double near = past && speed == at->speed ? GONE_PAST : AT_SWITCH;
    Belt belt;
    if (vabs(ahead) <= near * largest(reach, speed))
        state[1] = speed;
    p[P_MU_S] = p[P_MU_S] < 0.0 ? p[P_MU] : p[P_MU_S];
    begin_problem(w, 0, p, i->s.values[V_separation] != 0.0, state);
    begin_belt(&belt, w, 0, p, 1);
    if (belt.mode == SEPARATED) {
        state[1] = vx;
        return SEPARATED;
    }
    belt.hold_tolerance = AT_SWITCH;
    return (double)mode_on_belt(&belt, state[0], state[1], state[2], state[3]);
}

static int settle(Instance *i)
{
    State *s = &i->s;
    Content *at = content_of(i);
    double p[BELT_PARAMETERS];
    double state[4] = {s->states[X], s->states[VX], s->states[Y], s->states[VY]};
    Block w;
    parameters_of(s, p);
    begin_problem(&w, 0, p, s->values[V_separation] != 0.0, state);
    const double speed = largest(vabs(state[1]), vabs(state[3])) / w.frequency;
    const double place = largest(vabs(state[0]), vabs(state[2]));
    const double reach = largest(w.deflection, largest(place, speed));
    if (vabs(state[2]) <= AT_SWITCH * reach) {
        /* The sign of y is rounding; the direction of the motion decides. */
        state[2] = 0.0;
        begin_problem(&w, 0, p, s->values[V_separation] != 0.0, state);
    }
    double mode = w.side > 0.0 ? SEPARATED : CONTACT;
    if (is_finite_belt(s)) {
        mode = mode_at(i, &w, p, state, reach * w.frequency);
        at->speed = p[P_V_BELT];
    }
    if (mode == at->mode)
        return 0;
    at->separations += mode == SEPARATED, at->reattachments += at->mode == SEPARATED;
    at->switches += 1.0, at->sticks += mode == STICK;
    at->mode = mode, at->last_event = s->t, s->states[VX] = state[1], s->states[Y] = state[2];
    return 1;
}

/* The change of the friction force on the slider, given those of the values and of the force. */
static double change_of_friction(const Instance *i, const double *p, const double *q,
                                 const double *d, double force)
{
    const State *s = &i->s;
    const double *v = s->values, mode = content_in(i)->mode;
    if (mode == STICK)
        return holding_force_change(p, q, v[V_x], d[V_x], v[V_y], d[V_y],
                                    content_in(i)->acceleration, 0.0);
    if (mode != FORWARD && mode != BACKWARD)
        return v[V_mu] * force + d[V_mu] * v[V_P];
    const double sign = mode == FORWARD ? 1.0 : -1.0, speed = sliding_speed(s, mode);
    const double mu = friction_coefficient(p, speed);
    const double faster = sign * (d[V_v_belt] - d[V_vx]);
    double change = friction_coefficient_change(p, q, speed, faster);
    if (v[V_v_s] > 0.0 && v[V_mu_s] == 0.0 && d[V_mu_s] != 0.0) {
        /* 0 stands for μ: friction jumps there. */
        change = __builtin_nan("");
    }
    return sign * (mu * force + change * v[V_P]);
}

static void differentiate(const Instance *i, double *d)
{
    const double *v = i->s.values, y = v[V_y], mode = content_in(i)->mode;
    double p[BELT_PARAMETERS], q[BELT_PARAMETERS];
    parameters_of(&i->s, p), changes_of(d, q);
    const double force = mode != SEPARATED ? spring_force_change(p, q, y, d[V_y]) : 0.0;
    const double friction = change_of_friction(i, p, q, d, force);
    d[V_P] = force, d[V_switching] = d[V_y];
    d[V_friction_slider] = friction, d[V_friction_belt] = -friction;
    d[V_ax] = mode == STICK ? 0.0
                            : horizontal_acceleration_change(p, q, v[V_x], d[V_x], v[V_vx], d[V_vx],
                                                             y, d[V_y], v[V_friction_slider],
                                                             friction);
    d[V_ay] = vertical_acceleration_change(p, q, v[V_x], d[V_x], y, d[V_y], v[V_vy], d[V_vy],
                                           v[V_P] - load_of(p), force - load_of_change(p, q));
}

/* As `static_start_change` in `fivtui.model.slider_belt`. */
static void differentiate_start(const Instance *i, double *d)
{
    const double *v = i->s.values;
    d[V_x] = d[V_x_start], d[V_vx] = d[V_vx_start];
    d[V_y] = d[V_y_start], d[V_vy] = d[V_vy_start];
    if (v[V_start_static] == 0.0)
        return;
    double p[BELT_PARAMETERS], q[BELT_PARAMETERS];
    parameters_of(&i->s, p), changes_of(d, q);
    const double y = v[V_y], push = load_of_change(p, q);
    if (v[V_separation] != 0.0 && load_of(p) < 0.0)
        d[V_y] = -(push + suspension_stiffness_change(p, q) * y) / suspension_stiffness(p);
    else
        d[V_y] = -(push + (rest_cubic_change(p, q, 0.0, 0.0) * y * y + rest_linear_change(p, q, 0.0, 0.0)) * y)
                 / (3.0 * rest_cubic(p, 0.0) * y * y + rest_linear(p, 0.0));
    d[V_x] = rest_position_change(p, q, y, d[V_y], 0.0, 0.0);
    d[V_vx] = d[V_vy] = 0.0;
}

enum {
    N_MODE, N_SEPARATIONS, N_REATTACHMENTS, N_SWITCHES, N_ALL_STICKS, N_LAST_EVENT,
    N_FIRST_STICKS, N_SPEED_THEN,
    N_T, N_REST, N_STEP_SIDE, N_STALLED, N_LIFTS, N_LANDINGS, N_LAST, N_X, N_VX, N_Y, N_VY,
    N_STEP_MODE, N_STICKS, N_SLIPS, N_REVERSALS, N_CHANGES, N_CHANGED_AT,
    N_STEPPED, N_SINCE, N_F, N_F_SLOPE, N_MU, N_MU_SLOPE, N_SPEED, N_SPEED_SLOPE, NUMBERS
};
_Static_assert(NUMBERS <= MOTION_NUMBERS, "there is no room for the numbers");

static void pack(const Instance *i, double *n)
{
    const Content *at = content_in(i);
    const Motion *m = &at->motion;
    const Block *w = &m->w;
    n[N_MODE] = at->mode, n[N_SEPARATIONS] = at->separations;
    n[N_REATTACHMENTS] = at->reattachments, n[N_LAST_EVENT] = at->last_event;
    n[N_SWITCHES] = at->switches, n[N_ALL_STICKS] = at->sticks;
    n[N_FIRST_STICKS] = at->first_sticks, n[N_SPEED_THEN] = at->speed;
    n[N_T] = w->t, n[N_REST] = w->remainder, n[N_STEP_SIDE] = w->side, n[N_STALLED] = w->stalled;
    n[N_LIFTS] = w->separations, n[N_LANDINGS] = w->reattachments, n[N_LAST] = w->last_switch;
    n[N_X] = w->xs[0], n[N_VX] = w->xs[1], n[N_Y] = w->ys[0], n[N_VY] = w->ys[1];
    n[N_STEP_MODE] = mode_of_motion(m), n[N_STICKS] = m->sticks, n[N_SLIPS] = m->slips;
    n[N_REVERSALS] = m->reversals, n[N_CHANGES] = m->changes, n[N_CHANGED_AT] = m->changed_at;
    n[N_STEPPED] = m->stepped, n[N_SINCE] = m->since;
    n[N_F] = m->force.value, n[N_F_SLOPE] = m->force.slope;
    n[N_MU] = m->friction.value, n[N_MU_SLOPE] = m->friction.slope;
    n[N_SPEED] = m->speed.value, n[N_SPEED_SLOPE] = m->speed.slope;
}

static int is_mode(double mode, const State *s)
{
    if (mode == SEPARATED)
        return s->values[V_separation] != 0.0;
    return is_finite_belt(s) ? mode == FORWARD || mode == BACKWARD || mode == STICK
                             : mode == CONTACT;
}

/* Whether the speed at the start of the step is that of its mode, but for rounding. */
static int has_speed_of_mode(const double *n)
{
    const double mode = n[N_STEP_MODE];
    const double v = n[N_SPEED] + n[N_SPEED_SLOPE] * ((n[N_T] - n[N_SINCE]) + n[N_REST]);
    const double ahead = v - n[N_VX], slack = 0x1p-40 * (vabs(v) + vabs(n[N_VX]));
    return !(mode == FORWARD && ahead < -slack) && !(mode == BACKWARD && ahead > slack)
           && !(mode == STICK && vabs(ahead) > slack);
}

/* Whether what a time lacks of the exact one is rounding. */
static int is_rounding(double rest, double t)
{
    return vabs(rest) <= 0x1p-50 * (vabs(t) + 1.0);
}

static int unpack(Instance *i, const double *n)
{
    State *s = &i->s;
    Content *at = content_of(i);
    Motion *m = &at->motion;
    Block *w = &m->w;
    const Stepping *stepping = stepping_of(i);
    const int separation = s->values[V_separation] != 0.0;
    const double state[4] = {n[N_X], n[N_VX], n[N_Y], n[N_VY]};
    double p[BELT_PARAMETERS];
    parameters_of(s, p);
    p[P_F] = n[N_F], p[P_MU] = n[N_MU], p[P_V_BELT] = n[N_SPEED];
    at->mode = n[N_MODE], at->separations = n[N_SEPARATIONS];
    at->reattachments = n[N_REATTACHMENTS], at->last_event = n[N_LAST_EVENT];
    at->switches = n[N_SWITCHES], at->sticks = n[N_ALL_STICKS];
    at->first_sticks = n[N_FIRST_STICKS], at->speed = n[N_SPEED_THEN], at->acceleration = 0.0;
    if (!is_mode(n[N_MODE], s) || !is_mode(n[N_STEP_MODE], s)
        || !is_rounding(n[N_REST], n[N_T])
        || (i->type == fmi2CoSimulation && !has_speed_of_mode(n))
        || n[N_STEP_SIDE] != (n[N_STEP_MODE] == SEPARATED ? 1.0 : -1.0))
        return 0;
    stepping->begin(m, p, separation, is_finite_belt(s), state, n[N_T],
                    s->tolerance * LOCAL_TOLERANCE);
    w->remainder = n[N_REST], w->side = n[N_STEP_SIDE], w->stalled = n[N_STALLED];
    w->separations = n[N_LIFTS], w->reattachments = n[N_LANDINGS], w->last_switch = n[N_LAST];
    set_field(w);
    m->belt.mode = (int64_t)n[N_STEP_MODE], m->sticks = n[N_STICKS], m->slips = n[N_SLIPS];
    m->reversals = n[N_REVERSALS], m->changes = n[N_CHANGES], m->changed_at = n[N_CHANGED_AT];
    m->since = n[N_SINCE], m->force.slope = n[N_F_SLOPE], m->friction.slope = n[N_MU_SLOPE];
    m->speed.slope = n[N_SPEED_SLOPE];
    if (i->type == fmi2ModelExchange || n[N_STEPPED] == 0.0)
        return i->type == fmi2ModelExchange || s->t == w->t;
    return stepping->again(m) == RUNNING && s->t >= w->t && s->t < m->end;
}

const Component COMPONENT = {
    .guid = SLIDER_BELT_GUID,
    .variables = TABLE,
    .variable_count = VARIABLE_COUNT,
    .states = STATE_REFERENCES,
    .derivatives = DERIVATIVE_REFERENCES,
    .state_count = STATES,
    .indicator_count = INDICATORS,
    .begin = begin_motion,
    .remark = remark,
    .fits = fits,
    .move = move_on,
    .known_until = known_until,
    .part_end = part_end,
    .publish = publish,
    .indicate = indicate,
    .settle = settle,
    .differentiate = differentiate,
    .differentiate_start = differentiate_start,
    .pack = pack,
    .unpack = unpack,
};
