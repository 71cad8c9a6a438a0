"""Look for runs whose torque has the wrong sign: runs of a campaign in, a sentence by file out.

1. Fit all runs of a joint at one posture by least squares: inertia, friction, gravity and a spring, the same for all.
2. Turn the torque of that run round whose turning helps the fit most, and go on while it helps.
3. What the fit says of the inertia then tells which runs are wrong: where it is plainly negative, those that were left
   as they are; else the fewer ones.

A run that is fast or slow alone shows no wrong sign: its inertia looks like a spring and its friction is small. The
joint's other runs tell.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from haptid.measurement.signals.smoothing import smooth
from haptid.measurement.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array, Run

ENDS = 20
"""Part of a run, as one over this number, that is left out at either end, where the smoothing sees no motion beyond."""
ALL_RUNS = (
    "a least-squares fit of the joint's runs has a negative inertia: is the torque's sign wrong, or the position's?"
)
"""What is said where every run of a joint is wrong."""


def tell_how_to_turn(command: str) -> str:
    """Say how the sign of what drives a joint is turned in all tables of a campaign.

    Parameters
    ----------
    command
        Column of the campaign format, as ``torque_0_Nm``.

    Returns
    -------
    str
        Clause that follows a remark.
    """
    return f"turn it by haptid init --map 'COLUMN={command}*-1' (in mN m, *-0.001), or the position likewise"


@dataclass(frozen=True, slots=True, kw_only=True)
class _Rows:
    """Regressor and torque of a run, both over the norm of its torque.

    Parameters
    ----------
    W
        Acceleration in the first column, then speed, its sign, 1 and functions of position, shape (n, n_columns).
    torque
        Smoothed torque, shape (n,).
    """

    W: Array
    torque: Array


@dataclass(frozen=True, slots=True, kw_only=True)
class _Fit:
    """What a least-squares fit of several runs leaves.

    Parameters
    ----------
    squares
        Sum of squares that is left, in squared torques of a run.
    squares_without_inertia
        The same of a fit without the acceleration.
    inertia
        Coefficient of the acceleration, of which the sign counts.
    """

    squares: float
    squares_without_inertia: float
    inertia: float

    @property
    def sign(self) -> int:
        """Sign of the inertia, 0 where the rows hardly show it."""
        least = THRESHOLDS.least_squares_without_inertia_over_with
        return int(np.sign(self.inertia)) if self.squares_without_inertia > least * self.squares else 0


def wrong_signs(runs: Sequence[Run]) -> dict[str, str]:
    """Find runs whose torque has the opposite sign of what the joint's runs together say.

    Parameters
    ----------
    runs
        Runs of the campaign; excluded, coupled and short ones, and those without motion or torque, are ignored.

    Returns
    -------
    dict
        A sentence by file.

    Notes
    -----
    A run is turned round where that takes at least half its squared torque from what the fit leaves, or nine tenths of
    what is left. In measured campaigns turning a right run adds 0.8 to 3 times its squared torque.
    """
    groups: dict[tuple[object, ...], list[Run]] = {}
    for run in runs:
        if run.use != "excluded" and len(run.free_joints) == 1 and _is_long(run) and np.ptp(run.y) and np.ptp(run.u):
            # Another posture has another inertia and gravity, even of the other sign.
            groups.setdefault((run.free_joints, tuple(run.posture)), []).append(run)
    found: dict[str, str] = {}
    for group in groups.values():
        found |= _wrong_of_group(group)
    return found


def share_left(runs: Sequence[Run]) -> float:
    """Return the share of the torque's energy that inertia, friction, gravity and a spring leave unexplained.

    Parameters
    ----------
    runs
        Runs of one joint at one posture, each long enough to be smoothed.

    Returns
    -------
    float
        Mean over the runs [1], by one least-squares fit of all of them.
    """
    return _fit([_rows(run) for run in runs], [1.0] * len(runs)).squares / len(runs)


def _is_long(run: Run) -> bool:
    return run.t.size >= THRESHOLDS.least_differences_of_noise


def _wrong_of_group(runs: Sequence[Run]) -> dict[str, str]:
    rows = [_rows(run) for run in runs]
    signs = [1.0] * len(runs)
    fit = _fit(rows, signs)
    while True:
        others = [[-s if k == turned else s for k, s in enumerate(signs)] for turned in range(len(runs))]
        fits = [_fit(rows, other) for other in others]
        best = min(range(len(runs)), key=lambda k: fits[k].squares)
        if not _is_better(fits[best], fit):
            break
        signs, fit = others[best], fits[best]
    right = fit.sign or (1 if sum(signs) >= 0 else -1)
    wrong = [run for run, sign in zip(runs, signs, strict=True) if sign != right]
    if len(wrong) == len(runs):
        return {run.file: ALL_RUNS for run in wrong}
    rest = [run.file for run in runs if run not in wrong]
    others_named = rest[0] if len(rest) == 1 else "the joint's other runs"
    sentence = (
        f"its torque fits those of {others_named} only with the opposite sign: is the torque's sign wrong? "
        "multiply it by -1 in this run's table, or exclude the run"
    )
    return {run.file: sentence for run in wrong}


def _is_better(turned: _Fit, fit: _Fit) -> bool:
    """Whether a fit with one run turned round is plainly better."""
    gain = fit.squares - turned.squares
    if gain >= THRESHOLDS.least_gain_of_turned_torque:
        return True
    # Few runs: a spring in place of a mass hides much of a wrong sign, but not all where the fit is good.
    return gain >= max(
        THRESHOLDS.least_gain_of_turned_torque_in_good_fit, THRESHOLDS.least_share_of_turned_torque * fit.squares
    )


def _rows(run: Run) -> _Rows:
    motion = smooth(run)
    n = motion.t.size
    columns = [motion.a, motion.v, np.sign(motion.v), np.ones(n), motion.q]
    if not run.prismatic[0]:
        columns += [np.cos(motion.q), np.sin(motion.q)]
    inside = slice(n // ENDS, n - n // ENDS)
    torque = motion.torque[inside]
    scale = float(np.linalg.norm(torque - torque.mean())) or 1.0
    return _Rows(W=np.column_stack(columns)[inside] / scale, torque=torque / scale)


def _fit(rows: Sequence[_Rows], signs: Sequence[float]) -> _Fit:
    W = np.concatenate([one.W for one in rows])
    torque = np.concatenate([sign * one.torque for one, sign in zip(rows, signs, strict=True)])
    # Columns of one length: what is cut off as dependent does not hang on units.
    W = W / np.maximum(np.linalg.norm(W, axis=0), np.finfo(float).tiny)
    solution = np.linalg.lstsq(W, torque, rcond=None)[0]
    without = np.linalg.lstsq(W[:, 1:], torque, rcond=None)[0]
    return _Fit(
        squares=float(np.sum((torque - W @ solution) ** 2)),
        squares_without_inertia=float(np.sum((torque - W[:, 1:] @ without) ** 2)),
        inertia=float(solution[0]),
    )
