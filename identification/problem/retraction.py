"""Steps along the valleys of a spring and of bristles that are bent at the start: `Problem` in, `Retraction` out.

A straight step in (Ks, epos) changes the spring's torque at q = 0, o = Ks·epos, by ΔKs·Δepos and climbs out of the
valley (`identification.problem.valleys`). A step d therefore moves Ks and o linearly, with the same tangent, and epos
follows:

    Ks⁺ = Ks + d_K,   epos⁺ = (Ks·epos + Ks·d_e + epos·d_K)/Ks⁺.

Bounds of epos stay linear in d: lower·Ks⁺ ≤ Ks⁺·epos⁺ ≤ upper·Ks⁺.

Along a measured motion the friction at the start, σ₀·z₀, is what the torque tells, while the stiffness σ₀ in presliding
may move by orders of magnitude: at the same bristle deflection z₀ the first torques would do so too. With s = ln σ₀,

    z₀⁺ = (z₀ + d_z + z₀·d_s)·exp(−d_s).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from haptid.identification.problem.residuals import Problem
from haptid.identification.problem.valleys import Spring, Valleys
from haptid.measurement.values.run import Array
from haptid.model.friction.registry import law_named


@dataclass(frozen=True, slots=True, kw_only=True)
class Bristles:
    """Places of a stiffness in presliding, as its logarithm, and of the bristles' deflections at the start of a run.

    Parameters
    ----------
    stiffness
        Index of ln σ₀ among the unknowns.
    start
        Indices of the deflections δ among the unknowns, shape (n_z,).
    rest
        Deflection at δ = 0 over the unit of δ, shape (n_z,).
    """

    stiffness: int
    start: tuple[int, ...]
    rest: Array


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
    bristles
        Bristles of every run whose deflection at the start follows their stiffness.
    """

    problem: Problem
    springs: tuple[Spring, ...]
    bristles: tuple[Bristles, ...]

    @classmethod
    def of(cls, problem: Problem) -> Retraction:
        """Find what moves together: springs, and bristles whose start is fitted.

        Of a spring both parameters are free and of linear scale; bristles have a free start in every run along a
        measured motion, whose states are those of friction first.

        Parameters
        ----------
        problem
            Problem whose parameters are searched by id (``Ks…`` with ``epos…``).

        Returns
        -------
        Retraction
        """
        springs = tuple(spring for spring in Valleys.of(problem.parametrisation).springs if not spring.log)
        return cls(problem=problem, springs=springs, bristles=_bristles_of(problem))

    def move(self, x: Array, d: Array) -> Array:
        """Move the unknowns along a step.

        Parameters
        ----------
        x, d
            Unknowns and step, shape (n,).

        Returns
        -------
        ndarray, shape (n,)
            x + d, with epos⁺ = (Ks·epos + Ks·d_e + epos·d_K)/Ks⁺ for every spring, and
            z₀⁺ = (z₀ + d_z + z₀·d_s)·exp(−d_s) for all bristles.
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
        for some in self.bristles:
            places, d_s = list(some.start), float(d[some.stiffness])
            z = some.rest + x[places]
            y[places] = (z + d[places] + z * d_s) * np.exp(-d_s) - some.rest
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
        for some in self.bristles:
            places, d_s = list(some.start), float(d[some.stiffness])
            result[places, places] = np.exp(-d_s)
            # ∂z₀⁺/∂d_s = z₀·exp(−d_s) − z₀⁺.
            result[places, some.stiffness] = (some.rest + x[places]) * np.exp(-d_s) - (some.rest + y[places])
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


def _bristles_of(problem: Problem) -> tuple[Bristles, ...]:
    """Find bristles whose deflection at the start and whose stiffness are both fitted."""
    equations, parametrisation = problem.simulator.equations, problem.parametrisation
    if equations.joints or not equations.friction:
        return ()
    law = law_named(equations.friction[0])
    if law.roles.stiffness not in parametrisation.ids:
        return ()
    stiffness = parametrisation.ids.index(law.roles.stiffness)
    if not parametrisation.log[stiffness]:
        return ()
    found = []
    of_friction = set(range(len(law.nominal({q.id: q.initial for q in equations.parameters}))))
    for start, part in zip(problem.starts, problem.slices(), strict=True):
        chosen = [k for k, state in enumerate(start.states) if state in of_friction]
        if chosen:
            bent = Bristles(
                stiffness=stiffness,
                start=tuple(part.start + k for k in chosen),
                rest=start.base[[start.states[k] for k in chosen]] / start.unit[chosen],
            )
            found.append(bent)
    return tuple(found)
