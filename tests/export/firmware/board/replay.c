/* Replays what a device read and heard in each cycle: what it drives and sends, and its numbers, go to a file. */
#include <string.h>

#include "controller.h"
#include "start.h"

#define NUMBERS_EVERY 20u /* cycles */

static struct {
    station_samples samples;
    uint32_t size;
    uint8_t bytes[FRAME_MAX_SIZE];
} given;
static struct {
    station_outputs outputs;
    uint32_t ticks, stack, size;
    uint8_t bytes[2048];
} made;

extern const controller_settings machine_controller;
static controller rig;

void board_sample(station_samples *samples) { *samples = given.samples; }

void board_drive(const station_outputs *outputs) { made.outputs = *outputs; }

size_t board_receive(uint8_t *bytes, size_t size) {
    const size_t got = given.size < size ? given.size : size;
    memcpy(bytes, given.bytes, got);
    return got;
}

void board_send(const uint8_t *bytes, size_t size) {
    memcpy(made.bytes + made.size, bytes, size);
    made.size += (uint32_t)size;
}

int main(void) {
    const int32_t in = file_open("in.bin", READ_BINARY), out = file_open("out.bin", WRITE_BINARY);
    if (in < 0 || out < 0) {
        return 2;
    }
    paint_stack();
    controller_start(&rig, &machine_controller);
    for (uint32_t k = 0u; file_read(in, &given, sizeof given) == 0; k++) {
        made.size = 0u;
        const uint32_t then = ticks_now();
        controller_step(&rig);
        made.ticks = ticks_since(then);
        made.stack = stack_used();
        (void)file_write(out, &made, sizeof made);
        if (k % NUMBERS_EVERY == 0u) {
            (void)file_write(out, &rig.memory, sizeof rig.memory);
            (void)file_write(out, &rig.results, sizeof rig.results);
        }
    }
    return 0;
}
