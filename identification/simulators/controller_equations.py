"""The stated controller as equations, for its FMU: `Controller` and sample time in, `Equations` out.

The law samples: v̂_k = v̂_{k−1} + h/(h + T)·((y_k − y_{k−1})/h − v̂_{k−1}). With v̂_k = (y_k − g_k)/(h + T) it reads
g_{k+1} = g_k + h/(h + T)·(y_k − g_k), which is what ġ = r·(y − g), r = ln(1 + h/T)/h, does exactly over a step h with y
held. So the FMU, stepped at the sample time, gives the torques of the sampled law to rounding. Its parameters are r and
the time h + T.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import sympy as sp

from haptid.identification.simulators.closed_loop import Controller
from haptid.model.equations.equations import Equations, Input, Output, State
from haptid.model.equations.fmu_names import CONTROLLER, of_joint
from haptid.model.equations.quantity import Quantity

SHORTEST_FILTER_S = 1e-9
"""Time constant of the filter where the controller has none, so that ln(1 + h/T) stays finite [s]."""


def controller_equations(controller: Controller, sample_s: float, joints: Sequence[int]) -> Equations:
    """Write the sampled controller as differential equations.

    Parameters
    ----------
    controller
        Gains and time constant of the filter.
    sample_s
        Sample time h [s].
    joints
        Numbers of the joints, in the order of the gains.

    Returns
    -------
    Equations
        Inputs: reference positions [rad], then position readings [rad]. Outputs: torques [N m]. States: the filters g
        [rad]; v̂ starts at 0 where they start at the first readings.
    """
    rate, span = sp.Symbol("filter_rate", real=True), sp.Symbol("velocity_time", real=True)
    wanted, readings, filters = (
        [sp.Symbol(f"{name}{j}", real=True) for j in joints] for name in ("reference", "reading", "filtered")
    )
    gains = [(sp.Symbol(f"Kp_{j}", real=True), sp.Symbol(f"Kd_{j}", real=True)) for j in joints]
    law = zip(gains, wanted, readings, filters, strict=True)
    torques = [p * (r - y) - d * (y - g) / span for (p, d), r, y, g in law]
    return Equations(
        name="controller",
        title=f"position controller of joints {', '.join(map(str, joints))}",
        joints=(),
        states=tuple(
            State(id=g.name, unit="rad", description=f"filtered reading of joint {j}", structured=_name(j, "filter"))
            for j, g in zip(joints, filters, strict=True)
        ),
        inputs=(
            *(_input(r, j, "wanted position", "reference") for j, r in zip(joints, wanted, strict=True)),
            *(_input(y, j, "position reading", "reading") for j, y in zip(joints, readings, strict=True)),
        ),
        outputs=tuple(
            Output(
                id=f"torque{j}",
                unit="N m",
                description=f"commanded torque of joint {j}",
                expression=torque,
                structured=_name(j, "torque"),
            )
            for j, torque in zip(joints, torques, strict=True)
        ),
        parameters=(*_gain_rows(controller, joints), *_times(controller, sample_s)),
        rhs=tuple(rate * (y - g) for y, g in zip(readings, filters, strict=True)),
        rates=(rate,) * len(filters),
        notes=(controller.law,) if controller.law else (),
    )


def _name(joint: int, part: str) -> str:
    return of_joint(joint, CONTROLLER.format(part=part))


def _input(symbol: sp.Symbol, joint: int, what: str, part: str) -> Input:
    return Input(id=symbol.name, unit="rad", description=f"{what} of joint {joint}", structured=_name(joint, part))


def _gain_rows(controller: Controller, joints: Sequence[int]) -> list[Quantity]:
    rows = []
    for id, unit, what, values in (
        ("Kp", "N m/rad", "proportional", controller.proportional),
        ("Kd", "N m s/rad", "derivative", controller.derivative),
    ):
        for joint, value in zip(joints, np.asarray(values), strict=True):
            text = f"{what} gain of joint {joint}"
            rows.append(
                Quantity(
                    id=f"{id}_{joint}", unit=unit, description=text, initial=float(value), structured=_name(joint, id)
                )
            )
    return rows


def _times(controller: Controller, sample_s: float) -> tuple[Quantity, Quantity]:
    T = max(controller.filter_s, SHORTEST_FILTER_S)
    return (
        Quantity(
            id="filter_rate",
            unit="1/s",
            description=f"ln(1 + h/T)/h for the sample time h = {sample_s:.6g} s and the time constant T = {T:.6g} s",
            initial=float(np.log1p(sample_s / T)) / sample_s,
            lower=0.0,
        ),
        Quantity(
            id="velocity_time",
            unit="s",
            description="h + T, over which the reading's change is the velocity",
            initial=sample_s + T,
            lower=SHORTEST_FILTER_S,
        ),
    )
