"""Test whether there is any model discrepancy: `Study` and `Solution` in, `Omnibus` out.

1. Project the whitened residual off the tangent space Q of the fit: r = P·ε with P = I − QQᵀ.
2. Take its energy e = ‖Bᵀr‖² in three bands with orthonormal bases B: the harmonics of the drive, the same growing
   through the run, and everything slower than `omnibus_band_rad_per_s`.
3. Compare each energy with noise: its mean is tr(BᵀPB) and its variance 2·tr((BᵀPB)²), scaled χ² to second order.
4. Test the tallest single line of the last band too, and combine all tests by Bonferroni.

References
----------
Satterthwaite 1946, for the scaled χ² of step 3.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.fft import dct

from haptid.discrepancy.detect.chi_squared import log_tail
from haptid.discrepancy.fit.solution import Solution
from haptid.discrepancy.fit.tangent_space import tangent_space
from haptid.discrepancy.study.channels import Channel, channels
from haptid.discrepancy.study.study import Study
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.measurement.signals.cycles import whole_cycles
from haptid.measurement.signals.harmonics import harmonics
from haptid.measurement.values.run import Array, Run
from haptid.noise.correlation import Whitener


@dataclass(frozen=True, slots=True, kw_only=True)
class Omnibus:
    """Result of the omnibus test.

    Parameters
    ----------
    energy
        ‖Bᵀr‖² on the harmonics of the drive.
    dof
        Energy that noise is expected to have there.
    p
        p over all tests together (Bonferroni).
    parts
        p of every test by name.
    total
        ‖r‖² of the whitened residual, priors included.
    rows
        Number of scored residuals.
    """

    energy: float
    dof: float
    p: float
    parts: dict[str, float]
    total: float
    rows: int

    @property
    def over_noise(self) -> float:
        """Root mean square of the residual on the harmonics of the drive over that of noise [1], at least 1."""
        return max(float(np.sqrt(self.energy / max(self.dof, np.finfo(float).tiny))), 1.0)

    @property
    def far(self) -> bool:
        """Whether the residual is so large that no noise model turns it into noise."""
        return self.energy > THRESHOLDS.detect.far_energy_over_freedom * self.dof


def satterthwaite(along: Array, moved: Array, freedom: float = np.inf) -> tuple[float, float, float]:
    """Test the energy of a projected residual in one band.

    Parameters
    ----------
    along
        Bᵀr, shape (m,).
    moved
        BᵀQ, shape (m, k).
    freedom
        Degrees of freedom to which the noise power is known.

    Returns
    -------
    energy, mean, p
        ‖Bᵀr‖², its mean tr(BᵀPB) under noise, and its p-value.

    Notes
    -----
    With P = I − QQᵀ and M = BᵀQ, tr(BᵀPB) = m − tr(MᵀM) and tr((BᵀPB)²) = m − 2·tr(MᵀM) + ‖MᵀM‖².

    References
    ----------
    Satterthwaite 1946.
    """
    taken = moved.T @ moved
    mean = along.size - float(np.trace(taken))
    square = along.size - 2.0 * float(np.trace(taken)) + float((taken**2).sum())
    energy, scale = float(along @ along), max(square, 1e-9) / max(mean, 1e-9)
    return energy, mean, float(np.exp(log_tail(energy / scale, mean / scale, freedom)))


def omnibus(study: Study, solution: Solution) -> Omnibus:
    """Test the whitened residual of all fitted runs for any model discrepancy.

    Parameters
    ----------
    study
        Study with the fitted runs.
    solution
        Fitted model.

    Returns
    -------
    Omnibus
        p-values, and the energy on the harmonics of the drive.
    """
    Q = tangent_space(solution)
    r = solution.residual - Q @ (Q.T @ solution.residual)
    # Residual and tangent space take the same transforms, so one array carries both.
    both = np.column_stack((r, Q))
    names = ("repeating", "drifting", "band")
    found: dict[str, list[Array]] = {name: [] for name in names}
    each, first = channels(study.fitted), 0
    for number, run in enumerate(study.fitted):
        own, mine = [c for c in each if c.number == number], both[first : first + run.y.size]
        for name, drifting in (("repeating", False), ("drifting", True)):
            H = _waves(run, own, solution.problem.whiteners[number], drifting=drifting)
            found[name].append(np.linalg.qr(H)[0].T @ mine)
        # Line k of the discrete cosine transform has the frequency k·π/duration.
        lines = 1 + int(THRESHOLDS.detect.omnibus_band_rad_per_s * run.t[-1] / np.pi)
        found["band"] += [dct(both[c.rows], axis=0, norm="ortho")[:lines] for c in own]
        first += run.y.size
    freedom = solution.noise.arma.freedom
    tests = {name: _test_channel(np.concatenate(rows), freedom) for name, rows in found.items()}
    parts = {name: test[2] for name, test in tests.items()} | {"line": _tallest(np.concatenate(found["band"]), freedom)}
    return Omnibus(
        energy=tests["repeating"][0], dof=tests["repeating"][1], p=min(1.0, len(parts) * min(parts.values())),
        parts=parts, total=solution.chi2, rows=study.rows,
    )  # fmt: skip


def _waves(run: Run, own: Sequence[Channel], whiten: Whitener, *, drifting: bool) -> Array:
    """Return the whitened harmonics of each joint's drive in its own readings, shape (n_t·n_joints, k)."""
    columns = []
    for channel in own:
        waves = harmonics(channel.run, whole_cycles(channel.run), drifting=drifting)
        H = np.zeros((*run.y.shape, waves.shape[1]))
        H[:, channel.column] = waves
        H = whiten(H)
        # Rows before ``score_from`` are not scored, but row 0 is: it is the prior of the fitted initial position.
        H[1 : run.score_from] = 0.0
        columns.append(H.reshape(run.y.size, -1))
    return np.concatenate(columns, axis=1)


def _test_channel(rows: Array, freedom: float) -> tuple[float, float, float]:
    return satterthwaite(rows[:, 0], rows[:, 1:], freedom)


def _tallest(rows: Array, freedom: float) -> float:
    """Return p of the largest of m squared lines, each over its own variance under noise."""
    # A line that the model reproduces nearly whole has almost no variance left; the floor keeps its ratio from
    # exploding.
    left = np.maximum(1.0 - (rows[:, 1:] ** 2).sum(axis=1), 0.05)
    p = float(np.exp(log_tail(float((rows[:, 0] ** 2 / left).max()), 1, freedom)))
    return float(-np.expm1(rows.shape[0] * np.log1p(-min(p, 1 - 1e-16))))
