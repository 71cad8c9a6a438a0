/* Saving, restoring and serialising the state of an instance, and its exact directional derivatives (FMI 2.0.4, section 2.1). */

typedef struct {
    char guid[sizeof FMU_GUID];
    double v[HF_END + 1], time;
    int tangent, mode, unchecked;
} Saved;

FMI2 fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state) {
    Instance *s = c;
    Saved *saved = *state ? *state : s->call.allocateMemory(1, sizeof *saved);
    if (!saved) return refuse_text(s, "fmi2GetFMUstate", "expected memory from the host, got none");
    for (size_t i = 0; i < sizeof saved->guid; i++) saved->guid[i] = FMU_GUID[i];
    for (int i = 0; i < HF_END; i++) saved->v[i] = s->v[i];
    saved->time = s->time;
    saved->tangent = s->tangent;
    saved->mode = s->mode;
    saved->unchecked = s->unchecked;
    *state = saved;
    return fmi2OK;
}

FMI2 fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
    Instance *s = c;
    const Saved *saved = state;
    if (!saved || !same(saved->guid, FMU_GUID)) return refuse_text(s, "fmi2SetFMUstate", "expected a state of this FMU");
    for (int i = 0; i < HF_END; i++) s->v[i] = saved->v[i];
    s->time = saved->time;
    s->tangent = saved->tangent;
    s->mode = saved->mode;
    s->unchecked = saved->unchecked;
    s->stale_outputs = s->stale_derivatives = 1;
    return fmi2OK;
}

FMI2 fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state) {
    if (*state) ((Instance *)c)->call.freeMemory(*state);
    *state = NULL;
    return fmi2OK;
}

FMI2 fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size) {
    (void)c; (void)state;
    *size = sizeof(Saved);
    return fmi2OK;
}

FMI2 fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
    if (size < sizeof(Saved)) return refuse_text(c, "fmi2SerializeFMUstate", "the buffer is too short");
    for (size_t i = 0; i < sizeof(Saved); i++) bytes[i] = ((const fmi2Byte *)state)[i];
    return fmi2OK;
}

FMI2 fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state) {
    Instance *s = c;
    if (size != sizeof(Saved)) return refuse_text(s, "fmi2DeSerializeFMUstate", "these bytes are no state of this FMU");
    fmi2Byte *to = *state ? *state : s->call.allocateMemory(1, sizeof(Saved));
    if (!to) return refuse_text(s, "fmi2DeSerializeFMUstate", "expected memory from the host, got none");
    for (size_t i = 0; i < sizeof(Saved); i++) to[i] = bytes[i];
    *state = to;
    return fmi2OK;
}

#ifdef HK_NC
/* Derivative of output or state derivative `row` along known variable `vr`. */
static double partial(fmi2ValueReference row, fmi2ValueReference vr, const double *dF, const double *dY, const double *B, const double *D) {
    int output = fmu_role[row] == OUTPUT, i = (int)row - (output ? HF_Y : HF_DX);
    if (fmu_role[vr] == INPUT) return output ? D[i * HK_NU + (int)vr - HF_U] : B[i * HK_NU + (int)vr - HF_U];
    int column = fmu_role[vr] == STATE ? HK_NP + (int)vr - HF_X : (int)vr - HF_P;
    return output ? dY[i * HK_NC + column] : dF[i * HK_NC + column];
}

FMI2 fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknown[], size_t n, const fmi2ValueReference known[],
                                             size_t m, const fmi2Real seed[], fmi2Real value[]) {
    Instance *s = c;
    double S[HK_NX * HK_NC], dF[HK_NX * HK_NC], dY[HK_NY * HK_NC], B[HK_NX * HK_NU + 1], D[HK_NY * HK_NU + 1];
    for (int i = 0; i < HK_NX; i++) for (int k = 0; k < HK_NC; k++) S[i * HK_NC + k] = k == HK_NP + i;
    hk_linearise(s->time, s->v + HF_X, S, s->v + HF_U, s->v + HF_P, dF, dY);
    hf_input_jacobian(s->time, s->v + HF_X, s->v + HF_U, s->v + HF_P, B, D);
    for (size_t k = 0; k < m; k++)
        if (known[k] >= HF_END || fmu_role[known[k]] < INPUT || fmu_role[known[k]] > PARAMETER)
            return refuse_text(s, "fmi2GetDirectionalDerivative", "expected inputs, states or parameters as knowns");
    for (size_t i = 0; i < n; i++) {
        if (unknown[i] >= HF_END || (fmu_role[unknown[i]] != OUTPUT && fmu_role[unknown[i]] != DERIVATIVE))
            return refuse_text(s, "fmi2GetDirectionalDerivative", "expected outputs or state derivatives as unknowns");
        value[i] = 0;
        for (size_t k = 0; k < m; k++) value[i] += partial(unknown[i], known[k], dF, dY, B, D) * seed[k];
    }
    return fmi2OK;
}
#else
FMI2 fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknown[], size_t n, const fmi2ValueReference known[],
                                             size_t m, const fmi2Real seed[], fmi2Real value[]) {
    (void)unknown; (void)n; (void)known; (void)m; (void)seed; (void)value;
    return refuse_text(c, "fmi2GetDirectionalDerivative", "this FMU does not provide it");
}
#endif
