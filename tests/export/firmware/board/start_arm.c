/* Start of a program on qemu's MPS2 boards, and calls of its host. */
#include "start.h"

extern uint32_t stack_top;
void reset(void);
void die(void);
void uart_received(void);
void uart_sent(void);

int32_t semihost(uint32_t operation, const void *arguments) {
    register uint32_t r0 __asm__("r0") = operation;
    register const void *r1 __asm__("r1") = arguments;
    __asm__ volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
    return (int32_t)r0;
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
    SYSTICK_RELOAD = 0xFFFFFFu;
    SYSTICK_VALUE = 0u;
    SYSTICK_CONTROL = 5u; /* on, by the processor's clock */
    start();
}
