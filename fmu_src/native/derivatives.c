/* Directional derivatives, exact: how outputs and derivatives of states change with inputs, states
   and parameters at the instant reached, at constant mode. In initialization mode they are those of
   the initial values, which follow from inputs and parameters alone: states change with these. */

#include <math.h>

#include "instance.h"

#define READABLE (IN(INITIALIZATION) | IN(STEPPING) | IN(EVENTS) | IN(CONTINUOUS) | IN(TERMINATED))

static int is_known(const Instance *i, uint32_t reference)
{
    if (reference >= COMPONENT.variable_count || COMPONENT.variables[reference].kind != REAL)
        return 0;
    if (is_settable(COMPONENT.variables + reference))
        return 1;
    for (uint32_t n = 0; n < COMPONENT.state_count && i->s.phase != INITIALIZATION; n++)
        if (COMPONENT.states[n] == reference)
            return 1;
    return 0;
}

static int is_unknown(uint32_t reference)
{
    return reference < COMPONENT.variable_count && COMPONENT.variables[reference].kind == REAL
           && !is_settable(COMPONENT.variables + reference);
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknowns[],
                                        size_t unknown_count, const fmi2ValueReference knowns[],
                                        size_t known_count, const fmi2Real given[],
                                        fmi2Real result[])
{
    Instance *i = c;
    double changes[MOST_VARIABLES] = {0.0};
    ALLOWED("get_directional_derivative", EITHER, READABLE);
    if ((unknown_count > 0 && (!unknowns || !result)) || (known_count > 0 && (!knowns || !given)))
        return refuse(i, fmi2Error, "value references and values must be given");
    const int initial = i->s.phase == INITIALIZATION;
    for (size_t n = 0; n < unknown_count; n++)
        if (!is_unknown(unknowns[n]))
            return refuse(i, fmi2Error,
                          "value reference %u: must be that of an output or derivative",
                          unknowns[n]);
    for (size_t n = 0; n < known_count; n++) {
        if (!is_known(i, knowns[n]))
            return refuse(i, fmi2Error, "value reference %u: must be that of %s", knowns[n],
                          initial ? "an input or Real parameter"
                                  : "an input, state or Real parameter");
        changes[knowns[n]] += given[n];
    }
    fmi2Status status = ready(i);
    if (status != fmi2OK)
        return status;
    if (initial)
        COMPONENT.differentiate_start(i, changes);
    COMPONENT.differentiate(i, changes);
    for (size_t n = 0; n < unknown_count; n++)
        if (!isfinite(changes[unknowns[n]]))
            return refuse(i, fmi2Discard, "the derivative of %s is no finite number",
                          COMPONENT.variables[unknowns[n]].name);
    for (size_t n = 0; n < unknown_count; n++)
        result[n] = changes[unknowns[n]];
    return fmi2OK;
}
