/* Functions of C for a library of Windows that is linked without zig's own, which would add a third to its size; all
   others are those of the system's C library (UCRT). */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#define UCRT_STANDARD_SNPRINTF 2 /* option: end the text with a zero, and return its whole length */

__declspec(dllimport) int __stdio_common_vsprintf(uint64_t options, char *text, size_t size, const char *format,
                                                  void *locale, va_list arguments);

/* Entry point, called as the library is loaded: it needs no preparation. */
int DllMainCRTStartup(void *library, unsigned reason, void *reserved) {
    (void)library, (void)reason, (void)reserved;
    return 1;
}

int vsnprintf(char *restrict text, size_t size, const char *restrict format, va_list arguments) {
    return __stdio_common_vsprintf(UCRT_STANDARD_SNPRINTF, text, size, format, NULL, arguments);
}

/* In assembler, else the compiler makes loops calls of the functions that they define. */

void *memcpy(void *restrict to, const void *restrict from, size_t size) {
    void *place = to;
    __asm__ volatile("rep movsb" : "+D"(place), "+S"(from), "+c"(size) : : "memory");
    return to;
}

/* Copy from the last byte on where the first would overwrite others that are still to be copied. */
void *memmove(void *to, const void *from, size_t size) {
    if ((uintptr_t)to - (uintptr_t)from >= size) return memcpy(to, from, size);
    for (size_t i = size; i > 0; i--) ((volatile char *)to)[i - 1] = ((const char *)from)[i - 1];
    return to;
}

void *memset(void *to, int value, size_t size) {
    void *place = to;
    __asm__ volatile("rep stosb" : "+D"(place), "+c"(size) : "a"(value) : "memory");
    return to;
}

/* Touch each page of a large frame, rax bytes below the caller's stack pointer, as Windows extends a stack by pages
   that are touched in order; all registers are kept. */
__asm__(".globl ___chkstk_ms\n"
        "___chkstk_ms:\n"
        "  push %rcx\n"
        "  push %rax\n"
        "  lea 24(%rsp), %rcx\n"
        "1: cmp $0x1000, %rax\n"
        "  jb 2f\n"
        "  sub $0x1000, %rcx\n"
        "  orb $0, (%rcx)\n"
        "  sub $0x1000, %rax\n"
        "  jmp 1b\n"
        "2: sub %rax, %rcx\n"
        "  orb $0, (%rcx)\n"
        "  pop %rax\n"
        "  pop %rcx\n"
        "  ret\n");
