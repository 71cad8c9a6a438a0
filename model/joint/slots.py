"""The slots of a joint's equation that effects fill, in the standard symbols.

Effects and a friction law come in, `Terms` goes out; `locked_joint` and `joint_in_device` assemble equations from it:

1. Check that the friction law has every slot that an effect uses.
2. Sort the effects by their place between command and reading.
3. Add one effect at a time: torque path, reading and acceleration are composed, torques are summed, factors multiplied.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import sympy as sp

from haptid.model.effects import effect as sym
from haptid.model.effects.effect import Effect, EffectState
from haptid.model.friction.law import Friction, FrictionLaw, Levels, Symbols
from haptid.support.errors import InputError


@dataclass(frozen=True, slots=True, kw_only=True)
class Terms:
    """The slots that effects fill, before the equation is assembled.

    Parameters
    ----------
    w, y, a
        Torque that reaches the joint, reading, and acceleration in terms of the rigid joint's acceleration ``a``.
    torque
        Torque added to the right-hand side [N m].
    friction_level, coulomb_level, kinetic_level, viscous_level
        Factors for the friction law, as in `model.effects.effect.Effect`.
    stribeck_velocity
        Speed in the Stribeck curve [rad/s].
    stribeck_argument
        Argument of the exponential in the Stribeck curve; None where no effect changes it.
    inertia_factor
        Factor m(q) on the inertia.
    time_rate
        Factor between the machine's and the data's clock.
    states
        States of all effects.
    """

    w: sp.Expr
    y: sp.Expr
    a: sp.Expr = sym.a
    torque: sp.Expr = sp.S.Zero
    friction_level: sp.Expr = sp.S.One
    coulomb_level: sp.Expr = sp.S.One
    kinetic_level: sp.Expr = sp.S.One
    viscous_level: sp.Expr = sp.S.One
    stribeck_velocity: sp.Expr = sym.v
    stribeck_argument: sp.Expr | None = None
    inertia_factor: sp.Expr = sp.S.One
    time_rate: sp.Expr = sp.S.One
    states: tuple[EffectState, ...] = ()

    def friction(self, law: FrictionLaw, p: Symbols) -> Friction:
        """Write out a friction law at the levels that effects set.

        Parameters
        ----------
        law
            Friction law of the joint.
        p
            Parameters of the joint by id.

        Returns
        -------
        Friction
            Torque, rates of change of the law's states and their relaxation rates.
        """
        return law.write(sym.v, p, self.levels)

    @property
    def levels(self) -> Levels:
        """Factors, Stribeck speed and argument for the friction law."""
        return Levels(
            friction=self.friction_level,
            coulomb=self.coulomb_level,
            kinetic=self.kinetic_level,
            viscous=self.viscous_level,
            stribeck_velocity=self.stribeck_velocity,
            stribeck_argument=self.stribeck_argument,
        )


def _add(terms: Terms, effect: Effect) -> Terms:
    """Add the formulas of one effect; its w, y and a are the torque path, reading and acceleration built so far."""
    one = sp.S.One
    known = {sym.w: terms.w, sym.y: terms.y}
    # torque, levels and states depend on the torque path before the effect itself
    states = tuple(replace(s, rhs=s.rhs.subs(sym.w, terms.w)) for s in effect.states)
    return replace(
        terms,
        w=terms.w if effect.input is None else effect.input.subs(known),
        y=terms.y if effect.output is None else effect.output.subs(known),
        a=terms.a if effect.acceleration is None else effect.acceleration.subs({sym.w: terms.w, sym.a: terms.a}),
        torque=terms.torque + (effect.torque or sp.S.Zero).subs(sym.w, terms.w),
        friction_level=terms.friction_level * (effect.friction_level or one).subs(sym.w, terms.w),
        coulomb_level=terms.coulomb_level * (effect.coulomb_level or one).subs(sym.w, terms.w),
        kinetic_level=terms.kinetic_level * (effect.kinetic_level or one).subs(sym.w, terms.w),
        viscous_level=terms.viscous_level * (effect.viscous_level or one),
        stribeck_velocity=effect.stribeck_velocity if effect.stribeck_velocity is not None else terms.stribeck_velocity,
        stribeck_argument=effect.stribeck_argument if effect.stribeck_argument is not None else terms.stribeck_argument,
        inertia_factor=terms.inertia_factor * (effect.inertia_factor or one),
        time_rate=terms.time_rate * (effect.time_rate or one),
        states=terms.states + states,
    )


def with_effects(effects: Sequence[Effect], kp: sp.Symbol, law: FrictionLaw) -> Terms:
    """Fill the slots of a joint's equation with effects.

    Parameters
    ----------
    effects
        Deterministic effects of the joint, in any order.
    kp
        Symbol of the plant gain; the torque path starts as kp·tau.
    law
        Friction law of the joint.

    Returns
    -------
    Terms
        All slots in the standard symbols.

    Raises
    ------
    InputError
        Where an effect needs a slot that the friction law of the joint lacks: the effect would have no influence.
    """
    for effect in effects:
        check_slots(effect, law)
    terms = Terms(w=kp * sym.tau, y=sym.q)
    # t is the time of the data; where the clocks differ, all other effects depend on the machine's time rate·t
    rate = sp.prod(effect.time_rate for effect in effects if effect.time_rate is not None)
    for effect in sorted(effects, key=lambda effect: effect.place):
        terms = _add(terms, effect if effect.time_rate is not None else sym.in_time(effect, rate * sym.t))
    own = sp.Symbol(law.roles.coulomb, real=True)
    return replace(terms, coulomb_level=terms.coulomb_level.subs(sym.coulomb, own))


def check_slots(effect: Effect, law: FrictionLaw) -> None:
    """Check that a friction law has all slots that an effect uses.

    Parameters
    ----------
    effect
        Effect to add.
    law
        Friction law of the joint.

    Raises
    ------
    InputError
        Where a slot is missing; the message names it.
    """
    missing = sorted(effect.friction_slots - law.slots)
    if missing:
        where, expected = f"effect {effect.key}", f"a friction law with {', '.join(missing)}"
        raise InputError(where, expected=expected, got=f"{law.id}, which has none")
