"""Residual torques of two models compared by stretches: two `TorqueFit`s in, `Gain` out.

A residual under position control is correlated: its rows are not so many facts. The fitted rows are cut into stretches
of several correlation lengths of the larger model's residual. Each stretch is predicted by the parameters that all
other stretches give, to first order about the optimum,

    r_b⁻ = r_b + J_b·(JᵀJ − J_bᵀJ_b + λ·I)⁻¹·J_bᵀ·r_b,   λ = the residual's variance times its correlation length,

and the energies of these residuals are compared. λ keeps a parameter that the other stretches do not determine within
one of its scaled units. Only what the torque is linear in is estimated anew; shapes, such as a wave number or the
bristles of presliding, which one reversal may determine alone, are held: the first order would not hold for them. No
held-out row takes part.

Energies are those of rows away from reversals (`identification.simulators.slow_rows`). At a reversal the filter, not
the joint, decides when friction turns, and every effect that delays it would gain there.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.discrepancy.torque.fit import TorqueFit
from haptid.identification.simulators.slow_rows import Mask
from haptid.measurement.values.run import Array
from haptid.model.friction.registry import law_named
from haptid.support.linear_algebra import inverse


@dataclass(frozen=True, slots=True, kw_only=True)
class Gain:
    """Gain of a larger model over a smaller one, on fitted rows.

    Parameters
    ----------
    fitted
        n·ln(E₀/E₁) with the energies E of the residuals, and n rows counted by correlation lengths: twice the gain in
        log score.
    predicted
        The same with the energies of stretches that the other stretches predict.
    n
        Number of correlation lengths.
    errors
        Decrease of the predicted energy over its standard error, √K·mean(d)/std(d) of the K stretches.
    """

    fitted: float
    predicted: float
    n: float
    errors: float


def gain_of(less: TorqueFit, more: TorqueFit) -> Gain:
    """Compare two models of one study.

    Parameters
    ----------
    less, more
        Smaller and larger model.

    Returns
    -------
    Gain
    """
    # Under the larger model: what it explains is correlated as well, and would hide how much it explains.
    naming = more.study.names(more.study.fitted_rows)
    n = max(naming.sum() / more.correlation_time, 2.0)
    count = max(int(n / THRESHOLDS.torque.stretch_in_correlation_lengths), THRESHOLDS.torque.least_stretches)
    a, b = (_predicted_energies(model, naming, count) for model in (less, more))
    if not np.isfinite([*a, *b]).all():
        # A column that the other stretches do not tell at all predicts nothing.
        return Gain(fitted=-np.inf, predicted=-np.inf, n=n, errors=-np.inf)
    decrease = a - b
    spread = max(float(np.std(decrease, ddof=1)), np.finfo(float).tiny)
    return Gain(
        fitted=n * _log_ratio(*(float(np.sum(model.fitted[naming] ** 2)) for model in (less, more))),
        predicted=n * _log_ratio(float(a.sum()), float(b.sum())),
        n=n,
        errors=float(np.sqrt(decrease.size) * np.mean(decrease) / spread),
    )


def _log_ratio(less: float, more: float) -> float:
    tiny = np.finfo(float).tiny
    return float(np.log(max(less, tiny) / max(more, tiny)))


def _predicted_energies(model: TorqueFit, naming: Mask, count: int) -> Array:
    """Return the energy of the naming rows of every stretch as the other stretches predict it, shape (count,)."""
    J = model.jacobian[:, _linear_columns(model)]
    # The Jacobian is of the weighted residual over the noise, so the residual is taken so as well. Naming rows weigh 1.
    r = model.weighted / float(model.study.runs[0].sensor_std[0])
    A = J.T @ J + float(np.mean(r**2)) * model.correlation_time * np.eye(J.shape[1])
    energies = []
    for rows in np.array_split(np.arange(r.size), count):
        J_b, r_b = J[rows], r[rows]
        without = inverse(A - J_b.T @ J_b)
        with np.errstate(over="ignore", invalid="ignore"):
            predicted = r_b + J_b @ (without @ (J_b.T @ r_b))
            energies.append(float(np.sum(predicted[naming[rows]] ** 2)))
    return np.array(energies)


def _linear_columns(model: TorqueFit) -> list[int]:
    """Return the columns of the Jacobian of what the torque is linear in: rigid body, spring, levels, amplitudes."""
    roles = law_named(model.study.base.friction[0]).roles
    linear = {"inertia", "gravity_cos", "gravity_sin", "Kp", "Ks", "epos", roles.coulomb, roles.viscous}
    linear |= {q.id for effect in model.effects for q in effect.parameters[: effect.amplitudes]}
    return [k for k, id in enumerate(model.problem.parametrisation.ids) if id in linear]
