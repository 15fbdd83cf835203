/* Device that runs the control law and the supervisor itself. */
#include "controller.h"

extern const controller_settings machine_controller;
static controller rig;

int main(void) {
    controller_start(&rig, &machine_controller);
    for (;;) {
        controller_step(&rig);
    }
}
