/* What a careful engineer writes for one joint with LuGre friction: the same method, formulas by hand, libm, one loop.
 * p: M, g_c, g_s, Kp, Ks, epos, s0, s1, s2, vs, Fs, Fc. */
#include <math.h>

typedef struct { double half, half_phi, full, f1, f2, f3; } weights;

static double g_of(double v, const double *p) {
    double r = v / p[9];
    return p[11] + (p[10] - p[11]) * exp(-r * r);
}

static void rates(const double *x, const double *p, double *a) {
    a[1] = (p[7] + p[8]) / p[0];
    a[2] = p[6] * fabs(x[1]) / g_of(x[1], p);
}

static void f(const double *x, double u, const double *p, double *dx) {
    double dz = x[1] - p[6] * fabs(x[1]) / g_of(x[1], p) * x[2];
    double load = p[1] * cos(x[0]) + p[2] * sin(x[0]) + p[4] * (x[0] - p[5]) + p[6] * x[2] + p[7] * dz + p[8] * x[1];
    dx[0] = x[1];
    dx[1] = (p[3] * u - load) / p[0];
    dx[2] = dz;
}

/* phi_1..phi_3 at z <= 0: series near 0, else by recursion from exp. */
static weights weigh(double a, double h) {
    double z = -0.5 * h * a, e, p1, p2, p3;
    if (z > -1.0) {
        p3 = 0;
        for (int k = 13; k >= 0; k--) {
            static const double inverse[14] = {1 / 6.0, 1 / 24.0, 1 / 120.0, 1 / 720.0, 1 / 5040.0, 1 / 40320.0, 1 / 362880.0,
                1 / 3628800.0, 1 / 39916800.0, 1 / 479001600.0, 1 / 6227020800.0, 1 / 87178291200.0, 1 / 1307674368000.0, 1 / 20922789888000.0};
            p3 = inverse[k] + z * p3;
        }
        p2 = 0.5 + z * p3;
        p1 = 1 + z * p2;
        e = 1 + z * p1;
    } else {
        e = exp(z);
        p1 = (e - 1) / z;
        p2 = (p1 - 1) / z;
        p3 = (p2 - 0.5) / z;
    }
    double q1 = 0.5 * (e + 1) * p1, q2 = 0.25 * (p1 * p1 + 2 * p2), q3 = 0.125 * (p1 * p2 + 2 * p3 + p2);
    return (weights){e, 0.5 * h * p1, e * e, h * (q1 - 3 * q2 + 4 * q3), h * (2 * q2 - 4 * q3), h * (4 * q3 - q2)};
}

static void step(double *x, double u, const double *p, double h) {
    double F[3], N0[3], Na[3], Nb[3], Nc[3], Xa[3], Xs[3], a[3] = {0}, b[3] = {0}, end[3];
    weights w[3] = {{1, 0.5 * h, 1, h / 6, h / 3, h / 6}};
    f(x, u, p, F);
    for (int i = 0; i < 3; i++) end[i] = x[i] + h * F[i];
    rates(x, p, a);
    rates(end, p, b);
    for (int i = 1; i < 3; i++) w[i] = weigh(a[i] = fmax(a[i], b[i]), h);
    for (int i = 0; i < 3; i++) { N0[i] = F[i] + a[i] * x[i]; Xa[i] = w[i].half * x[i] + w[i].half_phi * N0[i]; }
    f(Xa, u, p, F);
    for (int i = 0; i < 3; i++) { Na[i] = F[i] + a[i] * Xa[i]; Xs[i] = w[i].half * x[i] + w[i].half_phi * Na[i]; }
    f(Xs, u, p, F);
    for (int i = 0; i < 3; i++) { Nb[i] = F[i] + a[i] * Xs[i]; Xs[i] = w[i].half * Xa[i] + w[i].half_phi * (2 * Nb[i] - N0[i]); }
    f(Xs, u, p, F);
    for (int i = 0; i < 3; i++) {
        Nc[i] = F[i] + a[i] * Xs[i];
        x[i] = w[i].full * x[i] + w[i].f1 * N0[i] + w[i].f2 * (Na[i] + Nb[i]) + w[i].f3 * Nc[i];
    }
}

#if defined(_WIN32)
__declspec(dllexport)
#else
__attribute__((visibility("default")))
#endif
void by_hand(long n, double h, const double *u, const double *p, double *x, double *y) {
    for (long k = 0; k < n; k++) {
        y[k] = x[0];
        step(x, u[k], p, h);
    }
}
