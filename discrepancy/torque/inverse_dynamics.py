"""A joint's equations with effects, read from measured motion to torque, for runs recorded under position control.

With q̈ = f₀ + f₁·τ, the torque that a motion needs is τ = (q̈ − f₀)/f₁; the states of friction and the effects' own are
driven by the measured position and speed. Effects on the path of the torque or the reading cannot be read this way.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import sympy as sp

from haptid.model.effects.effect import Effect
from haptid.model.effects.effect import q as position
from haptid.model.equations.equations import Equations, Input, Output
from haptid.model.friction.registry import law_named
from haptid.model.joint.locked_joint import joint_equations


def inverse_equations(equations: Equations) -> Equations | None:
    """Return inputs q, v, a; states: those of friction and of the effects; output τ. None where that is impossible."""
    tau = equations.inputs[0].symbol
    acceleration = sp.sympify(equations.rhs[1])
    slope = sp.diff(acceleration, tau)
    inner = (*equations.rhs[2:], *equations.rates[2:], slope)
    if equations.outputs[0].expression != position or any(sp.sympify(e).has(tau) for e in inner):
        return None
    q, v = equations.states[:2]
    a = Input(id="a", unit=f"{v.unit}/s", description="measured acceleration")
    sizes = law_named(equations.friction[0]).nominal({x.id: x.initial for x in equations.parameters})
    first = len(sizes) + 2
    friction = (replace(s, nominal=max(n, 1e-12)) for s, n in zip(equations.states[2:first], sizes, strict=True))
    return replace(
        equations,
        name=f"{equations.name}_inverse",
        title=f"{equations.title}, from measured motion to torque",
        joints=(),
        states=(*friction, *equations.states[first:]),
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
    joint, law = base.joints[0], law_named(base.friction[0])
    found = {}
    for key, effect in entries.items():
        if effect.random or effect.side in ("output", "time", "input"):
            continue
        if effect.friction_slots - law.slots:
            continue
        made = joint_equations(
            joint, parameters=base.parameters, effects=[effect], prismatic=prismatic, friction=law.id
        )
        if inverse_equations(made) is not None:
            found[key] = effect
    return found
