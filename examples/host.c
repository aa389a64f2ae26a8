/* Run the native FMU without Python: the base scene over 100 s; print y and the separations.

       fivtui fmu build --force --out belt.fmu && unzip -qo belt.fmu -d belt
       cc host.c -I"$(.venv/bin/python -c 'import fmpy; print(fmpy.__path__[0])')/c-code" -ldl -o host
       ./host belt                                                                              */

#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2FunctionTypes.h"

/* Copy the value of the first attribute `name` in `text`. */
static char *attribute(const char *text, const char *name)
{
    const char *start = text ? strstr(text, name) : NULL;
    if (!start)
        exit((fprintf(stderr, "no %s in the model description\n", name), 1));
    start = strchr(start, '"') + 1;
    size_t length = strcspn(start, "\"");
    char *value = calloc(1, length + 1);
    return memcpy(value, start, length);
}

static void log_message(void *host, const char *name, fmi2Status status, const char *category,
                        const char *message, ...)
{
    (void)host, (void)status;
    fprintf(stderr, "%s: %s: %s\n", name, category, message);
}

#define LOAD(name) fmi2##name##TYPE *name = (fmi2##name##TYPE *)dlsym(library, "fmi2" #name)
#define CALL(call) (call > fmi2Warning ? exit((fprintf(stderr, "%s\n", #call), 1)) : (void)0)

int main(int count, char **arguments)
{
    static char text[1 << 16], path[4096];
    if (count != 2)
        exit((fprintf(stderr, "usage: %s FOLDER (where the FMU is unpacked)\n", arguments[0]), 1));
    snprintf(path, sizeof path, "%s/modelDescription.xml", arguments[1]);
    FILE *file = fopen(path, "r");
    if (!file || !fread(text, 1, sizeof text - 1, file))
        exit((perror(path), 1));
    snprintf(path, sizeof path, "%s/binaries/linux64/SliderBelt.so", arguments[1]);
    void *library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (!library)
        exit((fprintf(stderr, "%s\n", dlerror()), 1));
    LOAD(Instantiate);
    LOAD(SetupExperiment);
    LOAD(EnterInitializationMode);
    LOAD(ExitInitializationMode);
    LOAD(DoStep);
    LOAD(GetReal);
    LOAD(FreeInstance);
    const fmi2CallbackFunctions callbacks = {log_message, calloc, free, NULL, NULL};
    void *belt = Instantiate("belt", fmi2CoSimulation, attribute(text, "guid="), "", &callbacks,
                             fmi2False, fmi2True);
    fmi2ValueReference references[2];
    references[0] = (unsigned)atoi(attribute(strstr(text, "name=\"y\""), "valueReference"));
    references[1] = (unsigned)atoi(attribute(strstr(text, "name=\"separations\""), "valueReference"));
    double values[2];
    CALL(SetupExperiment(belt, fmi2False, 0.0, 0.0, fmi2True, 100.0));
    CALL(EnterInitializationMode(belt));
    CALL(ExitInitializationMode(belt));
    for (int step = 0; step < 10000; step++)
        CALL(DoStep(belt, step / 100.0, (step + 1) / 100.0 - step / 100.0, fmi2True));
    CALL(GetReal(belt, references, 2, values));
    printf("y = %.17g m, separations: %.0f\n", values[0], values[1]);
    FreeInstance(belt);
    return dlclose(library);
}
