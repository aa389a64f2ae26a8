/* Times an FMU: HOST LIBRARY GUID RESOURCES STEP COUNT prints ns of a step, ns of a step and five
   outputs, and µs of an instance; CPU time. */

#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "fmi2FunctionTypes.h"

#define FMI(name) fmi2##name##TYPE *name = (fmi2##name##TYPE *)dlsym(library, "fmi2" #name)
#define DO(call) ((call) > fmi2Warning ? exit((fprintf(stderr, "%s\n", #call), 1)) : (void)0)

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void quiet(void *host, const char *name, fmi2Status status, const char *category,
                  const char *message, ...)
{
    (void)host, (void)name, (void)status, (void)category, (void)message;
}

int main(int argc, char **arguments)
{
    if (argc != 6)
        return 1;
    void *library = dlopen(arguments[1], RTLD_NOW | RTLD_LOCAL);
    if (!library)
        exit((fprintf(stderr, "%s\n", dlerror()), 1));
    FMI(Instantiate);
    FMI(FreeInstance);
    FMI(SetupExperiment);
    FMI(EnterInitializationMode);
    FMI(ExitInitializationMode);
    FMI(DoStep);
    FMI(GetReal);
    const fmi2CallbackFunctions callbacks = {quiet, calloc, free, NULL, NULL};
    const fmi2ValueReference outputs[5] = {15, 16, 17, 18, 19};
    const double h = atof(arguments[4]);
    const int count = atoi(arguments[5]);
    double values[5], begin = now();
    fmi2Component c = Instantiate("timed", fmi2CoSimulation, arguments[2], arguments[3], &callbacks,
                                  fmi2False, fmi2False);
    const double made = now() - begin;
    if (!c)
        exit((fprintf(stderr, "no instance\n"), 1));
    DO(SetupExperiment(c, fmi2False, 0.0, 0.0, fmi2False, 0.0));
    DO(EnterInitializationMode(c));
    DO(ExitInitializationMode(c));
    double spent[2];
    for (int reading = 0; reading < 2; reading++) {
        begin = now();
        for (int n = reading * count; n < (reading + 1) * count; n++) {
            DO(DoStep(c, n * h, h, fmi2True));
            if (reading)
                DO(GetReal(c, outputs, 5, values));
        }
        spent[reading] = now() - begin;
    }
    printf("%.17g %.17g %.17g\n", 1e9 * spent[0] / count, 1e9 * spent[1] / count, 1e6 * made);
    FreeInstance(c);
    return 0;
}
