/* Device that obeys the voltages of its host. */
#include "station.h"

extern const station_settings machine_station;
static station rig;

int main(void) {
    station_start(&rig, &machine_station);
    for (;;) {
        station_step(&rig);
    }
}
