/* The kernel of a Python FMU: the buffer of a slave that pythonfmu's loader makes, stepped by the compiled library that the slave
 * has loaded; where it has none for this platform, by the slave itself. All of FMI is answered around it, in C. */

#define HANDOVER 0x68617074u /* value references under which the slave hands over addresses, and calculates */
#define OUTPUT_NOW (HANDOVER + 1)
#define PIVOT_NOW (HANDOVER + 2)
enum { ASKED_TIME, ASKED_TANGENT, PIVOT_JOINT, PIVOT_VALUE };

typedef struct {
    fmi2Component inner;
    fmi2CallbackFunctions own;
    double *asked; /* array of the slave for what it is asked and answers */
    int (*step[2])(double *, double, double);
    int (*output[2])(double *, double);
    int (*pivot)(double *, double, double *);
} Slave;

typedef fmi2Component (*Instantiate)(fmi2String, fmi2Type, fmi2String, fmi2String, const fmi2CallbackFunctions *, fmi2Boolean, fmi2Boolean);
typedef void (*Free)(fmi2Component);
typedef fmi2Status (*Get)(fmi2Component, const fmi2ValueReference *, size_t, fmi2Real *);
typedef fmi2Status (*Do)(fmi2Component, fmi2Real, fmi2Real, fmi2Boolean);

/* Which function of the loader is which. */
enum { INSTANTIATE, FREE, GET_REAL, DO_STEP, COUNT };
static const char *const loader_name[COUNT] = {"fmi2Instantiate", "fmi2FreeInstance", "fmi2GetReal", "fmi2DoStep"};
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
    if (loader[COUNT - 1]) return NULL;
    own_path(path, sizeof path - sizeof LOADER_FILE);
    for (size_t i = 0; path[i]; i++) if (path[i] == '/' || path[i] == '\\') end = i + 1;
    for (size_t i = 0; i < sizeof LOADER_FILE; i++) path[end + i] = LOADER_FILE[i];
    void *library = opened(path);
    if (!library) return "expected " LOADER_FILE " beside the binary, and libpython in the process (a Python host has it; else preload it)";
    for (int k = 0; k < COUNT; k++) if (!(loader[k] = found(library, loader_name[k]))) return "the loader lacks a function of FMI 2.0";
    end_in_order(library);
    return NULL;
}

/* Hand on what the loader has to say. */
static void listen(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category, fmi2String message, ...) {
    Instance *s = environment;
    (void)name; (void)category;
    if (s->logging || status >= fmi2Error) log_text(&s->call, s->name, status, "logStatusError", message);
}

static int ask(const Slave *slave, fmi2ValueReference what, size_t n, double *answer) {
    fmi2ValueReference vr[8];
    for (size_t i = 0; i < n; i++) vr[i] = what;
    return ((Get)loader[GET_REAL])(slave->inner, vr, n, answer) <= fmi2Warning;
}

#define AT(value) ((void *)(size_t)(value))
/* Ask a new slave for its addresses: whole numbers, exact as doubles. */
static const char *take_over(Instance *s, Slave *slave) {
    double x[8] = {0};
    if (!ask(slave, HANDOVER, 8, x) || x[0] != HF_END || !x[1] || !x[2]) return "expected a slave of this FMU, got another";
    s->v = AT(x[1]);
    slave->asked = AT(x[2]);
    slave->step[0] = AT(x[3]);
    slave->step[1] = AT(x[4]);
    slave->output[0] = AT(x[5]);
    slave->output[1] = AT(x[6]);
    slave->pivot = AT(x[7]);
    return NULL;
}

static const char *open_kernel(Instance *s, const char *resources) {
    char folder[LONGEST_PATH];
    const char *fault = !resources ? "resource location: expected a URI, got none" : locate(resources, folder);
    if (!fault) fault = load();
    if (fault) return fault;
    Slave *slave = s->slave = s->call.allocateMemory(1, sizeof *slave);
    if (!slave) return "expected memory from the host, got none";
    slave->own = s->call;
    slave->own.logger = listen;
    slave->own.componentEnvironment = s;
    slave->inner = ((Instantiate)loader[INSTANTIATE])(s->name, fmi2CoSimulation, FMU_GUID, folder, &slave->own, fmi2False, fmi2True);
    return slave->inner ? take_over(s, slave) : "expected a slave from pythonfmu's loader, got none";
}

static void close_kernel(Instance *s) {
    Slave *slave = s->slave;
    if (!slave) return;
    if (slave->inner) ((Free)loader[FREE])(slave->inner);
    s->call.freeMemory(slave);
}

static void put_question(Instance *s) {
    Slave *slave = s->slave;
    slave->asked[ASKED_TIME] = s->time;
    slave->asked[ASKED_TANGENT] = s->tangent;
}

static void kernel_output(Instance *s) {
    Slave *slave = s->slave;
    double done;
    if (slave->output[s->tangent]) { slave->output[s->tangent](s->v, s->time); return; }
    put_question(s);
    ask(slave, OUTPUT_NOW, 1, &done);
}

static int kernel_step(Instance *s, double t, double dt) {
    Slave *slave = s->slave;
    if (slave->step[s->tangent]) return slave->step[s->tangent](s->v, t, dt);
    put_question(s);
    return ((Do)loader[DO_STEP])(slave->inner, t, dt, fmi2True) <= fmi2Warning;
}

static int kernel_pivot(Instance *s, double *pivot) {
    Slave *slave = s->slave;
    double done;
    if (slave->pivot) return slave->pivot(s->v, s->time, pivot);
    put_question(s);
    if (!ask(slave, PIVOT_NOW, 1, &done)) return -1;
    *pivot = slave->asked[PIVOT_VALUE];
    return (int)slave->asked[PIVOT_JOINT];
}

static void kernel_rates(Instance *s) { (void)s; } /* a Python FMU shows no derivatives */
