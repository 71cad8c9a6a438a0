"""Thresholds of `discrepancy/torque/`: the search in the torque of runs under position control."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class TorqueThresholds:
    """Stretches, budget and acceptance of the search in the torque."""

    # How runs are simulated and cut.
    inner_step_s: float = 2.5e-3
    """Inner step [s]: the motion is measured, and the bristle's equation is integrated exactly within a step."""
    slow_share_of_fast_speed: float = 0.3
    """Share of the 90 % quantile of the speed up to which rows are slow: noise may turn the sign of their speed [1]."""
    largest_gain_of_known_drive: float = 2.0
    """Largest plant gain of a drive whose torque constant and resistance were identified or stated, and the inverse of
    the smallest one [1]."""
    longest_presliding_over_travel: float = 0.1
    """Longest distance before sliding, Coulomb friction over the stiffness in presliding, over the travel [1]."""
    stretches_per_run: int = 48
    """Number of stretches into which a run is divided."""
    stretches_per_held_out_one: int = 3
    """Number of stretches of which the last one is held out.

    A sweep there and back shows a held-out position once more in the other direction.
    """

    # How much is tried.
    least_decrease_of_cost: float = 1e-5
    """Predicted decrease of the cost over the cost below which a descent stops [1]: times the few hundred correlation
    lengths of a residual it is a thousandth of a unit of log score."""
    least_decrease_of_trial: float = 1e-4
    """The same while effects are tried: a hundredth of a unit of log score decides nothing."""
    least_kept_share_of_promise: float = 0.9
    """Share of the energy that the scan promised to first order [1] from which a refit has found what was promised: a
    second start, with smaller amplitudes, is for linear estimates that are far too large."""
    most_simulations_of_start: int = 60
    """Largest number of simulations of all runs from one start, of the torque or through the controller."""
    most_effects: int = 4
    """Largest number of effects in a model."""
    most_refits_of_scan: int = 4
    """Number of effects of a scan that are refitted."""

    # Waves over position beyond the grids of the catalogue.
    rows_per_position_bin: int = 4
    """Number of fitted rows for each bin over which the residual is averaged, on average."""
    degree_of_power_over_wave_number: int = 3
    """Degree of the polynomial of ln n that stands for the power of noise."""
    wave_p_value: float = 1e-3
    """Probability with which noise alone shows a wave anywhere [1]."""
    most_waves_beyond_grid: int = 3
    """Number of waves that are offered to the effects."""
    bound_over_highest_wave: float = 1.2
    """Upper bound of a wave number over the highest wave that was found [1], as for the grids."""

    # What is accepted.
    least_twice_gain: float = 2.0
    """Least gain, twice in log score, on fitted rows (after the charge for parameters, so in BIC) and on predicted ones
    [1]: less is not worth more than a bare mention (Kass and Raftery 1995)."""
    stretch_in_correlation_lengths: float = 5.0
    """Length of a stretch whose energy counts as one fact, in correlation lengths of the residual."""
    least_runs_of_run_friction: int = 3
    """Number of runs [1] from which friction may differ from run to run: of two, each has its own half of anything."""
    largest_rms_with_run_friction: float = 0.9
    """RMS left with friction of each run over the one without, on fitted and on held-out rows, and over that of the
    better black box, up to which it is taken out [1]: a fifth of the energy goes by one number a run. On a gear that
    warmed up it was 0.34."""
    degree_of_speed_curve: int = 3
    """Degree of the curve of friction over speed that is held against it [1]."""
    part_that_gives_friction: float = 1.0 / 3.0
    """Part of a held-out run that gives the level of its friction [1]; it is scored no more."""
    rows_of_starting_bristle: int = 20
    """Rows at the beginning of a run that tell nothing of its friction: bristles there settle from rest."""
    passes_of_run_friction: int = 2
    """Number of times that levels and model are fitted in turn."""
    least_stretches: int = 16
    """Fewest stretches that are predicted from the others, even where they get shorter by that."""
    least_gain_in_standard_errors: float = 1.0
    """Least decrease of the energy of predicted stretches, in its standard errors over the stretches."""
    least_amplitude_in_standard_errors: float = 3.0
    """Least amplitude of an effect in its standard errors."""
    least_stability_of_certain_name: float = 0.33
    """Least share of bags in which a certain name is kept [1]: half, less two standard errors of a share of the bags.

    A cable and a Stribeck curve of another shape, which an axis had not, kept theirs in 0 and 0.18 of the bags.
    """
    largest_rms_of_free_simulation: float = 2.0
    """Position's RMS error in free simulation of unseen runs with named effects over that without, above which they are
    doubted [1]. Small errors of the torque grow on the way: with the direction-dependent viscous friction of a linear
    axis, which removes a third of its torque's discrepancy, the drift is 1.4 times that without.
    """
    largest_change_of_inertia: float = 2.0
    """Inertia with an effect over that of the nominal model, or its inverse, above which the effect is doubted, and a
    delay is not taken at all [1].

    A nominal model takes inertia I, viscous friction c and a lag T of the torque for an inertia of I + c·T. That is
    twice the inertia where T is the joint's own time constant I/c: a longer lag has changed places with the inertia. A
    lag of 0.29 s, where the axis had none, left 0.73 kg of 24 kg.
    """
    least_change_of_inertia_in_standard_errors: float = 2.0
    """The same change in standard errors of both models, below which it is none [1]."""
    least_inertia_in_standard_errors: float = 2.0
    """Inertia of the nominal model in its standard errors below which no free simulation is asked [1]: in a slow sweep
    any small error of the torque lets the joint stick or run away, whatever the model."""
    degree_of_black_box: int = 7
    """Degree of the polynomials of position that stand for the best black box, one for each direction."""
    least_share_of_black_box: float = 0.9
    """Least share of what the best black box closes that names have to close to stand alone."""
    largest_rms_through_controller: float = 1.1
    """Position's RMS error through the recorded controller with named effects over that without, on runs of any use,
    above which the names are no finding [1]: runs of one use are too few to differ by less."""
    least_share_of_repeated: float = 0.75
    """Least share of the energy that repeats that names have to close to stand alone: less than half its RMS is left.

    A ripple that closed 0.68 of it, beside a friction that differs between directions, was no whole answer."""
