/* Start of a program on qemu's MPS2 boards, and its host's files by semihosting. */
#include "start.h"

#include <stddef.h>

int main(void);
void reset(void);
void die(void);
void uart_received(void);
void uart_sent(void);
extern uint32_t stack_top, bss_start, bss_end, data_start, data_end, data_load;

static int32_t semihost(uint32_t operation, const void *arguments) {
    register uint32_t r0 __asm__("r0") = operation;
    register const void *r1 __asm__("r1") = arguments;
    __asm__ volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
    return (int32_t)r0;
}

static void end(uint32_t status) {
    const uint32_t arguments[2] = {0x20026u, status}; /* ADP_Stopped_ApplicationExit */
    (void)semihost(0x20u, arguments);
    for (;;) {
    }
}

void die(void) { end(3u); }

/* Interrupts of the first UART, where a program has them. */
__attribute__((weak)) void uart_received(void) { die(); }
__attribute__((weak)) void uart_sent(void) { die(); }

struct vectors {
    const uint32_t *stack;
    void (*handlers[17])(void);
};

__attribute__((section(".vectors"), used)) static const struct vectors vectors = {
    &stack_top, {reset, die, die, die, die, die, [15] = uart_received, uart_sent}};

void reset(void) {
    *(volatile uint32_t *)0xE000ED88u |= 0xFu << 20; /* CPACR: numbers in hardware */
    __asm__ volatile("dsb; isb");
    for (uint32_t *to = &bss_start; to < &bss_end; to++) {
        *to = 0u;
    }
    for (uint32_t *to = &data_start, *from = &data_load; to < &data_end; to++, from++) {
        *to = *from;
    }
    SYSTICK_RELOAD = 0xFFFFFFu;
    SYSTICK_VALUE = 0u;
    SYSTICK_CONTROL = 5u; /* on, by the processor's clock */
    end((uint32_t)main());
}

int32_t file_open(const char *name, int32_t mode) {
    uint32_t length = 0u;
    while (name[length] != '\0') {
        length++;
    }
    const uint32_t arguments[3] = {(uint32_t)name, (uint32_t)mode, length};
    return semihost(0x01u, arguments);
}

int32_t file_read(int32_t file, void *to, uint32_t bytes) {
    const uint32_t arguments[3] = {(uint32_t)file, (uint32_t)to, bytes};
    return semihost(0x06u, arguments);
}

int32_t file_write(int32_t file, const void *from, uint32_t bytes) {
    const uint32_t arguments[3] = {(uint32_t)file, (uint32_t)from, bytes};
    return semihost(0x05u, arguments);
}

uint32_t ticks_since(uint32_t then) { return (then - SYSTICK_VALUE) & 0xFFFFFFu; }

void paint_stack(void) {
    uint32_t here;
    __asm__ volatile("mov %0, sp" : "=r"(here));
    for (uint32_t *word = &bss_end; (uint32_t)word < here - 32u; word++) {
        *(volatile uint32_t *)word = PAINT;
    }
}

uint32_t stack_used(void) {
    const uint32_t *word = &bss_end;
    while (*(const volatile uint32_t *)word == PAINT) {
        word++;
    }
    return (uint32_t)&stack_top - (uint32_t)word;
}
