"""The fit of a configuration that an earlier command made: results folder and configuration in, `Fit` out.

`earlier_residual` gives what that command found of the residual alone.

Posterior and search for missing effects go on from the fit of ``python -m identification.run`` where its results lie in
the same folder and come from the same data, the same parameter entries and the same code. Then they fit nothing again.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from haptid.fmu_build.exchange.identification_json import read_identification
from haptid.identification.fit.stribeck_restraint import release_stribeck, restrain_stribeck
from haptid.identification.problem.options import FitOptions
from haptid.identification.result.fit import Fit
from haptid.identification.result.outcome import Outcome
from haptid.identification.sequence.configurations import Configuration
from haptid.identification.sequence.equations_for import stated_parameters
from haptid.identification.sequence.result_json import fit_from_json
from haptid.identification.sequence.resume import data_digest
from haptid.identification.statistics.absent import SPRING
from haptid.measurement.values.campaign import Campaign
from haptid.measurement.values.run import Array
from haptid.model.device.device import Device
from haptid.model.equations.equations import Equations
from haptid.support.errors import InputError
from haptid.support.linear_algebra import rms

FILE = "identification.json"
"""Name of the results in the output folder."""


@dataclass(frozen=True, slots=True, kw_only=True)
class EarlierResidual:
    """What an identification found of a residual.

    Parameters
    ----------
    at_noise
        Whether the position is at the noise; False where the torque was fitted, since it is fitted only otherwise.
    plain
        Whether the plain model is the result, which predicts the torque better than the fit predicts the motion.
    """

    at_noise: bool
    plain: bool


def carried_fit(
    campaign: Campaign,
    device: Device | None,
    configuration: Configuration,
    equations: Equations,
    out: Path,
    *,
    springless: bool = False,
) -> Fit | None:
    """Read the fit of a configuration from the results of an earlier identification.

    Parameters
    ----------
    campaign
        Campaign with parameter entries and friction laws.
    device
        Device of the campaign; None for a single joint.
    configuration
        Free joints, posture and runs.
    equations
        Equations of the configuration without the priors that the sequence of fits carries over.
    out
        Folder of the results.
    springless
        Whether the fit may have left out the spring of the equations (`statistics.absent.without_absent_spring`).

    Returns
    -------
    Fit or None
        None where the folder has no results, where they belong to other data, entries or code, and where the fit was
        not by free simulation: through an observer or in torque the optimum is another one.
    """
    entry = _entry_of(campaign, device, configuration, out)
    if entry is None or entry.get("outcome") == Outcome.TORQUE_SCORED.label or entry.get("observer_gain_per_s") != 0:
        return None
    fit = _read_fit(entry, equations)
    if fit is None:
        return None
    missing = {q.id for q in equations.parameters if not q.fixed} ^ set(fit.free)
    same = not missing or (springless and missing == set(SPRING) and not any(fit.values[id] for id in SPRING))
    return fit if same else None


def carried_torque_fit(
    campaign: Campaign, device: Device | None, configuration: Configuration, equations: Equations, out: Path
) -> Fit | None:
    """Read the fit of a joint's torque from the results of an earlier identification.

    Parameters
    ----------
    campaign
        Campaign with parameter entries and friction laws.
    device
        Device of the campaign; None for a single joint.
    configuration
        Free joint, posture and runs.
    equations
        Equations of motion of the joint.
    out
        Folder of the results.

    Returns
    -------
    Fit or None
        Fit of the torque equation, with the priors of its Stribeck curve unless it was released. None where the folder
        has no results of the same data, entries and code, and where the residual was a position.
    """
    entry = _entry_of(campaign, device, configuration, out)
    if entry is None or entry.get("outcome") != Outcome.TORQUE_SCORED.label:
        return None
    stated = stated_parameters(campaign, configuration.free_joints)
    restrained = restrain_stribeck(equations, configuration.runs, stated)
    return _read_fit(entry, restrained if entry.get("restrained", True) else release_stribeck(restrained))


def earlier_residual(
    campaign: Campaign, device: Device | None, configuration: Configuration, out: Path
) -> EarlierResidual | None:
    """Return what an earlier identification found of the residual of a configuration.

    Parameters
    ----------
    campaign
        Campaign with parameter entries and friction laws.
    device
        Device of the campaign; None for a single joint.
    configuration
        Free joints, posture and runs.
    out
        Folder of the results.

    Returns
    -------
    EarlierResidual or None
        None where the folder has no results of the same data, entries and code.
    """
    entry = _entry_of(campaign, device, configuration, out)
    if entry is None:
        return None
    try:
        at_noise = entry["basins"][0]["rmse_over_noise"] <= FitOptions().tolerance
        position, plain = entry["residual"] == "position", entry["outcome"] == Outcome.PLAIN.label
        return EarlierResidual(at_noise=bool(at_noise) and position, plain=plain)
    except (KeyError, TypeError, IndexError):  # changed by hand
        return None


def earlier_free_rms(
    campaign: Campaign, device: Device | None, configuration: Configuration, out: Path
) -> float | None:
    """Return how far an earlier identification's models stray from the position of the runs that no fit saw.

    Parameters
    ----------
    campaign
        Campaign with parameter entries and friction laws.
    device
        Device of the campaign; None for a single joint.
    configuration
        Free joints, posture and runs.
    out
        Folder of the results.

    Returns
    -------
    float or None
        RMS error of the position in free simulation [rad], or [m]: the lesser one of the fit and of the plain model,
        over all these runs. None where the folder has no results of the same data, entries and code, and where neither
        model was simulated.
    """
    entry = _entry_of(campaign, device, configuration, out)
    runs = [] if entry is None else entry.get("runs", [])
    unseen = [run["figures"] for run in runs if run.get("use") != "fit" and run.get("figures")]
    models = set(unseen[0]).intersection(*unseen) if unseen else set()
    errors = [[one[name].get("free_rmse") for one in unseen] for name in models]
    return min((rms(each) for each in errors if None not in each), default=None)


def earlier_zeros(
    campaign: Campaign, device: Device | None, configuration: Configuration, out: Path
) -> dict[str, Array]:
    """Return the encoder zeros that an earlier identification found in the runs of a configuration.

    Parameters
    ----------
    campaign
        Campaign with parameter entries and friction laws.
    device
        Device of the campaign; None for a single joint.
    configuration
        Free joints, posture and runs.
    out
        Folder of the results.

    Returns
    -------
    dict
        Reading at position 0 of every joint, shape (n_joints,), [rad] or [m], by the file of the run. Empty where it
        found none, and where the folder has no results of the same data, entries and code.
    """
    entry = _entry_of(campaign, device, configuration, out)
    zeros = None if entry is None else entry.get("encoder_zeros")
    return {} if zeros is None else {file: np.array(zero) for file, zero in zeros["runs"].items()}


def _read_fit(entry: Mapping[str, Any], equations: Equations) -> Fit | None:
    """Rebuild the fit of an entry; None where the entry was written by another version, or changed by hand."""
    try:
        fit = fit_from_json(entry, equations)
    except (KeyError, TypeError, ValueError, IndexError):
        return None
    return fit if np.isfinite(fit.theta).all() else None


def _entry_of(
    campaign: Campaign, device: Device | None, configuration: Configuration, out: Path
) -> Mapping[str, Any] | None:
    """Return the entry of a configuration; None where there are no results of the same data, entries and code."""
    try:
        entries = read_identification(out / FILE)["configurations"]
    except InputError:  # no results, or results that cannot be read: the caller fits
        return None
    digest = data_digest(campaign, device, configuration)
    return next((entry for entry in entries if entry.get("data") == digest), None)
