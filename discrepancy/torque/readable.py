"""Which effects can be read from motion to torque, and the load along a measured motion.

Effects and equations in; the readable effects, and equations whose states follow the motion out.

The load L = w − F, what friction leaves of the torque, is by the equation of motion what inertia, gravity and spring
take. From torque to motion it is written in the torque τ. From motion to torque it has to be written in the motion:
with q̈ = f₀ + f₁·τ, every τ in the rate of change of a state becomes (q̈ − f₀)/f₁.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import sympy as sp

from haptid.identification.simulators.inverse_dynamics import invertible, needed_torque
from haptid.model.effects import effect as sym
from haptid.model.effects.effect import Effect
from haptid.model.equations.equations import Equations, Input
from haptid.model.friction.registry import law_named
from haptid.model.joint.locked_joint import joint_equations


def follows_load(effect: Effect) -> bool:
    """Whether states of an effect depend on the torque, and only through the load.

    A state of the torque's path, as a lag of the amplifier, or one that the joint's acceleration drives acts on the
    acceleration itself, and the motion does not tell the torque.

    Parameters
    ----------
    effect
        Effect of the catalogue.

    Returns
    -------
    bool
        False for an effect without states.
    """
    symbols = {s for x in effect.states for s in sp.sympify(x.rhs).free_symbols}
    return sym.load in symbols and not symbols & {sym.w, sym.a, sym.tau}


def delays_torque(effect: Effect) -> bool:
    """Whether an effect lets the torque arrive late, and changes no slow torque.

    Such an effect is followed forward from the recorded torque. One that changes the size of the torque is not: a model
    whose torque and whose inertia are both small would explain any motion.

    Parameters
    ----------
    effect
        Effect of the catalogue.

    Returns
    -------
    bool
        True if it acts on the input, lives in frequency, and no state of it depends on the motion or the friction.
    """
    on_path = effect.side == "input" and effect.lives_in == "frequency"
    symbols = {s for x in effect.states for s in sp.sympify(x.rhs).free_symbols}
    # What the motion drives as well, as an elastic tendon, is more than a path of the torque.
    return on_path and not symbols & {sym.q, sym.v, sym.z, sym.a}


def with_measured_load(equations: Equations) -> Equations:
    """Write the rates of change of the states behind position and speed in the acceleration instead of the torque.

    Parameters
    ----------
    equations
        Equations of a single joint with the torque as input; its effects with states of the torque `follows_load`.

    Returns
    -------
    Equations
        With the acceleration ``a`` as a second input; the same object where no state depends on the torque.
    """
    tau = equations.inputs[0].symbol
    behind = equations.rhs[2:]
    if not any(sp.sympify(f).has(tau) for f in behind):
        return equations
    needed = needed_torque(equations, sym.a)
    measured = Input(id=sym.a.name, unit=f"{equations.states[0].unit}/s^2", description="acceleration")
    return replace(
        equations,
        inputs=(*equations.inputs, measured),
        rhs=(*equations.rhs[:2], *(sp.sympify(f).subs(tau, needed) for f in behind)),
    )


def readable(catalogue: Mapping[str, Effect], base: Equations, *, prismatic: bool) -> dict[str, Effect]:
    """Return the catalogue effects whose equations can be read from motion to torque.

    Parameters
    ----------
    catalogue
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
    kept = {}
    for key, effect in catalogue.items():
        if delays_torque(effect):
            kept[key] = effect
            continue
        # These sides act on the path of the torque or of the reading; leaving them out first saves building their
        # equations.
        if effect.random or effect.side in ("output", "time", "input"):
            continue
        if effect.friction_slots - law.slots:
            continue
        extended = joint_equations(
            joint, parameters=base.parameters, effects=[effect], prismatic=prismatic, friction=law.id
        )
        if invertible(with_measured_load(extended) if follows_load(effect) else extended):
            kept[key] = effect
    return kept
