/* The four functions for QEMU's MPS2 boards: the host is at the first UART; no machine is there. */
#include "station.h"

#if defined(__ARM_ARCH_8M_MAIN__) /* AN505, in the secure state */
#define UART 0x50200000u
#define WATCHDOG 0x50081000u
#define INTERRUPTS_ON (*(volatile uint32_t *)0xE000E104u) /* those from 32 on */
#define TICKS_PER_US 20u
#else
#define UART 0x40004000u
#define WATCHDOG 0x40008000u
#define INTERRUPTS_ON (*(volatile uint32_t *)0xE000E100u)
#define TICKS_PER_US 25u
#endif
#define UART_DATA (*(volatile uint32_t *)UART)
#define UART_STATE (*(volatile uint32_t *)(UART + 0x4u))
#define UART_CONTROL (*(volatile uint32_t *)(UART + 0x8u))
#define UART_INTERRUPT (*(volatile uint32_t *)(UART + 0xCu))
#define UART_DIVIDER (*(volatile uint32_t *)(UART + 0x10u))
#define WATCHDOG_LOAD (*(volatile uint32_t *)WATCHDOG)
#define WATCHDOG_CONTROL (*(volatile uint32_t *)(WATCHDOG + 0x8u))
#define WATCHDOG_LOCK (*(volatile uint32_t *)(WATCHDOG + 0xC00u))
#define SYSTICK_CONTROL (*(volatile uint32_t *)0xE000E010u)
#define SYSTICK_RELOAD (*(volatile uint32_t *)0xE000E014u)
#define SYSTICK_VALUE (*(volatile uint32_t *)0xE000E018u)
#define WATCHDOG_TICKS (TICKS_PER_US * 500000u) /* half a second; the second time it runs out, the processor starts anew */
#define QUEUE 1024u /* bytes, a power of two */
#ifndef BAUD
#define BAUD 921600u
#endif

typedef struct {
    volatile uint32_t taken, put; /* bytes so far */
    uint8_t bytes[QUEUE];
} queue;

static queue received, sent;
static station_outputs driven;
static uint32_t time_us, rest, last;

/* A byte has come. A full queue loses it, and the frame's checksum tells. */
void uart_received(void);
void uart_received(void) {
    UART_INTERRUPT = 2u;
    while ((UART_STATE & 2u) != 0u) {
        const uint8_t byte = (uint8_t)UART_DATA;
        if (received.put - received.taken < QUEUE) {
            received.bytes[received.put % QUEUE] = byte;
            received.put++;
        }
    }
}

/* The next byte can go. */
void uart_sent(void);
void uart_sent(void) {
    UART_INTERRUPT = 1u;
    while (sent.taken != sent.put && (UART_STATE & 1u) == 0u) {
        UART_DATA = sent.bytes[sent.taken % QUEUE];
        sent.taken++;
    }
}

static void start(void) {
    SYSTICK_RELOAD = 0xFFFFFFu;
    SYSTICK_VALUE = 0u;
    SYSTICK_CONTROL = 5u;
    UART_DIVIDER = TICKS_PER_US * 1000000u / BAUD;
    UART_CONTROL = 0xFu;
    INTERRUPTS_ON = 3u;
    WATCHDOG_LOCK = 0x1ACCE551u;
    WATCHDOG_LOAD = WATCHDOG_TICKS;
    WATCHDOG_CONTROL = 3u;
    last = SYSTICK_VALUE;
}

void board_sample(station_samples *samples) {
    if (UART_CONTROL != 0xFu) {
        start();
    }
    const uint32_t now = SYSTICK_VALUE;
    rest += (last - now) & 0xFFFFFFu;
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
}

void board_drive(const station_outputs *outputs) {
    driven = *outputs;
    WATCHDOG_LOAD = WATCHDOG_TICKS;
}

size_t board_receive(uint8_t *bytes, size_t size) {
    size_t got = 0u;
    while (got < size && received.taken != received.put) {
        bytes[got++] = received.bytes[received.taken % QUEUE];
        received.taken++;
    }
    return got;
}

void board_send(const uint8_t *bytes, size_t size) {
    for (size_t i = 0; i < size; i++) {
        while (sent.put - sent.taken >= QUEUE) {
        }
        sent.bytes[sent.put % QUEUE] = bytes[i];
        sent.put++;
    }
    __asm volatile("cpsid i" ::: "memory");
    uart_sent();
    __asm volatile("cpsie i" ::: "memory");
}
