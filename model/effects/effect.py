"""An effect of the catalogue as data: formulas in the standard symbols that extend the equation of a joint.

Files of the catalogue make an `Effect`; `model.joint.slots` puts its formulas into the equation of a joint.

The standard symbols are ``t`` [s], ``q``, ``v``, ``z`` (position, speed, bristle of a friction law that has one), ``w``
(torque that reaches the joint, as built so far; the command ``Kp·tau`` at first), ``a`` (acceleration as built so far),
``y`` (reading as built so far), and every parameter and state by its id. In the rates of change of an effect's states
there is ``load``, what friction leaves of the torque to inertia, gravity and spring, and in a ``coulomb_level``
``coulomb``, the Coulomb friction of whatever friction law the joint has, in a ``stribeck_argument`` ``fall``, (v/vs)².
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
from haptid.model.friction.law import FALL, SLOTS, USE_OF_BRISTLE

q, v, z, w, a, y, tau, load, coulomb = (
    sp.Symbol(name, real=True) for name in ("q", "v", "z", "w", "a", "y", "tau", "load", "coulomb")
)
t = TIME
fall = FALL
RESERVED = frozenset({"t", "q", "v", "z", "w", "a", "y", "tau", "load", "coulomb", "fall"})
SIDES = ("torque", "input", "output", "friction", "time", "random")
LAST = 9
"""Default of ``Effect.place``: behind all effects of the drive."""
FORMULAS = (
    "torque", "input", "output", "acceleration", *SLOTS, "inertia_factor", "time_rate",
)  # fmt: skip
"""Fields of an effect that hold a formula."""
VARIABLES = ("position", "velocity", "torque", "time", "reversal", "frequency", "cycle")


@dataclass(frozen=True, slots=True, kw_only=True)
class EffectState:
    """A state of an effect, ẋ = rhs.

    Parameters
    ----------
    state
        Id, unit and start value.
    rhs
        Right-hand side, in the unit of the state per second.
    rate
        Relaxation rate −∂rhs/∂x [1/s], which the stepper integrates exactly; 0 where the state is not stiff.
    """

    state: State
    rhs: sp.Expr
    rate: sp.Expr = sp.S.Zero


@dataclass(frozen=True, slots=True, kw_only=True)
class Effect:
    """One effect of the catalogue, as data.

    Parameters
    ----------
    id, title, formula
        Fixed id, name in words, formula as a reader writes it.
    variant
        Form of an effect that has several (``soft`` and ``hard`` saturation); empty where there is one form.
    lives_in
        The variable on which the effect mainly depends, one of `VARIABLES`.
    side
        Part of the equation that the effect changes, one of `SIDES`.
    parameters
        The first ``amplitudes`` of them are zero in the nominal model (``initial`` is a small typical size); the rest
        are shape parameters. Numbers are multiples of the joint's own scales, by ``relative``, until `at` is called.
    amplitudes
        Number of leading parameters that vanish together with the effect.
    relative, origin
        For a parameter's id, its scale and its zero in the symbols of `model.effects.scales`; 1 and 0 where absent.
    shapes
        Grid of parameters at which the signature is taken: tuples ``(id, values)``. Every combination of the values is
        simulated, and the best of them starts the fit, so a formula that is periodic in a parameter needs a fine grid.
    derived
        Further quantities for reports: tuples ``(id, unit, expression of the parameters)``.
    rivals
        Ids of effects with a similar signature.
    contenders
        Effects of the same kind with as many free parameters, in the same order, that are not in the catalogue and
        stand for all effects outside it: the effect has to be distinguished from each of them where no other catalogue
        effect has that contender.
    torque
        Torque added to the right-hand side.
    input, output, acceleration
        The new ``w``, ``y``, ``a`` in terms of the old.
    friction_level, coulomb_level, kinetic_level, viscous_level
        Factors on g(v), on Fc and Fs alone, on Fc alone and on σ2.
    stribeck_velocity, stribeck_argument
        Speed in the Stribeck curve, and the argument of its exponential in terms of ``fall``.
    inertia_factor
        m(q) in M·m(q)·q̈ + ½·M·m'(q)·q̇².
    time_rate
        Factor between the machine's and the data's clock.
    states
        Extra states.
    place
        Place in the chain from command to reading, independent of the order in which effects are added: effects of the
        amplifier come before those of the motor.
    edge, edges
        Id of a fixed parameter that rounds off a discontinuity, and the smaller values that a fit gives it one by one.
    torque_only
        Whether the effect is searched for in torques only: a family of many amplitudes needs a residual in which they
        are linear.
    series_of
        Key of the single wave of which the effect is a series of harmonics. A search in positions offers it in the
        place of that wave alone: so many amplitudes fit anything where nothing is named yet.
    again
        Whether the form is offered only beside another one of the same id, as what a machine may have twice.
    resonant_only
        Whether the form is offered only where the runs show the resonance of the plain form of the same id.
    joint
        The joint that has the effect, where several joints move together.
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
    stribeck_argument: sp.Expr | None = None
    inertia_factor: sp.Expr | None = None
    time_rate: sp.Expr | None = None
    states: tuple[EffectState, ...] = ()
    place: int = LAST
    edge: str = ""
    edges: tuple[float, ...] = ()
    torque_only: bool = False
    series_of: str = ""
    again: bool = False
    resonant_only: bool = False
    joint: int | None = None

    def __post_init__(self) -> None:
        """Check that the effect has a place in the equation and hides no standard symbol.

        Raises
        ------
        ValueError
            Where ``side`` or ``lives_in`` is unknown, a parameter has the name of a standard symbol, there is no
            amplitude, or ``shapes``, ``relative`` or ``origin`` name an unknown parameter.
        """
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
        """Return the ids of the effect's parameters and states."""
        return (*(x.id for x in self.parameters), *(s.state.id for s in self.states))

    @property
    def friction_slots(self) -> frozenset[str]:
        """Slots of the joint's friction law that the effect uses: of `model.friction.law.SLOTS` and `USE_OF_BRISTLE`.

        `USE_OF_BRISTLE` is among them where a formula reads the bristle deflection z.
        """
        filled = {name for name in SLOTS if getattr(self, name) is not None}
        formulas = (sp.sympify(e) for e in _expressions(self) if e is not None)
        return frozenset(filled | {USE_OF_BRISTLE} if any(z in e.free_symbols for e in formulas) else filled)

    @property
    def random(self) -> bool:
        """Whether the effect is random and enters the likelihood instead of the equation."""
        return self.side == "random"

    @property
    def threshold(self) -> bool:
        """Whether the torque path has a discontinuity where the torque passes the first parameter.

        Only torques close to the parameter identify it.
        """
        return self.input is not None and self.edge in {x.name for x in self.input.free_symbols}

    @property
    def position_torque(self) -> sp.Expr | None:
        """The torque of an effect that adds only a torque, one that depends on the position alone; None of others."""
        formulas = [e for e in _expressions(self) if e is not None]
        if self.torque is None or formulas != [self.torque]:
            return None
        moving = self.torque.free_symbols & {t, q, v, z, w, a, y, tau}
        return self.torque if moving == {q} else None

    @property
    def polynomial(self) -> bool:
        """Whether the effect adds only a torque that is a polynomial in the position."""
        torque = self.position_torque
        return torque is not None and bool(torque.is_polynomial(q))

    @property
    def neutral(self) -> dict[str, float]:
        """Values of the parameters at which the effect vanishes."""
        return {x.id: 0.0 for x in self.parameters[: self.amplitudes]}

    def at(self, scales: Scales) -> Effect:
        """Convert parameters, shape grids and contenders to SI units for one joint.

        A number x of the catalogue becomes ``origin + relative·x``.

        Parameters
        ----------
        scales
            Orders of magnitude of the joint in its tests.

        Returns
        -------
        Effect
            The effect in SI units, without ``relative`` and ``origin``; in the units of a prismatic joint where it
            slides.
        """
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
        """Return the effect with its discontinuity rounded by the next smaller of ``edges``.

        None where there is no discontinuity, or no smaller rounding is left.
        """
        if not self.edges:
            return None
        return self._rounded_by(self.edges[0]).but(edges=self.edges[1:])

    @property
    def touches(self) -> bool:
        """Whether the discontinuity is a contact of bodies (as opposed to a `threshold` of the torque)."""
        return bool(self.edge) and not self.threshold

    def sharper_by(self, times: float) -> Effect:
        """Return the effect with its discontinuity rounded less, independent of ``edges``.

        Parameters
        ----------
        times
            Factor by which the rounding parameter ``edge`` becomes smaller.

        Returns
        -------
        Effect
            The effect with the smaller rounding; ``edges`` stay.

        Raises
        ------
        ValueError
            Where the effect has no discontinuity.
        """
        (now,) = (x.initial for x in self.parameters if x.id == self.edge)
        return self._rounded_by(now / times)

    def _rounded_by(self, edge: float) -> Effect:
        return self.but(parameters=tuple(x.but(initial=edge) if x.id == self.edge else x for x in self.parameters))

    def row(self, x: Quantity, *, prismatic: bool) -> Quantity:
        """Return one of the effect's parameters as a row of a joint's parameter table.

        Parameters
        ----------
        x
            Parameter of the effect.
        prismatic
            Whether the joint slides, which chooses the units.

        Returns
        -------
        Quantity
            The parameter with the unit of the joint and, where ``x`` has none, the structured name ``<effect>.<id>``.
        """
        unit = sliding(x.unit) if prismatic else x.unit
        return x.but(unit=unit, structured=x.structured or f"{self.id}.{x.id}")

    def but(self, **changes: Any) -> Effect:
        """Return a copy with changed fields.

        Parameters
        ----------
        **changes
            New values by field name.

        Returns
        -------
        Effect
            The copy.
        """
        return replace(self, **changes)


def in_time(effect: Effect, now: sp.Expr) -> Effect:
    """Substitute another expression for the time t in all formulas of an effect.

    Parameters
    ----------
    effect
        Effect in the standard symbols.
    now
        Expression of the time [s], as rate·t for another clock.

    Returns
    -------
    Effect
        The effect on that clock.
    """
    formulas = {name: e.xreplace({t: now}) for name in FORMULAS if (e := getattr(effect, name)) is not None}
    states = (replace(s, rhs=s.rhs.xreplace({t: now}), rate=s.rate.xreplace({t: now})) for s in effect.states)
    return effect.but(states=tuple(states), **formulas)


def relabel(effect: Effect, names: Mapping[str, str]) -> Effect:
    """Rename the parameters and states of an effect.

    Parameters
    ----------
    effect
        Effect to rename.
    names
        New id by old id, of every parameter and state.

    Returns
    -------
    Effect
        The same effect under the new ids.

    Raises
    ------
    KeyError
        Where a parameter or state has no new id.
    """
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
    """Match the parameters of two effects that are the same equations under other names.

    Parameters
    ----------
    one, other
        Effects; their parameters and states are compared in the order in which they stand.

    Returns
    -------
    dict of str to str or None
        Id in ``other`` by id in ``one``; None where the formulas differ.
    """
    if (one.side, len(one.parameters), len(one.states)) != (other.side, len(other.parameters), len(other.states)):
        return None
    ids = {p.id: q.id for p, q in zip(one.parameters, other.parameters, strict=True)}
    states = {p.state.symbol: q.state.symbol for p, q in zip(one.states, other.states, strict=True)}
    symbols = states | {sp.Symbol(p, real=True): sp.Symbol(q, real=True) for p, q in ids.items()}
    here = [None if e is None else e.xreplace(symbols) for e in _expressions(one)]
    return ids if here == _expressions(other) else None


def id_of(key: str) -> str:
    """Return the id of an effect by its `Effect.key`.

    Parameters
    ----------
    key
        ``id``, or ``id:variant``.

    Returns
    -------
    str
    """
    return key.partition(":")[0]


def _expressions(effect: Effect) -> list[sp.Expr | None]:
    """All formulas of an effect."""
    found = [getattr(effect, name) for name in FORMULAS]
    return found + [e for x in effect.states for e in (x.rhs, x.rate)]


def parameter(
    id: str, unit: str, description: str, initial: float, lower: float, upper: float, **more: Any
) -> Quantity:
    """Make one parameter of an effect.

    Parameters
    ----------
    id, unit, description
        Name of the symbol, SI unit for a revolute joint, words for a reader.
    initial, lower, upper
        Typical size and bounds, as multiples of the scale that the effect's ``relative`` names.
    **more
        Further fields of `Quantity`.

    Returns
    -------
    Quantity
        The parameter.
    """
    return Quantity(id=id, unit=unit, description=description, initial=initial, lower=lower, upper=upper, **more)


def reference(id: str, unit: str, description: str) -> Quantity:
    """Make a fixed parameter for a scale that a formula refers to; its value is 1 times the scale in ``relative``.

    Parameters
    ----------
    id, unit, description
        Name of the symbol, SI unit for a revolute joint, words for a reader.

    Returns
    -------
    Quantity
        The fixed parameter.
    """
    return Quantity(id=id, unit=unit, description=description, initial=1.0, lower=0.0, upper=1e12, fixed=True)


def fade_in(amplitude: sp.Symbol, least: sp.Expr, full: sp.Expr, without: sp.Expr) -> sp.Expr:
    """Blend linearly from ``without`` at amplitude 0 to ``full`` at amplitude ``least``; beyond it ``full`` holds.

    Parameters
    ----------
    amplitude
        Symbol of the amplitude, not negative.
    least
        Smallest amplitude at which ``full`` is used unchanged, in the unit of the amplitude.
    full
        Expression of the amplitude that is singular at 0 (a time constant, a compliance).
    without
        Expression without the effect.

    Returns
    -------
    sympy.Expr
        without + a/h·(full(h) − without) with h = max(a, least).

    Notes
    -----
    Below ``least`` the deviation is evaluated at ``least`` and scaled linearly, so that the effect vanishes exactly and
    has a derivative at 0.
    """
    # the larger of the two is never 0, so that ``full`` is evaluated away from its singularity
    held = sp.Max(amplitude, least)
    return without + amplitude / held * (full.subs(amplitude, held) - without)
