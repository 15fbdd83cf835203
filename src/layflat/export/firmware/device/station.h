/* Device of a rig: obeys a host over the serial line, and makes safe by itself when the host falls silent. */
#ifndef LAYFLAT_STATION_H
#define LAYFLAT_STATION_H

#include "frames.h"

#define STATION_MAX_JOINTS 7u
#define STATION_WAVE 32u /* steps of the dither */
#define STATION_IDENTITY_WORDS 14u

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

typedef struct {
    int air, reset;
    uint8_t outputs;
    uint32_t voltage[STATION_MAX_JOINTS]; /* counts, without dither */
} station_command;

/* The four functions of a board. */
void board_sample(station_samples *samples);         /* read all sensors, the e-stop and the clock */
void board_drive(const station_outputs *outputs);    /* drive all outputs, and feed the hardware's watchdog */
size_t board_receive(uint8_t *bytes, size_t size);   /* take received bytes; return their number */
void board_send(const uint8_t *bytes, size_t size);  /* send bytes; a line that takes long has to be fed elsewhere */

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
/* Do everything once, as a device that obeys the host's voltages: call it again and again. */
void station_step(station *self);

/* The parts of a step, of which `controller.c` makes its own: read the sensors, and dump while the e-stop is pressed. */
void station_sample(station *self, station_samples *samples);
/* Obey a command, which counts as a sign of life. */
void station_obey(station *self, const station_command *command, const station_samples *samples);
/* Make safe where no command has come for some time, and drive the outputs. */
void station_finish(station *self, const station_samples *samples);
/* Return whether the number of a message comes after the last one, which it then is. */
int station_is_new(station *self, uint16_t sequence);
/* Write a number, an identity or a reading, high byte first; return the end. */
uint8_t *station_put(uint8_t *out, uint32_t number, size_t bytes);
uint8_t *station_put_identity(const station_settings *settings, uint8_t *out);
uint8_t *station_put_reading(
    const station_settings *settings, station_state state, const station_samples *samples, uint8_t *out);
void station_reply(uint8_t kind, uint16_t sequence, const uint8_t *payload, const uint8_t *end);

#endif
