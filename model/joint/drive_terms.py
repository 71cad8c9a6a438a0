"""The torque of a drive in symbols: `Drive` in; inputs, parameters, torque and states of the joint's equation out.

With the command c, recorded or c = clip(gain·(r − q) − …, ±limit) through the controller, and e = 1, or e = 0 while the
motor is let go:

- torque: τ = e·c
- current: τ = e·kt·c
- voltage: τ = e·kt·(c − kt·v)/R
- duty: τ = e·kt·(c·V − kt·v)/R with the supply V

A motor that is let go has no back-EMF either: its circuit is open.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from typing import Any

import numpy as np
import sympy as sp
from numpy.typing import NDArray

from haptid.model.effects import effect as sym
from haptid.model.equations.drive import Controller, Drive
from haptid.model.equations.equations import Input, State
from haptid.model.equations.fmu_names import CONTROLLER, DRIVE
from haptid.model.equations.joint_parameters import DRIVE_TABLE, quantities, sliding
from haptid.model.equations.quantity import Quantity

REFERENCE, SUPPLY, ENABLED, GAIN = "reference", "supply", "enabled", "controller_gain"
"""Ids of the inputs beside the command."""
LIMIT, DERIVATIVE_GAIN, INTEGRAL_GAIN = "controller_limit", "controller_derivative_gain", "controller_integral_gain"
"""Ids of the controller's parameters, which are known."""
DRIVE_PARAMETERS = frozenset({*(row.id for row in DRIVE_TABLE), LIMIT, DERIVATIVE_GAIN, INTEGRAL_GAIN})
"""Ids of all parameters that a drive and its controller may have."""
INTEGRAL = "controller_integral"
"""Id of the state of a controller with an integral term."""
COMMAND_UNITS = {"torque": "N m", "current": "A", "voltage": "V", "duty": "1"}
"""Unit of the command by kind of drive; a prismatic joint has N in place of N m."""


def _symbol(id: str) -> sp.Symbol:
    return sp.Symbol(id, real=True)


def drive_inputs(drive: Drive, *, prismatic: bool = False) -> tuple[Input, ...]:
    """Return the inputs of a driven joint, in the order in which a run holds their columns.

    Parameters
    ----------
    drive
        Drive of the joint.
    prismatic
        Whether the joint slides.

    Returns
    -------
    tuple of Input
        Command or reference first; then the supply of a duty, the switch, and the gain of the controller. An FMU
        starts with the motor held and the stated gain: driven by its reference alone it would be limp at zeros.
    """
    unit, length = _command_unit(drive, prismatic), "m" if prismatic else "rad"
    inputs = []
    if drive.is_closed:
        name = CONTROLLER.format(part=REFERENCE)
        inputs.append(Input(id=REFERENCE, unit=length, description="reference position", structured=name))
    else:
        name = DRIVE.format(part=drive.kind)
        inputs.append(Input(id=drive.kind, unit=unit, description=f"commanded {drive.kind}", structured=name))
    if drive.kind == "duty":
        name = DRIVE.format(part=SUPPLY)
        text = "supply voltage; without it the motor makes no torque"
        inputs.append(Input(id=SUPPLY, unit="V", description=text, structured=name))
    name, text = DRIVE.format(part=ENABLED), "1; 0 while the motor is let go"
    inputs.append(Input(id=ENABLED, unit="1", description=text, structured=name, start=1.0))
    if drive.controller is not None:
        name, text, gain = CONTROLLER.format(part="gain"), "gain of the controller", drive.controller.gain
        inputs.append(Input(id=GAIN, unit=_per(unit, length), description=text, structured=name, start=gain))
    return tuple(inputs)


def drive_quantities(drive: Drive, *, prismatic: bool = False) -> tuple[Quantity, ...]:
    """Return the parameters of a drive with default ranges, then those of its controller, which are fixed.

    Parameters
    ----------
    drive
        Drive of the joint.
    prismatic
        Whether the joint slides.

    Returns
    -------
    tuple of Quantity
        The drive's own: nothing for a torque, the torque constant for a current, and the winding resistance too for
        voltage and duty. Then those of the controller.
    """
    needed = {"torque": 0, "current": 1, "voltage": 2, "duty": 2}[drive.kind]
    own = quantities(DRIVE_TABLE[:needed], prismatic=prismatic)
    if drive.controller is None:
        return own
    return (*own, *_controller_quantities(drive.controller, _command_unit(drive, prismatic), prismatic))


def drive_torque(drive: Drive) -> sp.Expr:
    """Return the torque of a drive in the symbols of its inputs and parameters, and q and v.

    Parameters
    ----------
    drive
        Drive of the joint.

    Returns
    -------
    sympy.Expr
        τ [N m] ([N]), which takes the place of the commanded torque in the joint's equation.
    """
    command = _closed_command(drive.controller) if drive.controller else _symbol(drive.kind)
    constant, resistance, enabled = _symbol("torque_constant"), _symbol("resistance_ohm"), _symbol(ENABLED)
    if drive.kind == "torque":
        return enabled * command
    if drive.kind == "current":
        return enabled * constant * command
    voltage = command * _symbol(SUPPLY) if drive.kind == "duty" else command
    return enabled * constant * (voltage - constant * sym.v) / resistance


def drive_damping(drive: Drive) -> sp.Expr:
    """Return the back-EMF's share in −∂τ/∂v [N m s/rad], for the relaxation rate of the speed.

    Parameters
    ----------
    drive
        Drive of the joint.

    Returns
    -------
    sympy.Expr
        e·kt²/R for voltage and duty; 0 for torque and current.
    """
    if drive.kind in ("torque", "current"):
        return sp.S.Zero
    return _symbol(ENABLED) * _symbol("torque_constant") ** 2 / _symbol("resistance_ohm")


def drive_states(drive: Drive, *, prismatic: bool = False) -> tuple[tuple[State, sp.Expr], ...]:
    """Return the states of a drive with their rates of change: the integral of a ``pid`` controller.

    Parameters
    ----------
    drive
        Drive of the joint.
    prismatic
        Whether the joint slides.

    Returns
    -------
    tuple of (State, sympy.Expr)
        Integral [rad s] or [m s] of the error, with its rate; empty without a ``pid`` controller.
    """
    if drive.controller is None or drive.controller.kind != "pid":
        return ()
    unit = "m s" if prismatic else "rad s"
    name = CONTROLLER.format(part="integral")
    state = State(id=INTEGRAL, unit=unit, description="integral of the controller's error", structured=name)
    # The integral rests while the motor is let go, so that the joint does not jump when the motor holds it again.
    return ((state, _symbol(ENABLED) * (_symbol(REFERENCE) - sym.q)),)


def torque_along(
    drive: Drive,
    values: Mapping[str, float],
    inputs: Mapping[str, NDArray[np.float64]],
    q: NDArray[np.float64],
    v: NDArray[np.float64],
    t: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Compute the torque of a drive along a measured motion.

    Parameters
    ----------
    drive
        Drive of the joint.
    values
        Its parameters by id, in SI units.
    inputs
        Columns of a run by input id, shape (n_t,) each.
    q, v, t
        Position [rad], speed [rad/s] and time [s], shape (n_t,).

    Returns
    -------
    ndarray, shape (n_t,)
        τ [N m] ([N]).
    """
    names = tuple(x.id for x in drive_inputs(drive))
    parameters = tuple(x.id for x in drive_quantities(drive))
    integral = np.zeros_like(q)
    if drive_states(drive):
        error = inputs[ENABLED] * (inputs[REFERENCE] - q)
        integral[1:] = np.cumsum(error[:-1] * np.diff(t))
    numbers = [values[id] for id in parameters]
    columns = [inputs[id] for id in names]
    torque = _compile(drive, names, parameters)(q, v, integral, *columns, *numbers)
    return np.asarray(torque, dtype=np.float64)


@cache
def _compile(drive: Drive, names: tuple[str, ...], parameters: tuple[str, ...]) -> Callable[..., Any]:
    symbols = [sym.q, sym.v, _symbol(INTEGRAL), *(_symbol(id) for id in (*names, *parameters))]
    function: Callable[..., Any] = sp.lambdify(symbols, drive_torque(drive), "numpy")
    return function


def _closed_command(controller: Controller) -> sp.Expr:
    wanted = _symbol(GAIN) * (_symbol(REFERENCE) - sym.q)
    if controller.kind in ("pd", "pid"):
        wanted -= _symbol(DERIVATIVE_GAIN) * sym.v
    if controller.kind == "pid":
        wanted += _symbol(INTEGRAL_GAIN) * _symbol(INTEGRAL)
    limit = _symbol(LIMIT)
    return sp.Max(sp.Min(wanted, limit), -limit)


def _controller_quantities(controller: Controller, unit: str, prismatic: bool) -> tuple[Quantity, ...]:
    length = "m" if prismatic else "rad"
    rows = [(LIMIT, unit, "saturation of the controller", controller.limit, "limit")]
    if controller.kind in ("pd", "pid"):
        per = _per(unit, f"{length}/s")
        rows.append((DERIVATIVE_GAIN, per, "derivative gain", controller.derivative_gain, "derivative_gain"))
    if controller.kind == "pid":
        per = _per(unit, f"{length} s")
        rows.append((INTEGRAL_GAIN, per, "integral gain", controller.integral_gain, "integral_gain"))
    return tuple(
        Quantity(id=id, unit=unit, description=text, initial=value, fixed=True, structured=CONTROLLER.format(part=part))
        for id, unit, text, value, part in rows
    )


def _command_unit(drive: Drive, prismatic: bool) -> str:
    unit = COMMAND_UNITS[drive.kind]
    return sliding(unit) if prismatic else unit


def _per(unit: str, length: str) -> str:
    """Return ``unit`` per ``length``, as ``V s/rad``: at most one slash."""
    over, _, time = length.partition("/")
    top = " ".join(part for part in (unit if unit != "1" else "", time) if part) or "1"
    return f"{top}/{over}"
