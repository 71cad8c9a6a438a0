"""Thresholds of the frequency response that gives resonant effects their first guesses."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class ResonanceThresholds:
    """Thresholds of `discrepancy.resonance`."""

    segments_of_run: int = 4
    """Number of segments of the shortest run, half of each overlapping the next [1].

    A run of 15 s then resolves 0.3 Hz, a quarter of the width of a peak at 18 Hz with 4 % of critical damping."""
    least_rows_of_segment: int = 32
    """Rows of a segment below which there are too few frequencies to fit."""
    first_frequency: int = 2
    """First frequency that counts, in steps of the resolution [1]: below it the window holds the drift of a run."""
    largest_phase_of_row: float = 2.0
    """Phase ωT between two rows up to which frequencies count [rad]; half of the sampling rate has π, where the rows of
    an encoder alias."""
    least_coherence: float = 0.5
    """Coherence of torque and speed from which a frequency counts [1]: less than half of the speed is noise."""
    least_share_of_power: float = 1e-4
    """Share of the largest power of the torque from which a frequency counts [1]: beside strong lines, what leaks from
    them through the window is no torque of its own."""
    least_error_of_response: float = 0.02
    """Least relative error of the response [1], which friction bends by more than noise does."""
    errors_of_outlier: float = 3.0
    """Errors beyond which a frequency counts by its residual and no longer by its square [1]."""
    points_of_parameter: int = 8
    """Number of values of each parameter of an effect in the grid of starts."""
    least_share_of_range: float = 1e-3
    """Least value of a parameter whose range begins at 0, as a share of its end [1]."""
    widest_factor_of_joint: float = 1e3
    """Factor by which inertia, spring and friction may leave their starts [1]."""
    most_starts: int = 6
    """Number of best points of the grid from which the response is fitted."""
    most_evaluations: int = 100
    """Largest number of responses in one fit."""
    least_frequencies_per_parameter: int = 3
    """Least number of frequencies for each parameter of the fit."""
    largest_share_left: float = 0.5
    """Share of the misfit without the effect up to which a resonance is shown [1].

    A belt drive's resonance left a tenth of it; effects that a joint does not have left all of it."""
