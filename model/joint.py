"""The equation of one free joint, all others locked, with any effects added.

Kp·τ = M·q̈ + g_c·cos q + g_s·sin q + Ks·(q − epos) + σ0·z + σ1·ż + σ2·q̇ (Tam, Kubica, Wang 2005, Fig. 3)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import sympy as sp

from model import effect as sym
from model.effect import Effect, EffectState
from model.equations import Equations, Input, Output, State
from model.lugre import LuGreParameters, lugre
from model.parameters import joint_parameters, sliding
from model.quantity import Quantity


@dataclass(frozen=True, slots=True, kw_only=True)
class _Terms:
    """The slots that effects fill, before the equation is assembled."""

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


def _add(terms: _Terms, effect: Effect) -> _Terms:
    """Fill the slots of one effect; each sees the paths as built so far."""
    one = sp.S.One
    known = {sym.w: terms.w, sym.y: terms.y}
    states = tuple(replace(s, rhs=s.rhs.subs(sym.w, terms.w)) for s in effect.states)
    return replace(
        terms,
        w=terms.w if effect.input is None else effect.input.subs(known),
        y=terms.y if effect.output is None else effect.output.subs(known),
        a=terms.a if effect.acceleration is None else effect.acceleration.subs({sym.w: terms.w, sym.a: terms.a}),
        torque=terms.torque + (effect.torque if effect.torque is not None else 0),
        friction_level=terms.friction_level * (effect.friction_level or one).subs(sym.w, terms.w),
        coulomb_level=terms.coulomb_level * (effect.coulomb_level or one).subs(sym.w, terms.w),
        kinetic_level=terms.kinetic_level * (effect.kinetic_level or one).subs(sym.w, terms.w),
        viscous_level=terms.viscous_level * (effect.viscous_level or one),
        stribeck_velocity=effect.stribeck_velocity if effect.stribeck_velocity is not None else terms.stribeck_velocity,
        inertia_factor=terms.inertia_factor * (effect.inertia_factor or one),
        time_rate=terms.time_rate * (effect.time_rate or one),
        states=terms.states + states,
    )


def _gravity(q: sp.Expr, parameters: dict[str, sp.Symbol], prismatic: bool) -> sp.Expr:
    """g_c·cos q + g_s·sin q; a constant force on a prismatic joint."""
    constant = parameters.get("gravity_cos", sp.S.Zero)
    if prismatic:
        return constant
    return constant * sp.cos(q) + parameters.get("gravity_sin", sp.S.Zero) * sp.sin(q)


def _with_effects(effects: Sequence[Effect], kp: sp.Symbol) -> _Terms:
    """Fill all slots; where the positions' clock is off, every other effect lives by the machine's own time."""
    terms = _Terms(w=kp * sym.tau, y=sym.q)
    rate = sp.prod(effect.time_rate for effect in effects if effect.time_rate is not None)
    for effect in sorted(effects, key=lambda effect: effect.place):
        terms = _add(terms, effect if effect.time_rate is not None else sym.in_time(effect, rate * sym.t))
    return terms


def _row(x: Quantity, effect: Effect, prismatic: bool) -> Quantity:
    """Place an effect's parameter in the joint's table, in the units of a sliding joint where it slides."""
    unit = sliding(x.unit) if prismatic else x.unit
    return x.but(unit=unit, structured=x.structured or f"{effect.id}.{x.id}")


def joint_equations(
    joint: int,
    *,
    parameters: Sequence[Quantity] | None = None,
    effects: Sequence[Effect] = (),
    prismatic: bool = False,
) -> Equations:
    """Return the equations of joint ``joint``.

    Parameters
    ----------
    parameters
        The parameters of the locked joint, by default all of `model.parameters.TABLE`. ``gravity_cos`` and
        ``gravity_sin`` may be left out where gravity does no work.
    effects
        Deterministic effects to add, in order along the torque path. Random ones do not enter the equation.
    """
    quantities = tuple(parameters if parameters is not None else joint_parameters(prismatic=prismatic))
    p = {x.id: x.symbol for x in quantities}
    effects = [e for e in effects if not e.random]
    terms = _with_effects(effects, p["Kp"])
    friction = lugre(
        sym.v,
        sym.z,
        LuGreParameters(
            sigma0=p["sigma0"],
            sigma1=p["sigma1"],
            sigma2=p["sigma2"] * terms.viscous_level,
            vs=p["vs"],
            Fs=p["Fs"] * terms.coulomb_level,
            Fc=p["Fc"] * terms.coulomb_level * terms.kinetic_level,
        ),
        level=terms.friction_level,
        lagged=terms.stribeck_velocity,
    )
    m = terms.inertia_factor
    inertia = p["inertia"] * m
    load = _gravity(sym.q, p, prismatic) + p["Ks"] * (sym.q - p["epos"]) + friction.force
    force = terms.w + terms.torque - load - p["inertia"] * sp.diff(m, sym.q) * sym.v**2 / 2
    acceleration = terms.a.subs(sym.a, force / inertia)
    rhs = [sym.v, acceleration, friction.bristle, *(s.rhs.subs(sym.a, acceleration) for s in terms.states)]
    rates = [sp.S.Zero, (p["sigma1"] + p["sigma2"]) / p["inertia"], friction.rate, *(s.rate for s in terms.states)]
    rad, nm = ("m", "N") if prismatic else ("rad", "N m")
    name = f"joint{joint}"
    return Equations(
        name="_".join((name, *(e.id for e in effects))),
        title=f"joint {joint}, all others locked" + (f", with {', '.join(e.id for e in effects)}" if effects else ""),
        joints=(joint,),
        states=(
            State(id="q", unit=rad, description="position", structured=f"{name}.position"),
            State(id="v", unit=f"{rad}/s", description="velocity", structured=f"{name}.velocity"),
            State(
                id="z", unit=rad, description="bristle deflection", nominal=1e-3, structured=f"{name}.friction.bristle"
            ),
            *(replace(s.state, unit=sliding(s.state.unit) if prismatic else s.state.unit) for s in terms.states),
        ),
        inputs=(Input(id="tau", unit=nm, description="commanded torque", structured=f"{name}.torque"),),
        outputs=(
            Output(
                id="y",
                unit=rad,
                description="position reading",
                expression=terms.y.subs(sym.a, acceleration),
                structured=f"{name}.reading",
            ),
        ),
        parameters=(*quantities, *(_row(x, e, prismatic) for e in effects for x in e.parameters)),
        rhs=tuple(sp.sympify(f) * terms.time_rate for f in rhs),
        rates=tuple(sp.sympify(r) * terms.time_rate for r in rates),
        orderings=(("Fs", "Fc"),),
        effects=tuple(e.id for e in effects),
    )
