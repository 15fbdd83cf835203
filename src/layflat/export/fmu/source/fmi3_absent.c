/* Functions of FMI 3.0 that have to be there, for what this FMU does not have: they report an error. */
#include "fmi3.h"

#if defined(__GNUC__)
#pragma GCC diagnostic ignored "-Wunused-parameter"
#endif

static fmi3Status absent(instance *self, size_t count, const char *function) {
    if (!core_allows(self, ANY_PHASE, function)) return fmi3Error;
    return count ? (fmi3Status)core_fail(self, "%s: this FMU has nothing of the kind", function) : fmi3OK;
}

/* A function without arrays, and one of so many references that nothing is asked where there are none. */
#define ABSENT(name, ...)                                                                                              \
    EXPORTED fmi3Status name(fmi3Instance c, __VA_ARGS__) { return absent(c, 1, #name); }
#define ABSENT_MODE(name)                                                                                              \
    EXPORTED fmi3Status name(fmi3Instance c) { return absent(c, 1, #name); }
#define ABSENT_OF(name, ...)                                                                                           \
    EXPORTED fmi3Status name(fmi3Instance c, const fmi3ValueReference vr[], size_t count, __VA_ARGS__) {               \
        return absent(c, count, #name);                                                                                \
    }
#define ABSENT_KIND(kind, type)                                                                                        \
    ABSENT_OF(fmi3Get##kind, type values[], size_t size)                                                               \
    ABSENT_OF(fmi3Set##kind, const type values[], size_t size)

ABSENT_KIND(Float32, fmi3Float32)
ABSENT_KIND(Int8, fmi3Int8)
ABSENT_KIND(UInt8, fmi3UInt8)
ABSENT_KIND(Int16, fmi3Int16)
ABSENT_KIND(UInt16, fmi3UInt16)
ABSENT_KIND(UInt32, fmi3UInt32)
ABSENT_KIND(Int64, fmi3Int64)
ABSENT_KIND(UInt64, fmi3UInt64)
ABSENT_KIND(String, fmi3String)
ABSENT_OF(fmi3GetBinary, size_t sizes[], fmi3Binary values[], size_t size)
ABSENT_OF(fmi3SetBinary, const size_t sizes[], const fmi3Binary values[], size_t size)
ABSENT_OF(fmi3GetClock, fmi3Clock values[])
ABSENT_OF(fmi3SetClock, const fmi3Clock values[])
ABSENT_OF(fmi3GetIntervalDecimal, fmi3Float64 intervals[], fmi3IntervalQualifier qualifiers[])
ABSENT_OF(fmi3GetIntervalFraction, fmi3UInt64 counters[], fmi3UInt64 resolutions[], fmi3IntervalQualifier qualifiers[])
ABSENT_OF(fmi3GetShiftDecimal, fmi3Float64 shifts[])
ABSENT_OF(fmi3GetShiftFraction, fmi3UInt64 counters[], fmi3UInt64 resolutions[])
ABSENT_OF(fmi3SetIntervalDecimal, const fmi3Float64 intervals[])
ABSENT_OF(fmi3SetIntervalFraction, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])
ABSENT_OF(fmi3SetShiftDecimal, const fmi3Float64 shifts[])
ABSENT_OF(fmi3SetShiftFraction, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])
ABSENT_OF(fmi3GetOutputDerivatives, const fmi3Int32 orders[], fmi3Float64 values[], size_t size)
ABSENT_OF(fmi3GetDirectionalDerivative, const fmi3ValueReference knowns[], size_t known_count, const fmi3Float64 seeds[],
          size_t seed_count, fmi3Float64 values[], size_t size)
ABSENT_OF(fmi3GetAdjointDerivative, const fmi3ValueReference knowns[], size_t known_count, const fmi3Float64 seeds[],
          size_t seed_count, fmi3Float64 values[], size_t size)

ABSENT(fmi3GetNumberOfVariableDependencies, fmi3ValueReference reference, size_t *count)
ABSENT(fmi3GetVariableDependencies, fmi3ValueReference dependent, size_t elements[], fmi3ValueReference independents[],
       size_t independent_elements[], fmi3DependencyKind kinds[], size_t count)

ABSENT_MODE(fmi3EnterConfigurationMode)
ABSENT_MODE(fmi3ExitConfigurationMode)
ABSENT_MODE(fmi3EnterEventMode)
ABSENT_MODE(fmi3EnterStepMode)
ABSENT_MODE(fmi3EnterContinuousTimeMode)
ABSENT_MODE(fmi3EvaluateDiscreteStates)
ABSENT(fmi3UpdateDiscreteStates, fmi3Boolean *again, fmi3Boolean *terminates, fmi3Boolean *nominals,
       fmi3Boolean *values, fmi3Boolean *has_next, fmi3Float64 *next)
ABSENT(fmi3CompletedIntegratorStep, fmi3Boolean keeps, fmi3Boolean *event, fmi3Boolean *terminates)
ABSENT(fmi3SetTime, fmi3Float64 time)
ABSENT(fmi3SetContinuousStates, const fmi3Float64 states[], size_t count)
ABSENT(fmi3GetContinuousStateDerivatives, fmi3Float64 derivatives[], size_t count)
ABSENT(fmi3GetEventIndicators, fmi3Float64 indicators[], size_t count)
ABSENT(fmi3GetContinuousStates, fmi3Float64 states[], size_t count)
ABSENT(fmi3GetNominalsOfContinuousStates, fmi3Float64 nominals[], size_t count)
ABSENT(fmi3GetNumberOfEventIndicators, size_t *count)
ABSENT(fmi3GetNumberOfContinuousStates, size_t *count)
ABSENT(fmi3ActivateModelPartition, fmi3ValueReference clock, fmi3Float64 time)

EXPORTED fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources,
                                                   fmi3Boolean visible, fmi3Boolean on,
                                                   fmi3InstanceEnvironment environment, fmi3LogMessageCallback log) {
    if (log) log(environment, fmi3Error, "logStatusError", "this is an FMU for co-simulation, not for model exchange");
    return NULL;
}

EXPORTED fmi3Instance fmi3InstantiateScheduledExecution(fmi3String name, fmi3String token, fmi3String resources,
                                                        fmi3Boolean visible, fmi3Boolean on,
                                                        fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                                        fmi3ClockUpdateCallback update, fmi3LockPreemptionCallback lock,
                                                        fmi3UnlockPreemptionCallback unlock) {
    if (log) log(environment, fmi3Error, "logStatusError", "this is an FMU for co-simulation, not for schedules");
    return NULL;
}
