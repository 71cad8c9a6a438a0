/* Weights of the exponential Runge-Kutta step, and the number of sub-steps; included once, before stepper.h. */
#ifndef HK_MAX_SUBSTEPS
#define HK_MAX_SUBSTEPS 64
#endif

typedef struct { real half, half_phi, full, f1, f2, f3; } hk_weights;

HK_INLINE hk_weights hk_weigh(real a, real h) {
    hk_phi_t z = hk_phi(-0.5 * h * a);
    real p1 = 0.5 * (z.e + 1.0) * z.p1; /* phi_k(2z) from phi_k(z) */
    real p2 = 0.25 * (z.p1 * z.p1 + 2.0 * z.p2);
    real p3 = 0.125 * (z.p1 * z.p2 + 2.0 * z.p3 + z.p2);
    hk_weights w = {z.e, 0.5 * h * z.p1, z.e * z.e, h * (p1 - 3.0 * p2 + 4.0 * p3), h * (2.0 * p2 - 4.0 * p3), h * (4.0 * p3 - p2)};
    return w;
}

static inline hk_weights hk_classical(real h) {
    hk_weights w = {K(1.0), 0.5 * h, K(1.0), h * (1.0 / 6), h * (1.0 / 3), h * (1.0 / 6)};
    return w;
}

/* Sub-steps of a step h such that h·sqrt(coupling) <= 1, a whole number between 1 and HK_MAX_SUBSTEPS. */
HK_INLINE real hk_substeps(real t, const real *x, const real *u, const real *p, double h) {
    real c = hk_coupling(t, x, u, p);
    real n = hk_min(hk_sqrt(hk_select(hk_true(c < K(1e30)), c, K(0.0))) * h + 0.5, K(HK_MAX_SUBSTEPS));
    return hk_max((n + HK_ROUNDER) - HK_ROUNDER, K(1.0));
}

#ifdef HK_LANES
static inline int hk_any(mask c) { int any = 0; for (int l = 0; l < HK_LANES; l++) any |= c[l] != 0; return any; }
static inline long hk_most(real n) { long most = 1; for (int l = 0; l < HK_LANES; l++) most = (long)n[l] > most ? (long)n[l] : most; return most; }
#else
static inline int hk_any(mask c) { return c != 0; }
static inline long hk_most(real n) { return (long)n; }
#endif
