"""The variables of an FMU, read off the equations: names, value references, ranges, and the flat buffer they live in.

All real variables of an instance are one array of doubles; the value reference is the index into it. Blocks, in order:

u (n_u), x (n_x), p (n_p), y (n_y), dx (n_x), slope (n_u), dy (n_y·n_c), S (n_x·n_c)

with n_c = n_p + n_x directions of the sensitivities, or 0. Blocks that an FMU does not show are still there.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import sympy as sp

from model.equations import Equations
from model.kernel.generate import Kernel
from model.observer import GAIN
from model.quantity import Quantity

LARGEST = 1.7976931348623157e308
"""Finite inputs and states lie within ± this."""
SENSITIVITY_SWITCH = "sensitivity.enabled"


@dataclass(frozen=True, slots=True, kw_only=True)
class Variable:
    """One FMI real variable; `reference` is its value reference and its place in the buffer."""

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
        return self.role in ("input", "slope", "state", "parameter")

    @property
    def minimum_set(self) -> float:
        """Smallest value that may be set; above `maximum_set` where none may."""
        return max(self.minimum, -LARGEST) if self.settable else LARGEST

    @property
    def maximum_set(self) -> float:
        """Largest value that may be set."""
        return min(self.maximum, LARGEST) if self.settable else -LARGEST


@dataclass(frozen=True, slots=True, kw_only=True)
class Interface:
    """What an FMU shows of its kernel.

    Parameters
    ----------
    identifier
        Model identifier, a C identifier.
    identification
        Whether slopes and sensitivities are shown.
    derivatives
        Whether the state derivatives are shown (the native FMU).
    """

    kernel: Kernel
    identifier: str
    title: str
    variables: tuple[Variable, ...]
    identification: bool
    derivatives: bool

    @property
    def equations(self) -> Equations:
        """The equations of the kernel."""
        return self.kernel.equations

    @property
    def offsets(self) -> dict[str, int]:
        """Where each block of the buffer begins; ``end`` is its length."""
        return block_offsets(self.kernel)

    def of_role(self, role: str) -> tuple[Variable, ...]:
        """Return the variables of one role, in the order of the value references."""
        return tuple(v for v in self.variables if v.role == role)

    def by_id(self, id: str) -> Variable:
        """Return the variable of a state, input, output or parameter; KeyError lists the known ids."""
        for variable in self.variables:
            if variable.id == id:
                return variable
        msg = f"{self.identifier} has no variable {id!r}; it has {[v.id for v in self.variables]}"
        raise KeyError(msg)

    @property
    def start(self) -> tuple[float, ...]:
        """Initial content of the buffer; the tangent starts as the identity on the initial states."""
        values = [0.0] * self.offsets["end"]
        for variable in self.variables:
            if variable.start is not None:
                values[variable.reference] = variable.start
        columns, parameters = len(self.kernel.columns), len(self.equations.parameters)
        for i in range(len(self.equations.states) if columns else 0):
            values[self.offsets["S"] + i * columns + parameters + i] = 1.0
        return tuple(values)

    @property
    def stale_from(self) -> int:
        """First reference that, when set, leaves the outputs stale: an input only where outputs use inputs."""
        e = self.equations
        used: set[sp.Symbol] = {u.symbol for u in e.inputs}
        used |= {s for s, f in e.definitions if f.free_symbols & used}
        through = any(sp.sympify(o.expression).free_symbols & used for o in e.outputs)
        return 0 if through or self.identification else self.offsets["x"]

    @property
    def orderings(self) -> tuple[tuple[int, int], ...]:
        """Pairs of references (a, b) with a ≥ b required; a fit minds them itself and may pass where they fail."""
        pairs = () if self.identification else self.equations.orderings
        return tuple((self.by_id(a).reference, self.by_id(b).reference) for a, b in pairs)


def block_offsets(kernel: Kernel) -> dict[str, int]:
    """Return where each block begins in the buffer."""
    e, columns = kernel.equations, len(kernel.columns)
    nx, nu, n_p, ny = len(e.states), len(e.inputs), len(e.parameters), len(e.outputs)
    lengths = {"u": nu, "x": nx, "p": n_p, "y": ny, "dx": nx, "slope": nu, "dy": ny * columns, "S": nx * columns}
    offsets, total = {}, 0
    for name, length in lengths.items():
        offsets[name] = total
        total += length
    return {**offsets, "end": total}


def structured_name(equations: Equations, id: str, structured: str) -> str:
    """Return the FMI structured name: below ``joint<j>`` where there is one joint and the name does not say so."""
    name = structured or id
    if len(equations.joints) != 1 or name.startswith("joint"):
        return name
    return f"joint{equations.joints[0]}.{name}"


def sensitivity_name(output: str, column: str) -> str:
    """Return the name of the derivative of an output along one direction."""
    return f"sensitivity.{output}.{column}"


def interface_of(
    kernel: Kernel, *, identifier: str, identification: bool, derivatives: bool, values: dict[str, float]
) -> Interface:
    """Read the interface off a kernel's equations; ``values`` replaces start values by id."""
    e, at = kernel.equations, block_offsets(kernel)
    variables = [*_inputs(e, at["u"]), *_states(e, at["x"], values), *_parameters(e, at["p"], values, identification)]
    variables += _outputs(e, at["y"])
    if derivatives:
        variables += _derivatives(e, at["dx"], at["x"])
    if identification:
        variables += [*_slopes(e, at["slope"]), *_sensitivities(kernel, at["dy"])]
    return Interface(
        kernel=kernel,
        identifier=identifier,
        title=e.title,
        variables=tuple(variables),
        identification=identification,
        derivatives=derivatives,
    )


def _inputs(e: Equations, at: int) -> Iterator[Variable]:
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
            start=0.0,
        )


def _states(e: Equations, at: int, values: dict[str, float]) -> Iterator[Variable]:
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


def _parameters(e: Equations, at: int, values: dict[str, float], identification: bool) -> Iterator[Variable]:
    for i, x in enumerate(e.parameters, start=at):
        start = float(values.get(x.id, x.initial))
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
            nominal=abs(start) or 1.0,
        )


def _range(x: Quantity, start: float, identification: bool) -> tuple[float, float]:
    """Bounds that the FMU holds its user to: the quantity's own; a fit minds them itself and needs only the sign."""
    if identification:
        return (1e-300 if x.scale == "log" else -math.inf), math.inf
    return min(x.lower, start), max(x.upper, start)


def _outputs(e: Equations, at: int) -> Iterator[Variable]:
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


def _derivatives(e: Equations, at: int, states_at: int) -> Iterator[Variable]:
    for i, x in enumerate(e.states):
        unit = x.unit[:-2] + "/s^2" if x.unit.endswith("/s") else f"{x.unit}/s" if x.unit != "1" else "1/s"
        yield Variable(
            reference=at + i,
            id=f"der({x.id})",
            name=f"der({structured_name(e, x.id, x.structured)})",
            role="derivative",
            causality="local",
            variability="continuous",
            unit=unit,
            description=f"rate of change of {x.description}",
            initial="calculated",
            derivative_of=states_at + i,
        )


def _slopes(e: Equations, at: int) -> Iterator[Variable]:
    for i, x in enumerate(e.inputs, start=at):
        if x.id != GAIN:
            yield Variable(
                reference=i,
                id=f"{x.id}_slope",
                name=f"{structured_name(e, x.id, x.structured)}_slope",
                role="slope",
                causality="input",
                variability="continuous",
                unit=f"{x.unit}/s" if "/" not in x.unit else "1",
                description=f"rate of change of {x.description} during the step; 0 holds it",
                start=0.0,
            )


def _sensitivities(kernel: Kernel, at: int) -> Iterator[Variable]:
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
                unit="1",
                description=f"derivative of {output.description} with respect to {column}, SI units",
                initial="calculated",
            )
