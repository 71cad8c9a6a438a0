"""A joint's equations with effects, read from measured motion to torque, for runs recorded under position control.

With q̈ = f₀ + f₁·τ, the torque that a motion needs is τ = (q̈ − f₀)/f₁; the bristle and the effects' own states are
driven by the measured position and speed. Effects on the path of the torque or the reading cannot be read this way.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import sympy as sp

from haptid.model.effects.effect import Effect
from haptid.model.effects.effect import q as position
from haptid.model.equations.equations import Equations, Input, Output
from haptid.model.joint.locked_joint import joint_equations


def inverse_equations(equations: Equations) -> Equations | None:
    """Return inputs q, v, a; states: the bristle and those of the effects; output τ. None where that is impossible."""
    tau = equations.inputs[0].symbol
    acceleration = sp.sympify(equations.rhs[1])
    slope = sp.diff(acceleration, tau)
    inner = (*equations.rhs[2:], *equations.rates[2:], slope)
    if equations.outputs[0].expression != position or any(sp.sympify(e).has(tau) for e in inner):
        return None
    q, v = equations.states[:2]
    a = Input(id="a", unit=f"{v.unit}/s", description="measured acceleration")
    friction = {x.id: x.initial for x in equations.parameters}
    bristle = replace(equations.states[2], nominal=max(friction["Fc"] / friction["sigma0"], 1e-12))
    return replace(
        equations,
        name=f"{equations.name}_inverse",
        title=f"{equations.title}, from measured motion to torque",
        joints=(),
        states=(bristle, *equations.states[3:]),
        inputs=(
            Input(id=q.id, unit=q.unit, description="measured position"),
            Input(id=v.id, unit=v.unit, description="measured speed"),
            a,
        ),
        outputs=(
            Output(
                id="torque",
                unit=equations.inputs[0].unit,
                description="torque that the measured motion needs",
                expression=(a.symbol - acceleration.subs(tau, 0)) / slope,
            ),
        ),
        rhs=equations.rhs[2:],
        rates=equations.rates[2:],
    )


def readable(entries: Mapping[str, Effect], base: Equations, *, prismatic: bool) -> dict[str, Effect]:
    """Return the entries of the catalogue whose equations can be read from motion to torque."""
    joint = base.joints[0]
    found = {}
    for key, effect in entries.items():
        if effect.random or effect.side in ("output", "time", "input"):
            continue
        made = joint_equations(joint, parameters=base.parameters, effects=[effect], prismatic=prismatic)
        if inverse_equations(made) is not None:
            found[key] = effect
    return found
