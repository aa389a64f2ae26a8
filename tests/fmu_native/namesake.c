/* A host whose functions have the same names as those of the FMU; the FMU must not call them.

   Arguments: the library, and the instantiation token. Prints y after 1 s. */

#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>

#include "fmi3FunctionTypes.h"

/* Value reference of y. */
#ifndef Y_REFERENCE
#error "Y_REFERENCE must be defined"
#endif

/* Functions of FMI 2.0, and of the FMU alone, that its functions of FMI 3.0 call. */
#define NAMESAKE(name) int name(void) { exit(3); }
NAMESAKE(fmi2SetupExperiment)
NAMESAKE(fmi2EnterInitializationMode)
NAMESAKE(fmi2ExitInitializationMode)
NAMESAKE(fmi2GetReal)
NAMESAKE(fmi2FreeInstance)
NAMESAKE(make_instance)
NAMESAKE(update_outputs)
NAMESAKE(stepping)

#define FMI(name) fmi3##name##TYPE *name = (fmi3##name##TYPE *)dlsym(library, "fmi3" #name)

int main(int count, char **arguments)
{
    void *library = count == 3 ? dlopen(arguments[1], RTLD_NOW | RTLD_LOCAL) : NULL;
    if (!library)
        return 1;
    FMI(InstantiateCoSimulation);
    FMI(EnterInitializationMode);
    FMI(ExitInitializationMode);
    FMI(DoStep);
    FMI(GetFloat64);
    FMI(FreeInstance);
    const fmi3ValueReference y = Y_REFERENCE;
    fmi3Boolean event, stops, early;
    double value, t;
    fmi3Instance c = InstantiateCoSimulation("belt", arguments[2], NULL, 0, 0, 0, 0, NULL, 0, NULL,
                                             NULL, NULL);
    if (!c || EnterInitializationMode(c, 0, 0.0, 0.0, 0, 0.0) || ExitInitializationMode(c)
        || DoStep(c, 0.0, 1.0, 1, &event, &stops, &early, &t) || GetFloat64(c, &y, 1, &value, 1))
        return 2;
    printf("%a\n", value);
    FreeInstance(c);
    return 0;
}
