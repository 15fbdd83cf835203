/* A device that runs the law on QEMU's MPS2 boards; at its second UART is a rig that obeys voltages.
   A transaction with the rig is a control cycle of simulated time, for both, however long it takes. */
#include "controller.h"

#define board_sample mps2_sample
#define board_drive mps2_drive
#include "board_mps2.c"
#undef board_sample
#undef board_drive

#define PLANT_DATA (*(volatile uint32_t *)0x40005000u)
#define PLANT_STATE (*(volatile uint32_t *)0x40005004u)
#define PLANT_CONTROL (*(volatile uint32_t *)0x40005008u)
#define PLANT_DIVIDER (*(volatile uint32_t *)0x40005010u)
#define PATIENCE 1000000u /* for a reading, us */

extern const controller_settings machine_controller;
static controller rig;
static frame_decoder decoder;
static station_samples sampled;
static uint16_t number;
static int air, reset;
static uint8_t outputs;

static uint32_t take(const uint8_t **bytes, uint8_t bits) {
    uint32_t count = 0u;
    for (size_t i = bits >= 16u ? 4u : 2u; i > 0u; i--) {
        count = count << 8 | *(*bytes)++;
    }
    return count;
}

static void send_command(void) {
    const station_settings *s = machine_controller.station;
    uint8_t payload[2u + 2u * STATION_MAX_JOINTS], bytes[FRAME_MAX_SIZE];
    reset = !reset; /* so that the rig obeys whenever it can */
    uint8_t *end = station_put(payload, (uint32_t)air | (uint32_t)reset << 1 | (uint32_t)outputs << 8, 2u);
    for (size_t j = 0; j < s->joints; j++) {
        end = station_put(end, rig.station.counts[j], 2u);
    }
    const size_t size = frame_encode(FRAME_COMMAND, ++number, payload, (size_t)(end - payload), bytes);
    for (size_t i = 0; i < size; i++) {
        while ((PLANT_STATE & 1u) != 0u) {
        }
        PLANT_DATA = bytes[i];
    }
}

static void read_reading(const frame *taken) {
    const station_settings *s = machine_controller.station;
    const uint8_t *bytes = taken->payload;
    sampled.stopped = (take(&bytes, 2u) & 4u) != 0u;
    sampled.supply = take(&bytes, s->supply_bits);
    for (size_t j = 0; j < s->joints; j++) {
        sampled.angle[j] = take(&bytes, s->angle_bits);
        sampled.pressure[j] = take(&bytes, s->pressure_bits);
    }
    sampled.time += machine_controller.cycle;
}

/* Perform a transaction with the rig; return whether a reading came. */
static int exchange(void) {
    station_samples clock;
    frame taken;
    send_command();
    mps2_sample(&clock);
    for (const uint32_t asked = clock.time; clock.time - asked < PATIENCE; mps2_sample(&clock)) {
        WATCHDOG_LOAD = WATCHDOG_TICKS;
        if ((PLANT_STATE & 2u) != 0u && frame_decode(&decoder, (uint8_t)PLANT_DATA, &taken) &&
            taken.kind == FRAME_READING && taken.sequence == number) {
            read_reading(&taken);
            return 1;
        }
    }
    return 0;
}

void board_sample(station_samples *samples) {
    PLANT_DIVIDER = 16u;
    PLANT_CONTROL = 3u;
    while (!exchange()) {
        board_drive(&(station_outputs){.air = air, .outputs = outputs}); /* feeds the watchdog */
    }
    *samples = sampled;
}

void board_drive(const station_outputs *driven_now) {
    air = driven_now->air;
    outputs = driven_now->outputs;
    mps2_drive(driven_now);
}

int main(void) {
    controller_start(&rig, &machine_controller);
    for (;;) {
        controller_step(&rig);
    }
}
