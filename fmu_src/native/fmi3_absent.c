/* FMI 3.0: functions that this FMU refuses (clocks, binary values, configuration, partitions). */

#include "instance.h"

#pragma GCC diagnostic ignored "-Wunused-parameter"

/* A function that reports which features are absent. */
#define ABSENT(name, features, ...)                                                             \
    fmi3Status name(fmi3Instance c, __VA_ARGS__)                                                \
    {                                                                                           \
        return c ? (fmi3Status)report(c, fmi2Error, "there are no " features) : fmi3Error;      \
    }
#define REFERENCES const fmi3ValueReference r[], size_t count

ABSENT(fmi3GetBinary, "variables of type Binary", REFERENCES, size_t sizes[], fmi3Binary values[],
       size_t value_count)
ABSENT(fmi3SetBinary, "variables of type Binary", REFERENCES, const size_t sizes[],
       const fmi3Binary values[], size_t value_count)
ABSENT(fmi3GetClock, "clocks", REFERENCES, fmi3Clock values[])
ABSENT(fmi3SetClock, "clocks", REFERENCES, const fmi3Clock values[])
ABSENT(fmi3GetIntervalDecimal, "clocks", REFERENCES, fmi3Float64 intervals[],
       fmi3IntervalQualifier qualifiers[])
ABSENT(fmi3SetIntervalDecimal, "clocks", REFERENCES, const fmi3Float64 intervals[])
ABSENT(fmi3GetIntervalFraction, "clocks", REFERENCES, fmi3UInt64 counters[],
       fmi3UInt64 resolutions[], fmi3IntervalQualifier qualifiers[])
ABSENT(fmi3SetIntervalFraction, "clocks", REFERENCES, const fmi3UInt64 counters[],
       const fmi3UInt64 resolutions[])
ABSENT(fmi3GetShiftDecimal, "clocks", REFERENCES, fmi3Float64 shifts[])
ABSENT(fmi3SetShiftDecimal, "clocks", REFERENCES, const fmi3Float64 shifts[])
ABSENT(fmi3GetShiftFraction, "clocks", REFERENCES, fmi3UInt64 counters[], fmi3UInt64 resolutions[])
ABSENT(fmi3SetShiftFraction, "clocks", REFERENCES, const fmi3UInt64 counters[],
       const fmi3UInt64 resolutions[])
ABSENT(fmi3GetNumberOfVariableDependencies, "dependencies of array elements",
       fmi3ValueReference reference, size_t *count)
ABSENT(fmi3GetVariableDependencies, "dependencies of array elements", fmi3ValueReference dependent,
       size_t elements[], fmi3ValueReference independents[], size_t independent_elements[],
       fmi3DependencyKind kinds[], size_t count)
ABSENT(fmi3ActivateModelPartition, "model partitions", fmi3ValueReference clock, fmi3Float64 time)

static fmi3Status refuse_configuration(Instance *i)
{
    return i ? (fmi3Status)report(i, fmi2Error, "there are no structural parameters") : fmi3Error;
}

fmi3Status fmi3EnterConfigurationMode(fmi3Instance c) { return refuse_configuration(c); }
fmi3Status fmi3ExitConfigurationMode(fmi3Instance c) { return refuse_configuration(c); }
