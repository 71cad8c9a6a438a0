"""The equation of one free joint, all others locked, with any effects added.

Kp·τ = M·q̈ + g_c·cos q + g_s·sin q + Ks·(q − epos) + friction (Tam, Kubica, Wang 2005, Fig. 3, where friction is
LuGre's σ0·z + σ1·ż + σ2·q̇). Parameters, effects and the id of a friction law come in, `Equations` goes out.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import sympy as sp

from haptid.model.effects import effect as sym
from haptid.model.effects.effect import Effect
from haptid.model.equations.drive import Drive
from haptid.model.equations.equations import Equations, Input, Output, State
from haptid.model.equations.fmu_names import POSITION, READING, TORQUE, VELOCITY, of_joint
from haptid.model.equations.joint_parameters import sliding
from haptid.model.equations.quantity import Quantity
from haptid.model.friction.law import FrictionLaw
from haptid.model.friction.registry import DEFAULT, law_named
from haptid.model.joint.drive_terms import (
    drive_damping,
    drive_inputs,
    drive_quantities,
    drive_states,
    drive_torque,
)
from haptid.model.joint.parameter_table import joint_parameters
from haptid.model.joint.slots import Terms, with_effects


def _gravity(q: sp.Expr, parameters: Mapping[str, sp.Symbol], prismatic: bool) -> sp.Expr:
    """g_c·cos q + g_s·sin q; a constant force on a prismatic joint."""
    constant = parameters.get("gravity_cos", sp.S.Zero)
    if prismatic:
        return constant
    return constant * sp.cos(q) + parameters.get("gravity_sin", sp.S.Zero) * sp.sin(q)


def joint_equations(
    joint: int,
    *,
    parameters: Sequence[Quantity] | None = None,
    effects: Sequence[Effect] = (),
    prismatic: bool = False,
    friction: str = DEFAULT,
    drive: Drive | None = None,
) -> Equations:
    """Build the equations of a single free joint.

    Parameters
    ----------
    joint
        Number of the joint, for names.
    parameters
        The parameters of the locked joint, by default all of `parameter_table.joint_parameters`. ``gravity_cos`` and
        ``gravity_sin`` may be left out where gravity does no work.
    effects
        Effects to add, in any order: ``Effect.place`` sorts them along the torque path. Random effects do not enter the
        equation.
    prismatic
        Whether the joint slides: then gravity is a constant force, and units are those of forces and lengths.
    friction
        Id of the friction law.
    drive
        What drives the joint, with its parameters behind the others; None where the torque is the input.

    Returns
    -------
    Equations
        States q, v, those of the friction law, those of the effects; input ``tau`` or those of the drive, output ``y``.

    Raises
    ------
    InputError
        Where there is no such law, or an effect needs a slot that the law lacks.

    Notes
    -----
    q̈ = (w + torque − gravity − Ks·(q − epos) − friction − ½·M·m'(q)·q̇²)/(M·m(q)), changed by the effects' formulas for
    the acceleration; all rates of change are multiplied by the factor of the machine's clock.
    """
    law = law_named(friction)
    driven = () if drive is None else drive_quantities(drive, prismatic=prismatic)
    default = (*joint_parameters(prismatic=prismatic, friction=friction), *driven)
    quantities = tuple(parameters) if parameters is not None else default
    p = {x.id: x.symbol for x in quantities}
    effects = [e for e in effects if not e.random]
    terms = with_effects(effects, p["Kp"], law)
    motion = _motion_under_torque(terms, law, p, prismatic)
    further: tuple[State, ...] = ()
    if drive is not None:
        motion = _motion_under_drive(motion, drive, p, prismatic)
        states = [state for state, _ in drive_states(drive, prismatic=prismatic)]
        further = tuple(replace(state, structured=of_joint(joint, state.structured)) for state in states)
    rad = "m" if prismatic else "rad"
    return Equations(
        name="_".join((f"joint{joint}", *(e.id for e in effects))),
        title=f"joint {joint}, all others locked" + (f", with {', '.join(e.id for e in effects)}" if effects else ""),
        joints=(joint,),
        states=(
            State(id="q", unit=rad, description="position", structured=of_joint(joint, POSITION)),
            State(id="v", unit=f"{rad}/s", description="velocity", structured=of_joint(joint, VELOCITY)),
            *(replace(s, unit=_unit(s, prismatic), structured=of_joint(joint, s.structured)) for s in law.states),
            *(replace(s.state, unit=_unit(s.state, prismatic)) for s in terms.states),
            *further,
        ),
        inputs=_inputs(joint, drive, prismatic),
        outputs=(
            Output(
                id="y",
                unit=rad,
                description="position reading",
                expression=motion.reading,
                structured=of_joint(joint, READING),
            ),
        ),
        parameters=(*quantities, *(e.row(x, prismatic=prismatic) for e in effects for x in e.parameters)),
        rhs=tuple(sp.sympify(f) * terms.time_rate for f in motion.rhs),
        rates=tuple(sp.sympify(r) * terms.time_rate for r in motion.rates),
        orderings=law.orderings,
        effects=tuple(e.id for e in effects),
        friction=(friction,),
        drive=drive,
    )


@dataclass(frozen=True, slots=True)
class _Motion:
    """Rates of change of the states, the rates at which they decay, and the reading."""

    rhs: list[sp.Expr]
    rates: list[sp.Expr]
    reading: sp.Expr


def _motion_under_torque(terms: Terms, law: FrictionLaw, p: Mapping[str, sp.Symbol], prismatic: bool) -> _Motion:
    """Write the motion under a torque."""
    dry = terms.friction(law, p)
    m = terms.inertia_factor
    inertia = p["inertia"] * m
    load = _gravity(sym.q, p, prismatic) + p["Ks"] * (sym.q - p["epos"]) + dry.force
    force = terms.w + terms.torque - load - p["inertia"] * sp.diff(m, sym.q) * sym.v**2 / 2
    acceleration = terms.a.subs(sym.a, force / inertia)
    of_states = {sym.a: acceleration, sym.load: terms.w + terms.torque - dry.force}
    return _Motion(
        rhs=[sym.v, acceleration, *dry.rhs, *(s.rhs.subs(of_states) for s in terms.states)],
        rates=[sp.S.Zero, law.damping(sym.v, p) / p["inertia"], *dry.rates, *(s.rate for s in terms.states)],
        reading=terms.y.subs(sym.a, acceleration),
    )


def _motion_under_drive(motion: _Motion, drive: Drive, p: Mapping[str, sp.Symbol], prismatic: bool) -> _Motion:
    """Put a drive in the place of the torque, with its states behind the others."""
    command = {sym.tau: drive_torque(drive)}
    rhs = [sp.sympify(f).subs(command) for f in motion.rhs]
    rates = [sp.sympify(r).subs(command) for r in motion.rates]
    rates[1] += drive_damping(drive) * p["Kp"] / p["inertia"]
    for _, rate_of_change in drive_states(drive, prismatic=prismatic):
        rhs.append(rate_of_change)
        rates.append(sp.S.Zero)
    return _Motion(rhs=rhs, rates=rates, reading=sp.sympify(motion.reading).subs(command))


def _inputs(joint: int, drive: Drive | None, prismatic: bool) -> tuple[Input, ...]:
    if drive is None:
        unit = "N" if prismatic else "N m"
        return (Input(id="tau", unit=unit, description="commanded torque", structured=of_joint(joint, TORQUE)),)
    inputs = drive_inputs(drive, prismatic=prismatic)
    return tuple(replace(x, structured=of_joint(joint, x.structured)) for x in inputs)


def _unit(state: State, prismatic: bool) -> str:
    return sliding(state.unit) if prismatic else state.unit
