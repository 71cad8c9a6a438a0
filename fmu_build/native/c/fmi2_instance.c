/* Life of an instance (FMI 2.0.4, section 2.1.6). */

static void restart(Instance *s) {
    for (int i = 0; i < HF_END; i++) s->v[i] = fmu_start[i];
    s->time = 0;
    s->tangent = s->set_up = s->stop_given = 0;
    s->mode = INSTANTIATED;
    s->unchecked = s->stale_outputs = s->stale_derivatives = 1;
}

FMI2 const char *fmi2GetTypesPlatform(void) { return "default"; }
FMI2 const char *fmi2GetVersion(void) { return "2.0"; }

FMI2 void fmi2FreeInstance(fmi2Component c) {
    Instance *s = c;
    if (!s) return;
    close_kernel(s);
    s->call.freeMemory(s);
}

/* What is wrong with the arguments of an instantiation; NULL where nothing is. */
static const char *instantiation_fault(fmi2String name, fmi2Type type, fmi2String guid) {
    if (!name || !*name) return "instance name: expected a text, got none";
    if (!guid || !same(guid, FMU_GUID)) return "guid: expected " FMU_GUID ", got that of another FMU";
    if (type == fmi2CoSimulation || (type == fmi2ModelExchange && FMU_EXCHANGE)) return NULL;
    return FMU_EXCHANGE ? "type: expected co-simulation or model exchange" : "type: expected co-simulation";
}

FMI2 fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                                   const fmi2CallbackFunctions *call, fmi2Boolean visible, fmi2Boolean logging) {
    (void)visible;
    if (!call || !call->allocateMemory || !call->freeMemory) return NULL;
    const char *fault = instantiation_fault(name, type, guid);
    Instance *s = fault ? NULL : call->allocateMemory(1, sizeof *s);
    if (!s) {
        if (!fault) fault = "expected memory from the host, got none";
        log_text(call, name ? name : "", fmi2Error, "logStatusError", fault);
        return NULL;
    }
    s->call = *call;
    s->type = type;
    s->logging = logging;
    for (size_t i = 0; i + 1 < sizeof s->name && name[i]; i++) s->name[i] = name[i];
    fault = open_kernel(s, resources);
    if (!fault) {
        restart(s);
        return s;
    }
    log_text(call, name, fmi2Error, "logStatusError", fault);
    fmi2FreeInstance(s);
    return NULL;
}

FMI2 fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String categories[]) {
    Instance *s = c;
    if (!allowed(s, "fmi2SetDebugLogging", ANY) || !given(s, "fmi2SetDebugLogging", n, categories, categories)) return fmi2Error;
    for (size_t i = 0; i < n; i++)
        if (!categories[i] || (!same(categories[i], "logStatusError") && !same(categories[i], "logStatusDiscard")))
            return refuse_text(s, "fmi2SetDebugLogging", "expected the categories logStatusError and logStatusDiscard alone");
    s->logging = on;
    return fmi2OK;
}

FMI2 fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean tolerance_given, fmi2Real tolerance, fmi2Real start,
                                    fmi2Boolean stop_given, fmi2Real stop) {
    Instance *s = c;
    (void)tolerance_given; (void)tolerance;
    if (!allowed(s, "fmi2SetupExperiment", INSTANTIATED)) return fmi2Error;
    if (!is_finite(start) || (stop_given && !(stop >= start)))
        return refuse_text(s, "fmi2SetupExperiment", "expected a finite start time and a stop time not before it");
    s->time = start;
    s->set_up = 1;
    s->stop_given = stop_given != fmi2False;
    s->stop = stop;
    return fmi2OK;
}

FMI2 fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    Instance *s = c;
    if (!allowed(s, "fmi2EnterInitializationMode", INSTANTIATED)) return fmi2Error;
    if (!s->set_up) return refuse_text(s, "fmi2EnterInitializationMode", "expected fmi2SetupExperiment before, which defines the start time");
    s->mode = INITIALIZING;
    return fmi2OK;
}

FMI2 fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    Instance *s = c;
    if (!allowed(s, "fmi2ExitInitializationMode", INITIALIZING) || !consistent(s)) return fmi2Error;
    s->mode = s->type == fmi2CoSimulation ? IN_STEP : IN_EVENT;
    return fmi2OK;
}

FMI2 fmi2Status fmi2Terminate(fmi2Component c) {
    Instance *s = c;
    if (!allowed(s, "fmi2Terminate", GOING | STEP_FAILED)) return fmi2Error;
    s->mode = TERMINATED;
    return fmi2OK;
}

FMI2 fmi2Status fmi2Reset(fmi2Component c) {
    Instance *s = c;
    if (!allowed(s, "fmi2Reset", ANY)) return fmi2Error;
    restart(s);
    return fmi2OK;
}

/* Slack between times of the host and of the instance: hosts add up steps or multiply them, and round. */
static double slack(double t, double dt) { return 1e-6 * dt + 1e-9 * (t < 0 ? -t : t); }

APART static int refuse_time(Instance *s, const char *function, double t) {
    Message m = {{0}, 0};
    say(&m, function);
    say(&m, ": expected a time up to the stop time "); say_number(&m, s->stop);
    say(&m, " s, got "); say_number(&m, t); say(&m, " s");
    refuse(s, &m);
    return 0;
}

/* Whether the time lies within the experiment that the host has set up. */
static inline int within_experiment(Instance *s, const char *function, double t, double dt) {
    return !s->stop_given || t <= s->stop + slack(s->stop, dt) || refuse_time(s, function, t);
}
