/* Functions of FMI 3.0 for co-simulation that this FMU offers. */
#include "fmi3.h"

#include <string.h>

static void report(const instance *self, const char *message) {
    const fmi3LogMessageCallback log = (fmi3LogMessageCallback)self->log;
    log(self->environment, fmi3Error, "logStatusError", message);
}

EXPORTED const char *fmi3GetVersion(void) { return "3.0"; }

EXPORTED fmi3Status fmi3SetDebugLogging(fmi3Instance c, fmi3Boolean on, size_t count, const fmi3String categories[]) {
    (void)on, (void)count, (void)categories; /* errors alone are logged, and always */
    return core_allows(c, ANY_PHASE, "fmi3SetDebugLogging") ? fmi3OK : fmi3Error;
}

EXPORTED fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources,
                                                  fmi3Boolean visible, fmi3Boolean on, fmi3Boolean events,
                                                  fmi3Boolean early, const fmi3ValueReference intermediates[],
                                                  size_t count, fmi3InstanceEnvironment environment,
                                                  fmi3LogMessageCallback log, fmi3IntermediateUpdateCallback update) {
    (void)resources, (void)visible, (void)on, (void)early, (void)intermediates, (void)update;
    instance prototype;
    memset(&prototype, 0, sizeof prototype);
    if (log) {
        prototype.report = report;
        prototype.log = (void (*)(void))log;
        prototype.environment = environment;
    }
    if (events || count) {
        core_fail(&prototype, "fmi3InstantiateCoSimulation: this FMU has no %s", events ? "events" : "intermediate values");
        return NULL;
    }
    return core_instantiate(&prototype, name, token);
}

EXPORTED void fmi3FreeInstance(fmi3Instance c) { core_release(&c); }

EXPORTED fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean has_tolerance, fmi3Float64 tolerance,
                                                fmi3Float64 start, fmi3Boolean has_stop, fmi3Float64 stop) {
    (void)has_tolerance, (void)tolerance, (void)has_stop, (void)stop;
    return (fmi3Status)core_enter_initialization(c, start, "fmi3EnterInitializationMode");
}

EXPORTED fmi3Status fmi3ExitInitializationMode(fmi3Instance c) {
    return (fmi3Status)core_exit_initialization(c, "fmi3ExitInitializationMode");
}

EXPORTED fmi3Status fmi3Terminate(fmi3Instance c) { return (fmi3Status)core_terminate(c, "fmi3Terminate"); }

EXPORTED fmi3Status fmi3Reset(fmi3Instance c) {
    if (!core_allows(c, ANY_PHASE, "fmi3Reset")) return fmi3Error;
    core_reset(c);
    return fmi3OK;
}

/* Return whether arrays are there and fit each other: all variables are scalars. */
static int arrays_fit(instance *self, const fmi3ValueReference vr[], size_t count, const void *values, size_t size,
                      const char *function) {
    if (count && (!vr || !values)) {
        core_fail(self, "%s: an array is missing", function);
        return 0;
    }
    if (count == size) return 1;
    core_fail(self, "%s: %zu value references, but an array of %zu values", function, count, size);
    return 0;
}

EXPORTED fmi3Status fmi3GetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t count, fmi3Float64 values[],
                                   size_t size) {
    const char *function = "fmi3GetFloat64";
    if (!core_allows(c, ANY_PHASE, function) || !arrays_fit(c, vr, count, values, size, function)) return fmi3Error;
    return (fmi3Status)core_get(c, vr, count, values, function);
}

EXPORTED fmi3Status fmi3SetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t count,
                                   const fmi3Float64 values[], size_t size) {
    const char *function = "fmi3SetFloat64";
    if (!core_allows(c, BEFORE_STEPS | STEPPING, function) || !arrays_fit(c, vr, count, values, size, function))
        return fmi3Error;
    return (fmi3Status)core_set(c, vr, count, values, function);
}

#define INTEGERS(kind, type, typed)                                                                                    \
    EXPORTED fmi3Status fmi3Get##kind(fmi3Instance c, const fmi3ValueReference vr[], size_t count, type values[],      \
                                      size_t size) {                                                                   \
        const char *function = "fmi3Get" #kind;                                                                        \
        if (!core_allows(c, ANY_PHASE, function) || !arrays_fit(c, vr, count, values, size, function))                 \
            return fmi3Error;                                                                                          \
        for (size_t i = 0; i < count; i++) {                                                                           \
            const int32_t *place = core_integer(c, vr[i], function);                                                   \
            if (!place) return fmi3Error;                                                                              \
            values[i] = typed;                                                                                         \
        }                                                                                                              \
        return fmi3OK;                                                                                                 \
    }                                                                                                                  \
    EXPORTED fmi3Status fmi3Set##kind(fmi3Instance c, const fmi3ValueReference vr[], size_t count,                     \
                                      const type values[], size_t size) {                                              \
        const char *function = "fmi3Set" #kind;                                                                        \
        if (!core_allows(c, BEFORE_STEPS, function) || !arrays_fit(c, vr, count, values, size, function))              \
            return fmi3Error;                                                                                          \
        for (size_t i = 0; i < count; i++)                                                                             \
            if (core_set_integer(c, vr[i], values[i], function)) return fmi3Error;                                     \
        return fmi3OK;                                                                                                 \
    }

INTEGERS(Int32, fmi3Int32, *place)
INTEGERS(Boolean, fmi3Boolean, *place != 0)

EXPORTED fmi3Status fmi3GetFMUState(fmi3Instance c, fmi3FMUState *state) {
    return (fmi3Status)core_keep(c, state, "fmi3GetFMUState");
}

EXPORTED fmi3Status fmi3SetFMUState(fmi3Instance c, fmi3FMUState state) {
    return (fmi3Status)core_restore(c, state, "fmi3SetFMUState");
}

EXPORTED fmi3Status fmi3FreeFMUState(fmi3Instance c, fmi3FMUState *state) {
    core_release(state);
    return core_allows(c, ANY_PHASE, "fmi3FreeFMUState") ? fmi3OK : fmi3Error;
}

EXPORTED fmi3Status fmi3SerializedFMUStateSize(fmi3Instance c, fmi3FMUState state, size_t *size) {
    if (!core_allows(c, ANY_PHASE, "fmi3SerializedFMUStateSize")) return fmi3Error;
    if (!state || !size) return (fmi3Status)core_fail(c, "fmi3SerializedFMUStateSize: state or size is missing");
    *size = core_serialized_size();
    return fmi3OK;
}

EXPORTED fmi3Status fmi3SerializeFMUState(fmi3Instance c, fmi3FMUState state, fmi3Byte bytes[], size_t size) {
    return (fmi3Status)core_serialize(c, state, bytes, size, "fmi3SerializeFMUState");
}

EXPORTED fmi3Status fmi3DeserializeFMUState(fmi3Instance c, const fmi3Byte bytes[], size_t size, fmi3FMUState *state) {
    return (fmi3Status)core_deserialize(c, bytes, size, state, "fmi3DeserializeFMUState");
}

EXPORTED fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 time, fmi3Float64 size, fmi3Boolean keeps,
                               fmi3Boolean *events, fmi3Boolean *terminates, fmi3Boolean *early, fmi3Float64 *reached) {
    (void)keeps;
    instance *self = c;
    const fmi3Status status = (fmi3Status)core_step(self, time, size, "fmi3DoStep");
    if (events) *events = false;
    if (terminates) *terminates = false;
    if (early) *early = false;
    if (reached && self) *reached = self->now.start_time + MODEL_CYCLE / MODEL_STEPS * (double)self->now.steps;
    return status;
}
