/* What the compiler may call although no library is linked: the binaries depend on nothing and load anywhere. */
#include <stddef.h>

#ifndef __has_attribute
#define __has_attribute(x) 0
#endif
#if __has_attribute(no_builtin)
#define BARE __attribute__((no_builtin("memset", "memcpy", "memmove"), visibility("hidden")))
#else
#define BARE __attribute__((visibility("hidden")))
#endif

BARE void *memset(void *to, int value, size_t n) {
    unsigned char *p = to;
    for (size_t i = 0; i < n; i++) p[i] = (unsigned char)value;
    return to;
}

BARE void *memcpy(void *restrict to, const void *restrict from, size_t n) {
    unsigned char *p = to;
    const unsigned char *q = from;
    for (size_t i = 0; i < n; i++) p[i] = q[i];
    return to;
}

BARE void *memmove(void *to, const void *from, size_t n) {
    unsigned char *p = to;
    const unsigned char *q = from;
    if (p < q) for (size_t i = 0; i < n; i++) p[i] = q[i];
    else for (size_t i = n; i-- > 0;) p[i] = q[i];
    return to;
}

#if defined(_WIN32)
int _fltused = 1;
void *bare_module; /* handle of this library */
int __stdcall DllMainCRTStartup(void *module, unsigned long reason, void *reserved) {
    (void)reason; (void)reserved;
    bare_module = module;
    return 1;
}

/* The compiler calls this with rax = size of a frame beyond one page: touch its pages downward, so that the stack grows. */
__asm__(".globl ___chkstk_ms\n"
        "___chkstk_ms:\n"
        "    pushq %rax\n"
        "    pushq %rcx\n"
        "    leaq 24(%rsp), %rcx\n"
        "0:  cmpq $4096, %rax\n"
        "    jbe 1f\n"
        "    subq $4096, %rcx\n"
        "    subq $4096, %rax\n"
        "    orb $0, (%rcx)\n"
        "    jmp 0b\n"
        "1:  subq %rax, %rcx\n"
        "    orb $0, (%rcx)\n"
        "    popq %rcx\n"
        "    popq %rax\n"
        "    ret\n");
#endif
