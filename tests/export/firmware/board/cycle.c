/* Replays recorded control cycles: results, outcome, ticks of each call and stack go to a file. */
#include "rig.h"
#include "start.h"

static struct {
    rig_cycle_inputs inputs;
    rig_cycle_samples samples;
    rig_cycle_memory memory;
    rig_law_memory law_memory;
    rig_law_report report;
} numbers;
static rig_cycle_workspace workspace;

int main(void) {
    const int32_t in = file_open("in.bin", READ_BINARY), out = file_open("out.bin", WRITE_BINARY);
    int32_t stages[2];
    if (in < 0 || out < 0) {
        return 2;
    }
    paint_stack();
    while (file_read(in, stages, sizeof stages) == 0 && file_read(in, &numbers, sizeof numbers) == 0) {
        const uint32_t then = SYSTICK_VALUE;
        const int32_t outcome = rig_cycle_run(
            &rig_default_rig_settings, &rig_default_cycle_settings, &numbers.inputs, &numbers.samples,
            &numbers.memory, &rig_default_arm_settings, &rig_default_law_settings, &numbers.law_memory,
            &numbers.report, &workspace, stages[0]);
        const uint32_t measured[4] = {(uint32_t)outcome, ticks_since(then), stack_used(), 0u};
        (void)file_write(out, measured, sizeof measured);
        (void)file_write(out, &numbers, sizeof numbers);
    }
    return 0;
}
