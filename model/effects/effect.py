"""An effect of the catalogue: what it adds to the equation of a joint, as formulas in the standard symbols.

The standard symbols are ``t`` [s], ``q``, ``v``, ``z`` (position, speed, bristle of a friction law that has one), ``w``
(torque that reaches the joint, as built so far; the command ``Kp·tau`` at first), ``a`` (acceleration as built so far),
``y`` (reading as built so far), and every parameter and state by its id.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import sympy as sp

from haptid.model.effects.scales import Scales
from haptid.model.equations.equations import TIME, State
from haptid.model.equations.joint_parameters import sliding
from haptid.model.equations.quantity import Quantity
from haptid.model.friction.law import SLOTS, USE_OF_BRISTLE

q, v, z, w, a, y, tau = (sp.Symbol(name, real=True) for name in ("q", "v", "z", "w", "a", "y", "tau"))
t = TIME
RESERVED = frozenset({"t", "q", "v", "z", "w", "a", "y", "tau"})
SIDES = ("torque", "input", "output", "friction", "time", "random")
LAST = 9
"""Place of an effect that acts behind drive and encoder, or beside them."""
FORMULAS = (
    "torque", "input", "output", "acceleration", *SLOTS, "inertia_factor", "time_rate",
)  # fmt: skip
"""Fields of an effect that hold a formula."""
VARIABLES = ("position", "velocity", "torque", "time", "reversal", "frequency", "cycle")


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
    variant
        Tells forms of one effect apart (``soft`` and ``hard`` saturation); empty where there is one form.
    lives_in
        The variable in which the effect lives, one of `VARIABLES`.
    side
        Where it enters, one of `SIDES`.
    parameters
        The first ``amplitudes`` of them are zero in the base model (``initial`` is a small typical size); the rest give
        the effect its shape. Numbers are multiples of the joint's own scales, as ``relative`` says, until `at` is
        called.
    amplitudes
        How many parameters, from the first on, have to vanish for the effect to vanish.
    relative, origin
        For a parameter's id, its scale and its zero in the symbols of `model.effects.scales`; 1 and 0 where absent.
    shapes
        Grid of parameters at which the signature is taken: tuples ``(id, values)``.
    derived
        Further numbers that a reader wants: tuples ``(id, unit, expression of the parameters)``.
    rivals
        Ids of effects that are easily mistaken for this one.
    contenders
        Effects of the same kind with as many free parameters, in the same order, that are no entries and stand for all
        that are none: the name has to be told from each where the catalogue holds no other entry with that contender.
    torque
        Torque added to the right-hand side.
    input, output, acceleration
        The new ``w``, ``y``, ``a`` in terms of the old.
    friction_level, coulomb_level, kinetic_level, viscous_level
        Factors on g(v), on Fc and Fs alone, on Fc alone and on σ2.
    stribeck_velocity
        Speed seen by the Stribeck curve.
    inertia_factor
        m(q) in M·m(q)·q̈ + ½·M·m'(q)·q̇².
    time_rate
        Factor between the machine's and the data's clock.
    states
        Extra states.
    place
        Place in the chain from command to reading, whatever the order in which effects are added: what the amplifier
        does comes before what the motor does.
    edge, edges
        Id of a fixed parameter that rounds off a jump, and the smaller values to which a fit takes it, one by one.
    joint
        The joint in which it sits, where several move together.
    """

    id: str
    title: str
    formula: str
    lives_in: str
    side: str
    parameters: tuple[Quantity, ...]
    variant: str = ""
    amplitudes: int = 1
    relative: dict[str, sp.Expr] = field(default_factory=dict)
    origin: dict[str, sp.Expr] = field(default_factory=dict)
    shapes: tuple[tuple[str, tuple[float, ...]], ...] = ()
    derived: tuple[tuple[str, str, sp.Expr], ...] = ()
    rivals: tuple[str, ...] = ()
    contenders: tuple[Effect, ...] = ()
    torque: sp.Expr | None = None
    input: sp.Expr | None = None
    output: sp.Expr | None = None
    acceleration: sp.Expr | None = None
    friction_level: sp.Expr | None = None
    coulomb_level: sp.Expr | None = None
    kinetic_level: sp.Expr | None = None
    viscous_level: sp.Expr | None = None
    stribeck_velocity: sp.Expr | None = None
    inertia_factor: sp.Expr | None = None
    time_rate: sp.Expr | None = None
    states: tuple[EffectState, ...] = ()
    place: int = LAST
    edge: str = ""
    edges: tuple[float, ...] = ()
    joint: int | None = None

    def __post_init__(self) -> None:
        """Refuse what cannot be placed or would hide a standard symbol."""
        names = {x.id for x in self.parameters}
        problems = [
            (self.side not in SIDES, f"side {self.side!r} is none of {SIDES}"),
            (self.lives_in not in VARIABLES, f"lives_in {self.lives_in!r} is none of {VARIABLES}"),
            (bool(names & RESERVED), f"parameters {sorted(names & RESERVED)} have the names of standard symbols"),
            (not 1 <= self.amplitudes <= len(self.parameters), "the first parameter has to be an amplitude"),
            (not {id for id, _ in self.shapes} <= names, "shapes name a parameter that is not there"),
            (not {*self.relative, *self.origin} <= names, "relative or origin name a parameter that is not there"),
        ]
        for wrong, message in problems:
            if wrong:
                raise ValueError(f"{self.key}: {message}")  # noqa: EM102 - the message is made above

    @property
    def key(self) -> str:
        """Return the id, and the variant behind a colon where there is one."""
        return f"{self.id}:{self.variant}" if self.variant else self.id

    @property
    def own_names(self) -> tuple[str, ...]:
        """Return the ids of its parameters and states."""
        return (*(x.id for x in self.parameters), *(s.state.id for s in self.states))

    @property
    def friction_slots(self) -> frozenset[str]:
        """What it asks of the joint's friction law: names of `model.friction.law.SLOTS`, `USE_OF_BRISTLE`."""
        filled = {name for name in SLOTS if getattr(self, name) is not None}
        formulas = (sp.sympify(e) for e in _expressions(self) if e is not None)
        return frozenset(filled | {USE_OF_BRISTLE} if any(z in e.free_symbols for e in formulas) else filled)

    @property
    def random(self) -> bool:
        """Whether the effect is random and enters the likelihood instead of the equation."""
        return self.side == "random"

    @property
    def threshold(self) -> bool:
        """Whether it jumps where the torque passes its first parameter: only torques sent beside it tell where."""
        return self.input is not None and self.edge in {x.name for x in self.input.free_symbols}

    @property
    def polynomial(self) -> bool:
        """Whether the effect is nothing but a torque polynomial in the position."""
        formulas = [e for e in _expressions(self) if e is not None]
        if self.torque is None or formulas != [self.torque]:
            return False
        moving = self.torque.free_symbols & {t, q, v, z, w, a, y, tau}
        return moving == {q} and bool(self.torque.is_polynomial(q))

    @property
    def neutral(self) -> dict[str, float]:
        """Values of the parameters at which the effect vanishes."""
        return {x.id: 0.0 for x in self.parameters[: self.amplitudes]}

    def at(self, scales: Scales) -> Effect:
        """Return the effect with parameters and shape grids in SI units, for a joint of these scales."""
        values = scales.values()
        factor = {id: float(sp.sympify(e).subs(values)) for id, e in self.relative.items()}
        zero = {id: float(sp.sympify(e).subs(values)) for id, e in self.origin.items()}

        def si(id: str, number: float) -> float:
            return zero.get(id, 0.0) + factor.get(id, 1.0) * number

        def quantity(x: Quantity) -> Quantity:
            unit = sliding(x.unit) if scales.prismatic else x.unit
            return x.but(initial=si(x.id, x.initial), lower=si(x.id, x.lower), upper=si(x.id, x.upper), unit=unit)

        return self.but(
            parameters=tuple(quantity(x) for x in self.parameters),
            shapes=tuple((id, tuple(si(id, value) for value in grid)) for id, grid in self.shapes),
            relative={},
            origin={},
            contenders=tuple(e.at(scales) for e in self.contenders),
        )

    @property
    def sharper(self) -> Effect | None:
        """Return the effect with its jump less rounded; None where it has none, or is as sharp as it gets."""
        if not self.edges:
            return None
        return self._rounded_by(self.edges[0]).but(edges=self.edges[1:])

    @property
    def touches(self) -> bool:
        """Whether its jump is a contact: bodies meet and part as the joint moves."""
        return bool(self.edge) and not self.threshold

    def sharper_by(self, times: float) -> Effect:
        """Return the effect with its jump rounded that many times less, whatever a fit can follow."""
        (now,) = (x.initial for x in self.parameters if x.id == self.edge)
        return self._rounded_by(now / times)

    def _rounded_by(self, edge: float) -> Effect:
        return self.but(parameters=tuple(x.but(initial=edge) if x.id == self.edge else x for x in self.parameters))

    def row(self, x: Quantity, *, prismatic: bool) -> Quantity:
        """Place one of the parameters in a joint's table, in the units of a sliding joint where it slides."""
        unit = sliding(x.unit) if prismatic else x.unit
        return x.but(unit=unit, structured=x.structured or f"{self.id}.{x.id}")

    def but(self, **changes: Any) -> Effect:
        """Return a copy with ``changes``."""
        return replace(self, **changes)


def in_time(effect: Effect, now: sp.Expr) -> Effect:
    """Return the effect with ``now`` for the time in all its formulas."""
    formulas = {name: e.xreplace({t: now}) for name in FORMULAS if (e := getattr(effect, name)) is not None}
    states = (replace(s, rhs=s.rhs.xreplace({t: now}), rate=s.rate.xreplace({t: now})) for s in effect.states)
    return effect.but(states=tuple(states), **formulas)


def relabel(effect: Effect, names: Mapping[str, str]) -> Effect:
    """Return the same effect with other ids of parameters and states, by the old ones."""
    symbols = {sp.Symbol(a, real=True): sp.Symbol(b, real=True) for a, b in names.items()}

    def put(expression: sp.Expr) -> sp.Expr:
        return sp.sympify(expression).xreplace(symbols)

    formulas = {name: put(e) for name in FORMULAS if (e := getattr(effect, name)) is not None}
    return effect.but(
        parameters=tuple(x.but(id=names[x.id]) for x in effect.parameters),
        states=tuple(
            EffectState(state=replace(s.state, id=names[s.state.id]), rhs=put(s.rhs), rate=put(s.rate))
            for s in effect.states
        ),
        relative={names[id]: e for id, e in effect.relative.items()},
        origin={names[id]: e for id, e in effect.origin.items()},
        shapes=tuple((names[id], grid) for id, grid in effect.shapes),
        derived=tuple((id, unit, put(e)) for id, unit, e in effect.derived),
        edge=names.get(effect.edge, ""),
        **formulas,
    )


def match_parameters(one: Effect, other: Effect) -> dict[str, str] | None:
    """Return the parameters of ``other`` by those of ``one`` where both are the same equations under other names."""
    if (one.side, len(one.parameters), len(one.states)) != (other.side, len(other.parameters), len(other.states)):
        return None
    ids = {p.id: q.id for p, q in zip(one.parameters, other.parameters, strict=True)}
    states = {p.state.symbol: q.state.symbol for p, q in zip(one.states, other.states, strict=True)}
    symbols = states | {sp.Symbol(p, real=True): sp.Symbol(q, real=True) for p, q in ids.items()}
    here = [None if e is None else e.xreplace(symbols) for e in _expressions(one)]
    return ids if here == _expressions(other) else None


def _expressions(effect: Effect) -> list[sp.Expr | None]:
    """All formulas of an effect."""
    found = [getattr(effect, name) for name in FORMULAS]
    return found + [e for x in effect.states for e in (x.rhs, x.rate)]


def parameter(
    id: str, unit: str, description: str, initial: float, lower: float, upper: float, **more: Any
) -> Quantity:
    """Write one row of an effect's parameter table."""
    return Quantity(id=id, unit=unit, description=description, initial=initial, lower=lower, upper=upper, **more)


def reference(id: str, unit: str, description: str) -> Quantity:
    """Write a fixed scale that a formula refers to; its value is 1 times the scale named in ``relative``."""
    return Quantity(id=id, unit=unit, description=description, initial=1.0, lower=0.0, upper=1e12, fixed=True)


def fade_in(amplitude: sp.Symbol, least: sp.Expr, full: sp.Expr, without: sp.Expr) -> sp.Expr:
    """Blend from ``without`` at amplitude 0 to ``full`` at ``least`` and beyond.

    ``full`` is an expression of the amplitude that is singular at 0 (a time constant, a compliance). Below ``least``
    its deviation is taken at ``least`` and scaled linearly, so that the effect vanishes exactly and has a derivative
    at 0.
    """
    held = sp.Max(amplitude, least)
    return without + amplitude / held * (full.subs(amplitude, held) - without)
