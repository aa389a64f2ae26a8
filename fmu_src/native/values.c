/* Read and set values of variables, in the phases that allow it.

   `r` are value references: indices in `COMPONENT.variables`. */

#include <math.h>
#include <string.h>

#include "instance.h"

fmi2Status check_readable(Instance *i)
{
    if (i->s.phase == INTERMEDIATE && i->wants_inputs)
        return report(i, fmi2Error, "values cannot be read while an update asks for inputs");
    return fmi2OK;
}

fmi2Status check_finite(Instance *i, const char *name, double value)
{
    if (isfinite(value))
        return fmi2OK;
    return report(i, fmi2Discard, "%s grows beyond the floating-point range", name);
}

/* Check a call that reads values and compute the outputs. Any variable can be read as any type,
   because some importers read all as Real. */
static fmi2Status prepare_reading(Instance *i, const fmi2ValueReference *references, size_t count,
                                  const void *values)
{
    if (!i)
        return fmi2Error;
    if (count > 0 && (!references || !values))
        return report(i, fmi2Error, "value references and values must be given");
    int has_totals = 0;
    for (size_t n = 0; n < count; n++) {
        if (references[n] >= COMPONENT.variable_count)
            return report(i, fmi2Error, "value reference %u: there is no such variable",
                          references[n]);
        has_totals |= COMPONENT.variables[references[n]].is_total;
    }
    const fmi2Status status = check_readable(i);
    if (status != fmi2OK)
        return status;
    return has_totals ? update_totals(i) : update_outputs(i);
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference r[], size_t count,
                       fmi2Real values[])
{
    Instance *i = c;
    fmi2Status status = prepare_reading(i, r, count, values);
    for (size_t n = 0; n < count && status == fmi2OK; n++)
        status = check_finite(i, COMPONENT.variables[r[n]].name, i->s.values[r[n]]);
    /* After a failure all values are NaN, also for an importer that ignores the status. */
    for (size_t n = 0; n < count && values; n++)
        values[n] = status == fmi2OK ? i->s.values[r[n]] : NAN;
    return status;
}

fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference r[], size_t count,
                          fmi2Integer values[])
{
    Instance *i = c;
    fmi2Status status = prepare_reading(i, r, count, values);
    for (size_t n = 0; n < count && status == fmi2OK; n++)
        values[n] = (fmi2Integer)fmin(fmax(i->s.values[r[n]], -0x1p31), 0x1p31 - 1.0);
    return status;
}

fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference r[], size_t count,
                          fmi2Boolean values[])
{
    Instance *i = c;
    fmi2Status status = prepare_reading(i, r, count, values);
    for (size_t n = 0; n < count && status == fmi2OK; n++)
        values[n] = i->s.values[r[n]] != 0.0;
    return status;
}

fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference r[], size_t count,
                         fmi2String values[])
{
    (void)r, (void)values;
    if (!c)
        return fmi2Error;
    return count == 0 ? fmi2OK : report(c, fmi2Error, "no variable is of type String");
}

static const char *const KIND_NAMES[] = {"Real", "Integer", "Boolean"};

/* Check whether a value can be set now; log a refusal. */
static fmi2Status check_settable(Instance *i, fmi2ValueReference reference, Kind kind, double value)
{
    if (reference >= COMPONENT.variable_count)
        return report(i, fmi2Error, "value reference %u: must be from 0 to %u", reference,
                      COMPONENT.variable_count - 1);
    const Variable *v = COMPONENT.variables + reference;
    const Phase phase = i->s.phase;
    if (!is_settable(v))
        return report(i, fmi2Error, "%s is an output and cannot be set", v->name);
    if (v->kind != kind)
        return report(i, fmi2Error, "%s is of type %s, not %s", v->name, KIND_NAMES[v->kind],
                      KIND_NAMES[kind]);
    const int is_initial = phase == INSTANTIATED || phase == INITIALIZATION;
    /* FMI allows changes of tunable parameters in event mode, and between steps without one. */
    const int may_tune = v->role == TUNABLE
                         && (phase == EVENTS || (phase == STEPPING && !i->uses_events));
    const int is_fixed = v->role < INPUT && !is_initial && !may_tune;
    const int may_update =
        phase != INTERMEDIATE || (i->wants_inputs && i->is_updated[reference]);
    if (is_fixed || phase == TERMINATED || !may_update)
        return report(i, fmi2Error, "%s cannot be set %s", v->name, phase_name(i));
    if (kind != REAL)
        return fmi2OK;
    if (!isfinite(value))
        return report(i, fmi2Discard, "%s = %s: not a finite number; must be %s", v->name,
                      isnan(value) ? "nan" : value > 0.0 ? "inf" : "-inf", v->allowed);
    if (value > v->upper || value < v->lower)
        return report(i, fmi2Discard, "%s = %g: must be %s", v->name, value, v->allowed);
    return fmi2OK;
}

/* Set all values or none, from `reals` or `integers`; the other one is NULL. */
static fmi2Status set_values(Instance *i, const fmi2ValueReference *r, size_t count, Kind kind,
                             const fmi2Real *reals, const int *integers)
{
    if (!i)
        return fmi2Error;
    if (count > 0 && (!r || (!reals && !integers)))
        return report(i, fmi2Error, "value references and values must be given");
    fmi2Status worst = fmi2OK;
    for (size_t n = 0; n < count; n++) {
        fmi2Status status = check_settable(i, r[n], kind, reals ? reals[n] : integers[n]);
        worst = status > worst ? status : worst;
    }
    if (worst != fmi2OK)
        return worst;
    State *s = &i->s;
    const int is_initial = s->phase == INSTANTIATED || s->phase == INITIALIZATION;
    double values[MAX_VARIABLES];
    memcpy(values, s->values, sizeof values);
    for (size_t n = 0; n < count; n++)
        values[r[n]] = reals ? reals[n] : kind == BOOLEAN ? integers[n] != 0 : integers[n];
    const char *reason =
        COMPONENT.check_values && !is_initial ? COMPONENT.check_values(i, values) : NULL;
    if (reason)
        return report(i, fmi2Discard, "%s", reason);
    for (size_t n = 0; n < count; n++) {
        if (s->values[r[n]] == values[r[n]])
            continue;
        s->values[r[n]] = values[r[n]];
        /* The motion that is computed already, under the old inputs, no longer holds. */
        s->has_outputs = s->has_inputs_of_step = 0, s->fast_until = -INFINITY;
        /* Let the motion begin anew with the new initial values. */
        if (is_initial)
            s->has_motion = 0;
    }
    return fmi2OK;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference r[], size_t count,
                       const fmi2Real values[])
{
    return set_values(c, r, count, REAL, values, NULL);
}

fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference r[], size_t count,
                          const fmi2Integer values[])
{
    return set_values(c, r, count, INTEGER, NULL, values);
}

fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference r[], size_t count,
                          const fmi2Boolean values[])
{
    return set_values(c, r, count, BOOLEAN, NULL, values);
}

fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference r[], size_t count,
                         const fmi2String values[])
{
    (void)r, (void)values;
    if (!c)
        return fmi2Error;
    return count == 0 ? fmi2OK : report(c, fmi2Error, "no variable is of type String");
}
