#include "station.h"

extern const station_settings rig_settings;
static station rig;

int main(void) {
    station_start(&rig, &rig_settings);
    for (;;) {
        station_step(&rig);
    }
}
