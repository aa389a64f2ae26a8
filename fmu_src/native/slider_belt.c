/* The slider-belt model: its motion in co-simulation, its equations in model exchange. */

#include <float.h>
#include <string.h>

#include "build.h"
#include "instance.h"
#include "stepping.h"
#include "rest.h"
#include "slider_belt_table.h"

/* Relative distance to a switch, on either side, at which an importer stops. */
#define SWITCH_TOLERANCE 1e-8
/* Relative distance by which an importer of low accuracy may overshoot v_r = 0. */
#define OVERSHOOT_TOLERANCE 1e-2
/* A motion that fails at a smaller size is too fast, not too large: `_SMALL` in
   `fivtui.taylor.stepper`. */
#define OVERFLOW_SIZE 1e30
/* `local_tolerance` in `fivtui.taylor.stepper`. */
#define LOCAL_TOLERANCE 3e-3
/* Smaller speeds count as zero: `_LEAST` in `fivtui.model.parameters`. */
#define LEAST_SPEED 1e-12

enum { X, Y, VX, VY, STATES };
static const uint32_t STATE_REFERENCES[STATES] = {V_x, V_y, V_vx, V_vy};
static const uint32_t DERIVATIVE_REFERENCES[STATES] = {V_vx, V_vy, V_ax, V_ay};

/* Event indicators: y, v_r, and the margins of stick. */
enum { HEIGHT, SLIDING_SPEED, FORWARD_MARGIN, BACKWARD_MARGIN, INDICATORS };

/* The motion in the state of an instance. `mode` is as in `fivtui.model.modes`; `starts_in_stick`
   is 0 or 1. `speed` is the speed of the belt at the last update of the mode in model exchange,
   `acceleration` is that of the belt in the outputs. */
typedef struct {
    double mode, separations, reattachments, switches, sticks, last_event;
    double starts_in_stick, speed, acceleration;
    Motion motion;
} BeltMotion;

_Static_assert(sizeof(BeltMotion) <= sizeof(double) * MOTION_SIZE, "the motion is too large");
_Static_assert(VARIABLE_COUNT <= (int)MAX_VARIABLES, "there is no room for the values");
_Static_assert(INDICATORS <= (int)MAX_INDICATORS, "there is no room for the event indicators");

static BeltMotion *belt_motion(Instance *i) { return (BeltMotion *)i->s.motion; }
static const BeltMotion *const_motion(const Instance *i) { return (const BeltMotion *)i->s.motion; }

static const Stepping *get_stepping(Instance *i)
{
    i->stepping = i->stepping ? i->stepping : choose_stepping();
    return i->stepping;
}

static int is_finite_belt(const State *s) { return s->values[V_finite_belt] != 0.0; }

static double clipped_speed(const State *s, int variable)
{
    const double speed = s->values[variable];
    return speed < LEAST_SPEED ? 0.0 : speed;
}

/* Get BELT_PARAMETERS columns for `Stepping`. */
static void get_parameters(const State *s, double *p)
{
    for (int n = 0; n < PARAMETERS; n++)
        p[n] = s->values[PARAMETER_REFERENCES[n]];
    const double mu_s = s->values[V_mu_s];
    p[P_V_BELT] = clipped_speed(s, V_v_belt);
    p[P_MU_S] = mu_s > 0.0 ? mu_s : -1.0, p[P_V_S] = mu_s > 0.0 ? clipped_speed(s, V_v_s) : 0.0;
}

/* Get the changes of these parameters from those of the variables. */
static void get_parameter_changes(const double *d, double *q)
{
    for (int n = 0; n < PARAMETERS; n++)
        q[n] = d[PARAMETER_REFERENCES[n]];
    q[P_V_BELT] = d[V_v_belt], q[P_MU_S] = d[V_mu_s], q[P_V_S] = d[V_v_s];
}

static double static_friction(const State *s)
{
    return s->values[V_mu_s] > 0.0 ? s->values[V_mu_s] : s->values[V_mu];
}

static const char *check_input(Instance *i, uint32_t reference, double value)
{
    const State *s = &i->s;
    const double mu_s = s->values[V_mu_s];
    if (!is_finite_belt(s))
        return NULL;
    if (reference == V_mu && mu_s > 0.0 && value > mu_s)
        return set_reason(i, "mu = %g: must be at most mu_s = %g", value, mu_s);
    if (reference == V_v_belt && s->phase == CONTINUOUS && const_motion(i)->mode == STICK
        && value != s->values[V_v_belt])
        return set_reason(i, "v_belt = %g: must stay %g while the slider sticks, except in event "
                             "mode", value, s->values[V_v_belt]);
    return NULL;
}

static const char *find_warning(Instance *i)
{
    static const uint32_t REFERENCES[] = {V_v_belt, V_mu_s, V_v_s};
    const State *s = &i->s;
    char names[TEXT_SIZE] = "";
    int count = 0;
    if (is_finite_belt(s))
        return s->values[V_v_s] > 0.0 && s->values[V_mu_s] == 0.0
                   ? set_reason(i, "v_s has no effect without mu_s")
                   : NULL;
    for (size_t n = 0; n < sizeof REFERENCES / sizeof *REFERENCES; n++) {
        const Variable *v = &COMPONENT.variables[REFERENCES[n]];
        if (s->values[REFERENCES[n]] == v->start)
            continue;
        strcat(strcat(names, count++ ? ", " : ""), v->name);
    }
    return count ? set_reason(i, "%s %s no effect without finite_belt", names,
                              count == 1 ? "has" : "have")
                 : NULL;
}

static const char *begin_motion(Instance *i)
{
    State *s = &i->s;
    BeltMotion *data = belt_motion(i);
    const double *v = s->values;
    const int separation = v[V_separation] != 0.0;
    const char *reason = check_input(i, V_mu, v[V_mu]);
    double p[BELT_PARAMETERS];
    double state[4] = {v[V_x_start], v[V_vx_start], v[V_y_start], v[V_vy_start]};
    if (reason)
        return reason;
    get_parameters(s, p);
    if (v[V_start_static] != 0.0)
        resting_state(p, separation, state);
    if (!is_finite_number(state[2]))
        return set_reason(i, "no equilibrium: F = %g N lifts the slider and no spring holds it "
                          "vertically; use F >= 0, a larger k3, or ignore separation", p[P_F]);
    get_stepping(i)->begin(&data->motion, p, separation, is_finite_belt(s), state, s->start_time,
                           s->tolerance * LOCAL_TOLERANCE);
    data->mode = motion_mode(&data->motion), data->last_event = s->start_time;
    data->separations = data->reattachments = data->switches = 0.0;
    data->sticks = data->starts_in_stick = data->mode == STICK;
    data->speed = p[P_V_BELT], data->acceleration = 0.0;
    s->states[X] = state[0], s->states[VX] = state[1];
    s->states[Y] = state[2], s->states[VY] = state[3];
    return NULL;
}

/* Whether friction depends on the sliding speed. */
static int has_friction_law(const State *s)
{
    const double *v = s->values;
    return is_finite_belt(s) && clipped_speed(s, V_v_s) > 0.0 && v[V_mu_s] > v[V_mu];
}

/* As `overflow_error` in `fivtui.taylor.stepper`. */
static const char *overflow_reason(Instance *i, double t, double size)
{
    const State *s = &i->s;
    const double *v = s->values;
    const Remedy remedies_if_fast[] = {
        {"a larger v_s", has_friction_law(s)},
        {"a softer contact", 1},
        {"less damping", v[V_c1] > 0.0 || v[V_c2] > 0.0},
        {"a greater mass", 1},
    };
    const Remedy remedies_if_large[] = {
        {"separation", v[V_separation] == 0.0},
        {"a cubic contact (k_nl above 0)", v[V_k_nl] == 0.0},
        {"a shorter run", 1},
    };
    if (size < OVERFLOW_SIZE) {
        set_reason(i, "the motion changes faster than floating-point numbers resolve at t = %g s",
                   t);
        return advise(i, remedies_if_fast, sizeof remedies_if_fast / sizeof *remedies_if_fast);
    }
    set_reason(i, "the motion grows beyond the floating-point range at t = %g s", t);
    return advise(i, remedies_if_large, sizeof remedies_if_large / sizeof *remedies_if_large);
}

/* As `stall_error` in `fivtui.taylor.stepper`. */
static const char *stall_reason(Instance *i, double t)
{
    const Remedy remedies[] = {
        {"a less stiff contact", 1},
        {"more damping", 1},
        {"a larger v_s", has_friction_law(&i->s)},
    };
    set_reason(i, "at t = %.17g s the motion changes faster than floating-point time resolves", t);
    return advise(i, remedies, sizeof remedies / sizeof *remedies);
}

static const char *move_on(Instance *i, double from, double *t, int *switched)
{
    const State *s = &i->s;
    Motion *m = &belt_motion(i)->motion;
    const Ramp force = {s->values[V_F], s->slopes[V_F]}, mu = {s->values[V_mu], s->slopes[V_mu]};
    const Ramp speed = {clipped_speed(s, V_v_belt), s->slopes[V_v_belt]};
    switch (get_stepping(i)->move(m, from, t, switched, force, mu, speed)) {
    case OVERFLOW:
        return overflow_reason(i, m->failed_at, m->failed_size);
    case STALLED:
        return stall_reason(i, m->failed_at);
    case STEP_LIMIT:
        return step_limit_reason(i, m->failed_at);
    default:
        return NULL;
    }
}

static double computed_until(const Instance *i)
{
    const Motion *m = &const_motion(i)->motion;
    /* Where a ramp ends, the inputs are held again and a new step must begin. */
    return has_ramps(m) ? -INFINITE : m->end;
}

static double motion_step_end(Instance *i)
{
    double t = i->s.t;
    Motion *m = &belt_motion(i)->motion;
    const Motion before = *m;
    /* A failure is reported when the step is taken. */
    const double end = move_on(i, t, &t, NULL) ? INFINITE : m->end;
    /* Do not count modes met while looking ahead. */
    if (i->updates_inputs && is_finite_belt(&i->s))
        *m = before;
    return end;
}

/* Read the state at the current time, and unless a switch is pending, mode and counts. */
static void read_motion(Instance *i)
{
    State *s = &i->s;
    BeltMotion *data = belt_motion(i);
    const Motion *m = &data->motion;
    const Block *w = &m->w;
    double state[4];
    get_stepping(i)->state(m, s->t, state);
    s->states[X] = state[0], s->states[VX] = state[1];
    s->states[Y] = state[2], s->states[VY] = state[3];
    if (s->switch_pending)
        return;
    data->mode = motion_mode(m);
    data->last_event = is_finite_belt(s) ? m->last_change : w->last_switch;
    data->separations = w->separations, data->reattachments = w->reattachments;
    data->switches = is_finite_belt(s) ? m->changes : w->separations + w->reattachments;
    data->sticks = m->sticks + data->starts_in_stick;
}

/* On a belt of finite speed, read the acceleration of the belt and the mode: of the last step if no
   input was set since, else of the beginning of the next step. */
static void read_belt_mode(Instance *i)
{
    const State *s = &i->s;
    BeltMotion *data = belt_motion(i);
    const Motion *m = &data->motion;
    data->acceleration = s->inputs_unchanged ? m->speed.slope : s->slopes[V_v_belt];
    if (s->inputs_unchanged || s->switch_pending)
        return;
    const Motion before = *m;
    double t = s->t;
    /* A failure is reported when the step is taken. */
    if (!move_on(i, t, &t, NULL))
        data->mode = motion_mode(m);
    data->motion = before;
}

/* Absolute sliding speed in a mode; rounding below zero is clipped. */
static double sliding_speed(const State *s, double mode)
{
    const double v_r = clipped_speed(s, V_v_belt) - s->states[VX];
    return maximum(mode == BACKWARD ? -v_r : v_r, 0.0);
}

/* The friction force on the slider; `force` is the contact force. */
static double friction_on_slider(const Instance *i, const double *p, double force)
{
    const BeltMotion *data = const_motion(i);
    const double mode = data->mode;
    if (mode == STICK)
        return holding_force(p, i->s.states[X], i->s.states[Y], data->acceleration);
    if (mode != FORWARD && mode != BACKWARD)
        return i->s.values[V_mu] * force;
    const double friction = friction_coefficient(p, sliding_speed(&i->s, mode)) * force;
    return mode == BACKWARD ? -friction : friction;
}

static void compute_outputs(Instance *i)
{
    if (i->type == fmi2CoSimulation) {
        read_motion(i);
        if (is_finite_belt(&i->s))
            read_belt_mode(i);
    }
    const BeltMotion *data = const_motion(i);
    const double *states = i->s.states;
    double *v = i->s.values, x = states[X], y = states[Y], vx = states[VX], vy = states[VY];
    double p[BELT_PARAMETERS];
    get_parameters(&i->s, p);
    const double force = data->mode != SEPARATED ? spring_force(p, y) + 0.0 : 0.0;
    const double friction = friction_on_slider(i, p, force);
    v[V_x] = x, v[V_vx] = vx, v[V_y] = v[V_switching] = y, v[V_vy] = vy;
    v[V_P] = force;
    v[V_friction_slider] = friction, v[V_friction_belt] = -friction;
    v[V_ax] = horizontal_acceleration(p, x, vx, y, friction);
    if (data->mode == STICK)
        v[V_ax] = data->acceleration;
    v[V_ay] = vertical_acceleration(p, x, y, vy, force - load_of(p));
    v[V_mode] = v[V_mode_integer] = v[V_mode_enumeration] = data->mode;
    v[V_separations] = data->separations, v[V_reattachments] = data->reattachments;
    v[V_switches] = data->switches, v[V_sticks] = data->sticks;
    v[V_last_event] = data->last_event;
}

/* The value, or a tiny number with the sign of `side` if it is zero. */
static double signed_value(double value, double side)
{
    return value != 0.0 ? value : side * DBL_MIN;
}

/* An indicator is y, v_r or a margin of stick if its zero ends the mode, else 1. At zero it has the
   sign that it has within the mode. */
static void event_indicators(const Instance *i, double *indicators)
{
    const State *s = &i->s;
    const BeltMotion *data = const_motion(i);
    const double mode = data->mode, y = s->states[Y];
    for (int n = 0; n < INDICATORS; n++)
        indicators[n] = 1.0;
    indicators[HEIGHT] = signed_value(y, mode == SEPARATED ? 1.0 : -1.0);
    if (mode == FORWARD || mode == BACKWARD) {
        const double side = mode == FORWARD ? 1.0 : -1.0;
        indicators[SLIDING_SPEED] = signed_value(clipped_speed(s, V_v_belt) - s->states[VX], side);
    } else if (mode == STICK) {
        double p[BELT_PARAMETERS];
        get_parameters(s, p);
        const double friction_limit = static_friction(s) * spring_force(p, y);
        const double holding = holding_force(p, s->states[X], y, data->acceleration);
        indicators[FORWARD_MARGIN] = signed_value(friction_limit - holding, 1.0);
        indicators[BACKWARD_MARGIN] = signed_value(friction_limit + holding, 1.0);
    }
}

static double largest(double a, double b) { return a > b ? a : b; }

/* Find the mode on a belt of finite speed at a state whose y is exact. Set v_r to zero if its sign
   is due to rounding or to the importer, which overshot the zero. `scale` is a speed. */
static double find_mode(const Instance *i, Block *w, double *p, double *state, double scale)
{
    const BeltMotion *data = const_motion(i);
    const double vx = state[1], speed = p[P_V_BELT], v_r = speed - vx;
    const int has_overshot =
        (data->mode == FORWARD && v_r < 0.0) || (data->mode == BACKWARD && v_r > 0.0);
    const double tolerance =
        has_overshot && speed == data->speed ? OVERSHOOT_TOLERANCE : SWITCH_TOLERANCE;
    Belt belt;
    if (vabs(v_r) <= tolerance * largest(scale, speed))
        state[1] = speed;
    p[P_MU_S] = p[P_MU_S] < 0.0 ? p[P_MU] : p[P_MU_S];
    begin_problem(w, 0, p, i->s.values[V_separation] != 0.0, state);
    begin_belt(&belt, w, 0, p, 1);
    if (belt.mode == SEPARATED) {
        state[1] = vx;
        return SEPARATED;
    }
    belt.hold_tolerance = SWITCH_TOLERANCE;
    return (double)mode_on_belt(&belt, state[0], state[1], state[2], state[3]);
}

static int update_mode(Instance *i)
{
    State *s = &i->s;
    BeltMotion *data = belt_motion(i);
    double p[BELT_PARAMETERS];
    double state[4] = {s->states[X], s->states[VX], s->states[Y], s->states[VY]};
    Block w;
    get_parameters(s, p);
    begin_problem(&w, 0, p, s->values[V_separation] != 0.0, state);
    const double speed = largest(vabs(state[1]), vabs(state[3])) / w.frequency;
    const double position = largest(vabs(state[0]), vabs(state[2]));
    const double scale = largest(w.deflection, largest(position, speed));
    if (vabs(state[2]) <= SWITCH_TOLERANCE * scale) {
        /* The sign of y is due to rounding: the direction of the motion selects the mode. */
        state[2] = 0.0;
        begin_problem(&w, 0, p, s->values[V_separation] != 0.0, state);
    }
    double mode = w.side > 0.0 ? SEPARATED : CONTACT;
    if (is_finite_belt(s)) {
        mode = find_mode(i, &w, p, state, scale * w.frequency);
        data->speed = p[P_V_BELT];
    }
    if (mode == data->mode)
        return 0;
    data->separations += mode == SEPARATED, data->reattachments += data->mode == SEPARATED;
    data->switches += 1.0, data->sticks += mode == STICK;
    data->mode = mode, data->last_event = s->t, s->states[VX] = state[1], s->states[Y] = state[2];
    return 1;
}

/* The change of the friction force on the slider; `force` is the change of the contact force. */
static double friction_change(const Instance *i, const double *p, const double *q, const double *d,
                              double force)
{
    const State *s = &i->s;
    const double *v = s->values, mode = const_motion(i)->mode;
    if (mode == STICK)
        return holding_force_change(p, q, v[V_x], d[V_x], v[V_y], d[V_y],
                                    const_motion(i)->acceleration, 0.0);
    if (mode != FORWARD && mode != BACKWARD)
        return v[V_mu] * force + d[V_mu] * v[V_P];
    const double sign = mode == FORWARD ? 1.0 : -1.0, speed = sliding_speed(s, mode);
    const double mu = friction_coefficient(p, speed);
    const double speed_change = sign * (d[V_v_belt] - d[V_vx]);
    double change = friction_coefficient_change(p, q, speed, speed_change);
    if (v[V_v_s] > 0.0 && v[V_mu_s] == 0.0 && d[V_mu_s] != 0.0) {
        /* mu_s = 0 stands for μ, so friction is discontinuous there. */
        change = __builtin_nan("");
    }
    return sign * (mu * force + change * v[V_P]);
}

static void differentiate(const Instance *i, double *d)
{
    const double *v = i->s.values, y = v[V_y], mode = const_motion(i)->mode;
    double p[BELT_PARAMETERS], q[BELT_PARAMETERS];
    get_parameters(&i->s, p), get_parameter_changes(d, q);
    const double force = mode != SEPARATED ? spring_force_change(p, q, y, d[V_y]) : 0.0;
    const double friction = friction_change(i, p, q, d, force);
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
    get_parameters(&i->s, p), get_parameter_changes(d, q);
    const double y = v[V_y], load_change = load_of_change(p, q);
    if (v[V_separation] != 0.0 && load_of(p) < 0.0)
        d[V_y] = -(load_change + suspension_stiffness_change(p, q) * y) / suspension_stiffness(p);
    else
        d[V_y] = -(load_change
                   + (rest_cubic_change(p, q, 0.0, 0.0) * y * y
                      + rest_linear_change(p, q, 0.0, 0.0)) * y)
                 / (3.0 * rest_cubic(p, 0.0) * y * y + rest_linear(p, 0.0));
    d[V_x] = rest_position_change(p, q, y, d[V_y], 0.0, 0.0);
    d[V_vx] = d[V_vy] = 0.0;
}

enum {
    N_MODE, N_SEPARATIONS, N_REATTACHMENTS, N_SWITCHES, N_STICKS, N_LAST_EVENT,
    N_STARTS_IN_STICK, N_UPDATE_SPEED,
    N_STEP_START, N_REMAINDER, N_STEP_SIDE, N_STALLED, N_STEP_SEPARATIONS, N_STEP_REATTACHMENTS,
    N_LAST_SWITCH, N_X, N_VX, N_Y, N_VY,
    N_STEP_MODE, N_STEP_STICKS, N_SLIPS, N_REVERSALS, N_CHANGES, N_LAST_CHANGE,
    N_HAS_STEP, N_RAMP_START, N_F, N_F_SLOPE, N_MU, N_MU_SLOPE, N_SPEED, N_SPEED_SLOPE, NUMBERS
};
_Static_assert(NUMBERS <= MOTION_NUMBERS, "there is no room for the numbers");

static void pack(const Instance *i, double *n)
{
    const BeltMotion *data = const_motion(i);
    const Motion *m = &data->motion;
    const Block *w = &m->w;
    n[N_MODE] = data->mode, n[N_SEPARATIONS] = data->separations;
    n[N_REATTACHMENTS] = data->reattachments, n[N_LAST_EVENT] = data->last_event;
    n[N_SWITCHES] = data->switches, n[N_STICKS] = data->sticks;
    n[N_STARTS_IN_STICK] = data->starts_in_stick, n[N_UPDATE_SPEED] = data->speed;
    n[N_STEP_START] = w->t, n[N_REMAINDER] = w->remainder;
    n[N_STEP_SIDE] = w->side, n[N_STALLED] = w->stalled, n[N_LAST_SWITCH] = w->last_switch;
    n[N_STEP_SEPARATIONS] = w->separations, n[N_STEP_REATTACHMENTS] = w->reattachments;
    n[N_X] = w->xs[0], n[N_VX] = w->xs[1], n[N_Y] = w->ys[0], n[N_VY] = w->ys[1];
    n[N_STEP_MODE] = motion_mode(m), n[N_STEP_STICKS] = m->sticks, n[N_SLIPS] = m->slips;
    n[N_REVERSALS] = m->reversals, n[N_CHANGES] = m->changes, n[N_LAST_CHANGE] = m->last_change;
    n[N_HAS_STEP] = m->has_step, n[N_RAMP_START] = m->ramp_start;
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

/* Whether the speed at the start of the step suits its mode, up to rounding. */
static int has_speed_of_mode(const double *n)
{
    const double mode = n[N_STEP_MODE];
    const double elapsed = (n[N_STEP_START] - n[N_RAMP_START]) + n[N_REMAINDER];
    const double v = n[N_SPEED] + n[N_SPEED_SLOPE] * elapsed;
    const double v_r = v - n[N_VX], tolerance = 0x1p-40 * (vabs(v) + vabs(n[N_VX]));
    return !(mode == FORWARD && v_r < -tolerance) && !(mode == BACKWARD && v_r > tolerance)
           && !(mode == STICK && vabs(v_r) > tolerance);
}

/* Whether `remainder` is small enough to be the rounding error of t. */
static int is_rounding(double remainder, double t)
{
    return vabs(remainder) <= 0x1p-50 * (vabs(t) + 1.0);
}

static int unpack(Instance *i, const double *n)
{
    State *s = &i->s;
    BeltMotion *data = belt_motion(i);
    Motion *m = &data->motion;
    Block *w = &m->w;
    const Stepping *stepping = get_stepping(i);
    const int separation = s->values[V_separation] != 0.0;
    const double state[4] = {n[N_X], n[N_VX], n[N_Y], n[N_VY]};
    double p[BELT_PARAMETERS];
    get_parameters(s, p);
    p[P_F] = n[N_F], p[P_MU] = n[N_MU], p[P_V_BELT] = n[N_SPEED];
    data->mode = n[N_MODE], data->separations = n[N_SEPARATIONS];
    data->reattachments = n[N_REATTACHMENTS], data->last_event = n[N_LAST_EVENT];
    data->switches = n[N_SWITCHES], data->sticks = n[N_STICKS];
    data->starts_in_stick = n[N_STARTS_IN_STICK], data->speed = n[N_UPDATE_SPEED];
    data->acceleration = 0.0;
    if (!is_mode(n[N_MODE], s) || !is_mode(n[N_STEP_MODE], s)
        || !is_rounding(n[N_REMAINDER], n[N_STEP_START])
        || (i->type == fmi2CoSimulation && !has_speed_of_mode(n))
        || n[N_STEP_SIDE] != (n[N_STEP_MODE] == SEPARATED ? 1.0 : -1.0))
        return 0;
    stepping->begin(m, p, separation, is_finite_belt(s), state, n[N_STEP_START],
                    s->tolerance * LOCAL_TOLERANCE);
    w->remainder = n[N_REMAINDER], w->side = n[N_STEP_SIDE], w->stalled = n[N_STALLED];
    w->separations = n[N_STEP_SEPARATIONS], w->reattachments = n[N_STEP_REATTACHMENTS];
    w->last_switch = n[N_LAST_SWITCH];
    set_field(w);
    m->belt.mode = (int64_t)n[N_STEP_MODE], m->sticks = n[N_STEP_STICKS], m->slips = n[N_SLIPS];
    m->reversals = n[N_REVERSALS], m->changes = n[N_CHANGES], m->last_change = n[N_LAST_CHANGE];
    m->ramp_start = n[N_RAMP_START], m->force.slope = n[N_F_SLOPE];
    m->friction.slope = n[N_MU_SLOPE], m->speed.slope = n[N_SPEED_SLOPE];
    if (i->type == fmi2ModelExchange || n[N_HAS_STEP] == 0.0)
        return i->type == fmi2ModelExchange || s->t == w->t;
    return stepping->recompute(m) == RUNNING && s->t >= w->t && s->t < m->end;
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
    .find_warning = find_warning,
    .check_input = check_input,
    .move = move_on,
    .computed_until = computed_until,
    .motion_step_end = motion_step_end,
    .compute_outputs = compute_outputs,
    .event_indicators = event_indicators,
    .update_mode = update_mode,
    .differentiate = differentiate,
    .differentiate_start = differentiate_start,
    .pack = pack,
    .unpack = unpack,
};
