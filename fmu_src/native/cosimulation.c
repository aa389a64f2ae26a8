/* Co-simulation: communication steps, input derivatives, and the status of steps. */

#include <math.h>

#include "instance.h"

/* Times of importer and FMU are the same up to this, s, and up to rounding. */
#define SAME_TIME 1e-9
#define ROUNDING 0x1p-50
/* The part of its nominal value by which an input may go beyond its bound at the end of a step. */
#define AT_BOUND 1e-12

static int is_same(double one, double other)
{
    return fabs(one - other) <= fmax(SAME_TIME, ROUNDING * fabs(other));
}

/* An input that has gone on by `change`; its bound where it is beyond that by rounding alone, of its
   own or of larger values of which the importer has made it. */
static double gone_on(const Variable *v, double value, double change)
{
    const double now = value + change;
    const double bound = now > v->upper ? v->upper : now < v->lower ? v->lower : now;
    const double beyond = fabs(now - bound);
    return beyond <= fmax(ROUNDING * (fabs(value) + fabs(change)), AT_BOUND * v->nominal) ? bound : now;
}

/* Inputs at the end of a step that they are not held over; whether they are in their ranges. */
static const char *extrapolate(Instance *i, double h, double *ends)
{
    for (uint32_t r = 0; r < COMPONENT.variable_count; r++) {
        const Variable *v = COMPONENT.variables + r;
        ends[r] = i->s.values[r];
        if (v->role != INPUT)
            continue;
        ends[r] = gone_on(v, ends[r], i->s.slopes[r] * h);
        if (!(isfinite(ends[r]) && ends[r] >= v->lower && ends[r] <= v->upper))
            return because(i, "%s = %g at the end of the step: must be %s", v->name, ends[r],
                           v->allowed);
        const char *why = COMPONENT.fits ? COMPONENT.fits(i, r, ends[r]) : NULL;
        if (why)
            return why;
    }
    return NULL;
}

static fmi2Status give_up(Instance *i, const char *why)
{
    i->s.free_until = -INFINITY;
    return i->s.last_step = refuse(i, fmi2Discard, "%s", why);
}

fmi2Status check_step(Instance *i, double current, double h)
{
    const State *s = &i->s;
    const double end = current + h;
    if (!is_same(current, s->t))
        return give_up(i, because(i, "current time = %s s: the FMU is at %s s",
                                  number(current).text, number(s->t).text));
    if (!(h > 0.0 && h < INFINITY && end > s->t))
        return give_up(i, because(i, "step size = %s: must be a positive number of seconds that "
                                     "changes the time", number(h).text));
    if (end > s->stop_time && !is_same(end, s->stop_time))
        return give_up(i, because(i, "the step ends at %s s, after the stop time %s s",
                                  number(end).text, number(s->stop_time).text));
    return fmi2OK;
}

fmi2Status advance_to(Instance *i, double end, int *switched)
{
    State *s = &i->s;
    const double aim = end;
    double ends[MOST_VARIABLES];
    const char *why = s->is_sloped ? extrapolate(i, end - s->t, ends) : NULL;
    why = why ? why : COMPONENT.move(i, s->t, &end, switched);
    if (why)
        return give_up(i, why);
    s->is_pending = switched && *switched;
    if (s->is_sloped && end != aim)
        extrapolate(i, end - s->t, ends);
    if (s->is_sloped)
        for (uint32_t r = 0; r < COMPONENT.variable_count; r++)
            s->values[r] = ends[r], s->slopes[r] = 0.0;
    s->t = end, s->published = s->is_sloped = 0, s->are_left = 1;
    s->free_until = s->is_pending ? -INFINITY : fmin(COMPONENT.known_until(i), s->stop_time);
    return s->last_step = fmi2OK;
}

/* A step that is not free; apart, so that those that are need no room of its own. */
static __attribute__((noinline)) fmi2Status do_step(Instance *c, double current, double h,
                                                    int *switched)
{
    ALLOWED("do_step", fmi2CoSimulation, IN(STEPPING));
    const fmi2Status status = check_step(c, current, h);
    return status == fmi2OK ? advance_to(c, current + h, switched) : status;
}

fmi2Status take_communication_step(Instance *i, double current, double h, int *switched)
{
    const double end = current + h;
    /* Most steps end within one of the motion: nothing is computed until outputs are read. */
    const int is_free = i && end > i->s.t && end < i->s.free_until && h > 0.0
                        && fabs(current - i->s.t) <= SAME_TIME;
    if (__builtin_expect(!is_free, 0))
        return do_step(i, current, h, switched);
    i->s.t = end, i->s.published = 0;
    return fmi2OK;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real current, fmi2Real h, fmi2Boolean no_way_back)
{
    (void)no_way_back;
    return take_communication_step(c, current, h, NULL);
}

/* The slopes of inputs over the next step; after it they are held, unless given again. */
fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference r[], size_t count,
                                       const fmi2Integer order[], const fmi2Real value[])
{
    Instance *i = c;
    ALLOWED("set_real_input_derivatives", fmi2CoSimulation,
            IN(INSTANTIATED) | IN(INITIALIZATION) | IN(STEPPING));
    if (count > 0 && (!r || !order || !value))
        return refuse(i, fmi2Error, "value references, orders and values must be given");
    for (size_t n = 0; n < count; n++) {
        const int is_input =
            r[n] < COMPONENT.variable_count && COMPONENT.variables[r[n]].role == INPUT;
        if (!is_input)
            return refuse(i, fmi2Error, "value reference %u: must be that of an input", r[n]);
        if (order[n] != 1)
            return refuse(i, fmi2Error, "order of an input derivative = %d: must be 1", order[n]);
        if (!isfinite(value[n]))
            return refuse(i, fmi2Discard, "derivative of %s: must be a finite number",
                          COMPONENT.variables[r[n]].name);
    }
    for (size_t n = 0; n < count; n++)
        i->s.slopes[r[n]] = value[n];
    i->s.is_sloped = i->s.are_left = i->s.published = 0, i->s.free_until = -INFINITY;
    for (uint32_t reference = 0; reference < COMPONENT.variable_count; reference++)
        i->s.is_sloped |= i->s.slopes[reference] != 0.0;
    return fmi2OK;
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference r[], size_t count,
                                        const fmi2Integer order[], fmi2Real value[])
{
    Instance *i = c;
    (void)r, (void)count, (void)order, (void)value;
    return i ? refuse(i, fmi2Error, "derivatives of outputs are not provided") : fmi2Error;
}

fmi2Status fmi2CancelStep(fmi2Component c)
{
    Instance *i = c;
    return i ? refuse(i, fmi2Error, "cancel_step: steps are not asynchronous") : fmi2Error;
}

static fmi2Status check_status(Instance *c, int exists)
{
    ALLOWED("get_status", fmi2CoSimulation, IN(STEPPING));
    return exists ? fmi2OK : refuse(c, fmi2Discard, "get_status: there is no such status");
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
