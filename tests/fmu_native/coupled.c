/* A master in C: couples slider-belt and brake actuator with extrapolated inputs, as
   `examples/fmu_coupled.py` with `extrapolate`. Prints y and the derivatives of P by FMI 2.0 and 3.0.

   Arguments: library and GUID of each model, number of steps, end time in s. The value references
   SLIDER_F, SLIDER_P, SLIDER_Y, ACTUATOR_F and ACTUATOR_P are macros. */

#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>

#include "fmi2Functions.h"
#include "fmi3FunctionTypes.h"

typedef struct {
    void *library;
    fmi2Component c;
} Model;

static void require(int holds, const char *text)
{
    if (holds)
        return;
    fprintf(stderr, "failed: %s\n", text);
    exit(1);
}

/* Call a function of a model's library, which must succeed: return 0. */
#define CALL(model, name, ...)                                                             \
    require(((name##TYPE *)dlsym((model)->library, #name))((model)->c, __VA_ARGS__) == 0, #name)

static void log_message(void *host, fmi2String name, fmi2Status status, fmi2String category,
                        fmi2String message, ...)
{
    (void)host, (void)name, (void)status, (void)category;
    fprintf(stderr, "%s\n", message);
}

static Model start(const char *path, const char *guid)
{
    static const fmi2CallbackFunctions callbacks = {log_message, NULL, NULL, NULL, NULL};
    Model model = {.library = dlopen(path, RTLD_NOW | RTLD_LOCAL)};
    require(model.library != NULL, path);
    fmi2InstantiateTYPE *make = (fmi2InstantiateTYPE *)dlsym(model.library, "fmi2Instantiate");
    model.c = make("m", fmi2CoSimulation, guid, NULL, &callbacks, 0, 0);
    CALL(&model, fmi2SetupExperiment, 0, 0.0, 0.0, 0, 0.0);
    require(((fmi2EnterInitializationModeTYPE *)dlsym(model.library, "fmi2EnterInitializationMode"))(model.c)
            == fmi2OK, "fmi2EnterInitializationMode");
    require(((fmi2ExitInitializationModeTYPE *)dlsym(model.library, "fmi2ExitInitializationMode"))(model.c)
            == fmi2OK, "fmi2ExitInitializationMode");
    return model;
}

static const fmi2Integer FIRST_ORDER = 1;

static double slope_of(const Model *source, fmi2ValueReference output)
{
    double slope;
    CALL(source, fmi2GetRealOutputDerivatives, &output, 1, &FIRST_ORDER, &slope);
    return slope;
}

static void set_slope(const Model *target, fmi2ValueReference input, double slope)
{
    CALL(target, fmi2SetRealInputDerivatives, &input, 1, &FIRST_ORDER, &slope);
}

int main(int count, char **arguments)
{
    require(count == 7, "six arguments");
    const Model slider = start(arguments[1], arguments[2]), actuator = start(arguments[3], arguments[4]);
    const int steps = atoi(arguments[5]);
    const double h = atof(arguments[6]) / steps;
    const fmi2ValueReference force = SLIDER_P, preload = ACTUATOR_F, height = SLIDER_Y;
    double P, F, y;
    for (int step = 0; step < steps; step++) {
        CALL(&slider, fmi2GetReal, &force, 1, &P);
        CALL(&actuator, fmi2GetReal, &preload, 1, &F);
        /* A slope is that of the motion under the inputs of the next step: set these first. */
        const fmi2ValueReference slider_input = SLIDER_F, actuator_input = ACTUATOR_P;
        CALL(&slider, fmi2SetReal, &slider_input, 1, &F);
        CALL(&actuator, fmi2SetReal, &actuator_input, 1, &P);
        const double F_slope = slope_of(&actuator, preload), P_slope = slope_of(&slider, force);
        set_slope(&slider, slider_input, F_slope), set_slope(&actuator, actuator_input, P_slope);
        CALL(&slider, fmi2DoStep, step * h, h, 1);
        CALL(&actuator, fmi2DoStep, step * h, h, 1);
    }
    CALL(&slider, fmi2GetReal, &height, 1, &y);
    /* In this FMU both versions of FMI have the same type of instance. */
    const fmi2ValueReference forces[3] = {force, force, force};
    const int orders[3] = {1, 2, 3};
    double rates[3], rates_3[3];
    CALL(&slider, fmi2GetRealOutputDerivatives, forces, 3, orders, rates);
    CALL(&slider, fmi3GetOutputDerivatives, forces, 3, orders, rates_3, 3);
    printf("%a\n", y);
    for (int n = 0; n < 3; n++)
        printf("%a %a\n", rates[n], rates_3[n]);
    return 0;
}
