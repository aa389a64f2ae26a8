/* FMI 3.0: functions that this FMU refuses (clocks, binary values, configuration, partitions). */

#include "instance.h"

#pragma GCC diagnostic ignored "-Wunused-parameter"

/* A function that reports which features are absent. Its first parameter is the instance `c`. */
#define ABSENT(name, features, ...)                                                             \
    fmi3Status name(__VA_ARGS__)                                                                \
    {                                                                                           \
        return c ? (fmi3Status)report(c, fmi2Error, "there are no " features) : fmi3Error;      \
    }
#define REFERENCES fmi3Instance c, const fmi3ValueReference r[], size_t count

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
ABSENT(fmi3GetNumberOfVariableDependencies, "dependencies of array elements", fmi3Instance c,
       fmi3ValueReference reference, size_t *count)
ABSENT(fmi3GetVariableDependencies, "dependencies of array elements", fmi3Instance c,
       fmi3ValueReference dependent, size_t elements[], fmi3ValueReference independents[],
       size_t independent_elements[], fmi3DependencyKind kinds[], size_t count)
ABSENT(fmi3ActivateModelPartition, "model partitions", fmi3Instance c, fmi3ValueReference clock,
       fmi3Float64 time)
ABSENT(fmi3EnterConfigurationMode, "structural parameters", fmi3Instance c)
ABSENT(fmi3ExitConfigurationMode, "structural parameters", fmi3Instance c)
