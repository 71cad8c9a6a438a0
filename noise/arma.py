"""Correlation of the sensor noise, from what does not repeat with the drive.

The residual of a wrong model repeats from cycle to cycle and lies on the harmonics of the drive; noise lies between.
Harmonics (and their drift) and each cycle's amplitude are regressed out of the residual; a periodogram of it is fitted
by white noise plus a first-order autoregressive process (Whittle 1953). Frequencies that the regression took away count
by the share that it left. A line that stands far above the fitted spectrum, at whatever frequency, is no noise either:
it is regressed out as well, for a process that follows its skirts would explain it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from scipy.optimize import minimize

from haptid.measurement.signals.cycles import whole_cycles
from haptid.measurement.signals.harmonics import harmonics
from haptid.measurement.values.run import Array, Run
from haptid.noise.correlation import Colour

EVIDENCE = 20.0
"""Twice the gain in log-likelihood over white noise that correlation has to bring."""
LEFT = 0.3
"""Least share of a frequency that the regression has to leave."""
LONGEST = 0.5
"""Longest correlation time that counts as sensor noise [s]; what is slower is drift or a wrong model."""
LEAST_FREEDOM = 10.0
"""Fewest degrees of freedom that a spectrum is taken to have where its likelihood has no clear maximum."""
FLAT = 1e-10
"""Share of the largest curvature of a likelihood below which it has no clear maximum."""
NEW = 1e-6
"""Least share of a column that the columns before it must leave for it to count."""
CLIPPED = 8.0
"""A line this many times above the spectrum is no noise: it counts as this much."""
LINE, LINES = 16.0, 4
"""A line this many times above the spectrum, as of 10⁷ lines of noise one is (e⁻¹⁶), is taken out; four at most."""
NONE = float(np.exp(1.0 - CLIPPED))
"""Power, over the stated noise, below which a spectrum explains no line: it would count every one as no noise."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Regressed:
    """What repeats in a run: an orthonormal basis (n_t, k), and what it takes of each frequency (n_f,)."""

    Q: Array
    taken: Array

    @classmethod
    def by(cls, columns: Array, beside: Array | None = None) -> Regressed:
        """Orthonormalise columns, ``beside`` an orthonormal basis that is there already."""
        unit = columns / np.maximum(np.linalg.norm(columns, axis=0), 1e-300)
        if beside is not None:
            for _ in range(2):  # twice is enough
                unit -= beside @ (beside.T @ unit)
        Q, R = np.linalg.qr(unit)
        Q = Q[:, np.abs(np.diag(R)) > NEW]
        return cls(Q=Q, taken=(np.abs(np.fft.rfft(Q, axis=0)) ** 2).sum(axis=1) / len(Q))


@lru_cache(maxsize=8)
def _repeating(run: Run) -> Regressed:
    """Harmonics of the drive, their drift, and each cycle's mean: the same for every residual of a run."""
    cycles = whole_cycles(run)
    return Regressed.by(np.column_stack((harmonics(run, cycles, highest=60.0, most=60, drifting=True), cycles.inside)))


def _residual_periodogram(r: Array, run: Run, lines: Sequence[float] = ()) -> tuple[Array, Array, Array]:
    """Frequency [rad per row], periodogram of the residual's non-repeating part, share that is left; each (n_f,).

    The ``lines`` [rad/s] are taken out with it, and what lies up to half a wave in the run beside.
    """
    known = _repeating(run)
    smooth = run.y - r[:, None] * run.sensor_std  # the simulated reading: the measured one holds the noise itself
    columns = [whole_cycles(run).inside * smooth, *(_line(omega, run.t) for omega in lines)]
    others = Regressed.by(np.column_stack(columns), beside=known.Q)
    rest = r
    for Q in (known.Q, others.Q):
        rest = rest - Q @ (Q.T @ rest)
    power = np.abs(np.fft.rfft(rest)) ** 2 / r.size
    left = 1.0 - known.taken[1:-1] - others.taken[1:-1]
    angle = 2 * np.pi * np.arange(1, left.size + 1) / r.size
    return angle, power[1:-1], np.clip(left, 0.0, 1.0)


def _line(omega: float, t: Array) -> Array:
    """Waves of constant and of growing amplitude, (n_t, 4)."""
    wave = np.column_stack((np.cos(omega * t), np.sin(omega * t)))
    return np.column_stack((wave, (t / t[-1] - 0.5)[:, None] * wave))


def _spectrum(angle: Array, p: Array) -> Array:
    """White variance e^p0 plus AR(1) of variance e^p1 and pole φ = 1/(1 + e^−p2), at ``angle`` [rad per row]."""
    phi = 1.0 / (1.0 + np.exp(-p[2]))
    return np.asarray(np.exp(p[0]) + np.exp(p[1]) * (1 - phi**2) / (1 + phi**2 - 2 * phi * np.cos(angle)))


def estimate_colour(residuals: list[Array], runs: tuple[Run, ...]) -> Colour:
    """Estimate the noise's correlation from residuals over the sensor's std; white where nothing speaks against it."""
    whole = [(r, run) for r, run in zip(residuals, runs, strict=True) if run.score_from == 0]
    if not whole:
        return Colour()
    spacing, lines = float(np.median(np.diff(runs[0].t))), list[float]()
    while True:
        left = [_residual_periodogram(r, run, lines) for r, run in whole]
        colour = _fit_periodograms(left, spacing)
        height, angle = max(_tallest(one, colour) for one in left)
        if colour.white or height < LINE or len(lines) == LINES:
            return colour
        lines.append(angle / spacing)


def _tallest(left: tuple[Array, Array, Array], colour: Colour) -> tuple[float, float]:
    """Return by how much the tallest line of a run stands above the spectrum, and where [rad per row]."""
    angle, power, share = left
    height = np.where(share > LEFT, power / np.maximum(share, LEFT) / colour.gain(angle) ** 2, 0.0)
    at = int(np.argmax(height))
    return float(height[at]), float(angle[at])


def _fit_periodograms(each: Sequence[tuple[Array, Array, Array]], spacing: float) -> Colour:
    """Fit periodograms with the shares that are left of them, of rows that are ``spacing`` [s] apart."""
    angle = np.concatenate([angle[left > LEFT] for angle, _, left in each])
    power = np.concatenate([(power / np.maximum(left, LEFT))[left > LEFT] for _, power, left in each])
    slowest = float(np.log(LONGEST / spacing))

    def deviance(p: Array) -> float:
        if not -2.0 <= p[2] <= slowest:
            return float("inf")
        S = _spectrum(angle, p)
        if S.max() < NONE:
            return float("inf")
        return float(2.0 * np.sum(np.log(S) + np.minimum(power / S, CLIPPED)))

    white = deviance(np.array([0.0, -40.0, 0.0]))
    tried = [
        minimize(deviance, start, method="Nelder-Mead", options={"maxiter": 600, "xatol": 1e-4, "fatol": 1e-3})
        for start in (np.array([0.0, -1.0, 2.0]), np.array([0.0, -3.0, 4.0]))
    ]
    real = [found for found in tried if _spectrum(angle, found.x).max() > 2.0 * NONE]
    best = min(real, key=lambda found: float(found.fun), default=None)
    if best is None or white - float(best.fun) < EVIDENCE:
        return Colour()
    p = np.asarray(best.x)
    return replace(to_arma(p), freedom=_freedom(p, deviance))


def _freedom(p: Array, deviance: Callable[[Array], float]) -> float:
    """Degrees of freedom of the power at frequency 0, from the curvature of the likelihood at its maximum."""
    step, n = 0.05, p.size
    H = np.empty((n, n))
    for i in range(n):
        for k in range(n):
            a, b = step * np.eye(n)[i], step * np.eye(n)[k]
            H[i, k] = deviance(p + a + b) - deviance(p + a - b) - deviance(p - a + b) + deviance(p - a - b)
    H /= 8.0 * step**2  # of −ln L, half the deviance
    if not np.isfinite(H).all():
        return LEAST_FREEDOM
    curvatures = np.linalg.eigvalsh(H)
    if curvatures[0] <= FLAT * curvatures[-1]:
        return LEAST_FREEDOM
    base = np.log(_spectrum(np.zeros(1), p)[0])
    slope = np.array([np.log(_spectrum(np.zeros(1), p + 1e-4 * e)[0]) - base for e in np.eye(n)]) / 1e-4
    variance = float(slope @ np.linalg.solve(H, slope))
    return max(2.0 / variance, LEAST_FREEDOM)


def to_arma(p: Array) -> Colour:
    """Write white noise plus AR(1) as one ARMA(1,1) process with an invertible moving-average part."""
    phi, white, coloured = 1.0 / (1.0 + np.exp(-p[2])), float(np.exp(p[0])), float(np.exp(p[1]))
    a = white * (1 + phi**2) + coloured * (1 - phi**2)
    b = white * phi
    root = a + float(np.sqrt(max(a**2 - 4 * b**2, 0.0)))
    return Colour(phi=float(phi), theta=2 * b / root, sigma=float(np.sqrt(root / 2)))
