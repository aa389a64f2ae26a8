/* Save, restore and serialise the state of an instance.

   A serialised state has, in this order and little-endian: "fivtuiFM", version and count of numbers
   (32 bits each), 32 letters that identify the build, the numbers (64 bits each), and a CRC-32 of
   all bytes before it. Taylor polynomials are not stored: the step of the motion is computed again
   from its start, to the same bits. */

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "build.h"
#include "instance.h"

#define VERSION 1
/* Sizes of the parts, in bytes, and offsets of version, count, build and numbers. */
enum {
    MAGIC = 8, INTEGER_SIZE = 4, BUILD = 32, NUMBER_SIZE = 8,
    VERSION_AT = MAGIC, COUNT_AT = VERSION_AT + INTEGER_SIZE, BUILD_AT = COUNT_AT + INTEGER_SIZE,
    NUMBERS_AT = BUILD_AT + BUILD
};
/* Indices of the first numbers: type, and members of `State` in `instance.h`. The values of the
   variables, their slopes, the states and the motion follow. */
enum {
    N_TYPE, N_PHASE, N_IS_SET_UP, N_HAS_MOTION, N_HAS_SLOPES, N_HAS_INPUTS_OF_STEP,
    N_SWITCH_PENDING, N_START_TIME, N_STOP_TIME, N_TOLERANCE, N_TIME, FIXED_COUNT
};

static const char MAGIC_TEXT[MAGIC + 1] = "fivtuiFM";
static const char BUILD_TEXT[BUILD + 1] = BUILD_NAME;

typedef struct {
    fmi2Type type;
    State s;
} Saved;

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    Instance *i = c;
    REQUIRE(i, "get_fmu_state", ANY_TYPE, ~IN(INTERMEDIATE));
    if (!state)
        return report(i, fmi2Error, "get_fmu_state: a pointer to the state must be given");
    Saved *saved = *state ? *state : malloc(sizeof *saved);
    if (!saved)
        return report(i, fmi2Error, "get_fmu_state: out of memory");
    saved->type = i->type, saved->s = i->s;
    *state = saved;
    return fmi2OK;
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state)
{
    Instance *i = c;
    const Saved *saved = state;
    REQUIRE(i, "set_fmu_state", ANY_TYPE, ~IN(INTERMEDIATE));
    if (!saved)
        return report(i, fmi2Error, "there is no such FMU state");
    if (saved->type != i->type)
        return report(i, fmi2Error, "the FMU state is of %s",
                      saved->type == fmi2CoSimulation ? "co-simulation" : "model exchange");
    i->s = saved->s;
    return fmi2OK;
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    if (!c)
        return fmi2Error;
    if (state) {
        free(*state);
        *state = NULL;
    }
    return fmi2OK;
}

static size_t number_count(void)
{
    return FIXED_COUNT + 2 * COMPONENT.variable_count + MAX_STATES + MOTION_NUMBERS;
}

static size_t byte_count(void)
{
    return NUMBERS_AT + NUMBER_SIZE * number_count() + INTEGER_SIZE;
}

static void write_integer(unsigned char *bytes, uint64_t value, int count)
{
    for (int n = 0; n < count; n++)
        bytes[n] = (unsigned char)(value >> 8 * n);
}

static uint64_t read_integer(const unsigned char *bytes, int count)
{
    uint64_t value = 0;
    for (int n = 0; n < count; n++)
        value |= (uint64_t)bytes[n] << 8 * n;
    return value;
}

/* CRC-32 with the polynomial of zip files. */
static uint32_t checksum(const unsigned char *bytes, size_t count)
{
    uint32_t crc = UINT32_MAX;
    for (size_t n = 0; n < count; n++) {
        crc ^= bytes[n];
        for (int bit = 0; bit < 8; bit++)
            crc = (crc >> 1) ^ (crc & 1u ? UINT32_C(0xedb88320) : 0);
    }
    return ~crc;
}

/* Write a saved state as number_count() numbers. */
static void pack(const Saved *saved, const Instance *i, double *numbers)
{
    const State *s = &saved->s;
    const uint32_t count = COMPONENT.variable_count;
    /* COMPONENT.pack reads the motion from an instance. */
    Instance scratch = *i;
    scratch.s = *s;
    memset(numbers, 0, number_count() * sizeof *numbers);
    numbers[N_TYPE] = saved->type, numbers[N_PHASE] = s->phase, numbers[N_IS_SET_UP] = s->is_set_up;
    numbers[N_HAS_MOTION] = s->has_motion, numbers[N_HAS_SLOPES] = s->has_slopes;
    numbers[N_HAS_INPUTS_OF_STEP] = s->has_inputs_of_step;
    numbers[N_SWITCH_PENDING] = s->switch_pending;
    numbers[N_START_TIME] = s->start_time, numbers[N_STOP_TIME] = s->stop_time;
    numbers[N_TOLERANCE] = s->tolerance, numbers[N_TIME] = s->t;
    numbers += FIXED_COUNT;
    for (uint32_t r = 0; r < count; r++)
        if (is_settable(COMPONENT.variables + r))
            numbers[r] = s->values[r], numbers[count + r] = s->slopes[r];
    memcpy(numbers + 2 * count, s->states, MAX_STATES * sizeof *numbers);
    if (s->has_motion)
        COMPONENT.pack(&scratch, numbers + 2 * count + MAX_STATES);
}

static int is_whole_number(double number, double limit)
{
    return number >= 0.0 && number <= limit && number == (double)(int)number;
}

/* Restore the state of an instance from numbers; returns whether they are valid. */
static int unpack(Instance *i, const double *numbers)
{
    State *s = &i->s;
    const uint32_t count = COMPONENT.variable_count;
    clear_state(s);
    for (size_t n = 0; n < number_count(); n++)
        if (!isfinite(numbers[n]) && !(n == N_STOP_TIME && numbers[n] > 0.0))
            return 0;
    if (numbers[N_TYPE] != i->type || !is_whole_number(numbers[N_PHASE], TERMINATED)
        || !is_whole_number(numbers[N_IS_SET_UP], 1) || !is_whole_number(numbers[N_HAS_MOTION], 1)
        || !is_whole_number(numbers[N_HAS_SLOPES], 1)
        || !is_whole_number(numbers[N_HAS_INPUTS_OF_STEP], 1)
        || !is_whole_number(numbers[N_SWITCH_PENDING], 1)
        || numbers[N_STOP_TIME] < numbers[N_START_TIME]
        || !(numbers[N_TOLERANCE] >= LEAST_TOLERANCE
             && numbers[N_TOLERANCE] <= GREATEST_TOLERANCE))
        return 0;
    s->phase = (Phase)(int)numbers[N_PHASE], s->is_set_up = numbers[N_IS_SET_UP] != 0.0;
    s->has_motion = numbers[N_HAS_MOTION] != 0.0, s->has_slopes = numbers[N_HAS_SLOPES] != 0.0;
    s->has_inputs_of_step = numbers[N_HAS_INPUTS_OF_STEP] != 0.0;
    s->switch_pending = numbers[N_SWITCH_PENDING] != 0.0;
    s->start_time = numbers[N_START_TIME], s->stop_time = numbers[N_STOP_TIME];
    s->tolerance = numbers[N_TOLERANCE], s->t = numbers[N_TIME];
    numbers += FIXED_COUNT;
    for (uint32_t r = 0; r < count; r++) {
        const Variable *v = COMPONENT.variables + r;
        if (!is_settable(v))
            continue;
        if (!(numbers[r] <= v->upper && numbers[r] >= v->lower)
            || (v->kind == BOOLEAN && !is_whole_number(numbers[r], 1)))
            return 0;
        s->values[r] = numbers[r], s->slopes[r] = numbers[count + r];
    }
    memcpy(s->states, numbers + 2 * count, MAX_STATES * sizeof *numbers);
    return !s->has_motion || COMPONENT.unpack(i, numbers + 2 * count + MAX_STATES);
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size)
{
    Instance *i = c;
    if (!i)
        return fmi2Error;
    if (!state || !size)
        return report(i, fmi2Error, "there is no such FMU state");
    *size = byte_count();
    return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size)
{
    Instance *i = c;
    unsigned char *out = (unsigned char *)bytes;
    double numbers[FIXED_COUNT + 2 * MAX_VARIABLES + MAX_STATES + MOTION_NUMBERS];
    if (!i)
        return fmi2Error;
    if (!state || !bytes)
        return report(i, fmi2Error, "there is no such FMU state");
    if (size < byte_count())
        return report(i, fmi2Error, "%zu bytes: must be at least %zu", size, byte_count());
    pack(state, i, numbers);
    memset(out, 0, size);
    memcpy(out, MAGIC_TEXT, MAGIC);
    write_integer(out + VERSION_AT, VERSION, INTEGER_SIZE);
    write_integer(out + COUNT_AT, number_count(), INTEGER_SIZE);
    memcpy(out + BUILD_AT, BUILD_TEXT, BUILD);
    for (size_t n = 0; n < number_count(); n++) {
        uint64_t bits;
        memcpy(&bits, numbers + n, NUMBER_SIZE);
        write_integer(out + NUMBERS_AT + NUMBER_SIZE * n, bits, NUMBER_SIZE);
    }
    const size_t checksum_at = byte_count() - INTEGER_SIZE;
    write_integer(out + checksum_at, checksum(out, checksum_at), INTEGER_SIZE);
    return fmi2OK;
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size,
                                   fmi2FMUstate *state)
{
    Instance *i = c;
    const unsigned char *in = (const unsigned char *)bytes;
    double numbers[FIXED_COUNT + 2 * MAX_VARIABLES + MAX_STATES + MOTION_NUMBERS];
    if (!i)
        return fmi2Error;
    if (!state || !bytes)
        return report(i, fmi2Error, "bytes and a pointer to the state must be given");
    if (size >= NUMBERS_AT && memcmp(in, MAGIC_TEXT, MAGIC) == 0
        && read_integer(in + VERSION_AT, INTEGER_SIZE) == VERSION
        && memcmp(in + BUILD_AT, BUILD_TEXT, BUILD) != 0)
        return report(i, fmi2Error,
                      "the serialised FMU state comes from another build of this FMU");
    Instance scratch = *i;
    const size_t checksum_at = byte_count() - INTEGER_SIZE;
    int is_intact = size == byte_count() && memcmp(in, MAGIC_TEXT, MAGIC) == 0
                    && read_integer(in + VERSION_AT, INTEGER_SIZE) == VERSION
                    && read_integer(in + COUNT_AT, INTEGER_SIZE) == number_count()
                    && read_integer(in + checksum_at, INTEGER_SIZE) == checksum(in, checksum_at);
    for (size_t n = 0; is_intact && n < number_count(); n++) {
        uint64_t bits = read_integer(in + NUMBERS_AT + NUMBER_SIZE * n, NUMBER_SIZE);
        memcpy(numbers + n, &bits, NUMBER_SIZE);
    }
    if (!is_intact || !unpack(&scratch, numbers))
        return report(i, fmi2Error, "the serialised FMU state is damaged");
    /* *state may be uninitialised: do not reuse it. */
    Saved *saved = malloc(sizeof *saved);
    if (!saved)
        return report(i, fmi2Error, "deserialize_fmu_state: out of memory");
    saved->type = scratch.type, saved->s = scratch.s;
    *state = saved;
    return fmi2OK;
}
