"""The equation of motion of a few free joints with all others locked, and its coefficients.

M(q)·q̈ + C(q, q̇)·q̇ + φ(q) = torques, where M and φ are sums of coefficients times products of cos q_j and sin q_j.
`Device`, free joints and posture come in, `LockedDynamics` goes out:

1. `derive` gives M and V as exact linear forms in the inertial parameters π.
2. Every monomial of an entry has a row over π. A row that is linearly independent of the earlier rows becomes a
   `Coefficient`; a dependent row is written as the exact combination of the earlier coefficients.
3. C·q̇ follows from M by the Christoffel symbols.

The coefficients are thus the base parameters of the configuration at this posture.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
import sympy as sp
from numpy.typing import NDArray

from haptid.model.algebra.echelon import Row, combinations_of
from haptid.model.algebra.trig_polynomials import Monomial, TrigRing, position_symbol, velocity_symbol
from haptid.model.device.device import Device
from haptid.model.rigid_body.inertial_parameters import pi_ids, pi_prior
from haptid.model.rigid_body.lagrange import Lagrangian, LinearForm, derive

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Coefficient:
    """One coefficient of a locked equation.

    Parameters
    ----------
    id, unit, description
        ``inertia``, ``gravity_cos``, ``gravity_sin`` for one joint; ``M01_c1`` (of cos q1 in M01), ``V_s1`` (of sin q1
        in the potential) for several.
    exact
        Linear map from π, sparse and rational: index into `pi_ids` → factor.
    linear_map
        The same, shape (n_pi,).
    initial
        Value at the device's first guesses.
    prior_std
        Standard deviation at the device's stated uncertainty, to first order; the prior's mean is `initial`.
    """

    id: str
    unit: str
    description: str
    exact: Row
    linear_map: Array
    initial: float
    prior_std: float

    @property
    def symbol(self) -> sp.Symbol:
        """The SymPy symbol of the same name."""
        return sp.Symbol(self.id, real=True)


@dataclass(frozen=True, slots=True, kw_only=True)
class LockedDynamics:
    """Equation of motion of the free joints (symbols q<j>, v<j> and the coefficients').

    Parameters
    ----------
    joints
        The n free joints, ascending.
    posture
        Positions of all joints [rad] or [m], shape (n_q,); entries of free joints are 0.
    mass_matrix, christoffel_force, gravity_force
        M (n, n), C·q̇ (n,) and φ (n,).
    coefficients
        In the order in which the equation needs them.
    """

    joints: tuple[int, ...]
    posture: tuple[float, ...]
    mass_matrix: sp.ImmutableMatrix
    christoffel_force: sp.ImmutableMatrix
    gravity_force: sp.ImmutableMatrix
    coefficients: tuple[Coefficient, ...]

    @property
    def linear_map(self) -> Array:
        """Rows of all coefficients, shape (n_coefficients, n_pi)."""
        return np.array([coefficient.linear_map for coefficient in self.coefficients])


def locked_motion(device: Device, free_joints: Sequence[int], posture: Sequence[float] | None = None) -> LockedDynamics:
    """Derive the equation of motion of the free joints, all others locked.

    Parameters
    ----------
    device
        Device with n_q joints.
    free_joints
        Numbers of the free joints, in any order.
    posture
        Positions of all joints [rad] or [m], shape (n_q,); entries of free joints are ignored. All 0 where None or
        empty.

    Returns
    -------
    LockedDynamics
        Equation of motion in the symbols q<j>, v<j> and its linearly independent coefficients.
    """
    free = tuple(sorted(free_joints))
    given = posture if posture is not None and len(posture) else (0.0,) * len(device.joints)
    where = tuple(0.0 if j in free else float(x) for j, x in enumerate(given))
    table = _Table(device, derive(device, free, where))
    n = range(len(free))
    # diagonal entries first: a row that stands in several entries becomes a coefficient of the diagonal one
    pairs = [(i, i) for i in n] + [(i, j) for i in n for j in n[i + 1 :]]
    phi = table.read_motion({f"M{free[i]}{free[j]}": (i, j) for i, j in pairs})
    M = sp.Matrix(len(free), len(free), lambda i, j: table.expressions[f"M{free[min(i, j)]}{free[max(i, j)]}"])
    return LockedDynamics(
        joints=free,
        posture=where,
        mass_matrix=sp.ImmutableMatrix(M),
        christoffel_force=sp.ImmutableMatrix(christoffel_force(M, free)),
        gravity_force=sp.ImmutableMatrix(phi),
        coefficients=tuple(table.coefficients),
    )


def christoffel_force(M: sp.Matrix, joints: tuple[int, ...]) -> sp.Matrix:
    """Compute the Coriolis and centrifugal torques of a mass matrix.

    Parameters
    ----------
    M
        Mass matrix in the symbols q<j>, shape (n, n).
    joints
        Numbers j of the n joints.

    Returns
    -------
    sympy.Matrix
        C·q̇, shape (n,), with c_i = Σ_jk (∂M_ij/∂q_k − ½ ∂M_jk/∂q_i)·q̇_j·q̇_k in the symbols q<j>, v<j>.
    """
    q, v = [position_symbol(j) for j in joints], sp.Matrix([velocity_symbol(j) for j in joints])
    return sp.Matrix(
        [
            sum(((M[i, :] * v)[0].diff(qk) * vk for qk, vk in zip(q, v, strict=True)), sp.S.Zero)
            - (v.T * M.diff(q[i]) * v)[0] / 2
            for i in range(len(joints))
        ]
    )


def rows_of(form: LinearForm) -> dict[Monomial, Row]:
    """Sort a linear form in π by monomial.

    Parameters
    ----------
    form
        Index into π → polynomial.

    Returns
    -------
    dict of Monomial to Row
        Monomial, by ascending total degree → row over π.
    """
    rows: dict[Monomial, Row] = {}
    for k, polynomial in form.items():
        for monomial, value in polynomial.items():
            rows.setdefault(monomial, {})[k] = Fraction(int(value.numerator), int(value.denominator))
    return dict(sorted(rows.items(), key=lambda item: (sum(item[0]), tuple(-power for power in item[0]))))


class _Table:
    """Collect coefficients: a new one for each independent row, a combination of earlier ones for a dependent row."""

    def __init__(self, device: Device, lagrangian: Lagrangian) -> None:
        self.device, self.lagrangian = device, lagrangian
        self.ring: TrigRing = lagrangian.ring
        self.coefficients: list[Coefficient] = []
        self.expressions: dict[str, sp.Expr] = {}
        self._ids = pi_ids(device)
        self._mean, self._covariance = pi_prior(device)
        self._single = len(self.ring.free) == 1

    def read_motion(self, entries: Mapping[str, tuple[int, int]]) -> sp.Matrix:
        """Express the entries of M in coefficients, and return φ in coefficients.

        φ of one joint has coefficients of its own, even where its rows depend on those of M: a slide's constant force
        is a multiple of its mass, and still has its own name. Of several joints it is the gradient of the potential.
        """
        masses = [(name, self.lagrangian.entry(*entry), entry) for name, entry in entries.items()]
        if self._single:
            self._read(masses)
            self._read([("gravity", self.lagrangian.gravity(0), (0,))])
            return sp.Matrix([self.expressions["gravity"]])
        self._read([*masses, ("V", self.lagrangian.potential, ())])
        return sp.Matrix([self.expressions["V"].diff(position_symbol(j)) for j in self.ring.free])

    def _read(self, forms: Sequence[tuple[str, LinearForm, tuple[int, ...]]]) -> None:
        """Express entries of M and φ in coefficients."""
        terms = [(name, monomial, row, entry) for name, form, entry in forms for monomial, row in rows_of(form).items()]
        first = len(self.coefficients)
        totals: dict[str, sp.Expr] = dict.fromkeys((name for name, _, _ in forms), sp.S.Zero)
        combinations = combinations_of([row for _, _, row, _ in terms])
        for (name, monomial, row, entry), combination in zip(terms, combinations, strict=True):
            if combination is None:
                self.coefficients.append(self._coefficient(name, monomial, row, entry))
                factor = self.coefficients[-1].symbol
            else:
                parts = [
                    sp.Rational(share.numerator, share.denominator) * self.coefficients[first + number].symbol
                    for number, share in combination.items()
                ]
                factor = sp.Add(*parts)
            totals[name] += factor * self.ring.expression(monomial)
        self.expressions |= totals

    def _coefficient(self, name: str, monomial: Monomial, row: Row, entry: tuple[int, ...]) -> Coefficient:
        linear_map = np.zeros(len(self._ids))
        for k, value in row.items():
            linear_map[k] = float(value)
        linear_map.flags.writeable = False
        term = self.ring.expression(monomial)
        return Coefficient(
            id=self._id(name, monomial),
            unit=self._unit(monomial, entry),
            description=self._description(name, term),
            exact=row,
            linear_map=linear_map,
            initial=float(linear_map @ self._mean),
            prior_std=float(np.sqrt(linear_map @ self._covariance @ linear_map)),
        )

    def _id(self, name: str, monomial: Monomial) -> str:
        label = self.ring.label(monomial)
        if not self._single:
            return f"{name}_{label}"
        if name == "gravity":
            joint = self.ring.free[0]
            return {"1": "gravity_cos", f"c{joint}": "gravity_cos", f"s{joint}": "gravity_sin"}.get(
                label, f"gravity_{label}"
            )
        return "inertia" if label == "1" else f"inertia_{label}"

    def _description(self, name: str, term: sp.Expr) -> str:
        kind = {"g": "Gravity", "V": "Potential energy"}.get(name[0], f"Mass matrix entry {name}")
        posture = ", ".join(f"q{j} = {x:g}" for j, x in enumerate(self.ring.posture) if x)
        locked = f", locked at {posture}" if posture else ""
        return f"{kind}: coefficient of {term}{locked}" if term != 1 else f"{kind}: constant part{locked}"

    def _unit(self, monomial: Monomial, entry: tuple[int, ...]) -> str:
        slides = [self.device.joints[self.ring.free[i]].prismatic for i in entry]
        powers = sum(power for name, power in zip(self.ring.names, monomial, strict=False) if name[0] == "q")
        if len(entry) == 2:
            return _unit("kg", 2 - sum(slides) - powers)
        return _unit("N", 1 - sum(slides) - powers)


def _unit(stem: str, power: int) -> str:
    if power < 0:
        return f"{stem}/m" if power == -1 else f"{stem}/m^{-power}"
    return {0: stem, 1: f"{stem} m"}.get(power, f"{stem} m^{power}")
