/* Saving, restoring and serialising the state of an instance, and its exact partial derivatives (FMI 3.0.1, sections 2.2.10, 2.2.11). */

FMI3 fmi3Status fmi3GetFMUState(fmi3Instance instance, fmi3FMUState *state) {
    BEGIN(ANY);
    return (fmi3Status)fmi2GetFMUstate(w->core, state);
}

FMI3 fmi3Status fmi3SetFMUState(fmi3Instance instance, fmi3FMUState state) {
    BEGIN(ANY);
    return (fmi3Status)fmi2SetFMUstate(w->core, state);
}

FMI3 fmi3Status fmi3FreeFMUState(fmi3Instance instance, fmi3FMUState *state) {
    BEGIN(ANY);
    return (fmi3Status)fmi2FreeFMUstate(w->core, state);
}

FMI3 fmi3Status fmi3SerializedFMUStateSize(fmi3Instance instance, fmi3FMUState state, size_t *size) {
    BEGIN(ANY);
    return (fmi3Status)fmi2SerializedFMUstateSize(w->core, state, size);
}

FMI3 fmi3Status fmi3SerializeFMUState(fmi3Instance instance, fmi3FMUState state, fmi3Byte bytes[], size_t size) {
    BEGIN(ANY);
    return (fmi3Status)fmi2SerializeFMUstate(w->core, state, (fmi2Byte *)bytes, size);
}

FMI3 fmi3Status fmi3DeserializeFMUState(fmi3Instance instance, const fmi3Byte bytes[], size_t size, fmi3FMUState *state) {
    BEGIN(ANY);
    return (fmi3Status)fmi2DeSerializeFMUstate(w->core, (const fmi2Byte *)bytes, size, state);
}

FMI3 fmi3Status fmi3GetDirectionalDerivative(fmi3Instance instance, const fmi3ValueReference unknown[], size_t n,
                                             const fmi3ValueReference known[], size_t m, const fmi3Float64 seed[], size_t n_seed,
                                             fmi3Float64 value[], size_t n_value) {
    BEGIN(INITIALIZING | GOING | TERMINATED);
    if (n_seed != m || n_value != n) return complain(w, "expected one seed for each known and one value for each unknown");
    return (fmi3Status)fmi2GetDirectionalDerivative(w->core, unknown, n, known, m, seed, value);
}

#ifdef HK_NC
/* Jᵀ·seed with the exact Jacobian J of the unknowns along the knowns. */
FMI3 fmi3Status fmi3GetAdjointDerivative(fmi3Instance instance, const fmi3ValueReference unknown[], size_t n,
                                         const fmi3ValueReference known[], size_t m, const fmi3Float64 seed[], size_t n_seed,
                                         fmi3Float64 value[], size_t n_value) {
    BEGIN(INITIALIZING | GOING | TERMINATED);
    Jacobian J;
    if (n_seed != n || n_value != m) return complain(w, "expected one seed for each unknown and one value for each known");
    if (!given(w->core, __func__, n, unknown, seed) || !given(w->core, __func__, m, known, value)) return fmi3Error;
    if (!are_unknowns(unknown, n)) return complain(w, "expected outputs or state derivatives as unknowns");
    if (!are_knowns(known, m)) return complain(w, "expected inputs, states or parameters as knowns");
    linearise(w->core, &J);
    for (size_t k = 0; k < m; k++) {
        value[k] = 0;
        for (size_t i = 0; i < n; i++) value[k] += partial(&J, unknown[i], known[k]) * seed[i];
    }
    return fmi3OK;
}
#else
FMI3 fmi3Status fmi3GetAdjointDerivative(fmi3Instance instance, const fmi3ValueReference unknown[], size_t n,
                                         const fmi3ValueReference known[], size_t m, const fmi3Float64 seed[], size_t n_seed,
                                         fmi3Float64 value[], size_t n_value) {
    BEGIN(ANY);
    (void)unknown; (void)n; (void)known; (void)m; (void)seed; (void)n_seed; (void)value; (void)n_value;
    return complain(w, "this FMU does not provide it");
}
#endif
