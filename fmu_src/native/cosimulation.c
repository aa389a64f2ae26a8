/* Co-simulation: communication steps, input derivatives, and the status of steps. */

#include <math.h>

#include "instance.h"

/* Accepted difference of the times of importer and FMU, s. */
#define TIME_TOLERANCE 1e-9
/* Relative rounding error of times and extrapolated inputs. */
#define ROUNDING 0x1p-50
/* Accepted excess of an input over its bound after a step, relative to its nominal value. */
#define BOUND_TOLERANCE 1e-12

static int is_same_time(double time, double reference)
{
    return fabs(time - reference) <= fmax(TIME_TOLERANCE, ROUNDING * fabs(reference));
}

/* The input after `change`. If it exceeds its bound only by rounding, it is set to the bound. The
   importer may have computed its slope from values up to the nominal one, whose rounding errors are
   greater than those of a small input. */
static double extrapolate_input(const Variable *v, double value, double change)
{
    const double end_value = value + change;
    const double bound = end_value > v->upper   ? v->upper
                         : end_value < v->lower ? v->lower
                                                : end_value;
    const double excess = fabs(end_value - bound);
    const double rounding = ROUNDING * (fabs(value) + fabs(change));
    return excess <= fmax(rounding, BOUND_TOLERANCE * v->nominal) ? bound : end_value;
}

/* Extrapolate inputs over h, s, into `end_values`; returns the reason if a value is invalid. */
static const char *extrapolate_inputs(Instance *i, double h, double *end_values)
{
    for (uint32_t r = 0; r < COMPONENT.variable_count; r++) {
        const Variable *v = COMPONENT.variables + r;
        end_values[r] = i->s.values[r];
        if (v->role != INPUT)
            continue;
        end_values[r] = extrapolate_input(v, end_values[r], i->s.slopes[r] * h);
        if (!(isfinite(end_values[r]) && end_values[r] >= v->lower && end_values[r] <= v->upper))
            return set_reason(i, "%s = %g at the end of the step: must be %s", v->name,
                              end_values[r], v->allowed);
    }
    return COMPONENT.check_values ? COMPONENT.check_values(i, end_values) : NULL;
}

/* Refuse a step for a reason; the importer may repeat it with another size. */
static fmi2Status discard_step(Instance *i, const char *reason)
{
    i->s.fast_until = -INFINITY;
    return i->s.last_step = report(i, fmi2Discard, "%s", reason);
}

fmi2Status check_step(Instance *i, double current, double h)
{
    const State *s = &i->s;
    const double end = current + h;
    if (!is_same_time(current, s->t))
        return discard_step(i, set_reason(i, "current time = %s s: the FMU is at %s s",
                                          format_number(current).text, format_number(s->t).text));
    if (!(h > 0.0 && h < INFINITY && end > s->t))
        return discard_step(i, set_reason(i, "step size = %s: must be a positive number of seconds "
                                             "that changes the time", format_number(h).text));
    if (end > s->stop_time && !is_same_time(end, s->stop_time))
        return discard_step(i, set_reason(i, "the step ends at %s s, after the stop time %s s",
                                          format_number(end).text,
                                          format_number(s->stop_time).text));
    return fmi2OK;
}

fmi2Status advance_to(Instance *i, double end, int *switched)
{
    State *s = &i->s;
    const double target = end;
    double end_values[MAX_VARIABLES];
    const char *reason = s->has_slopes ? extrapolate_inputs(i, end - s->t, end_values) : NULL;
    reason = reason ? reason : COMPONENT.advance(i, s->t, &end, switched);
    if (reason)
        return discard_step(i, reason);
    s->switch_pending = switched && *switched;
    /* The motion stopped at a switch: the inputs have not reached the end of the step. */
    if (s->has_slopes && end != target)
        extrapolate_inputs(i, end - s->t, end_values);
    if (s->has_slopes)
        for (uint32_t r = 0; r < COMPONENT.variable_count; r++)
            s->values[r] = end_values[r], s->slopes[r] = 0.0;
    s->t = end, s->has_outputs = s->has_slopes = 0, s->has_inputs_of_step = 1;
    s->fast_until = s->switch_pending ? -INFINITY : fmin(COMPONENT.computed_until(i), s->stop_time);
    return s->last_step = fmi2OK;
}

/* Slow path of a communication step, kept out of line. */
static __attribute__((noinline)) fmi2Status do_computed_step(Instance *i, double current, double h,
                                                             int *switched)
{
    REQUIRE(i, "do_step", fmi2CoSimulation, IN(STEPPING));
    const fmi2Status status = check_step(i, current, h);
    return status == fmi2OK ? advance_to(i, current + h, switched) : status;
}

fmi2Status do_communication_step(Instance *i, double current, double h, int *switched)
{
    const double end = current + h;
    /* Fast path: most communication steps end inside a step of the motion that has been computed.
       Outputs are computed when they are read. */
    const int is_fast = i && end > i->s.t && end < i->s.fast_until && h > 0.0
                        && fabs(current - i->s.t) <= TIME_TOLERANCE;
    if (__builtin_expect(!is_fast, 0))
        return do_computed_step(i, current, h, switched);
    i->s.t = end, i->s.has_outputs = 0;
    return fmi2OK;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real current, fmi2Real h, fmi2Boolean no_way_back)
{
    (void)no_way_back;
    return do_communication_step(c, current, h, NULL);
}

/* Set the slopes of inputs for the next step; after that step inputs are held. */
fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference r[], size_t count,
                                       const fmi2Integer order[], const fmi2Real value[])
{
    Instance *i = c;
    REQUIRE(i, "set_real_input_derivatives", fmi2CoSimulation,
            IN(INSTANTIATED) | IN(INITIALIZATION) | IN(STEPPING));
    if (count > 0 && (!r || !order || !value))
        return report(i, fmi2Error, "value references, orders and values must be given");
    for (size_t n = 0; n < count; n++) {
        const int is_input =
            r[n] < COMPONENT.variable_count && COMPONENT.variables[r[n]].role == INPUT;
        if (!is_input)
            return report(i, fmi2Error, "value reference %u: must be that of an input", r[n]);
        if (order[n] != 1)
            return report(i, fmi2Error, "order of an input derivative = %d: must be 1", order[n]);
        if (!isfinite(value[n]))
            return report(i, fmi2Discard, "derivative of %s: must be a finite number",
                          COMPONENT.variables[r[n]].name);
    }
    for (size_t n = 0; n < count; n++)
        i->s.slopes[r[n]] = value[n];
    i->s.has_slopes = i->s.has_inputs_of_step = i->s.has_outputs = 0, i->s.fast_until = -INFINITY;
    for (uint32_t reference = 0; reference < COMPONENT.variable_count; reference++)
        i->s.has_slopes |= i->s.slopes[reference] != 0.0;
    return fmi2OK;
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference r[], size_t count,
                                        const fmi2Integer order[], fmi2Real value[])
{
    Instance *i = c;
    double rates[MAX_DERIVATIVE_ORDER + 1][MAX_VARIABLES] = {{0.0}};
    REQUIRE(i, "get_real_output_derivatives", fmi2CoSimulation, IN(STEPPING) | IN(TERMINATED));
    if (count > 0 && (!r || !order || !value))
        return report(i, fmi2Error, "value references, orders and values must be given");
    for (size_t n = 0; n < count; n++) {
        const Variable *v = r[n] < COMPONENT.variable_count ? COMPONENT.variables + r[n] : NULL;
        if (!v || !v->is_continuous || is_settable(v))
            return report(i, fmi2Error, "value reference %u: must be that of a continuous output",
                          r[n]);
        if (order[n] < 1 || order[n] > COMPONENT.derivative_order)
            return report(i, fmi2Error, "order of an output derivative = %d: must be from 1 to %d",
                          order[n], COMPONENT.derivative_order);
    }
    fmi2Status status = update_totals(i);
    const char *reason = status == fmi2OK ? COMPONENT.differentiate_in_time(i, rates) : NULL;
    status = reason ? report(i, fmi2Discard, "%s", reason) : status;
    for (size_t n = 0; n < count && status == fmi2OK; n++) {
        value[n] = rates[order[n]][r[n]];
        status = check_finite(i, COMPONENT.variables[r[n]].name, value[n]);
    }
    return status;
}

fmi2Status fmi2CancelStep(fmi2Component c)
{
    Instance *i = c;
    return i ? report(i, fmi2Error, "cancel_step: steps are not asynchronous") : fmi2Error;
}

/* Refuse a call for a status that does not exist. */
static fmi2Status check_status(Instance *i, int exists)
{
    REQUIRE(i, "get_status", fmi2CoSimulation, IN(STEPPING));
    return exists ? fmi2OK : report(i, fmi2Discard, "get_status: there is no such status");
}

fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Status *value)
{
    Instance *i = c;
    const fmi2Status status = check_status(i, value && kind == fmi2DoStepStatus);
    if (status == fmi2OK)
        *value = i->s.last_step;
    return status;
}

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value)
{
    Instance *i = c;
    const fmi2Status status = check_status(i, value && kind == fmi2LastSuccessfulTime);
    if (status == fmi2OK)
        *value = i->s.t;
    return status;
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value)
{
    const fmi2Status status = check_status(c, value && kind == fmi2Terminated);
    if (status == fmi2OK)
        *value = fmi2False;
    return status;
}

fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Integer *value)
{
    (void)kind, (void)value;
    return check_status(c, 0);
}

fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind kind, fmi2String *value)
{
    (void)kind, (void)value;
    return check_status(c, 0);
}
