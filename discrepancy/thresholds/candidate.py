"""Thresholds of `discrepancy/candidate/`: when a model leaves only noise, when an effect has earned its place."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class CandidateThresholds:
    """Refits of candidates, and what is asked of them."""

    # Step 9: a model leaves only noise.
    lack_p_value: float = 5e-4
    """p-value of the omnibus test, and of parameter constancy, below which a model lacks something [1].

    Of 439 sets in which nothing is hidden, chance alone puts 0.2 beyond it; one was found there, at 4.3e-4.
    """
    family_wise_p_value: float = 0.002
    """Family-wise p-value over the catalogue below which a score counts [1]."""
    refuted_family_wise_p_value: float = 1e-4
    """The same where no effect that was fitted has earned its place [1]."""
    largest_excess_over_stated_noise: float = 0.02
    """Largest excess of a run's mean square over the stated noise that a model with effects may have [1].

    What chance explains is taken off before. A model discrepancy may pass for correlated noise: a friction lag that was
    left out of the catalogue was named as two other effects, and the rest was taken for noise.
    """
    largest_share_of_nominal_excess: float = 0.005
    """The same as a share of the excess that the nominal model has [1]; the larger of the two limits holds."""
    least_own_squared_sine: float = 1e-4
    """Squared sine of the angle to the tangent space of the fit below which a direction does not count as a run's own
    [1]."""

    # Step 9: an effect has earned its place.
    least_gain_in_criterion: float = 6.0
    """Least gain in the criterion K that an effect has to bring [1]."""
    least_wald_statistic: float = 9.0
    """Least Wald statistic of an effect's amplitudes, or least loss of the criterion without the effect [1].

    Both are tried, as the curvature may mislead: a bent spring beside a drift had a Wald statistic of 5, although
    leaving it out cost 42,000.
    """
    rival_criterion_gap: float = 10.0
    """Difference of the criterion within which two candidates cannot be told apart (steps 14 and 15) [1]."""

    # Step 8: budgets of a refit, in simulations of all runs.
    first_try_simulations: int = 6
    """Largest number of simulations of all runs in a first try."""
    continued_simulations: int = 25
    """Largest number of simulations of all runs when a first try is continued."""
    full_fit_simulations: int = 60
    """Largest number of simulations of all runs in a fit to the end."""
    most_fits_under_new_noise: int = 5
    """Largest number of fits under a re-estimated noise: a fit that has not converged yet passes for noise that is not
    there."""
    settled_gain_change: float = 0.05
    """Relative change of the low-frequency gain of the sensor's noise below which the noise has settled [1]."""
    settled_scatter_change: float = 0.1
    """Relative change of a scatter's size, and change of its centre's effect on the reading over the sensor's standard
    deviation, up to which the scatter has settled [1]."""

    # Step 8: where a refit begins.
    largest_start_size: float = 10.0
    """Largest factor on an effect's typical size at the start, for an effect with shape parameters [1]."""
    largest_start_size_without_shape: float = 0.01
    """The same for an effect without shape parameters [1]."""
    least_second_shape_share: float = 0.5
    """Share of the score statistic T from which the next shape is tried too [1]."""
    largest_first_try_loss: float = 40.0
    """Loss of log-likelihood in a first try that shows its amplitude to be too large [1]."""
    amplitude_share_after_loss: float = 0.1
    """Share of the amplitude at which such a try begins again [1]."""

    # Step 8: what counts as a parameter, and what lies at its bound.
    informed_std_over_range: float = 0.5
    """Standard error over the range of a shape parameter (at most a factor e) below which the data inform it [1]."""
    least_margin_at_bound: float = 1e-3
    """Relative distance from the lower bound at which a wave number or time constant counts as lying there [1].

    A wave longer than the travel is a bent spring.
    """
    largest_margin_at_bound: float = 0.5
    """Largest such distance where two standard errors reach the bound [1].

    A wave or time that cannot be told from the end of its range lies at its bound: a cubic spring that was left out of
    the catalogue had been called cogging of a third of a wave.
    """
