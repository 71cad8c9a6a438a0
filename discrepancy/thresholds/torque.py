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
    stretches_per_run: int = 48
    """Number of stretches into which a run is divided."""
    stretches_per_held_out_one: int = 3
    """Number of stretches of which the last one is held out.

    A sweep there and back shows a held-out position once more in the other direction.
    """

    # How much is tried.
    most_effects: int = 4
    """Largest number of effects in a model."""
    most_refits_of_scan: int = 4
    """Number of effects of a scan that are refitted."""

    # What is accepted.
    least_twice_gain: float = 2.0
    """Least gain, twice in log score, on fitted rows (after the charge for parameters) and on held-out rows [1]."""
    mean_span_s: float = 0.1
    """Span over which the residual torque is averaged [s]: the residual is correlated over many rows."""
