"""How good an FMU with named effects is: its refit and what the search found in, `Accuracy` out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from haptid.discrepancy.torque.choice import only_configuration
from haptid.discrepancy.torque.closed_loop import ClosedLoop
from haptid.discrepancy.torque.fit import TorqueFit
from haptid.fmu_build.accuracy.accuracy import Accuracy
from haptid.fmu_build.accuracy.draws import COUNT, Draws
from haptid.fmu_build.accuracy.stored_draws import Known
from haptid.fmu_build.accuracy.verification import joint_in_tests, tell_verdict
from haptid.identification.result.fit import Fit
from haptid.identification.sequence.resume import code_digest, data_digest
from haptid.identification.statistics.parameter_draws import draw_free
from haptid.measurement.format.devices import device_of
from haptid.measurement.values.campaign import Campaign
from haptid.measurement.values.run import Array
from haptid.model.equations.equations import Equations
from haptid.support.linear_algebra import correlation_of

OF_REFIT = "covariance of the refit with the named effects, in the coordinates in which it moved"
Entries = Sequence[Mapping[str, Any]]
"""Entries ``effects`` of the JSON."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Origin:
    """Name what a search was run on.

    Parameters
    ----------
    words
        Title of the campaign, and whether its data were measured or are synthetic.
    synthetic
        Whether a virtual device made the data; None where unknown.
    digests
        Campaign, data and code.
    """

    words: str = "runs of no named campaign"
    synthetic: bool | None = None
    digests: Mapping[str, Any] = field(default_factory=dict)


def origin_of(campaign: Campaign, joints: Sequence[int]) -> Origin:
    """Return the origin of a search in a campaign for the effects of some free joints.

    Parameters
    ----------
    campaign
        Campaign with the runs.
    joints
        Numbers of the free joints.

    Returns
    -------
    Origin
        Title of the campaign, and digests of device, code and data; that of the data is None where the joints were
        tested in several postures.

    Raises
    ------
    InputError
        Where the file of the device is at fault.
    """
    tested = only_configuration(campaign, joints)
    kind = "measured" if campaign.measured else "SYNTHETIC"
    digests = {
        "device": campaign.device,
        "campaign": campaign.title,
        "code": code_digest().hex()[:16],
        "data": None if tested is None else data_digest(campaign, device_of(campaign), tested),
    }
    return Origin(words=f"{campaign.title} ({kind} data)", synthetic=not campaign.measured, digests=digests)


def of_refit(fit: Fit, effects: Entries, gaps: Mapping[str, Any], origin: Origin, seed: int) -> Accuracy:
    """Return the accuracy of a model whose position was refitted with named effects.

    Parameters
    ----------
    fit
        Refit of all parameters, with the scores of the runs.
    effects
        Named effects, as the JSON has them.
    gaps
        Gap before and after by use of the runs, as the JSON has it.
    origin
        What the search was run on.
    seed
        Seed of the draws.

    Returns
    -------
    Accuracy
    """
    joints = fit.equations.joints
    test = {
        "free_joints": list(joints),
        "parameters": {q.id: {"unit": q.unit} for q in fit.equations.parameters},
        "sigma": {file: sigma.tolist() for file, sigma in fit.sigma.items()},
        "runs": [
            {
                "file": score.file,
                "use": score.use,
                "rmse_rad": score.rmse_rad if np.isfinite(score.rmse).all() else None,
                "rmse_over_noise": score.over_noise,
                "rmse_per_joint": score.rmse.tolist(),
            }
            for score in fit.runs
        ],
    }
    draws = _draw(fit.equations, fit.theta, fit.free, fit.covariance, seed)
    return _accuracy(
        Known(draws=draws, correlation=(fit.free, correlation_of(fit.covariance)[0])),
        [joint_in_tests([test], joint) for joint in joints],
        [{"joint": list(joints) if len(joints) > 1 else joints[0], **entry, "gap": gaps} for entry in effects],
        origin,
    )


def of_torque_fit(
    fit: TorqueFit,
    loop: ClosedLoop | None,
    effects: Entries,
    gaps: Mapping[str, Any],
    origin: Origin,
    seed: int,
) -> Accuracy:
    """Return the accuracy of a model whose torque was fitted with named effects.

    Parameters
    ----------
    fit
        Fit to the torque of measured motion.
    loop
        Refit through the recorded controller, whose values the FMU has; None where it has those of ``fit``.
    effects, gaps, origin, seed
        As `of_refit`.

    Returns
    -------
    Accuracy
        Without draws beside a refit through the controller, whose covariance is not known.
    """
    joint, unit = fit.study.joint, "m" if fit.study.prismatic else "rad"
    about = {"free_joints": [joint], "relative": None}
    rows: list[dict[str, Any]] = [
        {"file": f"all runs: {use}", "use": use, **about, "mode": "torque", "rmse": gap["after"]}
        for use, gap in gaps.items()
        if gap is not None
    ]
    if loop is not None:
        rows += [
            {"file": f"all runs: {use}", "use": use, **about, "mode": "closed_loop", "rmse": rms, "over_noise": None}
            for use, rms in loop.rms.items()
        ]
    told = [{"joint": joint, "unit": unit, "verdict": tell_verdict(rows, unit), "runs": rows}]
    named = [{"joint": joint, **entry, "gap": gaps} for entry in effects]
    if loop is not None:
        why = "the values were refitted through the recorded controller, which gives no covariance"
        return _accuracy(Known(draws=None, why=why), told, named, origin)
    ids, equations = fit.problem.parametrisation.ids, fit.problem.simulator.equations
    draws = _draw(equations, fit.theta, ids, fit.covariance, seed)
    return _accuracy(Known(draws=draws), told, named, origin)


def _draw(equations: Equations, theta: Array, free: tuple[str, ...], covariance: Array, seed: int) -> Draws:
    rng = np.random.default_rng([seed, 31])
    values = draw_free(equations, theta, free, covariance, count=COUNT, rng=rng)
    return Draws(columns=free, values=values, source=OF_REFIT, seed=seed)


def _accuracy(
    known: Known, joints: Sequence[Mapping[str, Any]], effects: Sequence[Mapping[str, Any]], origin: Origin
) -> Accuracy:
    return Accuracy(
        origin=f"identified with the named effects from {origin.words}",
        synthetic=origin.synthetic,
        known=known,
        joints=tuple(joints),
        effects=tuple(effects),
        searched="searched; those named are in the model" if effects else "searched; none was named",
        digests=origin.digests,
    )
