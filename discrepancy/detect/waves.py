"""Find waves over position beyond the grids of the catalogue: positions and residual torques in, wave numbers out.

Gear teeth and motor poles make hundreds of waves a radian, where a grid that misses no wave would have thousands of
values. A periodogram over position finds them at once:

1. Average the residual torque in bins of equal width over position; a wave of dry friction changes its sign with the
   direction, so that residual·sgn q̇ is averaged, too.
2. Take the power |Σ_b r_b·exp(−i·n·q_b)|² of the bins at every wave number n up to half of what the bins can show.
3. Let ln S̄ be a polynomial of ln n through the logarithms of the power. Keep the highest peaks that noise of power S̄
   would reach among N wave numbers with a small probability α: P > S̄·ln(N/α), since the power of noise is
   distributed exponentially (Fisher 1929).
4. Offer every effect with a wave number among its shapes the highest of those beyond its own grid.

References
----------
Fisher, R. A. (1929). Tests of significance in harmonic analysis. Proceedings of the Royal Society A 125, 54–59.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array
from haptid.model.effects.effect import Effect

WAVE_NUMBERS = ("1/rad", "1/m")
"""Units that tell a wave number among the shape parameters of an effect: of a joint that turns, and of one that slides.
"""


def with_waves(catalogue: Mapping[str, Effect], residual: Callable[[], tuple[Array, Array]]) -> dict[str, Effect]:
    """Offer the waves that stand out of a residual torque to the effects that have a wave number.

    Parameters
    ----------
    catalogue
        Catalogue effects by key, in SI units.
    residual
        Returns positions [rad] or [m], shape (n,), and signals there, shape (n, n_signals). Asked only where an effect
        has a wave number.

    Returns
    -------
    dict
        The effects; those with a wave number have the new ones in their grid and below its upper bound.
    """
    waves = {key: id for key, effect in catalogue.items() if (id := _wave_of(effect))}
    if not waves:
        return dict(catalogue)
    ends = {key: grid[-1] for key in waves for id, grid in catalogue[key].shapes if id == waves[key]}
    found = find_waves(*residual(), beyond=min(ends.values()))
    # The grid of an encoder's lines ends where that of a motor's poles has long left waves out.
    own = {
        key: tuple(n for n in found if n > end)[: THRESHOLDS.torque.most_waves_beyond_grid] for key, end in ends.items()
    }
    return {key: _extend(e, waves[key], own[key]) if own.get(key) else e for key, e in catalogue.items()}


def find_waves(q: Array, signals: Array, *, beyond: float) -> tuple[float, ...]:
    """Find waves over position that stand out of noise.

    Parameters
    ----------
    q
        Positions [rad], shape (n,).
    signals
        Signals at these positions, shape (n, n_signals).
    beyond
        Smallest wave number that is looked at [1/rad].

    Returns
    -------
    tuple of float
        Wave numbers [1/rad], the highest of their peaks first.
    """
    limits = THRESHOLDS.torque
    bins = int(q.size // limits.rows_per_position_bin)
    if bins < 2 or (span := float(np.ptp(q))) <= 0.0:
        return ()
    place = np.minimum(((q - q.min()) / span * bins).astype(int), bins - 1)
    count = np.maximum(np.bincount(place, minlength=bins), 1)
    peaks = []
    for signal in signals.T:
        mean = np.bincount(place, signal - signal.mean(), minlength=bins) / count
        # Padding to four times the length shows a peak that lies between two waves of the travel.
        power = np.abs(np.fft.rfft(mean, 4 * bins)) ** 2
        number: Array = 2.0 * np.pi / span * np.arange(power.size, dtype=np.float64) / 4.0
        # From one wave over the travel on: of a range that begins beside a peak, the peak itself would be the level.
        inside = (number >= 2.0 * np.pi / span) & (number <= 0.5 * np.pi * bins / span)
        peaks += [peak for peak in _peaks(number[inside], power[inside]) if peak[1] > beyond]
    peaks.sort(key=lambda peak: -peak[0])
    return tuple(n for _, n in peaks)


def _peaks(number: Array, power: Array) -> list[tuple[float, float]]:
    """Return height over the limit, and wave number, of the peaks that noise would hardly reach."""
    degree = THRESHOLDS.torque.degree_of_power_over_wave_number
    if power.size <= 4 * (degree + 1):
        return []
    level = np.log(np.maximum(power, np.finfo(float).tiny))
    curve = np.polyval(np.polyfit(np.log(number), level, degree), np.log(number))
    # The logarithm of a power that is distributed exponentially has the mean ln S̄ − γ.
    surroundings = np.exp(curve + np.euler_gamma)
    # Padded wave numbers are not independent, so that their number is an upper bound of N.
    limit = surroundings * np.log(power.size / THRESHOLDS.torque.wave_p_value)
    ratio = power / np.maximum(limit, np.finfo(float).tiny)
    top = (ratio[1:-1] > 1.0) & (power[1:-1] >= power[:-2]) & (power[1:-1] > power[2:])
    return [(float(ratio[k]), float(number[k])) for k in np.flatnonzero(top) + 1]


def _wave_of(effect: Effect) -> str:
    """Return the id of the wave number among the shapes of an effect; empty where there is none."""
    units = {x.id: x.unit for x in effect.parameters}
    return next((id for id, _ in effect.shapes if units[id] in WAVE_NUMBERS), "")


def _extend(effect: Effect, id: str, numbers: tuple[float, ...]) -> Effect:
    # A wave number that is estimated may end a little above the peak of the periodogram.
    highest = THRESHOLDS.torque.bound_over_highest_wave * max(numbers)
    return replace(
        effect,
        parameters=tuple(
            x.but(upper=max(x.upper, highest)) if x.id == id else x for x in effect.parameters
        ),
        shapes=tuple((name, (*grid, *numbers) if name == id else grid) for name, grid in effect.shapes),
    )  # fmt: skip
