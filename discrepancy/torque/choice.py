"""Choose the residual in which a joint is searched: `Campaign` in, position or torque out; and fits carried on.

1. A position at the noise is the stricter test: then the position is searched.
2. Under position control the controller hides in the position what is missing in the torque: the torque is searched.
3. Where an identification found that the plain model predicts unseen runs better than a fit of the position does, a
   simulation from the recorded torque drifts, or the missing effect is what kept the fit from the motion. The position
   is searched first, which tells the two apart: an effect that closes most of the gap in unseen runs is the reason.
   Where none does, the torque is searched.

What an identification below the folder of results found of the same data is not fitted again.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Literal

from haptid.identification.fit.multistart import fit
from haptid.identification.fit.strategy import choose_for, fit_simulated, quiet
from haptid.identification.problem.options import FitOptions
from haptid.identification.result.fit import Fit
from haptid.identification.sequence.carried_fit import (
    carried_fit,
    earlier_free_rms,
    earlier_residual,
    earlier_zeros,
)
from haptid.identification.sequence.configurations import Configuration, configurations_of
from haptid.identification.sequence.equations_for import equations_for
from haptid.identification.simulators.kernel import KernelSimulator
from haptid.identification.thresholds import THRESHOLDS
from haptid.identification.workers.workers import Here
from haptid.measurement.format.devices import device_of
from haptid.measurement.values.campaign import Campaign
from haptid.measurement.values.run import Array
from haptid.model.equations.equations import Equations

Residual = Literal["position", "torque", "position_then_torque"]
"""In what a joint is searched; the last one where the torque is searched if the position tells no effect."""


def residual_of(campaign: Campaign, joint: int, out: Path) -> Residual:
    """Choose whether the position of a joint is searched, or its torque.

    Parameters
    ----------
    campaign
        Campaign with the runs of the joint.
    joint
        Number of the joint.
    out
        Folder of the results, perhaps with those of an identification.

    Returns
    -------
    str
        ``torque`` where the joint is controlled and its simulated position stays above the noise. Under a free torque
        ``position_then_torque`` where the identification's result is the plain model. Else, and without runs to fit,
        ``position``.

    Raises
    ------
    InputError
        Where the file of the device is at fault, or as `equations_for`.
    NumericalError
        Where the compiler is missing or fails.
    """
    runs = campaign.runs_of((joint,))
    if not campaign.runs_of((joint,), "fit"):
        return "position"
    drive = campaign.drives.get(joint)
    closed = drive is not None and drive.is_closed
    free = not closed and choose_for(runs).kind == "open_loop"
    if free and drive is not None:
        return "position"
    device = device_of(campaign)
    tested = only_configuration(campaign, (joint,))
    earlier = None if tested is None else earlier_residual(campaign, device, tested, out)
    if free:
        return "position_then_torque" if earlier is not None and earlier.plain else "position"
    if earlier is not None:
        return "position" if earlier.at_noise else "torque"
    equations = equations_for(campaign, device, (joint,))
    options = FitOptions(starts=THRESHOLDS.most_starts_of_trial, method="gauss_newton")
    simulator = KernelSimulator.of(equations)
    # The recorded controller holds the simulation near the motion as an observer would.
    seen = (
        fit(simulator, runs, options=options.but(gains=(0.0,)), workers=Here())
        if closed
        else fit_simulated(simulator, runs, options=options, workers=Here())
    )
    return "position" if quiet(seen, options) else "torque"


def read_carried_fit(
    campaign: Campaign, free: Sequence[int], base: Equations, out: Path, *, springless: bool = False
) -> Fit | None:
    """Return the fit that an identification wrote below ``out`` from the same runs.

    Parameters
    ----------
    campaign
        Campaign with the runs.
    free
        Numbers of the free joints.
    base
        Equations of the nominal model.
    out
        Folder of the results.
    springless
        Whether the fit may have left out the spring of the nominal model.

    Returns
    -------
    Fit or None
        None where there is none.

    Raises
    ------
    InputError
        Where the file of the device is at fault.
    """
    tested = only_configuration(campaign, free)
    return (
        None if tested is None else carried_fit(campaign, device_of(campaign), tested, base, out, springless=springless)
    )


def read_zeros(campaign: Campaign, free: Sequence[int], out: Path) -> dict[str, Array]:
    """Return the encoder zeros that an identification found below ``out`` in the same runs.

    Parameters
    ----------
    campaign
        Campaign with the runs.
    free
        Numbers of the free joints.
    out
        Folder of the results.

    Returns
    -------
    dict
        Reading at position 0 of every joint, shape (n_joints,), [rad] or [m], by the file of the run; empty where there
        is none.
    """
    tested = only_configuration(campaign, free)
    return {} if tested is None else earlier_zeros(campaign, device_of(campaign), tested, out)


def read_free_rms(campaign: Campaign, free: Sequence[int], out: Path) -> float | None:
    """Return how far the models of an identification below ``out`` stray from the position of unseen runs.

    Parameters
    ----------
    campaign
        Campaign with the runs.
    free
        Numbers of the free joints.
    out
        Folder of the results.

    Returns
    -------
    float or None
        As `earlier_free_rms`; None where there is no identification of the same runs.
    """
    tested = only_configuration(campaign, free)
    return None if tested is None else earlier_free_rms(campaign, device_of(campaign), tested, out)


def only_configuration(campaign: Campaign, free: Sequence[int]) -> Configuration | None:
    """Return the configuration of free joints that were tested in one posture.

    Parameters
    ----------
    campaign
        Campaign with the runs.
    free
        Numbers of the free joints.

    Returns
    -------
    Configuration or None
        None for several postures: a study then has all runs of the joints, and each fit those of one posture.
    """
    tested = [one for one in configurations_of(campaign, device_of(campaign)) if one.free_joints == tuple(free)]
    return tested[0] if len(tested) == 1 else None
