"""Thresholds of uncertainty: every number that decides the noise model, the inner step, and what a posterior says.

A number without a derivation in its docstring was chosen. What halving and doubling it changes in a panel of cases
stands in `docs/results/thresholds.md`.
"""

from __future__ import annotations

from dataclasses import dataclass

from haptid.identification.thresholds import THRESHOLDS as IDENTIFICATION


@dataclass(frozen=True, slots=True, kw_only=True)
class Thresholds:
    """Numbers that decide an outcome of uncertainty, each with its quantity and unit."""

    # Inner step: the longest one whose error is negligible.
    inner_steps_s: tuple[float, ...] = (5e-3, 2.5e-3, 1.25e-3, 6.25e-4)
    """Inner steps [s] that are tried, the longest first."""
    inner_step_of_correction_s: float = 2.5e-4
    """Inner step [s] of the simulation to which a coarser simulation is compared."""
    largest_std_of_solver_error: float = 0.1
    """Standard deviation of the solver's error in the log density [1] up to which an inner step is accepted. By Cauchy
    and Schwarz no posterior mean then moves by more than this share of its standard deviation."""
    draws_of_solver_error: int = 16
    """Draws of the normal approximation from which the solver's error is estimated [1]."""
    most_halvings_of_a_draw: int = 30
    """Times that a draw's distance from the mode is halved [1], until the posterior reaches the draw."""

    # Mode: when the climb ends, and how wide the normal approximation may be.
    largest_last_change_of_log_posterior: float = 0.05
    """Change of the log posterior [1] below which the climb has converged."""
    largest_last_change_of_short_climb: float = 0.5
    """The same of a short sampling [1]: a sixth of the gain that decides between noise models."""
    largest_std_of_log_noise: float = 3.0
    """Largest standard deviation of a noise parameter's logarithm in the normal approximation [1]."""

    # Noise model: which one the held-out runs choose.
    least_noise_factor_of_scatter: float = 1.2
    """Noise factor [1] from which the residual counts as larger than the sensor noise."""
    draws_of_held_out_score: int = 64
    """Draws of the normal approximation over which a held-out density is averaged [1]."""
    least_shortfall_of_hopeless_model: float = 100.0
    """Log posterior below that of the best noise model so far [1] from which a short climb that will not catch up ends:
    far more than the few parameters by which noise models differ are worth."""
    least_gain_of_held_out_score: float = 3.0
    """Gain in held-out log predictive density [1] below which the simpler model is kept: strong evidence in the words
    of Kass and Raftery (1995), because the best of six alternatives gains one or two by chance."""

    # Chains: starts, proposals, autocorrelation and modes of the ensembles.
    dispersed_start_over_std: float = 3.0
    """Factor [1] on the standard deviations of the normal approximation in the start of every second ensemble."""
    degrees_of_freedom_of_proposals: float = 10.0
    """Degrees of freedom of the Student distribution of independent proposals [1]."""
    window_over_autocorrelation_time: float = 5.0
    """Lag over τ(M) [1] from which the sum of autocorrelations is cut off (Sokal's window)."""
    least_distance_of_modes_in_std: float = 6.0
    """Scaled Mahalanobis distance of two ensembles' means [standard deviations] from which they count as two modes."""
    most_inner_steps_of_short_chains: float = 5e8
    """Inner steps that all walkers of short chains simulate together [1]: about half a minute on one core."""
    least_share_of_short_chains: float = 1 / 3
    """Smallest share of the steps of short chains to which that bound may shorten them [1]."""
    stored_draws_of_short_chains: int = 400
    """Draws of short chains in the files [1], at each of which every cycle is scored given all others of its run."""
    least_rhat_of_disagreement: float = 1.01
    """R̂ [1] from which ensembles disagree, so that the posterior is not sound."""

    # The fit that the chains start from.
    largest_distance_from_fit_in_std: float = 4.0
    """Distance of a posterior mean from the fit's estimate [standard deviations of both together] from which they
    contradict each other. Both see the same data, so that chance alone puts them far closer."""

    # Statements: intervals, and in which words a parameter is told.
    probability_contents: tuple[float, ...] = (0.5, 0.8, 0.95)
    """Probability contents of intervals and of predictive bands [1]."""
    largest_std_over_prior_std: float = IDENTIFICATION.largest_std_over_prior_std
    """Posterior over prior standard deviation [1] above which the prior counts as what determines the parameter; fits
    judge by the same bound."""
    largest_half_width_of_known: float = 0.5
    """Half width of a 95 % interval over the median [1] up to which a parameter is told as known."""
    largest_distance_to_bound_over_reach: float = 0.03
    """Distance of the lower end of a 95 % interval from the lower bound, over that of the upper end [1], below which
    the parameter counts as at that bound (and likewise above): a density that is level down to the bound has
    2.5/97.5 = 0.026, a normal one whose peak lies 1.5 standard deviations from it 0.046."""
    least_ratio_of_scatter_ends: float = 0.01
    """Lower over upper end of a scatter's 95 % interval [1] below which the sentence gives the upper end only."""

    # Predictions: what is tried, and from how many draws.
    tried_amplitudes_over_largest: tuple[float, ...] = (0.5, 0.7, 1.0, 1.4)
    """Torque amplitudes of the next run that are tried, over the largest amplitude of a fitted run [1]."""
    tried_frequencies_over_median: tuple[float, ...] = (0.5, 0.75, 1.0, 1.5, 2.0, 3.0)
    """Angular frequencies of the next run that are tried, over the median of the fitted runs [1]."""
    draws_of_whole_device: int = 40
    """Draws of the whole device's parameters behind its bands [1]."""

    # Posterior of a foreign FMU, whose every simulation is a call of its code.
    reach_of_open_bound_in_std: float = 100.0
    """Distance from the estimate to a bound that nobody states [standard deviations]: the flat prior is far wider than
    the posterior."""
    draws_of_foreign_band: int = 200
    """Draws of the posterior behind the predictive band of a run [1]."""


THRESHOLDS = Thresholds()
"""Thresholds that the code of `uq/` uses."""
