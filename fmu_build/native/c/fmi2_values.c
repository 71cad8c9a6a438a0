/* Values of variables (FMI 2.0.4, section 2.1.7): all real variables stand in the buffer, the value reference is the index. */

static void refresh_outputs(Instance *s) {
    if (s->stale_outputs) kernel_output(s);
    s->stale_outputs = 0;
}

static void refresh_derivatives(Instance *s) {
    if (s->stale_derivatives) kernel_rates(s);
    s->stale_derivatives = 0;
}

static int known(fmi2ValueReference vr) { return vr < HF_END && fmu_role[vr] != HIDDEN; }

FMI2 fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[]) {
    Instance *s = c;
    if (!allowed(s, "fmi2GetReal", READABLE) || !given(s, "fmi2GetReal", n, vr, value)) return fmi2Error;
    for (size_t i = 0; i < n; i++) {
        if (!known(vr[i])) return refuse_text(s, "fmi2GetReal", "unknown value reference");
        if (fmu_role[vr[i]] == OUTPUT || fmu_role[vr[i]] == SENSITIVITY) refresh_outputs(s);
        if (fmu_role[vr[i]] == DERIVATIVE) refresh_derivatives(s);
        value[i] = s->v[vr[i]];
    }
    return fmi2OK;
}

/* Whether a variable of this role may be set in the instance's mode: start values before the run, inputs and tunable parameters
 * while it goes on, inputs alone between events. */
static int settable_now(const Instance *s, int role) {
    if (s->mode & BEFORE) return 1;
    if (role == INPUT || role == SLOPE) return 1;
    return role == PARAMETER && !(s->mode & IN_CONTINUOUS);
}

/* Say why a value is refused. */
APART static fmi2Status refuse_value(Instance *s, fmi2ValueReference vr, double value) {
    Message m = {{0}, 0};
    if (!known(vr)) return refuse_text(s, "fmi2SetReal", "unknown value reference");
    say(&m, fmu_name[vr]);
    if (fmu_min[vr] > fmu_max[vr]) { say(&m, ": expected not to be set, it is calculated"); return refuse(s, &m); }
    if (!settable_now(s, fmu_role[vr])) {
        say(&m, fmu_role[vr] == PARAMETER ? ": expected to be set in mode event, got mode" : ": expected to be set in mode instantiated or initialization, got mode");
        say_modes(&m, s->mode);
        return refuse(s, &m);
    }
    say(&m, ": expected between "); say_number(&m, fmu_min[vr]); say(&m, " and "); say_number(&m, fmu_max[vr]);
    say(&m, ", got "); say_number(&m, value);
    return refuse(s, &m);
}

FMI2 fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real value[]) {
    Instance *s = c;
    const unsigned first_felt = FMU_STALE_FROM; /* references before it are inputs that no output uses */
    if (!allowed(s, "fmi2SetReal", SETTABLE) || !given(s, "fmi2SetReal", n, vr, value)) return fmi2Error;
    for (size_t i = 0; i < n; i++)
        if (vr[i] >= HF_END || !(fmu_min[vr[i]] <= value[i] && value[i] <= fmu_max[vr[i]]) || !settable_now(s, fmu_role[vr[i]]))
            return refuse_value(s, vr[i], value[i]);
    for (size_t i = 0; i < n; i++) {
        s->v[vr[i]] = value[i];
        s->stale_derivatives = 1;
        if (vr[i] >= first_felt) s->stale_outputs = 1;
        if (fmu_role[vr[i]] == PARAMETER || fmu_role[vr[i]] == STATE) s->unchecked = 1;
    }
    return fmi2OK;
}

/* The one boolean variable, of an FMU for identification, stands behind the buffer. */
static int switches(Instance *s, const char *function, const fmi2ValueReference vr[], size_t n) {
    for (size_t i = 0; i < n; i++)
        if (!FMU_SWITCH || vr[i] != HF_END) {
            refuse_text(s, function, "unknown value reference");
            return 0;
        }
    return 1;
}

FMI2 fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Boolean value[]) {
    Instance *s = c;
    if (!allowed(s, "fmi2GetBoolean", READABLE) || !given(s, "fmi2GetBoolean", n, vr, value) || !switches(s, "fmi2GetBoolean", vr, n))
        return fmi2Error;
    for (size_t i = 0; i < n; i++) value[i] = s->tangent;
    return fmi2OK;
}

FMI2 fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Boolean value[]) {
    Instance *s = c;
    if (!allowed(s, "fmi2SetBoolean", SETTABLE & ~IN_CONTINUOUS) || !given(s, "fmi2SetBoolean", n, vr, value)) return fmi2Error;
    if (!switches(s, "fmi2SetBoolean", vr, n)) return fmi2Error;
    if (n && !allowed(s, "fmi2SetBoolean", BEFORE)) return fmi2Error; /* it is a fixed parameter */
    for (size_t i = 0; i < n; i++) s->tangent = value[i] != fmi2False;
    if (n) s->stale_outputs = 1;
    return fmi2OK;
}

#define NONE_OF(Kind, type, access, modes)                                                                                \
    FMI2 fmi2Status fmi2##Kind(fmi2Component c, const fmi2ValueReference vr[], size_t n, access type value[]) {           \
        (void)vr; (void)value;                                                                                            \
        if (!allowed(c, "fmi2" #Kind, modes)) return fmi2Error;                                                           \
        return n ? refuse_text(c, "fmi2" #Kind, "this FMU has no variable of that type") : fmi2OK;                       \
    }
NONE_OF(GetInteger, fmi2Integer, , READABLE)
NONE_OF(SetInteger, fmi2Integer, const, SETTABLE & ~IN_CONTINUOUS)
NONE_OF(GetString, fmi2String, , READABLE)
NONE_OF(SetString, fmi2String, const, SETTABLE & ~IN_CONTINUOUS)
