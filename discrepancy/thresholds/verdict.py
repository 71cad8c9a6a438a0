"""Thresholds of `discrepancy/verdict/`: names, reported parameters, the next experiment."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class VerdictThresholds:
    """Names and alternatives, reported parameters, and the next experiment."""

    # Step 15: the verdict.
    least_evidence_of_each_name: float = 30.0
    """Least evidence of each of several names [1]: several weak ones together mend what one unknown effect causes."""
    bags: int = 40
    """Number of bags of stretches in which a name must prove itself [1]: the share is known to about 8 %."""
    least_stretches_of_bag: int = 16
    """Smallest number of stretches of all fitted runs together from which bags are drawn [1]."""
    most_alternatives_listed: int = 3
    """Number of alternatives that are listed where none is a rival."""

    # Step 16: reported parameters.
    reported_step_divisor: int = 4
    """Least division of the coarse inner step for parameters that are reported.

    A lag of 0.447 ms was reported as 0.246 ± 0.027 ms at a step of 2.5 ms, and as 0.400 ± 0.095 ms at a quarter of it:
    the error of the step stands for part of the lag, and no reading shows it.
    """
    contact_step_divisor: int = 8
    """The same division where bodies touch and part."""
    sharper_contact_factor: float = 10.0
    """Factor by which contacts are sharpened there [1].

    A damper that engages over 1/200 of its play can be followed from far off, but makes the play too wide by as much:
    one in four 95 % intervals missed the truth.
    """
    most_errors_between_fits: float = 2.0
    """Distance between two fits of one model over the standard error beyond which that distance is the error [1]."""

    # Step 17: the grid of proposed runs.
    proposed_amplitudes_and_offsets: tuple[tuple[float, float], ...] = ((1.0, 0.0), (0.5, 0.0), (0.5, 0.3))
    """Amplitudes and offsets of the grid, as shares of the largest torque that was used [1]."""
    proposed_frequencies_over_fastest: tuple[float, ...] = (0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0)
    """Frequencies of the grid, as multiples of the fastest one that was used [1]."""
    least_rows_per_period: int = 8
    """Least number of readings in a period of a proposed torque faster than any that was used."""

    # Step 17: which proposed run helps.
    largest_excursion_over_travel: float = 0.05
    """Share of the travel by which a proposed run may leave the travel [1]."""
    most_repeats: int = 10
    """Largest number of repeats for which a run counts as helpful."""
    clear_evidence: float = 50.0
    """Expected evidence, twice the difference of log-likelihoods, at which the runs tell the rivals apart [1].

    Ten of it are needed, ten may speak for the wrong one beforehand, and its standard deviation is 2·√50 = 14.
    """
