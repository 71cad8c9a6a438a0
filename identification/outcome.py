"""How a fit ended, in words."""

from __future__ import annotations

from enum import Enum


class Outcome(Enum):
    """Sentences; the name goes into files, the value to the reader."""

    CONVERGED = "converged: several starts agree on the best minimum, and what is left is the sensor's noise"
    ABOVE_NOISE = (
        "several starts agree on the best minimum, but the residual stays above the sensor's noise: "
        "the model lacks something; try python -m discrepancy.run"
    )
    SINGLE_START = (
        "only one start reached the best minimum, which leaves the sensor's noise; "
        "raise --starts to be sure that it is the best"
    )
    LONELY = "only one start reached the best minimum, and it lies above the sensor's noise; raise --starts"
    TORQUE_SCORED = (
        "recorded under position control: fitted to the torque with the measured motion as input, "
        "because a simulation from this torque drifts"
    )
    OBSERVED = (
        "small errors grow during these runs: fitted with the measured position fed back through an observer, "
        "not as a free simulation"
    )

    @property
    def label(self) -> str:
        """The short form used in files: ``converged``, ``above_noise``, …."""
        return self.name.lower()


def outcome_of(reached: int, rms_over_noise: float, tolerance: float) -> Outcome:
    """Return the outcome from the number of starts in the best basin and the residual over the noise."""
    quiet = rms_over_noise <= tolerance
    if reached > 1:
        return Outcome.CONVERGED if quiet else Outcome.ABOVE_NOISE
    return Outcome.SINGLE_START if quiet else Outcome.LONELY
