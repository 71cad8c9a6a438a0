/* Co-simulation (FMI 2.0.4, section 4.2): the kernel's own fixed-step stepper within each communication step. */

#define MOST_INNER_STEPS 1e8 /* of one communication step: about two minutes of computing, half a day of simulated time */

FMI2 fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer order[], const fmi2Real value[]) {
    Instance *s = c;
    if (!allowed_for(s, "fmi2SetRealInputDerivatives", fmi2CoSimulation, BEFORE | IN_STEP)) return fmi2Error;
    if (!given(s, "fmi2SetRealInputDerivatives", n, vr, value) || !given(s, "fmi2SetRealInputDerivatives", n, order, order)) return fmi2Error;
    for (size_t i = 0; i < n; i++)
        if (vr[i] >= HF_END || fmu_role[vr[i]] != INPUT || order[i] != 1 || !is_finite(value[i]))
            return refuse_text(s, "fmi2SetRealInputDerivatives", "expected finite first derivatives of inputs");
    for (size_t i = 0; i < n; i++) s->v[HF_SLOPE + (int)vr[i] - HF_U] = value[i];
    return fmi2OK;
}

FMI2 fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer order[], fmi2Real value[]) {
    (void)vr; (void)order; (void)value;
    if (!allowed_for(c, "fmi2GetRealOutputDerivatives", fmi2CoSimulation, IN_STEP | STEP_FAILED | TERMINATED)) return fmi2Error;
    return n ? refuse_text(c, "fmi2GetRealOutputDerivatives", "this FMU does not provide them (maxOutputDerivativeOrder is 0)") : fmi2OK;
}

/* A slope that came by fmi2SetRealInputDerivatives holds for one step; one that is a variable of its own stays. */
static void end_slopes(Instance *s, double dt) {
    if (FMU_SWITCH) return;
    for (int j = 0; j < HK_NU; j++) {
        s->v[HF_U + j] += dt * s->v[HF_SLOPE + j];
        s->v[HF_SLOPE + j] = 0;
    }
}

APART static fmi2Status refuse_step(Instance *s, const char *expected, double limit, const char *got, double value) {
    Message m = {{0}, 0};
    say(&m, "fmi2DoStep: expected "); say(&m, expected); say_number(&m, limit);
    say(&m, got); say_number(&m, value); say(&m, " s");
    return refuse(s, &m);
}

/* Whether a step can be tried at all. */
static int step_is_possible(Instance *s, double t, double dt) {
    const double away = t - s->time;
    if (!(dt > 0) || !is_finite(dt) || !is_finite(t)) {
        refuse_step(s, "a finite time and a positive step, got ", t, " s and ", dt);
        return 0;
    }
    if (!(away <= slack(t, dt) && -away <= slack(t, dt))) {
        refuse_step(s, "the time at which the instance is, ", s->time, " s, got ", t);
        return 0;
    }
    if (!within_experiment(s, "fmi2DoStep", t + dt, dt)) return 0;
    if (!(dt / s->v[HF_H] <= MOST_INNER_STEPS)) {
        refuse_step(s, "a step of at most ", MOST_INNER_STEPS * s->v[HF_H], " s, got ", dt);
        return 0;
    }
    return 1;
}

/* Try the step again in inner steps, until the mass matrix is no longer positive definite; whether it was so, and said. Positions are
 * the first states, velocities the next: where an inner step fails, the position that it goes to tells. */
static int blame_mass(Instance *s, Message *m, double dt) {
    const double start = s->time, count = (double)(long)(dt / s->v[HF_H] - 1e-6) + 1, inner = dt / count;
    int well = 1;
    for (double k = 0; well && k < count; k++) {
        const int stepped = kernel_step(s, start + k * inner, inner);
        for (int i = 0; !stepped && i < FMU_JOINTS; i++) s->v[HF_X + i] += inner * s->v[HF_X + FMU_JOINTS + i];
        s->time = start + (k + 1) * inner;
        well = definite(s, m);
        if (!stepped) break;
    }
    s->time = start;
    return !well;
}

/* End a step that failed where it began: a host reads the last good state, or restores one that it saved. */
APART static fmi2Status discard_step(Instance *s, const double *x, double t, double dt) {
    Message m = {{0}, 0};
    if (!FMU_JOINTS || !blame_mass(s, &m, dt)) {
        m.n = 0;
        say(&m, "the state left the finite numbers between t = "); say_number(&m, t); say(&m, " s and "); say_number(&m, t + dt); say(&m, " s");
    }
    for (int i = 0; i < HK_NX; i++) s->v[HF_X + i] = x[i];
    s->mode = STEP_FAILED;
    s->stale_outputs = s->stale_derivatives = 1;
    return tell_host(s, fmi2Discard, &m);
}

FMI2 fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real dt, fmi2Boolean no_set_state_before) {
    Instance *s = c;
    double x[HK_NX], start, pivot;
    (void)no_set_state_before;
    if (!allowed_for(s, "fmi2DoStep", fmi2CoSimulation, IN_STEP) || !step_is_possible(s, t, dt) || !consistent(s)) return fmi2Error;
    for (int i = 0; i < HK_NX; i++) x[i] = s->v[HF_X + i];
    start = s->time;
    if (!kernel_step(s, t, dt)) return discard_step(s, x, t, dt);
    s->time = t + dt;
    if (weightless_joint(s, &pivot) >= 0) {
        s->time = start;
        for (int i = 0; i < HK_NX; i++) s->v[HF_X + i] = x[i];
        return discard_step(s, x, t, dt);
    }
    end_slopes(s, dt);
    s->stale_outputs = 0;
    s->stale_derivatives = 1;
    return fmi2OK;
}

FMI2 fmi2Status fmi2CancelStep(fmi2Component c) {
    if (!allowed_for(c, "fmi2CancelStep", fmi2CoSimulation, ANY)) return fmi2Error;
    return refuse_text(c, "fmi2CancelStep", "expected while a step is pending, and steps never are");
}

/* What a host may ask of a step: the standard answers fmi2Discard where a slave does not have what is asked for. */
static fmi2Status ask_status(Instance *s, const char *function, int known_here, const void *value) {
    if (!allowed_for(s, function, fmi2CoSimulation, IN_STEP | STEP_FAILED | TERMINATED)) return fmi2Error;
    if (!value) return refuse_text(s, function, "expected a place for the answer, got none");
    return known_here ? fmi2OK : answer_text(s, fmi2Discard, function, "this FMU has no such status: steps are done when the call returns");
}

FMI2 fmi2Status fmi2GetStatus(fmi2Component c, fmi2StatusKind kind, fmi2Status *value) {
    (void)kind;
    return ask_status(c, "fmi2GetStatus", 0, value);
}

FMI2 fmi2Status fmi2GetRealStatus(fmi2Component c, fmi2StatusKind kind, fmi2Real *value) {
    fmi2Status status = ask_status(c, "fmi2GetRealStatus", kind == fmi2LastSuccessfulTime, value);
    if (status == fmi2OK) *value = ((Instance *)c)->time;
    return status;
}

FMI2 fmi2Status fmi2GetIntegerStatus(fmi2Component c, fmi2StatusKind kind, fmi2Integer *value) {
    (void)kind;
    return ask_status(c, "fmi2GetIntegerStatus", 0, value);
}

FMI2 fmi2Status fmi2GetBooleanStatus(fmi2Component c, fmi2StatusKind kind, fmi2Boolean *value) {
    fmi2Status status = ask_status(c, "fmi2GetBooleanStatus", kind == fmi2Terminated, value);
    if (status == fmi2OK) *value = fmi2False; /* whether the slave wants to end the simulation: it never does */
    return status;
}

FMI2 fmi2Status fmi2GetStringStatus(fmi2Component c, fmi2StatusKind kind, fmi2String *value) {
    (void)kind;
    return ask_status(c, "fmi2GetStringStatus", 0, value);
}
