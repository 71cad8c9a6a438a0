"""The part of one joint in the equations of several: parameters, states, inputs, outputs, friction and net torque.

`Device`, joint and effects come in, a `JointPart` goes out; `coupled_joints` and `whole_device` assemble the parts of
all joints to `Equations`. Symbols of the single joint get the joint's number (``q3``, ``sigma0_3``).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import sympy as sp

from haptid.model.algebra.trig_polynomials import velocity_symbol
from haptid.model.device.device import Device, Guess
from haptid.model.device.stated_parameters import range_of
from haptid.model.effects import effect as sym
from haptid.model.effects.effect import Effect
from haptid.model.equations.equations import Input, Output, State
from haptid.model.equations.fmu_names import POSITION, READING, TORQUE, VELOCITY, of_joint
from haptid.model.equations.joint_parameters import TABLE, Row, sliding
from haptid.model.equations.quantity import Normal, Quantity
from haptid.model.friction.law import FrictionLaw
from haptid.model.friction.registry import law_named
from haptid.model.joint.parameter_table import parameter_rows
from haptid.model.joint.slots import Terms, with_effects

INERTIAL = ("inertia", "gravity_cos", "gravity_sin")
"""Parameters of a locked joint that come from the rigid bodies."""
NUMBERED = {s.name for s in (sym.q, sym.v, sym.z, sym.tau)}
"""Standard symbols with the joint's number directly behind (``q3``); other names have an underscore between."""
Effects = Mapping[int, Sequence[Effect]]
"""Effects by joint."""


@dataclass(frozen=True, slots=True, kw_only=True)
class JointPart:
    """The part of one joint in M(q)·v̇ = torque − C·v − φ of several joints, in symbols with the joint's number.

    Parameters
    ----------
    torque
        Kp·τ − Ks·(q − epos) − friction, and the torques of effects [N m].
    inertia
        Inertia that effects add to the joint's diagonal entry of M [kg m²].
    friction, friction_rhs, friction_rates
        States of the friction law, their rates of change and their relaxation rates [1/s].
    orderings
        Pairs (a, b) of parameter ids with a ≥ b.
    damping
        Estimate of ∂torque/∂v from above [N m s/rad].
    motor, reading
        Motor-side torque [N m], and position reading [rad].
    states, rhs, rates
        States of effects, their rates of change and their relaxation rates [1/s].
    quantities
        Parameters of drive, spring, friction and effects.
    """

    torque: sp.Expr
    inertia: sp.Expr
    friction: tuple[State, ...]
    friction_rhs: tuple[sp.Expr, ...]
    friction_rates: tuple[sp.Expr, ...]
    orderings: tuple[tuple[str, str], ...]
    damping: sp.Expr
    motor: sp.Expr
    reading: sp.Expr
    states: tuple[State, ...]
    rhs: tuple[sp.Expr, ...]
    rates: tuple[sp.Expr, ...]
    quantities: tuple[Quantity, ...]


def joint_part(device: Device, joint: int, effects: Sequence[Effect] = ()) -> JointPart:
    """Build the part of one joint in the equations of several joints.

    Parameters
    ----------
    device
        Device with the joint.
    joint
        Number of the joint.
    effects
        Effects of the joint, all of a kind for which `of_the_test_alone` gives no reason against.

    Returns
    -------
    JointPart
        Torque, inertia, friction, states and parameters in symbols with the joint's number.

    Raises
    ------
    InputError
        Where an effect needs a slot that the joint's friction law lacks.

    Notes
    -----
    An effect that changes the acceleration of the single joint, q̈ = α·(torque − load)/(M·m) + β, replaces M by M·m/α
    and adds the torque M·m·β/α, with M the inertia of the joint in the test that found the effect.
    """
    slides, law = device.joints[joint].prismatic, law_named(device.joints[joint].friction)
    p = {row.id: sp.Symbol(row.id, real=True) for row in parameter_rows(law.id)}
    terms = with_effects(effects, p["Kp"], law)
    friction = terms.friction(law, p)
    inertia, torque = _own_motion(terms, p["inertia"])
    load = terms.w + terms.torque - friction.force
    torque += load - p["Ks"] * (sym.q - p["epos"])
    rates_of_change = [s.rhs.subs(sym.load, load) for s in terms.states]
    own = [e.row(x, prismatic=slides) for e in effects for x in e.parameters]
    formulas = (torque, inertia, *rates_of_change, *(s.rate for s in terms.states))
    # here M comes from the links: the inertia of the single-joint test is a parameter only where a formula uses it
    if any(p["inertia"] in sp.sympify(e).free_symbols for e in formulas):
        own.append(_make_tested_inertia(slides))
    suffix, prefix = f"_{joint}", of_joint(joint, "")
    table = [q.but(id=q.id + suffix, structured=prefix + q.structured) for q in own]
    return JointPart(
        torque=_of_joint(torque, joint),
        inertia=_of_joint(inertia, joint),
        friction=tuple(_friction_state(s, joint, slides) for s in law.states),
        friction_rhs=tuple(_of_joint(f, joint) for f in friction.rhs),
        friction_rates=tuple(_of_joint(f, joint) for f in friction.rates),
        orderings=tuple((a + suffix, b + suffix) for a, b in law.orderings),
        damping=_of_joint(
            law.damping(sym.v, p | {law.roles.viscous: p[law.roles.viscous] * terms.viscous_level}), joint
        ),
        motor=_of_joint(terms.w, joint),
        reading=_of_joint(terms.y, joint),
        states=tuple(_number_state(s.state, joint, slides) for s in terms.states),
        rhs=tuple(_of_joint(f, joint) for f in rates_of_change),
        rates=tuple(_of_joint(s.rate, joint) for s in terms.states),
        quantities=(*joint_quantities(device, joint, suffix=suffix, prefix=prefix), *table),
    )


def of_the_test_alone(effect: Effect) -> str:
    """Give the reason why an effect holds only in the test of a single joint.

    Parameters
    ----------
    effect
        Effect of the catalogue.

    Returns
    -------
    str
        The reason, for a reader; empty where the effect also holds when several joints move.
    """
    if effect.random:
        return "random: it stands beside the equations"
    if effect.time_rate is not None:
        return "the clock of the recording, not of the device"
    linear = effect.acceleration is None or not sp.diff(effect.acceleration, sym.a, 2)
    if not linear or any(sym.a in sp.sympify(s.rhs).free_symbols for s in effect.states):
        return "driven by the acceleration of a joint that moves alone"
    return ""


def _own_motion(terms: Terms, inertia: sp.Symbol) -> tuple[sp.Expr, sp.Expr]:
    """Return the additional inertia M·(m/α − 1), and the torque M·m·β/α − ½·M·m'(q)·q̇², of the joint's effects."""
    m, share, rest = terms.inertia_factor, sp.diff(terms.a, sym.a), terms.a.subs(sym.a, 0)
    christoffel = inertia * sp.diff(m, sym.q) * sym.v**2 / 2
    return inertia * (m / share - 1), inertia * m * rest / share - christoffel


def _of_joint(expression: sp.Expr, joint: int) -> sp.Expr:
    """Return an expression with the joint's number behind every symbol but time."""
    formula = sp.sympify(expression)
    free = [s for s in formula.free_symbols if s != sym.t]
    return formula.xreplace({s: _symbol(_with_number(s.name, joint)) for s in free})


def _with_number(id: str, joint: int) -> str:
    return f"{id}{joint}" if id in NUMBERED else f"{id}_{joint}"


def _friction_state(state: State, joint: int, slides: bool) -> State:
    return replace(
        state,
        id=_with_number(state.id, joint),
        unit=sliding(state.unit) if slides else state.unit,
        description=f"{state.description} of joint {joint}",
        structured=of_joint(joint, state.structured),
    )


def _number_state(state: State, joint: int, slides: bool) -> State:
    unit = sliding(state.unit) if slides else state.unit
    structured = of_joint(joint, state.structured or state.id)
    return replace(state, id=f"{state.id}_{joint}", unit=unit, structured=structured)


def _make_tested_inertia(slides: bool) -> Quantity:
    """Return the inertia of the joint in the test that found an effect, a known number."""
    (row,) = [row for row in TABLE if row.id == "inertia"]
    return Quantity(
        id=row.id, unit=row.prismatic_unit if slides else row.unit, description="inertia of the joint tested alone",
        initial=row.initial, lower=row.lower, upper=row.upper, scale=row.scale, fixed=True, structured="tested.inertia",
    )  # fmt: skip


def joint_quantities(device: Device, joint: int, *, suffix: str = "", prefix: str = "") -> tuple[Quantity, ...]:
    """Return the drive, spring and friction parameters of one joint.

    Parameters
    ----------
    device
        Device with first guesses.
    joint
        Number of the joint.
    suffix
        End of each id, as ``_3``.
    prefix
        Start of each structured name, as ``joint3.``.

    Returns
    -------
    tuple of Quantity
        Parameters in the order of `parameter_rows`, with the device's guesses, else the table's defaults.
    """
    given, slides = device.joints[joint].parameters, device.joints[joint].prismatic
    law = law_named(device.joints[joint].friction)
    rows = [row for row in parameter_rows(law.id) if row.id not in INERTIAL]
    guesses = {row.id: given.get(row.id) or _default(row, given, law) for row in rows}
    return tuple(_quantity(row, guesses[row.id], slides, suffix, prefix) for row in rows)


def _default(row: Row, given: Mapping[str, Guess], law: FrictionLaw) -> Guess:
    """Return the table's first guess, moved to the device's guesses where an ordering as Fs ≥ Fc requires it."""
    initial = row.initial
    for larger, smaller in law.orderings:
        if row.id == larger and smaller in given:
            initial = max(initial, given[smaller].initial)
        if row.id == smaller and larger in given:
            initial = min(initial, given[larger].initial)
    return Guess(initial=initial, fixed=row.fixed)


def _quantity(row: Row, guess: Guess, slides: bool, suffix: str, prefix: str) -> Quantity:
    lower, upper = range_of(row.id, {"initial": guess.initial, "lower": guess.lower, "upper": guess.upper})
    return Quantity(
        id=row.id + suffix,
        unit=row.prismatic_unit if slides else row.unit,
        description=row.description,
        initial=guess.initial,
        lower=lower,
        upper=upper,
        prior=Normal(mean=guess.initial, std=guess.std) if guess.std else None,
        fixed=guess.fixed,
        scale=row.scale,
        structured=prefix + row.structured,
    )


def joint_states(device: Device, parts: Mapping[int, JointPart]) -> tuple[State, ...]:
    """Return the states of several joints.

    Parameters
    ----------
    device
        Device with the joints.
    parts
        Parts by joint, in the order of the joints.

    Returns
    -------
    tuple of State
        All positions, all velocities, then all states of friction laws, then all states of effects; each group in the
        order of the joints.
    """
    units = {j: "m" if device.joints[j].prismatic else "rad" for j in parts}
    return (
        *(_state(f"q{j}", units[j], f"position of joint {j}", of_joint(j, POSITION)) for j in parts),
        *(_state(f"v{j}", f"{units[j]}/s", f"velocity of joint {j}", of_joint(j, VELOCITY)) for j in parts),
        *(state for part in parts.values() for state in part.friction),
        *(state for part in parts.values() for state in part.states),
    )


def _state(id: str, unit: str, description: str, structured: str) -> State:
    return State(id=id, unit=unit, description=description, structured=structured)


def joint_inputs(device: Device, joints: Sequence[int]) -> tuple[Input, ...]:
    """Return the commanded torques [N m] or forces [N] of the joints as inputs ``tau<j>``.

    Parameters
    ----------
    device
        Device with the joints.
    joints
        Numbers of the joints.

    Returns
    -------
    tuple of Input
        One input a joint, in the order of ``joints``.
    """
    result = []
    for j in joints:
        what, unit = ("force", "N") if device.joints[j].prismatic else ("torque", "N m")
        text = f"commanded {what} of joint {j}"
        result.append(Input(id=f"tau{j}", unit=unit, description=text, structured=of_joint(j, TORQUE)))
    return tuple(result)


def joint_outputs(device: Device, parts: Mapping[int, JointPart]) -> tuple[Output, ...]:
    """Return the position readings [rad] or [m] of the joints as outputs ``y<j>``.

    Parameters
    ----------
    device
        Device with the joints.
    parts
        Part of each joint in the equations.

    Returns
    -------
    tuple of Output
        One output a joint, in the order of ``parts``.
    """
    return tuple(
        Output(
            id=f"y{j}",
            unit="m" if device.joints[j].prismatic else "rad",
            description=f"position reading of joint {j}",
            expression=part.reading,
            structured=of_joint(j, READING),
        )
        for j, part in parts.items()
    )


def joint_rows(parts: Mapping[int, JointPart], motion: Sequence[sp.Expr]) -> tuple[sp.Expr, ...]:
    """Return the right-hand sides of several joints.

    Parameters
    ----------
    parts
        Parts by joint, in the order of the joints.
    motion
        Right-hand sides of the velocities, shape (n,): accelerations, or h of M·v̇ = h.

    Returns
    -------
    tuple of sympy.Expr
        Right-hand sides in the order of `joint_states`.
    """
    return (
        *(velocity_symbol(j) for j in parts),
        *motion,
        *(rhs for part in parts.values() for rhs in part.friction_rhs),
        *(rhs for part in parts.values() for rhs in part.rhs),
    )


def joint_rates(parts: Mapping[int, JointPart], damping: Sequence[sp.Expr]) -> tuple[sp.Expr, ...]:
    """Return the relaxation rates of several joints.

    Parameters
    ----------
    parts
        Parts by joint, in the order of the joints.
    damping
        Relaxation rates of the velocities [1/s], shape (n,).

    Returns
    -------
    tuple of sympy.Expr
        Relaxation rates [1/s] in the order of `joint_states`; 0 for the positions.
    """
    return (
        *(sp.S.Zero for _ in parts),
        *damping,
        *(rate for part in parts.values() for rate in part.friction_rates),
        *(rate for part in parts.values() for rate in part.rates),
    )


def names_of(effects: Effects) -> tuple[str, ...]:
    """Return a name such as ``joint3_cogging`` for every effect, by ascending joint.

    Parameters
    ----------
    effects
        Effects by joint.

    Returns
    -------
    tuple of str
        ``joint<j>_<id>``; several effects of a joint in their own order.
    """
    return tuple(f"joint{j}_{e.id}" for j, some in sorted(effects.items()) for e in some)


def _symbol(name: str) -> sp.Symbol:
    return sp.Symbol(name, real=True)
