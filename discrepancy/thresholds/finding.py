"""Thresholds of `discrepancy/finding/`: what is said of the gap before and after."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class FindingThresholds:
    """When a model discrepancy counts as explained, and how much of it is listed."""

    # Amplitudes that scatter.
    largest_share_beside_scatter: float = 1.05
    """Share of a discrepancy beside the scatter up to which it counts as all of it [1]: noise estimates differ by as
    much."""

    largest_rms_as_scatter: float = 1.05
    """RMS of whitened residuals up to which noise and scatter explain them [1]."""
    least_excess_over_noise: float = 0.05
    """Excess of the RMS over the noise, over the noise, from which on a share of it is told [1]: below, the share would
    be a quotient of estimation errors."""

    # Joints of which the plain model is the result.
    least_share_closed_in_position: float = 0.5
    """Share of the gap in unseen runs from which on effects found in the position stand; else the torque is searched
    [1]."""

    # Runs in which all joints move.
    largest_rms_over_expected: float = 3.0
    """RMS over the expected one beyond which a joint has a discrepancy [1]: the parameters' error is one draw for the
    whole run."""

    # Runs under position control.
    largest_rms_over_torque_noise: float = 1.1
    """RMS over the noise up to which the torque of held-out rows counts as explained [1]."""
    position_bins: int = 10
    """Number of bins of position over which the residual torque is averaged."""

    # The stages of the search alone.
    most_scores_listed: int = 5
    """Largest number of best-scoring effects that are listed."""
