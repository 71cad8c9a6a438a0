/* Calls of FMI 2.0: a call that is refused changes nothing, and a step that succeeds leaves finite states. */

static void hear(fmi2ComponentEnvironment e, fmi2String name, fmi2Status status, fmi2String category, fmi2String text, ...) {
    (void)e; (void)status;
    if (!strlen(name) || !strlen(category) || !strlen(text)) abort();
}

static fmi2Status one_step(Instance *s) {
    const double dt = next_step();
    const fmi2Status status = fmi2DoStep(s, next() % 8 ? s->time : next_value(HF_END), dt, 1);
    if (status == fmi2OK) states_are_finite(s);
    return status;
}

static fmi2Status one_call(Instance *s, unsigned which) {
    fmi2EventInfo info;
    fmi2Status pending;
    fmi2String text = "logStatusError";
    size_t n, slot, size;
    switch (which) {
    case 0: return fmi2SetupExperiment(s, 0, 0, next_value(HF_END), next() & 1, next_value(HF_END));
    case 1: return fmi2EnterInitializationMode(s);
    case 2: return fmi2ExitInitializationMode(s);
    case 3: return next() % 8 ? fmi2OK : fmi2Terminate(s);
    case 4: return next() % 8 ? fmi2OK : fmi2Reset(s);
    case 5: n = draw(); return fmi2GetReal(s, SELDOM(NULL, drawn.vr), n, drawn.value);
    case 6: case 7: n = draw(); return fmi2SetReal(s, drawn.vr, n, SELDOM(NULL, drawn.value));
    case 8: n = draw(); return fmi2GetBoolean(s, drawn.vr, n, drawn.whole);
    case 9: n = draw(); return fmi2SetBoolean(s, drawn.vr, n, drawn.whole);
    case 10: n = draw(); return fmi2SetRealInputDerivatives(s, drawn.vr, n, drawn.whole, drawn.value);
    case 11: return fmi2GetFMUstate(s, SELDOM(NULL, &drawn.slots[next() % SLOTS]));
    case 12: return fmi2SetFMUstate(s, drawn.slots[next() % SLOTS]);
    case 13: return fmi2FreeFMUstate(s, SELDOM(NULL, &drawn.slots[next() % SLOTS]));
    case 14:
        slot = next() % SLOTS;
        size = sizeof drawn.bytes - next() % 16;
        return fmi2SerializeFMUstate(s, drawn.slots[slot], (fmi2Byte *)drawn.bytes, size);
    case 15: flip_bits(); return fmi2OK;
    case 16:
        size = sizeof(Saved) - (next() % 8 == 0);
        return fmi2DeSerializeFMUstate(s, (fmi2Byte *)drawn.bytes, size, &drawn.slots[next() % SLOTS]);
    case 17: n = draw(); return fmi2GetDirectionalDerivative(s, drawn.vr, n, drawn.vr, n, drawn.value, drawn.value);
    case 18: return fmi2EnterEventMode(s);
    case 19: return fmi2NewDiscreteStates(s, SELDOM(NULL, &info));
    case 20: return fmi2EnterContinuousTimeMode(s);
    case 21: return fmi2CompletedIntegratorStep(s, 1, drawn.whole, SELDOM(NULL, drawn.whole + 1));
    case 22: return fmi2SetTime(s, next_value(HF_END));
    case 23: draw_states(); return fmi2SetContinuousStates(s, drawn.value, SELDOM(1, HK_NX));
    case 24: return fmi2GetDerivatives(s, drawn.value, SELDOM(1, HK_NX));
    case 25: return fmi2GetContinuousStates(s, drawn.value, HK_NX);
    case 26: return fmi2GetNominalsOfContinuousStates(s, drawn.value, HK_NX);
    case 27: return fmi2GetRealStatus(s, (fmi2StatusKind)(next() % 4), SELDOM(NULL, drawn.value));
    case 28: return fmi2GetStringStatus(s, (fmi2StatusKind)(next() % 4), &text);
    case 29: n = draw(); return fmi2SetInteger(s, drawn.vr, n, drawn.whole);
    case 30: n = draw(); return fmi2GetRealOutputDerivatives(s, drawn.vr, n, drawn.whole, drawn.value);
    case 31: n = draw(); return fmi2SetDebugLogging(s, (fmi2Boolean)(next() & 1), n ? 1 : 0, SELDOM(NULL, &text));
    case 32: return fmi2GetStatus(s, (fmi2StatusKind)(next() % 4), SELDOM(NULL, &pending));
    case 33: return fmi2GetEventIndicators(s, drawn.value, SELDOM(1, 0));
    case 34: return fmi2SerializedFMUstateSize(s, drawn.slots[next() % SLOTS], SELDOM(NULL, &size));
    default: return one_step(s);
    }
}

static void play(void) {
    const fmi2CallbackFunctions call = {hear, give_memory, take_memory, NULL, NULL};
    fmi2Component c = fmi2Instantiate("fuzzed", (fmi2Type)(next() & 1), FMU_GUID, "", &call, 0, 1);
    if (!c) abort();
    while (place < script_length) {
        const Seen before = look(c);
        const fmi2Status status = one_call(c, next() % 40);
        Seen after = look(c);
        if (status == fmi2Discard) after.mode = before.mode; /* a failed step changes the mode, and nothing else */
        if (status != fmi2OK && status != fmi2Discard && status != fmi2Error) abort();
        if (status != fmi2OK && memcmp(&before, &after, sizeof before)) abort();
    }
    for (int k = 0; k < SLOTS; k++) fmi2FreeFMUstate(c, &drawn.slots[k]);
    fmi2FreeInstance(c);
}
