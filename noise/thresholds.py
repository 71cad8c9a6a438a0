"""Nothing in, `THRESHOLDS` out: numbers that decide what counts as noise; tolerances of arithmetic stand in its use."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Thresholds:
    """What counts as correlation or scatter, and how wide the priors of the noise are."""

    # Correlation of the sensor noise (`noise/arma.py`).
    least_twice_gain_of_correlation: float = 20.0
    """Twice the gain in log-likelihood over white noise from which noise counts as correlated [1]."""
    longest_correlation_time_s: float = 0.5
    """Longest correlation time [s] that counts as sensor noise; slower variation is drift or model discrepancy."""
    least_share_of_power_left: float = 0.3
    """Smallest share of a frequency's power that the regression may leave for the frequency to enter the fit [1]."""
    largest_periodogram_over_spectrum: float = 8.0
    """Largest ratio of periodogram to spectrum in the likelihood [1]; a higher line counts as this much."""
    starts_of_spectrum: int = 2
    """Number of points of a grid, the likeliest first, from which the likelihood of a spectrum is maximised."""
    least_line_over_fitted_spectrum: float = 0.5
    """Mean ratio of lines to a fitted spectrum, each clipped, below which it explains them no more [1]; its best scale
    makes the ratio 1."""
    largest_share_of_clipped_lines: float = 0.5
    """Mean of these ratios over `largest_periodogram_over_spectrum` above which it explains them no more [1]: as if
    more lines than this share stood far above it."""
    least_power_of_full_band: float = 0.25
    """Mean power over that of the stated noise below which a band of frequency, and all above it, take no part in the
    fit of a spectrum [1]: a filter has taken the noise out. A moving average has zeros there, and a stated noise twice
    too large leaves as little."""
    least_freedom_of_spectrum: float = 10.0
    """Lower bound of a spectrum's degrees of freedom, and their number where the likelihood has no clear maximum [1].

    A power that was estimated is known only so well: on a clean joint with strongly correlated noise, a power 30 % too
    low passed for something missing.
    """

    # Lines that are no noise (`noise/arma.py`).
    least_line_over_spectrum: float = 16.0
    """Ratio to the spectrum from which a line is regressed out [1]; one noise line of 10⁷ has it, e⁻¹⁶.

    The skirts of a small rhythm that the catalogue lacked had passed for slow correlation.
    """
    most_lines: int = 4
    """Most lines that are regressed out."""

    # Scatter of the amplitude from cycle to cycle (`noise/reml.py`).
    least_scatter: float = 1e-7
    """Lower bound of the search for s, the standard deviation of a cycle's relative amplitude [1]."""
    largest_scatter: float = 0.5
    """Upper bound of the search for s [1]."""
    twice_gain_of_rounding: float = 1e-3
    """Twice the gain in log-likelihood over s = 0 below which the gain is rounding [1]."""
    least_samples_of_scatter: int = 3
    """Smallest number of cycles, or of runs, for a scatter between them to be a candidate (`noise/noise_model.py`)."""

    # Effect of a cycle's torque on the readings (`noise/cycle_torque.py`).
    torque_change_of_scatter: float = 1e-5
    """Relative change of a cycle's torque from which its effect on the reading is taken [1].

    A change of all torques alike has the effect of one of inertia, stiffness and friction. What the two differ by in a
    linear model passes for knowledge of either: at 1e-2 their standard errors came out eight times too small.
    Friction bends the readings within a change of 1e-3 already: central differences of 1e-3 are 9e-4 (a cosine of joint
    0 of the embedded device) and 3.5e-3 (a run of its joint 4) of the columns off, forward ones of 1e-5 are 5e-5 and
    1.0e-3 off.
    """
    forgotten_share_of_cycle_effect: float = 1e-6
    """Share of a cycle's largest effect on the readings that shows, over as long, that the joint has forgotten it [1].

    A joint that dissipates does so within a few cycles; what follows is not simulated.
    """
    most_parts_of_run: int = 20
    """Largest number of parts of a run after each of which the effect of a cycle may count as forgotten; none is
    shorter than the cycle."""

    # Priors (`noise/hyper.py`, `noise/terms.py`).
    stated_noise_log_std: float = 0.05
    """Standard deviation of ln(noise factor) in its prior, where the campaign states the sensor's noise [1]."""
    estimated_noise_log_std: float = 0.5
    """The same where the sensor's noise was estimated [1]."""
    scatter_prior_scale: float = 0.1
    """Scale of the half-normal prior of the scatter of amplitudes, from cycle to cycle and from run to run [1]."""
    model_error_prior_scale_over_travel: float = 0.05
    """Scale of the half-normal prior of the model error's standard deviation, over the travel [1]."""
    error_time_prior_median_s: float = 0.3
    """Median of the prior of the model error's correlation time [s]."""
    error_time_prior_log_std: float = 1.0
    """Standard deviation of that time's logarithm in its prior [1]."""
    initial_position_std_over_travel: float = 0.05
    """Prior standard deviation of the initial position around the first sample, as a share of the travel [1].

    It is much wider than what the run determines, so that the noise of the first sample counts once, as data.
    """


THRESHOLDS = Thresholds()
"""The values that every noise model uses."""
