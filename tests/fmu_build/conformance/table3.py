"""FMI 3.0 as a table: for every function the modes in which it may be called, and its answer to kinds of arguments.

Modes are those of FMI 3.0.1, sections 2.3, 3.2 and 4.2, that an FMU without events, clocks and structural parameters
can be in, by letter. As in `table`, the answer is fmi3Error elsewhere, and a refused call changes nothing. Nothing
asked for (no value references) is fmi3OK for types that the FMU does not have, wherever values of that type might be
got or set; functions of clocks are asked for nothing in any mode.
"""

from __future__ import annotations

from tests.fmu_build.conformance.table import DISCARD, ERROR, EXCHANGE, OK, TOGETHER, Row

MODES = {
    "I": "instantiated",
    "N": "initialization",
    "V": "event",
    "C": "continuous-time",
    "S": "step",
    "T": "terminated",
}
INTERFACES = {TOGETHER: "INST", EXCHANGE: "INVCT"}
ALWAYS, GOING, EVALUATED = "INVCST", "VCS", "NVCT"
SET, SET_DISCRETE, DERIVED = "INVCS", "INVS", "NVCST"
CONTINUOUS_TYPES = ("Float32",)
DISCRETE_TYPES = (
    "Int8",
    "UInt8",
    "Int16",
    "UInt16",
    "Int32",
    "UInt32",
    "Int64",
    "UInt64",
    "Boolean",
    "String",
    "Binary",
)
CLOCKS = (
    "GetClock", "SetClock", "GetIntervalDecimal", "GetIntervalFraction", "GetShiftDecimal", "GetShiftFraction",
    "SetIntervalDecimal", "SetIntervalFraction", "SetShiftDecimal", "SetShiftFraction",
)  # fmt: skip
ABSENT = (
    "ActivateModelPartition", "EnterConfigurationMode", "ExitConfigurationMode", "EnterStepMode",
    "EvaluateDiscreteStates", "GetNumberOfVariableDependencies", "GetVariableDependencies",
)  # fmt: skip
"""Functions that the model description says are not to be called: no mode allows them."""
NOTHING = {"nothing": OK, "one": ERROR}
STATES = {"plain": OK, "too few": ERROR, "no arrays": ERROR}

TABLE3: dict[str, Row] = {
    "GetVersion": Row(modes=ALWAYS, answers={"plain": OK}),
    "SetDebugLogging": Row(
        modes=ALWAYS, answers={"all": OK, "known category": OK, "unknown category": ERROR, "no arrays": ERROR}
    ),
    "EnterInitializationMode": Row(
        modes="I",
        answers={"plain": OK, "with stop time": OK, "stop before start": ERROR, "NaN start": ERROR, "NaN stop": ERROR},
    ),
    "ExitInitializationMode": Row(modes="N", answers={"plain": OK, "inconsistent values": ERROR}),
    "Terminate": Row(modes=GOING, answers={"plain": OK}),
    "Reset": Row(modes=ALWAYS, answers={"plain": OK}),
    "GetFloat64": Row(
        modes=ALWAYS,
        answers={
            "nothing": OK, "input": OK, "state": OK, "parameter": OK, "time": OK, "output": OK, "derivative": OK,
            "unknown": ERROR, "huge reference": ERROR, "no arrays": ERROR, "other number of values": ERROR,
        },
        # start values alone may be read before initialization
        narrower={"output": "NVCST", "derivative": "NVCST"},
    ),
    "SetFloat64": Row(
        modes=SET,
        answers={
            "nothing": OK, "input": OK, "parameter": OK, "state": OK, "time": ERROR, "output": ERROR, "outside": ERROR,
            "NaN": ERROR, "infinity": ERROR, "good and bad": ERROR, "unknown": ERROR, "no arrays": ERROR,
            "other number of values": ERROR,
        },
        narrower={"parameter": "INVS", "state": "IN"},
    ),
    **{f"Get{t}": Row(modes=ALWAYS, answers=NOTHING) for t in (*CONTINUOUS_TYPES, *DISCRETE_TYPES)},
    **{f"Set{t}": Row(modes=SET, answers=NOTHING) for t in CONTINUOUS_TYPES},
    **{f"Set{t}": Row(modes=SET_DISCRETE, answers=NOTHING) for t in DISCRETE_TYPES},
    **{name: Row(modes=ALWAYS, answers=NOTHING) for name in CLOCKS},
    **{name: Row(modes="", answers={"plain": ERROR}) for name in ABSENT},
    "GetFMUState": Row(modes=ALWAYS, answers={"new": OK, "again": OK, "no place": ERROR}),
    "SetFMUState": Row(modes=ALWAYS, answers={"own": OK, "none": ERROR, "foreign": ERROR}),
    "FreeFMUState": Row(modes=ALWAYS, answers={"own": OK, "none": OK, "no place": OK}),
    "SerializedFMUStateSize": Row(modes=ALWAYS, answers={"own": OK, "no place": ERROR}),
    "SerializeFMUState": Row(modes=ALWAYS, answers={"own": OK, "none": ERROR, "short": ERROR, "no place": ERROR}),
    "DeserializeFMUState": Row(modes=ALWAYS, answers={"own": OK, "truncated": ERROR, "nothing": ERROR}),
    "GetDirectionalDerivative": Row(
        modes=DERIVED,
        answers={
            "output by state": OK, "unknown by output": ERROR, "input as unknown": ERROR, "no arrays": ERROR,
            "other number of seeds": ERROR,
        },
    ),
    "GetAdjointDerivative": Row(
        modes=DERIVED,
        answers={
            "output by state": OK, "unknown by output": ERROR, "input as unknown": ERROR, "no arrays": ERROR,
            "other number of seeds": ERROR,
        },
    ),
    "EnterEventMode": Row(modes="C", answers={"plain": OK}, only=EXCHANGE),
    "UpdateDiscreteStates": Row(modes="V", answers={"plain": OK, "no place": ERROR}, only=EXCHANGE),
    "EnterContinuousTimeMode": Row(modes="V", answers={"plain": OK}, only=EXCHANGE),
    "CompletedIntegratorStep": Row(
        modes="C", answers={"plain": OK, "past the stop time": ERROR, "no place": ERROR}, only=EXCHANGE
    ),
    "SetTime": Row(modes="VC", answers={"plain": OK, "NaN": ERROR, "infinity": ERROR}, only=EXCHANGE),
    "SetContinuousStates": Row(modes="C", answers={**STATES, "NaN": ERROR}, only=EXCHANGE),
    "GetContinuousStateDerivatives": Row(modes=EVALUATED, answers=STATES, only=EXCHANGE),
    "GetContinuousStates": Row(modes=EVALUATED, answers=STATES, only=EXCHANGE),
    "GetNominalsOfContinuousStates": Row(modes=EVALUATED, answers=STATES, only=EXCHANGE),
    "GetEventIndicators": Row(modes=EVALUATED, answers=NOTHING, only=EXCHANGE),
    "GetNumberOfContinuousStates": Row(modes=ALWAYS, answers={"plain": OK, "no place": ERROR}, only=EXCHANGE),
    "GetNumberOfEventIndicators": Row(modes=ALWAYS, answers={"plain": OK, "no place": ERROR}, only=EXCHANGE),
    "GetOutputDerivatives": Row(modes="ST", answers=NOTHING, only=TOGETHER),
    "DoStep": Row(
        modes="S",
        answers={
            "plain": OK, "up to the stop time": OK, "rounded time": OK, "past the stop time": ERROR,
            "earlier time": ERROR, "later time": ERROR, "NaN time": ERROR, "no step": ERROR, "step back": ERROR,
            "NaN step": ERROR, "infinite step": ERROR, "step beyond all counting": ERROR, "no place": ERROR,
            "inconsistent values": ERROR, "one that leaves the finite numbers": DISCARD,
        },
        only=TOGETHER,
    ),
}  # fmt: skip
"""Functions without their ``fmi3``; instances are made and freed by the harness."""
