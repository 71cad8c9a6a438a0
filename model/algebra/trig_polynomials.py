"""Exact trigonometric polynomials in the free joints' positions.

An element is a polynomial in c_j = cos q_j, s_j = sin q_j (q_j itself for a prismatic joint) with rational
coefficients. With s² → 1 − c² it is canonical: two expressions are equal exactly when their polynomials are.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

import sympy as sp
from sympy.polys.domains import QQ
from sympy.polys.rings import ring

from haptid.model.algebra.rational_rotations import cos_sin, rational
from haptid.model.algebra.vectors import Scalar
from haptid.model.device.device import Device

Polynomial = Any
"""An element of a `TrigRing` (SymPy's sparse PolyElement)."""
Monomial = tuple[int, ...]


def position_symbol(joint: int) -> sp.Symbol:
    """Return the SymPy symbol q_j of a joint's position.

    Parameters
    ----------
    joint
        Number j of the joint.

    Returns
    -------
    sympy.Symbol
        Real symbol ``q<j>`` [rad] or [m].
    """
    return sp.Symbol(f"q{joint}", real=True)


def velocity_symbol(joint: int) -> sp.Symbol:
    """Return the SymPy symbol v_j of a joint's velocity q̇_j.

    Parameters
    ----------
    joint
        Number j of the joint.

    Returns
    -------
    sympy.Symbol
        Real symbol ``v<j>`` [rad/s] or [m/s].
    """
    return sp.Symbol(f"v{joint}", real=True)


class TrigRing:
    """Coordinates with free joints as generators and locked ones as rational constants.

    Parameters
    ----------
    device
        Device, which says which joints are prismatic.
    free
        Joints that stay symbols.
    posture
        Positions of all joints [rad] or [m], shape (n_q,); entries of free joints are ignored.
    """

    def __init__(self, device: Device, free: Sequence[int], posture: Sequence[float]) -> None:
        self.free, self.posture = tuple(free), tuple(float(x) for x in posture)
        self._locked = {j: float(x) for j, x in enumerate(posture) if j not in self.free}
        self._prismatic = {j for j in self.free if device.joints[j].prismatic}
        names = [name for j in self.free for name in ([f"q{j}"] if j in self._prismatic else [f"c{j}", f"s{j}"])]
        self.ring, *generators = ring(names, QQ) if names else ring("one", QQ)
        self._generator = dict(zip(names, generators, strict=False))
        self._index = {name: i for i, name in enumerate(names)}
        self._sines = [self._index[f"s{j}"] for j in self.free if j not in self._prismatic]
        self.names = tuple(names)

    def constant(self, value: Fraction | int) -> Scalar:
        """Return a rational number as an element.

        Parameters
        ----------
        value
            Rational number.

        Returns
        -------
        Polynomial
            Constant element of the ring.
        """
        fraction = Fraction(value)
        return self.ring.ground_new(QQ(fraction.numerator, fraction.denominator))

    def cos_sin(self, moved_by: Mapping[int, Fraction]) -> tuple[Scalar, Scalar]:
        """Return cosine and sine of Σ moved_by[j]·q_j by the addition theorems.

        Parameters
        ----------
        moved_by
            Joint → coefficient; whole numbers for free joints.

        Returns
        -------
        tuple of Polynomial
            (cos, sin) in canonical form.
        """
        c, s = self.ring.one, self.ring.zero
        locked = sum((float(ratio) * self._locked[j] for j, ratio in moved_by.items() if j in self._locked), 0.0)
        if locked != 0.0:
            c, s = (self.constant(value) for value in cos_sin(locked))
        for j, ratio in moved_by.items():
            if j in self.free:
                cj, sj = self._generator[f"c{j}"], self._generator[f"s{j}"]
                for _ in range(abs(int(ratio))):
                    c, s = (c * cj - s * sj, s * cj + c * sj) if ratio > 0 else (c * cj + s * sj, s * cj - c * sj)
        return self.tidy(c), self.tidy(s)

    def travel(self, moved_by: Mapping[int, Fraction]) -> Scalar:
        """Return Σ moved_by[j]·q_j, with locked joints at their posture.

        Parameters
        ----------
        moved_by
            Joint → coefficient; free joints are prismatic.

        Returns
        -------
        Polynomial
            Linear element of the ring [m].
        """
        total = self.ring.zero
        for j, ratio in moved_by.items():
            position = self._generator[f"q{j}"] if j in self.free else self.constant(rational(self._locked[j]))
            total = total + self.constant(ratio) * position
        return total

    def tidy(self, value: Scalar) -> Scalar:
        """Return the canonical form of an element.

        Parameters
        ----------
        value
            Element of the ring; a plain int is returned unchanged.

        Returns
        -------
        Polynomial
            The element after s² → 1 − c² until every sine has at most the first power.
        """
        if isinstance(value, int):
            return value
        while any(monomial[i] > 1 for monomial in value for i in self._sines):
            value = self._once(value)
        return value

    def _once(self, value: Polynomial) -> Polynomial:
        result: dict[Monomial, Any] = {}
        for monomial, coefficient in value.items():
            i = next((i for i in self._sines if monomial[i] > 1), None)
            if i is None:
                _accumulate(result, monomial, coefficient)
                continue
            lower = (*monomial[:i], monomial[i] - 2, *monomial[i + 1 :])
            _accumulate(result, lower, coefficient)
            # the generator c_j stands directly before s_j in ``names``
            _accumulate(result, (*lower[: i - 1], lower[i - 1] + 2, *lower[i:]), -coefficient)
        return self.ring.from_dict({monomial: x for monomial, x in result.items() if x})

    def element(self, value: Scalar) -> Polynomial:
        """Return a scalar, possibly a plain int, as an element.

        Parameters
        ----------
        value
            Element of the ring or a plain int.

        Returns
        -------
        Polynomial
            Element of the ring.
        """
        return self.ring.ground_new(QQ(value)) if isinstance(value, int) else value

    def derivative(self, value: Polynomial, joint: int) -> Polynomial:
        """Differentiate an element with respect to a joint's position.

        Parameters
        ----------
        value
            Element of the ring.
        joint
            Number j of a free joint.

        Returns
        -------
        Polynomial
            ∂value/∂q_j = c·∂value/∂s − s·∂value/∂c in canonical form.
        """
        if joint in self._prismatic:
            return value.diff(self._generator[f"q{joint}"])
        c, s = self._generator[f"c{joint}"], self._generator[f"s{joint}"]
        return self.tidy(value.diff(s) * c - value.diff(c) * s)

    def expression(self, monomial: Monomial) -> sp.Expr:
        """Return a monomial as a SymPy expression of q_j.

        Parameters
        ----------
        monomial
            Powers of the generators, in the order of ``names``.

        Returns
        -------
        sympy.Expr
            Product of powers of cos q_j, sin q_j and, for prismatic joints, q_j.
        """
        return sp.Mul(*(self._function(name) ** power for name, power in zip(self.names, monomial, strict=False)))

    def label(self, monomial: Monomial) -> str:
        """Return a monomial as an identifier: 1, c1, c1s2, c1c1, …; q1q1 for a prismatic joint.

        Parameters
        ----------
        monomial
            Powers of the generators, in the order of ``names``.

        Returns
        -------
        str
            Names of the generators, each as often as its power says.
        """
        return "".join(name * power for name, power in zip(self.names, monomial, strict=False)) or "1"

    def _function(self, name: str) -> sp.Expr:
        q = position_symbol(int(name[1:]))
        return {"c": sp.cos(q), "s": sp.sin(q), "q": q}[name[0]]


def _accumulate(result: dict[Monomial, Any], monomial: Monomial, value: Scalar) -> None:
    result[monomial] = result.get(monomial, 0) + value
