/* Co-simulation (FMI 2.0.4, section 4.2): the kernel's own fixed-step stepper within each communication step. */

FMI2 fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer order[], const fmi2Real value[]) {
    Instance *s = c;
    for (size_t i = 0; i < n; i++) {
        if (vr[i] >= HF_END || fmu_role[vr[i]] != INPUT || order[i] != 1 || !(value[i] - value[i] == 0))
            return refuse_text(s, "fmi2SetRealInputDerivatives", "expected finite first derivatives of inputs");
        s->v[HF_SLOPE + (int)vr[i] - HF_U] = value[i];
    }
    return fmi2OK;
}

FMI2 fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer order[], fmi2Real value[]) {
    (void)vr; (void)n; (void)order; (void)value;
    return refuse_text(c, "fmi2GetRealOutputDerivatives", "this FMU does not provide them");
}

/* A slope that came by fmi2SetRealInputDerivatives holds for one step; one that is a variable of its own stays. */
static void end_slopes(Instance *s, double dt) {
    if (FMU_SWITCH) return;
    for (int j = 0; j < HK_NU; j++) {
        s->v[HF_U + j] += dt * s->v[HF_SLOPE + j];
        s->v[HF_SLOPE + j] = 0;
    }
}

FMI2 fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real dt, fmi2Boolean no_set_state_before) {
    Instance *s = c;
    int finite;
    (void)no_set_state_before;
    if (!allowed(s, "fmi2DoStep", RUNNING) || !consistent(s)) return fmi2Error;
    if (!(dt > 0) || !(dt - dt == 0) || !(t - t == 0)) {
        Message m = {{0}, 0};
        say(&m, "fmi2DoStep: expected a finite time and a positive step, got "); say_number(&m, t); say(&m, " s and "); say_number(&m, dt);
        say(&m, " s");
        return refuse(s, &m);
    }
#ifdef HK_NC
    if (s->tangent) finite = hf_step_tangent(s->v, t, dt); else
#endif
    finite = hf_step(s->v, t, dt);
    end_slopes(s, dt);
    s->time = t + dt;
    s->stale_outputs = 0;
    s->stale_derivatives = 1;
    if (finite) return fmi2OK;
    Message m = {{0}, 0};
    say(&m, "the state left the finite numbers between t = "); say_number(&m, t); say(&m, " s and "); say_number(&m, t + dt); say(&m, " s");
    return refuse(s, &m);
}

FMI2 fmi2Status fmi2CancelStep(fmi2Component c) { return refuse_text(c, "fmi2CancelStep", "steps are never pending"); }

FMI2 fmi2Status fmi2GetStatus(fmi2Component c, fmi2StatusKind kind, fmi2Status *value) {
    (void)kind; (void)value;
    return refuse_text(c, "fmi2GetStatus", "steps are never pending");
}

FMI2 fmi2Status fmi2GetRealStatus(fmi2Component c, fmi2StatusKind kind, fmi2Real *value) {
    if (kind != fmi2LastSuccessfulTime) return refuse_text(c, "fmi2GetRealStatus", "expected fmi2LastSuccessfulTime");
    *value = ((Instance *)c)->time;
    return fmi2OK;
}

FMI2 fmi2Status fmi2GetIntegerStatus(fmi2Component c, fmi2StatusKind kind, fmi2Integer *value) {
    (void)kind; (void)value;
    return refuse_text(c, "fmi2GetIntegerStatus", "there is no such status");
}

FMI2 fmi2Status fmi2GetBooleanStatus(fmi2Component c, fmi2StatusKind kind, fmi2Boolean *value) {
    if (kind != fmi2Terminated) return refuse_text(c, "fmi2GetBooleanStatus", "expected fmi2Terminated");
    *value = ((Instance *)c)->mode == TERMINATED;
    return fmi2OK;
}

FMI2 fmi2Status fmi2GetStringStatus(fmi2Component c, fmi2StatusKind kind, fmi2String *value) {
    (void)kind; (void)value;
    return refuse_text(c, "fmi2GetStringStatus", "steps are never pending");
}
