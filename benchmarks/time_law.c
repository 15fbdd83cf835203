/* Times recorded cycles of a control law: prints the mean time of a call in the fastest round, ns. */
#define _POSIX_C_SOURCE 200809L
#include <stdio.h>
#include <time.h>

#include "law.h"

enum { MAX_CYCLES = 4096, ROUNDS = 200 };

static struct {
    law_sensed sensed;
    law_demand demand;
} rows[MAX_CYCLES];

static double now(void)
{
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return 1e9 * (double)time.tv_sec + (double)time.tv_nsec;
}

int main(void)
{
    law_sensed first;
    law_memory memory;
    law_command command;
    law_report report;
    double best = 1e300;
    if (fread(&first, sizeof first, 1, stdin) != 1) {
        return 2;
    }
    const size_t count = fread(rows, sizeof rows[0], MAX_CYCLES, stdin);
    for (int round = 0; round < ROUNDS; round++) {
        law_control_wake(&law_default_settings, &first, &memory);
        const double begun = now();
        for (size_t k = 0; k < count; k++) {
            law_control_step(&law_default_settings, &memory, &rows[k].sensed, &rows[k].demand, LAW_CYCLE, &memory,
                             &command, &report);
        }
        const double time = (now() - begun) / (double)count;
        best = time < best ? time : best;
    }
    printf("%.0f\n", best);
    return 0;
}
