/* A host that prints CPU times of an FMU: of a step, ns, of a step and reading five outputs, ns, and
   of creating an instance, µs.

   Arguments: library, GUID, URI of the resources, length of a step, s, and number of steps. */

#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "fmi2FunctionTypes.h"

#define FMI(name) fmi2##name##TYPE *name = (fmi2##name##TYPE *)dlsym(library, "fmi2" #name)
/* Exit unless the call returns success or a warning. */
#define REQUIRE_OK(call)           \
    do {                           \
        if ((call) > fmi2Warning)  \
            fail(#call);           \
    } while (0)

static void fail(const char *reason)
{
    fprintf(stderr, "%s\n", reason);
    exit(1);
}

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
        fail(dlerror());
    FMI(Instantiate);
    FMI(FreeInstance);
    FMI(SetupExperiment);
    FMI(EnterInitializationMode);
    FMI(ExitInitializationMode);
    FMI(DoStep);
    FMI(GetReal);
    const fmi2CallbackFunctions callbacks = {quiet, calloc, free, NULL, NULL};
    /* x, vx, y, vy and P of the slider; height and speed of the ball by turns. */
    const fmi2ValueReference outputs[5] = {15, 16, 17, 18, 19};
    const double h = atof(arguments[4]);
    const int count = atoi(arguments[5]);
    double values[5], begin = now();
    fmi2Component c = Instantiate("timed", fmi2CoSimulation, arguments[2], arguments[3], &callbacks,
                                  fmi2False, fmi2False);
    const double made = now() - begin;
    if (!c)
        fail("no instance");
    REQUIRE_OK(SetupExperiment(c, fmi2False, 0.0, 0.0, fmi2False, 0.0));
    REQUIRE_OK(EnterInitializationMode(c));
    REQUIRE_OK(ExitInitializationMode(c));
    double spent[2];
    for (int reading = 0; reading < 2; reading++) {
        begin = now();
        for (int n = reading * count; n < (reading + 1) * count; n++) {
            REQUIRE_OK(DoStep(c, n * h, h, fmi2True));
            if (reading)
                REQUIRE_OK(GetReal(c, outputs, 5, values));
        }
        spent[reading] = now() - begin;
    }
    printf("%.17g %.17g %.17g\n", 1e9 * spent[0] / count, 1e9 * spent[1] / count, 1e6 * made);
    FreeInstance(c);
    return 0;
}
