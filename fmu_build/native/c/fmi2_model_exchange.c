/* Model exchange (FMI 2.0.4, section 3.2): right-hand side and outputs; the host integrates. There are no events. */

FMI2 fmi2Status fmi2EnterEventMode(fmi2Component c) { return allowed(c, "fmi2EnterEventMode", RUNNING) ? fmi2OK : fmi2Error; }

FMI2 fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *info) {
    (void)c;
    info->newDiscreteStatesNeeded = info->terminateSimulation = info->nominalsOfContinuousStatesChanged = fmi2False;
    info->valuesOfContinuousStatesChanged = info->nextEventTimeDefined = fmi2False;
    info->nextEventTime = 0;
    return fmi2OK;
}

FMI2 fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c) {
    Instance *s = c;
    return allowed(s, "fmi2EnterContinuousTimeMode", RUNNING) && consistent(s) ? fmi2OK : fmi2Error;
}

FMI2 fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean no_set_state_before, fmi2Boolean *event, fmi2Boolean *terminate) {
    (void)c; (void)no_set_state_before;
    *event = *terminate = fmi2False;
    return fmi2OK;
}

FMI2 fmi2Status fmi2SetTime(fmi2Component c, fmi2Real t) {
    Instance *s = c;
    if (!(t - t == 0)) return refuse_text(s, "fmi2SetTime", "expected a finite time");
    s->time = t;
    s->stale_outputs = s->stale_derivatives = 1;
    return fmi2OK;
}

FMI2 fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t n) {
    Instance *s = c;
    if (n != HK_NX) return refuse_text(s, "fmi2SetContinuousStates", "expected as many values as there are states");
    for (int i = 0; i < HK_NX; i++) {
        if (!(x[i] - x[i] == 0)) return refuse_text(s, fmu_name[HF_X + i], "expected a finite state");
        s->v[HF_X + i] = x[i];
    }
    s->stale_outputs = s->stale_derivatives = 1;
    return fmi2OK;
}

FMI2 fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real rates[], size_t n) {
    Instance *s = c;
    if (n != HK_NX) return refuse_text(s, "fmi2GetDerivatives", "expected as many values as there are states");
    refresh_derivatives(s);
    for (int i = 0; i < HK_NX; i++) rates[i] = s->v[HF_DX + i];
    return fmi2OK;
}

FMI2 fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real z[], size_t n) {
    (void)z;
    return n ? refuse_text(c, "fmi2GetEventIndicators", "there are none") : fmi2OK;
}

FMI2 fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t n) {
    Instance *s = c;
    if (n != HK_NX) return refuse_text(s, "fmi2GetContinuousStates", "expected as many values as there are states");
    for (int i = 0; i < HK_NX; i++) x[i] = s->v[HF_X + i];
    return fmi2OK;
}

FMI2 fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real x[], size_t n) {
    if (n != HK_NX) return refuse_text(c, "fmi2GetNominalsOfContinuousStates", "expected as many values as there are states");
    for (int i = 0; i < HK_NX; i++) x[i] = fmu_nominal[i];
    return fmi2OK;
}
