/* Model exchange (FMI 3.0.1, section 3): right-hand side and outputs; the host integrates. There are no events. */

/* Whether it is an instance for model exchange, in one of these modes. */
#define BEGIN_EXCHANGE(modes)                                  \
    BEGIN(modes);                                              \
    if (w->core->type != fmi2ModelExchange) return complain(w, "expected an instance for model exchange")

enum { EVALUATED = INITIALIZING | IN_EVENT | IN_CONTINUOUS | TERMINATED };

FMI3 fmi3Status fmi3EnterEventMode(fmi3Instance instance) {
    BEGIN_EXCHANGE(IN_CONTINUOUS);
    w->core->mode = IN_EVENT;
    return fmi3OK;
}

REFUSED(fmi3EvaluateDiscreteStates, (fmi3Instance instance), (void)0, "this FMU does not provide it (providesEvaluateDiscreteStates is false)")

FMI3 fmi3Status fmi3UpdateDiscreteStates(fmi3Instance instance, fmi3Boolean *again, fmi3Boolean *terminate, fmi3Boolean *nominals_changed,
                                         fmi3Boolean *values_changed, fmi3Boolean *next_defined, fmi3Float64 *next) {
    BEGIN_EXCHANGE(IN_EVENT);
    if (!again || !terminate || !nominals_changed || !values_changed || !next_defined || !next) return complain(w, NO_PLACE);
    *again = *terminate = *nominals_changed = *values_changed = *next_defined = false;
    *next = 0;
    return fmi3OK;
}

FMI3 fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance instance) {
    BEGIN_EXCHANGE(IN_EVENT);
    return (fmi3Status)fmi2EnterContinuousTimeMode(w->core);
}

FMI3 fmi3Status fmi3CompletedIntegratorStep(fmi3Instance instance, fmi3Boolean no_set_state_before, fmi3Boolean *event,
                                            fmi3Boolean *terminate) {
    BEGIN_EXCHANGE(IN_CONTINUOUS);
    (void)no_set_state_before;
    if (!event || !terminate) return complain(w, NO_PLACE);
    if (!within_experiment(w->core, "fmi2CompletedIntegratorStep", w->core->time, 0)) return fmi3Error;
    *event = *terminate = false;
    return fmi3OK;
}

FMI3 fmi3Status fmi3SetTime(fmi3Instance instance, fmi3Float64 t) {
    BEGIN_EXCHANGE(IN_EVENT | IN_CONTINUOUS);
    return (fmi3Status)fmi2SetTime(w->core, t);
}

FMI3 fmi3Status fmi3SetContinuousStates(fmi3Instance instance, const fmi3Float64 x[], size_t n) {
    BEGIN_EXCHANGE(IN_CONTINUOUS);
    if (n != HK_NX || !x) return complain(w, "expected as many values as there are states");
    return (fmi3Status)take_states(w->core, x);
}

FMI3 fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance instance, fmi3Float64 rates[], size_t n) {
    BEGIN_EXCHANGE(EVALUATED);
    if (n != HK_NX || !rates) return complain(w, "expected as many values as there are states");
    return (fmi3Status)give_rates(w->core, rates);
}

FMI3 fmi3Status fmi3GetEventIndicators(fmi3Instance instance, fmi3Float64 z[], size_t n) {
    BEGIN_EXCHANGE(EVALUATED);
    return (fmi3Status)fmi2GetEventIndicators(w->core, z, n);
}

FMI3 fmi3Status fmi3GetContinuousStates(fmi3Instance instance, fmi3Float64 x[], size_t n) {
    BEGIN_EXCHANGE(EVALUATED);
    return (fmi3Status)fmi2GetContinuousStates(w->core, x, n);
}

FMI3 fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance instance, fmi3Float64 x[], size_t n) {
    BEGIN_EXCHANGE(EVALUATED);
    if (n != HK_NX || !x) return complain(w, "expected as many values as there are states");
    for (int i = 0; i < HK_NX; i++) x[i] = fmu_nominal[i];
    return fmi3OK;
}

FMI3 fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance instance, size_t *n) {
    BEGIN_EXCHANGE(ANY);
    if (!n) return complain(w, NO_PLACE);
    *n = 0;
    return fmi3OK;
}

FMI3 fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance instance, size_t *n) {
    BEGIN_EXCHANGE(ANY);
    if (!n) return complain(w, NO_PLACE);
    *n = HK_NX;
    return fmi3OK;
}
