"""Thresholds of `discrepancy/detect/`: inner step, omnibus test, score tests, where the residual lies."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class DetectThresholds:
    """Inner step, omnibus test, score tests and residual localisation."""

    # Step 3: the inner step.
    invisible_step_error_chi2: float = 0.5
    """Largest ‖P·e‖² of a step whose error counts as invisible, in squares over the noise [1]."""
    step_error_share_of_excess: float = 1e-6
    """The same for the nominal model, as a share of the excess of its χ² over noise [1].

    Without it a search about a stuck nominal model went down to a step of 0.08 ms and was not done in 15 minutes.
    """
    row_divisor_of_merging: int = 4
    """Part of the spacing of all rows at which merged and unmerged rows are simulated to be compared, as a divisor [1].

    At the step of the search the errors of a stiff slider were 13,000 squares over the noise, at a quarter of its rows
    0.2."""
    most_step_halvings: int = 5
    """Largest number of times that the step is halved."""

    # Step 5: the omnibus test.
    least_statistic_of_series: float = 500.0
    """Statistic of a χ² test beyond which the asymptotic series replaces the exact tail [1], which underflows."""
    omnibus_band_rad_per_s: float = 40.0
    """Upper end of the band of motion [rad/s]."""
    far_energy_over_freedom: float = 5.0
    """Energy over its degrees of freedom beyond which no noise model turns the residual into noise [1]."""

    # Step 6: signatures and score tests.
    share_of_typical_amplitude: float = 0.03
    """Share s of the typical amplitude in the difference of a signature [1].

    At the whole amplitude, curvature along what the nominal model can nearly reproduce would pass for a discrepancy,
    and sizes were called detectable that are not.
    """
    largest_change_over_sensor_std: float = 1e6
    """Largest change of a reading, in standard deviations of the sensor, beyond which a simulation counts as diverged
    [1]."""
    least_share_off_tangent_space: float = 1e-3
    """Share of a signature's norm that must survive the projection for the signature to be scored [1]."""
    random_draws: int = 2000
    """Number of random draws of scores or of signs; with n of them, no p-value of sign flips is below 1/(n + 1)."""
    sign_stretches_per_run: int = 60
    """Number of stretches of a run whose signs are flipped, each on its own."""
    detected_family_wise_p_value: float = 0.01
    """Family-wise p-value at which an effect counts as detected in the smallest detectable size [1]."""
    detection_power: float = 0.9
    """Share of data sets in which an effect of the smallest detectable size has to be detected [1]."""

    # Step 7: residual localisation.
    bins_per_variable: int = 12
    """Number of bins of equal width per variable; fewer where the variable has fewer values."""
    least_share_of_excess_in_region: float = 0.5
    """Share of the residual's excess energy that a region must hold [1]."""
