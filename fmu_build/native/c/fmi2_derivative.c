/* Exact directional derivatives of outputs and state derivatives (FMI 2.0.4, section 2.1.9). */

#ifdef HK_NC
typedef struct { double dF[HK_NX * HK_NC], dY[HK_NY * HK_NC], B[HK_NX * HK_NU + 1], D[HK_NY * HK_NU + 1]; } Jacobian;

static void linearise(const Instance *s, Jacobian *J) {
    double S[HK_NX * HK_NC];
    for (int i = 0; i < HK_NX; i++) for (int k = 0; k < HK_NC; k++) S[i * HK_NC + k] = k == HK_NP + i;
    hk_linearise(s->time, s->v + HF_X, S, s->v + HF_U, s->v + HF_P, J->dF, J->dY);
    hf_input_jacobian(s->time, s->v + HF_X, s->v + HF_U, s->v + HF_P, J->B, J->D);
}

/* Derivative of output or state derivative `row` along known variable `vr`. */
static double partial(const Jacobian *J, fmi2ValueReference row, fmi2ValueReference vr) {
    int output = fmu_role[row] == OUTPUT, i = (int)row - (output ? HF_Y : HF_DX);
    if (fmu_role[vr] == INPUT) return output ? J->D[i * HK_NU + (int)vr - HF_U] : J->B[i * HK_NU + (int)vr - HF_U];
    int column = fmu_role[vr] == STATE ? HK_NP + (int)vr - HF_X : (int)vr - HF_P;
    return output ? J->dY[i * HK_NC + column] : J->dF[i * HK_NC + column];
}

static int are_unknowns(const fmi2ValueReference vr[], size_t n) {
    for (size_t i = 0; i < n; i++)
        if (vr[i] >= HF_END || (fmu_role[vr[i]] != OUTPUT && fmu_role[vr[i]] != DERIVATIVE)) return 0;
    return 1;
}

static int are_knowns(const fmi2ValueReference vr[], size_t n) {
    for (size_t i = 0; i < n; i++)
        if (vr[i] >= HF_END || fmu_role[vr[i]] < INPUT || fmu_role[vr[i]] > PARAMETER) return 0;
    return 1;
}

FMI2 fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknown[], size_t n, const fmi2ValueReference known[],
                                             size_t m, const fmi2Real seed[], fmi2Real value[]) {
    Instance *s = c;
    Jacobian J;
    if (!allowed(s, "fmi2GetDirectionalDerivative", READABLE)) return fmi2Error;
    if (!given(s, "fmi2GetDirectionalDerivative", n, unknown, value) || !given(s, "fmi2GetDirectionalDerivative", m, known, seed)) return fmi2Error;
    if (!are_knowns(known, m)) return refuse_text(s, "fmi2GetDirectionalDerivative", "expected inputs, states or parameters as knowns");
    if (!are_unknowns(unknown, n)) return refuse_text(s, "fmi2GetDirectionalDerivative", "expected outputs or state derivatives as unknowns");
    linearise(s, &J);
    for (size_t i = 0; i < n; i++) {
        value[i] = 0;
        for (size_t k = 0; k < m; k++) value[i] += partial(&J, unknown[i], known[k]) * seed[k];
    }
    return fmi2OK;
}
#else
FMI2 fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknown[], size_t n, const fmi2ValueReference known[],
                                             size_t m, const fmi2Real seed[], fmi2Real value[]) {
    (void)unknown; (void)n; (void)known; (void)m; (void)seed; (void)value;
    if (!allowed(c, "fmi2GetDirectionalDerivative", READABLE)) return fmi2Error;
    return refuse_text(c, "fmi2GetDirectionalDerivative", "this FMU does not provide it");
}
#endif
