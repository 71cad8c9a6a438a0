/* Life, modes and messages of an instance (FMI 3.0.1, section 2.3). The FMI 2.0 layer, private here, does the work; this checks the
 * modes of 3.0 before it. */

typedef struct {
    Instance *core;
    const char *function; /* that is being called */
    fmi3InstanceEnvironment environment;
    fmi3LogMessageCallback log;
    int logging;
} Wrapper;

static void tell(const Wrapper *w, fmi3Status status, const Message *m) {
    const char *category = status == fmi3Discard ? "logStatusDiscard" : "logStatusError";
    if (w->logging && w->log) w->log(w->environment, status, category, m->text);
}

/* Hand on a message of the FMI 2.0 layer; where it begins with a function's name, with that of the function called here. */
static void relay(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category, fmi2String text, ...) {
    const Wrapper *w = environment;
    Message m = {{0}, 0};
    (void)name; (void)category;
    if (text[0] == 'f' && text[1] == 'm' && text[2] == 'i' && text[3] == '2') {
        while (*text && *text != ':') text++;
        say(&m, w->function);
    }
    say(&m, text);
    tell(w, (fmi3Status)status, &m);
}

static fmi3Status complain(const Wrapper *w, const char *what) {
    Message m = {{0}, 0};
    say(&m, w->function);
    say(&m, ": ");
    say(&m, what);
    tell(w, fmi3Error, &m);
    return fmi3Error;
}

/* Whether the call may come in this mode. */
static int ready(Wrapper *w, const char *function, int modes) {
    if (!w) return 0;
    w->function = function;
    if (w->core->mode & modes) return 1;
    complain(w, "expected in another mode of the instance (see FMI 3.0.1, sections 2.3, 3.2 and 4.2)");
    return 0;
}

#define NO_PLACE "expected places for the results, got none"
#define BEGIN(modes)       \
    Wrapper *w = instance; \
    if (!ready(w, __func__, modes)) return fmi3Error

FMI3 const char *fmi3GetVersion(void) { return "3.0"; }

static fmi3Instance begin(const char *function, fmi2Type type, fmi3String name, fmi3String token, fmi3Boolean logging,
                          fmi3InstanceEnvironment environment, fmi3LogMessageCallback log) {
    Wrapper *w = take(1, sizeof *w);
    if (!w) return NULL;
    w->function = function;
    w->environment = environment;
    w->log = log;
    w->logging = logging;
    fmi2CallbackFunctions call = {relay, take, give, NULL, w};
    if (!token || !same(token, FMU_GUID)) complain(w, "expected the instantiation token " FMU_GUID ", got that of another FMU");
    else w->core = fmi2Instantiate(name, type, token, NULL, &call, fmi2False, logging);
    if (w->core) return w;
    give(w);
    return NULL;
}

FMI3 fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                               fmi3Boolean logging, fmi3InstanceEnvironment environment, fmi3LogMessageCallback log) {
    (void)resources; (void)visible;
    return begin(__func__, fmi2ModelExchange, name, token, logging, environment, log);
}

FMI3 fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                              fmi3Boolean logging, fmi3Boolean event_mode, fmi3Boolean early_return,
                                              const fmi3ValueReference intermediate[], size_t n_intermediate,
                                              fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                              fmi3IntermediateUpdateCallback update) {
    (void)resources; (void)visible; (void)early_return; (void)intermediate; (void)n_intermediate; (void)update;
    const Wrapper caller = {NULL, __func__, environment, log, logging};
    if (!event_mode) return begin(__func__, fmi2CoSimulation, name, token, logging, environment, log);
    complain(&caller, "expected eventModeUsed = false: hasEventMode is false, there are no events");
    return NULL;
}

FMI3 fmi3Instance fmi3InstantiateScheduledExecution(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                                    fmi3Boolean logging, fmi3InstanceEnvironment environment,
                                                    fmi3LogMessageCallback log, fmi3ClockUpdateCallback update,
                                                    fmi3LockPreemptionCallback lock, fmi3UnlockPreemptionCallback unlock) {
    (void)name; (void)token; (void)resources; (void)visible; (void)update; (void)lock; (void)unlock;
    const Wrapper caller = {NULL, __func__, environment, log, logging};
    complain(&caller, "this FMU is for co-simulation and model exchange");
    return NULL;
}

FMI3 void fmi3FreeInstance(fmi3Instance instance) {
    Wrapper *w = instance;
    if (!w) return;
    fmi2FreeInstance(w->core);
    give(w);
}

FMI3 fmi3Status fmi3SetDebugLogging(fmi3Instance instance, fmi3Boolean on, size_t n, const fmi3String categories[]) {
    BEGIN(ANY);
    if (fmi2SetDebugLogging(w->core, on, n, categories) != fmi2OK) return fmi3Error;
    w->logging = on;
    return fmi3OK;
}

FMI3 fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean tolerance_given, fmi3Float64 tolerance, fmi3Float64 start,
                                            fmi3Boolean stop_given, fmi3Float64 stop) {
    BEGIN(INSTANTIATED);
    if (fmi2SetupExperiment(w->core, tolerance_given, tolerance, start, stop_given, stop) != fmi2OK) return fmi3Error;
    return (fmi3Status)fmi2EnterInitializationMode(w->core);
}

FMI3 fmi3Status fmi3ExitInitializationMode(fmi3Instance instance) {
    BEGIN(INITIALIZING);
    return (fmi3Status)fmi2ExitInitializationMode(w->core);
}

FMI3 fmi3Status fmi3Terminate(fmi3Instance instance) {
    BEGIN(GOING);
    return (fmi3Status)fmi2Terminate(w->core);
}

FMI3 fmi3Status fmi3Reset(fmi3Instance instance) {
    BEGIN(ANY);
    return (fmi3Status)fmi2Reset(w->core);
}
