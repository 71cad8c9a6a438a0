"""Collect all remarks on a campaign: `Campaign` in, `Remarks` per run out, each a sentence with its remedy.

Remarks are on likely slips and on circumstances that a fit has to respect; none refuses the campaign.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from haptid.measurement.format.drive_columns import COMMANDS
from haptid.measurement.remarks.between_runs import find_correlated_noise, find_misnamed, find_odd_sensors, twins
from haptid.measurement.remarks.limits import limits_of
from haptid.measurement.remarks.postures import find_lonely_postures, find_unfitted_postures
from haptid.measurement.remarks.saturation import find_saturation
from haptid.measurement.remarks.shared import tell_shared
from haptid.measurement.remarks.stated_controller import find_other_controllers, with_recorded_torques
from haptid.measurement.remarks.suspicions import GIVES_WORK, UNLIMITED, suspicions
from haptid.measurement.remarks.torque_scale import off_scale
from haptid.measurement.remarks.torque_sign import ALL_RUNS, tell_how_to_turn, wrong_signs
from haptid.measurement.signals.averaging import with_averaging
from haptid.measurement.signals.control_detection import position_control
from haptid.measurement.signals.gaps import find_gaps
from haptid.measurement.signals.noise import with_noise
from haptid.measurement.thresholds import THRESHOLDS
from haptid.measurement.values.campaign import Campaign
from haptid.measurement.values.run import Array, Run


@dataclass(frozen=True, slots=True, kw_only=True)
class Remarks:
    """Hold the remarks on one run.

    Parameters
    ----------
    run
        As it was read; with the recorded torque, where that of a stated controller takes its place in a fit.
    noise, resolution
        Stated, or estimated from the rows of this run [rad] ([m]), shape (n_joints,) each.
    by_joint
        Sentences for each free joint, in the order of ``run.free_joints``.
    doubts
        Those of them that speak of a slip; the others tell of circumstances that the commands deal with by themselves.
    """

    run: Run
    noise: Array
    resolution: Array
    by_joint: tuple[tuple[str, ...], ...]
    doubts: tuple[tuple[str, ...], ...]


def remarks_of(
    campaign: Campaign, *, closed: Collection[int] = (), report: Callable[[], object] = lambda: None
) -> tuple[Remarks, ...]:
    """Return the remarks on every run of a campaign.

    Parameters
    ----------
    campaign
        As it was read, with NaN where no noise is stated.
    closed
        Joints that a fit simulates through their stated controllers where they move alone.
    report
        Called without arguments after each run, for a progress bar.

    Returns
    -------
    tuple of Remarks
        In the order of the runs.

    Raises
    ------
    InputError
        Where the file of the device is at fault.
    """
    campaign = with_averaging(campaign)
    limits = limits_of(campaign)
    controllers = find_other_controllers(campaign)
    campaign = with_recorded_torques(campaign)
    unfitted, lonely = find_unfitted_postures(campaign.runs), find_lonely_postures(campaign.runs)
    between = (twins(campaign.runs), find_misnamed(campaign.runs), off_scale(campaign), unfitted, lonely)
    turned = wrong_signs(campaign.runs)
    fulls = [with_noise(run) for run in campaign.runs]
    estimates = [_with_estimates(run, full) for run, full in zip(campaign.runs, fulls, strict=True)]
    odd = find_odd_sensors(estimates)
    correlated = find_correlated_noise(fulls)
    made = []
    for run, full, estimated in zip(campaign.runs, fulls, estimates, strict=True):
        shared = [*_few_rows(run), *_lost_rows(run), *(table[run.file] for table in between if run.file in table)]
        sentences, doubts = [], []
        for column, joint in enumerate(run.free_joints):
            slips = suspicions(run, estimated, column, limits=limits.get(joint, UNLIMITED))
            if run.file in turned and GIVES_WORK not in slips:  # a run that tells it alone needs no other
                slips.append(turned[run.file])
            command = _column_of_command(run, column, campaign)
            slips = [
                f"{slip} {tell_how_to_turn(command)}" if slip in (ALL_RUNS, GIVES_WORK) else slip for slip in slips
            ]
            saturated = "" if joint in campaign.drives else find_saturation(run, column)  # a drive has its own limit
            slips += [saturated] if saturated else []
            by_joint = [
                table[run.file, joint] for table in (odd, correlated, controllers) if (run.file, joint) in table
            ]
            stated = campaign.parameter_overrides.get(joint, {})
            doubts.append((*_stillness(run, full, column, stated), *slips, *by_joint, *shared))
            is_closed = joint in closed and len(run.free_joints) == 1
            sentences.append((*_circumstances(run, column, is_closed=is_closed), *doubts[-1]))
        made.append(
            Remarks(
                run=run,
                noise=full.noise,
                resolution=full.resolution,
                by_joint=tuple(sentences),
                doubts=tuple(doubts),
            )
        )
        report()
    return tuple(made)


def _column_of_command(run: Run, column: int, campaign: Campaign) -> str:
    """Return the column of the campaign format that drives a joint of a run."""
    joint = run.free_joints[column]
    torque = f"force_{joint}_N" if run.prismatic[column] else f"torque_{joint}_Nm"
    drive = campaign.drives.get(joint)
    return torque if drive is None else COMMANDS.get(drive.kind, torque).format(joint=joint)


def _with_estimates(run: Run, full: Run) -> Run:
    """Return a run with noise and step estimated from its rows, also where they are stated."""
    if not np.isfinite([run.noise, run.resolution]).any():
        return full
    return with_noise(run.but(noise=np.full(run.noise.shape, np.nan), resolution=np.full(run.noise.shape, np.nan)))


def _stillness(run: Run, full: Run, column: int, stated: Mapping[str, Mapping[str, Any]]) -> list[str]:
    """Return whether the torque or the joint stands still; ``stated`` has what is stated of the joint's parameters."""
    found = []
    still = np.ptp(run.y[:, column]) < THRESHOLDS.least_travel_over_noise * float(full.sensor_std[column])
    if still or np.any(run.u[:, column]):
        if np.ptp(run.u[:, column]) == 0:
            found.append("the torque never changes: nothing excites the joint; was it recorded, in this column?")
    elif not any(entry.get("fixed") or "prior" in entry for id, entry in stated.items() if id != "Kp"):
        key = f"[joint.{run.free_joints[column]}.parameters]"
        found.append(
            "the torque is zero throughout: a free swing tells gravity, friction and damping over inertia, not their "
            f"scale; fix a known one, as {key} inertia = {{ fixed = 0.05 }}; or is the torque in another column?"
        )
    if still:
        least = f"{THRESHOLDS.least_travel_over_noise:.0f}"
        found.append(f"the joint hardly moves: its travel is below {least} times the sensor noise")
    return found


def _few_rows(run: Run) -> list[str]:
    """Return that a run is too short to show its noise, as after a slice too many."""
    least = THRESHOLDS.least_differences_of_noise
    if run.t.size >= least:
        return []
    return [f"only {run.t.size} rows, {run.t[-1]:.3g} s: fewer than {least} do not show the noise; is a part lost?"]


def _lost_rows(run: Run) -> list[str]:
    """Return where the recorder lost rows, which a fit simulates across all the same."""
    gaps = np.flatnonzero(find_gaps(run.t))
    if gaps.size == 0:
        return []
    intervals = run.t[gaps] - run.t[gaps - 1]
    longest = int(np.argmax(intervals))
    begin = run.t[gaps[longest] - 1] + run.start_time
    count = f"{gaps.size} gaps, the longest" if gaps.size > 1 else "a gap"
    return [
        f"{count} of {intervals[longest]:.3g} s after {begin:.4g} s: rows are missing, and no torque is known in "
        "between; make a run of each part, as haptid init does"
    ]


def _circumstances(run: Run, column: int, *, is_closed: bool) -> list[str]:
    """Return what any fit of one joint of a run has to know, and does.

    ``is_closed`` says whether the run is simulated through a stated controller, which lets nothing drift.
    """
    found = []
    noise, rounding = float(run.noise[column]), float(run.resolution[column]) / np.sqrt(12.0)
    if noise < rounding / THRESHOLDS.largest_stated_over_estimated_noise:
        found.append(
            f"the stated noise of {noise:.2g} is far below what the stated encoder step leaves, {rounding:.2g} "
            "(step/√12), which weighs the readings: is the step right?"
        )
    if run.averaged_rows > 1:
        found.append(f"positions are averages over {run.averaged_rows} rows: simulations are averaged alike")
    sign = position_control(run, column)
    if sign and not is_closed:
        found.append(f"{sign}: recorded under position control, an open-loop simulation from the torque would drift")
    # Where rows come at irregular times, a long interval is no lost row.
    if not find_gaps(run.t).any() and float(np.diff(run.t).max()) > 5 * float(np.median(np.diff(run.t))):
        row = int(np.argmax(np.diff(run.t)))
        found.append(f"a gap of {np.diff(run.t).max():.3g} s after {run.t[row] + run.start_time:.4g} s")
    if run.v is not None and abs(run.v[0, column]) > 0.1 * float(np.abs(run.v[:, column]).max()):
        found.append("it starts in motion: the initial velocity should be measured or fitted")
    return found


def remark_lines(remarks: Sequence[Remarks]) -> list[str]:
    """Return one line a doubt, ``a.csv, joint 0, 1: …``: joints and runs that share it stand together.

    Parameters
    ----------
    remarks
        Remarks on the runs, of which the doubts are written.

    Returns
    -------
    list of str
        In the order of the runs.
    """
    doubts = [
        (one.run.file, str(joint), sentence)
        for one in remarks
        for joint, sentences in zip(one.run.free_joints, one.doubts, strict=True)
        for sentence in sentences
    ]
    return tell_shared(doubts, every=len(remarks))
