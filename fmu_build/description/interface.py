"""The variables that an FMU shows and the flat buffer that holds them: `Kernel` in, `Interface` out.

All real variables of an instance are one array of doubles; the value reference is the index into it. Blocks, in order:

u (n_u), slope (n_u), x (n_x), p (n_p), y (n_y), dx (n_x), dy (n_y·n_c), S (n_x·n_c), h (1)

with n_c = n_p + n_x directions of the sensitivities, or 0, and the longest inner step h [s]. dy and S are row-major:
the derivatives of the outputs and of the states (rows) along each direction (columns). The buffer has all blocks, also
those that an FMU does not show.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import sympy as sp

from haptid.fmu_build.description.variables import (
    Variable,
    derivative_variables,
    inner_step_variable,
    input_variables,
    output_variables,
    parameter_variables,
    sensitivity_variables,
    slope_variables,
    state_variables,
)
from haptid.model.equations.equations import Equations
from haptid.model.kernel.generate import Kernel
from haptid.support.numbers import choose_unit

TORQUE_UNIT = "N m"


@dataclass(frozen=True, slots=True, kw_only=True)
class Interface:
    """Hold the variables that an FMU shows of its kernel.

    Parameters
    ----------
    kernel
        Generated C source with its equations.
    identifier
        Model identifier, a C identifier.
    title
        Name of the model for people.
    variables
        Shown variables, by ascending value reference within each block.
    identification
        Whether slopes, sensitivities and the inner step are shown.
    derivatives
        Whether the state derivatives are shown (the native FMU).
    plain_units
        Units in which numbers are shown as they are, without a display unit.
    """

    kernel: Kernel
    identifier: str
    title: str
    variables: tuple[Variable, ...]
    identification: bool
    derivatives: bool
    plain_units: frozenset[str] = frozenset()

    @property
    def equations(self) -> Equations:
        """The equations of the kernel."""
        return self.kernel.equations

    @property
    def offsets(self) -> dict[str, int]:
        """Index of the first entry of each block by name; ``end`` is the length of the buffer."""
        return block_offsets(self.kernel)

    def of_role(self, role: str) -> tuple[Variable, ...]:
        """Return the variables of one role, in the order of the value references.

        Parameters
        ----------
        role
            Role of a variable, as ``input`` or ``state``.

        Returns
        -------
        tuple of Variable
            Empty where no variable has the role.
        """
        return tuple(v for v in self.variables if v.role == role)

    def by_id(self, id: str) -> Variable:
        """Find the variable of a state, input, output or parameter.

        Parameters
        ----------
        id
            Id in the equations.

        Returns
        -------
        Variable
            The first with this id.

        Raises
        ------
        KeyError
            With the known ids.
        """
        for variable in self.variables:
            if variable.id == id:
                return variable
        msg = f"{self.identifier} has no variable {id!r}; it has {[v.id for v in self.variables]}"
        raise KeyError(msg)

    @property
    def start(self) -> tuple[float, ...]:
        """Initial content of the buffer, SI units, of length ``offsets["end"]``.

        S = ∂x/∂(p, x₀) starts as (0, I): the initial states are directions of the sensitivities.
        """
        values = [0.0] * self.offsets["end"]
        for variable in self.variables:
            if variable.start is not None:
                values[variable.reference] = variable.start
        values[self.offsets["h"]] = self.kernel.step
        columns, parameters = len(self.kernel.columns), len(self.equations.parameters)
        for i in range(len(self.equations.states) if columns else 0):
            values[self.offsets["S"] + i * columns + parameters + i] = 1.0
        return tuple(values)

    @property
    def stale_from(self) -> int:
        """First value reference whose setting makes the outputs stale.

        0, the first input, where an output depends on an input; else the first state, behind inputs and slopes.
        """
        e = self.equations
        used: set[sp.Symbol] = {u.symbol for u in e.inputs}
        # Outputs may use inputs through definitions, and these use earlier ones: one pass in order finds every chain.
        for symbol, formula in e.definitions:
            if formula.free_symbols & used:
                used.add(symbol)
        through = any(sp.sympify(o.expression).free_symbols & used for o in e.outputs)
        return 0 if through else self.offsets["x"]

    @property
    def orderings(self) -> tuple[tuple[int, int], ...]:
        """Pairs of value references (a, b) with a ≥ b required before a step, as of Fs and Fc.

        Empty for an identification FMU: the fit keeps the order itself, and its trial steps may violate it.
        """
        pairs = () if self.identification else self.equations.orderings
        return tuple((self.by_id(a).reference, self.by_id(b).reference) for a, b in pairs)


def block_offsets(kernel: Kernel) -> dict[str, int]:
    """Return the index of the first entry of each block of the buffer.

    Parameters
    ----------
    kernel
        Kernel whose equations and sensitivity directions give the lengths.

    Returns
    -------
    dict
        Index by block, in the order of the buffer, and under ``end`` the length of the buffer.
    """
    e, columns = kernel.equations, len(kernel.columns)
    nx, nu, n_p, ny = len(e.states), len(e.inputs), len(e.parameters), len(e.outputs)
    lengths = {
        "u": nu,
        "slope": nu,
        "x": nx,
        "p": n_p,
        "y": ny,
        "dx": nx,
        "dy": ny * columns,
        "S": nx * columns,
        "h": 1,
    }
    offsets, total = {}, 0
    for name, length in lengths.items():
        offsets[name] = total
        total += length
    return {**offsets, "end": total}


def interface_of(
    kernel: Kernel,
    *,
    identifier: str,
    identification: bool,
    derivatives: bool,
    values: dict[str, float],
    largest_torque: float = 0.0,
) -> Interface:
    """Build the interface of a kernel.

    Parameters
    ----------
    kernel
        Kernel with the equations.
    identifier
        Model identifier, a C identifier.
    identification
        Whether to show slopes, sensitivities and the inner step.
    derivatives
        Whether to show the state derivatives.
    values
        Start values of parameters and states by id, SI units; the first guesses where absent.
    largest_torque
        Largest torque that the drives apply [N m]; 0 where it is not known.

    Returns
    -------
    Interface
        Variables in the order in which the model description lists them.
    """
    e, at = kernel.equations, block_offsets(kernel)
    variables = [
        *input_variables(e, at["u"]),
        *state_variables(e, at["x"], values),
        *parameter_variables(e, at["p"], values, identification),
    ]
    variables += output_variables(e, at["y"])
    if derivatives:
        variables += derivative_variables(e, at["dx"], at["x"])
    if identification:
        variables += [*slope_variables(e, at["slope"]), *sensitivity_variables(kernel, at["dy"])]
        variables.append(inner_step_variable(kernel.step, at["h"]))
    return Interface(
        kernel=kernel,
        identifier=identifier,
        title=e.title,
        variables=tuple(variables),
        identification=identification,
        derivatives=derivatives,
        plain_units=_plain_units(variables, largest_torque),
    )


def _plain_units(variables: Sequence[Variable], largest_torque: float) -> frozenset[str]:
    """Choose the units without a display unit: torques of a machine whose drive or parameters reach 1 N m.

    40 N m were 40000 mN m in every simulator.
    """
    starts = [abs(v.start) for v in variables if v.unit == TORQUE_UNIT and v.start is not None]
    unit, _ = choose_unit(max([largest_torque, *starts]), TORQUE_UNIT)
    return frozenset({TORQUE_UNIT} if unit == TORQUE_UNIT else ())
