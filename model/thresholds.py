"""Thresholds of the model: numbers of ranges, first guesses, steps and refusals."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Thresholds:
    """Numbers that decide ranges, first guesses, steps and refusals of the model, each with its quantity and unit."""

    # Joint equations and their ranges.
    inertial_bounds_in_prior_std: float = 5.0
    """Distance of the bounds of an inertial coefficient from its first guess, in standard deviations of its prior."""
    largest_inertia_over_guess: float = 20.0
    """Largest factor between a moment of inertia and its first guess, above and below."""
    bristle_length_over_travel: float = 0.01
    """First guess of the bristle's length, as a share of the travel."""
    following_rate_per_s: float = 50.0
    """First guess of C over Fc [1/s]."""
    stiction_over_coulomb: float = 1.2
    """First guess of stiction over Coulomb friction; a URDF states a single number for both."""

    # Catalogue of effects.
    settling_rate_per_s: float = 1e4
    """Rate at which a settled amplifier takes the first command, within the first half millisecond [1/s]."""
    largest_friction_harmonic: float = 0.23
    """Bound of an amplitude of the series [1]: with all of them at their bounds dry friction stays above 0."""
    wall_rate_of_play_per_s: float = 2000.0
    """Rate at which the play's wall holds the encoder [1/s]."""
    onset_of_stop_damper_over_travel: float = 2e-3
    """Share of the travel over which the stop's damper engages."""

    # What a device file may state.
    least_share_of_common_letters: float = 0.6
    """Share of common letters from which a name is taken for a misspelling (``xzy`` for ``xyz`` has two thirds)."""
    largest_factor_beyond_range: float = 1e3
    """Factor by which a stated number may lie beyond its default range; a wrong unit lies further out."""
    least_std_over_value: float = 1e-12
    """Smallest standard deviation of a prior, relative to the prior's mean: the weight of a sharper prior overflows."""
    largest_value_si: float = 1e12
    """No length, mass, torque or angle of a robot is larger in SI units."""

    # Kernel.
    inner_step_s: float = 5e-4
    """Inner step [s], as in Tam, Kubica and Wang (2005), section IV."""
    most_inner_steps_of_call: int = 50_000
    """Inner steps of one call: far below a second for a joint, about one for a whole device with sensitivities."""
    most_substeps_of_inner_step: int = 8
    """Largest number of sub-steps of an inner step; a trial that needs more has contacts too stiff for the sampling."""

    # Planning.
    reach_of_postures_over_range: float = 0.9
    """Share of the range between the position limits that postures use, about its middle."""
    torque_amplitudes_over_largest: tuple[float, ...] = (0.15, 0.3, 0.5, 0.75, 1.0)
    """Torque amplitudes of the grid, as shares of the largest torque that keeps the joint within its limits."""


THRESHOLDS = Thresholds()
