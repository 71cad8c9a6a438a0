"""Invert a joint's equations with effects: forward `Equations` in, `Equations` from measured motion to torque out.

With q̈ = f₀ + f₁·τ, the torque that a motion needs is τ = (q̈ − f₀)/f₁. The measured position and speed drive the
states of friction and of effects. Effects on the path of the torque or of the reading cannot be inverted in this way.
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
    """Return the equations from measured motion to torque.

    Parameters
    ----------
    equations
        Equations of one joint, from torque to position.

    Returns
    -------
    Equations or None
        Equations with the inputs q, v and a, the states of friction and of effects, and the output τ. None where the
        output is not the position, where the acceleration is not linear in τ, or where a state depends on τ.
    """
    tau = equations.inputs[0].symbol
    acceleration = sp.sympify(equations.rhs[1])
    slope = sp.diff(acceleration, tau)
    # τ must enter the acceleration linearly and nothing else; then the slope f₁ is free of τ, as are the other states.
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
    """Return the catalogue effects whose equations can be read from motion to torque.

    Parameters
    ----------
    entries
        Catalogue effects by key.
    base
        Equations of the nominal model.
    prismatic
        Whether the joint is prismatic.

    Returns
    -------
    dict
        Effects by key.
    """
    joint, law = base.joints[0], law_named(base.friction[0])
    found = {}
    for key, effect in entries.items():
        # These sides act on the path of the torque or of the reading; leaving them out first saves building their
        # equations.
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
