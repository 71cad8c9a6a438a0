/* The functions that the outside calls. Lanes give only the vectorised run; the scalar build gives everything. */
#ifdef HK_API /* whoever includes this keeps the functions to itself */
#elif defined(_WIN32)
#define HK_API __declspec(dllexport)
#else
#define HK_API __attribute__((visibility("default")))
#endif

#ifdef HK_LANES

typedef struct { double *y; long n; long first, last; } hk_lane_sink;
static void hk_store_lanes(void *where, long k, real Y[HK_NY][1]) {
    hk_lane_sink *s = where;
    for (long l = 0; l < HK_LANES && s->first + l < s->last; l++)
        for (int o = 0; o < HK_NY; o++) s->y[((s->first + l) * s->n + k) * HK_NY + o] = Y[o][0][l];
}

/* Parameter sets [first, last) of p[sets][HK_NP], x0[sets][HK_NX]: y[sets][n][HK_NY]. Returns how many sets ran to the end. */
HK_API long hk_simulate_lanes(long first, long last, long n, const double *t, const double *u, int linear, const double *p,
                              const double *x0, double h, double *y, signed char *done) {
    long good = 0;
    hk_mode mode = hk_flush();
    for (long base = first; base < last; base += HK_LANES) {
        real P[HK_NP + 1], X[HK_NX][1];
        for (int i = 0; i < HK_NP; i++)
            for (long l = 0; l < HK_LANES; l++) P[i][l] = p[(base + l < last ? base + l : last - 1) * HK_NP + i];
        for (int i = 0; i < HK_NX; i++)
            for (long l = 0; l < HK_LANES; l++) X[i][0][l] = x0[(base + l < last ? base + l : last - 1) * HK_NX + i];
        hk_lane_sink sink = {y, n, base, last};
        hk_plain_rows(n, t, u, linear, P, X, h, hk_store_lanes, &sink);
        mask finite = hk_plain_finite(X);
        for (long l = 0; l < HK_LANES && base + l < last; l++) { done[base + l] = finite[l] != 0; good += finite[l] != 0; }
    }
    hk_restore(mode);
    return good;
}

#else

typedef struct { double *y, *dy; } hk_sink;
static void hk_store_plain(void *where, long k, real Y[HK_NY][1]) {
    hk_sink *s = where;
    for (int o = 0; o < HK_NY; o++) s->y[k * HK_NY + o] = Y[o][0];
}

/* y[n][HK_NY] from x0[HK_NX]; x_end[HK_NX] is the state at the last row. linear: bit j set where input j is interpolated. */
HK_API long hk_simulate(long n, const double *t, const double *u, int linear, const double *p, const double *x0, double h,
                        double *y, double *x_end) {
    real X[HK_NX][1];
    hk_sink sink = {y, 0};
    for (int i = 0; i < HK_NX; i++) X[i][0] = x0[i];
    hk_mode mode = hk_flush();
    long done = hk_plain_rows(n, t, u, linear, p, X, h, hk_store_plain, &sink);
    hk_restore(mode);
    for (int i = 0; i < HK_NX; i++) x_end[i] = X[i][0];
    return done;
}

/* Advance x by dt, as a co-simulation step does. Returns 1, or 0 where the state would leave the finite numbers: then x stays. */
HK_API int hk_advance(double *x, double t, double dt, const double *u, const double *slope, const double *p, double h) {
    real X[HK_NX][1];
    for (int i = 0; i < HK_NX; i++) X[i][0] = x[i];
    hk_mode mode = hk_flush();
    hk_plain_advance(X, t, dt, u, slope, p, h);
    hk_restore(mode);
    if (!hk_plain_finite(X)) return 0;
    for (int i = 0; i < HK_NX; i++) x[i] = X[i][0];
    return 1;
}

HK_API void hk_derivatives(double t, const double *x, const double *u, const double *p, double *f) {
    real X[HK_NX][1], F[HK_NX][1];
    for (int i = 0; i < HK_NX; i++) X[i][0] = x[i];
    hk_eval_plain(t, X, u, p, F);
    for (int i = 0; i < HK_NX; i++) f[i] = F[i][0];
}

HK_API void hk_output(double t, const double *x, const double *u, const double *p, double *y) {
    real X[HK_NX][1], Y[HK_NY][1];
    for (int i = 0; i < HK_NX; i++) X[i][0] = x[i];
    hk_out_plain(t, X, u, p, Y);
    for (int i = 0; i < HK_NY; i++) y[i] = Y[i][0];
}

#ifdef HK_NC
static void hk_store_tangent(void *where, long k, real Y[HK_NY][1 + HK_NC]) {
    hk_sink *s = where;
    for (int o = 0; o < HK_NY; o++) {
        s->y[k * HK_NY + o] = Y[o][0];
        for (int c = 0; c < HK_NC; c++) s->dy[(k * HK_NY + o) * HK_NC + c] = Y[o][1 + c];
    }
}

static void hk_seed(real X[HK_NX][1 + HK_NC], const double *x0, const double *S0) {
    for (int i = 0; i < HK_NX; i++) {
        X[i][0] = x0[i];
        for (int c = 0; c < HK_NC; c++) X[i][1 + c] = S0[i * HK_NC + c];
    }
}

/* As hk_simulate, with dy[n][HK_NY][HK_NC]: columns are the parameters, then the initial states. S0[HK_NX][HK_NC] are
 * the sensitivities at the first row, S_end those at the last; they may be one array. */
HK_API long hk_simulate_tangent(long n, const double *t, const double *u, int linear, const double *p, const double *x0,
                                const double *S0, double h, double *y, double *dy, double *x_end, double *S_end) {
    real X[HK_NX][1 + HK_NC];
    hk_sink sink = {y, dy};
    hk_seed(X, x0, S0);
    hk_mode mode = hk_flush();
    long done = hk_tangent_rows(n, t, u, linear, p, X, h, hk_store_tangent, &sink);
    hk_restore(mode);
    for (int i = 0; i < HK_NX; i++) {
        x_end[i] = X[i][0];
        for (int c = 0; c < HK_NC; c++) S_end[i * HK_NC + c] = X[i][1 + c];
    }
    return done;
}

/* As hk_advance, with S[HK_NX][HK_NC] advanced too. */
HK_API int hk_advance_tangent(double *x, double *S, double t, double dt, const double *u, const double *slope, const double *p, double h) {
    real X[HK_NX][1 + HK_NC];
    hk_seed(X, x, S);
    hk_mode mode = hk_flush();
    hk_tangent_advance(X, t, dt, u, slope, p, h);
    hk_restore(mode);
    if (!hk_tangent_finite(X)) return 0;
    for (int i = 0; i < HK_NX; i++) {
        x[i] = X[i][0];
        for (int c = 0; c < HK_NC; c++) S[i * HK_NC + c] = X[i][1 + c];
    }
    return 1;
}

/* As hk_output, with dY[HK_NY][HK_NC], the derivatives of y along the columns of S[HK_NX][HK_NC]. */
HK_API void hk_output_tangent(double t, const double *x, const double *S, const double *u, const double *p, double *y, double *dY) {
    real X[HK_NX][1 + HK_NC], Y[HK_NY][1 + HK_NC];
    hk_seed(X, x, S);
    hk_out_tangent(t, X, u, p, Y);
    for (int i = 0; i < HK_NY; i++) {
        y[i] = Y[i][0];
        for (int c = 0; c < HK_NC; c++) dY[i * HK_NC + c] = Y[i][1 + c];
    }
}

/* Derivatives of f and y in direction (dx, dp) are read off the tangent columns: F[HK_NX][1+HK_NC], Y[HK_NY][1+HK_NC] from S. */
HK_API void hk_linearise(double t, const double *x, const double *S, const double *u, const double *p, double *dF, double *dY) {
    real X[HK_NX][1 + HK_NC], F[HK_NX][1 + HK_NC], Y[HK_NY][1 + HK_NC];
    hk_seed(X, x, S);
    hk_eval_tangent(t, X, u, p, F);
    hk_out_tangent(t, X, u, p, Y);
    for (int i = 0; i < HK_NX; i++) for (int c = 0; c < HK_NC; c++) dF[i * HK_NC + c] = F[i][1 + c];
    for (int i = 0; i < HK_NY; i++) for (int c = 0; c < HK_NC; c++) dY[i * HK_NC + c] = Y[i][1 + c];
}
#endif
#endif
