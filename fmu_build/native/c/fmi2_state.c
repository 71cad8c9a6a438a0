/* Saving, restoring and serialising the state of an instance (FMI 2.0.4, section 2.1.8). */

typedef struct {
    char guid[sizeof FMU_GUID];
    double v[HF_END + 1], time;
    int set_up, tangent, mode, type;
} Saved;

/* Whether a value is one that a variable of this reference may have; what is calculated is so again. */
static int valid_value(fmi2ValueReference vr, double value) {
    const int role = fmu_role[vr];
    if (role == INPUT || role == SLOPE || role == STATE || role == PARAMETER || role == STEP) return fmu_min[vr] <= value && value <= fmu_max[vr];
    return role == OUTPUT || role == DERIVATIVE || is_finite(value);
}

/* What is wrong with a state: bytes that came from outside are believed in nothing. NULL where nothing is. */
static const char *state_fault(const Instance *s, const Saved *saved) {
    int known_mode = 0;
    if (!saved) return "expected a state, got none";
    for (size_t i = 0; i < sizeof saved->guid; i++)
        if (saved->guid[i] != FMU_GUID[i]) return "expected a state of this FMU";
    if (saved->type != (int)s->type) return "expected a state of the same interface, co-simulation or model exchange";
    for (int k = 0; k < MODES; k++) known_mode |= saved->mode == mode_names[k].mode;
    if (saved->mode & (s->type == fmi2CoSimulation ? IN_EVENT | IN_CONTINUOUS : IN_STEP | STEP_FAILED)) known_mode = 0;
    if (!known_mode || !is_finite(saved->time) || ((saved->tangent | saved->set_up) & ~1)) return "expected a state that an instance can be in";
    for (unsigned vr = 0; vr < HF_END; vr++)
        if (!valid_value(vr, saved->v[vr])) return fmu_role[vr] == HIDDEN ? "expected finite values" : fmu_name[vr];
    return NULL;
}

static fmi2Status refuse_state(Instance *s, const char *function, const char *fault) {
    Message m = {{0}, 0};
    say(&m, function);
    say(&m, ": ");
    for (int vr = 0; vr < HF_END; vr++)
        if (fault == fmu_name[vr]) say(&m, "expected a value within its range for ");
    say(&m, fault);
    return refuse(s, &m);
}

FMI2 fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state) {
    Instance *s = c;
    if (!allowed(s, "fmi2GetFMUstate", ANY) || !given(s, "fmi2GetFMUstate", 1, state, state)) return fmi2Error;
    Saved *saved = *state ? *state : s->call.allocateMemory(1, sizeof *saved);
    if (!saved) return refuse_text(s, "fmi2GetFMUstate", "expected memory from the host, got none");
    for (size_t i = 0; i < sizeof saved->guid; i++) saved->guid[i] = FMU_GUID[i];
    for (int i = 0; i < HF_END; i++) saved->v[i] = s->v[i];
    saved->time = s->time;
    saved->tangent = s->tangent;
    saved->set_up = s->set_up;
    saved->mode = s->mode;
    saved->type = s->type;
    *state = saved;
    return fmi2OK;
}

FMI2 fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
    Instance *s = c;
    const Saved *saved = state;
    if (!allowed(s, "fmi2SetFMUstate", ANY)) return fmi2Error;
    const char *fault = state_fault(s, saved);
    if (fault) return refuse_state(s, "fmi2SetFMUstate", fault);
    for (int i = 0; i < HF_END; i++) s->v[i] = saved->v[i];
    s->time = saved->time;
    s->tangent = saved->tangent;
    s->set_up = saved->set_up;
    s->mode = saved->mode;
    s->unchecked = s->stale_outputs = s->stale_derivatives = 1;
    return fmi2OK;
}

FMI2 fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state) {
    Instance *s = c;
    if (!allowed(s, "fmi2FreeFMUstate", ANY)) return fmi2Error;
    if (!state || !*state) return fmi2OK;
    s->call.freeMemory(*state);
    *state = NULL;
    return fmi2OK;
}

FMI2 fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size) {
    (void)state; /* all states of an FMU have one size */
    if (!allowed(c, "fmi2SerializedFMUstateSize", ANY) || !given(c, "fmi2SerializedFMUstateSize", 1, size, size)) return fmi2Error;
    *size = sizeof(Saved);
    return fmi2OK;
}

FMI2 fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
    if (!allowed(c, "fmi2SerializeFMUstate", ANY) || !given(c, "fmi2SerializeFMUstate", 1, state, bytes)) return fmi2Error;
    if (size < sizeof(Saved)) return refuse_text(c, "fmi2SerializeFMUstate", "the buffer is too short");
    for (size_t i = 0; i < sizeof(Saved); i++) bytes[i] = ((const fmi2Byte *)state)[i];
    return fmi2OK;
}

FMI2 fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state) {
    Instance *s = c;
    Saved read = {{0}, {0}, 0, 0, 0, 0, 0};
    if (!allowed(s, "fmi2DeSerializeFMUstate", ANY) || !given(s, "fmi2DeSerializeFMUstate", 1, bytes, state)) return fmi2Error;
    if (size != sizeof read) return refuse_text(s, "fmi2DeSerializeFMUstate", "these bytes are no state of this FMU");
    for (size_t i = 0; i < sizeof read; i++) ((fmi2Byte *)&read)[i] = bytes[i];
    const char *fault = state_fault(s, &read);
    if (fault) return refuse_state(s, "fmi2DeSerializeFMUstate", fault);
    Saved *saved = *state ? *state : s->call.allocateMemory(1, sizeof *saved);
    if (!saved) return refuse_text(s, "fmi2DeSerializeFMUstate", "expected memory from the host, got none");
    *saved = read;
    *state = saved;
    return fmi2OK;
}
