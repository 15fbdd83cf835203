/* The four functions for QEMU's board virt: the host is at its UART; no machine is there, nor a watchdog. */
#include "station.h"

#define UART_DATA (*(volatile uint8_t *)0x10000000u)
#define UART_FIFO (*(volatile uint8_t *)0x10000002u)
#define UART_STATE (*(volatile uint8_t *)0x10000005u)
#define CLOCK (*(volatile uint32_t *)0x0200BFF8u)
#define TICKS_PER_US 10u
#define QUEUE 1024u /* bytes, a power of two */

static struct {
    uint32_t taken, put; /* bytes so far */
    uint8_t bytes[QUEUE];
} sent;
static station_outputs driven;
static uint32_t time_us, rest, last;

/* Send what the UART takes without waiting. */
static void flush(void) {
    while (sent.taken != sent.put && (UART_STATE & 0x20u) != 0u) {
        UART_DATA = sent.bytes[sent.taken % QUEUE];
        sent.taken++;
    }
}

void board_sample(station_samples *samples) {
    const uint32_t now = CLOCK;
    rest += now - last;
    last = now;
    time_us += rest / TICKS_PER_US;
    rest %= TICKS_PER_US;
    samples->time = time_us;
    samples->stopped = 0;
    samples->supply = driven.air ? 3000u : 0u;
    for (size_t j = 0; j < STATION_MAX_JOINTS; j++) {
        samples->angle[j] = 2048u + 16u * (uint32_t)j;
        samples->pressure[j] = 2048u;
    }
    flush();
}

void board_drive(const station_outputs *outputs) {
    driven = *outputs;
}

/* The UART keeps sixteen bytes, if its queue is on; a board with a real line needs an interrupt here. */
size_t board_receive(uint8_t *bytes, size_t size) {
    size_t got = 0u;
    UART_FIFO = 1u;
    while (got < size && (UART_STATE & 1u) != 0u) {
        bytes[got++] = UART_DATA;
    }
    return got;
}

void board_send(const uint8_t *bytes, size_t size) {
    for (size_t i = 0; i < size; i++) {
        while (sent.put - sent.taken >= QUEUE) {
            flush();
        }
        sent.bytes[sent.put % QUEUE] = bytes[i];
        sent.put++;
    }
    flush();
}
