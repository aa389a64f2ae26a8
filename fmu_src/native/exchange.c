/* Model exchange: the importer integrates, and stops at the zeros of the event indicators. */

#include <math.h>
#include <string.h>

#include "instance.h"

#define EXCHANGE_PHASES (IN(EVENTS) | IN(CONTINUOUS))

fmi2Status fmi2EnterEventMode(fmi2Component c)
{
    Instance *i = c;
    REQUIRE(i, "enter_event_mode", fmi2ModelExchange, EXCHANGE_PHASES);
    i->s.phase = EVENTS;
    return fmi2OK;
}

fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *info)
{
    Instance *i = c;
    REQUIRE(i, "new_discrete_states", fmi2ModelExchange, IN(EVENTS));
    if (!info)
        return report(i, fmi2Error, "a pointer to the result must be given");
    memset(info, 0, sizeof *info);
    /* At a switch the equations change, and states are set to their exact values there: the
       importer must restart its solver. */
    info->valuesOfContinuousStatesChanged = COMPONENT.update_mode(i) ? fmi2True : fmi2False;
    i->s.has_outputs = 0;
    return fmi2OK;
}

fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c)
{
    Instance *i = c;
    REQUIRE(i, "enter_continuous_time_mode", fmi2ModelExchange, IN(EVENTS));
    i->s.phase = CONTINUOUS;
    return fmi2OK;
}

fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean no_way_back,
                                       fmi2Boolean *enter_event_mode, fmi2Boolean *terminate)
{
    Instance *i = c;
    (void)no_way_back;
    REQUIRE(i, "completed_integrator_step", fmi2ModelExchange, IN(CONTINUOUS));
    if (!enter_event_mode || !terminate)
        return report(i, fmi2Error, "pointers to the results must be given");
    *enter_event_mode = *terminate = fmi2False;
    return !COMPONENT.complete_step || COMPONENT.complete_step(i) ? fmi2OK : fmi2Discard;
}

fmi2Status fmi2SetTime(fmi2Component c, fmi2Real time)
{
    Instance *i = c;
    REQUIRE(i, "set_time", fmi2ModelExchange, EXCHANGE_PHASES);
    if (!isfinite(time))
        return report(i, fmi2Error, "time = %g: must be a finite number of seconds", time);
    i->s.t = time, i->s.has_outputs = 0;
    return fmi2OK;
}

/* Refuse an array of states or indicators of a wrong length. */
static fmi2Status check_count(Instance *i, const void *numbers, size_t count, uint32_t expected)
{
    if (count == expected && (numbers || count == 0))
        return fmi2OK;
    return report(i, fmi2Error, "%zu numbers: must be %u", count, expected);
}

fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t count)
{
    Instance *i = c;
    REQUIRE(i, "set_continuous_states", fmi2ModelExchange, IN(CONTINUOUS));
    fmi2Status status = check_count(i, x, count, COMPONENT.state_count);
    for (size_t n = 0; n < count && status == fmi2OK; n++)
        if (!isfinite(x[n]))
            status = report(i, fmi2Discard, "%s = %g: must be a finite number",
                            COMPONENT.variables[COMPONENT.states[n]].name, x[n]);
    if (status != fmi2OK)
        return status;
    memcpy(i->s.states, x, count * sizeof *x);
    i->s.has_outputs = 0;
    return fmi2OK;
}

fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t count)
{
    Instance *i = c;
    REQUIRE(i, "get_continuous_states", fmi2ModelExchange, READABLE);
    fmi2Status status = check_count(i, x, count, COMPONENT.state_count);
    /* Begins the motion, if it has not begun: this sets the states. */
    status = status == fmi2OK ? update_outputs(i) : status;
    if (status == fmi2OK)
        memcpy(x, i->s.states, count * sizeof *x);
    return status;
}

fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real x[], size_t count)
{
    Instance *i = c;
    REQUIRE(i, "get_nominals_of_continuous_states", fmi2ModelExchange, IN(INSTANTIATED) | READABLE);
    fmi2Status status = check_count(i, x, count, COMPONENT.state_count);
    for (size_t n = 0; n < count && status == fmi2OK; n++)
        x[n] = COMPONENT.variables[COMPONENT.states[n]].nominal;
    return status;
}

fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real derivatives[], size_t count)
{
    Instance *i = c;
    REQUIRE(i, "get_derivatives", fmi2ModelExchange, READABLE);
    fmi2Status status = check_count(i, derivatives, count, COMPONENT.state_count);
    status = status == fmi2OK ? update_outputs(i) : status;
    for (size_t n = 0; n < count && status == fmi2OK; n++) {
        const uint32_t r = COMPONENT.derivatives[n];
        derivatives[n] = i->s.values[r];
        status = check_finite(i, COMPONENT.variables[r].name, derivatives[n]);
    }
    return status;
}

fmi2Status compute_indicators(Instance *i, double *indicators)
{
    fmi2Status status = update_outputs(i);
    if (status == fmi2OK)
        COMPONENT.event_indicators(i, indicators);
    for (size_t n = 0; n < COMPONENT.indicator_count && status == fmi2OK; n++)
        status = check_finite(i, "an event indicator", indicators[n]);
    return status;
}

fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real indicators[], size_t count)
{
    Instance *i = c;
    REQUIRE(i, "get_event_indicators", fmi2ModelExchange, READABLE);
    const fmi2Status status = check_count(i, indicators, count, COMPONENT.indicator_count);
    return status == fmi2OK ? compute_indicators(i, indicators) : status;
}
