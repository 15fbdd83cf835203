/* Two machines side by side, memory updated in place, and a state that is saved and restored; 0 if all is as it must be. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "paper_arm.h"

enum { JOINTS = PAPER_ARM_JOINTS };

struct machine {
    paper_arm_parameters parameters;
    paper_arm_state state;
    paper_arm_memory memory;
    paper_arm_outputs outputs[JOINTS];
};

static void rest(struct machine *machine, double angle, double payload)
{
    paper_arm_angles angles;
    paper_arm_pressures pressures;
    paper_arm_noise noise[JOINTS] = { { 0.0, 0.0 }, { 0.0, 0.0 } };
    paper_arm_sensed sensed;
    int j;
    memset(machine, 0, sizeof *machine);
    machine->parameters = paper_arm_default_parameters;
    machine->parameters.around.payload = payload;
    for (j = 0; j < JOINTS; j++) {
        angles.angle[j] = angle;
        pressures.pressure_a[j] = NAN;
        pressures.pressure_b[j] = NAN;
    }
    paper_arm_plant_rest(&machine->parameters, &angles, &pressures, &machine->state);
    paper_arm_plant_sample(&machine->parameters, &machine->state, noise, &sensed);
    paper_arm_control_wake(&paper_arm_default_settings, &sensed, &machine->memory);
}

/* Run some cycles; `in_place` has the law write its memory where it read it. */
static int run(struct machine *machine, int cycles, int in_place)
{
    paper_arm_demand demand = { { 0.2, 0.1 }, { 0.0, 0.0 }, { 0.0, 0.0 }, { 0.0, 0.0 } };
    paper_arm_noise noise[JOINTS] = { { 0.5, -0.5 }, { 1.0, 0.25 } };
    paper_arm_inputs inputs[JOINTS] = { { 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0 }, { 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0 } };
    int j, k;
    for (k = 0; k < cycles; k++) {
        paper_arm_sensed sensed;
        paper_arm_command command;
        paper_arm_report report;
        paper_arm_memory after;
        paper_arm_plant_sample(&machine->parameters, &machine->state, noise, &sensed);
        paper_arm_control_step(&paper_arm_default_settings, &machine->memory, &sensed, &demand, PAPER_ARM_CYCLE,
                               in_place ? &machine->memory : &after, &command, &report);
        if (!in_place) {
            machine->memory = after;
        }
        for (j = 0; j < JOINTS; j++) {
            inputs[j].voltage = command.voltage[j];
        }
        if (paper_arm_plant_advance(&machine->parameters, &machine->state, inputs, machine->outputs, PAPER_ARM_STEPS,
                                    1) >= 0) {
            return 1;
        }
    }
    return 0;
}

static int differ(const struct machine *one, const struct machine *other)
{
    return memcmp(&one->state, &other->state, sizeof one->state) != 0
        || memcmp(&one->memory, &other->memory, sizeof one->memory) != 0
        || memcmp(one->outputs, other->outputs, sizeof one->outputs) != 0;
}

int main(void)
{
    static struct machine alone, beside, heavy, saved;
    int k;
    rest(&alone, 0.0, 1.0);
    if (run(&alone, 200, 1)) return 10;

    rest(&beside, 0.0, 1.0);
    rest(&heavy, 0.1, 3.0);
    for (k = 0; k < 100; k++) {
        if (run(&beside, 1, 0) || run(&heavy, 1, 1)) return 11;
    }
    if (beside.state.step != 100 * PAPER_ARM_STEPS) return 12;
    memcpy(&saved, &beside, sizeof saved);
    if (run(&beside, 100, 0)) return 13;
    if (differ(&alone, &beside)) return 14; /* alone in place, beside another machine with a copy of the memory */
    if (!differ(&beside, &heavy)) return 15;
    if (!differ(&beside, &saved)) return 16;
    if (run(&saved, 100, 1)) return 17;
    if (differ(&beside, &saved)) return 18; /* continued from a copy */

    rest(&heavy, 0.0, 1.0);
    heavy.parameters.around.supply_pressure = NAN;
    if (run(&heavy, 1, 1) != 1) return 19; /* numbers that are none are reported, not trapped */
    puts("as it must be");
    return 0;
}
