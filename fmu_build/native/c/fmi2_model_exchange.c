/* Model exchange (FMI 2.0.4, section 3.2): right-hand side and outputs; the host integrates. There are no events. */

/* Whether the call may come, with one value for each of n states. */
static int states_given(Instance *s, const char *function, int modes, const double *x, size_t n, size_t wanted) {
    if (!allowed_for(s, function, fmi2ModelExchange, modes)) return 0;
    if (n == wanted) return given(s, function, n, x, x);
    refuse_text(s, function, wanted ? "expected as many values as there are states" : "there are none");
    return 0;
}

FMI2 fmi2Status fmi2EnterEventMode(fmi2Component c) {
    Instance *s = c;
    if (!allowed_for(s, "fmi2EnterEventMode", fmi2ModelExchange, IN_EVENT | IN_CONTINUOUS)) return fmi2Error;
    s->mode = IN_EVENT;
    return fmi2OK;
}

FMI2 fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *info) {
    if (!allowed_for(c, "fmi2NewDiscreteStates", fmi2ModelExchange, IN_EVENT)) return fmi2Error;
    if (!given(c, "fmi2NewDiscreteStates", 1, info, info)) return fmi2Error;
    info->newDiscreteStatesNeeded = info->terminateSimulation = info->nominalsOfContinuousStatesChanged = fmi2False;
    info->valuesOfContinuousStatesChanged = info->nextEventTimeDefined = fmi2False;
    info->nextEventTime = 0;
    return fmi2OK;
}

FMI2 fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c) {
    Instance *s = c;
    if (!allowed_for(s, "fmi2EnterContinuousTimeMode", fmi2ModelExchange, IN_EVENT) || !consistent(s)) return fmi2Error;
    s->mode = IN_CONTINUOUS;
    return fmi2OK;
}

FMI2 fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean no_set_state_before, fmi2Boolean *event, fmi2Boolean *terminate) {
    Instance *s = c;
    (void)no_set_state_before;
    if (!allowed_for(s, "fmi2CompletedIntegratorStep", fmi2ModelExchange, IN_CONTINUOUS)) return fmi2Error;
    if (!given(s, "fmi2CompletedIntegratorStep", 1, event, terminate)) return fmi2Error;
    /* Integrators look past the stop time and interpolate back; a step must not end there. */
    if (!within_experiment(s, "fmi2CompletedIntegratorStep", s->time, 0)) return fmi2Error;
    *event = *terminate = fmi2False;
    return fmi2OK;
}

FMI2 fmi2Status fmi2SetTime(fmi2Component c, fmi2Real t) {
    Instance *s = c;
    if (!allowed_for(s, "fmi2SetTime", fmi2ModelExchange, IN_EVENT | IN_CONTINUOUS)) return fmi2Error;
    if (!is_finite(t)) return refuse_text(s, "fmi2SetTime", "expected a finite time");
    s->time = t;
    s->stale_outputs = s->stale_derivatives = 1;
    return fmi2OK;
}

/* Take the states where all are finite. */
static fmi2Status take_states(Instance *s, const double *x) {
    for (int i = 0; i < HK_NX; i++)
        if (!is_finite(x[i])) return refuse_text(s, fmu_name[HF_X + i], "expected a finite state");
    for (int i = 0; i < HK_NX; i++) s->v[HF_X + i] = x[i];
    s->stale_outputs = s->stale_derivatives = 1;
    return fmi2OK;
}

FMI2 fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t n) {
    return states_given(c, "fmi2SetContinuousStates", IN_CONTINUOUS, x, n, HK_NX) ? take_states(c, x) : fmi2Error;
}

/* Calculate the right-hand side; what makes it leave the finite numbers may be put right by a shorter step of the host. */
static fmi2Status give_rates(Instance *s, double *rates) {
    Message m = {{0}, 0};
    refresh_derivatives(s);
    for (int i = 0; i < HK_NX; i++) rates[i] = s->v[HF_DX + i];
    for (int i = 0; i < HK_NX; i++) {
        if (is_finite(rates[i])) continue;
        if (definite(s, &m)) { say(&m, fmu_name[HF_DX + i]); say(&m, ": expected a finite value, got "); say_number(&m, rates[i]); }
        return tell_host(s, fmi2Discard, &m);
    }
    return fmi2OK;
}

FMI2 fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real rates[], size_t n) {
    const int modes = IN_EVENT | IN_CONTINUOUS | TERMINATED;
    return states_given(c, "fmi2GetDerivatives", modes, rates, n, HK_NX) ? give_rates(c, rates) : fmi2Error;
}

FMI2 fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real z[], size_t n) {
    const int modes = INITIALIZING | IN_EVENT | IN_CONTINUOUS | TERMINATED;
    return states_given(c, "fmi2GetEventIndicators", modes, z, n, 0) ? fmi2OK : fmi2Error;
}

FMI2 fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t n) {
    Instance *s = c;
    const int modes = INITIALIZING | IN_EVENT | IN_CONTINUOUS | TERMINATED;
    if (!states_given(s, "fmi2GetContinuousStates", modes, x, n, HK_NX)) return fmi2Error;
    for (int i = 0; i < HK_NX; i++) x[i] = s->v[HF_X + i];
    return fmi2OK;
}

FMI2 fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real x[], size_t n) {
    const int modes = INSTANTIATED | IN_EVENT | IN_CONTINUOUS | TERMINATED;
    if (!states_given(c, "fmi2GetNominalsOfContinuousStates", modes, x, n, HK_NX)) return fmi2Error;
    for (int i = 0; i < HK_NX; i++) x[i] = fmu_nominal[i];
    return fmi2OK;
}
