/* Fixed-step exponential Runge-Kutta of order four (Cox and Matthews 2002, eqs. 26-29) with diagonal linear part.
 *
 * x_i' = f_i = N_i - a_i x_i with the relaxation rate a_i held over a sub-step, N_i = f_i + a_i x_i. Where a_i = 0 it is the
 * classical Runge-Kutta method. A rate that is too large costs a little accuracy, never stability, so the larger one of
 * the rates at the start and at a predicted end is taken. Stiffness off the diagonal sets the number of sub-steps.
 * Sensitivities S = dx/d(p, x0) obey S' = J S + f_p and are advanced by the same formula: column 0 of X is the state,
 * the other HK_W - 1 columns are S.
 *
 * This file knows no physics and is included once for every width. Before it stand HK_W, HK_FN(name), HK_EVAL and HK_OUT,
 * and what is generated: HK_NX, HK_NU, HK_NP, HK_NY, hk_stiff[], hk_rates, hk_coupling. */

static inline void HK_FN(column)(real X[HK_NX][HK_W], real *x) {
    for (int i = 0; i < HK_NX; i++) x[i] = X[i][0];
}

/* Relaxation rates for one sub-step of length h, whose input goes from u0 to u1: of a motion that is the input, the speed. */
HK_INLINE void HK_FN(relax)(real t, real X[HK_NX][HK_W], const real *u0, const real *u1, const real *p, real F[HK_NX][HK_W], real h, real *a) {
    real x[HK_NX], end[HK_NX];
    HK_FN(column)(X, x);
    hk_rates(t, x, u0, p, a);
    for (int i = 0; i < HK_NX; i++) x[i] = x[i] + h * F[i][0];
    hk_rates(t + h, x, u1, p, end);
    for (int i = 0; i < HK_NX; i++) a[i] = hk_max(a[i], end[i]);
}

/* One sub-step of length h; u0 is the input at its start, slope its rate of change. */
HK_INLINE void HK_FN(substep)(real X[HK_NX][HK_W], real t, const real *u0, const real *slope, const real *p, real h) {
    real F[HK_NX][HK_W], N0[HK_NX][HK_W], Na[HK_NX][HK_W], Nb[HK_NX][HK_W], Xa[HK_NX][HK_W], Xs[HK_NX][HK_W];
    real a[HK_NX], um[HK_NU], u1[HK_NU];
    hk_weights w[HK_NX];
    for (int j = 0; j < HK_NU; j++) {
        um[j] = u0[j] + 0.5 * h * slope[j];
        u1[j] = u0[j] + h * slope[j];
    }
    HK_EVAL(t, X, u0, p, F);
    HK_FN(relax)(t, X, u0, u1, p, F, h, a);
    for (int i = 0; i < HK_NX; i++) {
        w[i] = hk_stiff[i] ? hk_weigh(a[i], h) : hk_classical(h);
        for (int c = 0; c < HK_W; c++) {
            N0[i][c] = hk_stiff[i] ? F[i][c] + a[i] * X[i][c] : F[i][c];
            Xa[i][c] = w[i].half * X[i][c] + w[i].half_phi * N0[i][c];
        }
    }
    HK_EVAL(t + 0.5 * h, Xa, um, p, F);
    for (int i = 0; i < HK_NX; i++)
        for (int c = 0; c < HK_W; c++) {
            Na[i][c] = hk_stiff[i] ? F[i][c] + a[i] * Xa[i][c] : F[i][c];
            Xs[i][c] = w[i].half * X[i][c] + w[i].half_phi * Na[i][c];
        }
    HK_EVAL(t + 0.5 * h, Xs, um, p, F);
    for (int i = 0; i < HK_NX; i++)
        for (int c = 0; c < HK_W; c++) {
            Nb[i][c] = hk_stiff[i] ? F[i][c] + a[i] * Xs[i][c] : F[i][c];
            Xs[i][c] = w[i].half * Xa[i][c] + w[i].half_phi * (2.0 * Nb[i][c] - N0[i][c]);
        }
    HK_EVAL(t + h, Xs, u1, p, F);
    for (int i = 0; i < HK_NX; i++)
        for (int c = 0; c < HK_W; c++) {
            real Nc = hk_stiff[i] ? F[i][c] + a[i] * Xs[i][c] : F[i][c];
            X[i][c] = w[i].full * X[i][c] + (w[i].f1 * N0[i][c] + w[i].f2 * (Na[i][c] + Nb[i][c]) + w[i].f3 * Nc);
        }
}

/* Advance by dt in equal inner steps no longer than h. Each is cut into sub-steps: the state at the start of a sub-step says
 * how many of its length would fill the inner step, the last one takes what is left. */
static inline void HK_FN(advance)(real X[HK_NX][HK_W], double t, double dt, const real *u, const real *slope, const real *p, double h) {
    long steps = (long)(dt / h - 1e-6) + 1;
    double inner = dt;
    if (steps > 1) inner = dt / (double)steps; /* a branch, so that the common case does not wait for a division */
    for (long k = 0; k < steps; k++) {
        real past = K(0.0);
        for (int s = 0; s < HK_MAX_SUBSTEPS; s++) {
            real x[HK_NX], now[HK_NU], trial[HK_NX][HK_W], left = inner - past, since = (double)k * inner + past;
            mask active = hk_true(left > K(0.0));
            if (!hk_any(active)) break;
            HK_FN(column)(X, x);
            for (int j = 0; j < HK_NU; j++) now[j] = u[j] + since * slope[j];
            real parts = hk_substeps(t + since, x, now, p, inner);
            if (s == 0 && hk_most(parts) == 1) { HK_FN(substep)(X, t + since, now, slope, p, K(inner)); break; }
            real sub = inner / parts;
            mask last = hk_true(left - sub < K(1e-9 * inner)) | hk_true(K((double)s) == K(HK_MAX_SUBSTEPS - 1.0));
            sub = hk_select(last, left, sub);
            for (int i = 0; i < HK_NX; i++) for (int c = 0; c < HK_W; c++) trial[i][c] = X[i][c];
            HK_FN(substep)(trial, t + since, now, slope, p, sub);
            for (int i = 0; i < HK_NX; i++) for (int c = 0; c < HK_W; c++) X[i][c] = hk_select(active, trial[i][c], X[i][c]);
            past = hk_select(last, K(inner), past + sub);
        }
    }
}

/* Lanes in which everything is finite. */
static inline mask HK_FN(finite)(real X[HK_NX][HK_W]) {
    mask good = hk_true(K(0.0) == K(0.0));
    for (int i = 0; i < HK_NX; i++)
        for (int c = 0; c < HK_W; c++) good &= hk_true(hk_abs(X[i][c]) < K(c ? 1e150 : 1e12));
    return good;
}

/* Run through n rows of inputs u[n][HK_NU]; the outputs of a row go to Y. Returns the rows done: n, or fewer
 * where no lane is finite any more. */
static inline long HK_FN(rows)(long n, const double *t, const double *u, int linear, const real *p, real X[HK_NX][HK_W], double h,
                               void (*store)(void *, long, real [HK_NY][HK_W]), void *where) {
    real now[HK_NU], slope[HK_NU], Y[HK_NY][HK_W];
    for (long k = 0; k < n; k++) {
        double dt = k + 1 < n ? t[k + 1] - t[k] : 1.0;
        for (int j = 0; j < HK_NU; j++) {
            double here = u[k * HK_NU + j], next = k + 1 < n ? u[(k + 1) * HK_NU + j] : here;
            now[j] = K(here);
            slope[j] = K((linear >> j) & 1 ? (next - here) / dt : 0.0);
        }
        if (!hk_any(HK_FN(finite)(X))) return k;
        HK_OUT(K(t[k]), X, now, p, Y);
        store(where, k, Y);
        if (k + 1 < n) HK_FN(advance)(X, t[k], dt, now, slope, p, h);
    }
    return n;
}
