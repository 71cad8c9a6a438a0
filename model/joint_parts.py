"""What each joint brings to the equations of a device: parameters, states, inputs, outputs, friction, net torque."""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp

from model.algebra import position_symbol, velocity_symbol
from model.device import Device, Guess
from model.equations import Input, Output, State
from model.lugre import LuGre, LuGreParameters, lugre
from model.parameters import TABLE, Row
from model.quantity import Normal, Quantity

INERTIAL = ("inertia", "gravity_cos", "gravity_sin")
"""Parameters of a locked joint that come from the rigid bodies."""


def joint_quantities(device: Device, joint: int, *, suffix: str = "", prefix: str = "") -> tuple[Quantity, ...]:
    """Return drive, spring and friction parameters of one joint: the device's guesses, else the table's defaults."""
    given, slides = device.joints[joint].parameters, device.joints[joint].prismatic
    return tuple(_quantity(row, given.get(row.id), slides, suffix, prefix) for row in TABLE if row.id not in INERTIAL)


def _quantity(row: Row, guess: Guess | None, slides: bool, suffix: str, prefix: str) -> Quantity:
    if guess is None:
        guess = Guess(initial=row.initial, lower=row.lower, upper=row.upper, fixed=row.fixed)
    return Quantity(
        id=row.id + suffix,
        unit=row.prismatic_unit if slides else row.unit,
        description=row.description,
        initial=guess.initial,
        lower=max(guess.lower, row.lower),
        upper=min(guess.upper, row.upper),
        prior=Normal(mean=guess.initial, std=guess.std) if guess.std else None,
        fixed=guess.fixed,
        scale=row.scale,
        structured=prefix + row.structured,
    )


def joint_states(device: Device, joints: Sequence[int]) -> tuple[State, ...]:
    """Return positions, velocities and bristle deflections, joint by joint within each."""
    units = {j: "m" if device.joints[j].prismatic else "rad" for j in joints}
    return (
        *(_state(f"q{j}", units[j], f"position of joint {j}", f"joint{j}.position") for j in joints),
        *(_state(f"v{j}", f"{units[j]}/s", f"velocity of joint {j}", f"joint{j}.velocity") for j in joints),
        *(_bristle(j, units[j]) for j in joints),
    )


def _state(id: str, unit: str, description: str, structured: str) -> State:
    return State(id=id, unit=unit, description=description, structured=structured)


def _bristle(j: int, unit: str) -> State:
    name = f"joint{j}.friction.bristle"
    return State(id=f"z{j}", unit=unit, description=f"bristle deflection of joint {j}", nominal=1e-3, structured=name)


def joint_inputs(device: Device, joints: Sequence[int]) -> tuple[Input, ...]:
    """Return the commanded torques (forces)."""
    result = []
    for j in joints:
        what, unit = ("force", "N") if device.joints[j].prismatic else ("torque", "N m")
        text = f"commanded {what} of joint {j}"
        result.append(Input(id=f"tau{j}", unit=unit, description=text, structured=f"joint{j}.torque"))
    return tuple(result)


def joint_outputs(device: Device, joints: Sequence[int]) -> tuple[Output, ...]:
    """Return the position readings."""
    return tuple(
        Output(
            id=f"y{j}",
            unit="m" if device.joints[j].prismatic else "rad",
            description=f"position reading of joint {j}",
            expression=position_symbol(j),
            structured=f"joint{j}.reading",
        )
        for j in joints
    )


def joint_friction(joint: int) -> LuGre:
    """Return LuGre friction of one of several joints, its parameters' ids ending in ``_<joint>``."""
    p = {id: _symbol(f"{id}_{joint}") for id in ("sigma0", "sigma1", "sigma2", "vs", "Fs", "Fc")}
    return lugre(velocity_symbol(joint), _symbol(f"z{joint}"), LuGreParameters(**p))


def net_torque(joint: int) -> sp.Expr:
    """Return Kp·τ − Ks·(q − epos) − friction of one of several joints."""
    Kp, tau, Ks, epos = (_symbol(name) for name in (f"Kp_{joint}", f"tau{joint}", f"Ks_{joint}", f"epos_{joint}"))
    return Kp * tau - Ks * (position_symbol(joint) - epos) - joint_friction(joint).force


def _symbol(name: str) -> sp.Symbol:
    return sp.Symbol(name, real=True)
