"""Remark on runs that stand alone in their lock posture: runs in, a sentence by file out.

Coefficients of a joint differ between postures: a fit of one posture tells nothing of a run in another.
"""

from __future__ import annotations

from collections.abc import Sequence

from haptid.measurement.values.postures import locked_posture
from haptid.measurement.values.run import Run


def find_unfitted_postures(runs: Sequence[Run]) -> dict[str, str]:
    """Find validation runs that no fit of their joints compares with: none of the fitted runs has their posture.

    Parameters
    ----------
    runs
        Runs of a campaign.

    Returns
    -------
    dict
        A sentence by file.
    """
    fitted = _fitted_postures(runs)
    found: dict[str, str] = {}
    for run in runs:
        # Joints that are only validated, as the whole device is, are simulated with the values of all fits.
        if run.use != "validate" or run.free_joints not in fitted or locked_posture(run) in fitted[run.free_joints]:
            continue
        found[run.file] = (
            f"no run to fit has its posture ({_words(run)}): it is compared with nothing; correct "
            "locked_positions_rad, or fit a run in this posture"
        )
    return found


def find_lonely_postures(runs: Sequence[Run]) -> dict[str, str]:
    """Find runs that are the only one to be fitted in their posture, beside other postures of the same joints.

    Parameters
    ----------
    runs
        Runs of a campaign.

    Returns
    -------
    dict
        A sentence by file.
    """
    fitted = _fitted_postures(runs)
    found: dict[str, str] = {}
    for run in runs:
        alone = run.use == "fit" and len(fitted[run.free_joints]) > 1
        if alone and fitted[run.free_joints][locked_posture(run)] == 1:
            found[run.file] = (
                f"the only run to fit in its posture ({_words(run)}): each posture of a joint is fitted on its own; "
                "where the lock was the same as in other runs, state one locked_positions_rad"
            )
    return found


def _fitted_postures(runs: Sequence[Run]) -> dict[tuple[int, ...], dict[tuple[float, ...], int]]:
    """Count the runs to fit by free joints and posture."""
    counts: dict[tuple[int, ...], dict[tuple[float, ...], int]] = {}
    for run in runs:
        if run.use == "fit":
            of_joints = counts.setdefault(run.free_joints, {})
            posture = locked_posture(run)
            of_joints[posture] = of_joints.get(posture, 0) + 1
    return counts


def _words(run: Run) -> str:
    """Name the positions of the locked joints, as ``1 at +0.3``."""
    held = [f"{joint} at {x:+.3g}" for joint, x in enumerate(run.posture) if joint not in run.free_joints]
    return ", ".join(held)
