/* FMI 3.0: values of variables by type, and derivatives with respect to them. */

#include <math.h>

#include "instance.h"

/* Value references after those of the table: of the time, then of the event indicators. */
#define TIME COMPONENT.variable_count
#define FIRST_INDICATOR (COMPONENT.variable_count + 1)

/* Refuse a call with unequal numbers of value references and values: no variable is an array. */
static fmi3Status check_counts(Instance *i, size_t references, size_t values)
{
    if (!i)
        return fmi3Error;
    if (references == values)
        return fmi3OK;
    return (fmi3Status)report(i, fmi2Error, "%zu value references, but %zu values", references,
                              values);
}

fmi3Status fmi3GetFloat64(fmi3Instance c, const fmi3ValueReference r[], size_t count,
                          fmi3Float64 values[], size_t value_count)
{
    Instance *i = c;
    fmi3Status status = check_counts(i, count, value_count);
    status = status == fmi3OK ? (fmi3Status)check_readable(i) : status;
    for (size_t n = 0; n < count && r && values && status == fmi3OK; n++) {
        if (r[n] == TIME) {
            /* `t` is set when the motion begins. */
            values[n] = i->s.has_motion ? i->s.t : i->s.start_time;
        } else if (r[n] >= FIRST_INDICATOR && r[n] - FIRST_INDICATOR < COMPONENT.indicator_count) {
            double indicators[MAX_INDICATORS];
            status = (fmi3Status)compute_indicators(i, indicators);
            if (status == fmi3OK)
                values[n] = indicators[r[n] - FIRST_INDICATOR];
        } else {
            status = (fmi3Status)fmi2GetReal(c, r + n, 1, values + n);
        }
    }
    if (status != fmi3OK || (r && values))
        return status;
    /* A pointer is missing: fmi2GetReal refuses it. */
    return (fmi3Status)fmi2GetReal(c, r, count, values);
}

fmi3Status fmi3SetFloat64(fmi3Instance c, const fmi3ValueReference r[], size_t count,
                          const fmi3Float64 values[], size_t value_count)
{
    fmi3Status status = check_counts(c, count, value_count);
    return status == fmi3OK ? (fmi3Status)fmi2SetReal(c, r, count, values) : status;
}

fmi3Status fmi3GetInt32(fmi3Instance c, const fmi3ValueReference r[], size_t count,
                        fmi3Int32 values[], size_t value_count)
{
    fmi3Status status = check_counts(c, count, value_count);
    return status == fmi3OK ? (fmi3Status)fmi2GetInteger(c, r, count, values) : status;
}

fmi3Status fmi3SetInt32(fmi3Instance c, const fmi3ValueReference r[], size_t count,
                        const fmi3Int32 values[], size_t value_count)
{
    fmi3Status status = check_counts(c, count, value_count);
    return status == fmi3OK ? (fmi3Status)fmi2SetInteger(c, r, count, values) : status;
}

/* Importers read enumerations by this function. */
fmi3Status fmi3GetInt64(fmi3Instance c, const fmi3ValueReference r[], size_t count,
                        fmi3Int64 values[], size_t value_count)
{
    fmi3Status status = check_counts(c, count, value_count);
    for (size_t n = 0; n < count && status == fmi3OK; n++) {
        fmi2Integer value = 0;
        status = (fmi3Status)fmi2GetInteger(c, r ? r + n : NULL, 1, values ? &value : NULL);
        if (status == fmi3OK)
            values[n] = value;
    }
    return status;
}

fmi3Status fmi3GetBoolean(fmi3Instance c, const fmi3ValueReference r[], size_t count,
                          fmi3Boolean values[], size_t value_count)
{
    fmi3Status status = check_counts(c, count, value_count);
    for (size_t n = 0; n < count && status == fmi3OK; n++) {
        fmi2Boolean value = 0;
        status = (fmi3Status)fmi2GetBoolean(c, r ? r + n : NULL, 1, values ? &value : NULL);
        if (status == fmi3OK)
            values[n] = value != 0;
    }
    return status;
}

fmi3Status fmi3SetBoolean(fmi3Instance c, const fmi3ValueReference r[], size_t count,
                          const fmi3Boolean values[], size_t value_count)
{
    fmi2Boolean numbers[MAX_VARIABLES];
    fmi3Status status = check_counts(c, count, value_count);
    if (status == fmi3OK && count > MAX_VARIABLES)
        status = (fmi3Status)report(c, fmi2Error, "%zu values: there are fewer variables", count);
    if (status != fmi3OK)
        return status;
    for (size_t n = 0; n < count && values; n++)
        numbers[n] = values[n];
    return (fmi3Status)fmi2SetBoolean(c, r, count, values ? numbers : NULL);
}

/* Functions for types that no variable has: without references they succeed. */
#define NO_GETTER(Type)                                                                       \
    fmi3Status fmi3Get##Type(fmi3Instance c, const fmi3ValueReference r[], size_t count,      \
                             fmi3##Type values[], size_t value_count)                         \
    {                                                                                         \
        (void)r, (void)values, (void)value_count;                                             \
        if (!c)                                                                               \
            return fmi3Error;                                                                 \
        return count == 0 ? fmi3OK                                                            \
                          : (fmi3Status)report(c, fmi2Error, "no variable is of type "        \
                                                             #Type);                          \
    }
#define NO_SETTER(Type)                                                                       \
    fmi3Status fmi3Set##Type(fmi3Instance c, const fmi3ValueReference r[], size_t count,      \
                             const fmi3##Type values[], size_t value_count)                   \
    {                                                                                         \
        (void)r, (void)values, (void)value_count;                                             \
        if (!c)                                                                               \
            return fmi3Error;                                                                 \
        return count == 0 ? fmi3OK                                                            \
                          : (fmi3Status)report(c, fmi2Error, "no variable of type " #Type     \
                                                             " can be set");                  \
    }
#define NO_ACCESS(Type) NO_GETTER(Type) NO_SETTER(Type)

NO_ACCESS(Float32)
NO_ACCESS(Int8)
NO_ACCESS(UInt8)
NO_ACCESS(Int16)
NO_ACCESS(UInt16)
NO_ACCESS(UInt32)
NO_ACCESS(UInt64)
NO_ACCESS(String)
NO_SETTER(Int64)

fmi3Status fmi3GetOutputDerivatives(fmi3Instance c, const fmi3ValueReference r[], size_t count,
                                    const fmi3Int32 orders[], fmi3Float64 values[],
                                    size_t value_count)
{
    fmi3Status status = check_counts(c, count, value_count);
    return status == fmi3OK ? (fmi3Status)fmi2GetRealOutputDerivatives(c, r, count, orders, values)
                            : status;
}

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance c, const fmi3ValueReference unknowns[],
                                        size_t unknown_count, const fmi3ValueReference knowns[],
                                        size_t known_count, const fmi3Float64 seed[],
                                        size_t seed_count, fmi3Float64 result[],
                                        size_t result_count)
{
    fmi3Status status = check_counts(c, known_count, seed_count);
    status = status == fmi3OK ? check_counts(c, unknown_count, result_count) : status;
    if (status != fmi3OK)
        return status;
    return (fmi3Status)fmi2GetDirectionalDerivative(c, unknowns, unknown_count, knowns, known_count,
                                                    seed, result);
}

fmi3Status fmi3GetAdjointDerivative(fmi3Instance c, const fmi3ValueReference unknowns[],
                                    size_t unknown_count, const fmi3ValueReference knowns[],
                                    size_t known_count, const fmi3Float64 seed[], size_t seed_count,
                                    fmi3Float64 result[], size_t result_count)
{
    fmi3Status status = check_counts(c, unknown_count, seed_count);
    status = status == fmi3OK ? check_counts(c, known_count, result_count) : status;
    if (status != fmi3OK)
        return status;
    return (fmi3Status)get_adjoint_derivative(c, unknowns, unknown_count, knowns, known_count, seed,
                                              result);
}
