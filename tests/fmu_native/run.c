/* Runs the base scene over 100 s in steps of 10 ms, by both versions of FMI, in a program that the
   FMU is linked to; prints the state at the end, and the switches that were announced. */

#include <stdio.h>
#include <stdlib.h>

#include "build.h"
#include "fmi2Functions.h"
#include "fmi3Functions.h"

#define DO(call) ((int)(call) > 1 ? exit((fprintf(stderr, "%s\n", #call), 1)) : (void)0)
enum { STEPS = 10000, STATES = 4 };
static const unsigned OUTPUTS[STATES] = {15, 16, 17, 18};

static void tell(void *host, fmi2String name, fmi2Status status, fmi2String category,
                 fmi2String message, ...)
{
    (void)host, (void)name, (void)status, (void)category;
    fprintf(stderr, "%s\n", message);
}

static void tell_3(void *host, fmi3Status status, fmi3String category, fmi3String message)
{
    (void)host, (void)status, (void)category;
    fprintf(stderr, "%s\n", message);
}

static void print(const double *state)
{
    for (int n = 0; n < STATES; n++)
        printf("%a ", state[n]);
}

int main(void)
{
    static const fmi2CallbackFunctions callbacks = {tell, NULL, NULL, NULL, NULL};
    double state[STATES], t = 0.0;
    fmi2Component c =
        fmi2Instantiate("belt", fmi2CoSimulation, SLIDER_BELT_GUID, NULL, &callbacks, 0, 0);
    DO(fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0));
    DO(fmi2EnterInitializationMode(c));
    DO(fmi2ExitInitializationMode(c));
    for (int step = 0; step < STEPS; step++)
        DO(fmi2DoStep(c, step * 0.01, 0.01, 1));
    DO(fmi2GetReal(c, OUTPUTS, STATES, state));
    print(state);
    fmi2FreeInstance(c);

    int switches = 0;
    fmi3Boolean event, stops, early, more;
    fmi3Instance i = fmi3InstantiateCoSimulation("belt", SLIDER_BELT_GUID, NULL, 0, 0, 1, 1, NULL, 0,
                                                 NULL, tell_3, NULL);
    DO(fmi3EnterInitializationMode(i, 0, 0.0, 0.0, 0, 0.0));
    DO(fmi3ExitInitializationMode(i));
    DO(fmi3EnterStepMode(i));
    for (double end = (STEPS - 1) * 0.01 + 0.01; t < end;) {
        DO(fmi3DoStep(i, t, end - t < 1.0 ? end - t : 1.0, 1, &event, &stops, &early, &t));
        if (!event)
            continue;
        double next;
        switches++;
        DO(fmi3EnterEventMode(i));
        DO(fmi3UpdateDiscreteStates(i, &more, &stops, &early, &event, &event, &next));
        DO(fmi3EnterStepMode(i));
    }
    DO(fmi3GetFloat64(i, OUTPUTS, STATES, state, STATES));
    print(state);
    fmi3FreeInstance(i);
    printf("%d\n", switches);
    return 0;
}
