/* What tests need of a simulated board. */
#ifndef START_H
#define START_H

#include <stdint.h>

#ifdef __riscv
static inline uint32_t ticks_now(void) {
    uint32_t instructions;
    __asm__ volatile("csrr %0, minstret" : "=r"(instructions));
    return instructions;
}
static inline uint32_t ticks_since(uint32_t then) { return ticks_now() - then; }
#else
#define SYSTICK_CONTROL (*(volatile uint32_t *)0xE000E010u)
#define SYSTICK_RELOAD (*(volatile uint32_t *)0xE000E014u)
#define SYSTICK_VALUE (*(volatile uint32_t *)0xE000E018u)
static inline uint32_t ticks_now(void) { return SYSTICK_VALUE; }
static inline uint32_t ticks_since(uint32_t then) { return (then - SYSTICK_VALUE) & 0xFFFFFFu; }
#endif

#define PAINT 0xDEADBEEFu
#define READ_BINARY 1
#define WRITE_BINARY 5

/* Call the host, as semihosting numbers its operations. */
int32_t semihost(uint32_t operation, const void *arguments);
/* Set the variables to their initial values, run the program, and end it. */
void start(void);
void end(uint32_t status);
int32_t file_open(const char *name, int32_t mode);
/* Return the number of bytes that were not read, or not written. */
int32_t file_read(int32_t file, void *to, uint32_t bytes);
int32_t file_write(int32_t file, const void *from, uint32_t bytes);
/* Fill the free part of the stack, and return how many bytes of it have been used since. */
void paint_stack(void);
uint32_t stack_used(void);

#endif
