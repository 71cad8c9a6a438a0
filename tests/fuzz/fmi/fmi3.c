/* Calls of FMI 3.0: a call that is refused or discarded changes nothing, the mode included, and a step that succeeds leaves finite states. */

static void hear(fmi3InstanceEnvironment e, fmi3Status status, fmi3String category, fmi3String text) {
    (void)e; (void)status;
    if (!strlen(category) || !strlen(text)) abort();
}

static fmi3Boolean flag[5];

static fmi3Status one_step(fmi3Instance c, const Instance *s) {
    double reached = 0;
    const double dt = next_step();
    const double t = next() % 8 ? s->time : next_value(HF_END);
    const fmi3Status status = fmi3DoStep(c, t, dt, true, flag, flag + 1, flag + 2, SELDOM(NULL, &reached));
    if (status == fmi3OK) states_are_finite(s);
    if (status == fmi3OK && reached != s->time) abort();
    return status;
}

/* Derivatives: as many seeds and values as references, or not. */
static fmi3Status one_derivative(fmi3Instance c, int adjoint) {
    const size_t n = draw(), m = SELDOM(n ? n - 1 : 0, n);
    double seed[MANY];
    memcpy(seed, drawn.value, sizeof seed);
    if (adjoint) return fmi3GetAdjointDerivative(c, drawn.vr, n, drawn.vr, n, seed, n, SELDOM(NULL, drawn.value), m);
    return fmi3GetDirectionalDerivative(c, drawn.vr, n, drawn.vr, n, SELDOM(NULL, seed), m, drawn.value, n);
}

/* What is of a type that no variable has, or of clocks. */
static fmi3Status one_absent(fmi3Instance c) {
    fmi3String text[MANY] = {0};
    fmi3Binary binary[MANY] = {0};
    fmi3Float32 small[MANY] = {0};
    fmi3UInt64 large[MANY] = {0};
    size_t sizes[MANY] = {0}, count;
    fmi3IntervalQualifier qualifier[MANY];
    const size_t n = draw();
    switch (next() % 14) {
    case 0: return fmi3GetFloat32(c, drawn.vr, n, small, n);
    case 1: return fmi3SetInt32(c, drawn.vr, n, drawn.whole, n);
    case 2: return fmi3GetUInt64(c, drawn.vr, n, large, n);
    case 3: return fmi3GetString(c, drawn.vr, n, text, n);
    case 4: return fmi3SetBinary(c, drawn.vr, n, sizes, binary, n);
    case 5: return fmi3GetBinary(c, drawn.vr, n, sizes, binary, n);
    case 6: return fmi3SetClock(c, drawn.vr, n, flag);
    case 7: return fmi3GetIntervalDecimal(c, drawn.vr, n, drawn.value, qualifier);
    case 8: return fmi3SetShiftFraction(c, drawn.vr, n, large, large);
    case 9: return fmi3ActivateModelPartition(c, drawn.vr[0], drawn.value[0]);
    case 10: return fmi3EnterConfigurationMode(c);
    case 11: return fmi3EnterStepMode(c);
    case 12: return fmi3GetNumberOfVariableDependencies(c, drawn.vr[0], SELDOM(NULL, &count));
    default: return fmi3GetBoolean(c, drawn.vr, n, flag, n);
    }
}

static fmi3Status one_call(fmi3Instance c, const Instance *s, unsigned which) {
    fmi3String text = "logStatusError";
    size_t n, slot, size;
    switch (which) {
    case 0: return fmi3EnterInitializationMode(c, false, 0, next_value(HF_END), next() & 1, next_value(HF_END));
    case 1: return fmi3ExitInitializationMode(c);
    case 2: return next() % 8 ? fmi3OK : fmi3Terminate(c);
    case 3: return next() % 8 ? fmi3OK : fmi3Reset(c);
    case 4: n = draw(); return fmi3GetFloat64(c, SELDOM(NULL, drawn.vr), n, drawn.value, SELDOM(1, n));
    case 5: case 6: n = draw(); return fmi3SetFloat64(c, drawn.vr, n, SELDOM(NULL, drawn.value), SELDOM(1, n));
    case 7: return fmi3GetFMUState(c, SELDOM(NULL, &drawn.slots[next() % SLOTS]));
    case 8: return fmi3SetFMUState(c, drawn.slots[next() % SLOTS]);
    case 9: return fmi3FreeFMUState(c, SELDOM(NULL, &drawn.slots[next() % SLOTS]));
    case 10:
        slot = next() % SLOTS;
        size = sizeof drawn.bytes - next() % 16;
        return fmi3SerializeFMUState(c, drawn.slots[slot], drawn.bytes, size);
    case 11: flip_bits(); return fmi3OK;
    case 12:
        size = sizeof(Saved) - (next() % 8 == 0);
        return fmi3DeserializeFMUState(c, drawn.bytes, size, &drawn.slots[next() % SLOTS]);
    case 13: return fmi3SerializedFMUStateSize(c, drawn.slots[next() % SLOTS], SELDOM(NULL, &size));
    case 14: return one_derivative(c, 0);
    case 15: return one_derivative(c, 1);
    case 16: return fmi3EnterEventMode(c);
    case 17: return fmi3UpdateDiscreteStates(c, flag, flag + 1, flag + 2, flag + 3, flag + 4, SELDOM(NULL, drawn.value));
    case 18: return fmi3EnterContinuousTimeMode(c);
    case 19: return fmi3CompletedIntegratorStep(c, true, flag, SELDOM(NULL, flag + 1));
    case 20: return fmi3SetTime(c, next_value(HF_END));
    case 21: draw_states(); return fmi3SetContinuousStates(c, SELDOM(NULL, drawn.value), SELDOM(1, HK_NX));
    case 22: return fmi3GetContinuousStateDerivatives(c, drawn.value, SELDOM(1, HK_NX));
    case 23: return fmi3GetContinuousStates(c, drawn.value, SELDOM(1, HK_NX));
    case 24: return fmi3GetNominalsOfContinuousStates(c, drawn.value, SELDOM(1, HK_NX));
    case 25: return fmi3GetEventIndicators(c, drawn.value, SELDOM(1, 0));
    case 26: return fmi3GetNumberOfEventIndicators(c, SELDOM(NULL, &size));
    case 27: return fmi3GetNumberOfContinuousStates(c, SELDOM(NULL, &size));
    case 28: return fmi3EvaluateDiscreteStates(c);
    case 29: n = draw(); return fmi3GetOutputDerivatives(c, drawn.vr, n, drawn.whole, drawn.value, n);
    case 30: n = draw(); return fmi3SetDebugLogging(c, next() & 1, n ? 1 : 0, SELDOM(NULL, &text));
    case 31: return one_absent(c);
    default: return one_step(c, s);
    }
}

/* Scripts of scheduled execution and of event mode: instances that there are not. */
static fmi3Instance begin_any(void) {
    switch (next() % 16) {
    case 14: return fmi3InstantiateScheduledExecution("fuzzed", FMU_GUID, "", false, true, NULL, hear, NULL, NULL, NULL);
    case 15: return fmi3InstantiateCoSimulation("fuzzed", FMU_GUID, "", false, true, true, false, NULL, 0, NULL, hear, NULL);
    case 1: case 3: case 5: case 7: case 9: case 11: case 13:
        return fmi3InstantiateModelExchange("fuzzed", FMU_GUID, "", false, true, NULL, hear);
    default: return fmi3InstantiateCoSimulation("fuzzed", FMU_GUID, "", false, true, false, false, NULL, 0, NULL, hear, NULL);
    }
}

static void play(void) {
    fmi3Instance c = begin_any();
    if (!c && script[0] % 16 < 14) abort();
    while (c && place < script_length) {
        const Instance *s = ((Wrapper *)c)->core;
        const Seen before = look(s);
        const fmi3Status status = one_call(c, s, next() % 38);
        const Seen after = look(s);
        if (status != fmi3OK && status != fmi3Discard && status != fmi3Error) abort();
        if (status != fmi3OK && memcmp(&before, &after, sizeof before)) abort();
    }
    for (int k = 0; c && k < SLOTS; k++) fmi3FreeFMUState(c, &drawn.slots[k]);
    fmi3FreeInstance(c);
}
