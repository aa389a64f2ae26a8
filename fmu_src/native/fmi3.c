/* FMI 3.0: instances, modes, steps and states, by the functions of FMI 2.0 where both agree.

   A switch is the end of a mode of the motion, such as contact. If the importer uses event mode and
   allows early return, a co-simulation step ends at every switch; the outputs for the mode of the
   motion and the counts of switches change when the importer then enters event mode. Otherwise
   steps continue over switches. Both give the same motion. */

#include <math.h>

#include "instance.h"

/* Return with a failure unless the importer passed the pointers to results. */
#define REQUIRE_POINTERS(given)                                                           \
    do {                                                                                  \
        if (!(given))                                                                     \
            return (fmi3Status)report(i, fmi2Error, "pointers to results must be given");  \
    } while (0)
/* `REQUIRE` for a function of FMI 3.0. */
#define REQUIRE3(instance, call, type, phases)                           \
    do {                                                                 \
        fmi2Status status_ = check_call(instance, call, type, phases);   \
        if (status_ != fmi2OK)                                           \
            return (fmi3Status)status_;                                  \
    } while (0)

/* A function of FMI 3.0, with its parameters, that passes the arguments after them to one of
   FMI 2.0. */
#define SAME(name, name_2, parameters, ...) \
    fmi3Status name parameters { return (fmi3Status)name_2(__VA_ARGS__); }

const char *fmi3GetVersion(void) { return fmi3Version; }

fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources,
                                          fmi3Boolean visible, fmi3Boolean logging,
                                          fmi3InstanceEnvironment environment,
                                          fmi3LogMessageCallback log)
{
    (void)resources, (void)visible, (void)logging;
    const Instance settings = {.type = fmi2ModelExchange, .log = log, .environment = environment};
    return make_instance(&settings, name, token);
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources,
                                         fmi3Boolean visible, fmi3Boolean logging,
                                         fmi3Boolean event_mode, fmi3Boolean early_return,
                                         const fmi3ValueReference intermediate[], size_t count,
                                         fmi3InstanceEnvironment environment,
                                         fmi3LogMessageCallback log,
                                         fmi3IntermediateUpdateCallback update)
{
    (void)resources, (void)visible, (void)logging;
    const Instance settings = {.type = fmi2CoSimulation, .log = log, .environment = environment,
                           .uses_events = event_mode, .returns_early = early_return,
                           .stops_at_switches = event_mode && early_return, .update = update};
    Instance *i = make_instance(&settings, name, token);
    if (i && !register_updates(i, intermediate, count)) {
        fmi2FreeInstance(i);
        return NULL;
    }
    return i;
}

fmi3Instance fmi3InstantiateScheduledExecution(fmi3String name, fmi3String token,
                                               fmi3String resources, fmi3Boolean visible,
                                               fmi3Boolean logging,
                                               fmi3InstanceEnvironment environment,
                                               fmi3LogMessageCallback log,
                                               fmi3ClockUpdateCallback update,
                                               fmi3LockPreemptionCallback lock,
                                               fmi3UnlockPreemptionCallback unlock)
{
    (void)name, (void)token, (void)resources, (void)visible, (void)logging;
    (void)update, (void)lock, (void)unlock;
    if (log)
        log(environment, fmi3Error, "logStatusError", "there is no scheduled execution");
    return NULL;
}

void fmi3FreeInstance(fmi3Instance c) { fmi2FreeInstance(c); }

SAME(fmi3SetDebugLogging, fmi2SetDebugLogging,
     (fmi3Instance c, fmi3Boolean on, size_t count, const fmi3String categories[]),
     c, on, count, categories)

fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean with_tolerance,
                                       fmi3Float64 tolerance, fmi3Float64 start,
                                       fmi3Boolean with_stop, fmi3Float64 stop)
{
    const fmi2Status status =
        fmi2SetupExperiment(c, with_tolerance, tolerance, start, with_stop, stop);
    if (status > fmi2Warning)
        return (fmi3Status)status;
    const fmi2Status entered = fmi2EnterInitializationMode(c);
    return (fmi3Status)(entered == fmi2OK ? status : entered);
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance c)
{
    Instance *i = c;
    const fmi2Status status = fmi2ExitInitializationMode(c);
    if (status == fmi2OK && i->uses_events)
        i->s.phase = EVENTS;
    return (fmi3Status)status;
}

fmi3Status fmi3EnterEventMode(fmi3Instance c)
{
    Instance *i = c;
    REQUIRE3(i, "enter_event_mode", ANY_TYPE, IN(STEPPING) | IN(CONTINUOUS));
    if (i->type == fmi2ModelExchange)
        return (fmi3Status)fmi2EnterEventMode(c);
    if (!i->uses_events)
        return (fmi3Status)report(i, fmi2Error, "enter_event_mode: the instance was created "
                                                "without event mode");
    /* Compute the outputs again: without a pending switch, mode and counts are those after it. The
       next step is not a fast one: it checks the phase. */
    i->s.phase = EVENTS, i->s.switch_pending = i->s.has_outputs = 0, i->s.fast_until = -INFINITY;
    return (fmi3Status)update_outputs(i);
}

fmi3Status fmi3EnterStepMode(fmi3Instance c)
{
    Instance *i = c;
    REQUIRE3(i, "enter_step_mode", fmi2CoSimulation, IN(EVENTS));
    i->s.phase = STEPPING;
    return fmi3OK;
}

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance c, fmi3Boolean *more, fmi3Boolean *terminate,
                                    fmi3Boolean *nominals, fmi3Boolean *values,
                                    fmi3Boolean *with_time, fmi3Float64 *time)
{
    Instance *i = c;
    REQUIRE3(i, "update_discrete_states", ANY_TYPE, IN(EVENTS));
    REQUIRE_POINTERS(more && terminate && nominals && values && with_time && time);
    fmi2EventInfo info = {0};
    if (i->type == fmi2ModelExchange)
        fmi2NewDiscreteStates(c, &info);
    *more = *terminate = *nominals = *with_time = fmi3False;
    *values = info.valuesOfContinuousStatesChanged;
    *time = 0.0;
    return fmi3OK;
}

fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance c)
{
    Instance *i = c;
    REQUIRE3(i, "evaluate_discrete_states", ANY_TYPE, IN(EVENTS));
    return fmi3OK;
}

fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 current, fmi3Float64 h, fmi3Boolean no_way_back,
                      fmi3Boolean *event, fmi3Boolean *terminate, fmi3Boolean *early,
                      fmi3Float64 *reached)
{
    Instance *i = c;
    (void)no_way_back;
    if (!i)
        return fmi3Error;
    REQUIRE_POINTERS(event && terminate && early && reached);
    int switched = 0, returned_early = 0;
    int *stop_at_switch = i->stops_at_switches ? &switched : NULL;
    const fmi2Status status =
        i->update ? do_step_with_updates(i, current, h, stop_at_switch, &returned_early)
                  : do_communication_step(i, current, h, stop_at_switch);
    *reached = i->s.t, *event = switched != 0, *terminate = fmi3False;
    *early = (switched || returned_early) && *reached < current + h;
    return (fmi3Status)status;
}

SAME(fmi3Terminate, fmi2Terminate, (fmi3Instance c), c)
SAME(fmi3Reset, fmi2Reset, (fmi3Instance c), c)
SAME(fmi3EnterContinuousTimeMode, fmi2EnterContinuousTimeMode, (fmi3Instance c), c)

fmi3Status fmi3CompletedIntegratorStep(fmi3Instance c, fmi3Boolean no_way_back, fmi3Boolean *event,
                                       fmi3Boolean *terminate)
{
    Instance *i = c;
    fmi2Boolean enter_event_mode = fmi2False, terminate_run = fmi2False;
    if (!i)
        return fmi3Error;
    REQUIRE_POINTERS(event && terminate);
    const fmi2Status status =
        fmi2CompletedIntegratorStep(c, no_way_back, &enter_event_mode, &terminate_run);
    *event = enter_event_mode != 0, *terminate = terminate_run != 0;
    return (fmi3Status)status;
}

SAME(fmi3SetTime, fmi2SetTime, (fmi3Instance c, fmi3Float64 t), c, t)
SAME(fmi3SetContinuousStates, fmi2SetContinuousStates,
     (fmi3Instance c, const fmi3Float64 x[], size_t count), c, x, count)
SAME(fmi3GetContinuousStates, fmi2GetContinuousStates,
     (fmi3Instance c, fmi3Float64 x[], size_t count), c, x, count)
SAME(fmi3GetNominalsOfContinuousStates, fmi2GetNominalsOfContinuousStates,
     (fmi3Instance c, fmi3Float64 x[], size_t count), c, x, count)
SAME(fmi3GetContinuousStateDerivatives, fmi2GetDerivatives,
     (fmi3Instance c, fmi3Float64 rates[], size_t count), c, rates, count)
SAME(fmi3GetEventIndicators, fmi2GetEventIndicators,
     (fmi3Instance c, fmi3Float64 indicators[], size_t count), c, indicators, count)

fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance c, size_t *count)
{
    Instance *i = c;
    REQUIRE3(i, "get_number_of_event_indicators", fmi2ModelExchange, ~0u);
    REQUIRE_POINTERS(count);
    *count = COMPONENT.indicator_count;
    return fmi3OK;
}

fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance c, size_t *count)
{
    Instance *i = c;
    REQUIRE3(i, "get_number_of_continuous_states", fmi2ModelExchange, ~0u);
    REQUIRE_POINTERS(count);
    *count = COMPONENT.state_count;
    return fmi3OK;
}

SAME(fmi3GetFMUState, fmi2GetFMUstate, (fmi3Instance c, fmi3FMUState *state), c, state)
SAME(fmi3SetFMUState, fmi2SetFMUstate, (fmi3Instance c, fmi3FMUState state), c, state)
SAME(fmi3FreeFMUState, fmi2FreeFMUstate, (fmi3Instance c, fmi3FMUState *state), c, state)
SAME(fmi3SerializedFMUStateSize, fmi2SerializedFMUstateSize,
     (fmi3Instance c, fmi3FMUState state, size_t *size), c, state, size)
SAME(fmi3SerializeFMUState, fmi2SerializeFMUstate,
     (fmi3Instance c, fmi3FMUState state, fmi3Byte bytes[], size_t size),
     c, state, (fmi2Byte *)bytes, size)
SAME(fmi3DeserializeFMUState, fmi2DeSerializeFMUstate,
     (fmi3Instance c, const fmi3Byte bytes[], size_t size, fmi3FMUState *state),
     c, (const fmi2Byte *)bytes, size, state)
