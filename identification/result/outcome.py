"""Outcome of a fit: basins and residuals over the noise in, one `Outcome` with its sentence out."""

from __future__ import annotations

from enum import Enum

from haptid.identification.thresholds import THRESHOLDS
from haptid.support.errors import NumericalError


class NoStartError(NumericalError):
    """No start of a fit gave a finite simulation: what the user states of the parameters is far from the joint."""


class Outcome(Enum):
    """How a fit ended: the name goes into files, the value is the sentence for the reader."""

    CONVERGED = "converged: several starts agree on the best minimum, and what is left is the sensor's noise"
    ABOVE_NOISE = (
        "several starts agree on the best minimum, but the residual stays above the sensor's noise: "
        "the model lacks something; try haptid missing (python -m discrepancy.run in a clone)"
    )
    SINGLE_START = (
        "only one start reached the best minimum, which leaves the sensor's noise; "
        "raise --starts to be sure that it is the best"
    )
    LONELY = (
        "only one start reached the best minimum, and it lies above the sensor's noise; "
        "look whether columns and units are right, then raise --starts"
    )
    UNEXPLAINED = (
        "the model explains hardly anything of the motion: look whether the columns of torque and position, their "
        "units and their signs are right (haptid check, or python -m measurement.check in a clone), then what it lacks "
        "(haptid missing, or python -m discrepancy.run)"
    )
    UNEXCITED = (
        "the torque never changes in the fitted runs, so that they do not tell how the joint answers to it: "
        "look whether the torque was recorded, and in which column; of a joint that swings freely fix what is known, "
        "as the weighed inertia, under [joint.J.parameters], which gives the rest its scale"
    )
    FIXED = "every parameter is fixed, so that nothing was fitted: the scores are those of the model as it is stated"
    UNSEEN = (
        "the fitted runs are at the sensor's noise, but runs that no fit saw are not: "
        "look whether their columns and units are those of the fitted runs, or try haptid missing "
        "(python -m discrepancy.run in a clone)"
    )
    TOO_FEW_ROWS = (
        "the fitted runs hold too few rows for so many parameters, so that a small residual says nothing: "
        "measure longer, or fix parameters under [joint.J.parameters]"
    )
    TORQUE_SCORED = (
        "recorded under position control: fitted to the torque with the measured motion as input, "
        "because a simulation from this torque drifts"
    )
    PLAIN = (
        "the plain model (inertia, gravity, Coulomb and viscous friction, a constant torque) predicts the torque and "
        "the next second of motion of the runs that no fit saw better than a fit of the whole model, so that it is the "
        "result; for what both lack try haptid missing (python -m discrepancy.run in a clone)"
    )
    OBSERVED = (
        "small errors grow during these runs: fitted with the measured position fed back through an observer, "
        "not as a free simulation"
    )

    @property
    def label(self) -> str:
        """Short form in files: ``converged``, ``above_noise``, …."""
        return self.name.lower()


LONELY_NEAR_THE_DATA = (
    "only one start reached the best minimum, and it lies above the sensor's noise, though it follows the motion; "
    "raise --starts, then see what the model lacks: haptid missing (python -m discrepancy.run in a clone)"
)
"""Sentence of `Outcome.LONELY` where little of the motion is left, so that columns and units are right."""
MODEL_DOES_NOT_FIT = (Outcome.ABOVE_NOISE, Outcome.LONELY)
"""Outcomes in which the data determine values of a model that lacks something: no value is told as certain."""
TOLD_AS_UNCERTAIN = (*MODEL_DOES_NOT_FIT, Outcome.PLAIN, Outcome.OBSERVED, Outcome.TORQUE_SCORED)
"""Outcomes whose values may have been moved by what the model lacks: besides those that do not fit, the plain model,
which stands in for a model above the noise, and fits whose free simulation misses the runs: under an observer, and of
the torque, which is fitted only then."""
UNCERTAIN = "uncertain"
"""Word that is told for such a value, in place of ``identified``."""


def tell_status(status: str, outcome: str) -> str:
    """Return the word under which terminal, report, API and FMUs tell a parameter.

    The status of such a parameter is ``identified``, by a standard deviation that the jackknife widened. What the model
    lacks may still have moved the value further: a cubic spring that it lacks turns gravity to the other sign.

    Parameters
    ----------
    status
        Status of the parameter in the fit.
    outcome
        Label of the fit's outcome.

    Returns
    -------
    str
        `UNCERTAIN` for an identified parameter of a model that does not fit, else ``status``.
    """
    unfit = status == "identified" and outcome in [one.label for one in TOLD_AS_UNCERTAIN]
    return UNCERTAIN if unfit else status


def outcome_of(
    reached: int, rms_over_noise: float, tolerance: float, *, unseen: float, rows: int, parameters: int
) -> Outcome:
    """Judge how a fit ended.

    Parameters
    ----------
    reached
        Number of starts in the best basin.
    rms_over_noise, unseen
        RMS of the residual over the noise: of the fitted runs, and the largest of runs that no fit saw (0 for none).
    tolerance
        RMS of the residual over the noise up to which the residual counts as noise.
    rows, parameters
        Number of readings of the fitted runs, and of fitted parameters.

    Returns
    -------
    Outcome
    """
    # The order matters: without free parameters or with too few rows, no later comparison means anything.
    if parameters == 0:
        return Outcome.FIXED
    if rows < THRESHOLDS.least_rows_per_parameter * parameters:
        return Outcome.TOO_FEW_ROWS
    quiet = rms_over_noise <= tolerance
    if quiet and not is_like_fitted(unseen, tolerance):
        return Outcome.UNSEEN
    return outcome_of_starts(reached, quiet=quiet)


def is_like_fitted(unseen: float, tolerance: float) -> bool:
    """Say whether an unseen run is simulated nearly as well as the fitted ones of a fit at the noise.

    Parameters
    ----------
    unseen
        RMS of its residual over the noise.
    tolerance
        RMS of the residual over the noise up to which the residual counts as noise.

    Returns
    -------
    bool
        False for a NaN of a simulation that is not finite.
    """
    return unseen <= THRESHOLDS.largest_unseen_residual_over_tolerance * tolerance


def outcome_of_starts(reached: int, *, quiet: bool) -> Outcome:
    """Judge a fit by its residual and by how many starts reached its minimum.

    Parameters
    ----------
    reached
        Number of starts in the best basin.
    quiet
        Whether the residual is at the noise.

    Returns
    -------
    Outcome
    """
    if reached > 1:
        return Outcome.CONVERGED if quiet else Outcome.ABOVE_NOISE
    return Outcome.SINGLE_START if quiet else Outcome.LONELY


def with_cause(outcome: Outcome, *, over_motion: float, excited: bool, scaled: bool = True) -> Outcome:
    """Replace an outcome by its plain cause, where there is one.

    Parameters
    ----------
    outcome
        Outcome as `outcome_of` judged it.
    over_motion
        RMS of the residual over that of the motion about its mean, in the fitted runs.
    excited
        Whether the torque changes in some fitted run, or gravity and springs alone move the joint, and a stated value
        gives them their scale.
    scaled
        Whether a torque or a stated value gives the parameters their scale. Without it a residual at the noise tells
        their ratios alone.

    Returns
    -------
    Outcome
        ``outcome`` itself where no plain cause is seen, as of a residual at the noise of parameters with a scale.
    """
    if not scaled and outcome not in (Outcome.FIXED, Outcome.TOO_FEW_ROWS):
        return Outcome.UNEXCITED
    # Without a changing torque a model cannot explain the motion: this cause comes before `UNEXPLAINED`.
    if outcome not in MODEL_DOES_NOT_FIT:
        return outcome
    if not excited:
        return Outcome.UNEXCITED
    return Outcome.UNEXPLAINED if over_motion > THRESHOLDS.largest_residual_over_motion else outcome
