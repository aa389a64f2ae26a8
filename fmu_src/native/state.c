/* The state of an instance: saved, restored, and as bytes.

   Bytes are, in order and little-endian: "fivtuiFM", version and count of numbers (32 bits each),
   32 letters that name the build of the FMU, the numbers (64 bits each), and a CRC-32 of all before
   it. Steps of the motion are computed again from where they start, to the same bits. */

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "build.h"
#include "instance.h"

#define VERSION 1
enum { MAGIC = 8, BUILD = 32, HEAD = MAGIC + 8 + BUILD, TAIL = 4 };
/* Numbers before those of variables. */
enum { N_TYPE, N_PHASE, N_SET_UP, N_BEGUN, N_SLOPED, N_LEFT, N_PENDING, N_START, N_STOP, N_TOLERANCE, N_T, FIXED };

static const char MAGIC_TEXT[MAGIC + 1] = "fivtuiFM";
static const char BUILD_TEXT[BUILD + 1] = BUILD_NAME;

typedef struct {
    fmi2Type type;
    State s;
} Saved;

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    Instance *i = c;
    ALLOWED("get_fmu_state", EITHER, ~IN(INTERMEDIATE));
    if (!state)
        return refuse(i, fmi2Error, "get_fmu_state: a place for the state must be given");
    Saved *saved = *state ? *state : malloc(sizeof *saved);
    if (!saved)
        return refuse(i, fmi2Error, "get_fmu_state: there is no memory");
    saved->type = i->type, saved->s = i->s;
    *state = saved;
    return fmi2OK;
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state)
{
    Instance *i = c;
    const Saved *saved = state;
    ALLOWED("set_fmu_state", EITHER, ~IN(INTERMEDIATE));
    if (!saved)
        return refuse(i, fmi2Error, "there is no such FMU state");
    if (saved->type != i->type)
        return refuse(i, fmi2Error, "the FMU state is of %s",
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
    return FIXED + 2 * COMPONENT.variable_count + MOST_STATES + MOTION_NUMBERS;
}

static size_t byte_count(void) { return HEAD + 8 * number_count() + TAIL; }

static void put(unsigned char *bytes, uint64_t value, int count)
{
    for (int n = 0; n < count; n++)
        bytes[n] = (unsigned char)(value >> 8 * n);
}

static uint64_t get(const unsigned char *bytes, int count)
{
    uint64_t value = 0;
    for (int n = 0; n < count; n++)
        value |= (uint64_t)bytes[n] << 8 * n;
    return value;
}

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

static void pack(const Saved *saved, const Instance *i, double *numbers)
{
    const State *s = &saved->s;
    const uint32_t count = COMPONENT.variable_count;
    Instance scratch = *i;
    scratch.s = *s;
    memset(numbers, 0, number_count() * sizeof *numbers);
    numbers[N_TYPE] = saved->type, numbers[N_PHASE] = s->phase, numbers[N_SET_UP] = s->is_set_up;
    numbers[N_BEGUN] = s->begun, numbers[N_SLOPED] = s->is_sloped;
    numbers[N_LEFT] = s->are_left, numbers[N_PENDING] = s->is_pending;
    numbers[N_START] = s->start_time, numbers[N_STOP] = s->stop_time;
    numbers[N_TOLERANCE] = s->tolerance, numbers[N_T] = s->t;
    numbers += FIXED;
    for (uint32_t r = 0; r < count; r++)
        if (is_settable(COMPONENT.variables + r))
            numbers[r] = s->values[r], numbers[count + r] = s->slopes[r];
    memcpy(numbers + 2 * count, s->states, MOST_STATES * sizeof *numbers);
    if (s->begun)
        COMPONENT.pack(&scratch, numbers + 2 * count + MOST_STATES);
}

static int is_one_of(double number, double most)
{
    return number >= 0.0 && number <= most && number == (double)(int)number;
}

static int unpack(Instance *i, const double *numbers)
{
    State *s = &i->s;
    const uint32_t count = COMPONENT.variable_count;
    clear_state(s);
    for (size_t n = 0; n < number_count(); n++)
        if (!isfinite(numbers[n]) && !(n == N_STOP && numbers[n] > 0.0))
            return 0;
    if (numbers[N_TYPE] != i->type || !is_one_of(numbers[N_PHASE], TERMINATED)
        || !is_one_of(numbers[N_SET_UP], 1) || !is_one_of(numbers[N_BEGUN], 1)
        || !is_one_of(numbers[N_SLOPED], 1) || !is_one_of(numbers[N_LEFT], 1)
        || !is_one_of(numbers[N_PENDING], 1) || numbers[N_STOP] < numbers[N_START]
        || !(numbers[N_TOLERANCE] >= 1e-13 && numbers[N_TOLERANCE] <= 1e-2))
        return 0;
    s->phase = (Phase)(int)numbers[N_PHASE], s->is_set_up = numbers[N_SET_UP] != 0.0;
    s->begun = numbers[N_BEGUN] != 0.0, s->is_sloped = numbers[N_SLOPED] != 0.0;
    s->are_left = numbers[N_LEFT] != 0.0, s->is_pending = numbers[N_PENDING] != 0.0;
    s->start_time = numbers[N_START], s->stop_time = numbers[N_STOP];
    s->tolerance = numbers[N_TOLERANCE], s->t = numbers[N_T];
    numbers += FIXED;
    for (uint32_t r = 0; r < count; r++) {
        const Variable *v = COMPONENT.variables + r;
        if (!is_settable(v))
            continue;
        if (!(numbers[r] <= v->upper && numbers[r] >= v->lower)
            || (v->kind == BOOLEAN && !is_one_of(numbers[r], 1)))
            return 0;
        s->values[r] = numbers[r], s->slopes[r] = numbers[count + r];
    }
    memcpy(s->states, numbers + 2 * count, MOST_STATES * sizeof *numbers);
    return !s->begun || COMPONENT.unpack(i, numbers + 2 * count + MOST_STATES);
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size)
{
    Instance *i = c;
    if (!i)
        return fmi2Error;
    if (!state || !size)
        return refuse(i, fmi2Error, "there is no such FMU state");
    *size = byte_count();
    return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size)
{
    Instance *i = c;
    unsigned char *out = (unsigned char *)bytes;
    double numbers[FIXED + 2 * MOST_VARIABLES + MOST_STATES + MOTION_NUMBERS];
    if (!i)
        return fmi2Error;
    if (!state || !bytes)
        return refuse(i, fmi2Error, "there is no such FMU state");
    if (size < byte_count())
        return refuse(i, fmi2Error, "%zu bytes: must be at least %zu", size, byte_count());
    pack(state, i, numbers);
    memset(out, 0, size);
    memcpy(out, MAGIC_TEXT, MAGIC);
    put(out + MAGIC, VERSION, 4);
    put(out + MAGIC + 4, number_count(), 4);
    memcpy(out + MAGIC + 8, BUILD_TEXT, BUILD);
    for (size_t n = 0; n < number_count(); n++) {
        uint64_t bits;
        memcpy(&bits, numbers + n, 8);
        put(out + HEAD + 8 * n, bits, 8);
    }
    put(out + byte_count() - TAIL, checksum(out, byte_count() - TAIL), 4);
    return fmi2OK;
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size,
                                   fmi2FMUstate *state)
{
    Instance *i = c;
    const unsigned char *in = (const unsigned char *)bytes;
    double numbers[FIXED + 2 * MOST_VARIABLES + MOST_STATES + MOTION_NUMBERS];
    if (!i)
        return fmi2Error;
    if (!state || !bytes)
        return refuse(i, fmi2Error, "bytes, and a place for the state, must be given");
    if (size >= HEAD && memcmp(in, MAGIC_TEXT, MAGIC) == 0 && get(in + MAGIC, 4) == VERSION
        && memcmp(in + MAGIC + 8, BUILD_TEXT, BUILD) != 0)
        return refuse(i, fmi2Error,
                      "the serialised FMU state comes from another build of this FMU");
    Instance scratch = *i;
    int good = size == byte_count() && memcmp(in, MAGIC_TEXT, MAGIC) == 0
               && get(in + MAGIC, 4) == VERSION && get(in + MAGIC + 4, 4) == number_count()
               && get(in + size - TAIL, 4) == checksum(in, size - TAIL);
    for (size_t n = 0; good && n < number_count(); n++) {
        uint64_t bits = get(in + HEAD + 8 * n, 8);
        memcpy(numbers + n, &bits, 8);
    }
    if (!good || !unpack(&scratch, numbers))
        return refuse(i, fmi2Error, "the serialised FMU state is damaged");
    /* Nothing is known about what *state points to. */
    Saved *saved = malloc(sizeof *saved);
    if (!saved)
        return refuse(i, fmi2Error, "deserialize_fmu_state: there is no memory");
    saved->type = scratch.type, saved->s = scratch.s;
    *state = saved;
    return fmi2OK;
}
