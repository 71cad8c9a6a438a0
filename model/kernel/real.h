/* Arithmetic of the kernel: `real` is a double, or HK_LANES doubles side by side (one parameter set a lane).
 * Every function is branch-free and written once for both, without fused multiply-add, so that lanes and scalars agree bit
 * for bit and so do platforms. */
#ifndef HK_REAL_H
#define HK_REAL_H
#include <float.h>
#include <stdint.h>

/* Rounding by a large summand, NaN that is no number, and equal bits everywhere need arithmetic as it is written. */
#if defined(__FAST_MATH__) || defined(__ASSOCIATIVE_MATH__) || defined(_M_FP_FAST) || (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__)
#error "expected arithmetic by IEEE 754, got -ffast-math or a part of it (/fp:fast): the results would be wrong; compile without it"
#endif
#if defined(FLT_EVAL_METHOD) && FLT_EVAL_METHOD != 0
#error "expected doubles that are calculated as doubles, got wider ones: compile with -msse2 -mfpmath=sse"
#endif
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#elif defined(__GNUC__)
#pragma GCC optimize("fp-contract=off") /* GCC does not know the standard's pragma */
#elif defined(_MSC_VER)
#pragma fp_contract(off)
#else
#pragma STDC FP_CONTRACT OFF
#endif

/* HK_TIGHT: one step in one function, so that what its stages share is calculated once. It takes a quarter less time and twice as long
 * to compile: for what is compiled once and stepped for long. */
#if defined(HK_TIGHT) && defined(__GNUC__)
#define HK_INLINE static inline __attribute__((always_inline))
#else
#define HK_INLINE static inline
#endif

#ifdef HK_LANES
typedef double real __attribute__((vector_size(8 * HK_LANES)));
typedef uint64_t mask __attribute__((vector_size(8 * HK_LANES)));
#define HK_BITS(x) ((mask)(x))
#define HK_FROM_BITS(i) ((real)(i))
#define hk_true(c) ((mask)(c)) /* a comparison of vectors yields all bits or none */
static inline real hk_sqrt(real x) { return __builtin_elementwise_sqrt(x); }
#else
typedef double real;
typedef uint64_t mask;
typedef union { real x; mask i; } hk_bits_of; /* C99 reads the bits of a number through a union */
static inline mask hk_bits(real x) { hk_bits_of b; b.x = x; return b.i; }
static inline real hk_from_bits(mask i) { hk_bits_of b; b.i = i; return b.x; }
#define HK_BITS(x) hk_bits(x)
#define HK_FROM_BITS(i) hk_from_bits(i)
static inline mask hk_true(mask c) { return -(mask)(c != 0); } /* as a vector comparison yields it: all bits or none */
#if defined(__GNUC__)
static inline real hk_sqrt(real x) { return __builtin_sqrt(x); }
#else
#include <math.h>
static inline real hk_sqrt(real x) { return sqrt(x); }
#endif
#endif
#define K(c) ((real){0} + (c))
#define HK_NEUTRAL (-(real){0}) /* x + -0.0 is x to the bit: makes lanes of a number, costs nothing where they are lanes */

static inline real hk_select(mask c, real a, real b) {
    return HK_FROM_BITS((c & HK_BITS(a)) | (~c & HK_BITS(b)));
}
static inline real hk_abs(real x) { return HK_FROM_BITS(HK_BITS(x) & (UINT64_MAX >> 1)); }
static inline real hk_max(real a, real b) { return hk_select(hk_true(a > b), a, b); }
static inline real hk_min(real a, real b) { return hk_select(hk_true(a < b), a, b); }
static inline real hk_sign(real x) {
    return hk_select(hk_true(x > K(0.0)), K(1.0), hk_select(hk_true(x < K(0.0)), K(-1.0), K(0.0)));
}
static inline real hk_step(real x) { return hk_select(hk_true(x > K(0.0)), K(1.0), K(0.0)); }

/* Nearest integer of |x| < 2^51 by adding 1.5·2^52; the low bits of the sum hold the integer. */
#define HK_ROUNDER 6755399441055744.0

/* exp(x) = 2^n·exp(r), |r| <= ln2/2, Taylor to r^13 (remainder 4e-18), Estrin's order; arguments are clamped to +-700. */
HK_INLINE real hk_exp(real x) {
    x = hk_max(hk_min(x, K(700.0)), K(-700.0));
    real k = x * 1.4426950408889634 + HK_ROUNDER;
    mask n = HK_BITS(k);
    k = k - HK_ROUNDER;
    real r = (x - k * 0x1.62e42feep-1) - k * 0x1.a39ef35793c76p-33;
    real r2 = r * r, r4 = r2 * r2, r8 = r4 * r4;
    real a0 = 1.0 + r, a1 = 1.0 / 2 + r * (1.0 / 6), a2 = 1.0 / 24 + r * (1.0 / 120), a3 = 1.0 / 720 + r * (1.0 / 5040);
    real a4 = 1.0 / 40320 + r * (1.0 / 362880), a5 = 1.0 / 3628800 + r * (1.0 / 39916800);
    real a6 = 1.0 / 479001600 + r * (1.0 / 6227020800.0);
    real e = ((a0 + r2 * a1) + r4 * (a2 + r2 * a3)) + r8 * ((a4 + r2 * a5) + r4 * a6);
    return e * HK_FROM_BITS((n + 1023) << 52);
}

/* log(x) = k·ln2 + log(m), sqrt(1/2) <= m < sqrt(2); log(m) = 2·atanh(s), s = (m - 1)/(m + 1), |s| <= 0.172, by its series to s^23
 * (remainder 1e-19). Arguments below the least normal number count as it. */
HK_INLINE real hk_log(real x) {
    mask all = HK_BITS(hk_max(x, K(0x1p-1022))), k = (all - 0x3fe6a09e667f3bcd + (UINT64_C(1023) << 52)) >> 52; /* k + 1023 */
    real m = HK_FROM_BITS(all - ((k - 1023) << 52));
    real n = HK_FROM_BITS(k | 0x4330000000000000) - 4503599627371519.0; /* bits of 2^52 + k; less 2^52 + 1023 */
    real s = (m - 1.0) / (m + 1.0), q = s * s, q2 = q * q, q4 = q2 * q2;
    real b0 = 1.0 / 3 + q * (1.0 / 5), b1 = 1.0 / 7 + q * (1.0 / 9), b2 = 1.0 / 11 + q * (1.0 / 13);
    real b3 = 1.0 / 15 + q * (1.0 / 17), b4 = 1.0 / 19 + q * (1.0 / 21);
    real tail = ((b0 + q2 * b1) + q4 * (b2 + q2 * b3)) + q4 * q4 * (b4 + q2 * (1.0 / 23));
    return n * 0x1.62e42feep-1 + (2.0 * (s + s * q * tail) + n * 0x1.a39ef35793c76p-33);
}

/* sin and cos: x = k·pi/2 + r in three parts, Taylor on |r| <= pi/4 (remainder 2e-17), quadrant by k. Full accuracy to |x| < 1e5. */
HK_INLINE void hk_sincos(real x, real *s, real *c) {
    real k = x * 0.63661977236758134 + HK_ROUNDER;
    mask n = HK_BITS(k);
    k = k - HK_ROUNDER;
    real r = ((x - k * 0x1.921fb544p+0) - k * 0x1.0b4611a6p-34) - k * 0x1.3198a2e037073p-69;
    real q = r * r;
    real sr = r + r * q * (-1.0 / 6 + q * (1.0 / 120 + q * (-1.0 / 5040 + q * (1.0 / 362880 + q * (-1.0 / 39916800
            + q * (1.0 / 6227020800.0 + q * (-1.0 / 1307674368000.0)))))));
    real cr = 1.0 - q * 0.5 + q * q * (1.0 / 24 + q * (-1.0 / 720 + q * (1.0 / 40320 + q * (-1.0 / 3628800
            + q * (1.0 / 479001600 + q * (-1.0 / 87178291200.0 + q * (1.0 / 20922789888000.0)))))));
    mask odd = -(n & 1), flip_s = (n & 2) << 62, flip_c = ((n + 1) & 2) << 62;
    *s = HK_FROM_BITS(HK_BITS(hk_select(odd, cr, sr)) ^ flip_s);
    *c = HK_FROM_BITS(HK_BITS(hk_select(odd, sr, cr)) ^ flip_c);
}
static inline real hk_sin(real x) { real s, c; hk_sincos(x, &s, &c); return s; }
static inline real hk_cos(real x) { real s, c; hk_sincos(x, &s, &c); return c; }
static inline real hk_tanh(real x) { return 1.0 - 2.0 / (hk_exp(2.0 * x) + 1.0); }

/* phi_1, phi_2, phi_3 and exp at L <= 0: phi_3 by Taylor where |L| < 1 and the others from it, else from exp downward. */
typedef struct { real e, p1, p2, p3; } hk_phi_t;
static inline hk_phi_t hk_phi_near(real z) {
    real z2 = z * z, z4 = z2 * z2, z8 = z4 * z4;
    real b0 = 1.0 / 6 + z * (1.0 / 24), b1 = 1.0 / 120 + z * (1.0 / 720), b2 = 1.0 / 5040 + z * (1.0 / 40320);
    real b3 = 1.0 / 362880 + z * (1.0 / 3628800), b4 = 1.0 / 39916800 + z * (1.0 / 479001600);
    real b5 = 1.0 / 6227020800.0 + z * (1.0 / 87178291200.0), b6 = 1.0 / 1307674368000.0 + z * (1.0 / 20922789888000.0);
    hk_phi_t p;
    p.p3 = ((b0 + z2 * b1) + z4 * (b2 + z2 * b3)) + z8 * ((b4 + z2 * b5) + z4 * b6);
    p.p2 = 0.5 + z * p.p3;
    p.p1 = 1.0 + z * p.p2;
    p.e = 1.0 + z * p.p1;
    return p;
}
static inline hk_phi_t hk_phi_far(real L) {
    real inverse = 1.0 / L;
    hk_phi_t p;
    p.e = hk_exp(L);
    p.p1 = (p.e - 1.0) * inverse;
    p.p2 = (p.p1 - 1.0) * inverse;
    p.p3 = (p.p2 - 0.5) * inverse;
    return p;
}
static inline hk_phi_t hk_phi(real L) {
#ifdef HK_LANES
    hk_phi_t near = hk_phi_near(hk_max(L, K(-1.0))), far = hk_phi_far(hk_min(L, K(-0.5))), p;
    mask c = hk_true(L < K(-1.0));
    p.e = hk_select(c, far.e, near.e);
    p.p1 = hk_select(c, far.p1, near.p1);
    p.p2 = hk_select(c, far.p2, near.p2);
    p.p3 = hk_select(c, far.p3, near.p3);
    return p;
#else
    return L < -1.0 ? hk_phi_far(L) : hk_phi_near(hk_max(L, -1.0)); /* the same bits for half the work */
#endif
}
#endif
