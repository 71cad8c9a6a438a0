/* Values (FMI 3.0.1, section 2.2.6): all variables are scalars of type Float64. The independent one stands behind the buffer. */

FMI3 fmi3Status fmi3GetFloat64(fmi3Instance instance, const fmi3ValueReference vr[], size_t n, fmi3Float64 value[], size_t n_values) {
    BEGIN(ANY);
    if (n != n_values) return complain(w, "expected as many values as value references");
    if (!given(w->core, __func__, n, vr, value)) return fmi3Error;
    for (size_t i = 0; i < n; i++) {
        if (vr[i] == HF_END) value[i] = w->core->time;
        else if (w->core->mode == INSTANTIATED) { /* start values alone may be read before initialization (section 2.3.2) */
            if (!known(vr[i]) || fmu_role[vr[i]] < INPUT || fmu_role[vr[i]] > PARAMETER)
                return complain(w, "expected variables with a start value, others are calculated from initialization mode on");
            value[i] = w->core->v[vr[i]];
        } else if (fmi2GetReal(w->core, vr + i, 1, value + i) != fmi2OK) return fmi3Error;
    }
    return fmi3OK;
}

FMI3 fmi3Status fmi3SetFloat64(fmi3Instance instance, const fmi3ValueReference vr[], size_t n, const fmi3Float64 value[], size_t n_values) {
    BEGIN(SETTABLE);
    if (n != n_values) return complain(w, "expected as many values as value references");
    if (!given(w->core, __func__, n, vr, value)) return fmi3Error;
    for (size_t i = 0; i < n; i++)
        if (vr[i] == HF_END) return complain(w, "time: expected not to be set, fmi3SetTime or fmi3DoStep moves it");
    return (fmi3Status)fmi2SetReal(w->core, vr, n, value);
}

static fmi3Status none_of(Wrapper *w, const char *function, int modes, size_t n) {
    if (!ready(w, function, modes)) return fmi3Error;
    return n ? complain(w, "this FMU has no variable of that type") : fmi3OK;
}

#define NONE_HERE(Type, modes)                                                                                                                \
    FMI3 fmi3Status fmi3Get##Type(fmi3Instance instance, const fmi3ValueReference vr[], size_t n, fmi3##Type value[], size_t n_values) { \
        (void)vr; (void)value;                                                                                                           \
        return none_of(instance, __func__, ANY, n | n_values);                                                                           \
    }                                                                                                                                    \
    FMI3 fmi3Status fmi3Set##Type(fmi3Instance instance, const fmi3ValueReference vr[], size_t n, const fmi3##Type value[],              \
                                  size_t n_values) {                                                                                     \
        (void)vr; (void)value;                                                                                                           \
        return none_of(instance, __func__, modes, n | n_values);                                                                         \
    }
enum { DISCRETE = SETTABLE & ~IN_CONTINUOUS }; /* variables that are not continuous */
NONE_HERE(Float32, SETTABLE)
NONE_HERE(Int8, DISCRETE)
NONE_HERE(UInt8, DISCRETE)
NONE_HERE(Int16, DISCRETE)
NONE_HERE(UInt16, DISCRETE)
NONE_HERE(Int32, DISCRETE)
NONE_HERE(UInt32, DISCRETE)
NONE_HERE(Int64, DISCRETE)
NONE_HERE(UInt64, DISCRETE)
NONE_HERE(Boolean, DISCRETE)
NONE_HERE(String, DISCRETE)

#define ABSENT(function, parameters, unused, n)                                  \
    FMI3 fmi3Status function parameters {                                        \
        unused;                                                                  \
        return none_of(instance, __func__, ANY, n);                              \
    }
ABSENT(fmi3GetBinary, (fmi3Instance instance, const fmi3ValueReference vr[], size_t n, size_t sizes[], fmi3Binary value[], size_t n_values),
       ((void)vr, (void)sizes, (void)value), n | n_values)
FMI3 fmi3Status fmi3SetBinary(fmi3Instance instance, const fmi3ValueReference vr[], size_t n, const size_t sizes[],
                              const fmi3Binary value[], size_t n_values) {
    (void)vr; (void)sizes; (void)value;
    return none_of(instance, __func__, DISCRETE, n | n_values);
}
ABSENT(fmi3GetClock, (fmi3Instance instance, const fmi3ValueReference vr[], size_t n, fmi3Clock value[]), ((void)vr, (void)value), n)
ABSENT(fmi3SetClock, (fmi3Instance instance, const fmi3ValueReference vr[], size_t n, const fmi3Clock value[]), ((void)vr, (void)value), n)
