"""Thresholds of the FMUs: numbers that decide what an FMU states, and what is refused before it is built."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Thresholds:
    """Numbers that decide what an FMU states and what it is built from, each with its quantity and unit."""

    # Description of variables.
    least_nominal_of_scale: float = 1e-9
    """Smallest nominal value over the magnitude of the bounds: solvers scale their tolerances by nominal values."""
    rounding_of_scale: float = 1e-12
    """Share of the magnitude of the bounds below which a value of either sign is zero but for rounding."""

    # What a result may state.
    largest_magnitude_si: float = 1e15
    """Largest magnitude of a parameter in SI units, beyond that of any machine, where no closer range is known."""
    largest_excess_over_bound: float = 1e-9
    """How far a value may lie beyond its bounds, relative to them: a fit works with its logarithm."""
    largest_shortfall_of_stiction: float = 1e-4
    """How far Fs may lie below Fc, relative to it: a minimiser passes a constraint at which it ends by as much."""
    rounding_of_second_moment: float = 1e-6
    """Magnitude of a negative second moment of mass that counts as rounding, relative to the inertia's largest entry.

    The smallest moment of a disc or a rod is 0.
    """
    longest_path_characters: int = 1024
    """Characters of a device's path; the shortest limit among the systems, macOS's."""

    # Reference run.
    reference_amplitude_without_stiction_Nm: float = 1e-2
    """Torque [N m] where the equations have no stiction to measure it by."""

    # Files for multibody simulators.
    inertia_of_massless_body_si: float = 2e-15
    """Mass [kg] and inertia [kg m²] of a massless body that moves, in MJCF: MuJoCo refuses less than 1e-15."""
    limit_where_none_is_stated_si: float = 1e6
    """Effort, speed and position of a limit that the device does not state, in SI units: URDF demands a number."""
    impedance_of_followers: float = 0.9999
    """Share of the acceleration by which MuJoCo holds a passive link to its joint; MuJoCo takes at most 0.9999."""
    time_constant_of_followers_s: float = 1e-3
    """Time [s] in which MuJoCo's equality of two joints returns; MuJoCo takes no less than twice its step."""


THRESHOLDS = Thresholds()
