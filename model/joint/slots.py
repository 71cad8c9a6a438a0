"""The slots of a joint's equation that effects fill, in the standard symbols."""

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
    """The slots that effects fill, before the equation is assembled; fields as in `model.effects.effect.Effect`."""

    w: sp.Expr
    y: sp.Expr
    a: sp.Expr = sym.a
    torque: sp.Expr = sp.S.Zero
    friction_level: sp.Expr = sp.S.One
    coulomb_level: sp.Expr = sp.S.One
    kinetic_level: sp.Expr = sp.S.One
    viscous_level: sp.Expr = sp.S.One
    stribeck_velocity: sp.Expr = sym.v
    inertia_factor: sp.Expr = sp.S.One
    time_rate: sp.Expr = sp.S.One
    states: tuple[EffectState, ...] = ()

    def friction(self, law: FrictionLaw, p: Symbols) -> Friction:
        """Return friction after ``law`` with the parameters ``p``, by id, at the levels that effects set."""
        return law.write(sym.v, p, self.levels)

    @property
    def levels(self) -> Levels:
        """What effects put into the friction law."""
        return Levels(
            friction=self.friction_level,
            coulomb=self.coulomb_level,
            kinetic=self.kinetic_level,
            viscous=self.viscous_level,
            stribeck_velocity=self.stribeck_velocity,
        )


def _add(terms: Terms, effect: Effect) -> Terms:
    """Fill the slots of one effect; each sees the paths as built so far."""
    one = sp.S.One
    known = {sym.w: terms.w, sym.y: terms.y}
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
        inertia_factor=terms.inertia_factor * (effect.inertia_factor or one),
        time_rate=terms.time_rate * (effect.time_rate or one),
        states=terms.states + states,
    )


def with_effects(effects: Sequence[Effect], kp: sp.Symbol, law: FrictionLaw) -> Terms:
    """Fill all slots; where the positions' clock is off, every other effect lives by the machine's own time.

    Raises
    ------
    InputError
        Where an effect asks for a slot that the friction law of the joint lacks: it would have no influence.
    """
    for effect in effects:
        check_slots(effect, law)
    terms = Terms(w=kp * sym.tau, y=sym.q)
    rate = sp.prod(effect.time_rate for effect in effects if effect.time_rate is not None)
    for effect in sorted(effects, key=lambda effect: effect.place):
        terms = _add(terms, effect if effect.time_rate is not None else sym.in_time(effect, rate * sym.t))
    return terms


def check_slots(effect: Effect, law: FrictionLaw) -> None:
    """Refuse an effect that asks for what the friction law lacks."""
    missing = sorted(effect.friction_slots - law.slots)
    if missing:
        where, expected = f"effect {effect.key}", f"a friction law with {', '.join(missing)}"
        raise InputError(where, expected=expected, got=f"{law.id}, which has none")
