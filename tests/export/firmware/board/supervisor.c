/* Replays inputs of a supervisor: its results and memory, ticks of each cycle and stack go to a file. */
#include "rig.h"
#include "start.h"

static rig_supervisor_inputs inputs;
static rig_supervisor_memory memory;
static rig_supervisor_results results;
static rig_supervisor_workspace workspace;

int main(void) {
    const int32_t in = file_open("in.bin", READ_BINARY), out = file_open("out.bin", WRITE_BINARY);
    if (in < 0 || out < 0) {
        return 2;
    }
    paint_stack();
    memory = rig_default_supervisor_memory;
    while (file_read(in, &inputs, sizeof inputs) == 0) {
        const uint32_t then = ticks_now();
        rig_supervisor_cycle(&rig_default_supervisor_settings, &inputs, &memory, &results, &workspace);
        const uint32_t measured[2] = {ticks_since(then), stack_used()};
        (void)file_write(out, measured, sizeof measured);
        (void)file_write(out, &memory, sizeof memory);
        (void)file_write(out, &results, sizeof results);
    }
    return 0;
}
