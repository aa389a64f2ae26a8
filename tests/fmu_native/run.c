/* Runs the base scene over 100 s by FMI 2.0 in steps of 10 ms, then by FMI 3.0 with events. The FMU is
   linked to this program. Prints the final state of each run and the number of announced switches. */

#include <stdio.h>
#include <stdlib.h>

#include "build.h"
#include "fmi2Functions.h"
#include "fmi3Functions.h"
#include "slider_belt_table.h"

/* Exit unless the call returns success or a warning. */
#define REQUIRE_OK(call)                    \
    do {                                    \
        if ((int)(call) > fmi2Warning) {    \
            fprintf(stderr, "%s\n", #call); \
            exit(1);                        \
        }                                   \
    } while (0)
enum { STEPS = 10000, STATES = 4 };
static const unsigned OUTPUTS[STATES] = {V_x, V_vx, V_y, V_vy};

static void log_message(void *host, fmi2String name, fmi2Status status, fmi2String category,
                 fmi2String message, ...)
{
    (void)host, (void)name, (void)status, (void)category;
    fprintf(stderr, "%s\n", message);
}

static void log_message_3(void *host, fmi3Status status, fmi3String category, fmi3String message)
{
    (void)host, (void)status, (void)category;
    fprintf(stderr, "%s\n", message);
}

static void print_state(const double *state)
{
    for (int n = 0; n < STATES; n++)
        printf("%a ", state[n]);
}

int main(void)
{
    static const fmi2CallbackFunctions callbacks = {log_message, NULL, NULL, NULL, NULL};
    double state[STATES], t = 0.0;
    fmi2Component c =
        fmi2Instantiate("belt", fmi2CoSimulation, SLIDER_BELT_GUID, NULL, &callbacks, 0, 0);
    REQUIRE_OK(fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0));
    REQUIRE_OK(fmi2EnterInitializationMode(c));
    REQUIRE_OK(fmi2ExitInitializationMode(c));
    for (int step = 0; step < STEPS; step++)
        REQUIRE_OK(fmi2DoStep(c, step * 0.01, 0.01, 1));
    REQUIRE_OK(fmi2GetReal(c, OUTPUTS, STATES, state));
    print_state(state);
    fmi2FreeInstance(c);

    int switches = 0;
    fmi3Boolean event, stops, early, more;
    fmi3Instance i = fmi3InstantiateCoSimulation("belt", SLIDER_BELT_GUID, NULL, 0, 0, 1, 1, NULL, 0,
                                                 NULL, log_message_3, NULL);
    REQUIRE_OK(fmi3EnterInitializationMode(i, 0, 0.0, 0.0, 0, 0.0));
    REQUIRE_OK(fmi3ExitInitializationMode(i));
    REQUIRE_OK(fmi3EnterStepMode(i));
    /* The end of the last step above, rounded alike. */
    const double end = (STEPS - 1) * 0.01 + 0.01;
    while (t < end) {
        REQUIRE_OK(fmi3DoStep(i, t, end - t < 1.0 ? end - t : 1.0, 1, &event, &stops, &early, &t));
        if (!event)
            continue;
        double next;
        switches++;
        REQUIRE_OK(fmi3EnterEventMode(i));
        REQUIRE_OK(fmi3UpdateDiscreteStates(i, &more, &stops, &early, &event, &event, &next));
        REQUIRE_OK(fmi3EnterStepMode(i));
    }
    REQUIRE_OK(fmi3GetFloat64(i, OUTPUTS, STATES, state, STATES));
    print_state(state);
    fmi3FreeInstance(i);
    printf("%d\n", switches);
    return 0;
}
