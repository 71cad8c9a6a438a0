"""Steps along the valley of a spring and its equilibrium position: `Problem` in, `Retraction` out.

A straight step in (Ks, epos) changes the spring's torque at q = 0, o = Ks·epos, by ΔKs·Δepos and climbs out of the
valley (`identification.problem.valleys`). A step d therefore moves Ks and o linearly, with the same tangent, and epos
follows:

    Ks⁺ = Ks + d_K,   epos⁺ = (Ks·epos + Ks·d_e + epos·d_K)/Ks⁺.

Bounds of epos stay linear in d: lower·Ks⁺ ≤ Ks⁺·epos⁺ ≤ upper·Ks⁺.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from haptid.identification.problem.residuals import Problem
from haptid.identification.problem.valleys import Spring, Valleys
from haptid.measurement.values.run import Array

LEAST_STIFFNESS_OVER_UNIT = 1e-9
"""Smallest stiffness, over its scale w, at which the equilibrium position still follows the step in stiffness."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Retraction:
    """Moves the unknowns of a problem along curved valleys and bounds the steps.

    Parameters
    ----------
    problem
        Problem with the unknowns x (n,).
    springs
        Springs whose stiffness and equilibrium position are moved together.
    """

    problem: Problem
    springs: tuple[Spring, ...]

    @classmethod
    def of(cls, problem: Problem) -> Retraction:
        """Find the springs whose stiffness and equilibrium position are both free and of linear scale.

        Parameters
        ----------
        problem
            Problem whose parameters are searched by id (``Ks…`` with ``epos…``).

        Returns
        -------
        Retraction
        """
        springs = tuple(spring for spring in Valleys.of(problem.parametrisation).springs if not spring.log)
        return cls(problem=problem, springs=springs)

    def move(self, x: Array, d: Array) -> Array:
        """Move the unknowns along a step.

        Parameters
        ----------
        x, d
            Unknowns and step, shape (n,).

        Returns
        -------
        ndarray, shape (n,)
            x + d, with epos⁺ = (Ks·epos + Ks·d_e + epos·d_K)/Ks⁺ for every spring.
        """
        y = x + d
        for spring in self.springs:
            (K, e), (after, _) = spring.physical(x), spring.physical(y)
            # Without a stiffness above 0, before and after, the quotient has no meaning: the step stays straight.
            if min(K, after) > LEAST_STIFFNESS_OVER_UNIT * spring.stiffness_unit:
                d_K, d_e = after - K, spring.position_unit * float(d[spring.position])
                y[spring.position] = (
                    (K * e + K * d_e + e * d_K) / after - spring.position_centre
                ) / spring.position_unit
        return y

    def slope(self, x: Array, d: Array) -> Array:
        """Differentiate `move` by the step.

        Parameters
        ----------
        x, d
            Unknowns and step, shape (n,).

        Returns
        -------
        ndarray, shape (n, n)
            ∂move(x, d)/∂d.
        """
        result, y = np.eye(x.size), self.move(x, d)
        for spring in self.springs:
            (K, e), (after, now) = spring.physical(x), spring.physical(y)
            if min(K, after) > LEAST_STIFFNESS_OVER_UNIT * spring.stiffness_unit:
                result[spring.position, spring.position] = K / after
                change = (e - now) / after * spring.stiffness_unit / spring.position_unit
                result[spring.position, spring.stiffness] = change
        return result

    def constraints(self, x: Array) -> tuple[Array, Array]:
        """Write bounds and orderings of the moved unknowns as linear inequalities A·d ≥ slack of the step.

        Parameters
        ----------
        x
            Unknowns, shape (n,).

        Returns
        -------
        A : ndarray, shape (n_c, n)
            Coefficients.
        slack : ndarray, shape (n_c,)
            Limits, none above 0.
        """
        A, b = self.problem.constraints()
        # Where rounding has x beyond a bound, slack 0 keeps d = 0 feasible.
        A, slack = A.copy(), np.minimum(b - A @ x, 0.0)
        for spring in self.springs:
            stiffness = spring.physical(x)[0]
            if stiffness > LEAST_STIFFNESS_OVER_UNIT * spring.stiffness_unit:
                rows = np.flatnonzero(A[:, spring.position])
                # Distance from the bound in units of epos, times the relative change of Ks.
                A[rows, spring.stiffness] -= slack[rows] * spring.stiffness_unit / stiffness
        return A, slack
