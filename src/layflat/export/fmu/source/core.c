/* Variables, phases and time of an instance; the laws of the machine are functions of other object files. */
#include "core.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define TIME_TOLERANCE 1e-3 /* rounding of times that an importer adds up, in steps of the plant */
#define SIZE_TOLERANCE 1e-6 /* rounding of a difference of two times, likewise */
#define MAX_SIZE 1e5        /* of an importer's step, s */

int core_fail(const instance *self, const char *format, ...) {
    char message[320];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    if (self && self->report) self->report(self, message);
    return STATUS_ERROR;
}

int core_allows(const instance *self, int phases, const char *function) {
    static const char *const names[] = {"instantiated", "in initialization", "in its steps", "terminated", "failed"};
    if (!self) return 0;
    if (self->now.phase & phases) return 1;
    int phase = 0;
    while (phase < 4 && !(self->now.phase >> phase & 1)) phase++;
    core_fail(self, "%s: called out of order: the instance is %s", function, names[phase]);
    return 0;
}

/* Law and plant: each part of the machine is missing where it is not exported. */

#if MODEL_PLANT
static void sample_sensors(numbers *now, int noisy) {
    double noise[2 * MODEL_JOINTS] = {0.0};
    for (int i = 0; noisy && i < 2 * MODEL_JOINTS; i++) noise[i] = noise_normal(&now->noise);
    model_sample(now->values + MODEL_PARAMETERS, now->state, noise, now->values + MODEL_MEASURED);
}

static void record_outputs(numbers *now) {
    double *values = now->values;
    model_record(values + MODEL_PARAMETERS, values + MODEL_SHARED, now->state, values + MODEL_MEASURED,
                 values + MODEL_OUTPUTS);
}
#endif

static int is_finite(double value) { return value - value == 0.0; }

static int all_finite(const double *values, size_t count) {
    for (size_t i = 0; i < count; i++)
        if (!is_finite(values[i])) return 0;
    return 1;
}

/* Bring the machine to rest at its start; outputs are without noise until the steps begin. */
static int settle(instance *self, const char *function) {
    numbers *now = &self->now;
    (void)function;
    if (now->settled || !(now->phase & BEFORE_STEPS)) return STATUS_OK;
    now->steps = 0;
#if MODEL_PLANT
    double start[3 * MODEL_JOINTS];
    for (int i = 0; i < 3 * MODEL_JOINTS; i++) {
        start[i] = now->values[MODEL_START + i];
        if (i >= MODEL_JOINTS && start[i] == 0.0) start[i] = NAN; /* the pressures that hold the arm */
    }
    model_rest(now->values + MODEL_PARAMETERS, start, now->values + MODEL_SHARED, now->state);
    sample_sensors(now, 0);
    record_outputs(now);
    if (!all_finite(now->values + MODEL_OUTPUTS, MODEL_OUTPUT_VALUES))
        return core_fail(self, "%s: the machine can't rest with these parameters and start values", function);
#endif
#if MODEL_CONTROLLER
    model_control_wake(now->values + MODEL_SETTINGS, now->values + MODEL_MEASURED, now->memory);
#endif
    now->settled = 1;
    return STATUS_OK;
}

/* Begin a control cycle: the law reads its inputs, and the valves get their voltages. */
static int begin_cycle(instance *self, const char *function) {
    numbers *now = &self->now;
    double *values = now->values;
#if MODEL_CONTROLLER
    double *command = values + MODEL_COMMAND, after[MODEL_MEMORY];
    model_control_step(values + MODEL_SETTINGS, now->memory, values + MODEL_MEASURED, values + MODEL_DEMAND, MODEL_CYCLE,
                       after, command, values + MODEL_REPORT);
    if (!all_finite(command, 4 * MODEL_JOINTS))
        return core_fail(self, "%s: the control law commands a voltage that is not a number", function);
    memcpy(now->memory, after, sizeof after);
#if MODEL_PLANT
    for (int j = 0; j < MODEL_JOINTS; j++) {
        double *input = values + MODEL_INPUTS + j * MODEL_INPUT_COLUMNS;
        input[0] = command[j];
        memcpy(input + 1, command + MODEL_JOINTS + 3 * j, 3 * sizeof(double));
    }
#endif
#endif
#if MODEL_PLANT
    const double time = MODEL_CYCLE * (double)(now->steps / MODEL_STEPS);
    model_drive(values + MODEL_PARAMETERS, values + MODEL_INPUTS, values + MODEL_SHARED, time, now->state);
#endif
    (void)values, (void)function;
    return STATUS_OK;
}

static int advance_steps(instance *self, int64_t count, const char *function) {
    numbers *now = &self->now;
    while (count > 0) {
        if (now->steps % MODEL_STEPS == 0 && begin_cycle(self, function)) return STATUS_ERROR;
        const int64_t left = MODEL_STEPS - now->steps % MODEL_STEPS, part = count < left ? count : left;
#if MODEL_PLANT
        const int32_t diverged = model_advance(now->values + MODEL_PARAMETERS, now->values + MODEL_INPUTS,
                                               now->values + MODEL_SHARED, (int32_t)part, now->state);
        if (diverged >= 0)
            return core_fail(self, "%s: joint %d diverged before %g s", function, (int)diverged + 1,
                             now->start_time + MODEL_CYCLE / MODEL_STEPS * (double)(now->steps + part));
#endif
        now->steps += part;
        count -= part;
#if MODEL_PLANT
        if (now->steps % MODEL_STEPS == 0) sample_sensors(now, now->noisy);
#endif
    }
#if MODEL_PLANT
    record_outputs(now);
#endif
    return STATUS_OK;
}

/* Phases. */

void core_reset(instance *self) {
    memset(&self->now, 0, sizeof self->now);
    memcpy(self->now.values, model_start, sizeof model_start);
    self->now.noisy = 1;
    self->now.phase = INSTANTIATED;
}

instance *core_instantiate(const instance *prototype, const char *name, const char *token) {
    if (!name || !*name) {
        core_fail(prototype, "instantiate: the instance has no name");
        return NULL;
    }
    if (!token || strcmp(token, MODEL_TOKEN) != 0) {
        core_fail(prototype, "instantiate: the token is not that of this library, %s", MODEL_TOKEN);
        return NULL;
    }
    instance *self = malloc(sizeof *self);
    if (!self) {
        core_fail(prototype, "instantiate: out of memory");
        return NULL;
    }
    *self = *prototype;
    strncpy(self->name, name, sizeof self->name - 1);
    core_reset(self);
    return self;
}

int core_enter_initialization(instance *self, double start_time, const char *function) {
    if (!core_allows(self, INSTANTIATED, function)) return STATUS_ERROR;
    if (!is_finite(start_time)) return core_fail(self, "%s: the start time is not a number", function);
    self->now.start_time = start_time;
    self->now.phase = INITIALIZING;
    return STATUS_OK;
}

int core_exit_initialization(instance *self, const char *function) {
    if (!core_allows(self, INITIALIZING, function) || settle(self, function)) return STATUS_ERROR;
#if MODEL_PLANT
    noise_seed(&self->now.noise, (uint32_t)self->now.seed);
    sample_sensors(&self->now, self->now.noisy);
    record_outputs(&self->now);
#endif
    self->now.phase = STEPPING;
    return STATUS_OK;
}

int core_terminate(instance *self, const char *function) {
    if (!core_allows(self, STEPPING | FAILED, function)) return STATUS_ERROR;
    self->now.phase = TERMINATED;
    return STATUS_OK;
}

int core_step(instance *self, double time, double size, const char *function) {
    const double h = MODEL_CYCLE / MODEL_STEPS;
    if (!core_allows(self, STEPPING, function)) return STATUS_ERROR;
    if (!is_finite(time) || !is_finite(size)) return core_fail(self, "%s: time or step is not a number", function);
    const double present = self->now.start_time + h * (double)self->now.steps;
    if (fabs(time - present) > TIME_TOLERANCE * h)
        return core_fail(self, "%s: the step begins at %.9g s, but the instance is at %.9g s", function, time, present);
    const double count = floor(size / h + 0.5);
    if (!(size > 0.0) || size > MAX_SIZE || count < 1.0 || fabs(size / h - count) > SIZE_TOLERANCE)
        return core_fail(self, "%s: a step of %.9g s is not a whole number of plant steps; give a multiple of %.9g s", function,
                         size, h);
    if (advance_steps(self, (int64_t)count, function)) {
        self->now.phase = FAILED;
        return STATUS_ERROR;
    }
    return STATUS_OK;
}

/* Variables. */

int core_get(instance *self, const uint32_t *references, size_t count, double *values, const char *function) {
    if (!core_allows(self, ANY_PHASE, function)) return STATUS_ERROR;
    if (count && (!references || !values)) return core_fail(self, "%s: an array is missing", function);
    if (settle(self, function)) return STATUS_ERROR;
    for (size_t i = 0; i < count; i++) {
        const uint32_t reference = references[i];
        if (reference == MODEL_TIME)
            values[i] = self->now.start_time + MODEL_CYCLE / MODEL_STEPS * (double)self->now.steps;
        else if (reference < MODEL_VALUES && model_access[reference])
            values[i] = self->now.values[reference];
        else
            return core_fail(self, "%s: %u is no value reference of a real variable", function, (unsigned)reference);
    }
    return STATUS_OK;
}

int core_set(instance *self, const uint32_t *references, size_t count, const double *values, const char *function) {
    if (!core_allows(self, BEFORE_STEPS | STEPPING, function)) return STATUS_ERROR;
    if (count && (!references || !values)) return core_fail(self, "%s: an array is missing", function);
    for (size_t i = 0; i < count; i++) {
        const uint32_t reference = references[i];
        const int access = reference < MODEL_VALUES ? model_access[reference] : ACCESS_NONE;
        if (access == ACCESS_NONE)
            return core_fail(self, "%s: %u is no value reference of a real variable", function, (unsigned)reference);
        if (access == ACCESS_OUTPUT || (access == ACCESS_FIXED && self->now.phase == STEPPING))
            return core_fail(self, "%s: variable %u can't be set now", function, (unsigned)reference);
        /* A limit that is missing is infinite. */
        if (access == ACCESS_TUNABLE ? values[i] != values[i] : !is_finite(values[i]))
            return core_fail(self, "%s: the value of variable %u is not a number", function, (unsigned)reference);
    }
    for (size_t i = 0; i < count; i++) self->now.values[references[i]] = values[i];
    self->now.settled = self->now.settled && count == 0;
    return STATUS_OK;
}

int32_t *core_integer(instance *self, uint32_t reference, const char *function) {
    if (MODEL_PLANT && reference == MODEL_SEED) return &self->now.seed;
    if (MODEL_PLANT && reference == MODEL_NOISE) return &self->now.noisy;
    core_fail(self, "%s: %u is no value reference of such a variable", function, (unsigned)reference);
    return NULL;
}

int core_set_integer(instance *self, uint32_t reference, int64_t value, const char *function) {
    int32_t *place = core_integer(self, reference, function);
    if (!place) return STATUS_ERROR;
    if (value < 0 || value > (place == &self->now.seed ? INT32_MAX : 1))
        return core_fail(self, "%s: the value of variable %u is out of range", function, (unsigned)reference);
    *place = (int32_t)value;
    return STATUS_OK;
}
