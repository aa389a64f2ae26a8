/* Exact directional derivatives of unknowns with respect to knowns, at the current time and in the
   current mode. Unknowns are all Real variables that cannot be set: outputs, states and state
   derivatives. Knowns are inputs, Real parameters and states. In initialization mode states are not
   known: their initial values depend on inputs and parameters. `changes` has the change of each
   variable, by value reference. */

#include <math.h>

#include "instance.h"

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

/* Refuse references without derivatives, and bring outputs up to date. */
static fmi2Status check_references(Instance *i, const fmi2ValueReference unknowns[],
                                   size_t unknown_count, const fmi2ValueReference knowns[],
                                   size_t known_count)
{
    for (size_t n = 0; n < unknown_count; n++)
        if (!is_unknown(unknowns[n]))
            return report(i, fmi2Error,
                          "value reference %u: must be that of an output or derivative",
                          unknowns[n]);
    for (size_t n = 0; n < known_count; n++)
        if (!is_known(i, knowns[n]))
            return report(i, fmi2Error, "value reference %u: must be that of %s", knowns[n],
                          i->s.phase == INITIALIZATION ? "an input or Real parameter"
                                                       : "an input, state or Real parameter");
    return update_totals(i);
}

static fmi2Status check_seeds(Instance *i, const fmi2ValueReference r[], size_t count,
                              const fmi2Real seeds[])
{
    for (size_t n = 0; n < count; n++)
        if (!isfinite(seeds[n]))
            return report(i, fmi2Discard, "seed of %s = %s: must be a finite number",
                          COMPONENT.variables[r[n]].name, format_number(seeds[n]).text);
    return fmi2OK;
}

/* Compute the changes of all other variables from those of the knowns. */
static void propagate(const Instance *i, double *changes)
{
    if (i->s.phase == INITIALIZATION)
        COMPONENT.differentiate_start(i, changes);
    COMPONENT.differentiate(i, changes);
}

static fmi2Status check_derivative(Instance *i, fmi2ValueReference r, double value)
{
    if (isfinite(value))
        return fmi2OK;
    return report(i, fmi2Discard, "the derivative of %s is not a finite number",
                  COMPONENT.variables[r].name);
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknowns[],
                                        size_t unknown_count, const fmi2ValueReference knowns[],
                                        size_t known_count, const fmi2Real seeds[],
                                        fmi2Real result[])
{
    Instance *i = c;
    double changes[MAX_VARIABLES] = {0.0};
    REQUIRE(i, "get_directional_derivative", ANY_TYPE, READABLE);
    if ((unknown_count > 0 && (!unknowns || !result)) || (known_count > 0 && (!knowns || !seeds)))
        return report(i, fmi2Error, "value references and values must be given");
    fmi2Status status = check_references(i, unknowns, unknown_count, knowns, known_count);
    status = status == fmi2OK ? check_seeds(i, knowns, known_count, seeds) : status;
    if (status != fmi2OK)
        return status;
    for (size_t n = 0; n < known_count; n++)
        changes[knowns[n]] += seeds[n];
    propagate(i, changes);
    for (size_t n = 0; n < unknown_count && status == fmi2OK; n++)
        status = check_derivative(i, unknowns[n], changes[unknowns[n]]);
    for (size_t n = 0; n < unknown_count && status == fmi2OK; n++)
        result[n] = changes[unknowns[n]];
    return status;
}

fmi2Status get_adjoint_derivative(Instance *c, const fmi2ValueReference unknowns[],
                                  size_t unknown_count, const fmi2ValueReference knowns[],
                                  size_t known_count, const fmi2Real seeds[], fmi2Real result[])
{
    Instance *i = c;
    double sums[MAX_VARIABLES];
    REQUIRE(i, "get_adjoint_derivative", ANY_TYPE, READABLE);
    if ((unknown_count > 0 && (!unknowns || !seeds)) || (known_count > 0 && (!knowns || !result)))
        return report(i, fmi2Error, "value references and values must be given");
    fmi2Status status = check_references(i, unknowns, unknown_count, knowns, known_count);
    status = status == fmi2OK ? check_seeds(i, unknowns, unknown_count, seeds) : status;
    for (size_t k = 0; k < known_count && status == fmi2OK; k++) {
        double changes[MAX_VARIABLES] = {0.0}, sum = 0.0;
        changes[knowns[k]] = 1.0;
        propagate(i, changes);
        for (size_t n = 0; n < unknown_count && status == fmi2OK; n++) {
            sum += seeds[n] * changes[unknowns[n]];
            status = check_derivative(i, unknowns[n], sum);
        }
        sums[knowns[k]] = sum;
    }
    for (size_t k = 0; k < known_count && status == fmi2OK; k++)
        result[k] = sums[knowns[k]];
    return status;
}
