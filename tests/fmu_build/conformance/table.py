"""FMI 2.0.4 as a table: for every function the modes in which it may be called, and its answer to kinds of arguments.

Modes are those of the state machines of sections 3.2.3 (model exchange) and 4.2.4 (co-simulation), by letter. In a mode
that is not listed, and for an instance of the other interface, the answer is fmi2Error. A mode of an erroneous
instance is missing: a call that is refused changes nothing here, so that its table is that of the mode before.
"""

from __future__ import annotations

from dataclasses import dataclass

OK, WARNING, DISCARD, ERROR, FATAL, PENDING = range(6)
"""``fmi2Status``."""
MODES = {
    "I": "instantiated",
    "N": "initialization",
    "V": "event",
    "C": "continuous-time",
    "S": "step complete",
    "F": "step failed",
    "T": "terminated",
}
INTERFACES = {"co-simulation": "INSFT", "model exchange": "INVCT"}
"""Modes that an instance of each interface can be in."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """State when a function may be called and what it answers.

    Parameters
    ----------
    modes
        Letters of the modes in which the standard allows the call, of both interfaces.
    answers
        Status by kind of argument, in those modes.
    only
        The interface that has the function; both where empty.
    narrower
        Kinds of argument that are allowed in fewer modes, with these.
    """

    modes: str
    answers: dict[str, int]
    only: str = ""
    narrower: dict[str, str] | None = None

    def expected(self, interface: str, mode: str, kind: str) -> int:
        """Return the status that the standard asks for."""
        modes = (self.narrower or {}).get(kind, self.modes)
        return self.answers[kind] if mode in modes and self.only in ("", interface) else ERROR


ALWAYS, BEFORE, READ = "INVCSFT", "IN", "NVCSFT"
SET, SET_DISCRETE = "INVCS", "INVS"
TOGETHER, EXCHANGE = "co-simulation", "model exchange"
VALUES = {"none": OK, "unknown": ERROR, "no arrays": ERROR}

TABLE: dict[str, Row] = {
    "fmi2GetTypesPlatform": Row(modes=ALWAYS, answers={"plain": OK}),
    "fmi2GetVersion": Row(modes=ALWAYS, answers={"plain": OK}),
    "fmi2SetDebugLogging": Row(
        modes=ALWAYS, answers={"all": OK, "known category": OK, "unknown category": ERROR, "no arrays": ERROR}
    ),
    "fmi2SetupExperiment": Row(
        modes="I",
        answers={"plain": OK, "with stop time": OK, "stop before start": ERROR, "NaN start": ERROR, "NaN stop": ERROR},
    ),
    "fmi2EnterInitializationMode": Row(modes="I", answers={"plain": OK, "before fmi2SetupExperiment": ERROR}),
    "fmi2ExitInitializationMode": Row(modes="N", answers={"plain": OK, "inconsistent values": ERROR}),
    "fmi2Terminate": Row(modes="VCSF", answers={"plain": OK}),
    "fmi2Reset": Row(modes=ALWAYS, answers={"plain": OK}),
    "fmi2GetReal": Row(
        modes=READ, answers={**VALUES, "input": OK, "state": OK, "parameter": OK, "output": OK, "huge reference": ERROR}
    ),
    "fmi2SetReal": Row(
        modes=SET,
        answers={
            **VALUES,
            "input": OK,
            "parameter": OK,
            "state": OK,
            "output": ERROR,
            "outside": ERROR,
            "NaN": ERROR,
            "infinity": ERROR,
            "good and bad": ERROR,
        },
        narrower={"parameter": "INVS", "state": BEFORE},
    ),
    "fmi2GetInteger": Row(modes=READ, answers=VALUES),
    "fmi2SetInteger": Row(modes=SET_DISCRETE, answers={"none": OK, "unknown": ERROR}),
    "fmi2GetBoolean": Row(modes=READ, answers=VALUES),
    "fmi2SetBoolean": Row(modes=SET_DISCRETE, answers={"none": OK, "unknown": ERROR}),
    "fmi2GetString": Row(modes=READ, answers=VALUES),
    "fmi2SetString": Row(modes=SET_DISCRETE, answers={"none": OK, "unknown": ERROR}),
    "fmi2GetFMUstate": Row(modes=ALWAYS, answers={"new": OK, "again": OK, "no place": ERROR}),
    "fmi2SetFMUstate": Row(modes=ALWAYS, answers={"own": OK, "none": ERROR, "foreign": ERROR}),
    "fmi2FreeFMUstate": Row(modes=ALWAYS, answers={"own": OK, "none": OK, "no place": OK}),
    "fmi2SerializedFMUstateSize": Row(modes=ALWAYS, answers={"own": OK, "no place": ERROR}),
    "fmi2SerializeFMUstate": Row(modes=ALWAYS, answers={"own": OK, "none": ERROR, "short": ERROR, "no place": ERROR}),
    "fmi2DeSerializeFMUstate": Row(
        modes=ALWAYS,
        answers={"own": OK, "truncated": ERROR, "NaN parameter": ERROR, "bad mode": ERROR, "nothing": ERROR},
    ),
    "fmi2GetDirectionalDerivative": Row(
        modes=READ, answers={"output by state": OK, "unknown by output": ERROR, "input as unknown": ERROR}
    ),
    "fmi2EnterEventMode": Row(modes="VC", answers={"plain": OK}, only=EXCHANGE),
    "fmi2NewDiscreteStates": Row(modes="V", answers={"plain": OK, "no place": ERROR}, only=EXCHANGE),
    "fmi2EnterContinuousTimeMode": Row(modes="V", answers={"plain": OK}, only=EXCHANGE),
    "fmi2CompletedIntegratorStep": Row(
        modes="C", answers={"plain": OK, "past the stop time": ERROR, "no place": ERROR}, only=EXCHANGE
    ),
    "fmi2SetTime": Row(modes="VC", answers={"plain": OK, "NaN": ERROR, "infinity": ERROR}, only=EXCHANGE),
    "fmi2SetContinuousStates": Row(
        modes="C", answers={"plain": OK, "too few": ERROR, "NaN": ERROR, "no arrays": ERROR}, only=EXCHANGE
    ),
    "fmi2GetDerivatives": Row(modes="VCT", answers={"plain": OK, "too few": ERROR, "no arrays": ERROR}, only=EXCHANGE),
    "fmi2GetEventIndicators": Row(modes="NVCT", answers={"none": OK, "one": ERROR}, only=EXCHANGE),
    "fmi2GetContinuousStates": Row(
        modes="NVCT", answers={"plain": OK, "too few": ERROR, "no arrays": ERROR}, only=EXCHANGE
    ),
    "fmi2GetNominalsOfContinuousStates": Row(
        modes="IVCT", answers={"plain": OK, "too few": ERROR, "no arrays": ERROR}, only=EXCHANGE
    ),
    "fmi2SetRealInputDerivatives": Row(
        modes="INS",
        answers={"input": OK, "none": OK, "second order": ERROR, "parameter": ERROR, "NaN": ERROR, "no arrays": ERROR},
        only=TOGETHER,
    ),
    "fmi2GetRealOutputDerivatives": Row(modes="SFT", answers={"none": OK, "output": ERROR}, only=TOGETHER),
    "fmi2DoStep": Row(
        modes="S",
        answers={
            "plain": OK,
            "up to the stop time": OK,
            "rounded time": OK,
            "past the stop time": ERROR,
            "earlier time": ERROR,
            "later time": ERROR,
            "NaN time": ERROR,
            "no step": ERROR,
            "step back": ERROR,
            "NaN step": ERROR,
            "infinite step": ERROR,
            "step beyond all counting": ERROR,
            "inconsistent values": ERROR,
        },
        only=TOGETHER,
    ),
    "fmi2CancelStep": Row(modes="", answers={"plain": ERROR}, only=TOGETHER),
    "fmi2GetStatus": Row(modes="SFT", answers={"last step": DISCARD, "no place": ERROR}, only=TOGETHER),
    "fmi2GetRealStatus": Row(
        modes="SFT", answers={"last successful time": OK, "another": DISCARD, "no place": ERROR}, only=TOGETHER
    ),
    "fmi2GetIntegerStatus": Row(modes="SFT", answers={"any": DISCARD, "no place": ERROR}, only=TOGETHER),
    "fmi2GetBooleanStatus": Row(
        modes="SFT", answers={"terminated": OK, "another": DISCARD, "no place": ERROR}, only=TOGETHER
    ),
    "fmi2GetStringStatus": Row(modes="SFT", answers={"any": DISCARD, "no place": ERROR}, only=TOGETHER),
}
