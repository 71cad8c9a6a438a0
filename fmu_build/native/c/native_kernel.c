/* The kernel of a native FMU: compiled into this file, on a buffer in the host's memory. */

/* Whether the compiler kept the arithmetic as it is written. No macro tells of clang's -fassociative-math, which takes the rounding out
 * of exponential and sine: what comes out is wrong by far more than a rounding, and known here. */
static int arithmetic_is_kept(void) {
    volatile double given = 0.7; /* volatile: calculated at run time, as everything else */
    const double x = given, e = hk_exp(x) - 2.0137527074704766;
    double s, c;
    hk_sincos(4 * x, &s, &c);
    s -= 0.33498815015590491;
    c += 0.94222234066865806;
    return e * e + s * s + c * c < 1e-28;
}

static const char *open_kernel(Instance *s, const char *resources) {
    (void)resources;
    if (!arithmetic_is_kept()) return "expected arithmetic by IEEE 754, got a part of -ffast-math: compile without it";
    s->v = s->call.allocateMemory(HF_END + 1, sizeof *s->v);
    return s->v ? NULL : "expected memory from the host, got none";
}

static void close_kernel(Instance *s) {
    if (s->v) s->call.freeMemory(s->v);
}

static void kernel_output(Instance *s) {
#ifdef HK_NC
    if (s->tangent) hf_output_tangent(s->v, s->time); else
#endif
    hf_output(s->v, s->time);
}

static int kernel_step(Instance *s, double t, double dt) {
#ifdef HK_NC
    if (s->tangent) return hf_step_tangent(s->v, t, dt);
#endif
    return hf_step(s->v, t, dt);
}

static int kernel_pivot(Instance *s, double *pivot) { return hf_pivot(s->v, s->time, pivot); }

static void kernel_rates(Instance *s) { hk_derivatives(s->time, s->v + HF_X, s->v + HF_U, s->v + HF_P, s->v + HF_DX); }
