/* What belongs to clocks, scheduled execution, structural parameters and dependencies of array elements: there are none of them. */

ABSENT(fmi3GetIntervalDecimal,
       (fmi3Instance instance, const fmi3ValueReference vr[], size_t n, fmi3Float64 interval[], fmi3IntervalQualifier qualifier[]),
       ((void)vr, (void)interval, (void)qualifier), n)
ABSENT(fmi3GetIntervalFraction,
       (fmi3Instance instance, const fmi3ValueReference vr[], size_t n, fmi3UInt64 counter[], fmi3UInt64 resolution[],
        fmi3IntervalQualifier qualifier[]),
       ((void)vr, (void)counter, (void)resolution, (void)qualifier), n)
ABSENT(fmi3GetShiftDecimal, (fmi3Instance instance, const fmi3ValueReference vr[], size_t n, fmi3Float64 shift[]), ((void)vr, (void)shift), n)
ABSENT(fmi3GetShiftFraction,
       (fmi3Instance instance, const fmi3ValueReference vr[], size_t n, fmi3UInt64 counter[], fmi3UInt64 resolution[]),
       ((void)vr, (void)counter, (void)resolution), n)
ABSENT(fmi3SetIntervalDecimal, (fmi3Instance instance, const fmi3ValueReference vr[], size_t n, const fmi3Float64 interval[]),
       ((void)vr, (void)interval), n)
ABSENT(fmi3SetIntervalFraction,
       (fmi3Instance instance, const fmi3ValueReference vr[], size_t n, const fmi3UInt64 counter[], const fmi3UInt64 resolution[]),
       ((void)vr, (void)counter, (void)resolution), n)
ABSENT(fmi3SetShiftDecimal, (fmi3Instance instance, const fmi3ValueReference vr[], size_t n, const fmi3Float64 shift[]),
       ((void)vr, (void)shift), n)
ABSENT(fmi3SetShiftFraction,
       (fmi3Instance instance, const fmi3ValueReference vr[], size_t n, const fmi3UInt64 counter[], const fmi3UInt64 resolution[]),
       ((void)vr, (void)counter, (void)resolution), n)

#define REFUSED(function, parameters, unused, why) \
    FMI3 fmi3Status function parameters {          \
        BEGIN(ANY);                                \
        unused;                                    \
        return complain(w, why);                   \
    }
REFUSED(fmi3ActivateModelPartition, (fmi3Instance instance, fmi3ValueReference clock, fmi3Float64 time), ((void)clock, (void)time),
        "this FMU has no model partitions")
REFUSED(fmi3EnterConfigurationMode, (fmi3Instance instance), (void)0, "this FMU has no structural parameters")
REFUSED(fmi3ExitConfigurationMode, (fmi3Instance instance), (void)0, "this FMU has no structural parameters")
REFUSED(fmi3GetNumberOfVariableDependencies, (fmi3Instance instance, fmi3ValueReference vr, size_t *n), ((void)vr, (void)n),
        "the dependencies stand in the model description, there are no arrays")
REFUSED(fmi3GetVariableDependencies,
        (fmi3Instance instance, fmi3ValueReference dependent, size_t element[], fmi3ValueReference independent[],
         size_t independent_element[], fmi3DependencyKind kind[], size_t n),
        ((void)dependent, (void)element, (void)independent, (void)independent_element, (void)kind, (void)n),
        "the dependencies stand in the model description, there are no arrays")
