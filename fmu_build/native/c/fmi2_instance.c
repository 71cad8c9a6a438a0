/* Life, values and messages of an instance (FMI 2.0.4, sections 2.1 and 2.2). The generated tables stand before this text:
 * FMU_GUID, FMU_REALS, fmu_name[], fmu_role[], fmu_min[], fmu_max[], fmu_start[], fmu_orders, fmu_order[][2], FMU_SWITCH. */

enum { HIDDEN, INPUT, STATE, PARAMETER, OUTPUT, DERIVATIVE, SLOPE, SENSITIVITY, STEP };
enum { INSTANTIATED = 1, INITIALIZING = 2, RUNNING = 4, TERMINATED = 8 };

typedef struct {
    double v[HF_END + 1]; /* all that a run needs to go on stands in these five */
    double time;
    int tangent, mode, unchecked;
    int stale_outputs, stale_derivatives; /* all that follows can be had from the above, or does not change */
    fmi2Type type;
    fmi2Boolean logging;
    fmi2CallbackFunctions call;
    char name[128];
} Instance;

static fmi2Status refuse(Instance *s, const Message *m) {
    if (s->call.logger) s->call.logger(s->call.componentEnvironment, s->name, fmi2Error, "logStatusError", m->text);
    return fmi2Error;
}

static fmi2Status refuse_text(Instance *s, const char *where, const char *what) {
    Message m = {{0}, 0};
    say(&m, where);
    say(&m, ": ");
    say(&m, what);
    return refuse(s, &m);
}

/* Whether the call may come in this mode. */
static int allowed(Instance *s, const char *function, int modes) {
    if (s->mode & modes) return 1;
    refuse_text(s, function, "expected in another mode of the instance (see FMI 2.0.4, sections 3.2.3 and 4.2.4)");
    return 0;
}

static int same(const char *a, const char *b) {
    while (*a && *a == *b) { a++; b++; }
    return *a == *b;
}

static void restart(Instance *s) {
    for (int i = 0; i < HF_END; i++) s->v[i] = fmu_start[i];
    s->time = 0;
    s->tangent = 0;
    s->mode = INSTANTIATED;
    s->unchecked = s->stale_outputs = s->stale_derivatives = 1;
}

/* Whether the values make sense together. */
static int consistent(Instance *s) {
    if (!s->unchecked) return 1;
    for (int k = 0; k < fmu_orders; k++) {
        unsigned a = fmu_order[k][0], b = fmu_order[k][1];
        if (s->v[a] >= s->v[b]) continue;
        Message m = {{0}, 0};
        say(&m, fmu_name[a]); say(&m, " = "); say_number(&m, s->v[a]);
        say(&m, ": expected at least "); say(&m, fmu_name[b]); say(&m, " = "); say_number(&m, s->v[b]);
        refuse(s, &m);
        return 0;
    }
    s->unchecked = 0;
    return 1;
}

static void refresh_outputs(Instance *s) {
    if (!s->stale_outputs) return;
#ifdef HK_NC
    if (s->tangent) hf_output_tangent(s->v, s->time); else
#endif
    hf_output(s->v, s->time);
    s->stale_outputs = 0;
}

static void refresh_derivatives(Instance *s) {
    if (!s->stale_derivatives) return;
    hk_derivatives(s->time, s->v + HF_X, s->v + HF_U, s->v + HF_P, s->v + HF_DX);
    s->stale_derivatives = 0;
}

FMI2 const char *fmi2GetTypesPlatform(void) { return "default"; }
FMI2 const char *fmi2GetVersion(void) { return "2.0"; }

FMI2 fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                                   const fmi2CallbackFunctions *call, fmi2Boolean visible, fmi2Boolean logging) {
    (void)resources; (void)visible;
    if (!call || !call->allocateMemory || !call->freeMemory) return NULL;
    const char *fault = !name || !*name ? "instance name: expected a text, got none"
                      : !guid || !same(guid, FMU_GUID) ? "guid: expected " FMU_GUID ", got that of another FMU" : NULL;
    if (fault) {
        if (call->logger) call->logger(call->componentEnvironment, name ? name : "", fmi2Error, "logStatusError", fault);
        return NULL;
    }
    Instance *s = call->allocateMemory(1, sizeof *s);
    if (!s) return NULL;
    s->call = *call;
    s->type = type;
    s->logging = logging;
    for (size_t i = 0; i + 1 < sizeof s->name && name[i]; i++) s->name[i] = name[i];
    restart(s);
    return s;
}

FMI2 void fmi2FreeInstance(fmi2Component c) {
    Instance *s = c;
    if (s) s->call.freeMemory(s);
}

FMI2 fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String categories[]) {
    (void)n; (void)categories;
    ((Instance *)c)->logging = on;
    return fmi2OK;
}

FMI2 fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean tolerance_given, fmi2Real tolerance, fmi2Real start,
                                    fmi2Boolean stop_given, fmi2Real stop) {
    Instance *s = c;
    (void)tolerance_given; (void)tolerance;
    if (!allowed(s, "fmi2SetupExperiment", INSTANTIATED)) return fmi2Error;
    if (!(start - start == 0) || (stop_given && !(stop >= start)))
        return refuse_text(s, "fmi2SetupExperiment", "expected a finite start time and a stop time not before it");
    s->time = start;
    return fmi2OK;
}

FMI2 fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    if (!allowed(c, "fmi2EnterInitializationMode", INSTANTIATED)) return fmi2Error;
    ((Instance *)c)->mode = INITIALIZING;
    return fmi2OK;
}

FMI2 fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    Instance *s = c;
    if (!allowed(s, "fmi2ExitInitializationMode", INITIALIZING) || !consistent(s)) return fmi2Error;
    s->mode = RUNNING;
    return fmi2OK;
}

FMI2 fmi2Status fmi2Terminate(fmi2Component c) {
    ((Instance *)c)->mode = TERMINATED;
    return fmi2OK;
}

FMI2 fmi2Status fmi2Reset(fmi2Component c) {
    restart(c);
    return fmi2OK;
}

FMI2 fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[]) {
    Instance *s = c;
    for (size_t i = 0; i < n; i++) {
        if (vr[i] >= HF_END || fmu_role[vr[i]] == HIDDEN) return refuse_text(s, "fmi2GetReal", "unknown value reference");
        if (fmu_role[vr[i]] == OUTPUT || fmu_role[vr[i]] == SENSITIVITY) refresh_outputs(s);
        if (fmu_role[vr[i]] == DERIVATIVE) refresh_derivatives(s);
        value[i] = s->v[vr[i]];
    }
    return fmi2OK;
}

static fmi2Status out_of_range(Instance *s, fmi2ValueReference vr, double value) {
    Message m = {{0}, 0};
    if (vr >= HF_END || fmu_role[vr] == HIDDEN) return refuse_text(s, "fmi2SetReal", "unknown value reference");
    say(&m, fmu_name[vr]);
    if (fmu_min[vr] > fmu_max[vr]) { say(&m, ": expected not to be set, it is calculated"); return refuse(s, &m); }
    say(&m, ": expected between "); say_number(&m, fmu_min[vr]); say(&m, " and "); say_number(&m, fmu_max[vr]);
    say(&m, ", got "); say_number(&m, value);
    return refuse(s, &m);
}

FMI2 fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real value[]) {
    Instance *s = c;
    fmi2Status status = fmi2OK;
    const unsigned first_felt = FMU_STALE_FROM; /* references before it are inputs that no output uses */
    for (size_t i = 0; i < n; i++) {
        if (vr[i] >= HF_END || !(fmu_min[vr[i]] <= value[i] && value[i] <= fmu_max[vr[i]])) {
            status = out_of_range(s, vr[i], value[i]);
            continue;
        }
        s->v[vr[i]] = value[i];
        s->stale_derivatives = 1;
        if (vr[i] >= first_felt) s->stale_outputs = 1;
        if (fmu_role[vr[i]] == PARAMETER) s->unchecked = 1;
    }
    return status;
}

FMI2 fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Boolean value[]) {
    Instance *s = c;
    for (size_t i = 0; i < n; i++) {
        if (!FMU_SWITCH || vr[i] != HF_END) return refuse_text(s, "fmi2GetBoolean", "unknown value reference");
        value[i] = s->tangent;
    }
    return fmi2OK;
}

FMI2 fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Boolean value[]) {
    Instance *s = c;
    for (size_t i = 0; i < n; i++) {
        if (!FMU_SWITCH || vr[i] != HF_END) return refuse_text(s, "fmi2SetBoolean", "unknown value reference");
        s->tangent = value[i] != fmi2False;
        s->stale_outputs = 1;
    }
    return fmi2OK;
}

#define NONE_OF(Kind, type, access)                                                                                     \
    FMI2 fmi2Status fmi2##Kind(fmi2Component c, const fmi2ValueReference vr[], size_t n, access type value[]) {         \
        (void)vr; (void)value;                                                                                          \
        return n ? refuse_text(c, "fmi2" #Kind, "this FMU has no variable of that type") : fmi2OK;                     \
    }
NONE_OF(GetInteger, fmi2Integer, )
NONE_OF(SetInteger, fmi2Integer, const)
NONE_OF(GetString, fmi2String, )
NONE_OF(SetString, fmi2String, const)
