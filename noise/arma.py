"""Estimation of the sensor noise's ARMA model: residuals of whole runs in, `Arma` out.

The residual of a wrong model repeats from cycle to cycle and lies on the harmonics of the drive. Sensor noise lies
between the harmonics. The estimate takes four steps:

1. Regress the harmonics of the drive, their drift, and each cycle's mean and amplitude out of the residual.
2. Take the periodogram of the rest, and divide each frequency by the share that the regression did not remove.
3. Fit white noise plus a first-order autoregressive process by Whittle's likelihood (Whittle 1953), without a band that
   a filter has emptied; keep the fit only where its log-likelihood is clearly above that of white noise.
4. Regress out a spectral line that stands far above the fitted spectrum, and repeat from step 1: otherwise an
   autoregressive process would explain the line's skirts as slow correlation.

References
----------
Whittle, P. (1953). Estimation and information in stationary time series. Arkiv för Matematik 2, 423–434.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import product

import numpy as np
from scipy.optimize import minimize

from haptid.measurement.signals.cycles import whole_cycles
from haptid.measurement.signals.harmonics import harmonics
from haptid.measurement.values.run import Array, Run
from haptid.noise.correlation import Arma
from haptid.noise.thresholds import THRESHOLDS

LEAST_CURVATURE_RATIO = 1e-10
"""Ratio of the smallest to the largest curvature of a likelihood below which it has no clear maximum."""
LEAST_NORM_OF_NEW_COLUMN = 1e-6
"""Smallest norm of a unit column's part outside the columns before it from which the column counts as independent."""
LINES_OF_BAND = 60
"""Lines of all runs whose mean power tells whether a filter has removed the noise: of noise it varies by 0.13."""
LEAST_SPECTRUM = float(np.exp(1.0 - THRESHOLDS.largest_periodogram_over_spectrum))
"""Power over that of the stated noise below which a spectrum is refused.

With every line clipped, such a spectrum has ln S + `largest_periodogram_over_spectrum` < 1 per line, below the mean 1
of ln S + P/S that noise of the stated power has: the likelihood would reward it for explaining no line at all.
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class Regressed:
    """Subspace that is regressed out of a run's residual.

    Parameters
    ----------
    Q
        Orthonormal basis of the subspace, shape (n_t, k).
    taken
        Share of each frequency's white-noise power that the projection onto ``Q`` removes, shape (n_f,).
    """

    Q: Array
    taken: Array

    @classmethod
    def by(cls, columns: Array, beside: Array | None = None) -> Regressed:
        """Orthonormalise columns and drop those that depend linearly on the others.

        Parameters
        ----------
        columns
            Columns that span the subspace, shape (n_t, k).
        beside
            Orthonormal basis to which the new one is made orthogonal, shape (n_t, m); none where None.

        Returns
        -------
        Regressed
            Orthonormal basis of what the columns span beyond ``beside``, at most k columns.
        """
        unit = columns / np.maximum(np.linalg.norm(columns, axis=0), 1e-300)
        if beside is not None:
            for _ in range(2):  # one Gram–Schmidt pass leaves rounding of nearly dependent columns, a second removes it
                unit -= beside @ (beside.T @ unit)
        Q, R = np.linalg.qr(unit)
        Q = Q[:, np.abs(np.diag(R)) > LEAST_NORM_OF_NEW_COLUMN]
        return cls(Q=Q, taken=(np.abs(np.fft.rfft(Q, axis=0)) ** 2).sum(axis=1) / len(Q))


@lru_cache(maxsize=8)
def _repeating(run: Run) -> Regressed:
    """Return the harmonics of the drive, their drift, and each cycle's mean: the same for every residual of a run."""
    cycles = whole_cycles(run)
    return Regressed.by(np.column_stack((harmonics(run, cycles, highest=60.0, most=60, drifting=True), cycles.inside)))


def _residual_periodogram(r: Array, run: Run, lines: Sequence[float] = ()) -> tuple[Array, Array, Array]:
    """Return the periodogram of the part of a residual that does not repeat with the drive.

    Parameters
    ----------
    r
        Residual over the sensor's standard deviation, shape (n_t,).
    run
        Run of the residual.
    lines
        Angular frequencies [rad/s] that are regressed out as well, with a linear drift of their amplitude.

    Returns
    -------
    angle, power, left : ndarray, shape (n_f,) each
        Frequency [rad per row], periodogram, and the share of the white-noise power that the regression left.
    """
    known = _repeating(run)
    smooth = run.y - r[:, None] * run.sensor_std  # the simulated reading: the measured one holds the noise itself
    columns = [whole_cycles(run).inside * smooth, *(_line(omega, run.t) for omega in lines)]
    others = Regressed.by(np.column_stack(columns), beside=known.Q)
    rest = r
    for Q in (known.Q, others.Q):
        rest = rest - Q @ (Q.T @ rest)
    power = np.abs(np.fft.rfft(rest)) ** 2 / r.size
    # Frequency 0 and, of an even number of rows, the last have one degree of freedom; Whittle's likelihood assumes two.
    left = 1.0 - known.taken[1:-1] - others.taken[1:-1]
    angle = 2 * np.pi * np.arange(1, left.size + 1) / r.size
    return angle, power[1:-1], np.clip(left, 0.0, 1.0)


def _line(omega: float, t: Array) -> Array:
    """Return sine and cosine of constant and of linearly growing amplitude, shape (n_t, 4)."""
    wave = np.column_stack((np.cos(omega * t), np.sin(omega * t)))
    return np.column_stack((wave, (t / t[-1] - 0.5)[:, None] * wave))


def _spectrum(cosine: Array, p: Array) -> Array:
    """Return the spectrum of white noise of variance e^p0 plus AR(1) of variance e^p1 and pole φ = 1/(1 + e^−p2).

    S(ω) = e^p0 + e^p1·(1 − φ²)/(1 + φ² − 2·φ·cos ω), with cos ω in ``cosine``, shape (n_f,), ω in rad per row.
    """
    phi = 1.0 / (1.0 + np.exp(-p[2]))
    return np.asarray(np.exp(p[0]) + np.exp(p[1]) * (1 - phi**2) / (1 + phi**2 - 2 * phi * cosine))


def estimate_arma(residuals: list[Array], runs: tuple[Run, ...]) -> Arma:
    """Estimate the ARMA(1,1) model of the sensor noise from residuals.

    Parameters
    ----------
    residuals
        Residual of each run over the sensor's standard deviation, shape (n_t,) each.
    runs
        Runs of the residuals, all with the row spacing of the first.

    Returns
    -------
    Arma
        White noise of the stated size where no run is scored from its first row, or where correlation raises twice the
        log-likelihood by less than `least_twice_gain_of_correlation`.
    """
    whole = [(r, run) for r, run in zip(residuals, runs, strict=True) if run.score_from == 0]
    if not whole:
        return Arma()
    spacing, lines = float(np.median(np.diff(runs[0].t))), list[float]()
    while True:
        left = [_residual_periodogram(r, run, lines) for r, run in whole]
        arma = _fit_periodograms(left, spacing)
        height, angle = max(_tallest(one, arma) for one in left)
        # One line at a time: the spectrum fitted without it is another, against which the next line is judged.
        if arma.white or height < THRESHOLDS.least_line_over_spectrum or len(lines) == THRESHOLDS.most_lines:
            return arma
        lines.append(angle / spacing)


def _tallest(left: tuple[Array, Array, Array], arma: Arma) -> tuple[float, float]:
    """Return the largest ratio of a run's periodogram to the spectrum, and its frequency [rad per row]."""
    angle, power, share = left
    least = THRESHOLDS.least_share_of_power_left
    height = np.where(share > least, power / np.maximum(share, least) / arma.gain(angle) ** 2, 0.0)
    at = int(np.argmax(height))
    return float(height[at]), float(angle[at])


def _fit_periodograms(each: Sequence[tuple[Array, Array, Array]], spacing: float) -> Arma:
    """Fit white noise plus AR(1) to periodograms by Whittle's likelihood.

    Parameters
    ----------
    each
        Frequency, periodogram and share left of every run, as `_residual_periodogram` returns them.
    spacing
        Time between rows [s].

    Notes
    -----
    The deviance is −2 ln L = 2·Σ (ln S + min(P/S, `largest_periodogram_over_spectrum`)).
    """
    least = THRESHOLDS.least_share_of_power_left
    angle = np.concatenate([angle[left > least] for angle, _, left in each])
    power = np.concatenate([(power / np.maximum(left, least))[left > least] for _, power, left in each])
    below = angle < _end_of_band(angle, power)
    found = _fit_lines(angle[below], power[below], spacing)
    if not below.all() and float(np.mean(power[~below] / found.gain(angle[~below]) ** 2)) > 1.0:
        # No filter emptied that band: it holds more than what the lines below it let expect, the white part of a noise
        # that is mostly slow.
        return _fit_lines(angle, power, spacing)
    return found


def _fit_lines(angle: Array, power: Array, spacing: float) -> Arma:
    """Fit white noise plus AR(1) to lines of frequency ``angle`` [rad per row] and of ``power``, both (n_f,)."""
    cosine, slowest = np.cos(angle), float(np.log(THRESHOLDS.longest_correlation_time_s / spacing))
    highest = THRESHOLDS.largest_periodogram_over_spectrum

    def deviance(p: Array) -> float:
        if not -2.0 <= p[2] <= slowest:  # the correlation time of a slow process is about e^p2 rows
            return float("inf")
        S = _spectrum(cosine, p)
        if S.max() < LEAST_SPECTRUM:
            return float("inf")
        return float(2.0 * np.sum(np.log(S) + np.minimum(power / S, highest)))

    white = deviance(np.array([0.0, -40.0, 0.0]))  # the stated noise: e⁻⁴⁰ is no correlated part

    def explains(p: Array) -> bool:
        """Say whether lines are about as high as the spectrum, of which the best scale makes their mean ratio 1."""
        ratio = float(np.mean(np.minimum(power / _spectrum(cosine, p), highest)))
        most = THRESHOLDS.largest_share_of_clipped_lines * highest
        return THRESHOLDS.least_line_over_fitted_spectrum < ratio < most

    # Nelder–Mead finds the nearest maximum only, and what a wrong model leaves has several.
    grid = product(np.linspace(-4.0, 1.0, 6), np.linspace(-3.0, 3.0, 5), np.linspace(-1.0, slowest - 0.1, 6))
    able = (p for p in map(np.array, grid) if explains(p))
    starts = sorted(able, key=deviance)[: THRESHOLDS.starts_of_spectrum]
    tried = [
        minimize(deviance, start, method="Nelder-Mead", options={"maxiter": 600, "xatol": 1e-4, "fatol": 1e-3})
        for start in starts
    ]
    real = [found for found in tried if explains(found.x)]
    best = min(real, key=lambda found: float(found.fun), default=None)
    if best is None or white - float(best.fun) < THRESHOLDS.least_twice_gain_of_correlation:
        return Arma()
    p = np.asarray(best.x)
    return replace(to_arma(p), freedom=_freedom(p, deviance))


def _end_of_band(angle: Array, power: Array) -> float:
    """Return the frequency [rad per row] above which a filter has emptied the readings; π where none has.

    Readings that were smoothed before they were recorded hold next to no noise above some frequency. White noise plus
    AR(1) follows no such edge: many empty lines would pull its spectrum below the noise where the motion is.
    """
    order = np.argsort(angle)
    whole = order[: order.size // LINES_OF_BAND * LINES_OF_BAND].reshape(-1, LINES_OF_BAND)
    empty = np.flatnonzero(power[whole].mean(axis=1) < THRESHOLDS.least_power_of_full_band)
    return float(angle[whole[empty[0], 0]]) if empty.size and empty[0] > 0 else float(np.pi)


def _freedom(p: Array, deviance: Callable[[Array], float]) -> float:
    """Return the degrees of freedom ν of the estimated power at frequency 0.

    Notes
    -----
    ν = 2/Var(ln S(0)), as a scaled χ² of ν degrees of freedom has the relative variance 2/ν. The variance follows from
    the curvature H of −ln L at the maximum by the delta method, ∇ᵀ·H⁻¹·∇ with ∇ the gradient of ln S(0). ν is at least
    `least_freedom_of_spectrum`.
    """
    step, n = 0.05, p.size
    H = np.empty((n, n))
    for i in range(n):
        for k in range(n):
            a, b = step * np.eye(n)[i], step * np.eye(n)[k]
            H[i, k] = deviance(p + a + b) - deviance(p + a - b) - deviance(p - a + b) + deviance(p - a - b)
    H /= 8.0 * step**2  # of −ln L, half the deviance
    if not np.isfinite(H).all():  # a step of the difference left the bounds of the deviance
        return THRESHOLDS.least_freedom_of_spectrum
    curvatures = np.linalg.eigvalsh(H)
    if curvatures[0] <= LEAST_CURVATURE_RATIO * curvatures[-1]:
        return THRESHOLDS.least_freedom_of_spectrum
    base = np.log(_spectrum(np.ones(1), p)[0])
    slope = np.array([np.log(_spectrum(np.ones(1), p + 1e-4 * e)[0]) - base for e in np.eye(n)]) / 1e-4
    variance = float(slope @ np.linalg.solve(H, slope))
    return max(2.0 / variance, THRESHOLDS.least_freedom_of_spectrum)


def to_arma(p: Array) -> Arma:
    """Write white noise plus AR(1) as one ARMA(1,1) process with an invertible moving-average part.

    Parameters
    ----------
    p
        ln of the white variance, ln of the AR(1) variance, logit of the pole φ; shape (3,), variances over that of the
        stated noise.

    Returns
    -------
    Arma
        Process of the same autocovariance, its ``freedom`` not set.

    Notes
    -----
    Both sides of (1 − φB)·r = (1 − θB)·σ·ε have the same autocovariance where σ²·(1 + θ²) = a and σ²·θ = b, with
    a = e^p0·(1 + φ²) + e^p1·(1 − φ²) and b = e^p0·φ. The root with |θ| < 1 is θ = 2·b/(a + √(a² − 4·b²)).
    """
    phi, white, coloured = 1.0 / (1.0 + np.exp(-p[2])), float(np.exp(p[0])), float(np.exp(p[1]))
    a = white * (1 + phi**2) + coloured * (1 - phi**2)
    b = white * phi
    root = a + float(np.sqrt(max(a**2 - 4 * b**2, 0.0)))
    return Arma(phi=float(phi), theta=2 * b / root, sigma=float(np.sqrt(root / 2)))
