"""The variables of an FMU: `Equations` in, one `Variable` per quantity out with name, range and value reference."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from haptid.fmu_build.thresholds import THRESHOLDS
from haptid.model.equations.equations import Equations
from haptid.model.equations.fmu_names import DERIVATIVE, INNER_STEP, SENSITIVITY, SLOPE, is_of_joint, of_joint
from haptid.model.equations.output_injection import GAIN
from haptid.model.equations.quantity import Quantity
from haptid.model.kernel.generate import Kernel

LARGEST_DOUBLE = 1.7976931348623157e308
"""Finite inputs and states lie within ± this."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Variable:
    """Hold one FMI real variable.

    Parameters
    ----------
    reference
        Value reference, and index into the buffer of an instance.
    id
        Id of the quantity in the equations.
    name
        Structured name of FMI 2.0.4, section 2.2.9.
    role
        ``input``, ``slope``, ``state``, ``parameter``, ``output``, ``derivative``, ``sensitivity`` or ``step``.
    causality, variability, initial
        Attributes of FMI; ``initial`` is "" where the standard's default holds.
    unit
        Unit that `parse_unit` reads; "" where none is stated.
    description
        One line for people.
    start
        Start value; None for calculated variables.
    minimum, maximum
        Range of the values that make sense, infinite where it has no bound.
    nominal
        Typical magnitude.
    derivative_of
        Value reference of the state; None but for derivatives.
    """

    reference: int
    id: str
    name: str
    role: str
    causality: str
    variability: str
    unit: str
    description: str
    initial: str = ""
    start: float | None = None
    minimum: float = -math.inf
    maximum: float = math.inf
    nominal: float = 1.0
    derivative_of: int | None = None

    @property
    def settable(self) -> bool:
        """Whether a user may set it."""
        return self.role in ("input", "slope", "state", "parameter", "step")

    @property
    def minimum_set(self) -> float:
        """Smallest value that may be set; above `maximum_set` where no value may be set."""
        return max(self.minimum, -LARGEST_DOUBLE) if self.settable else LARGEST_DOUBLE

    @property
    def maximum_set(self) -> float:
        """Largest value that may be set."""
        return min(self.maximum, LARGEST_DOUBLE) if self.settable else -LARGEST_DOUBLE


def structured_name(equations: Equations, id: str, structured: str) -> str:
    """Return the FMI structured name of a quantity (FMI 2.0.4, section 2.2.9).

    Parameters
    ----------
    equations
        Equations with the quantity; their number of joints decides the prefix.
    id
        Id of the quantity, the name where ``structured`` is empty.
    structured
        Name that the quantity brings with it, as ``friction.Fc``.

    Returns
    -------
    str
        As ``joint4.friction.Fc`` with one joint. With several joints, or a joint in the name, the name as it is.
    """
    name = structured or id
    if len(equations.joints) != 1 or is_of_joint(name):
        return name
    return of_joint(equations.joints[0], name)


def sensitivity_name(output: str, column: str) -> str:
    """Return the FMU variable name of the derivative of an output with respect to a parameter or an initial state.

    Parameters
    ----------
    output
        Id of the output.
    column
        Id of the parameter, or ``<state>_0`` of an initial state.

    Returns
    -------
    str
        ``sensitivity.<output>.<column>``.
    """
    return SENSITIVITY.format(output=output, column=column)


def input_variables(e: Equations, at: int) -> Iterator[Variable]:
    """Yield the inputs, from value reference `at` on.

    Parameters
    ----------
    e
        Equations with their inputs.
    at
        Value reference of the first input.

    Yields
    ------
    Variable
        One an input, which may change continuously and starts at the value of the equations.
    """
    for i, x in enumerate(e.inputs, start=at):
        yield Variable(
            reference=i,
            id=x.id,
            name=structured_name(e, x.id, x.structured),
            role="input",
            causality="input",
            variability="continuous",
            unit=x.unit,
            description=x.description,
            start=x.start,
        )


def state_variables(e: Equations, at: int, values: dict[str, float]) -> Iterator[Variable]:
    """Yield the states, from value reference `at` on.

    Parameters
    ----------
    e
        Equations with their states.
    at
        Value reference of the first state.
    values
        Start value by id of the state, SI units; that of the equations where absent.

    Yields
    ------
    Variable
        One a state, local with an exact start value.
    """
    for i, x in enumerate(e.states, start=at):
        yield Variable(
            reference=i,
            id=x.id,
            name=structured_name(e, x.id, x.structured),
            role="state",
            causality="local",
            variability="continuous",
            unit=x.unit,
            description=x.description,
            initial="exact",
            start=values.get(x.id, x.start),
            nominal=x.nominal,
        )


def parameter_variables(e: Equations, at: int, values: dict[str, float], identification: bool) -> Iterator[Variable]:
    """Yield the parameters of an FMU.

    Parameters
    ----------
    e
        Equations with the parameters.
    at
        Value reference of the first.
    values
        Start values by id, SI units; the first guesses where absent.
    identification
        Whether a fit keeps the bounds, so that the FMU enforces the sign alone.

    Yields
    ------
    Variable
        In the order of the equations. Bounds widen to include the start value.
    """
    for i, x in enumerate(e.parameters, start=at):
        start = _without_residue(x, float(values.get(x.id, x.initial)))
        lower, upper = _range(x, start, identification)
        yield Variable(
            reference=i,
            id=x.id,
            name=structured_name(e, x.id, x.structured),
            role="parameter",
            causality="parameter",
            variability="tunable",
            unit=x.unit,
            description=x.description,
            initial="exact",
            start=start,
            minimum=lower,
            maximum=upper,
            nominal=_nominal(x, start),
        )


def _scale(x: Quantity) -> float:
    """Return the magnitude of the bounds of a quantity; 0 where one is infinite."""
    largest = max(abs(x.lower), abs(x.upper))
    return largest if math.isfinite(largest) else 0.0


def _without_residue(x: Quantity, start: float) -> float:
    """Return 0 for a value of either sign that is but the rounding of zero, as where the data say nothing of it."""
    return 0.0 if x.lower < 0 < x.upper and abs(start) < THRESHOLDS.rounding_of_scale * _scale(x) else start


def _nominal(x: Quantity, start: float) -> float:
    """Return a typical magnitude: that of the start value; where that is next to nothing, that of the bounds."""
    return abs(start) if abs(start) > THRESHOLDS.least_nominal_of_scale * _scale(x) else _scale(x) or 1.0


def _range(x: Quantity, start: float, identification: bool) -> tuple[float, float]:
    """Return the bounds that the FMU enforces: the quantity's own, or its sign alone where a fit keeps the bounds."""
    if identification:
        return (1e-300 if x.scale == "log" else -math.inf), math.inf
    return min(x.lower, start), max(x.upper, start)


def output_variables(e: Equations, at: int) -> Iterator[Variable]:
    """Yield the outputs, from value reference `at` on.

    Parameters
    ----------
    e
        Equations with their outputs.
    at
        Value reference of the first output.

    Yields
    ------
    Variable
        One an output, calculated.
    """
    for i, x in enumerate(e.outputs, start=at):
        yield Variable(
            reference=i,
            id=x.id,
            name=structured_name(e, x.id, x.structured),
            role="output",
            causality="output",
            variability="continuous",
            unit=x.unit,
            description=x.description,
            initial="calculated",
        )


def derivative_variables(e: Equations, at: int, states_at: int) -> Iterator[Variable]:
    """Yield the state derivatives, from value reference `at` on.

    Parameters
    ----------
    e
        Equations with their states.
    at
        Value reference of the first derivative.
    states_at
        Value reference of the first state.

    Yields
    ------
    Variable
        One a state, local, with the reference of its state.
    """
    for i, x in enumerate(e.states):
        # A second division by time is a square: rad/s becomes rad/s^2.
        unit = f"{x.unit}^2" if x.unit.endswith("/s") else f"{x.unit}/s"
        yield Variable(
            reference=at + i,
            id=f"der({x.id})",
            name=DERIVATIVE.format(state=structured_name(e, x.id, x.structured)),
            role="derivative",
            causality="local",
            variability="continuous",
            unit=unit,
            description=f"rate of change of {x.description}",
            initial="calculated",
            derivative_of=states_at + i,
        )


def slope_variables(e: Equations, at: int) -> Iterator[Variable]:
    """Yield the rate of change of each input except the observer gain, from value reference `at` on.

    Parameters
    ----------
    e
        Equations with their inputs.
    at
        Value reference that belongs to the first input.

    Yields
    ------
    Variable
        One an input, per second; the reference of the observer gain's stays without a variable.
    """
    for i, x in enumerate(e.inputs, start=at):
        if x.id != GAIN:
            yield Variable(
                reference=i,
                id=f"{x.id}_slope",
                name=SLOPE.format(input=structured_name(e, x.id, x.structured)),
                role="slope",
                causality="input",
                variability="continuous",
                unit=f"{x.unit}/s" if "/" not in x.unit else "",
                description=f"rate of change of {x.description} during the step; 0 holds it",
                start=0.0,
            )


def sensitivity_variables(kernel: Kernel, at: int) -> Iterator[Variable]:
    """Yield the derivatives of the outputs, row-major in outputs and directions, from value reference `at` on.

    Parameters
    ----------
    kernel
        Kernel with its outputs and directions (``columns``).
    at
        Value reference of the first derivative.

    Yields
    ------
    Variable
        n_y·n_c outputs, without a unit.
    """
    e = kernel.equations
    for i, output in enumerate(e.outputs):
        for k, column in enumerate(kernel.columns):
            yield Variable(
                reference=at + i * len(kernel.columns) + k,
                id=f"d{output.id}_d{column}",
                name=sensitivity_name(output.id, column),
                role="sensitivity",
                causality="output",
                variability="continuous",
                unit="",
                description=f"derivative of {output.description} with respect to {column}, SI units",
                initial="calculated",
            )


def inner_step_variable(step: float, at: int) -> Variable:
    """Return the variable of the longest inner step, which a fit sets: coarse in its search, fine at its end.

    Parameters
    ----------
    step
        Start value [s].
    at
        Value reference.

    Returns
    -------
    Variable
        A fixed parameter of at least 1 µs.
    """
    return Variable(
        reference=at,
        id=INNER_STEP,
        name=INNER_STEP,
        role="step",
        causality="parameter",
        variability="fixed",
        unit="s",
        description="longest inner step of the integration",
        initial="exact",
        start=step,
        minimum=1e-6,
        nominal=step,
    )
