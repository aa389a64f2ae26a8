/* FMI 3.0: functions that this FMU refuses (clocks, binary values, configuration, partitions). */

#include "instance.h"

static fmi3Status report_absent(fmi3Instance c, const char *features)
{
    return c ? (fmi3Status)report(c, fmi2Error, "there are no %s", features) : fmi3Error;
}

fmi3Status fmi3GetBinary(fmi3Instance c, const fmi3ValueReference r[], size_t count, size_t sizes[],
                         fmi3Binary values[], size_t value_count)
{
    (void)r, (void)count, (void)sizes, (void)values, (void)value_count;
    return report_absent(c, "variables of type Binary");
}

fmi3Status fmi3SetBinary(fmi3Instance c, const fmi3ValueReference r[], size_t count,
                         const size_t sizes[], const fmi3Binary values[], size_t value_count)
{
    (void)r, (void)count, (void)sizes, (void)values, (void)value_count;
    return report_absent(c, "variables of type Binary");
}

fmi3Status fmi3GetClock(fmi3Instance c, const fmi3ValueReference r[], size_t count,
                        fmi3Clock values[])
{
    (void)r, (void)count, (void)values;
    return report_absent(c, "clocks");
}

fmi3Status fmi3SetClock(fmi3Instance c, const fmi3ValueReference r[], size_t count,
                        const fmi3Clock values[])
{
    (void)r, (void)count, (void)values;
    return report_absent(c, "clocks");
}

fmi3Status fmi3GetIntervalDecimal(fmi3Instance c, const fmi3ValueReference r[], size_t count,
                                  fmi3Float64 intervals[], fmi3IntervalQualifier qualifiers[])
{
    (void)r, (void)count, (void)intervals, (void)qualifiers;
    return report_absent(c, "clocks");
}

fmi3Status fmi3GetIntervalFraction(fmi3Instance c, const fmi3ValueReference r[], size_t count,
                                   fmi3UInt64 counters[], fmi3UInt64 resolutions[],
                                   fmi3IntervalQualifier qualifiers[])
{
    (void)r, (void)count, (void)counters, (void)resolutions, (void)qualifiers;
    return report_absent(c, "clocks");
}

fmi3Status fmi3GetShiftDecimal(fmi3Instance c, const fmi3ValueReference r[], size_t count,
                               fmi3Float64 shifts[])
{
    (void)r, (void)count, (void)shifts;
    return report_absent(c, "clocks");
}

fmi3Status fmi3GetShiftFraction(fmi3Instance c, const fmi3ValueReference r[], size_t count,
                                fmi3UInt64 counters[], fmi3UInt64 resolutions[])
{
    (void)r, (void)count, (void)counters, (void)resolutions;
    return report_absent(c, "clocks");
}

fmi3Status fmi3SetIntervalDecimal(fmi3Instance c, const fmi3ValueReference r[], size_t count,
                                  const fmi3Float64 intervals[])
{
    (void)r, (void)count, (void)intervals;
    return report_absent(c, "clocks");
}

fmi3Status fmi3SetIntervalFraction(fmi3Instance c, const fmi3ValueReference r[], size_t count,
                                   const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])
{
    (void)r, (void)count, (void)counters, (void)resolutions;
    return report_absent(c, "clocks");
}

fmi3Status fmi3SetShiftDecimal(fmi3Instance c, const fmi3ValueReference r[], size_t count,
                               const fmi3Float64 shifts[])
{
    (void)r, (void)count, (void)shifts;
    return report_absent(c, "clocks");
}

fmi3Status fmi3SetShiftFraction(fmi3Instance c, const fmi3ValueReference r[], size_t count,
                                const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])
{
    (void)r, (void)count, (void)counters, (void)resolutions;
    return report_absent(c, "clocks");
}

fmi3Status fmi3EnterConfigurationMode(fmi3Instance c)
{
    return report_absent(c, "structural parameters");
}

fmi3Status fmi3ExitConfigurationMode(fmi3Instance c)
{
    return report_absent(c, "structural parameters");
}

fmi3Status fmi3GetNumberOfVariableDependencies(fmi3Instance c, fmi3ValueReference reference,
                                               size_t *count)
{
    (void)reference, (void)count;
    return report_absent(c, "dependencies of array elements");
}

fmi3Status fmi3GetVariableDependencies(fmi3Instance c, fmi3ValueReference dependent,
                                       size_t elements[], fmi3ValueReference independents[],
                                       size_t independent_elements[], fmi3DependencyKind kinds[],
                                       size_t count)
{
    (void)dependent, (void)elements, (void)independents, (void)independent_elements, (void)kinds;
    (void)count;
    return report_absent(c, "dependencies of array elements");
}

fmi3Status fmi3ActivateModelPartition(fmi3Instance c, fmi3ValueReference clock, fmi3Float64 time)
{
    (void)clock, (void)time;
    return report_absent(c, "model partitions");
}
