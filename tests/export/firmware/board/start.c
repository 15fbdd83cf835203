/* Memory of a program on a board of qemu, its host's files by semihosting, and its stack. */
#include "start.h"

#include <stddef.h>

int main(void);
extern uint32_t stack_top, bss_start, bss_end, data_start, data_end, data_load;

void end(uint32_t status) {
    const uint32_t arguments[2] = {0x20026u, status}; /* ADP_Stopped_ApplicationExit */
    (void)semihost(0x20u, arguments);
    for (;;) {
    }
}

void start(void) {
    for (uint32_t *to = &bss_start; to < &bss_end; to++) {
        *to = 0u;
    }
    for (uint32_t *to = &data_start, *from = &data_load; to < &data_end; to++, from++) {
        *to = *from;
    }
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

void paint_stack(void) {
    const uint32_t here = (uint32_t)__builtin_frame_address(0);
    for (uint32_t *word = &bss_end; (uint32_t)word < here - 64u; word++) {
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
