"""Cut a periodic run into the cycles of its torque: `Run` in, `Cycles` with the number of each row's cycle out.

1. The largest bin of a windowed, zero-padded spectrum gives the angular frequency ω of the torque.
2. ω is refined by least squares of a·cos(ωt) + b·sin(ωt) + c on the rows, which need not be evenly spaced.
3. The torque counts as periodic where that line carries enough of its variance.
4. Cycle boundaries lie where the phase of the line passes multiples of 2π.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from haptid.measurement.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array, Run


@dataclass(frozen=True, slots=True, kw_only=True)
class Cycles:
    """Hold the frequency of a periodic torque and the cycle of each row.

    Parameters
    ----------
    omega
        Angular frequency of the strongest line of the torque [rad/s]; 0 where the torque is constant.
    share
        Share of the torque's variance on that line, 0 to 1.
    index
        Number of the cycle that each row lies in, from 0, shape (n_t,). All 0 where the torque is not periodic.
    turns
        Phase of the line in cycles plus the error of a boundary (`_boundary_error`), shape (n_t,). That error puts a
        row at a boundary behind the boundary, whichever way it was rounded. All 0 where the torque is not periodic.
    """

    omega: float
    share: float
    index: NDArray[np.int64]
    turns: Array

    @property
    def count(self) -> int:
        """Number of cycles, including an unfinished one at the end."""
        return int(self.index[-1]) + 1

    @property
    def inside(self) -> NDArray[np.bool_]:
        """Indicator matrix of the cycles, shape (n_t, n_cycles): True where a row lies in a cycle."""
        return np.asarray(self.index[:, None] == np.arange(self.count))


def find_cycles(run: Run, column: int = 0) -> Cycles:
    """Find the cycles of the torque ``run.u[:, column]``; pieces below a tenth of a cycle join their neighbour.

    Parameters
    ----------
    run
        Run of any use.
    column
        Column of the joint among ``run.free_joints``.

    Returns
    -------
    Cycles
        With one cycle for the whole run where the torque is constant, has less than one cycle, or its strongest line
        carries less than half of its variance (95 % where the run has at most two cycles).

    Notes
    -----
    ω minimises the sum of squares of u − a·cos(ωt) − b·sin(ωt) − c over the rows. A cycle begins where the phase of
    that line, A·cos(ωt + φ), passes a multiple of 2π: for u = A·cos(ωt), at t = 0. Other boundaries, as an amplifier's
    lag would give, change the amplitudes of the cycles but not their scatter from cycle to cycle.
    """
    t, u = run.t, run.u[:, column]
    nothing = Cycles(omega=0.0, share=0.0, index=np.zeros(t.size, dtype=np.int64), turns=np.zeros(t.size))
    if np.ptp(u) == 0:
        return nothing
    omega = _refine_frequency(t, u, _strongest_line(t, u))
    share = _line(t, u, omega)[1]
    turns_in_all = omega * t[-1] / (2 * np.pi)
    many = turns_in_all > 2
    least_share = THRESHOLDS.least_line_share_of_variance if many else THRESHOLDS.least_line_share_of_two_cycles
    if turns_in_all < 1 or share < least_share:
        return Cycles(omega=omega, share=share, index=nothing.index, turns=nothing.turns)
    turns = _turns(t, u, omega, share)
    return Cycles(omega=omega, share=share, index=_number_cycles(turns), turns=turns)


@lru_cache(maxsize=64)
def whole_cycles(run: Run) -> Cycles:
    """Return the cycles of a run's first joint with every begun cycle counted: each has an amplitude of its own.

    Parameters
    ----------
    run
        Run of any use; results are cached per object.

    Returns
    -------
    Cycles
        As `find_cycles` gives them, but short pieces at either end are cycles of their own. Cycle k holds the rows
        with k ≤ (ωt + φ)/2π < k + 1 for the torque's strongest line A·cos(ωt + φ), k counted from the first row's.
    """
    found = find_cycles(run)
    if not found.turns.any():  # not periodic: the whole run is one cycle
        return found
    begun = np.floor(found.turns).astype(np.int64)
    return replace(found, index=begun - begun[0])


def _turns(t: Array, u: Array, omega: float, share: float) -> Array:
    """Return the phase of the line in cycles, plus the error of a boundary, shape (n_t,)."""
    a, b, _ = _line(t, u, omega)[0]
    return np.asarray((omega * t + np.arctan2(-b, a)) / (2 * np.pi) + _boundary_error(share, t.size))


def _boundary_error(share: float, rows: int) -> float:
    """Return the error of a cycle boundary [cycles]: five standard errors of the phase, from 1e-6 to 1e-4.

    The phase at an end of the run has the standard error 2·√(2/n)·σ/A, A the line's amplitude and
    σ² = A²/2·(1/share − 1) the power beside it, as if that were noise.
    """
    error = 2.0 * np.sqrt(max(1.0 / share - 1.0, 0.0) / rows) / (2 * np.pi)
    return float(
        np.clip(
            THRESHOLDS.boundary_error_in_std * error,
            THRESHOLDS.least_boundary_error_cycles,
            THRESHOLDS.largest_boundary_error_cycles,
        )
    )


def _strongest_line(t: Array, u: Array) -> float:
    """Angular frequency of the largest bin of a zero-padded, windowed spectrum on an even grid [rad/s]."""
    even = np.linspace(0.0, t[-1], t.size)
    centred = np.interp(even, t, u) - u.mean()
    spectrum = np.abs(np.fft.rfft(centred * np.hanning(t.size), 8 * t.size))
    lowest = 8  # one cycle per run
    k = lowest + int(np.argmax(spectrum[lowest:]))
    return 2 * np.pi * k / (8 * t.size) * (t.size - 1) / float(t[-1])


def _refine_frequency(t: Array, u: Array, omega: float) -> float:
    # A quarter of a cycle per run to either side: two bins of the padded spectrum that gave the first guess.
    width = 2 * np.pi / float(t[-1]) / 4
    best = minimize_scalar(lambda w: -_line(t, u, w)[1], bounds=(omega - width, omega + width), method="bounded",
                           options={"xatol": 1e-9 * omega})  # fmt: skip
    return float(best.x)


def _line(t: Array, u: Array, omega: float) -> tuple[Array, float]:
    """Fit a·cos(ωt) + b·sin(ωt) + c; return (a, b, c) and the share of variance that it explains."""
    basis = np.stack([np.cos(omega * t), np.sin(omega * t), np.ones_like(t)], axis=1)
    weights = np.linalg.lstsq(basis, u, rcond=None)[0]
    return weights, 1.0 - float(np.var(u - basis @ weights) / np.var(u))


def _number_cycles(turns: Array) -> NDArray[np.int64]:
    """Count cycles from 0, slivers at both ends joined to their neighbours."""
    index = np.floor(turns).astype(np.int64)
    # The first boundary is near: the rows before it count to the first whole cycle. Likewise at the end.
    if 1.0 - turns[0] % 1.0 < THRESHOLDS.least_share_of_cycle:
        index = np.maximum(index, index[0] + 1)
    if turns[-1] % 1.0 < THRESHOLDS.least_share_of_cycle:
        index = np.minimum(index, index[-1] - 1)
    return np.asarray(index - index[0], dtype=np.int64)
