/* FMI 3.0: communication steps with intermediate updates.

   Such a step is taken in parts, which end where steps of the motion end. Before a part, an importer
   that sets inputs is asked for those at the end of it: over the part they are interpolated. After a
   part it can read outputs. Both times it may ask for an early return. Where inputs stay as they are
   the motion has the bits of a step without updates. */

#include <math.h>
#include <string.h>

#include "instance.h"

/* Parts after which one communication step is given up; each calls the importer. */
#ifndef MOST_PARTS
#define MOST_PARTS 1000000
#endif

int prepare_updates(Instance *i, const fmi3ValueReference *needed, size_t count)
{
    if (!i->update)
        return 1;
    for (size_t n = 0; n < count; n++) {
        /* After the variables of the table come the time and the event indicators. */
        if (!needed || needed[n] > COMPONENT.variable_count + COMPONENT.indicator_count) {
            refuse(i, fmi2Error,
                   "required intermediate variable %zu: must be the value reference of a variable",
                   n);
            return 0;
        }
        if (needed[n] >= COMPONENT.variable_count)
            continue;
        const Variable *v = COMPONENT.variables + needed[n];
        /* An importer that records all outputs requires all of them. */
        if (!v->is_continuous)
            refuse(i, fmi2Warning, "required intermediate variable %s is not continuous: ignored",
                   v->name);
        i->updated[needed[n]] = v->is_continuous && v->role == INPUT;
        i->updates_inputs |= i->updated[needed[n]];
    }
    return 1;
}

/* An update at a time; the step is to end at `stop`, which may become earlier. */
static void update(Instance *i, double time, int asks, double *stop)
{
    State *s = &i->s;
    fmi3Boolean is_early = fmi3False;
    fmi3Float64 early = time;
    s->phase = INTERMEDIATE, s->free_until = -INFINITY, i->asks = asks;
    i->update(i->environment, time, asks, !asks, !asks, i->returns_early, &is_early, &early);
    s->phase = STEPPING, i->asks = 0;
    if (is_early && i->returns_early)
        *stop = early > s->t ? fmin(early, *stop) : s->t;
}

/* Ask for the inputs at the end of a part; their slopes over it, unless there is to be none. */
static void ask(Instance *i, double end, double *stop)
{
    State *s = &i->s;
    double before[MOST_VARIABLES];
    memcpy(before, s->values, sizeof before);
    update(i, end, 1, stop);
    for (uint32_t r = 0; r < COMPONENT.variable_count && *stop > s->t; r++) {
        s->slopes[r] = i->updated[r] ? (s->values[r] - before[r]) / (end - s->t) : 0.0;
        s->is_sloped |= s->slopes[r] != 0.0;
    }
    memcpy(s->values, before, sizeof before);
}

fmi2Status take_updated_step(Instance *i, double current, double h, int *switched, int *returned)
{
    Instance *c = i;
    ALLOWED("do_step", fmi2CoSimulation, IN(STEPPING));
    const fmi2Status status = check_step(i, current, h);
    if (status != fmi2OK)
        return status;
    const double end = current + h;
    const State before = i->s;
    double stop = end;
    memset(i->s.slopes, 0, sizeof i->s.slopes);
    i->s.is_sloped = 0;
    int parts = 0;
    do {
        const double aim = fmin(COMPONENT.part_end(i), stop);
        if (i->updates_inputs)
            ask(i, aim, &stop);
        if (stop <= i->s.t)
            break;
        const fmi2Status moved = parts++ < MOST_PARTS
                                     ? advance_to(i, fmin(aim, stop), switched)
                                     : refuse(i, fmi2Discard, "%s", needs_too_much(i, i->s.t));
        if (moved != fmi2OK) {
            i->s = before, i->s.free_until = -INFINITY;
            return i->s.last_step = fmi2Discard;
        }
        update(i, i->s.t, 0, &stop);
    } while (i->s.t < stop && !(switched && *switched));
    *returned = stop < end;
    return i->s.last_step = fmi2OK;
}
