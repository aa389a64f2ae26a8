/* FMI 3.0: communication steps with intermediate updates.

   A communication step is divided into parts that end with the steps in which the component
   computes the motion (`component.h`). Before each part the importer, if it sets inputs, is asked
   for those at the end of the part; they are interpolated. After the part it can read outputs. In
   both updates it may request an early return. If inputs do not change, the motion equals that
   without updates to the last bit. */

#include <math.h>
#include <string.h>

#include "instance.h"

/* Limit of parts per communication step; each part calls the importer. */
#ifndef MAX_PARTS
#define MAX_PARTS 1000000
#endif

int register_updates(Instance *i, const fmi3ValueReference *needed, size_t count)
{
    if (!i->update)
        return 1;
    for (size_t n = 0; n < count; n++) {
        /* After the variables of the table come the time and the event indicators. */
        if (!needed || needed[n] > COMPONENT.variable_count + COMPONENT.indicator_count) {
            report(i, fmi2Error,
                   "required intermediate variable %zu: must be the value reference of a variable",
                   n);
            return 0;
        }
        if (needed[n] >= COMPONENT.variable_count)
            continue;
        const Variable *v = COMPONENT.variables + needed[n];
        /* Only a warning: importers that record all outputs require all of them. */
        if (!v->is_continuous)
            report(i, fmi2Warning, "required intermediate variable %s is not continuous: ignored",
                   v->name);
        i->is_updated[needed[n]] = v->is_continuous && v->role == INPUT;
        i->updates_inputs |= i->is_updated[needed[n]];
    }
    return 1;
}

/* Call the importer at a time, s, for inputs or to read outputs; an early return reduces `stop`,
   the end of the step. */
static void call_update(Instance *i, double time, int wants_inputs, double *stop)
{
    State *s = &i->s;
    fmi3Boolean wants_return = fmi3False;
    fmi3Float64 return_time = time;
    s->phase = INTERMEDIATE, s->fast_until = -INFINITY, i->wants_inputs = wants_inputs;
    i->update(i->environment, time, wants_inputs, !wants_inputs, !wants_inputs, i->returns_early,
              &wants_return, &return_time);
    s->phase = STEPPING, i->wants_inputs = 0;
    if (wants_return && i->returns_early)
        *stop = return_time > s->t ? fmin(return_time, *stop) : s->t;
}

/* Ask the importer for inputs at the end of a part; set their slopes if the step continues. */
static void ask_for_inputs(Instance *i, double end, double *stop)
{
    State *s = &i->s;
    double before[MAX_VARIABLES];
    memcpy(before, s->values, sizeof before);
    call_update(i, end, 1, stop);
    for (uint32_t r = 0; r < COMPONENT.variable_count && *stop > s->t; r++) {
        s->slopes[r] = i->is_updated[r] ? (s->values[r] - before[r]) / (end - s->t) : 0.0;
        s->has_slopes |= s->slopes[r] != 0.0;
    }
    /* The inputs reach the new values along their slopes, at the end of the part. */
    memcpy(s->values, before, sizeof before);
}

fmi2Status do_step_with_updates(Instance *i, double current, double h, int *switched, int *returned)
{
    REQUIRE(i, "do_step", fmi2CoSimulation, IN(STEPPING));
    const fmi2Status status = check_step(i, current, h);
    if (status != fmi2OK)
        return status;
    const double end = current + h;
    const State before = i->s;
    double stop = end;
    memset(i->s.slopes, 0, sizeof i->s.slopes);
    i->s.has_slopes = 0;
    int parts = 0;
    do {
        const double target = fmin(COMPONENT.motion_step_end(i), stop);
        if (i->updates_inputs)
            ask_for_inputs(i, target, &stop);
        if (stop <= i->s.t)
            break;
        const fmi2Status part_status = parts++ < MAX_PARTS
                                     ? advance_to(i, fmin(target, stop), switched)
                                     : report(i, fmi2Discard, "%s", step_limit_reason(i, i->s.t));
        if (part_status != fmi2OK) {
            i->s = before, i->s.fast_until = -INFINITY;
            return i->s.last_step = fmi2Discard;
        }
        call_update(i, i->s.t, 0, &stop);
    } while (i->s.t < stop && !(switched && *switched));
    *returned = stop < end;
    return i->s.last_step = fmi2OK;
}
