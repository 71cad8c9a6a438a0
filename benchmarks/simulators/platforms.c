/* Steps the co-simulation of an FMU's binary through rows of inputs, on whichever platform this is compiled for.
 *
 *     program BINARY VERSION GUID < plan > outputs
 *
 * plan: three 32-bit numbers (rows, inputs, outputs), the value references of both, then for each row its time and inputs as doubles.
 * outputs: one row of doubles for each row of the plan, read when the step to it is done, the first after its inputs are set. */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#if defined(_WIN32)
#include <fcntl.h>
#include <io.h>
#include <windows.h>
static void *opened(const char *path) { return (void *)LoadLibraryA(path); }
static void *found(void *library, const char *name) { return (void *)GetProcAddress((HMODULE)library, name); }
static void prepare(void) { _setmode(0, _O_BINARY); _setmode(1, _O_BINARY); }
#else
#include <dlfcn.h>
static void *opened(const char *path) { return dlopen(path, RTLD_NOW); }
static void *found(void *library, const char *name) { return dlsym(library, name); }
static void prepare(void) {}
#endif

typedef struct { void *logger, *(*take)(size_t, size_t); void (*give)(void *); void *finished, *environment; } Callbacks;
typedef void *(*Begin2)(const char *, int, const char *, const char *, const Callbacks *, int, int);
typedef int (*Setup2)(void *, int, double, double, int, double);
typedef int (*Plain)(void *);
typedef int (*Values2)(void *, const uint32_t *, size_t, double *);
typedef int (*Step2)(void *, double, double, int);
typedef void *(*Begin3)(const char *, const char *, const char *, _Bool, _Bool, _Bool, _Bool, const uint32_t *, size_t, void *, void *, void *);
typedef int (*Initial3)(void *, _Bool, double, double, _Bool, double);
typedef int (*Values3)(void *, const uint32_t *, size_t, double *, size_t);
typedef int (*Step3)(void *, double, double, _Bool, _Bool *, _Bool *, _Bool *, double *);

static void *library;

static void *need(const char *name) {
    void *address = found(library, name);
    if (!address) { fprintf(stderr, "no %s\n", name); exit(3); }
    return address;
}

static void must(int status, const char *what) {
    if (status) { fprintf(stderr, "%s answers %d\n", what, status); exit(4); }
}

static void *read_some(size_t n, size_t size) {
    void *content = calloc(n + 1, size);
    if (!content || fread(content, size, n, stdin) != n) { fprintf(stderr, "the plan ends early\n"); exit(5); }
    return content;
}

static void *begin(int version, const char *guid) {
    static const Callbacks own = {NULL, calloc, free, NULL, NULL};
    void *c = version == 2 ? ((Begin2)need("fmi2Instantiate"))("model", 1, guid, "", &own, 0, 0)
                           : ((Begin3)need("fmi3InstantiateCoSimulation"))("model", guid, "", 0, 0, 0, 0, NULL, 0, NULL, NULL, NULL);
    if (!c) { fprintf(stderr, "no instance\n"); exit(6); }
    if (version == 2) {
        must(((Setup2)need("fmi2SetupExperiment"))(c, 0, 0, 0, 0, 0), "fmi2SetupExperiment");
        must(((Plain)need("fmi2EnterInitializationMode"))(c), "fmi2EnterInitializationMode");
        must(((Plain)need("fmi2ExitInitializationMode"))(c), "fmi2ExitInitializationMode");
    } else {
        must(((Initial3)need("fmi3EnterInitializationMode"))(c, 0, 0, 0, 0, 0), "fmi3EnterInitializationMode");
        must(((Plain)need("fmi3ExitInitializationMode"))(c), "fmi3ExitInitializationMode");
    }
    return c;
}

static void set_values(void *c, int version, const uint32_t *vr, uint32_t n, double *values) {
    if (version == 2) must(((Values2)need("fmi2SetReal"))(c, vr, n, values), "fmi2SetReal");
    else must(((Values3)need("fmi3SetFloat64"))(c, vr, n, values, n), "fmi3SetFloat64");
}

static void get_values(void *c, int version, const uint32_t *vr, uint32_t n, double *values) {
    if (version == 2) must(((Values2)need("fmi2GetReal"))(c, vr, n, values), "fmi2GetReal");
    else must(((Values3)need("fmi3GetFloat64"))(c, vr, n, values, n), "fmi3GetFloat64");
    fwrite(values, sizeof *values, n, stdout);
}

static void step(void *c, int version, double t, double dt) {
    _Bool flag[3];
    double reached;
    if (version == 2) must(((Step2)need("fmi2DoStep"))(c, t, dt, 1), "fmi2DoStep");
    else must(((Step3)need("fmi3DoStep"))(c, t, dt, 1, flag, flag + 1, flag + 2, &reached), "fmi3DoStep");
}

int main(int n, char **argument) {
    if (n != 4) return 2;
    prepare();
    library = opened(argument[1]);
    if (!library) { fprintf(stderr, "%s does not load\n", argument[1]); return 3; }
    const int version = atoi(argument[2]);
    const uint32_t *sizes = read_some(3, sizeof *sizes);
    const uint32_t *in = read_some(sizes[1], sizeof *in), *out = read_some(sizes[2], sizeof *out);
    const size_t width = sizes[1] + 1;
    double *rows = read_some(sizes[0] * width, sizeof *rows), *values = calloc(sizes[2] + 1, sizeof *values);
    void *c = begin(version, argument[3]);
    set_values(c, version, in, sizes[1], rows + 1);
    get_values(c, version, out, sizes[2], values);
    for (uint32_t k = 1; k < sizes[0]; k++) {
        double *row = rows + (k - 1) * width;
        set_values(c, version, in, sizes[1], row + 1);
        step(c, version, row[0], row[width] - row[0]);
        get_values(c, version, out, sizes[2], values);
    }
    return 0;
}
