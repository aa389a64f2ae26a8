/* Attacks the FMU, linked into this program: states, values, calls at random, and many of all.

   Arguments: steps and instances whose memory is to stay, and rounds of each attack. */

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "build.h"
#include "fmi2Functions.h"
#include "fmi3Functions.h"

#define CHECK(what)                                                     \
    do {                                                                \
        if (!(what)) {                                                  \
            fprintf(stderr, "line %d: not so: %s\n", __LINE__, #what);  \
            exit(1);                                                    \
        }                                                               \
    } while (0)
enum { F = 6, MU = 8, X = 15, FINITE_BELT = 31, V_BELT, MU_S, V_S, VARIABLES = 37, MOST_BYTES = 4096 };
/* Whether instances have a belt of finite speed. */
static int on_belt;

static uint64_t chance_state = 88172645463325252u;

static unsigned chance(unsigned below)
{
    uint64_t *s = &chance_state;
    *s ^= *s << 13, *s ^= *s >> 7, *s ^= *s << 17;
    return (unsigned)(*s >> 33) % below;
}

static double hostile(void)
{
    static const double ODD[] = {0.0, -0.0, 1.0, -1.0, 1e-300, 5e-324, 1e300, 1e-3, 0.7, 80.0, 50.0};
    switch (chance(6)) {
    case 0:
        return NAN;
    case 1:
        return chance(2) ? INFINITY : -INFINITY;
    case 2:
        return ldexp((double)chance(1000), (int)chance(2000) - 1000);
    default:
        return ODD[chance(sizeof ODD / sizeof *ODD)];
    }
}

static void quiet(void *host, fmi2String name, fmi2Status status, fmi2String category,
                  fmi2String message, ...)
{
    (void)host, (void)name;
    CHECK(status > fmi2OK && *category && *message);
}

static fmi2Component made(fmi2Type type)
{
    static const fmi2CallbackFunctions CALLBACKS = {quiet, NULL, NULL, NULL, NULL};
    fmi2Component c = fmi2Instantiate("attacked", type, SLIDER_BELT_GUID, NULL, &CALLBACKS, 0, fmi2True);
    CHECK(c);
    return c;
}

static void choose_belt(fmi2Component c)
{
    const fmi2ValueReference flag = FINITE_BELT, of_belt[] = {V_BELT, MU_S, V_S};
    const double values[] = {1.0, 0.9, 0.4};
    CHECK(fmi2SetBoolean(c, &flag, 1, &on_belt) == fmi2OK);
    CHECK(fmi2SetReal(c, of_belt, 3, values) == fmi2OK);
}

static fmi2Component begun(fmi2Type type)
{
    fmi2Component c = made(type);
    choose_belt(c);
    CHECK(fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0) == fmi2OK);
    CHECK(fmi2EnterInitializationMode(c) == fmi2OK);
    CHECK(fmi2ExitInitializationMode(c) == fmi2OK);
    return c;
}

/* The checksum of the bytes before it, so that what is damaged gets further. */
static void sign(fmi2Byte *bytes, size_t size)
{
    uint32_t crc = UINT32_MAX;
    for (size_t n = 0; n + 4 < size; n++) {
        crc ^= (unsigned char)bytes[n];
        for (int bit = 0; bit < 8; bit++)
            crc = (crc >> 1) ^ (crc & 1u ? UINT32_C(0xedb88320) : 0);
    }
    for (int n = 0; n < 4; n++)
        bytes[size - 4 + (size_t)n] = (fmi2Byte)(~crc >> 8 * n);
}

static void attack_states(int rounds)
{
    fmi2Component c = begun(fmi2CoSimulation);
    fmi2Byte bytes[MOST_BYTES], damaged[MOST_BYTES];
    fmi2FMUstate state = NULL, copy;
    size_t size;
    double t = 0.0;
    for (int round = 0; round < rounds; round++) {
        double h = 0.01 * (1.0 + chance(20));
        CHECK(fmi2DoStep(c, t, h, 1) == fmi2OK);
        t += h;
        CHECK(fmi2GetFMUstate(c, &state) == fmi2OK);
        CHECK(fmi2SerializedFMUstateSize(c, state, &size) == fmi2OK && size <= MOST_BYTES);
        CHECK(fmi2SerializeFMUstate(c, state, bytes, size - 1) == fmi2Error);
        CHECK(fmi2SerializeFMUstate(c, state, bytes, size) == fmi2OK);
        /* Cut, flipped: always refused. */
        CHECK(fmi2DeSerializeFMUstate(c, bytes, chance((unsigned)size), &copy) == fmi2Error);
        memcpy(damaged, bytes, size);
        damaged[chance((unsigned)size)] ^= (fmi2Byte)(1 << chance(8));
        CHECK(fmi2DeSerializeFMUstate(c, damaged, size, &copy) == fmi2Error);
        /* Forged: refused, or harmless. */
        memcpy(damaged, bytes, size);
        for (unsigned left = 1 + chance(4); left > 0; left--) {
            double number = hostile();
            memcpy(damaged + 48 + 8 * chance((unsigned)(size - 52) / 8), &number, 8);
        }
        sign(damaged, size);
        if (fmi2DeSerializeFMUstate(c, damaged, size, &copy) == fmi2OK) {
            double values[VARIABLES];
            fmi2ValueReference all[VARIABLES];
            for (unsigned n = 0; n < VARIABLES; n++)
                all[n] = n;
            CHECK(fmi2SetFMUstate(c, copy) == fmi2OK);
            fmi2GetReal(c, all, VARIABLES, values);
            if (fmi2DoStep(c, t, 0.01, 1) == fmi2OK) {
                CHECK(fmi2GetReal(c, all, VARIABLES, values) == fmi2OK);
                for (unsigned n = 0; n < VARIABLES; n++)
                    CHECK(!isnan(values[n]));
            }
            CHECK(fmi2FreeFMUstate(c, &copy) == fmi2OK && !copy);
            CHECK(fmi2SetFMUstate(c, state) == fmi2OK);
        }
        /* As it was: goes on to the same bits. */
        const fmi2ValueReference x = X;
        double one, other;
        CHECK(fmi2DeSerializeFMUstate(c, bytes, size, &copy) == fmi2OK);
        CHECK(fmi2DoStep(c, t, h, 1) == fmi2OK && fmi2GetReal(c, &x, 1, &one) == fmi2OK);
        CHECK(fmi2SetFMUstate(c, copy) == fmi2OK && fmi2FreeFMUstate(c, &copy) == fmi2OK);
        CHECK(fmi2DoStep(c, t, h, 1) == fmi2OK && fmi2GetReal(c, &x, 1, &other) == fmi2OK);
        CHECK(one == other);
        CHECK(fmi2SetFMUstate(c, state) == fmi2OK);
    }
    CHECK(fmi2FreeFMUstate(c, &state) == fmi2OK);
    fmi2FreeInstance(c);
}

static void quiet_3(void *host, fmi3Status status, fmi3String category, fmi3String message)
{
    (void)host;
    CHECK(status > fmi3OK && *category && *message);
}

/* An instance of FMI 3.0 for co-simulation with events. */
static fmi2Component begun_3(void)
{
    fmi3Instance c = fmi3InstantiateCoSimulation("attacked", SLIDER_BELT_GUID, NULL, 0, 1, 1, 1, NULL,
                                                 0, NULL, quiet_3, NULL);
    CHECK(c);
    choose_belt(c);
    CHECK(fmi3EnterInitializationMode(c, 0, 0.0, 0.0, 0, 0.0) == fmi3OK);
    CHECK(fmi3ExitInitializationMode(c) == fmi3OK && fmi3EnterStepMode(c) == fmi3OK);
    return c;
}

/* Numbers of a call that is well are finite. */
static void check_finite(int status, const double *numbers, size_t count)
{
    for (size_t n = 0; n < count; n++)
        CHECK(status != fmi2OK || isfinite(numbers[n]));
}

/* Any call in any phase, with anything: no harm. */
static void call_anything(fmi2Component c, fmi2FMUstate *state)
{
    const fmi2ValueReference r[2] = {chance(VARIABLES + 8), chance(4) ? chance(VARIABLES + 8) : UINT32_MAX};
    const fmi2Real reals[4] = {hostile(), hostile(), hostile(), hostile()};
    const fmi2Integer orders[2] = {(int)chance(3), 1};
    const fmi2Boolean booleans[2] = {(int)chance(3), 0};
    fmi2Real read[4];
    fmi2Boolean flags[2];
    fmi2EventInfo info;
    const size_t two = chance(3), four = chance(4) ? 4 : chance(5);
    const fmi2String category = chance(2) ? "logStatusError" : "nonsense";
    fmi3Boolean set[6];
    fmi3Int64 long_number[2];
    switch (chance(36)) {
    case 0: fmi2SetupExperiment(c, booleans[0], reals[0], reals[1], 0, reals[2]); break;
    case 1: fmi2EnterInitializationMode(c); break;
    case 2: fmi2ExitInitializationMode(c); break;
    case 3: fmi2Terminate(c); break;
    case 4: fmi2Reset(c); break;
    case 5: fmi2SetReal(c, r, two, reals); break;
    case 6: fmi2SetBoolean(c, r, two, booleans); break;
    case 7: fmi2SetInteger(c, r, two, orders); break;
    case 8: check_finite(fmi2GetReal(c, r, two, read), read, two); break;
    case 9: fmi2GetInteger(c, r, two, flags); break;
    case 10: fmi2GetBoolean(c, r, two, flags); break;
    case 11: fmi2DoStep(c, reals[0], fmin(reals[1], 10.0), 1); break;
    case 12: fmi2SetRealInputDerivatives(c, r, two, orders, reals); break;
    case 13: fmi2GetFMUstate(c, state); break;
    case 14: fmi2SetFMUstate(c, *state); break;
    case 15: fmi2FreeFMUstate(c, state); break;
    case 16: fmi2SetTime(c, reals[0]); break;
    case 17: fmi2SetContinuousStates(c, reals, four); break;
    case 18: check_finite(fmi2GetContinuousStates(c, read, four), read, four); break;
    case 19: check_finite(fmi2GetDerivatives(c, read, four), read, four); break;
    case 20: check_finite(fmi2GetEventIndicators(c, read, four), read, four); break;
    case 21: fmi2EnterEventMode(c); break;
    case 22: fmi2NewDiscreteStates(c, &info); break;
    case 23: fmi2EnterContinuousTimeMode(c); break;
    case 24: check_finite(fmi2GetDirectionalDerivative(c, r, two, r, two, reals, read), read, two); break;
    case 25: fmi3EnterEventMode(c); break;
    case 26: fmi3EnterStepMode(c); break;
    case 27: fmi3UpdateDiscreteStates(c, set, set + 1, set + 2, set + 3, set + 4, read); break;
    case 28: fmi3DoStep(c, reals[0], fmin(reals[1], 10.0), 1, set, set + 1, set + 2, read); break;
    case 29: check_finite(fmi3GetFloat64(c, r, two, read, chance(8) ? two : 3), read, two); break;
    case 30: fmi3GetInt64(c, r, two, long_number, two); break;
    case 31: fmi3SetFloat64(c, r, two, reals, two); break;
    case 32: fmi3GetBoolean(c, r, two, set, two); break;
    case 33: check_finite(fmi3GetAdjointDerivative(c, r, two, r + 1, 1, reals, two, read, 1), read, 1); break;
    case 34: fmi3EnterInitializationMode(c, 1, reals[0], reals[1], 1, reals[2]); break;
    default: fmi2SetDebugLogging(c, booleans[0], chance(2), &category); break;
    }
}

static void attack_calls(fmi2Component c, int rounds)
{
    fmi2FMUstate state = NULL;
    for (int round = 0; round < rounds; round++)
        call_anything(c, &state);
    fmi2FreeFMUstate(c, &state);
    fmi2FreeInstance(c);
}

/* Anything within intermediate updates, too: the step goes on. */
typedef struct {
    fmi3Instance c;
    fmi2FMUstate state;
    double last;
} Updated;

static void attack_from_within(fmi3InstanceEnvironment environment, fmi3Float64 time,
                               fmi3Boolean asks, fmi3Boolean get_allowed, fmi3Boolean finished,
                               fmi3Boolean can_return, fmi3Boolean *is_early, fmi3Float64 *early)
{
    Updated *of = environment;
    CHECK(can_return && asks != get_allowed && get_allowed == finished);
    CHECK(time >= of->last);
    of->last = finished ? time : of->last;
    const fmi2ValueReference f = F, v = V_BELT;
    const double force = chance(4) ? 80.0 + chance(9) : hostile();
    const double speed = chance(4) ? 1.0 + 0.1 * chance(9) : hostile();
    fmi3SetFloat64(of->c, &f, 1, &force, 1);
    fmi3SetFloat64(of->c, &v, 1, &speed, 1);
    for (unsigned left = chance(4); left > 0; left--)
        call_anything(of->c, &of->state);
    fmi3FreeInstance(chance(8) ? NULL : of->c);
    *is_early = chance(4) == 0, *early = chance(2) ? time : hostile();
}

static void attack_updates(int rounds, fmi3Boolean events)
{
    const fmi3ValueReference needed[] = {F, MU, X, V_BELT};
    Updated of = {0};
    fmi3Boolean event, stops, early, flags[5];
    double t = 0.0, reached;
    int switches = 0;
    of.c = fmi3InstantiateCoSimulation("attacked", SLIDER_BELT_GUID, NULL, 0, 1, events, 1, needed, 4,
                                       &of, quiet_3, attack_from_within);
    CHECK(of.c);
    choose_belt(of.c);
    CHECK(fmi3EnterInitializationMode(of.c, 0, 0.0, 0.0, 0, 0.0) == fmi3OK);
    CHECK(fmi3ExitInitializationMode(of.c) == fmi3OK);
    CHECK(!events || fmi3EnterStepMode(of.c) == fmi3OK);
    for (int round = 0; round < rounds; round++) {
        const double h = 0.01 * (1.0 + chance(50));
        const fmi3Status status = fmi3DoStep(of.c, t, h, 1, &event, &stops, &early, &reached);
        if (status == fmi3Discard) {
            /* Forces that are too great: the instance is as it was. */
            CHECK(reached == t);
            of.last = t;
            continue;
        }
        CHECK(status == fmi3OK);
        CHECK(reached >= t && reached <= t + h && !stops);
        CHECK(early == (reached < t + h) && (events || !event));
        t = reached, switches += event;
        if (!event || !chance(8))
            continue;
        CHECK(fmi3EnterEventMode(of.c) == fmi3OK);
        CHECK(fmi3UpdateDiscreteStates(of.c, flags, flags + 1, flags + 2, flags + 3, flags + 4, &reached)
              == fmi3OK);
        CHECK(fmi3EnterStepMode(of.c) == fmi3OK);
    }
    CHECK(!events || rounds < 50 || switches > 0);
    fmi2FreeFMUstate(of.c, &of.state);
    fmi3FreeInstance(of.c);
}

static void let_pass(fmi3InstanceEnvironment environment, fmi3Float64 time, fmi3Boolean asks,
                     fmi3Boolean get_allowed, fmi3Boolean finished, fmi3Boolean can_return,
                     fmi3Boolean *is_early, fmi3Float64 *early)
{
    (void)environment, (void)time, (void)asks, (void)get_allowed, (void)finished;
    (void)can_return, (void)is_early, (void)early;
}

/* A step that no computer can finish is given up, with updates and without, and changes nothing. */
static void attack_by_length(fmi3IntermediateUpdateCallback update, size_t required)
{
    const fmi3ValueReference needed = F;
    fmi3Boolean flags[3];
    double reached;
    fmi3Instance c = fmi3InstantiateCoSimulation("attacked", SLIDER_BELT_GUID, NULL, 0, 1, 0, 1, &needed,
                                                 required, NULL, quiet_3, update);
    CHECK(c);
    choose_belt(c);
    CHECK(fmi3EnterInitializationMode(c, 0, 0.0, 0.0, 0, 0.0) == fmi3OK);
    CHECK(fmi3ExitInitializationMode(c) == fmi3OK);
    CHECK(fmi3DoStep(c, 0.0, 1e206, 1, flags, flags + 1, flags + 2, &reached) == fmi3Discard);
    CHECK(reached == 0.0);
    CHECK(fmi3DoStep(c, 0.0, 0.1, 1, flags, flags + 1, flags + 2, &reached) == fmi3OK);
    CHECK(reached == 0.1);
    fmi3FreeInstance(c);
}

static long resident(void)
{
    long total, pages = 0;
    FILE *file = fopen("/proc/self/statm", "r");
    if (!file || fscanf(file, "%ld %ld", &total, &pages) != 2)
        pages = 0;
    if (file)
        fclose(file);
    return pages;
}

/* Pages of memory that many steps and many instances take and do not give back. */
static void measure_memory(int steps, int instances)
{
    fmi2Component c = begun(fmi2CoSimulation);
    const fmi2ValueReference f = F;
    long before = 0;
    for (int step = 0; step < steps; step++) {
        const double force = 80.0 + step % 7;
        if (step == steps / 10)
            before = resident();
        if (step % 100 == 0)
            CHECK(fmi2SetReal(c, &f, 1, &force) == fmi2OK);
        CHECK(fmi2DoStep(c, step * 1e-3, 1e-3, 1) == fmi2OK);
    }
    printf("%ld\n", resident() - before);
    fmi2FreeInstance(c);
    for (int number = 0; number < instances; number++) {
        if (number == instances / 10)
            before = resident();
        c = begun(fmi2CoSimulation);
        CHECK(fmi2DoStep(c, 0.0, 0.1, 1) == fmi2OK);
        fmi2FreeInstance(c);
    }
    printf("%ld\n", resident() - before);
}

int main(int count, char **arguments)
{
    CHECK(count == 4);
    const int rounds = atoi(arguments[3]);
    CHECK(!fmi2Instantiate("a", fmi2CoSimulation, SLIDER_BELT_GUID, NULL, NULL, 0, 0));
    CHECK(fmi2DoStep(NULL, 0.0, 1.0, 1) == fmi2Error);
    fmi2FreeInstance(NULL);
    for (on_belt = 0; on_belt < 2; on_belt++) {
        attack_states(rounds);
        attack_calls(begun(fmi2CoSimulation), 20 * rounds);
        attack_calls(begun(fmi2ModelExchange), 20 * rounds);
        attack_calls(begun_3(), 20 * rounds);
        attack_updates(rounds, fmi3False);
        attack_updates(rounds, fmi3True);
        attack_by_length(NULL, 0);
        attack_by_length(let_pass, 0);
        attack_by_length(let_pass, 1);
    }
    measure_memory(atoi(arguments[1]), atoi(arguments[2]));
    return 0;
}
