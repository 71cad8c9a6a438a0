/* Innovations of an Ornstein-Uhlenbeck process seen through white noise, for several columns of data at once.
 *
 * Covariance of a column: S(i, j) = noise^2 delta_ij + error^2 exp(-|t_i - t_j| / time). The Kalman filter of the scalar state
 * gives L^-1 v for the Cholesky factor S = L L'. Rows with keep = 0 are not seen. v[columns][n] is overwritten by L^-1 v
 * (0 where not seen); the logarithm of the determinant of S is returned. */
#include <math.h>

__attribute__((visibility("default")))
double uq_whiten(long columns, long n, const double *t, const signed char *keep, double noise, double error, double time, double *v) {
    double P = error * error, logdet = 0.0;
    double mean[columns];
    for (long c = 0; c < columns; c++) mean[c] = 0.0;
    for (long k = 0; k < n; k++) {
        if (k > 0) {
            double phi = exp((t[k - 1] - t[k]) / time);
            P = phi * phi * P + error * error * (1.0 - phi * phi);
            for (long c = 0; c < columns; c++) mean[c] *= phi;
        }
        if (!keep[k]) {
            for (long c = 0; c < columns; c++) v[c * n + k] = 0.0;
            continue;
        }
        double S = P + noise * noise, gain = P / S, scale = 1.0 / sqrt(S);
        for (long c = 0; c < columns; c++) {
            double innovation = v[c * n + k] - mean[c];
            mean[c] += gain * innovation;
            v[c * n + k] = innovation * scale;
        }
        P *= 1.0 - gain;
        logdet += log(S);
    }
    return logdet;
}

/* Row of the first number that is not 0, n where there is none: the column of a cycle is 0 before the cycle. */
static long first_row(const double *v, long n) {
    long k = 0;
    while (k < n && v[k] == 0.0) k++;
    return k;
}

/* gram[columns][columns] = v v' for v[columns][n], both triangles. The order of summation is fixed: same input, same bits.
 * Rows before both columns have begun add 0, and are left out by whole groups of eight, so that the order stays. */
__attribute__((visibility("default")))
void uq_gram(long columns, long n, const double *v, double *gram) {
    long first[columns];
    for (long i = 0; i < columns; i++) first[i] = first_row(v + i * n, n);
    for (long i = 0; i < columns; i++)
        for (long j = 0; j <= i; j++) {
            double s[8] = {0, 0, 0, 0, 0, 0, 0, 0};
            const double *a = v + i * n, *b = v + j * n;
            long k = (first[i] > first[j] ? first[i] : first[j]) / 8 * 8;
            for (; k + 8 <= n; k += 8)
                for (int l = 0; l < 8; l++) s[l] += a[k + l] * b[k + l];
            for (; k < n; k++) s[0] += a[k] * b[k];
            double total = ((s[0] + s[4]) + (s[1] + s[5])) + ((s[2] + s[6]) + (s[3] + s[7]));
            gram[i * columns + j] = gram[j * columns + i] = total;
        }
}
