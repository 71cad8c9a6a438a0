/* Steps an FMI 2.0 co-simulation slave through a table of inputs, at compiled speed. The addresses come from whoever loaded it. */
#include <stddef.h>

#if defined(_WIN32)
#define HD_API __declspec(dllexport)
#else
#define HD_API __attribute__((visibility("default")))
#endif

typedef int (*set_real)(void *, const unsigned *, size_t, const double *);
typedef int (*get_real)(void *, const unsigned *, size_t, double *);
typedef int (*do_step)(void *, double, double, int);
enum { WARNING = 1 };

/* Rows k < n: set in[k][n_in], read out[k][n_out], step from t[k] to t[k + 1]. Returns how many rows were read. */
HD_API long hd_run(set_real set, get_real get, do_step step, void *slave, long n, const double *t, size_t n_in, const unsigned *in_vr,
                   const double *in, size_t n_out, const unsigned *out_vr, double *out) {
    for (long k = 0; k < n; k++) {
        if (n_in && set(slave, in_vr, n_in, in + (size_t)k * n_in) > WARNING) return k;
        if (get(slave, out_vr, n_out, out + (size_t)k * n_out) > WARNING) return k;
        if (k + 1 < n && step(slave, t[k], t[k + 1] - t[k], 1) > WARNING) return k + 1;
    }
    return n;
}
