/* Start of a program on qemu's RISC-V board, and calls of its host. */
#include "start.h"

void reset(void);

int32_t semihost(uint32_t operation, const void *arguments) {
    register uint32_t a0 __asm__("a0") = operation;
    register const void *a1 __asm__("a1") = arguments;
    __asm__ volatile(
        ".option push; .option norvc; .balign 16\n"
        "slli zero, zero, 0x1f; ebreak; srai zero, zero, 7\n"
        ".option pop"
        : "+r"(a0)
        : "r"(a1)
        : "memory");
    return (int32_t)a0;
}

__attribute__((section(".vectors"), naked, used)) void reset(void) {
    __asm__ volatile("la sp, stack_top; li t0, 0x6000; csrs mstatus, t0; j start"); /* FS: numbers in hardware */
}
