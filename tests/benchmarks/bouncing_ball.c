/* A ball that bounces, as an FMU in C is usually written: fixed steps of 1 ms by Euler's method, with
   an event after each. Benchmarks compare the cost of its communication steps with the slider's. */

#include <float.h>
#include <stdlib.h>

#include "fmi2Functions.h"

#define STEP 1e-3

typedef struct {
    double t, h, v, g, e, before;
    unsigned long steps;
} Ball;

static void derivatives(const Ball *b, double *rates) { rates[0] = b->v, rates[1] = b->g; }

static void bounce(Ball *b)
{
    if (b->h <= 0.0 && b->v < 0.0) {
        /* Above zero, so that the next contact is a change of sign. */
        b->h = DBL_MIN;
        b->v = -b->v * b->e;
        if (b->v < 0.1)
            b->v = b->g = 0.0;
    }
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String place,
                              const fmi2CallbackFunctions *callbacks, fmi2Boolean visible,
                              fmi2Boolean logging)
{
    (void)name, (void)type, (void)guid, (void)place, (void)callbacks, (void)visible, (void)logging;
    Ball *b = calloc(1, sizeof *b);
    if (b)
        b->h = b->before = 1.0, b->g = -9.81, b->e = 0.7;
    return b;
}

void fmi2FreeInstance(fmi2Component c) { free(c); }

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean with_tolerance, fmi2Real tolerance,
                               fmi2Real start, fmi2Boolean with_stop, fmi2Real stop)
{
    (void)with_tolerance, (void)tolerance, (void)with_stop, (void)stop;
    ((Ball *)c)->t = start;
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) { return c ? fmi2OK : fmi2Error; }
fmi2Status fmi2ExitInitializationMode(fmi2Component c) { return c ? fmi2OK : fmi2Error; }

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean no_way_back)
{
    (void)no_way_back;
    Ball *b = c;
    /* The tolerance includes a step that rounding makes end just after t + h. */
    const double end = t + h + STEP * 1e-5;
    double rates[2];
    while (b->t + STEP < end) {
        derivatives(b, rates);
        b->h += STEP * rates[0], b->v += STEP * rates[1];
        b->t = STEP * (double)++b->steps;
        if ((b->h > 0.0) != (b->before > 0.0))
            bounce(b);
        b->before = b->h;
    }
    return fmi2OK;
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference r[], size_t count,
                       fmi2Real values[])
{
    const Ball *b = c;
    for (size_t n = 0; n < count; n++)
        values[n] = r[n] % 2 ? b->v : b->h;
    return fmi2OK;
}
