/* A thin guard around pythonfmu's loader, which stands beside this binary: what pythonfmu lacks of FMI 2.0.
 *
 * The GUID is checked. A call during which the slave logged an error, and a step that it discarded, give fmi2Error, although
 * pythonfmu itself knows only success, discard and fatal. Errors reach the host's logger whether or not it asked for debug logging.
 * What is plain is answered from the slave's own arrays, at the speed of the compiled kernel. */

/* The slave's arrays and its kernel's functions: reals in range are set and read, and steps done, without Python. All that is not
 * plain (a value out of range, values to be checked or refused) goes through Python, which keeps the same arrays. */
enum { STALE, UNCHECKED, TANGENT, FAULTY };
typedef struct {
    unsigned size, stale_from;
    int ordered, *flag;
    double *v, *clock, *start; /* start: the values of a new slave; v is NULL where Python does everything */
    const double *lower, *upper;
    int (*step[2])(double *, double, double);
    int (*output[2])(double *, double);
} Direct;

typedef struct {
    fmi2Component inner;
    fmi2CallbackFunctions host, own;
    fmi2Status logged;
    fmi2Boolean logging;
    int begun;
    Direct direct;
} Guard;

/* Which function of the loader is which. */
enum { INSTANTIATE, FREE, SETUP, ENTER, EXIT, TERMINATE, RESET, GET_REAL, SET_REAL, GET_BOOLEAN, SET_BOOLEAN, GET_STATE, SET_STATE,
       FREE_STATE, STATE_SIZE, SERIALIZE, DESERIALIZE, DO_STEP, REAL_STATUS, COUNT };
static const char *const loader_name[COUNT] = {
    "fmi2Instantiate", "fmi2FreeInstance", "fmi2SetupExperiment", "fmi2EnterInitializationMode", "fmi2ExitInitializationMode",
    "fmi2Terminate", "fmi2Reset", "fmi2GetReal", "fmi2SetReal", "fmi2GetBoolean", "fmi2SetBoolean", "fmi2GetFMUstate",
    "fmi2SetFMUstate", "fmi2FreeFMUstate", "fmi2SerializedFMUstateSize", "fmi2SerializeFMUstate", "fmi2DeSerializeFMUstate",
    "fmi2DoStep", "fmi2GetRealStatus"};
static void *loader[COUNT];

#if defined(_WIN32)
extern void *bare_module;
__declspec(dllimport) unsigned long __stdcall GetModuleFileNameA(void *, char *, unsigned long);
__declspec(dllimport) void *__stdcall LoadLibraryA(const char *);
__declspec(dllimport) void *__stdcall GetProcAddress(void *, const char *);
static void own_path(char *path, size_t n) { GetModuleFileNameA(bare_module, path, (unsigned long)n); }
static void *opened(const char *path) { return LoadLibraryA(path); }
static void *found(void *library, const char *name) { return GetProcAddress(library, name); }
static void end_in_order(void *library) { (void)library; }
#define LOADER_FILE "pythonfmu-export.dll"
#else
typedef struct { const char *file; void *base; const char *name; void *address; } Place;
int dladdr(const void *, Place *);
void *dlopen(const char *, int);
void *dlsym(void *, const char *);
static void own_path(char *path, size_t n) {
    Place place = {0};
    if (!dladdr((const void *)loader_name, &place) || !place.file) return;
    for (size_t i = 0; i + 1 < n && place.file[i]; i++) path[i] = place.file[i];
}
static void *opened(const char *path) { return dlopen(path, 2 /* RTLD_NOW */); }
static void *found(void *library, const char *name) { return dlsym(library, name); }
/* At exit the loader uses its state once more after it has freed it. Told to let go of it before, it finds nothing there. */
int __cxa_atexit(void (*)(void *), void *, void *);
static void end_in_order(void *library) {
    void (*end)(void *) = dlsym(library, "finalizePythonInterpreter");
    if (end) __cxa_atexit(end, 0, 0);
}
#define LOADER_FILE "pythonfmu-export.so"
#endif

/* Find the loader's functions, once; NULL where all is well. */
static const char *load(void) {
    char path[4096] = {0};
    size_t end = 0;
    if (loader[DO_STEP]) return NULL;
    own_path(path, sizeof path - sizeof LOADER_FILE);
    for (size_t i = 0; path[i]; i++) if (path[i] == '/' || path[i] == '\\') end = i + 1;
    for (size_t i = 0; i < sizeof LOADER_FILE; i++) path[end + i] = LOADER_FILE[i];
    void *library = opened(path);
    if (!library) return "expected " LOADER_FILE " beside the binary, and libpython in the process (a Python host has it; else preload it)";
    for (int k = 0; k < COUNT; k++) if (!(loader[k] = found(library, loader_name[k]))) return "the loader lacks a function of FMI 2.0";
    end_in_order(library);
    return NULL;
}

static int same(const char *a, const char *b) {
    while (*a && *a == *b) { a++; b++; }
    return *a == *b;
}

static void listen(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category, fmi2String message, ...) {
    Guard *g = environment;
    if (status > g->logged) g->logged = status;
    if (g->host.logger && (g->logging || status >= fmi2Error))
        g->host.logger(g->host.componentEnvironment, name, status, category ? category : "logStatusError", message);
}

static fmi2Status settle(Guard *g, fmi2Status status) {
    if (status == fmi2Fatal) return fmi2Fatal;
    return status == fmi2Discard || status == fmi2Error || g->logged >= fmi2Error ? fmi2Error : status;
}

static void attach(Guard *g);

static fmi2Status unsupported(Guard *g, const char *text) {
    if (g->host.logger) g->host.logger(g->host.componentEnvironment, "", fmi2Error, "logStatusError", text);
    return fmi2Error;
}

FMI2 const char *fmi2GetTypesPlatform(void) { return "default"; }
FMI2 const char *fmi2GetVersion(void) { return "2.0"; }

FMI2 fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                                   const fmi2CallbackFunctions *call, fmi2Boolean visible, fmi2Boolean logging) {
    char folder[LONGEST_PATH];
    if (!call || !call->allocateMemory || !call->freeMemory) return NULL;
    const char *fault = !name || !*name ? "instance name: expected a text, got none"
                      : !guid || !same(guid, FMU_GUID) ? "guid: expected " FMU_GUID ", got that of another FMU"
                      : !resources ? "resource location: expected a URI, got none"
                      : type != 1 ? "type: expected co-simulation" : locate(resources, folder);
    if (!fault) fault = load();
    Guard *g = fault ? NULL : call->allocateMemory(1, sizeof *g);
    if (g) {
        g->host = g->own = *call;
        g->logging = logging;
        g->own.logger = listen;
        g->own.componentEnvironment = g;
        fmi2Component (*instantiate)(fmi2String, fmi2Type, fmi2String, fmi2String, const fmi2CallbackFunctions *, fmi2Boolean, fmi2Boolean);
        instantiate = loader[INSTANTIATE];
        g->inner = instantiate(name, type, guid, folder, &g->own, visible, fmi2True);
        if (g->inner) {
            attach(g);
            return g;
        }
        call->freeMemory(g);
    }
    if (fault && call->logger) call->logger(call->componentEnvironment, name ? name : "", fmi2Error, "logStatusError", fault);
    return NULL;
}

FMI2 void fmi2FreeInstance(fmi2Component c) {
    Guard *g = c;
    if (!g) return;
    ((void (*)(fmi2Component))loader[FREE])(g->inner);
    if (g->direct.start) g->host.freeMemory(g->direct.start);
    g->host.freeMemory(g);
}

FMI2 fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String categories[]) {
    (void)n; (void)categories;
    ((Guard *)c)->logging = on;
    return fmi2OK;
}

#define UNPACK(...) __VA_ARGS__
#define FORWARD(function, index, types, parameters, arguments)                                          \
    FMI2 fmi2Status function(fmi2Component c UNPACK parameters) {                                       \
        Guard *g = c;                                                                                   \
        g->logged = fmi2OK;                                                                             \
        return settle(g, ((fmi2Status (*)(fmi2Component UNPACK types))loader[index])(g->inner UNPACK arguments)); \
    }
#define VALUES(function, index, type, access)                                                          \
    FORWARD(function, index, (, const fmi2ValueReference *, size_t, access type *),                    \
            (, const fmi2ValueReference vr[], size_t n, access type value[]), (, vr, n, value))

FORWARD(fmi2SetupExperiment, SETUP, (, fmi2Boolean, fmi2Real, fmi2Real, fmi2Boolean, fmi2Real),
        (, fmi2Boolean tolerance_given, fmi2Real tolerance, fmi2Real start, fmi2Boolean stop_given, fmi2Real stop),
        (, tolerance_given, tolerance, start, stop_given, stop))
FORWARD(fmi2EnterInitializationMode, ENTER, (), (), ())
FORWARD(fmi2Terminate, TERMINATE, (), (), ())
VALUES(fmi2GetBoolean, GET_BOOLEAN, fmi2Boolean, )
VALUES(fmi2SetBoolean, SET_BOOLEAN, fmi2Boolean, const)
FORWARD(fmi2GetFMUstate, GET_STATE, (, fmi2FMUstate *), (, fmi2FMUstate *state), (, state))
FORWARD(fmi2FreeFMUstate, FREE_STATE, (, fmi2FMUstate *), (, fmi2FMUstate *state), (, state))
FORWARD(fmi2SerializedFMUstateSize, STATE_SIZE, (, fmi2FMUstate, size_t *), (, fmi2FMUstate state, size_t *size), (, state, size))
FORWARD(fmi2SerializeFMUstate, SERIALIZE, (, fmi2FMUstate, fmi2Byte *, size_t), (, fmi2FMUstate state, fmi2Byte bytes[], size_t size),
        (, state, bytes, size))
FORWARD(fmi2DeSerializeFMUstate, DESERIALIZE, (, const fmi2Byte *, size_t, fmi2FMUstate *),
        (, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state), (, bytes, size, state))
FORWARD(fmi2GetRealStatus, REAL_STATUS, (, fmi2StatusKind, fmi2Real *), (, fmi2StatusKind kind, fmi2Real *value), (, kind, value))

static fmi2Status through_python_get(Guard *g, const fmi2ValueReference vr[], size_t n, fmi2Real value[]) {
    g->logged = fmi2OK;
    return settle(g, ((fmi2Status (*)(fmi2Component, const fmi2ValueReference *, size_t, fmi2Real *))loader[GET_REAL])(g->inner, vr, n, value));
}

static fmi2Status through_python_set(Guard *g, const fmi2ValueReference vr[], size_t n, const fmi2Real value[]) {
    g->logged = fmi2OK;
    return settle(g, ((fmi2Status (*)(fmi2Component, const fmi2ValueReference *, size_t, const fmi2Real *))loader[SET_REAL])(g->inner, vr, n, value));
}

#define HANDOVER 0x68617074u
#define AT(value) ((void *)(size_t)(value))
/* Ask a new slave for its addresses. */
static void attach(Guard *g) {
    Direct *d = &g->direct;
    fmi2ValueReference vr[12];
    fmi2Real x[12] = {0};
    for (int i = 0; i < 12; i++) vr[i] = HANDOVER;
    d->v = NULL;
    if (through_python_get(g, vr, 12, x) > fmi2Warning || !x[0]) return;
    if (!d->start) d->start = g->host.allocateMemory((size_t)x[0], sizeof *d->start);
    if (!d->start) return;
    d->size = (unsigned)x[0];
    d->stale_from = (unsigned)x[1];
    d->ordered = x[2] != 0;
    d->flag = AT(x[4]);
    d->clock = AT(x[5]);
    d->lower = AT(x[6]);
    d->upper = AT(x[7]);
    d->step[0] = AT(x[8]);
    d->step[1] = AT(x[9]);
    d->output[0] = AT(x[10]);
    d->output[1] = AT(x[11]);
    d->v = AT(x[3]);
    for (unsigned i = 0; i < d->size; i++) d->start[i] = d->v[i];
}

FMI2 fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[]) {
    Guard *g = c;
    Direct *d = &g->direct;
    int plain = d->v != NULL;
    for (size_t i = 0; plain && i < n; i++) plain = vr[i] < d->size;
    if (!plain) return through_python_get(g, vr, n, value);
    if (d->flag[STALE]) {
        d->output[d->flag[TANGENT]](d->v, *d->clock);
        d->flag[STALE] = 0;
    }
    for (size_t i = 0; i < n; i++) value[i] = d->v[vr[i]];
    return fmi2OK;
}

FMI2 fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real value[]) {
    Guard *g = c;
    Direct *d = &g->direct;
    int plain = d->v && !d->flag[FAULTY];
    for (size_t i = 0; plain && i < n; i++) plain = vr[i] < d->size && d->lower[vr[i]] <= value[i] && value[i] <= d->upper[vr[i]];
    if (!plain) return through_python_set(g, vr, n, value);
    for (size_t i = 0; i < n; i++) {
        d->v[vr[i]] = value[i];
        if (vr[i] < d->stale_from) continue;
        d->flag[STALE] = 1;
        if (d->ordered) d->flag[UNCHECKED] = 1;
    }
    return fmi2OK;
}

FMI2 fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    Guard *g = c;
    g->logged = fmi2OK;
    fmi2Status status = settle(g, ((fmi2Status (*)(fmi2Component))loader[EXIT])(g->inner));
    if (status <= fmi2Warning) g->begun = 1;
    return status;
}

FMI2 fmi2Status fmi2Reset(fmi2Component c) {
    Guard *g = c;
    g->logged = fmi2OK;
    g->begun = 0;
    Direct *d = &g->direct;
    if (d->v && !d->flag[FAULTY]) {
        for (unsigned i = 0; i < d->size; i++) d->v[i] = d->start[i];
        d->flag[STALE] = d->flag[UNCHECKED] = 1;
        d->flag[TANGENT] = 0;
        *d->clock = 0;
        return fmi2OK;
    }
    fmi2Status status = settle(g, ((fmi2Status (*)(fmi2Component))loader[RESET])(g->inner));
    attach(g); /* the loader has made a new slave */
    return status;
}

FMI2 fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
    Guard *g = c;
    g->logged = fmi2OK;
    g->begun = 1;
    return settle(g, ((fmi2Status (*)(fmi2Component, fmi2FMUstate))loader[SET_STATE])(g->inner, state));
}

FMI2 fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real dt, fmi2Boolean no_set_state_before) {
    Guard *g = c;
    if (!g->begun) return unsupported(g, "fmi2DoStep: expected fmi2ExitInitializationMode before it");
    Direct *d = &g->direct;
    if (d->v && !d->flag[UNCHECKED] && dt > 0 && dt - dt == 0 && t - t == 0) {
        if (d->step[d->flag[TANGENT]](d->v, t, dt)) {
            *d->clock = t + dt;
            d->flag[STALE] = 0;
            return fmi2OK;
        } /* Python fails again, and says so */
    }
    g->logged = fmi2OK;
    return settle(g, ((fmi2Status (*)(fmi2Component, fmi2Real, fmi2Real, fmi2Boolean))loader[DO_STEP])(g->inner, t, dt, no_set_state_before));
}

#define NONE_OF(Kind, type, access)                                                                             \
    FMI2 fmi2Status fmi2##Kind(fmi2Component c, const fmi2ValueReference vr[], size_t n, access type value[]) { \
        (void)vr; (void)value;                                                                                  \
        return n ? unsupported(c, "fmi2" #Kind ": this FMU has no variable of that type") : fmi2OK;             \
    }
NONE_OF(GetInteger, fmi2Integer, )
NONE_OF(SetInteger, fmi2Integer, const)
NONE_OF(GetString, fmi2String, )
NONE_OF(SetString, fmi2String, const)

#define NOT_HERE(function, parameters)                                                       \
    FMI2 fmi2Status function(fmi2Component c UNPACK parameters) { return unsupported(c, #function ": not provided"); }
NOT_HERE(fmi2SetRealInputDerivatives, (, const fmi2ValueReference *vr, size_t n, const fmi2Integer *order, const fmi2Real *value))
NOT_HERE(fmi2GetRealOutputDerivatives, (, const fmi2ValueReference *vr, size_t n, const fmi2Integer *order, fmi2Real *value))
NOT_HERE(fmi2GetDirectionalDerivative, (, const fmi2ValueReference *unknown, size_t n, const fmi2ValueReference *known, size_t m,
                                        const fmi2Real *seed, fmi2Real *value))
NOT_HERE(fmi2CancelStep, ())
NOT_HERE(fmi2GetStatus, (, fmi2StatusKind kind, fmi2Status *value))
NOT_HERE(fmi2GetIntegerStatus, (, fmi2StatusKind kind, fmi2Integer *value))
NOT_HERE(fmi2GetBooleanStatus, (, fmi2StatusKind kind, fmi2Boolean *value))
NOT_HERE(fmi2GetStringStatus, (, fmi2StatusKind kind, fmi2String *value))
