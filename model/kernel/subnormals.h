/* Numbers below 2^-1022 count as 0 while a simulation runs; the caller's mode comes back after it. What decays ends among
 * them and stays there, since the least of them times a half is rounded to itself, and each operation on one takes a
 * hundred cycles. Where the mode is not known, they stay: slower, and the same to 2^-1022. */
#if defined(__GNUC__) && defined(__SSE2__)
typedef unsigned hk_mode;
static inline hk_mode hk_flush(void) {
    hk_mode before = __builtin_ia32_stmxcsr();
    __builtin_ia32_ldmxcsr(before | 0x8040u); /* results and operands */
    return before;
}
static inline void hk_restore(hk_mode before) { __builtin_ia32_ldmxcsr(before); }
#elif defined(_MSC_VER) && defined(_M_X64)
#include <xmmintrin.h>
typedef unsigned hk_mode;
static inline hk_mode hk_flush(void) {
    hk_mode before = _mm_getcsr();
    _mm_setcsr(before | 0x8040u);
    return before;
}
static inline void hk_restore(hk_mode before) { _mm_setcsr(before); }
#elif defined(__GNUC__) && defined(__aarch64__)
typedef uint64_t hk_mode;
static inline hk_mode hk_flush(void) {
    hk_mode before;
    __asm__ volatile("mrs %0, fpcr" : "=r"(before));
    __asm__ volatile("msr fpcr, %0" : : "r"(before | (UINT64_C(1) << 24)));
    return before;
}
static inline void hk_restore(hk_mode before) { __asm__ volatile("msr fpcr, %0" : : "r"(before)); }
#else
typedef int hk_mode;
static inline hk_mode hk_flush(void) { return 0; }
static inline void hk_restore(hk_mode before) { (void)before; }
#endif
