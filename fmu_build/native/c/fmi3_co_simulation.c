/* Co-simulation (FMI 3.0.1, section 4): inputs are held over a step, each step is done to its end. */

/* Whether it is an instance for co-simulation, in one of these modes. */
#define BEGIN_TOGETHER(modes) \
    BEGIN(modes);             \
    if (w->core->type != fmi2CoSimulation) return complain(w, "expected an instance for co-simulation")

FMI3 fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 t, fmi3Float64 dt, fmi3Boolean no_set_state_before, fmi3Boolean *event,
                           fmi3Boolean *terminate, fmi3Boolean *early_return, fmi3Float64 *last_successful) {
    BEGIN_TOGETHER(IN_STEP);
    if (!event || !terminate || !early_return || !last_successful) return complain(w, NO_PLACE);
    const fmi3Status status = (fmi3Status)fmi2DoStep(w->core, t, dt, no_set_state_before);
    *event = *terminate = *early_return = false;
    *last_successful = w->core->time;
    if (status == fmi3Discard) w->core->mode = IN_STEP; /* the state is that before the call, and 3.0 has no mode for a failed step */
    return status;
}

REFUSED(fmi3EnterStepMode, (fmi3Instance instance), (void)0, "expected with eventModeUsed alone, and this FMU has no events")

FMI3 fmi3Status fmi3GetOutputDerivatives(fmi3Instance instance, const fmi3ValueReference vr[], size_t n, const fmi3Int32 order[],
                                         fmi3Float64 value[], size_t n_values) {
    BEGIN_TOGETHER(IN_STEP | TERMINATED);
    (void)vr; (void)order; (void)value;
    return n | n_values ? complain(w, "this FMU does not provide them (maxOutputDerivativeOrder is 0)") : fmi3OK;
}
