/* Device of a rig: obeys a host over the serial line, and makes safe by itself when the host falls silent. */
#ifndef LAYFLAT_STATION_H
#define LAYFLAT_STATION_H

#include "frames.h"

#define STATION_MAX_JOINTS 7u
#define STATION_WAVE 32u /* steps of the dither */

typedef struct {
    uint8_t joints;
    uint8_t voltage_bits, angle_bits, pressure_bits, supply_bits;
    int16_t voltage_low, voltage_high, centre_voltage; /* mV */
    uint32_t centres_after, dumps_after; /* time without a command, us */
    uint32_t empties_after;              /* time from a dump until the valves open, us */
    int lets_down;                       /* whether the valves stay centred in a dump */
    uint16_t shortest_cycle;             /* us */
    uint32_t dither_period;              /* us */
    int32_t dither[STATION_WAVE];        /* counts of voltage over a period */
    uint8_t outputs;                     /* number of digital outputs */
} station_settings;

typedef struct {
    uint32_t time; /* us; goes round */
    int stopped;   /* whether the loop of the e-stop is open */
    uint32_t supply;
    uint32_t angle[STATION_MAX_JOINTS];
    uint32_t pressure[STATION_MAX_JOINTS];
} station_samples;

typedef struct {
    int air;                              /* whether the dump valve lets air in */
    uint8_t outputs;                      /* digital outputs that are on, as bits */
    uint32_t voltage[STATION_MAX_JOINTS]; /* counts */
} station_outputs;

/* The four functions of a board. */
void board_sample(station_samples *samples);         /* read all sensors, the e-stop and the clock */
void board_drive(const station_outputs *outputs);    /* drive all outputs, and feed the hardware's watchdog */
size_t board_receive(uint8_t *bytes, size_t size);   /* take received bytes; return their number */
void board_send(const uint8_t *bytes, size_t size);

typedef enum { STATION_RUNNING, STATION_CENTRED, STATION_DUMPED } station_state;

typedef struct {
    const station_settings *settings;
    frame_decoder decoder;
    station_state state;
    station_outputs outputs;
    uint32_t counts[STATION_MAX_JOINTS]; /* voltages without dither */
    uint32_t heard, dumped;              /* times of the last command and of the dump */
    int opened, reset, numbered;
    uint16_t last; /* number of the last command, where there is one (`numbered`) */
} station;

/* Begin with the air out. */
void station_start(station *self, const station_settings *settings);
/* Do everything once: call it again and again. */
void station_step(station *self);

#endif
