/* Attacks the FMU, linked into this program, by damaged states, extreme values and random calls.

   Arguments: numbers of steps and instances that measure memory growth, of rounds per attack, and a
   seed of the random numbers. */

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "build.h"
#include "fmi2Functions.h"
#include "fmi3Functions.h"
#include "slider_belt_table.h"

#define CHECK(condition)                                                     \
    do {                                                                     \
        if (!(condition)) {                                                  \
            fprintf(stderr, "line %d: false: %s\n", __LINE__, #condition);   \
            exit(1);                                                         \
        }                                                                    \
    } while (0)
/* Sizes in bytes of the parts of a serialised state: the head, each number, and the checksum, which is
   last; and a bound of the size of the state. */
enum { HEAD = 48, NUMBER_SIZE = 8, CHECKSUM_SIZE = 4, MAX_BYTES = 4096 };
/* Whether `choose_belt` gives new instances a belt of finite speed; set by `main`. */
static int has_finite_belt;

/* State of the random numbers: the xorshift generator of Marsaglia. */
static uint64_t random_state;

static unsigned random_below(unsigned bound)
{
    uint64_t *s = &random_state;
    *s ^= *s << 13, *s ^= *s >> 7, *s ^= *s << 17;
    return (unsigned)(*s >> 33) % bound;
}

static double extreme_number(void)
{
    static const double SPECIAL_NUMBERS[] = {0.0, -0.0, 1.0, -1.0, 1e-300, 5e-324, 1e300, 1e-3,
                                             0.7, 80.0, 50.0};
    switch (random_below(6)) {
    case 0:
        return NAN;
    case 1:
        return random_below(2) ? INFINITY : -INFINITY;
    case 2:
        return ldexp((double)random_below(1000), (int)random_below(2000) - 1000);
    default:
        return SPECIAL_NUMBERS[random_below(sizeof SPECIAL_NUMBERS / sizeof *SPECIAL_NUMBERS)];
    }
}

static void check_message(void *host, fmi2String name, fmi2Status status, fmi2String category,
                  fmi2String message, ...)
{
    (void)host, (void)name;
    CHECK(status > fmi2OK && *category && *message);
}

static fmi2Component create_instance(fmi2Type type)
{
    static const fmi2CallbackFunctions CALLBACKS = {check_message, NULL, NULL, NULL, NULL};
    fmi2Component c = fmi2Instantiate("attacked", type, SLIDER_BELT_GUID, NULL, &CALLBACKS, 0, fmi2True);
    CHECK(c);
    return c;
}

static void choose_belt(fmi2Component c)
{
    const fmi2ValueReference flag = V_finite_belt, belt_references[] = {V_v_belt, V_mu_s, V_v_s};
    const double values[] = {1.0, 0.9, 0.4};
    CHECK(fmi2SetBoolean(c, &flag, 1, &has_finite_belt) == fmi2OK);
    CHECK(fmi2SetReal(c, belt_references, 3, values) == fmi2OK);
}

static fmi2Component create_initialized(fmi2Type type)
{
    fmi2Component c = create_instance(type);
    choose_belt(c);
    CHECK(fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0) == fmi2OK);
    CHECK(fmi2EnterInitializationMode(c) == fmi2OK);
    CHECK(fmi2ExitInitializationMode(c) == fmi2OK);
    return c;
}

/* Check that a successful call returned only finite numbers. */
static void check_finite(int status, const double *numbers, size_t count)
{
    for (size_t n = 0; n < count; n++)
        CHECK(status != fmi2OK || isfinite(numbers[n]));
}

/* Make the checksum valid, so that damaged numbers are read. */
static void update_checksum(fmi2Byte *bytes, size_t size)
{
    uint32_t crc = UINT32_MAX;
    for (size_t n = 0; n + CHECKSUM_SIZE < size; n++) {
        crc ^= (unsigned char)bytes[n];
        for (int bit = 0; bit < 8; bit++)
            crc = (crc >> 1) ^ (crc & 1u ? UINT32_C(0xedb88320) : 0);
    }
    for (int n = 0; n < CHECKSUM_SIZE; n++)
        bytes[size - CHECKSUM_SIZE + (size_t)n] = (fmi2Byte)(~crc >> 8 * n);
}

static void attack_states(int rounds)
{
    fmi2Component c = create_initialized(fmi2CoSimulation);
    fmi2Byte bytes[MAX_BYTES], damaged[MAX_BYTES];
    fmi2FMUstate state = NULL, copy;
    size_t size;
    double t = 0.0;
    for (int round = 0; round < rounds; round++) {
        double h = 0.01 * (1.0 + random_below(20));
        CHECK(fmi2DoStep(c, t, h, 1) == fmi2OK);
        t += h;
        CHECK(fmi2GetFMUstate(c, &state) == fmi2OK);
        CHECK(fmi2SerializedFMUstateSize(c, state, &size) == fmi2OK && size <= MAX_BYTES);
        CHECK(fmi2SerializeFMUstate(c, state, bytes, size - 1) == fmi2Error);
        CHECK(fmi2SerializeFMUstate(c, state, bytes, size) == fmi2OK);
        /* A truncated state and a flipped bit are always refused. */
        CHECK(fmi2DeSerializeFMUstate(c, bytes, random_below((unsigned)size), &copy) == fmi2Error);
        memcpy(damaged, bytes, size);
        damaged[random_below((unsigned)size)] ^= (fmi2Byte)(1 << random_below(8));
        CHECK(fmi2DeSerializeFMUstate(c, damaged, size, &copy) == fmi2Error);
        /* Wrong numbers with a valid checksum are refused, or cause no NaN. */
        memcpy(damaged, bytes, size);
        const unsigned number_count = (unsigned)(size - HEAD - CHECKSUM_SIZE) / NUMBER_SIZE;
        for (unsigned remaining = 1 + random_below(4); remaining > 0; remaining--) {
            double number = extreme_number();
            memcpy(damaged + HEAD + NUMBER_SIZE * random_below(number_count), &number, NUMBER_SIZE);
        }
        update_checksum(damaged, size);
        if (fmi2DeSerializeFMUstate(c, damaged, size, &copy) == fmi2OK) {
            double values[VARIABLE_COUNT];
            fmi2ValueReference all[VARIABLE_COUNT];
            for (unsigned n = 0; n < VARIABLE_COUNT; n++)
                all[n] = n;
            CHECK(fmi2SetFMUstate(c, copy) == fmi2OK);
            fmi2GetReal(c, all, VARIABLE_COUNT, values);
            if (fmi2DoStep(c, t, 0.01, 1) == fmi2OK)
                check_finite(fmi2GetReal(c, all, VARIABLE_COUNT, values), values, VARIABLE_COUNT);
            CHECK(fmi2FreeFMUstate(c, &copy) == fmi2OK && !copy);
            CHECK(fmi2SetFMUstate(c, state) == fmi2OK);
        }
        /* The undamaged state continues to the same bits. */
        const fmi2ValueReference x = V_x;
        double original, restored;
        CHECK(fmi2DeSerializeFMUstate(c, bytes, size, &copy) == fmi2OK);
        CHECK(fmi2DoStep(c, t, h, 1) == fmi2OK && fmi2GetReal(c, &x, 1, &original) == fmi2OK);
        CHECK(fmi2SetFMUstate(c, copy) == fmi2OK && fmi2FreeFMUstate(c, &copy) == fmi2OK);
        CHECK(fmi2DoStep(c, t, h, 1) == fmi2OK && fmi2GetReal(c, &x, 1, &restored) == fmi2OK);
        CHECK(original == restored);
        CHECK(fmi2SetFMUstate(c, state) == fmi2OK);
    }
    CHECK(fmi2FreeFMUstate(c, &state) == fmi2OK);
    fmi2FreeInstance(c);
}

static void check_message_3(void *host, fmi3Status status, fmi3String category, fmi3String message)
{
    (void)host;
    CHECK(status > fmi3OK && *category && *message);
}

/* An instance of FMI 3.0. In this FMU both versions of FMI have the same type of instance, so that
   functions of either may be called. */
static fmi2Component create_initialized_3(fmi2Type type, fmi3Boolean events)
{
    fmi3Instance c = type == fmi2ModelExchange
        ? fmi3InstantiateModelExchange("attacked", SLIDER_BELT_GUID, NULL, 0, 1, NULL, check_message_3)
        : fmi3InstantiateCoSimulation("attacked", SLIDER_BELT_GUID, NULL, 0, 1, events, events, NULL, 0,
                                      NULL, check_message_3, NULL);
    CHECK(c);
    choose_belt(c);
    CHECK(fmi3EnterInitializationMode(c, 0, 0.0, 0.0, 0, 0.0) == fmi3OK);
    CHECK(fmi3ExitInitializationMode(c) == fmi3OK);
    CHECK(!events || fmi3EnterStepMode(c) == fmi3OK);
    return c;
}

/* Replace a state by what it becomes as bytes. */
static void copy_state(fmi2Component c, fmi2FMUstate *state)
{
    fmi3Byte bytes[MAX_BYTES];
    size_t size;
    if (!*state || fmi3SerializedFMUStateSize(c, *state, &size) != fmi3OK)
        return;
    CHECK(size <= MAX_BYTES && fmi3SerializeFMUState(c, *state, bytes, size) == fmi3OK);
    CHECK(fmi3FreeFMUState(c, state) == fmi3OK);
    CHECK(fmi3DeserializeFMUState(c, bytes, size, state) == fmi3OK);
}

/* Call a random function with random arguments, in any phase. */
static void call_at_random(fmi2Component c, fmi2FMUstate *state)
{
    const unsigned bound = VARIABLE_COUNT + 8;
    const fmi2ValueReference r[2] = {random_below(bound), random_below(4) ? random_below(bound) : UINT32_MAX};
    const fmi2Real reals[4] = {extreme_number(), extreme_number(), extreme_number(), extreme_number()};
    const fmi2Integer orders[2] = {(int)random_below(3), 1 + (int)random_below(3)};
    const fmi2ValueReference continuous[2] = {V_P, random_below(2) ? V_y_peak : V_friction_slider};
    const fmi2Boolean booleans[2] = {(int)random_below(3), 0};
    fmi2Real read[4];
    fmi2Boolean flags[2];
    fmi2EventInfo info;
    /* Numbers of variables and of states, for valid and invalid calls. */
    const size_t count = random_below(3), state_count = random_below(4) ? 4 : random_below(5);
    const fmi2String category = random_below(2) ? "logStatusError" : "nonsense";
    fmi3Boolean set[6] = {random_below(2), random_below(2)};
    fmi3Int64 long_number[2];
    size_t size;
    switch (random_below(56)) {
    case 0: fmi2SetupExperiment(c, booleans[0], reals[0], reals[1], 0, reals[2]); break;
    case 1: fmi2EnterInitializationMode(c); break;
    case 2: fmi2ExitInitializationMode(c); break;
    case 3: fmi2Terminate(c); break;
    case 4: fmi2Reset(c); break;
    case 5: fmi2SetReal(c, r, count, reals); break;
    case 6: fmi2SetBoolean(c, r, count, booleans); break;
    case 7: fmi2SetInteger(c, r, count, orders); break;
    case 8: check_finite(fmi2GetReal(c, r, count, read), read, count); break;
    case 9: fmi2GetInteger(c, r, count, flags); break;
    case 10: fmi2GetBoolean(c, r, count, flags); break;
    case 11: fmi2DoStep(c, reals[0], fmin(reals[1], 10.0), 1); break;
    case 12: fmi2SetRealInputDerivatives(c, r, count, orders, reals); break;
    case 13: fmi2GetFMUstate(c, state); break;
    case 14: fmi2SetFMUstate(c, *state); break;
    case 15: fmi2FreeFMUstate(c, state); break;
    case 16: fmi2SetTime(c, reals[0]); break;
    case 17: fmi2SetContinuousStates(c, reals, state_count); break;
    case 18: check_finite(fmi2GetContinuousStates(c, read, state_count), read, state_count); break;
    case 19: check_finite(fmi2GetDerivatives(c, read, state_count), read, state_count); break;
    case 20: check_finite(fmi2GetEventIndicators(c, read, state_count), read, state_count); break;
    case 21: fmi2EnterEventMode(c); break;
    case 22: fmi2NewDiscreteStates(c, &info); break;
    case 23: fmi2EnterContinuousTimeMode(c); break;
    case 24:
        check_finite(fmi2GetDirectionalDerivative(c, r, count, r, count, reals, read), read, count);
        break;
    case 25: fmi3EnterEventMode(c); break;
    case 26: fmi3EnterStepMode(c); break;
    case 27: fmi3UpdateDiscreteStates(c, set, set + 1, set + 2, set + 3, set + 4, read); break;
    case 28: fmi3DoStep(c, reals[0], fmin(reals[1], 10.0), 1, set, set + 1, set + 2, read); break;
    case 29: check_finite(fmi3GetFloat64(c, r, count, read, random_below(8) ? count : 3), read, count); break;
    case 30: fmi3GetInt64(c, r, count, long_number, count); break;
    case 31: fmi3SetFloat64(c, r, count, reals, count); break;
    case 32: fmi3GetBoolean(c, r, count, set, count); break;
    case 33:
        check_finite(fmi3GetAdjointDerivative(c, r, count, r + 1, 1, reals, count, read, 1), read, 1);
        break;
    case 34: fmi3EnterInitializationMode(c, 1, reals[0], reals[1], 1, reals[2]); break;
    case 35: check_finite(fmi2GetRealOutputDerivatives(c, r, count, orders, read), read, count); break;
    case 36:
        check_finite(fmi3GetOutputDerivatives(c, continuous, count, orders, read, count), read, count);
        break;
    case 37: fmi2SetDebugLogging(c, booleans[0], random_below(2), &category); break;
    case 38: fmi3SetDebugLogging(c, set[0], random_below(2), &category); break;
    case 39: fmi3Reset(c), fmi3SetTime(c, reals[0]); break;
    case 40: fmi3Terminate(c); break;
    case 41: fmi2CompletedIntegratorStep(c, booleans[0], flags, flags + 1); break;
    case 42: fmi3CompletedIntegratorStep(c, fmi3True, set, set + 1); break;
    case 43: fmi3EnterContinuousTimeMode(c), fmi3EvaluateDiscreteStates(c); break;
    case 44: fmi3SetContinuousStates(c, reals, state_count); break;
    case 45:
        check_finite(fmi3GetContinuousStates(c, read, state_count), read, state_count);
        check_finite(fmi3GetContinuousStateDerivatives(c, read, state_count), read, state_count);
        break;
    case 46:
        check_finite(fmi3GetNominalsOfContinuousStates(c, read, state_count), read, state_count);
        check_finite(fmi2GetNominalsOfContinuousStates(c, read, state_count), read, state_count);
        break;
    case 47: check_finite(fmi3GetEventIndicators(c, read, state_count), read, state_count); break;
    case 48:
        if (fmi3GetNumberOfContinuousStates(c, &size) == fmi3OK)
            CHECK(size == 4 && fmi3GetNumberOfEventIndicators(c, &size) == fmi3OK && size == 4);
        break;
    case 49: fmi3SetBoolean(c, r, count, set, random_below(8) ? count : 3); break;
    case 50: fmi3GetInt32(c, r, count, flags, count), fmi3SetInt32(c, r, count, orders, count); break;
    case 51: fmi3GetFMUState(c, state); break;
    case 52: fmi3SetFMUState(c, *state); break;
    case 53: fmi3FreeFMUState(c, state); break;
    case 54: copy_state(c, state); break;
    case 55:
        check_finite(fmi3GetDirectionalDerivative(c, r, count, r, count, reals, count, read, count), read,
                     count);
        break;
    }
}

/* Instances of each kind and version, with a short sequence of random calls each. */
static void attack_calls(int rounds)
{
    for (int round = 0; round < rounds; round++) {
        fmi2Component instances[] = {
            create_initialized(fmi2CoSimulation), create_initialized(fmi2ModelExchange),
            create_initialized_3(fmi2CoSimulation, round % 2), create_initialized_3(fmi2ModelExchange, 0)};
        for (size_t n = 0; n < sizeof instances / sizeof *instances; n++) {
            fmi2FMUstate state = NULL;
            for (unsigned remaining = 1 + random_below(60); remaining > 0; remaining--)
                call_at_random(instances[n], &state);
            fmi2FreeFMUstate(instances[n], &state);
            fmi2FreeInstance(instances[n]);
        }
    }
}

/* Co-simulation in which inputs and tunable parameters change between steps: all outputs, totals and
   output derivatives stay consistent, and equal by both versions of FMI. */
static void attack_tuning(int rounds, fmi3Boolean events)
{
    static const fmi2ValueReference TUNED[] = {V_k1, V_k2, V_k3, V_c1, V_c2, V_k_nl, V_F, V_mu};
    static const fmi2ValueReference READ[] = {V_x, V_x_peak, V_y, V_y_peak, V_P, V_P_min, V_P_max, V_mode};
    enum { X, X_PEAK, Y, Y_PEAK, P, P_MIN, P_MAX, MODE, COUNT };
    static const int ORDERS[] = {1, 2, 3, 1};
    static const fmi2ValueReference DERIVED[] = {V_P, V_P, V_y, V_friction_slider};
    double v[COUNT], starts[8], by_2[4], by_3[4], next = 0.0, t = 0.0, number;
    fmi3Boolean flags[5];
    fmi3Int64 mode;
    const fmi2ValueReference enumeration = V_mode_enumeration;
    fmi2Component c = create_initialized_3(fmi2CoSimulation, events);
    CHECK(fmi2GetReal(c, TUNED, 8, starts) == fmi2OK);
    for (int round = 0; round < rounds; round++) {
        const unsigned chosen = random_below(8);
        const double value = starts[chosen] * (0.9 + 0.02 * random_below(10));
        const double h = 0.001 * (1 + random_below(99));
        if (events) {
            CHECK(fmi3EnterEventMode(c) == fmi3OK);
            CHECK(fmi3SetFloat64(c, TUNED + chosen, 1, &value, 1) == fmi3OK);
            CHECK(fmi3UpdateDiscreteStates(c, flags, flags + 1, flags + 2, flags + 3, flags + 4, &number)
                  == fmi3OK);
            CHECK(fmi3EnterStepMode(c) == fmi3OK);
        } else
            CHECK(fmi2SetReal(c, TUNED + chosen, 1, &value) == fmi2OK);
        CHECK(fmi3GetFloat64(c, TUNED + chosen, 1, &number, 1) == fmi3OK && number == value);
        CHECK(fmi3DoStep(c, t, h, 1, flags, flags + 1, flags + 2, &next) == fmi3OK && next >= t);
        t = next;
        CHECK(fmi2GetReal(c, READ, COUNT, v) == fmi2OK);
        CHECK(fmi3GetInt64(c, &enumeration, 1, &mode, 1) == fmi3OK);
        CHECK(v[X_PEAK] >= fabs(v[X]) && v[Y_PEAK] >= fabs(v[Y]) && v[P_MIN] <= v[P] && v[P] <= v[P_MAX]);
        CHECK((double)mode == v[MODE]);
        CHECK(fmi2GetRealOutputDerivatives(c, DERIVED, 4, ORDERS, by_2) == fmi2OK);
        CHECK(fmi3GetOutputDerivatives(c, DERIVED, 4, ORDERS, by_3, 4) == fmi3OK);
        CHECK(memcmp(by_2, by_3, sizeof by_2) == 0);
        check_finite(fmi2OK, by_2, 4);
    }
    fmi3FreeInstance(c);
}

/* Functions for what this FMU does not have refuse every call. */
static void attack_absent(void)
{
    fmi2Component c = create_initialized_3(fmi2CoSimulation, fmi3False);
    const fmi3ValueReference r = V_x;
    union { fmi3Float64 real; fmi3UInt64 number; fmi3Clock clock; } v[2] = {{0}};
    fmi3Binary binary = NULL;
    fmi3String string = "";
    fmi3IntervalQualifier qualifier;
    fmi3DependencyKind kind;
    size_t size = 0, element;
    fmi3ValueReference independent;
    void *value = v;
    const int statuses[] = {
        fmi3GetBinary(c, &r, 1, &size, &binary, 1), fmi3SetBinary(c, &r, 1, &size, &binary, 1),
        fmi3GetClock(c, &r, 1, value), fmi3SetClock(c, &r, 1, value),
        fmi3GetIntervalDecimal(c, &r, 1, value, &qualifier), fmi3SetIntervalDecimal(c, &r, 1, value),
        fmi3GetIntervalFraction(c, &r, 1, value, value, &qualifier),
        fmi3SetIntervalFraction(c, &r, 1, value, value), fmi3GetShiftDecimal(c, &r, 1, value),
        fmi3SetShiftDecimal(c, &r, 1, value), fmi3GetShiftFraction(c, &r, 1, value, value),
        fmi3SetShiftFraction(c, &r, 1, value, value), fmi3EnterConfigurationMode(c),
        fmi3ExitConfigurationMode(c), fmi3GetNumberOfVariableDependencies(c, r, &size),
        fmi3GetVariableDependencies(c, r, &element, &independent, &element, &kind, 1),
        fmi3ActivateModelPartition(c, r, 0.0), fmi3GetFloat32(c, &r, 1, value, 1),
        fmi3SetFloat32(c, &r, 1, value, 1), fmi3GetInt8(c, &r, 1, value, 1),
        fmi3SetInt8(c, &r, 1, value, 1), fmi3GetUInt8(c, &r, 1, value, 1),
        fmi3SetUInt8(c, &r, 1, value, 1), fmi3GetInt16(c, &r, 1, value, 1),
        fmi3SetInt16(c, &r, 1, value, 1), fmi3GetUInt16(c, &r, 1, value, 1),
        fmi3SetUInt16(c, &r, 1, value, 1), fmi3GetUInt32(c, &r, 1, value, 1),
        fmi3SetUInt32(c, &r, 1, value, 1), fmi3SetInt64(c, &r, 1, value, 1),
        fmi3GetUInt64(c, &r, 1, value, 1), fmi3SetUInt64(c, &r, 1, value, 1),
        fmi3GetString(c, &r, 1, &string, 1), fmi3SetString(c, &r, 1, &string, 1),
        fmi2GetString(c, &r, 1, &string), fmi2SetString(c, &r, 1, &string)};
    for (size_t n = 0; n < sizeof statuses / sizeof *statuses; n++)
        CHECK(statuses[n] == fmi3Error);
    CHECK(fmi2GetStatus(c, fmi2DoStepStatus, value) == fmi2OK);
    CHECK(fmi2GetRealStatus(c, fmi2LastSuccessfulTime, value) == fmi2OK && v->real == 0.0);
    CHECK(fmi2GetBooleanStatus(c, fmi2Terminated, value) == fmi2OK);
    CHECK(fmi2GetIntegerStatus(c, fmi2DoStepStatus, value) == fmi2Discard);
    CHECK(fmi2GetStringStatus(c, fmi2PendingStatus, &string) == fmi2Discard);
    CHECK(fmi2CancelStep(c) == fmi2Error);
    CHECK(*fmi2GetVersion() == '2' && *fmi3GetVersion() == '3' && *fmi2GetTypesPlatform());
    CHECK(!fmi3InstantiateScheduledExecution("a", SLIDER_BELT_GUID, NULL, 0, 0, NULL, check_message_3, NULL,
                                             NULL, NULL));
    fmi3FreeInstance(c);
}

/* An importer that calls random functions in intermediate updates; the step must continue. */
typedef struct {
    fmi3Instance c;
    fmi2FMUstate state;
    double last_time;
} Importer;

static void call_in_update(fmi3InstanceEnvironment environment, fmi3Float64 time,
                               fmi3Boolean wants_inputs, fmi3Boolean get_allowed, fmi3Boolean finished,
                               fmi3Boolean can_return, fmi3Boolean *is_early, fmi3Float64 *early)
{
    Importer *importer = environment;
    /* An update either asks for inputs before a part of the step, or lets outputs be read after it. */
    CHECK(can_return && wants_inputs != get_allowed && get_allowed == finished);
    CHECK(time >= importer->last_time);
    importer->last_time = finished ? time : importer->last_time;
    const fmi2ValueReference f = V_F, v = V_v_belt;
    const double force = random_below(4) ? 80.0 + random_below(9) : extreme_number();
    const double speed = random_below(4) ? 1.0 + 0.1 * random_below(9) : extreme_number();
    fmi3SetFloat64(importer->c, &f, 1, &force, 1);
    fmi3SetFloat64(importer->c, &v, 1, &speed, 1);
    for (unsigned remaining = random_below(4); remaining > 0; remaining--)
        call_at_random(importer->c, &importer->state);
    /* Neither call frees anything: the step in progress needs the instance. */
    fmi3FreeInstance(random_below(8) ? NULL : importer->c);
    *is_early = random_below(4) == 0, *early = random_below(2) ? time : extreme_number();
}

static void attack_updates(int rounds, fmi3Boolean events)
{
    const fmi3ValueReference needed[] = {V_F, V_mu, V_x, V_v_belt};
    Importer importer = {0};
    fmi3Boolean event, stops, early, flags[5];
    double t = 0.0, reached;
    int switches = 0;
    importer.c = fmi3InstantiateCoSimulation("attacked", SLIDER_BELT_GUID, NULL, 0, 1, events, 1, needed, 4,
                                       &importer, check_message_3, call_in_update);
    CHECK(importer.c);
    choose_belt(importer.c);
    CHECK(fmi3EnterInitializationMode(importer.c, 0, 0.0, 0.0, 0, 0.0) == fmi3OK);
    CHECK(fmi3ExitInitializationMode(importer.c) == fmi3OK);
    CHECK(!events || fmi3EnterStepMode(importer.c) == fmi3OK);
    for (int round = 0; round < rounds; round++) {
        const double h = 0.01 * (1.0 + random_below(50));
        const fmi3Status status = fmi3DoStep(importer.c, t, h, 1, &event, &stops, &early, &reached);
        if (status == fmi3Discard) {
            /* A force was too large: the instance is unchanged. */
            CHECK(reached == t);
            importer.last_time = t;
            continue;
        }
        CHECK(status == fmi3OK);
        CHECK(reached >= t && reached <= t + h && !stops);
        CHECK(early == (reached < t + h) && (events || !event));
        t = reached, switches += event;
        if (!event || !random_below(8))
            continue;
        CHECK(fmi3EnterEventMode(importer.c) == fmi3OK);
        CHECK(fmi3UpdateDiscreteStates(importer.c, flags, flags + 1, flags + 2, flags + 3, flags + 4, &reached)
              == fmi3OK);
        CHECK(fmi3EnterStepMode(importer.c) == fmi3OK);
    }
    CHECK(!events || rounds < 50 || switches > 0);
    fmi2FreeFMUstate(importer.c, &importer.state);
    fmi3FreeInstance(importer.c);
}

static void ignore_update(fmi3InstanceEnvironment environment, fmi3Float64 time, fmi3Boolean wants_inputs,
                     fmi3Boolean get_allowed, fmi3Boolean finished, fmi3Boolean can_return,
                     fmi3Boolean *is_early, fmi3Float64 *early)
{
    (void)environment, (void)time, (void)wants_inputs, (void)get_allowed, (void)finished;
    (void)can_return, (void)is_early, (void)early;
}

/* A step that would never end is refused, with updates and without, and changes nothing. */
static void attack_by_endless_step(fmi3IntermediateUpdateCallback update, size_t required)
{
    const fmi3ValueReference needed = V_F;
    fmi3Boolean flags[3];
    double reached;
    fmi3Instance c = fmi3InstantiateCoSimulation("attacked", SLIDER_BELT_GUID, NULL, 0, 1, 0, 1, &needed,
                                                 required, NULL, check_message_3, update);
    CHECK(c);
    choose_belt(c);
    CHECK(fmi3EnterInitializationMode(c, 0, 0.0, 0.0, 0, 0.0) == fmi3OK);
    CHECK(fmi3ExitInitializationMode(c) == fmi3OK);
    /* So many seconds need more internal steps than the limit of a communication step. */
    CHECK(fmi3DoStep(c, 0.0, 1e206, 1, flags, flags + 1, flags + 2, &reached) == fmi3Discard);
    CHECK(reached == 0.0);
    CHECK(fmi3DoStep(c, 0.0, 0.1, 1, flags, flags + 1, flags + 2, &reached) == fmi3OK);
    CHECK(reached == 0.1);
    fmi3FreeInstance(c);
}

static long resident_pages(void)
{
    long total, pages = 0;
    FILE *file = fopen("/proc/self/statm", "r");
    if (!file || fscanf(file, "%ld %ld", &total, &pages) != 2)
        pages = 0;
    if (file)
        fclose(file);
    return pages;
}

/* Print the pages of memory that many steps, then many instances, do not release. */
static void measure_memory(int steps, int instances)
{
    fmi2Component c = create_initialized(fmi2CoSimulation);
    const fmi2ValueReference f = V_F;
    long before = 0;
    for (int step = 0; step < steps; step++) {
        const double force = 80.0 + step % 7;
        if (step == steps / 10)
            before = resident_pages();
        if (step % 100 == 0)
            CHECK(fmi2SetReal(c, &f, 1, &force) == fmi2OK);
        CHECK(fmi2DoStep(c, step * 1e-3, 1e-3, 1) == fmi2OK);
    }
    printf("%ld\n", resident_pages() - before);
    fmi2FreeInstance(c);
    for (int number = 0; number < instances; number++) {
        if (number == instances / 10)
            before = resident_pages();
        c = create_initialized(fmi2CoSimulation);
        CHECK(fmi2DoStep(c, 0.0, 0.1, 1) == fmi2OK);
        fmi2FreeInstance(c);
    }
    printf("%ld\n", resident_pages() - before);
}

int main(int count, char **arguments)
{
    CHECK(count == 5);
    const int rounds = atoi(arguments[3]);
    random_state = 88172645463325252u + (uint64_t)atoll(arguments[4]);
    CHECK(!fmi2Instantiate("a", fmi2CoSimulation, SLIDER_BELT_GUID, NULL, NULL, 0, 0));
    CHECK(fmi2DoStep(NULL, 0.0, 1.0, 1) == fmi2Error);
    fmi2FreeInstance(NULL);
    for (has_finite_belt = 0; has_finite_belt < 2; has_finite_belt++) {
        attack_states(rounds);
        attack_calls(rounds);
        attack_tuning(rounds, fmi3False);
        attack_tuning(rounds, fmi3True);
        attack_absent();
        attack_updates(rounds, fmi3False);
        attack_updates(rounds, fmi3True);
        attack_by_endless_step(NULL, 0);
        attack_by_endless_step(ignore_update, 0);
        attack_by_endless_step(ignore_update, 1);
    }
    measure_memory(atoi(arguments[1]), atoi(arguments[2]));
    return 0;
}
