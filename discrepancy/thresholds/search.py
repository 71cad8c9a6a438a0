"""Thresholds of `discrepancy/search/`: how many effects go on from one step of the search to the next."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class SearchThresholds:
    """Numbers of candidates, and the gains that ask for more of them."""

    # Step 9: other friction laws in the nominal model.
    largest_excess_under_other_law: float = 0.5
    """Share of the nominal model's excess energy that another friction law may leave to be searched under [1]."""
    largest_excess_over_best_effect: float = 0.5
    """Share of what the best single effect leaves, up to which the other law is searched under at once [1]."""
    largest_excess_beside_effects: float = 0.75
    """Excess ‖r‖² under the observer with another law over that with the law of the study, beside the same effects, up
    to which the other law is searched under [1]: no further effect takes such a share there."""
    largest_excess_under_right_law: float = 0.005
    """The same for a law with no more parameters to be taken at once, though something is missing beside it [1]."""
    least_gain_under_other_law_chi2: float = 20.0
    """Decrease of ‖r‖² by brief fits under another law, in squares over the noise, below which the law is left [1]."""
    least_gain_under_other_law_over_excess: float = 0.2
    """The same as a share of the nominal model's excess energy [1]."""
    smaller_start_divisor: float = 10.0
    """Factor by which a second start begins below the guesses of what only the other law has [1]."""
    simulations_of_a_start_under_other_law: int = 12
    """Largest number of simulations of all runs from the best start under another law, until it has to gain."""

    # Step 10, single effects: how many go on after a first try.
    most_effects_continued: int = 8
    """Number of effects that are continued after a first try."""
    most_finished_fits: int = 8
    """Largest number of fits to the end in one step."""
    most_finished_if_none_adequate: int = 4
    """The same where no fit of the step is adequate."""
    most_finished_if_all_far: int = 2
    """The same where all fits of the step are far from noise."""
    rival_log_likelihood_gap: float = 40.0
    """Difference of log-likelihood from the best adequate fit within which a preliminary fit is finished as a rival
    [1]."""
    declared_rival_log_likelihood_gap: float = 120.0
    """The same for an effect that the catalogue calls a rival of the best one's [1]: its preliminary fit of a few
    simulations may be far from converged. A soft saturation, fitted to the end as likely as the best, was 46 behind."""
    least_lead_of_restart_over_excess: float = 0.05
    """Share of the excess energy of a finished fit by which a new start with the same effects must be ahead to be
    finished too [1]."""

    # Step 10, under scatter.
    largest_chi2_share_left_by_scatter: float = 0.1
    """Largest share of the nominal model's ‖r‖² that remains where scatter, or an effect, explains most of a large
    discrepancy [1]."""

    # Step 10, two at once.
    most_leading_fits: int = 3
    """Number of leading fits, each with another effect, on which a second effect is tried where no other way is
    adequate."""
    most_scores_on_leading_fit: int = 4
    """Number of best scores that are tried on top of a leading fit as it is, before many are tried from the first
    guesses.

    Two pairs that were unlisted were named this way, in a third of the time.
    """
    least_rounding_of_discontinuity: float = 0.01
    """Least rounding of a discontinuity, as a share of its threshold, while a second effect is searched for [1].

    Fits of both effects got stuck at a sharp discontinuity.
    """

    # Step 10, from the first guesses, under the gains of the observer.
    sieve_gains: int = 2
    """Number of homotopy gains of the first sieve."""
    sieve_simulations_per_gain: int = 12
    """Largest number of simulations of all runs under each gain of the sieve."""
    sieve_tolerance_chi2: float = 10.0
    """Predicted decrease of ‖r‖², in squares over the noise, at which a fit of the sieve ends [1]."""
    gains_until_distinguishable: int = 3
    """Number of homotopy gains after which effects are distinguishable."""
    gains_where_observer_hides: int = 4
    """Number of homotopy gains that are passed where the nominal model, far from noise in a free simulation, is near it
    after `gains_until_distinguishable`: an observer of 6 /s corrects what acts more slowly than that."""
    most_effects_released: int = 4
    """Number of effects that are continued from there without the observer."""
    most_effects_beside_effect: int = 12
    """Number of effects that are fitted from the first guesses beside another effect: those that score best there.

    In a study of pairs the missing effect scored first beside every leading fit that held a real one.
    """

    # Step 10, large effects under the observer.
    least_energy_for_observer: float = 4.0
    """Mean square of the nominal model's residual over the stated noise from which effects are searched under the
    observer [1]: twice the noise is left."""
    share_of_amplitude_under_observer: float = 0.3
    """Share of the typical amplitude at which signatures are taken under the observer [1]: what is missing is large."""
    shares_of_linear_amplitude: tuple[float, ...] = (1.0, 0.25, 0.0625)
    """Shares of the linear amplitude of an effect, of which the one that leaves least begins its try [1].

    On a slider with a one-sided spring the estimates of all springs were five times too large, and four simulations did
    not bring them back."""
    most_tries_under_observer: int = 12
    """Number of best scores that are tried under the observer in each round."""
    least_score_share_under_observer: float = 0.1
    """Share of the best score below which none is tried [1]."""
    simulations_of_a_try_under_observer: int = 4
    """Largest number of simulations of all runs under each gain of such a try.

    In a development case the missing friction asymmetry was sixth by score beside a ripple, and first after a try with
    two; effects many times the noise take more.
    """
    most_refits_under_observer: int = 4
    """Number of best tries that are finished in each round, beside the rivals of the best one."""
    most_scores_refitted_under_observer: int = 2
    """Number of best scores that are finished in any case."""
    least_share_under_observer: float = 0.15
    """Share of the excess ‖r‖² under the observer that an effect has to take to be added [1].

    The largest of three missing effects takes a third or more; what takes less follows a formula that is only near that
    of the machine."""
    least_share_of_all_under_observer: float = 0.005
    """The same as a share of the nominal model's excess [1]: what is left beside effects whose formulas are only near
    those of the machine is not searched on."""
    largest_share_of_hidden_signature: float = 0.03
    """Share of a signature's norm off the tangent space of the nominal model below which its score is not trusted [1].

    Signatures are differences of simulations. Beside rigid friction a cubic spring, which gravity and spring follow but
    for 0.009, scored the 13th part of what its fit took.
    """
    most_effects_under_observer: int = 4
    """Largest number of effects that are chosen under the observer."""
    largest_left_of_noise_under_observer: float = 1.3
    """Residual over the stated noise up to which a model is not searched under another friction law [1]: a stated noise
    may be off by as much."""
    largest_excess_beside_scatter: float = 0.5
    """Share of the nominal model's excess under the observer that the best effect may leave beside a scatter [1]."""
    largest_excess_over_replacement: float = 0.25
    """Excess ‖r‖² of a model under the observer over that with the best other effect in the place of one, up to which
    that one stands out [1]."""
    most_replacements_in_free_motion: int = 6
    """Largest number of models that come near under the observer, which are compared in free motion too."""
    largest_share_left_by_names: float = 0.06
    """Largest share of the nominal model's mean square beyond the sensor's noise on held-out runs that a model may
    leave whose names stand though it leaves more than noise [1]: three quarters of the discrepancy are removed."""
    most_turns_of_smooth_curve: int = 5
    """Largest number of turns, from bending one way to bending the other, of a torque over position that is a smooth
    curve over the travel [1]: a cubic has one, a wave two a period. With fewer than three periods none is shown."""
    points_of_smooth_curve: int = 401
    """Number of positions at which its bend is looked at [1]."""
    largest_excess_of_near_lead: float = 1.5
    """Excess ‖r‖² of a model over that of the best one, up to which its observer is released too [1]."""

    # Step 10, one more.
    least_score_share_of_small_effects: float = 0.1
    """Share of the best score below which an effect is not begun, where less than twice the noise is left [1].

    There the residual is linear in what is missing: in ten development cases of one small effect, the right one had
    0.92 of the best score or more, and came first or second."""
    most_effects_begun_on_effect: int = 20
    """Number of effects that are begun on top of an effect: by then the scores of the catalogue can be trusted as a
    first sieve."""
    least_share_that_asks_for_more: float = 0.2
    """Least share of the excess energy, or of the gain of the effect before, that asks for a further effect [1].

    Together with coarser columns of the scatter and fewer sub-steps in trials it halved the time of unlisted cases.
    """
    most_effects_at_once: int = 3
    """Largest number of effects in a model (step 11, too)."""

    # Steps 12 and 13: the nominal fit again, and the inner step.
    least_deviance_drop_of_stuck_fit: float = 10.0
    """Decrease of the nominal model's −2 ln L from the winner's optimum that shows its fit to have been stuck [1]."""
    least_excess_over_step_error: float = 10.0
    """Multiple of the step's visible error beyond which a residual cannot come from the step [1]."""
