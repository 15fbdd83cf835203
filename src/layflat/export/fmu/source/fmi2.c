/* Functions of FMI 2.0 for co-simulation. With FMI_HEADERS the standard's own headers check their declarations. */
#include <string.h>

#include "core.h"

#if defined(FMI_HEADERS)
#include "fmi2Functions.h"
#else
typedef void *fmi2Component, *fmi2ComponentEnvironment, *fmi2FMUstate;
typedef unsigned fmi2ValueReference;
typedef double fmi2Real;
typedef int fmi2Integer, fmi2Boolean;
typedef char fmi2Char, fmi2Byte;
typedef const fmi2Char *fmi2String;
typedef enum { fmi2OK, fmi2Warning, fmi2Discard, fmi2Error, fmi2Fatal, fmi2Pending } fmi2Status;
typedef enum { fmi2ModelExchange, fmi2CoSimulation } fmi2Type;
typedef enum { fmi2DoStepStatus, fmi2PendingStatus, fmi2LastSuccessfulTime, fmi2Terminated } fmi2StatusKind;
typedef void (*fmi2CallbackLogger)(fmi2ComponentEnvironment, fmi2String, fmi2Status, fmi2String, fmi2String, ...);
typedef struct {
    fmi2CallbackLogger logger;
    void *(*allocateMemory)(size_t, size_t);
    void (*freeMemory)(void *);
    void (*stepFinished)(fmi2ComponentEnvironment, fmi2Status);
    fmi2ComponentEnvironment componentEnvironment;
} fmi2CallbackFunctions;
#endif

static void report(const instance *self, const char *message) {
    const fmi2CallbackLogger log = (fmi2CallbackLogger)self->log;
    log(self->environment, self->name, fmi2Error, "logStatusError", "%s", message);
}

EXPORTED const char *fmi2GetTypesPlatform(void) { return "default"; }

EXPORTED const char *fmi2GetVersion(void) { return "2.0"; }

EXPORTED fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t count, const fmi2String categories[]) {
    (void)on, (void)count, (void)categories; /* errors alone are logged, and always */
    return core_allows(c, ANY_PHASE, "fmi2SetDebugLogging") ? fmi2OK : fmi2Error;
}

EXPORTED fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String token, fmi2String resources,
                                       const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean on) {
    (void)resources, (void)visible, (void)on;
    instance prototype;
    memset(&prototype, 0, sizeof prototype);
    if (functions && functions->logger) {
        prototype.report = report;
        prototype.log = (void (*)(void))functions->logger;
        prototype.environment = functions->componentEnvironment;
    }
    if (type != fmi2CoSimulation) {
        core_fail(&prototype, "fmi2Instantiate: this is an FMU for co-simulation, not for model exchange");
        return NULL;
    }
    return core_instantiate(&prototype, name, token);
}

EXPORTED void fmi2FreeInstance(fmi2Component c) { core_release(&c); }

EXPORTED fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean has_tolerance, fmi2Real tolerance, fmi2Real start,
                                        fmi2Boolean has_stop, fmi2Real stop) {
    (void)has_tolerance, (void)tolerance, (void)has_stop, (void)stop;
    instance *self = c;
    if (!core_allows(self, INSTANTIATED, "fmi2SetupExperiment")) return fmi2Error;
    self->now.start_time = start;
    return fmi2OK;
}

EXPORTED fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    instance *self = c;
    return (fmi2Status)core_enter_initialization(self, self ? self->now.start_time : 0.0,
                                                 "fmi2EnterInitializationMode");
}

EXPORTED fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    return (fmi2Status)core_exit_initialization(c, "fmi2ExitInitializationMode");
}

EXPORTED fmi2Status fmi2Terminate(fmi2Component c) { return (fmi2Status)core_terminate(c, "fmi2Terminate"); }

EXPORTED fmi2Status fmi2Reset(fmi2Component c) {
    if (!core_allows(c, ANY_PHASE, "fmi2Reset")) return fmi2Error;
    core_reset(c);
    return fmi2OK;
}

EXPORTED fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t count, fmi2Real values[]) {
    return (fmi2Status)core_get(c, vr, count, values, "fmi2GetReal");
}

EXPORTED fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t count, const fmi2Real values[]) {
    return (fmi2Status)core_set(c, vr, count, values, "fmi2SetReal");
}

static fmi2Status get_integers(instance *self, const fmi2ValueReference vr[], size_t count, int values[],
                               const char *function) {
    if (!core_allows(self, ANY_PHASE, function)) return fmi2Error;
    if (count && (!vr || !values)) return (fmi2Status)core_fail(self, "%s: an array is missing", function);
    for (size_t i = 0; i < count; i++) {
        const int32_t *place = core_integer(self, vr[i], function);
        if (!place) return fmi2Error;
        values[i] = *place;
    }
    return fmi2OK;
}

static fmi2Status set_integers(instance *self, const fmi2ValueReference vr[], size_t count, const int values[],
                               const char *function) {
    if (!core_allows(self, BEFORE_STEPS, function)) return fmi2Error;
    if (count && (!vr || !values)) return (fmi2Status)core_fail(self, "%s: an array is missing", function);
    for (size_t i = 0; i < count; i++)
        if (core_set_integer(self, vr[i], values[i], function)) return fmi2Error;
    return fmi2OK;
}

EXPORTED fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t count, fmi2Integer values[]) {
    return get_integers(c, vr, count, values, "fmi2GetInteger");
}

EXPORTED fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t count, fmi2Boolean values[]) {
    return get_integers(c, vr, count, values, "fmi2GetBoolean");
}

EXPORTED fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t count,
                                   const fmi2Integer values[]) {
    return set_integers(c, vr, count, values, "fmi2SetInteger");
}

EXPORTED fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t count,
                                   const fmi2Boolean values[]) {
    return set_integers(c, vr, count, values, "fmi2SetBoolean");
}

static fmi2Status absent(instance *self, size_t count, const char *function) {
    if (!core_allows(self, ANY_PHASE, function)) return fmi2Error;
    return count ? (fmi2Status)core_fail(self, "%s: this FMU has nothing of the kind", function) : fmi2OK;
}

EXPORTED fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t count, fmi2String values[]) {
    (void)vr, (void)values;
    return absent(c, count, "fmi2GetString");
}

EXPORTED fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t count,
                                  const fmi2String values[]) {
    (void)vr, (void)values;
    return absent(c, count, "fmi2SetString");
}

EXPORTED fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state) {
    return (fmi2Status)core_keep(c, state, "fmi2GetFMUstate");
}

EXPORTED fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
    return (fmi2Status)core_restore(c, state, "fmi2SetFMUstate");
}

EXPORTED fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state) {
    core_release(state);
    return core_allows(c, ANY_PHASE, "fmi2FreeFMUstate") ? fmi2OK : fmi2Error;
}

EXPORTED fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size) {
    if (!core_allows(c, ANY_PHASE, "fmi2SerializedFMUstateSize")) return fmi2Error;
    if (!state || !size) return (fmi2Status)core_fail(c, "fmi2SerializedFMUstateSize: state or size is missing");
    *size = core_serialized_size();
    return fmi2OK;
}

EXPORTED fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
    return (fmi2Status)core_serialize(c, state, (unsigned char *)bytes, size, "fmi2SerializeFMUstate");
}

EXPORTED fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state) {
    return (fmi2Status)core_deserialize(c, (const unsigned char *)bytes, size, state, "fmi2DeSerializeFMUstate");
}

EXPORTED fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknowns[], size_t count,
                                                 const fmi2ValueReference knowns[], size_t known_count,
                                                 const fmi2Real seeds[], fmi2Real values[]) {
    (void)unknowns, (void)knowns, (void)known_count, (void)seeds, (void)values;
    return absent(c, count, "fmi2GetDirectionalDerivative");
}

EXPORTED fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t count,
                                                const fmi2Integer orders[], const fmi2Real values[]) {
    (void)vr, (void)orders, (void)values;
    return absent(c, count, "fmi2SetRealInputDerivatives");
}

EXPORTED fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t count,
                                                 const fmi2Integer orders[], fmi2Real values[]) {
    (void)vr, (void)orders, (void)values;
    return absent(c, count, "fmi2GetRealOutputDerivatives");
}

EXPORTED fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real size, fmi2Boolean keeps) {
    (void)keeps;
    return (fmi2Status)core_step(c, time, size, "fmi2DoStep");
}

EXPORTED fmi2Status fmi2CancelStep(fmi2Component c) { return absent(c, 1, "fmi2CancelStep"); }

/* Steps are done when fmi2DoStep returns, so that there is nothing to ask. */

EXPORTED fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Status *value) {
    (void)kind, (void)value;
    return core_allows(c, ANY_PHASE, "fmi2GetStatus") ? fmi2Discard : fmi2Error;
}

EXPORTED fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value) {
    instance *self = c;
    if (!core_allows(self, ANY_PHASE, "fmi2GetRealStatus")) return fmi2Error;
    if (kind != fmi2LastSuccessfulTime || !value) return fmi2Discard;
    *value = self->now.start_time + MODEL_CYCLE / MODEL_STEPS * (double)self->now.steps;
    return fmi2OK;
}

EXPORTED fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Integer *value) {
    (void)kind, (void)value;
    return core_allows(c, ANY_PHASE, "fmi2GetIntegerStatus") ? fmi2Discard : fmi2Error;
}

EXPORTED fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value) {
    if (!core_allows(c, ANY_PHASE, "fmi2GetBooleanStatus")) return fmi2Error;
    if (kind != fmi2Terminated || !value) return fmi2Discard;
    *value = 0;
    return fmi2OK;
}

EXPORTED fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind kind, fmi2String *value) {
    (void)kind, (void)value;
    return core_allows(c, ANY_PHASE, "fmi2GetStringStatus") ? fmi2Discard : fmi2Error;
}
