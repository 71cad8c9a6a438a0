"""An effect of the catalogue: what it adds to the equation of a joint, as formulas in the standard symbols.

The standard symbols are ``t`` [s], ``q``, ``v``, ``z`` (position, speed, bristle), ``w`` (torque that reaches the
joint, as built so far; the command ``Kp·tau`` at first), ``a`` (acceleration as built so far), ``y`` (reading as built
so far), and every parameter and state by its id.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import sympy as sp

from model.equations import TIME, State
from model.quantity import Quantity

q, v, z, w, a, y, tau = (sp.Symbol(name, real=True) for name in ("q", "v", "z", "w", "a", "y", "tau"))
t = TIME


@dataclass(frozen=True, slots=True, kw_only=True)
class EffectState:
    """A state that an effect brings along: ẋ = rhs, with the relaxation rate −∂rhs/∂x where it may be stiff."""

    state: State
    rhs: sp.Expr
    rate: sp.Expr = sp.S.Zero


@dataclass(frozen=True, slots=True, kw_only=True)
class Effect:
    """One entry of the catalogue, as data.

    Parameters
    ----------
    id, title, formula
        Fixed id, name in words, formula as a reader writes it.
    lives_in
        The variable in which the effect lives: ``position``, ``velocity``, ``torque``, ``time``, ``reversal``,
        ``frequency``, ``cycle``.
    side
        ``torque``, ``input``, ``output``, ``friction``, ``time`` or ``random``.
    parameters
        Amplitude first: the quantity that is zero in the base model (its ``initial`` is a typical size, its bounds hold
        0 or reach close to it); the rest are shape parameters.
    shapes
        Grid of shape parameters at which the signature is taken: tuples ``(id, values)``.
    neutral
        Values of the parameters at which the effect vanishes.
    rivals
        Ids of effects that are easily mistaken for this one.
    torque
        Torque added to the right-hand side.
    input, output, acceleration
        The new ``w``, ``y``, ``a`` in terms of the old.
    friction_level, coulomb_level, viscous_level
        Factors on g(v), on Fc and Fs alone and on σ2.
    stribeck_velocity
        Speed seen by the Stribeck curve.
    inertia_factor
        m(q) in M·m(q)·q̈ + ½·M·m'(q)·q̇².
    time_rate
        Factor between the machine's and the data's clock.
    states
        Extra states.
    """

    id: str
    title: str
    formula: str
    lives_in: str
    side: str
    parameters: tuple[Quantity, ...]
    neutral: dict[str, float] = field(default_factory=dict)
    shapes: tuple[tuple[str, tuple[float, ...]], ...] = ()
    rivals: tuple[str, ...] = ()
    torque: sp.Expr | None = None
    input: sp.Expr | None = None
    output: sp.Expr | None = None
    acceleration: sp.Expr | None = None
    friction_level: sp.Expr | None = None
    coulomb_level: sp.Expr | None = None
    viscous_level: sp.Expr | None = None
    stribeck_velocity: sp.Expr | None = None
    inertia_factor: sp.Expr | None = None
    time_rate: sp.Expr | None = None
    states: tuple[EffectState, ...] = ()

    @property
    def random(self) -> bool:
        """Whether the effect is random and enters the likelihood instead of the equation."""
        return self.side == "random"
