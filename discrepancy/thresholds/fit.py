"""Thresholds of `discrepancy/fit/`: starts, noise, scatter, unseen runs, standard errors.

A χ² counts squares over the variance of the noise; −2 ln L has the same unit, 1.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class FitThresholds:
    """Starts, noise, scatter, unseen runs and standard errors of fits."""

    # Step 2: the nominal fit, and tolerances of fits.
    on_upper_end_of_range: float = 0.99
    """Share of the upper end of a range [1] from which an estimate lies on it."""
    starts_that_agree: int = 2
    """Number of starts that must reach the best minimum before the remaining ones are left out."""
    equal_minima_chi2: float = 1.0
    """Difference of two costs ‖r‖² that count as one minimum, in squares over the noise [1]."""
    equal_minima_excess_share: float = 1e-2
    """The same as a share of the cost beyond noise [1]; the larger of the two limits holds."""
    most_hopeless_starts: int = 4
    """Number of starts after which no more are tried where all of them leave far more than noise."""
    least_energy_of_hopeless_starts: float = 25.0
    """Mean square of the residual over the noise that counts as far more [1]: where so much is missing, no minimum of
    the nominal model is the right one."""
    rough_tolerance_chi2: float = 1.0
    """Predicted decrease of ‖r‖², in squares over the noise, at which a preliminary fit ends [1]."""
    most_simulations_of_gain: int = 25
    """Largest number of simulations of all runs under one observer gain."""
    gain_tolerance_chi2: float = 1.0
    """Predicted decrease of ‖r‖², in squares over the noise, at which the fit under one observer gain ends [1]."""
    most_simulations_of_last_fit: int = 80
    """Largest number of simulations of all runs in the fit without observer and weak priors."""
    nominal_tolerance_chi2: float = 0.01
    """Predicted decrease of ‖r‖², in squares over the noise, at which the last fit of the nominal model ends [1]."""
    weak_prior_width_over_guess: float = 0.5
    """Width of the weak priors over the first guess, for parameters of logarithmic scale [1]."""

    # Step 4: scatter of the amplitude from cycle to cycle.
    least_twice_gain_of_scatter: float = 14.0
    """Twice the gain in restricted log-likelihood from which cycles count as scattering [1]."""
    least_twice_gain_for_centre: float = 4.0
    """Least such gain about a fixed centre for which the centre of a scatter on the reading is optimised [1]."""
    centre_reach_over_range: float = 0.3
    """Largest distance of that centre from the mean of the readings, over the range of a run's readings [1]."""
    most_linearisations: int = 12
    """Most linearisations of a run about the amplitudes of its cycles.

    Three do for most runs. A joint whose torque steps while it reverses takes nine: after three it was left with eight
    times the noise.
    """
    settled_log_torque_change: float = 5e-4
    """Change of the logarithm of a cycle's relative torque from which a run is linearised once more [1]."""
    largest_log_torque_factor: float = 1.0
    """Largest |ln| of a cycle's relative torque about which a run is linearised [1]."""
    fits_under_scatter: int = 2
    """Number of fits under a scatter; each linearises the scatter about the optimum of the fit before."""
    least_common_factor_over_scatter: float = 0.05
    """Deviation of the common torque factor from 1, over the size of the scatter, below which the factor is left as it
    is [1]. Larger ones move into the parameters, as a fit would creep along them."""

    # Step 9: unseen runs.
    largest_held_out_excess_in_std: float = 5.0
    """Largest excess of ‖r‖² of unseen runs over its mean under noise, in standard deviations [1]."""
    largest_held_out_excess_share: float = 0.05
    """The same as a share of the mean, which is added [1]."""
    most_places_of_discontinuity: int = 8
    """Largest number of places between two fitted torques that are predicted separately."""

    # Step 16: standard errors.
    interval_coverage: float = 0.95
    """Share of intervals that are to hold the true value [1]."""
    trusted_rise_of_deviance: tuple[float, float] = (1 / 3, 3.0)
    """Range of the rise of −2 ln L one standard error away within which the curvature is trusted [1]; a parabola rises
    by 1. Where contacts come and go, minimum lies by minimum: the curvature of one gave intervals from which the truth
    lay up to seven standard errors off."""
    least_predicted_rise_of_chi2: float = 0.5
    """Least rise of ‖r‖² that the Jacobian predicts [1]: a parameter that the data do not determine has no minimum to
    leave."""
    restarts_in_standard_errors: tuple[float, ...] = (-6.0, -2.0, 2.0, 6.0)
    """Standard errors from the minimum at which fits begin again, along the valley of a parameter [1]."""
    restart_simulations: int = 30
    """Largest number of simulations of all runs in one of these fits."""
    restart_tolerance_chi2: float = 0.1
    """Predicted decrease of ‖r‖² at which these fits end [1], small beside the drop of 2 ln L that defines the
    interval."""
