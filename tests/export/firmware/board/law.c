/* Replays recorded cycles through a control law: results, ticks of each call and stack go to a file. */
#include "law.h"
#include "start.h"

static law_memory memory;
static law_sensed sensed;
static law_demand demand;
static law_command command;
static law_report report;

int main(void) {
    const int32_t in = file_open("in.bin", READ_BINARY), out = file_open("out.bin", WRITE_BINARY);
    if (in < 0 || out < 0 || file_read(in, &sensed, sizeof sensed) != 0) {
        return 2;
    }
    paint_stack();
    law_control_wake(&law_default_settings, &sensed, &memory);
    (void)file_write(out, &memory, sizeof memory);
    while (file_read(in, &sensed, sizeof sensed) == 0 && file_read(in, &demand, sizeof demand) == 0) {
        const uint32_t then = ticks_now();
        law_control_step(&law_default_settings, &memory, &sensed, &demand, LAW_CYCLE, &memory, &command, &report);
        const uint32_t measured[2] = {ticks_since(then), stack_used()};
        (void)file_write(out, &memory, sizeof memory);
        (void)file_write(out, &command, sizeof command);
        (void)file_write(out, &report, sizeof report);
        (void)file_write(out, measured, sizeof measured);
    }
    return 0;
}
