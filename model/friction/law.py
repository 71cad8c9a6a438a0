"""A friction law as data and formulas: each file beside this one may define a ``LAW``, which the registry finds.

A `FrictionLaw` gives equations, kernel and FMUs the parameters, states and torque; fits the first guesses, orderings
and passivity; effects the slots that they may fill; warnings and scales the role of each parameter.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import sympy as sp

from haptid.model.equations.equations import State
from haptid.model.equations.joint_parameters import Row

Values = Mapping[str, float]
Symbols = Mapping[str, sp.Expr]
SLOTS = (
    "friction_level", "coulomb_level", "kinetic_level", "viscous_level", "stribeck_velocity", "stribeck_argument",
)  # fmt: skip
"""Slots of a law that effects may fill, by the names of `model.effects.effect.Effect`."""
FALL = sp.Symbol("fall", real=True)
"""(v/vs)², the argument of the exponential in the Stribeck curve as every law writes it."""
USE_OF_BRISTLE = "bristle"
"""Slot of a law whose state is one bristle deflection z, which an effect's formulas may read."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Levels:
    """The contribution of effects to a law: factors, and speed and argument of the Stribeck curve.

    Parameters
    ----------
    friction
        Factor on the level of dry friction as a whole.
    coulomb, kinetic
        Factors on Fc and Fs alike, and on Fc alone.
    viscous
        Factor on the viscous friction.
    stribeck_velocity
        Speed in the Stribeck curve [rad/s]; the joint's where None.
    stribeck_argument
        Argument of the exponential in the Stribeck curve, an expression of `FALL`; `FALL` itself where None.
    """

    friction: sp.Expr = sp.S.One
    coulomb: sp.Expr = sp.S.One
    kinetic: sp.Expr = sp.S.One
    viscous: sp.Expr = sp.S.One
    stribeck_velocity: sp.Expr | None = None
    stribeck_argument: sp.Expr | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Friction:
    """A friction law written out in the symbols of its states.

    Parameters
    ----------
    force
        Friction torque [N m].
    rhs
        Rates of change of the states, in their units per second.
    rates
        Relaxation rates aᵢ [1/s], estimates of −∂ẋᵢ/∂xᵢ from above. The stepper integrates aᵢ exactly, and is stable at
        any step where aᵢ is at least half of the true rate.
    """

    force: sp.Expr
    rhs: tuple[sp.Expr, ...]
    rates: tuple[sp.Expr, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Roles:
    """Ids of the parameters of a law by their physical role.

    Parameters
    ----------
    stiffness
        Stiffness in presliding; empty in a law without presliding.
    coulomb, stiction
        Levels of dry friction; the same id twice in a law without stiction.
    viscous
        Viscous friction.
    stribeck_velocity
        Stribeck velocity; empty in a law without one.
    """

    stiffness: str
    coulomb: str
    stiction: str
    viscous: str
    stribeck_velocity: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Sliding:
    """Estimates from the data of a joint before any fit: friction in gross sliding, and scales.

    Parameters
    ----------
    coulomb, viscous
        Plateau [N m] and slope [N m s/rad] of friction over speed.
    inertia
        Inertia of the joint [kg m²].
    travel, speed
        Range of positions [rad] and largest speed [rad/s].
    """

    coulomb: float
    viscous: float
    inertia: float
    travel: float
    speed: float


@dataclass(frozen=True, slots=True, kw_only=True)
class FrictionLaw:
    """One friction law, as data and formulas; all ids without a joint's number, all units revolute.

    Parameters
    ----------
    id, title
        Name in files (``lugre``), name in words.
    formulas
        Formulas as a reader writes them: first the torque, as a sum, then the rates and their auxiliary functions.
    parameters
        Rows of the parameter table.
    states
        Internal states at rest: their ids must not be those of effects, their structured names begin ``friction.``.
    write
        (v, parameters by id, levels) → `Friction`, in the symbols of ``states``.
    damping
        (v, parameters by id) → estimate of ∂torque/∂v from above [N m s/rad], by which the speed relaxes.
    roles
        Parameters by their physical role.
    slots
        The slots of `SLOTS` that the law has, and `USE_OF_BRISTLE` where its state is ``z``.
    guess
        First guesses of all parameters from the data.
    nominal
        Values by id → size of each state.
    presliding_length
        Values by id → displacement after which the joint slides.
    without_presliding, without_sliding
        Ids of the parameters that are not identifiable from data without presliding, and from data without gross
        sliding.
    orderings
        Pairs (a, b) of ids with a ≥ b.
    passivity
        Expression of the parameters that must not be negative, on request; None where the law is always passive, or
        where a condition would remove a part of it.
    level
        (v, parameters by id) → level of dry friction at speed v in the form in which ``write`` holds it, for pages that
        give it a letter; None where there is none.
    """

    id: str
    title: str
    formulas: tuple[str, ...]
    parameters: tuple[Row, ...]
    states: tuple[State, ...]
    write: Callable[[sp.Expr, Symbols, Levels], Friction]
    damping: Callable[[sp.Expr, Symbols], sp.Expr]
    roles: Roles
    slots: frozenset[str]
    guess: Callable[[Sliding], dict[str, float]]
    nominal: Callable[[Values], tuple[float, ...]]
    presliding_length: Callable[[Values], float]
    without_presliding: tuple[str, ...]
    without_sliding: tuple[str, ...]
    orderings: tuple[tuple[str, str], ...] = ()
    passivity: sp.Expr | None = None
    level: Callable[[sp.Expr, Symbols], sp.Expr] | None = None

    def __post_init__(self) -> None:
        """Check that roles, orderings and slots name existing parameters and slots; ValueError where not."""
        ids = {row.id for row in self.parameters}
        named = {
            self.roles.stiffness, self.roles.coulomb, self.roles.stiction, self.roles.viscous,
            *self.without_presliding, *self.without_sliding, *(id for pair in self.orderings for id in pair),
        } - {""}  # fmt: skip
        known = {*SLOTS, USE_OF_BRISTLE}
        problems = [
            (not named <= ids, f"names {sorted(named - ids)}, which are no parameters of its"),
            (not self.slots <= known, f"offers {sorted(self.slots - known)}, which are none of {sorted(known)}"),
        ]
        for wrong, message in problems:
            if wrong:
                raise ValueError(f"friction law {self.id} {message}")  # noqa: EM102 - the message is made above

    @property
    def ids(self) -> tuple[str, ...]:
        """Ids of the parameters."""
        return tuple(row.id for row in self.parameters)

    def values(self, of: Values, tail: str = "") -> dict[str, float]:
        """Select the law's parameters among the values of a device.

        Parameters
        ----------
        of
            Values by id.
        tail
            End of the ids in ``of``, as ``_3`` of joint 3.

        Returns
        -------
        dict of str to float
            Values by plain id.

        Raises
        ------
        KeyError
            Where a parameter of the law is missing.
        """
        return {id: float(of[id + tail]) for id in self.ids}
