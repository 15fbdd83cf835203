/* Device of a rig that runs the machine's control law and supervisor itself; its host sends requests. */
#ifndef LAYFLAT_CONTROLLER_H
#define LAYFLAT_CONTROLLER_H

#include "machine.h"
#include "station.h"

#define CONTROLLER_EVENTS 32u /* that wait for the host */

typedef struct {
    double low, lsb; /* value of count 0, and of one count; SI units */
    uint32_t top;    /* greatest count */
} converter;

typedef struct {
    const station_settings *station;
    const rig_supervisor_settings *supervisor;
    const rig_supervisor_memory *memory; /* before the first cycle */
    converter voltage, angle, pressure, supply;
    uint32_t cycle;                       /* us */
    uint32_t digest;                      /* of the machine, which the host compares with its own */
    uint8_t recorded[MACHINE_RECORDED + 1u]; /* numbers of the law's report that are sent to the host */
} controller_settings;

/* Request of the host in force. */
typedef struct {
    uint16_t edges;    /* starts, stops, holds, resets, 4 bits each: a change counts once */
    uint8_t outputs;   /* digital outputs that are to be on */
    uint8_t switches;  /* a bit of each that changes as it is switched */
    uint16_t flags, events;
    double age, demand_age; /* since the host's own host has spoken, and since the instant of the demands, s */
    double numbers[STATION_MAX_JOINTS][3]; /* demands, their velocities and accelerations; NAN for none */
} controller_request;

typedef struct {
    const controller_settings *settings;
    station station;
    controller_request request;
    uint32_t asked;      /* when it came, us */
    int known;           /* whether a request has come since the device was switched on, or identified */
    int begun;           /* whether a cycle has been performed */
    uint32_t due, cycled; /* instants of the next cycle and of the last, us */
    uint16_t cycles;
    uint16_t events; /* that happened so far; the last ones are kept */
    uint8_t happened[CONTROLLER_EVENTS][2];
    station_samples samples; /* of the last cycle */
    rig_supervisor_inputs inputs;
    rig_supervisor_memory memory;
    rig_supervisor_results results;
    rig_supervisor_workspace workspace;
} controller;

/* Begin with the air out. */
void controller_start(controller *self, const controller_settings *settings);
/* Do everything once: call it again and again, far more often than there are control cycles. */
void controller_step(controller *self);

#endif
