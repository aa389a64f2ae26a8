/* The brake actuator: τ dF/dt = command + gain (command − P) − F, solved exactly over a step.

   `i` is the instance, `i->s` its state; `v` are the values of its variables and `d` their changes
   in directional derivatives, by reference. The actuator has one mode, hence no switches, and
   nothing is computed ahead. */

#include <math.h>

#include "brake_actuator_table.h"
#include "build.h"
#include "instance.h"

static const uint32_t STATE_REFERENCES[] = {V_F};
static const uint32_t DERIVATIVE_REFERENCES[] = {V_F_rate};

_Static_assert(VARIABLE_COUNT <= (int)MAX_VARIABLES, "there is no room for the values");
_Static_assert(OUTPUT_DERIVATIVE_ORDER <= (int)MAX_DERIVATIVE_ORDER, "there is no room for rates");

/* The preload that the actuator approaches under constant inputs, N. */
static double target_force(const double *v)
{
    return v[V_command] + v[V_gain] * (v[V_command] - v[V_P]);
}

static const char *begin_motion(Instance *i)
{
    i->s.states[0] = i->s.values[V_F_start];
    return NULL;
}

/* The slope of `target_force` under the slopes of the inputs, N/s. */
static double target_slope_of(const State *s)
{
    const double *slopes = s->slopes;
    return slopes[V_command] + s->values[V_gain] * (slopes[V_command] - slopes[V_P]);
}

static const char *advance_motion(Instance *i, double from, double *end, int *switched)
{
    (void)switched;
    const double t = *end;
    const double *v = i->s.values;
    const double target_slope = target_slope_of(&i->s);
    /* With a target force of constant slope, F approaches exponentially the target less
       τ · slope. */
    const double lagged_start = target_force(v) - v[V_tau] * target_slope;
    const double lagged_end = lagged_start + target_slope * (t - from);
    const double force = lagged_end + (i->s.states[0] - lagged_start) * exp((from - t) / v[V_tau]);
    if (!isfinite(force)) {
        const int is_fed_back = v[V_gain] > 0.0;
        const Remedy remedies[] = {
            {"a smaller command", 1},
            {"a smaller gain", is_fed_back},
            {"a smaller contact force", is_fed_back},
        };
        set_reason(i, "the preload grows beyond the floating-point range at t = %g s", t);
        return advise(i, remedies, sizeof remedies / sizeof *remedies);
    }
    i->s.states[0] = force;
    return NULL;
}

/* F has the derivative F_rate = (target − F)/τ. The target force has a first derivative only. */
static const char *differentiate_in_time(Instance *i, double rates[][MAX_VARIABLES])
{
    const double *v = i->s.values;
    double rate = v[V_F_rate], target_rate = target_slope_of(&i->s);
    for (int n = 1; n <= OUTPUT_DERIVATIVE_ORDER; n++) {
        rates[n][V_F] = rate;
        rates[n][V_F_rate] = rate = (target_rate - rate) / v[V_tau];
        target_rate = 0.0;
    }
    return NULL;
}

static double computed_until(const Instance *i) { return i->s.t; }

static double motion_step_end(Instance *i)
{
    (void)i;
    return INFINITY;
}

static void compute_outputs(Instance *i)
{
    double *v = i->s.values;
    v[V_F] = i->s.states[0];
    v[V_F_rate] = (target_force(v) - v[V_F]) / v[V_tau];
}

static void event_indicators(const Instance *i, double *indicators) { (void)i, (void)indicators; }

static int update_mode(Instance *i)
{
    (void)i;
    return 0;
}

static void differentiate(const Instance *i, double *d)
{
    const double *v = i->s.values;
    const double target_change = d[V_command] + v[V_gain] * (d[V_command] - d[V_P])
        + d[V_gain] * (v[V_command] - v[V_P]);
    d[V_F_rate] = (target_change - d[V_F] - v[V_F_rate] * d[V_tau]) / v[V_tau];
}

static void differentiate_start(const Instance *i, double *d)
{
    (void)i;
    d[V_F] = d[V_F_start];
}

/* The motion is the state F alone, which is saved with all states. */
static void pack(const Instance *i, double *numbers) { (void)i, (void)numbers; }

static int unpack(Instance *i, const double *numbers)
{
    (void)i, (void)numbers;
    return 1;
}

const Component COMPONENT = {
    .guid = BRAKE_ACTUATOR_GUID,
    .variables = TABLE,
    .variable_count = VARIABLE_COUNT,
    .states = STATE_REFERENCES,
    .derivatives = DERIVATIVE_REFERENCES,
    .state_count = 1,
    .indicator_count = 0,
    .begin = begin_motion,
    .advance = advance_motion,
    .differentiate_in_time = differentiate_in_time,
    .derivative_order = OUTPUT_DERIVATIVE_ORDER,
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
