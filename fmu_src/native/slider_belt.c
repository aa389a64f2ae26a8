/* The slider-belt model: its motion in co-simulation, its equations in model exchange.

   In all functions `i` is the instance, `s` its state, `v` the values of its variables by value
   reference, and `d` the changes of these values in directional derivatives. `p` are the parameters
   in the order of the kernel, `fivtui/kernel` (P_M to P_V_S), and `q` their changes. The kernel's
   functions of `p`, such as `load_of` (the downward force F, N), are generated from
   `fivtui/model/field.py`. */

#include <float.h>
#include <string.h>

#include "build.h"
#include "instance.h"
#include "stepping.h"
#include "rest.h"
#include "slider_belt_table.h"

/* Closer to a switch than this, relative to the scale of motion, the motion is at the switch: an
   importer stops close to it, on either side. */
#define SWITCH_TOLERANCE 1e-8
/* An importer of low accuracy may overshoot v_r = 0 by this part of the typical speed. */
#define OVERSHOOT_TOLERANCE 1e-2
/* If all coordinates of a motion that overflows are smaller, m and m/s, its derivatives overflow:
   the motion is too fast, not too large. `_SMALL` in `fivtui.taylor.stepper`. */
#define OVERFLOW_SIZE 1e30
/* Tolerance of one Taylor step, as part of the tolerance of a run: `local_tolerance` in
   `fivtui.taylor.stepper`. */
#define LOCAL_TOLERANCE 3e-3
/* Speeds below this count as zero, m/s: `_MIN_SIZE` in `fivtui.model.parameters`. */
#define LEAST_SPEED 1e-12
/* Rounding errors, relative: of the belt speed along a ramp, and of a time. */
#define SPEED_ROUNDING 0x1p-40
#define TIME_ROUNDING 0x1p-50

/* Order of the states in the model description; the kernel's order is S_X, S_VX, S_Y, S_VY. */
enum { X, Y, VX, VY, STATES };
static const uint32_t STATE_REFERENCES[STATES] = {V_x, V_y, V_vx, V_vy};
static const uint32_t DERIVATIVE_REFERENCES[STATES] = {V_vx, V_vy, V_ax, V_ay};

/* Event indicators: y, the sliding speed v_r = v_belt - vx, and the margins by which friction
   keeps the slider from slipping forward and backward. */
enum { HEIGHT, SLIDING_SPEED, FORWARD_MARGIN, BACKWARD_MARGIN, INDICATORS };

/* What the state of an instance stores of the motion. */
typedef struct {
    /* Values of outputs: mode, as in `fivtui.model.modes`, counts, and time of the last switch, s.
       In co-simulation they are read from `motion`. */
    double mode, separations, reattachments, switches, sticks, last_event;
    /* 0 or 1: counts as a stick. */
    double starts_in_stick;
    /* Speed of the belt at the last update of the mode in model exchange, m/s. */
    double update_speed;
    /* Acceleration of the belt for the outputs, m/s². */
    double belt_acceleration;
    /* The motion in Taylor steps, which co-simulation advances. */
    Motion motion;
} MotionRecord;

_Static_assert(sizeof(MotionRecord) <= sizeof(double) * MOTION_SIZE, "the motion is too large");
_Static_assert(VARIABLE_COUNT <= (int)MAX_VARIABLES, "there is no room for the values");
_Static_assert(OUTPUT_DERIVATIVE_ORDER <= (int)MAX_DERIVATIVE_ORDER, "there is no room for rates");
_Static_assert(INDICATORS <= (int)MAX_INDICATORS, "there is no room for the event indicators");

static MotionRecord *motion_record(Instance *i) { return (MotionRecord *)i->s.motion; }
static const MotionRecord *const_record(const Instance *i)
{
    return (const MotionRecord *)i->s.motion;
}

/* Store a state in the kernel's order as the states of model exchange. */
static void store_states(State *s, const double *state)
{
    s->states[X] = state[S_X], s->states[VX] = state[S_VX];
    s->states[Y] = state[S_Y], s->states[VY] = state[S_VY];
}

/* The functions of the motion, chosen for this processor at the first call. */
static const Stepping *get_stepping(Instance *i)
{
    i->stepping = i->stepping ? i->stepping : choose_stepping();
    return i->stepping;
}

static int is_finite_belt(const State *s) { return s->values[V_finite_belt] != 0.0; }

static double clipped_speed(const State *s, int variable)
{
    const double speed = s->values[variable];
    return vabs(speed) < LEAST_SPEED ? 0.0 : speed;
}

/* Read the parameters in the kernel's order: P_MU_S is -1 where static friction equals μ. */
static void read_parameters(const State *s, double *p)
{
    for (int n = 0; n < PARAMETERS; n++)
        p[n] = s->values[PARAMETER_REFERENCES[n]];
    const double mu_s = is_finite_belt(s) ? s->values[V_mu_s] : 0.0;
    p[P_V_BELT] = is_finite_belt(s) ? clipped_speed(s, V_v_belt) : 0.0;
    p[P_MU_S] = mu_s > 0.0 ? mu_s : -1.0, p[P_V_S] = mu_s > 0.0 ? clipped_speed(s, V_v_s) : 0.0;
}

/* Read the parameters and inputs that apply from the current time on. */
static Inputs read_inputs(const State *s)
{
    /* Adding 0.0 makes −0.0 positive. */
    Inputs inputs = {.rates = {.F = s->slopes[V_F] + 0.0, .mu = s->slopes[V_mu] + 0.0}};
    read_parameters(s, inputs.p);
    inputs.rates.v_belt = is_finite_belt(s) ? s->slopes[V_v_belt] + 0.0 : 0.0;
    return inputs;
}

/* Read the changes of the parameters from those of the variables. */
static void read_parameter_changes(const double *d, double *q)
{
    for (int n = 0; n < PARAMETERS; n++)
        q[n] = d[PARAMETER_REFERENCES[n]];
    q[P_V_BELT] = d[V_v_belt], q[P_MU_S] = d[V_mu_s], q[P_V_S] = d[V_v_s];
}

static double static_friction(const State *s)
{
    return s->values[V_mu_s] > 0.0 ? s->values[V_mu_s] : s->values[V_mu];
}

static const char *check_friction(Instance *i, const double *v)
{
    if (v[V_finite_belt] != 0.0 && v[V_mu_s] > 0.0 && v[V_mu] > v[V_mu_s])
        return set_reason(i, "mu = %g: must be at most mu_s = %g", v[V_mu], v[V_mu_s]);
    return NULL;
}

static const char *check_values(Instance *i, const double *v)
{
    const State *s = &i->s;
    const double speed = v[V_v_belt];
    /* A speed of 0, to which some importers set unconnected inputs, and the default are no speed. */
    if (v[V_finite_belt] == 0.0 && speed != 0.0 && speed != TABLE[V_v_belt].start)
        return set_reason(i, "v_belt = %g: has no effect without finite_belt, which must be set",
                          speed);
    if (v[V_finite_belt] != 0.0 && s->phase == CONTINUOUS && const_record(i)->mode == STICK
        && speed != s->values[V_v_belt])
        return set_reason(i, "v_belt = %g: must stay %g while the slider sticks, except in event "
                             "mode", speed, s->values[V_v_belt]);
    return check_friction(i, v);
}

static const char *find_warning(Instance *i)
{
    const double *v = i->s.values;
    const int has_mu_s = v[V_mu_s] > 0.0, has_v_s = v[V_v_s] > 0.0;
    if (v[V_finite_belt] != 0.0)
        return has_v_s && !has_mu_s ? set_reason(i, "v_s has no effect without mu_s") : NULL;
    if (!has_mu_s && !has_v_s)
        return NULL;
    return set_reason(i, "%s no effect without finite_belt",
                      has_mu_s && has_v_s ? "mu_s, v_s have" : has_mu_s ? "mu_s has" : "v_s has");
}

static const char *begin_motion(Instance *i)
{
    State *s = &i->s;
    MotionRecord *record = motion_record(i);
    const double *v = s->values;
    const int separation = v[V_separation] != 0.0;
    const char *reason = check_friction(i, v);
    double state[STATE] = {v[V_x_start], v[V_vx_start], v[V_y_start], v[V_vy_start]};
    if (reason)
        return reason;
    Inputs inputs = {.rates = {0}};
    read_parameters(s, inputs.p);
    const double *p = inputs.p;
    if (v[V_start_static] != 0.0)
        resting_state(p, separation, state);
    if (!is_finite_number(state[S_Y]))
        return set_reason(i, "no equilibrium: F = %g N lifts the slider and no spring holds it "
                          "vertically; use F >= 0, a larger k3, or ignore separation", p[P_F]);
    get_stepping(i)->begin(&record->motion, &inputs, separation, is_finite_belt(s), state,
                           s->start_time, s->tolerance * LOCAL_TOLERANCE);
    record->mode = motion_mode(&record->motion), record->last_event = s->start_time;
    record->separations = record->reattachments = record->switches = 0.0;
    record->sticks = record->starts_in_stick = record->mode == STICK;
    record->update_speed = p[P_V_BELT], record->belt_acceleration = 0.0;
    store_states(s, state);
    return NULL;
}

/* Whether friction depends on the sliding speed. */
static int has_friction_law(const State *s)
{
    const double *v = s->values;
    return is_finite_belt(s) && clipped_speed(s, V_v_s) > 0.0 && v[V_mu_s] > v[V_mu];
}

/* The reason why a motion overflows, with advice: as `overflow_error` in `fivtui.taylor.stepper`.
   `size` is the largest coordinate at time t. */
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

/* The reason why steps do not advance the time: as `stall_error` in `fivtui.taylor.stepper`. */
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

static const char *advance_motion(Instance *i, double from, double *t, int *switched)
{
    Motion *m = &motion_record(i)->motion;
    const Inputs inputs = read_inputs(&i->s);
    switch (get_stepping(i)->advance(m, from, t, switched, &inputs)) {
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

/* Whether a quantity with these derivatives, divided by factorials, grows, or falls if `sign` is
   −1. */
static int is_growing(const double *series, double sign)
{
    for (int n = 1; n <= OUTPUT_DERIVATIVE_ORDER; n++)
        if (series[n] != 0.0)
            return sign * series[n] > 0.0;
    return 0;
}

/* The n-th coefficient in time of a total, which grows by `sign` times an output while that exceeds
   it. */
static double total_term(double total, double value, const double *series, double sign, int n)
{
    return total == sign * value && is_growing(series, sign) ? sign * series[n] : 0.0;
}

/* Derivatives by time, from an expansion of the motion at the current time. */
static const char *differentiate_in_time(Instance *i, double rates[][MAX_VARIABLES])
{
    const State *s = &i->s;
    const double *v = s->values;
    Motion m = motion_record(i)->motion;
    const Inputs inputs = read_inputs(s);
    if (get_stepping(i)->expand(&m, s->t, &inputs) != RUNNING)
        return overflow_reason(i, s->t, maximum(vabs(v[V_x]), vabs(v[V_y])));
    /* Coefficients in the time since now. A force is the mass times the part of the acceleration
       that is missing without it. */
    const double *p = inputs.p, *x = m.w.xs, *y = m.w.ys;
    double vx[OUTPUT_DERIVATIVE_ORDER + 1], vy[OUTPUT_DERIVATIVE_ORDER + 1],
        ax[OUTPUT_DERIVATIVE_ORDER + 1], ay[OUTPUT_DERIVATIVE_ORDER + 1],
        P[OUTPUT_DERIVATIVE_ORDER + 1], factorial = 1.0;
    const int is_off = motion_mode(&m) == SEPARATED;
    for (int k = 1; k <= OUTPUT_DERIVATIVE_ORDER; k++) {
        vx[k] = (k + 1.0) * x[k + 1], ax[k] = (k + 1.0) * (k + 2.0) * x[k + 2];
        vy[k] = (k + 1.0) * y[k + 1], ay[k] = (k + 1.0) * (k + 2.0) * y[k + 2];
        P[k] = is_off ? 0.0 : p[P_M] * (ay[k] - vertical_acceleration(p, x[k], y[k], vy[k], 0.0));
    }
    if (!is_off)
        P[1] += inputs.rates.F;
    for (int n = 1; n <= OUTPUT_DERIVATIVE_ORDER; n++) {
        double *d = rates[n], friction = 0.0;
        if (!is_off)
            friction = p[P_M] * (ax[n] - horizontal_acceleration(p, x[n], vx[n], y[n], 0.0));
        d[V_x] = x[n], d[V_vx] = vx[n], d[V_ax] = ax[n];
        d[V_y] = d[V_switching] = y[n], d[V_vy] = vy[n], d[V_ay] = ay[n];
        d[V_P] = P[n], d[V_friction_slider] = friction, d[V_friction_belt] = -friction;
        d[V_x_peak] = total_term(v[V_x_peak], v[V_x], x, v[V_x] < 0.0 ? -1.0 : 1.0, n);
        d[V_y_peak] = total_term(v[V_y_peak], v[V_y], y, v[V_y] < 0.0 ? -1.0 : 1.0, n);
        d[V_vx_max] = total_term(v[V_vx_max], v[V_vx], vx, 1.0, n);
        d[V_P_max] = total_term(v[V_P_max], v[V_P], P, 1.0, n);
        d[V_P_min] = -total_term(-v[V_P_min], v[V_P], P, -1.0, n);
        d[V_separated_time] = n == 1 ? is_off : 0.0;
        factorial *= n;
        for (int r = 0; r < VARIABLE_COUNT; r++)
            d[r] *= factorial;
    }
    return NULL;
}

static double computed_until(const Instance *i)
{
    const Motion *m = &const_record(i)->motion;
    /* Where a ramp ends, the inputs are held again and a new step must begin. */
    return has_ramps(m) ? -INFINITE : m->end;
}

static double motion_step_end(Instance *i)
{
    double t = i->s.t;
    Motion *m = &motion_record(i)->motion;
    const Motion before = *m;
    /* To advance to the current time computes the step that begins there. Ignore a failure: the
       step that follows reports it. */
    const double end = advance_motion(i, t, &t, NULL) ? INFINITE : m->end;
    /* The importer sets inputs for this step, with which it is computed again. On a belt of finite
       speed the mode may then be another: that under held inputs must not be counted. */
    if (i->updates_inputs && is_finite_belt(&i->s))
        *m = before;
    return end;
}

/* Read the state at the current time; also mode and counts unless a switch is pending. `w` has the
   kernel's state of the run, with its counts. */
static void read_motion(Instance *i)
{
    State *s = &i->s;
    MotionRecord *record = motion_record(i);
    const Motion *m = &record->motion;
    const Block *w = &m->w;
    double state[STATE];
    get_stepping(i)->state(m, s->t, state);
    store_states(s, state);
    if (s->switch_pending)
        return;
    record->mode = motion_mode(m);
    record->last_event = is_finite_belt(s) ? m->last_belt_switch : w->last_switch;
    record->separations = w->separations, record->reattachments = w->reattachments;
    record->switches = is_finite_belt(s) ? m->belt_switches : w->separations + w->reattachments;
    record->sticks = m->sticks + record->starts_in_stick;
}

/* On a belt of finite speed, read the acceleration of the belt and the mode. They are those of the
   last step if no input was set after it. Otherwise they are those at the beginning of the next
   step, with the new inputs and slopes. */
static void read_belt_mode(Instance *i)
{
    const State *s = &i->s;
    MotionRecord *record = motion_record(i);
    const Motion *m = &record->motion;
    record->belt_acceleration = s->has_inputs_of_step ? m->inputs.rates.v_belt
                                                      : s->slopes[V_v_belt];
    if (s->has_inputs_of_step || s->switch_pending)
        return;
    const Motion before = *m;
    double t = s->t;
    /* Ignore a failure: the step that follows reports it. */
    if (!advance_motion(i, t, &t, NULL))
        record->mode = motion_mode(m);
    record->motion = before;
}

/* Absolute sliding speed |v_r| in a mode; negative rounding errors become zero. */
static double sliding_speed(const State *s, double mode)
{
    const double v_r = clipped_speed(s, V_v_belt) - s->states[VX];
    return maximum(mode == BACKWARD ? -v_r : v_r, 0.0);
}

/* The friction force on the slider; `force` is the contact force. */
static double friction_on_slider(const Instance *i, const double *p, double force)
{
    const MotionRecord *record = const_record(i);
    const double mode = record->mode;
    if (mode == STICK)
        return holding_force(p, i->s.states[X], i->s.states[Y], record->belt_acceleration);
    if (mode != FORWARD && mode != BACKWARD)
        return i->s.values[V_mu] * force;
    const double friction = friction_coefficient(p, sliding_speed(&i->s, mode)) * force;
    return mode == BACKWARD ? -friction : friction;
}

/* Model exchange: the totals up to the current time, from those at completed steps. */
static Totals exchange_totals(const Instance *i)
{
    const State *s = &i->s;
    const MotionRecord *record = const_record(i);
    const double *v = s->values;
    const int is_off = record->mode == SEPARATED;
    const Totals part = {vabs(v[V_x]), vabs(v[V_y]), v[V_vx], v[V_P], v[V_P],
                         is_off ? s->t - record->last_event : 0.0};
    Totals totals = record->motion.past;
    extend_totals(&totals, &part);
    return totals;
}

static void compute_outputs(Instance *i)
{
    if (i->type == fmi2CoSimulation) {
        read_motion(i);
        if (is_finite_belt(&i->s))
            read_belt_mode(i);
    }
    const MotionRecord *record = const_record(i);
    const double *states = i->s.states;
    double *v = i->s.values, x = states[X], y = states[Y], vx = states[VX], vy = states[VY];
    double p[BELT_PARAMETERS];
    read_parameters(&i->s, p);
    /* Adding 0.0 makes −0.0 positive. */
    const double force = record->mode != SEPARATED ? spring_force(p, y) + 0.0 : 0.0;
    const double friction = friction_on_slider(i, p, force);
    /* `switching` is the switching function: y, negative in contact. */
    v[V_x] = x, v[V_vx] = vx, v[V_y] = v[V_switching] = y, v[V_vy] = vy;
    v[V_P] = force;
    v[V_friction_slider] = friction, v[V_friction_belt] = -friction;
    v[V_ax] = horizontal_acceleration(p, x, vx, y, friction);
    if (record->mode == STICK)
        v[V_ax] = record->belt_acceleration;
    v[V_ay] = vertical_acceleration(p, x, y, vy, force - load_of(p));
    v[V_mode] = v[V_mode_integer] = v[V_mode_enumeration] = record->mode;
    v[V_separations] = record->separations, v[V_reattachments] = record->reattachments;
    v[V_switches] = record->switches, v[V_sticks] = record->sticks;
    v[V_last_event] = record->last_event;
}

static void compute_totals(Instance *i)
{
    double *v = i->s.values;
    Totals totals;
    if (i->type == fmi2CoSimulation)
        get_stepping(i)->totals(&motion_record(i)->motion, i->s.t, &totals);
    else
        totals = exchange_totals(i);
    v[V_x_peak] = totals.x_peak, v[V_y_peak] = totals.y_peak, v[V_vx_max] = totals.vx_max;
    /* The contact force is that under parameters set since the last step. */
    v[V_P_min] = minimum(totals.P_min, v[V_P]), v[V_P_max] = maximum(totals.P_max, v[V_P]);
    v[V_separated_time] = totals.separated_time;
}

/* Include the states of model exchange in the totals at completed steps. */
static int complete_step(Instance *i)
{
    Motion *m = &motion_record(i)->motion;
    update_outputs(i);
    Totals totals = exchange_totals(i);
    /* The time off the belt is added where that ends, by `update_mode`. */
    totals.separated_time = m->past.separated_time;
    if (check_finite(i, "P", totals.P_max - totals.P_min) != fmi2OK)
        return 0;
    m->past = totals;
    return 1;
}

/* The value; if it is zero, the least normal number with the sign of `side`. */
static double signed_value(double value, double side)
{
    return value != 0.0 ? value : side * DBL_MIN;
}

/* Indicators whose zero does not end the current mode are 1. At zero an indicator has the sign that
   it has within the mode, so that the importer finds no event at the start of the mode. */
static void event_indicators(const Instance *i, double *indicators)
{
    const State *s = &i->s;
    const MotionRecord *record = const_record(i);
    const double mode = record->mode, y = s->states[Y];
    for (int n = 0; n < INDICATORS; n++)
        indicators[n] = 1.0;
    indicators[HEIGHT] = signed_value(y, mode == SEPARATED ? 1.0 : -1.0);
    if (mode == FORWARD || mode == BACKWARD) {
        const double side = mode == FORWARD ? 1.0 : -1.0;
        indicators[SLIDING_SPEED] = signed_value(clipped_speed(s, V_v_belt) - s->states[VX], side);
    } else if (mode == STICK) {
        double p[BELT_PARAMETERS];
        read_parameters(s, p);
        const double friction_limit = static_friction(s) * spring_force(p, y);
        const double holding = holding_force(p, s->states[X], y, record->belt_acceleration);
        indicators[FORWARD_MARGIN] = signed_value(friction_limit - holding, 1.0);
        indicators[BACKWARD_MARGIN] = signed_value(friction_limit + holding, 1.0);
    }
}

/* Find the mode on a belt of finite speed at a state whose y has the right sign: `update_mode` has
   set it to zero if it is zero to rounding. If the sign of v_r is due to rounding, or to an
   importer that overshot its zero, set vx to the speed of the belt. `scale` is the typical speed of
   the motion, m/s. */
static double find_mode(const Instance *i, Block *w, double *p, double *state, double scale)
{
    const MotionRecord *record = const_record(i);
    const double vx = state[S_VX], speed = p[P_V_BELT], v_r = speed - vx;
    const int has_overshot =
        (record->mode == FORWARD && v_r < 0.0) || (record->mode == BACKWARD && v_r > 0.0);
    /* A new speed of the belt since the last update reverses v_r at once: this is no overshoot. */
    const double tolerance =
        has_overshot && speed == record->update_speed ? OVERSHOOT_TOLERANCE : SWITCH_TOLERANCE;
    Belt belt;
    if (vabs(v_r) <= tolerance * maximum(scale, vabs(speed)))
        state[S_VX] = speed;
    /* The kernel needs the value; `read_parameters` gives −1 for μ. */
    p[P_MU_S] = p[P_MU_S] < 0.0 ? p[P_MU] : p[P_MU_S];
    begin_problem(w, ONLY_LANE, p, i->s.values[V_separation] != 0.0, state);
    begin_belt(&belt, w, ONLY_LANE, p, 1);
    if (belt.mode == SEPARATED) {
        state[S_VX] = vx;
        return SEPARATED;
    }
    belt.hold_tolerance = SWITCH_TOLERANCE;
    return (double)mode_on_belt(&belt, state[S_X], state[S_VX], state[S_Y], state[S_VY]);
}

/* Model exchange: update mode, counts and states at the current time; returns whether the mode
   changed. */
static int update_mode(Instance *i)
{
    State *s = &i->s;
    MotionRecord *record = motion_record(i);
    complete_step(i);
    double p[BELT_PARAMETERS];
    double state[STATE] = {s->states[X], s->states[VX], s->states[Y], s->states[VY]};
    Block w;
    read_parameters(s, p);
    /* The kernel's scales of the motion, and the side of y: `w.side`. */
    begin_problem(&w, ONLY_LANE, p, s->values[V_separation] != 0.0, state);
    /* The scale of motion, m: of positions, and of speeds over the frequency. */
    const double speed = maximum(vabs(state[S_VX]), vabs(state[S_VY])) / w.frequency;
    const double position = maximum(vabs(state[S_X]), vabs(state[S_Y]));
    const double scale = maximum(w.deflection, maximum(position, speed));
    if (vabs(state[S_Y]) <= SWITCH_TOLERANCE * scale) {
        /* The sign of y is due to rounding. At y = 0 `begin_problem` sets the side by the direction
           of the motion. */
        state[S_Y] = 0.0;
        begin_problem(&w, ONLY_LANE, p, s->values[V_separation] != 0.0, state);
    }
    double mode = w.side > 0.0 ? SEPARATED : CONTACT;
    if (is_finite_belt(s)) {
        mode = find_mode(i, &w, p, state, scale * w.frequency);
        record->update_speed = p[P_V_BELT];
    }
    if (mode == record->mode)
        return 0;
    record->separations += mode == SEPARATED, record->reattachments += record->mode == SEPARATED;
    record->switches += 1.0, record->sticks += mode == STICK;
    if (record->mode == SEPARATED)
        record->motion.past.separated_time += s->t - record->last_event;
    record->mode = mode, record->last_event = s->t;
    s->states[VX] = state[S_VX], s->states[Y] = state[S_Y];
    return 1;
}

/* The change of the friction force on the slider; `force_change` is that of the contact force. */
static double friction_change(const Instance *i, const double *p, const double *q, const double *d,
                              double force_change)
{
    const State *s = &i->s;
    const double *v = s->values, mode = const_record(i)->mode;
    if (mode == STICK)
        return holding_force_change(p, q, v[V_x], d[V_x], v[V_y], d[V_y],
                                    const_record(i)->belt_acceleration, 0.0);
    if (mode != FORWARD && mode != BACKWARD)
        return v[V_mu] * force_change + d[V_mu] * v[V_P];
    const double sign = mode == FORWARD ? 1.0 : -1.0, speed = sliding_speed(s, mode);
    const double mu = friction_coefficient(p, speed);
    const double speed_change = sign * (d[V_v_belt] - d[V_vx]);
    double change = friction_coefficient_change(p, q, speed, speed_change);
    if (v[V_v_s] > 0.0 && v[V_mu_s] == 0.0 && d[V_mu_s] != 0.0) {
        /* mu_s = 0 stands for μ, so friction is discontinuous there. */
        change = __builtin_nan("");
    }
    return sign * (mu * force_change + change * v[V_P]);
}

/* Changes of the outputs and accelerations from those of parameters, inputs and states. */
static void differentiate(const Instance *i, double *d)
{
    const double *v = i->s.values, y = v[V_y], mode = const_record(i)->mode;
    double p[BELT_PARAMETERS], q[BELT_PARAMETERS];
    read_parameters(&i->s, p), read_parameter_changes(d, q);
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
    /* A total changes if the motion takes it at this instant. */
    d[V_x_peak] = v[V_x_peak] == vabs(v[V_x]) ? __builtin_copysign(1.0, v[V_x]) * d[V_x] : 0.0;
    d[V_y_peak] = v[V_y_peak] == vabs(y) ? __builtin_copysign(1.0, y) * d[V_y] : 0.0;
    d[V_vx_max] = v[V_vx_max] == v[V_vx] ? d[V_vx] : 0.0;
    d[V_P_min] = v[V_P_min] == v[V_P] ? force : 0.0;
    d[V_P_max] = v[V_P_max] == v[V_P] ? force : 0.0;
}

/* Changes of the initial states: as `static_start_change` in `fivtui.model.slider_belt`. */
static void differentiate_start(const Instance *i, double *d)
{
    const double *v = i->s.values;
    d[V_x] = d[V_x_start], d[V_vx] = d[V_vx_start];
    d[V_y] = d[V_y_start], d[V_vy] = d[V_vy_start];
    if (v[V_start_static] == 0.0)
        return;
    double p[BELT_PARAMETERS], q[BELT_PARAMETERS];
    read_parameters(&i->s, p), read_parameter_changes(d, q);
    const double y = v[V_y], load_change = load_of_change(p, q);
    /* The height of a slider off the belt is −F over the stiffness of k1 and k3 together. In
       contact it is the root of a cubic, α y³ + β y + F: `rest_cubic` and `rest_linear` for
       μ = 0. */
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

/* The numbers of a saved motion, X(index, member): of the record, and of the start of its Taylor
   step `m` in the kernel's state `w`, with the counts of `Motion` in `stepping.h`. */
#define SAVED_MEMBERS(X)                                                                           \
    X(N_MODE, record->mode) X(N_SEPARATIONS, record->separations)                                  \
    X(N_REATTACHMENTS, record->reattachments) X(N_SWITCHES, record->switches)                      \
    X(N_STICKS, record->sticks) X(N_LAST_EVENT, record->last_event)                                \
    X(N_STARTS_IN_STICK, record->starts_in_stick) X(N_UPDATE_SPEED, record->update_speed)          \
    X(N_REMAINDER, w->remainder) X(N_STEP_SIDE, w->side) X(N_STALLED, w->stalled)                  \
    X(N_STEP_SEPARATIONS, w->separations) X(N_STEP_REATTACHMENTS, w->reattachments)                \
    X(N_LAST_SWITCH, w->last_switch) X(N_SEPARATED_TIME, w->separated_time)                        \
    X(N_SEPARATED_REMAINDER, w->separated_remainder) X(N_STEP_STICKS, m->sticks)                   \
    X(N_SLIPS, m->slips) X(N_REVERSALS, m->reversals) X(N_BELT_SWITCHES, m->belt_switches)         \
    X(N_LAST_BELT_SWITCH, m->last_belt_switch) X(N_INPUT_START, m->input_start)
#define INDEX(index, member) index,
#define PACK(index, member) numbers[index] = member;
#define UNPACK(index, member) member = numbers[index];
enum {
    SAVED_MEMBERS(INDEX)
    N_STEP_START, N_X, N_VX, N_Y, N_VY, N_STEP_MODE, N_HAS_STEP, N_INPUTS,
    N_EXTREMES = N_INPUTS + sizeof(Inputs) / sizeof(double),
    N_PAST = N_EXTREMES + sizeof(Extremes) / sizeof(double),
    NUMBERS = N_PAST + sizeof(Totals) / sizeof(double)
};
_Static_assert(NUMBERS <= (int)MOTION_NUMBERS, "there is no room for the numbers");

/* Write the record and the start of its Taylor step to numbers. */
static void pack(const Instance *i, double *numbers)
{
    const MotionRecord *record = const_record(i);
    const Motion *m = &record->motion;
    const Block *w = &m->w;
    SAVED_MEMBERS(PACK)
    numbers[N_STEP_START] = w->t, numbers[N_X] = w->xs[0], numbers[N_VX] = w->xs[1];
    numbers[N_Y] = w->ys[0], numbers[N_VY] = w->ys[1];
    numbers[N_STEP_MODE] = motion_mode(m), numbers[N_HAS_STEP] = m->has_step;
    memcpy(numbers + N_INPUTS, &m->inputs, sizeof m->inputs);
    memcpy(numbers + N_EXTREMES, &w->extremes, sizeof w->extremes);
    memcpy(numbers + N_PAST, &m->past, sizeof m->past);
}

/* Whether the system can be in a mode: it depends on separation and on the belt. */
static int is_possible_mode(double mode, const State *s)
{
    if (mode == SEPARATED)
        return s->values[V_separation] != 0.0;
    return is_finite_belt(s) ? mode == FORWARD || mode == BACKWARD || mode == STICK
                             : mode == CONTACT;
}

/* Whether the speed at the start of the step suits its mode, up to rounding. */
static int has_speed_of_mode(const double *numbers, const Inputs *inputs)
{
    const double mode = numbers[N_STEP_MODE];
    const double elapsed = (numbers[N_STEP_START] - numbers[N_INPUT_START]) + numbers[N_REMAINDER];
    const double speed = inputs->p[P_V_BELT] + inputs->rates.v_belt * elapsed;
    const double v_r = speed - numbers[N_VX];
    const double tolerance = SPEED_ROUNDING * (vabs(speed) + vabs(numbers[N_VX]));
    return !(mode == FORWARD && v_r < -tolerance) && !(mode == BACKWARD && v_r > tolerance)
           && !(mode == STICK && vabs(v_r) > tolerance);
}

/* Whether parameters and inputs are in their ranges; P_MU_S may be −1. */
static int are_valid(const Inputs *inputs)
{
    const double *p = inputs->p;
    for (int n = 0; n < BELT_PARAMETERS; n++) {
        const Variable *v = TABLE + PARAMETER_REFERENCES[n];
        if (!(p[n] >= v->lower && p[n] <= v->upper) && !(n == P_MU_S && p[n] == -1.0))
            return 0;
    }
    return 1;
}

/* Whether `remainder` is small enough to be the rounding error of t. */
static int is_rounding(double remainder, double t)
{
    return vabs(remainder) <= TIME_ROUNDING * (vabs(t) + 1.0);
}

/* Restore the record from numbers and compute its step again; returns whether they are valid. */
static int unpack(Instance *i, const double *numbers)
{
    State *s = &i->s;
    MotionRecord *record = motion_record(i);
    Motion *m = &record->motion;
    Block *w = &m->w;
    const Stepping *stepping = get_stepping(i);
    const int separation = s->values[V_separation] != 0.0;
    const double state[STATE] = {numbers[N_X], numbers[N_VX], numbers[N_Y], numbers[N_VY]};
    Inputs inputs;
    memcpy(&inputs, numbers + N_INPUTS, sizeof inputs);
    if (!are_valid(&inputs) || !is_possible_mode(numbers[N_MODE], s)
        || !is_possible_mode(numbers[N_STEP_MODE], s)
        || !is_rounding(numbers[N_REMAINDER], numbers[N_STEP_START])
        || (i->type == fmi2CoSimulation && !has_speed_of_mode(numbers, &inputs))
        || numbers[N_STEP_SIDE] != (numbers[N_STEP_MODE] == SEPARATED ? 1.0 : -1.0))
        return 0;
    stepping->begin(m, &inputs, separation, is_finite_belt(s), state, numbers[N_STEP_START],
                    s->tolerance * LOCAL_TOLERANCE);
    SAVED_MEMBERS(UNPACK)
    record->belt_acceleration = 0.0;
    m->belt.mode = (int64_t)numbers[N_STEP_MODE];
    /* The coefficients of the motion on the restored side. */
    set_field(w);
    memcpy(&w->extremes, numbers + N_EXTREMES, sizeof w->extremes);
    memcpy(&m->past, numbers + N_PAST, sizeof m->past);
    if (i->type == fmi2ModelExchange)
        return 1;
    if (numbers[N_HAS_STEP] == 0.0)
        return s->t == w->t;
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
    .check_values = check_values,
    .advance = advance_motion,
    .differentiate_in_time = differentiate_in_time,
    .derivative_order = OUTPUT_DERIVATIVE_ORDER,
    .computed_until = computed_until,
    .motion_step_end = motion_step_end,
    .compute_outputs = compute_outputs,
    .compute_totals = compute_totals,
    .event_indicators = event_indicators,
    .update_mode = update_mode,
    .complete_step = complete_step,
    .differentiate = differentiate,
    .differentiate_start = differentiate_start,
    .pack = pack,
    .unpack = unpack,
};
