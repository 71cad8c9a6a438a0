"""Equations of motion as data: the single source of kernel, FMU, parameter tables and reports.

SymPy expressions of states, inputs and parameters come in, an immutable `Equations` goes out. All symbols are real and
bear the id of their quantity, so that a symbol made anywhere from the same id is the same symbol.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import sympy as sp

from haptid.model.equations.drive import Drive
from haptid.model.equations.quantity import Quantity

TIME = sp.Symbol("t", real=True)
"""Time since the start of the run [s]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class State:
    """A state of the equations.

    Parameters
    ----------
    id
        Name of the symbol (``q``, ``v``, ``z``).
    unit, description
        SI unit and words for a reader.
    start
        Value at the start of a run, in ``unit``.
    nominal
        Typical magnitude, in ``unit``.
    structured
        Structured name of the FMU variable.
    start_std
        Standard deviation of the start value over the runs, in ``unit``; 0 where ``start`` holds for every run.
    """

    id: str
    unit: str
    description: str
    start: float = 0.0
    nominal: float = 1.0
    structured: str = ""
    start_std: float = 0.0

    @property
    def symbol(self) -> sp.Symbol:
        """The SymPy symbol of this state."""
        return sp.Symbol(self.id, real=True)


@dataclass(frozen=True, slots=True, kw_only=True)
class Input:
    """An input that runs linearly inside a step: value at the step's start, and a slope (0 for a zero-order hold).

    Parameters
    ----------
    id
        Name of the symbol (``tau``).
    unit, description
        SI unit and words for a reader.
    structured
        Structured name of the FMU variable.
    start
        Value of an FMU that nobody gives this input, in ``unit``.
    """

    id: str
    unit: str
    description: str
    structured: str = ""
    start: float = 0.0

    @property
    def symbol(self) -> sp.Symbol:
        """The SymPy symbol of this input."""
        return sp.Symbol(self.id, real=True)


@dataclass(frozen=True, slots=True, kw_only=True)
class Output:
    """An output: an expression of time, states, inputs, parameters and definitions.

    Parameters
    ----------
    id
        Name in the arrays of outputs (``y``).
    unit, description
        SI unit and words for a reader.
    expression
        Formula, in ``unit``.
    structured
        Structured name of the FMU variable.
    """

    id: str
    unit: str
    description: str
    expression: sp.Expr
    structured: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Equations:
    """ẋ = f(t, x, u, p), y = g(t, x, u, p), or M(x, p) v̇ = h(t, x, u, p) for velocities v with a ``mass_matrix`` M.

    Parameters
    ----------
    name, title
        Identifier, valid as a C identifier (``joint4``), and words for a reader.
    joints
        The free joints, in order. Their positions are the first ``len(joints)`` states and the first outputs,
        their velocities the next ``len(joints)`` states.
    states, inputs, outputs, parameters
        In the order of the arrays x (n_x,), u (n_u,), y (n_y,), p (n_p,).
    definitions
        Intermediate quantities, each an expression of states, inputs, parameters and earlier definitions, for use in
        rhs, rates, outputs and mass_matrix.
    rhs
        f, shape (n_x,). Where ``mass_matrix`` is given, the entries of the velocities hold h instead.
    rates
        Relaxation rates aᵢ ≥ 0 [1/s], shape (n_x,): an estimate of −∂fᵢ/∂xᵢ that the stepper integrates exactly.
        Zero where the state is not stiff. That of LuGre's bristle is σ0·|v|/g(v).
    mass_matrix
        Symmetric M, shape (n_q, n_q), or None where rhs is explicit. Sensitivities exist only for explicit equations.
    inertia
        Symmetric M, shape (n_q, n_q), of explicit equations that were solved for the accelerations by it: what must be
        positive definite for them to make sense. None where there is none, or it stands in ``mass_matrix``.
    orderings
        Pairs (a, b) of parameter ids with a ≥ b required, as (Fs, Fc).
    effects
        Ids of the effects that were added to the nominal model.
    friction
        The friction law of each joint, in the order of ``joints``; empty where there is none.
    drive
        What drives a single joint; None where the input is a torque.
    notes
        Sentences for the documentation of an FMU.
    """

    name: str
    title: str
    joints: tuple[int, ...]
    states: tuple[State, ...]
    inputs: tuple[Input, ...]
    outputs: tuple[Output, ...]
    parameters: tuple[Quantity, ...]
    rhs: tuple[sp.Expr, ...]
    rates: tuple[sp.Expr, ...]
    definitions: tuple[tuple[sp.Symbol, sp.Expr], ...] = ()
    mass_matrix: tuple[tuple[sp.Expr, ...], ...] | None = None
    inertia: tuple[tuple[sp.Expr, ...], ...] | None = None
    orderings: tuple[tuple[str, str], ...] = ()
    effects: tuple[str, ...] = ()
    friction: tuple[str, ...] = ()
    drive: Drive | None = None
    notes: tuple[str, ...] = field(default=())

    def __post_init__(self) -> None:
        """Check lengths, names and that every formula uses defined symbols only.

        Raises
        ------
        ValueError
            Where the numbers of states, right-hand sides and rates differ, two quantities share a name, or a formula
            uses an undefined symbol.
        """
        n = len(self.states)
        if len(self.rhs) != n or len(self.rates) != n:
            msg = f"{self.name}: {n} states, but {len(self.rhs)} right-hand sides and {len(self.rates)} rates"
            raise ValueError(msg)
        named: tuple[State | Input | Quantity, ...] = (*self.states, *self.inputs, *self.parameters)
        known = {TIME, *(x.symbol for x in named)}
        if len(known) != 1 + n + len(self.inputs) + len(self.parameters):
            msg = f"{self.name}: two quantities share a name"
            raise ValueError(msg)
        for symbol, expression in self.definitions:
            # a definition becomes known only after its own check: it may use earlier definitions, not itself
            self._check(known, symbol.name, expression)
            known.add(symbol)
        for state, f, a in zip(self.states, self.rhs, self.rates, strict=True):
            self._check(known, f"rhs of {state.id}", f)
            self._check(known, f"rate of {state.id}", a)
        for output in self.outputs:
            self._check(known, f"output {output.id}", output.expression)

    def _check(self, known: set[sp.Symbol], where: str, expression: sp.Expr) -> None:
        unknown = sp.sympify(expression).free_symbols - known
        if unknown:
            msg = f"{self.name}: {where} uses undefined {sorted(s.name for s in unknown)}"
            raise ValueError(msg)

    def parameter(self, id: str) -> Quantity:
        """Return the parameter with this id.

        Parameters
        ----------
        id
            Id of the parameter, as ``sigma0``.

        Returns
        -------
        Quantity
            The row of the parameter table.

        Raises
        ------
        KeyError
            Where there is no such parameter; the message lists the known ids.
        """
        for quantity in self.parameters:
            if quantity.id == id:
                return quantity
        msg = f"{self.name} has no parameter {id!r}; it has {[q.id for q in self.parameters]}"
        raise KeyError(msg)

    def with_parameters(self, changes: dict[str, dict[str, Any]]) -> Equations:
        """Return a copy in which the named parameters have changed fields.

        Parameters
        ----------
        changes
            Changed fields of `Quantity` by parameter id, e.g. ``{"Kp": {"fixed": True}}``.

        Returns
        -------
        Equations
            The same formulas with the changed parameter table.

        Raises
        ------
        KeyError
            Where an id is no parameter of the equations.
        """
        for id in changes:
            self.parameter(id)
        return replace(self, parameters=tuple(q.but(**changes.get(q.id, {})) for q in self.parameters))

    def without_definitions(self) -> Equations:
        """Substitute the definitions into all formulas, so that derivatives of the formulas are total derivatives.

        Returns
        -------
        Equations
            Equivalent equations without definitions; the same object where there are none.
        """
        if not self.definitions:
            return self
        inside: dict[sp.Symbol, sp.Expr] = {}
        # in order: each definition is expanded by those before it, so that one substitution is enough afterwards
        for symbol, expression in self.definitions:
            inside[symbol] = sp.sympify(expression).xreplace(inside)

        return replace(self.substitute(inside), definitions=())

    def substitute(self, expressions: Mapping[sp.Symbol, sp.Expr], *, outputs: bool = True) -> Equations:
        """Put expressions in the place of symbols, all at once, in all formulas.

        Parameters
        ----------
        expressions
            Expressions of states, inputs and parameters by the symbol that each replaces.
        outputs
            Whether the outputs are changed too; otherwise they stay as they are.

        Returns
        -------
        Equations
            The same states, inputs and parameters with the changed formulas.
        """
        inside = dict(expressions)

        def put_in(formulas: Iterable[sp.Expr]) -> tuple[sp.Expr, ...]:
            return tuple(sp.sympify(e).xreplace(inside) for e in formulas)

        changed = put_in(o.expression for o in self.outputs) if outputs else [o.expression for o in self.outputs]
        return replace(
            self,
            rhs=put_in(self.rhs),
            rates=put_in(self.rates),
            outputs=tuple(replace(o, expression=e) for o, e in zip(self.outputs, changed, strict=True)),
            definitions=tuple((symbol, put_in((e,))[0]) for symbol, e in self.definitions),
            mass_matrix=None if self.mass_matrix is None else tuple(put_in(row) for row in self.mass_matrix),
            inertia=None if self.inertia is None else tuple(put_in(row) for row in self.inertia),
        )

    @property
    def starts(self) -> tuple[int, ...]:
        """Indices of the states whose initial value is fitted: positions, velocities, and those that have a start_std.

        All states where there are no joints.
        """
        moving = 2 * len(self.joints) or len(self.states)
        return tuple(k for k, state in enumerate(self.states) if k < moving or state.start_std > 0)

    @property
    def digest(self) -> str:
        """Sixteen hex digits of the SHA-256 of name, ids and formulas; guesses, bounds and units do not enter."""
        return self._digest_of(self.name, self.joints)

    @property
    def formula_digest(self) -> str:
        """Sixteen hex digits of the SHA-256 of ids and formulas, which joints that move alone share.

        Of the joints only their count enters.
        """
        return self._digest_of(len(self.joints))

    def _digest_of(self, *about: object) -> str:
        text = repr(
            (
                *about,
                [s.id for s in self.states],
                [u.id for u in self.inputs],
                [q.id for q in self.parameters],
                [sp.srepr(d) for _, d in self.definitions],
                [sp.srepr(sp.sympify(e)) for e in (*self.rhs, *self.rates)],
                [(o.id, sp.srepr(sp.sympify(o.expression))) for o in self.outputs],
                [[sp.srepr(sp.sympify(e)) for e in row] for row in self.mass_matrix or ()],
            )
        )
        return hashlib.sha256(text.encode()).hexdigest()[:16]
