/* The four functions for qemu's MPS2 boards: the serial line is the first UART; sensors read what was driven. */
#include "station.h"

#define UART_DATA (*(volatile uint32_t *)0x40004000u)
#define UART_STATE (*(volatile uint32_t *)0x40004004u)
#define UART_CONTROL (*(volatile uint32_t *)0x40004008u)
#define UART_DIVIDER (*(volatile uint32_t *)0x40004010u)
#define SYSTICK_CONTROL (*(volatile uint32_t *)0xE000E010u)
#define SYSTICK_RELOAD (*(volatile uint32_t *)0xE000E014u)
#define SYSTICK_VALUE (*(volatile uint32_t *)0xE000E018u)
#define TICKS_PER_US 25u

static station_outputs driven;
static uint32_t time_us, rest, last;

static void advance(void) {
    if (UART_CONTROL != 3u) {
        SYSTICK_RELOAD = 0xFFFFFFu;
        SYSTICK_VALUE = 0u;
        SYSTICK_CONTROL = 5u;
        UART_DIVIDER = 217u; /* 115200 baud */
        UART_CONTROL = 3u;
        last = SYSTICK_VALUE;
    }
    const uint32_t now = SYSTICK_VALUE;
    rest += (last - now) & 0xFFFFFFu;
    last = now;
    time_us += rest / TICKS_PER_US;
    rest %= TICKS_PER_US;
}

void board_sample(station_samples *samples) {
    advance();
    samples->time = time_us;
    samples->stopped = 0;
    samples->supply = driven.air ? 3000u : 0u;
    for (size_t j = 0; j < STATION_MAX_JOINTS; j++) {
        samples->angle[j] = 2048u + 16u * (uint32_t)j;
        samples->pressure[j] = driven.voltage[j] >> 4;
    }
}

void board_drive(const station_outputs *outputs) { driven = *outputs; }

size_t board_receive(uint8_t *bytes, size_t size) {
    size_t got = 0u;
    while (got < size && (UART_STATE & 2u) != 0u) {
        bytes[got++] = (uint8_t)UART_DATA;
    }
    return got;
}

void board_send(const uint8_t *bytes, size_t size) {
    for (size_t i = 0; i < size; i++) {
        while ((UART_STATE & 1u) != 0u) {
        }
        UART_DATA = bytes[i];
    }
}
