/* The native FMU in a process without Python: the base scene over 100 s, and its separations.

       fivtui fmu build --flavour native --out belt.fmu && unzip -q belt.fmu -d belt
       cc host.c -I"$(python -c 'import fmpy; print(fmpy.__path__[0])')/c-code" -ldl -o host
       ./host belt                                                                            */

#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2FunctionTypes.h"

/* The text of an attribute in the model description, from a place in it on. */
static char *attribute(const char *text, const char *name)
{
    const char *begin = text ? strstr(text, name) : NULL;
    if (!begin)
        exit((fprintf(stderr, "no %s in the model description\n", name), 1));
    begin = strchr(begin, '"') + 1;
    size_t length = strcspn(begin, "\"");
    char *value = calloc(1, length + 1);
    return memcpy(value, begin, length);
}

static void log_message(void *host, const char *name, fmi2Status status, const char *category,
                        const char *message, ...)
{
    (void)host, (void)status;
    fprintf(stderr, "%s: %s: %s\n", name, category, message);
}

#define FMI(name) fmi2##name##TYPE *name = (fmi2##name##TYPE *)dlsym(library, "fmi2" #name)
#define DO(call) (call > fmi2Warning ? exit((fprintf(stderr, "%s\n", #call), 1)) : (void)0)

int main(int count, char **arguments)
{
    static char text[1 << 16], path[4096];
    if (count != 2)
        return 1;
    snprintf(path, sizeof path, "%s/modelDescription.xml", arguments[1]);
    FILE *file = fopen(path, "r");
    if (!file || !fread(text, 1, sizeof text - 1, file))
        return 1;
    snprintf(path, sizeof path, "%s/binaries/linux64/SliderBelt.so", arguments[1]);
    void *library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (!library)
        return 1;
    FMI(Instantiate);
    FMI(SetupExperiment);
    FMI(EnterInitializationMode);
    FMI(ExitInitializationMode);
    FMI(DoStep);
    FMI(GetReal);
    FMI(FreeInstance);
    const fmi2CallbackFunctions callbacks = {log_message, calloc, free, NULL, NULL};
    void *belt = Instantiate("belt", fmi2CoSimulation, attribute(text, "guid="), "", &callbacks,
                             fmi2False, fmi2True);
    fmi2ValueReference references[2];
    references[0] = (unsigned)atoi(attribute(strstr(text, "name=\"y\""), "valueReference"));
    references[1] = (unsigned)atoi(attribute(strstr(text, "name=\"separations\""), "valueReference"));
    double values[2];
    DO(SetupExperiment(belt, fmi2False, 0.0, 0.0, fmi2True, 100.0));
    DO(EnterInitializationMode(belt));
    DO(ExitInitializationMode(belt));
    for (int step = 0; step < 10000; step++)
        DO(DoStep(belt, step * 0.01, 0.01, fmi2True));
    DO(GetReal(belt, references, 2, values));
    printf("y = %a m, separations: %.0f\n", values[0], values[1]);
    FreeInstance(belt);
    return dlclose(library);
}
