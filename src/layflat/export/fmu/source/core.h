/* Co-simulation of a machine's plant, of its control law, or of both, beneath the functions of FMI 2.0 and 3.0. */
#ifndef LAYFLAT_CORE_H
#define LAYFLAT_CORE_H

#include <stddef.h>
#include <stdint.h>

#include "model.h"

#if defined(_WIN32)
#define EXPORTED __declspec(dllexport)
#else
#define EXPORTED __attribute__((visibility("default")))
#endif

/* Status of FMI: the same numbers in 2.0 and 3.0. */
enum { STATUS_OK = 0, STATUS_DISCARD = 2, STATUS_ERROR = 3 };

/* Phases of an instance, as bits of a set. */
enum {
    INSTANTIATED = 1,
    INITIALIZING = 2,
    STEPPING = 4,
    TERMINATED = 8,
    FAILED = 16, /* the simulation can't go on from here */
    BEFORE_STEPS = INSTANTIATED | INITIALIZING,
    ANY_PHASE = 31
};

/* Generator of the sensors' noise: PCG64, words of its state and of its increment, the higher one first. */
typedef struct {
    uint64_t state[2];
    uint64_t increment[2];
} generator;

/* All that changes in an instance: what a state of FMI keeps. */
typedef struct {
    double values[MODEL_VALUES]; /* by value reference: parameters, inputs, outputs */
    double state[MODEL_STATE];   /* of the plant */
    double memory[MODEL_MEMORY]; /* of the control law */
    double start_time;           /* s */
    int64_t steps;               /* of the plant since the start */
    generator noise;
    int32_t seed;
    int32_t noisy;
    int32_t phase;
    int32_t settled; /* 1: the outputs belong to the inputs */
} numbers;

typedef struct instance instance;

struct instance {
    numbers now;
    void (*report)(const instance *, const char *message);
    void *environment;
    void (*log)(void);
    char name[128];
};

/* Return a new instance, or NULL where the name or the token is wrong or memory is out; `prototype` holds `report`,
   `environment` and `log`. */
instance *core_instantiate(const instance *prototype, const char *name, const char *token);

/* Report an error through the importer's logger; return STATUS_ERROR. */
int core_fail(const instance *self, const char *format, ...)
#if defined(__GNUC__)
    __attribute__((format(printf, 2, 3)))
#endif
    ;

/* Return whether an instance is there and in one of these phases; else report a call out of order. */
int core_allows(const instance *self, int phases, const char *function);

void core_reset(instance *self);
int core_enter_initialization(instance *self, double start_time, const char *function);
int core_exit_initialization(instance *self, const char *function);
int core_terminate(instance *self, const char *function);
int core_step(instance *self, double time, double size, const char *function);

int core_get(instance *self, const uint32_t *references, size_t count, double *values, const char *function);
int core_set(instance *self, const uint32_t *references, size_t count, const double *values, const char *function);

/* Return the place of an integer variable; NULL, reported, where there is none or its range excludes a new value. */
int32_t *core_integer(instance *self, uint32_t reference, const char *function);
int core_set_integer(instance *self, uint32_t reference, int64_t value, const char *function);

int core_keep(instance *self, void **state, const char *function);
int core_restore(instance *self, const void *state, const char *function);
int core_serialize(const instance *self, const void *state, unsigned char *bytes, size_t size, const char *function);
int core_deserialize(const instance *self, const unsigned char *bytes, size_t size, void **state, const char *function);
size_t core_serialized_size(void);
void core_release(void **state);

/* noise.c */
void noise_seed(generator *self, uint32_t seed);
double noise_normal(generator *self);

#endif
