"""``identification.json`` (schema identification/1): `Step` in, JSON data out; and an entry in, `Fit` out."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np

from haptid.identification.fit.stribeck_restraint import restrained_ids
from haptid.identification.fit.zeros_fit import encoder_zeros
from haptid.identification.links.consistency import Agreement
from haptid.identification.result.fit import Basin, Combination, Fit, Interval, RunScore
from haptid.identification.result.outcome import Outcome, tell_status
from haptid.identification.sequence.outcome_sentence import tell_outcome
from haptid.identification.sequence.step import Step
from haptid.identification.simulators.inverse_dynamics import torque_equations
from haptid.model.equations.equations import Equations
from haptid.model.equations.quantity import Quantity
from haptid.model.joint.encoder_zero import with_encoder_zeros, zero_states
from haptid.model.thresholds import THRESHOLDS as MODEL

SCHEMA = "identification/1"


def step_json(step: Step) -> dict[str, Any]:
    """Convert a fitted configuration to an entry of ``configurations``.

    Parameters
    ----------
    step
        Configuration with its fit.

    Returns
    -------
    dict
        JSON data; bounds and scores that are not finite are None.
    """
    fit = step.fit
    sigma = np.mean(np.concatenate([np.atleast_1d(s) for s in fit.sigma.values()]))
    unit, compared = "torque" if step.torque_scored else "position", step.compared
    return {
        "free_joints": list(step.configuration.free_joints),
        "locked_positions_rad": list(step.configuration.posture),
        "scored": unit,
        "residual": unit,
        "why": tell_why(fit, torque_scored=step.torque_scored),
        "floor": None if compared is None else compared.floor_json(),
        "baseline": None if step.baseline is None else step.baseline.as_json(),
        "friction": fit.equations.friction[0] if len(fit.equations.friction) == 1 else list(fit.equations.friction),
        "drive": None if fit.equations.drive is None else asdict(fit.equations.drive),
        "observer_gain_per_s": fit.observer_gain,
        "parameters": _parameters_json(fit),
        **_replaced_json(step),
        "runs": [_run_json(score, step) for score in fit.runs],
        "largest_torque_Nm": max((run.largest_torque for run in step.configuration.runs), default=0.0),
        "noise_rad": float(sigma),
        "cost": float(fit.cost),
        "outcome": fit.outcome.label,
        "outcome_sentence": tell_outcome(step),
        "starts": fit.starts,
        "simulations": fit.simulations,
        "wall_s": round(fit.wall_s, 3),
        "basins": _basins_json(fit),
        "combinations": [
            {"coefficients": dict(c.coefficients), "value": c.value, "std": c.std} for c in fit.combinations
        ],
        "agreement": [agreement_json(a) for a in step.agreements],
        "residual_correlation_rows": float(fit.correlation_time),
        "warnings": list(fit.warnings),
        "notes": list(fit.notes),
        "free": list(fit.free),
        "restrained": list(restrained_ids(fit.equations)),
        "covariance": fit.covariance.tolist(),
        "information": fit.information.tolist(),
        "encoder_zeros": _zeros_json(fit),
        "initial_states": {file: x.tolist() for file, x in fit.x0.items()},
        "sigma": {file: s.tolist() for file, s in fit.sigma.items()},
        **({} if fit.inner_step == MODEL.inner_step_s else {"inner_step_s": fit.inner_step}),
    }


def _parameters_json(fit: Fit) -> dict[str, dict[str, Any]]:
    return {
        q.id: parameter_json(q, v, s, fit.statuses[q.id], fit.outcome) | _profile_json(fit.profiles.get(q.id))
        for q, v, s in zip(fit.equations.parameters, fit.theta, fit.std, strict=True)
    }


def _basins_json(fit: Fit) -> list[dict[str, Any]]:
    ids = [q.id for q in fit.equations.parameters]
    return [
        {
            "rmse_over_noise": float(basin.over_noise),
            "starts": list(basin.starts),
            "simulations": basin.simulations,
            "parameters": dict(zip(ids, basin.theta.tolist(), strict=True)),
        }
        for basin in fit.basins
    ]


def _replaced_json(step: Step) -> dict[str, dict[str, float]]:
    """Keep the parameters of a fit that the plain model replaced: ``figures.model`` of the runs are that fit's."""
    if step.fit.outcome is not Outcome.PLAIN or step.compared is None:
        return {}
    model = step.compared.models["model"]
    own = dict(zip((q.id for q in model.simulator.equations.parameters), model.theta.tolist(), strict=True))
    # The models are compared on torques: what makes them, a drive with its controller, is known.
    return {"replaced": {**step.fit.values, **own}}


def _zeros_json(fit: Fit) -> dict[str, Any] | None:
    """Keep the reading at position 0 of every run and joint; None where readings are positions."""
    zeros = encoder_zeros(fit)
    if not zeros:
        return None
    spread = [fit.equations.states[k].start_std for k in zero_states(fit.equations)]
    return {"prior_std": spread, "runs": {file: zero.tolist() for file, zero in zeros.items()}}


def parameter_json(quantity: Quantity, value: float, std: float, status: str, outcome: Outcome) -> dict[str, Any]:
    """Convert an estimate to its entry of ``parameters``.

    Parameters
    ----------
    quantity
        Parameter with unit, description and range.
    value, std
        Estimate and its standard deviation, in the parameter's unit.
    status
        Status that the fit gives it.
    outcome
        How the fit ended.

    Returns
    -------
    dict
        JSON data; bounds that are not finite are None, and ``told_status`` is the word of `tell_status`.
    """
    return {
        "value": float(value),
        "std": float(std),
        "unit": quantity.unit,
        "status": status,
        "told_status": tell_status(status, outcome.label),
        "description": quantity.description,
        "lower": finite(quantity.lower),
        "upper": finite(quantity.upper),
    }


def _profile_json(interval: Interval | None) -> dict[str, list[float | None]]:
    return {} if interval is None else {"profile_95": [interval.lower, interval.upper]}


def tell_why(fit: Fit, *, torque_scored: bool) -> str:
    """Say in a sentence why this residual decides.

    Parameters
    ----------
    fit
        Fit of the configuration.
    torque_scored
        Whether the torque was fitted.

    Returns
    -------
    str
        Without a full stop.
    """
    why = _simulation_words(fit, torque_scored=torque_scored)
    if not zero_states(fit.equations):
        return why
    return f"{why}; the encoders' zeros differ from run to run, and are fitted with the initial states"


def _simulation_words(fit: Fit, *, torque_scored: bool) -> str:
    if torque_scored or fit.observer_gain:
        return fit.outcome.value
    drive = fit.equations.drive
    if drive is not None and drive.is_closed:
        return "the recorded reference drives a simulation through the stated controller, from the measured start"
    if drive is not None:
        return f"the recorded {drive.kind} drives a free simulation, whose position is compared with the measured one"
    return "the recorded torque drives a free simulation, whose position is compared with the measured one"


def _run_json(score: RunScore, step: Step) -> dict[str, Any]:
    result = {
        "file": score.file,
        "use": score.use,
        "rmse_rad": finite(score.rmse_rad),
        "rmse_over_noise": finite(score.over_noise),
        "nrmse": finite(score.nrmse),
        "rmse_per_joint": [finite(float(x)) for x in score.rmse],
        "initial_state": score.x0.tolist(),
        "rows": score.rows,
        "residual_correlation_rows": score.correlation_time,
        "rmse_over_noise_beyond_open": score.beyond_open,
        "figures": None if step.compared is None else step.compared.as_json(score.file, score.use),
    }
    if step.torque_scored:
        result |= {"scored": "torque", "rmse_Nm": result["rmse_rad"], "rmse_rad": None}
    return result


def finite(value: float) -> float | None:
    """Return a number as JSON can write it.

    Parameters
    ----------
    value
        Any number.

    Returns
    -------
    float or None
        None where the number is NaN or infinite.
    """
    return float(value) if math.isfinite(value) else None


def agreement_json(a: Agreement) -> dict[str, Any]:
    """Convert a comparison between tests to JSON data.

    Parameters
    ----------
    a
        Comparison; values of a single quantity are written where it has them.

    Returns
    -------
    dict
        JSON data; ``comparisons`` is the size of the family.
    """
    pairs = {"earlier": a.earlier, "later": a.later, "pooled": a.pooled}
    return {
        "name": a.name,
        "chi2": a.chi2,
        "dof": a.dof,
        "p": a.p,
        "comparisons": a.family,
        "contradicts": a.contradicts,
        **{k: {"value": v[0], "std": v[1]} for k, v in pairs.items() if v is not None},
    }


def fit_from_json(entry: Mapping[str, Any], equations: Equations) -> Fit:
    """Rebuild a fit from an entry of ``configurations``.

    Parameters
    ----------
    entry
        Entry as `step_json` wrote it.
    equations
        Equations of motion with the same parameters. Where the fit was one of the torque, or has encoder zeros, the
        equations of the fit are made from them.

    Returns
    -------
    Fit
        Its numbers are those of the fit that was written, bit for bit, and so are the ranges of its parameters;
        ``wall_s`` is rounded to milliseconds.

    Raises
    ------
    KeyError
        Where the entry lacks a key, a parameter of the equations, or has an unknown outcome.
    ValueError
        Where the torque was fitted, and the equations cannot be read from motion to torque.
    """
    by_id, zeros = entry["parameters"], entry.get("encoder_zeros")
    if entry["outcome"] == Outcome.TORQUE_SCORED.label:
        equations = torque_equations(equations)
    if zeros is not None:
        equations = with_encoder_zeros(equations, zeros["prior_std"])
    return Fit(
        equations=equations.with_parameters(_ranges(by_id, equations)),
        theta=np.array([by_id[q.id]["value"] for q in equations.parameters]),
        free=tuple(entry["free"]),
        covariance=np.array(entry["covariance"]),
        information=np.array(entry["information"]),
        cost=entry["cost"],
        outcome=Outcome[entry["outcome"].upper()],
        basins=tuple(
            Basin(
                over_noise=b["rmse_over_noise"],
                starts=tuple(b["starts"]),
                theta=np.array(list(b["parameters"].values())),
                simulations=b["simulations"],
            )
            for b in entry["basins"]
        ),
        starts=entry["starts"],
        x0={file: np.array(x) for file, x in entry["initial_states"].items()},
        sigma={file: np.array(s) for file, s in entry["sigma"].items()},
        correlation_time=entry["residual_correlation_rows"],
        simulations=entry["simulations"],
        wall_s=entry["wall_s"],
        statuses={id: one["status"] for id, one in by_id.items()},
        combinations=tuple(Combination(**c) for c in entry["combinations"]),
        warnings=tuple(entry["warnings"]),
        runs=tuple(_score_from(run) for run in entry["runs"]),
        notes=tuple(entry["notes"]),
        observer_gain=entry["observer_gain_per_s"],
        profiles={
            id: Interval(lower=one["profile_95"][0], upper=one["profile_95"][1])
            for id, one in by_id.items()
            if "profile_95" in one
        },
        inner_step=entry.get("inner_step_s", MODEL.inner_step_s),
    )


def _ranges(by_id: Mapping[str, Mapping[str, Any]], equations: Equations) -> dict[str, dict[str, object]]:
    """Return the ranges that the fit was made with: those that haptid chose may have been widened."""
    ranges: dict[str, dict[str, object]] = {}
    for quantity in equations.parameters:
        lower, upper = by_id[quantity.id].get("lower"), by_id[quantity.id].get("upper")
        made: dict[str, float] = {
            "lower": -math.inf if lower is None else float(lower),
            "upper": math.inf if upper is None else float(upper),
        }
        if made != {"lower": quantity.lower, "upper": quantity.upper}:
            initial = min(max(quantity.initial, made["lower"]), made["upper"])
            ranges[quantity.id] = {**made, "initial": initial}
    return ranges


def _score_from(run: Mapping[str, Any]) -> RunScore:
    def number(value: float | None) -> float:
        return math.nan if value is None else value

    return RunScore(
        file=run["file"],
        use=run["use"],
        rmse=np.array([number(x) for x in run["rmse_per_joint"]]),
        over_noise=number(run["rmse_over_noise"]),
        nrmse=number(run["nrmse"]),
        x0=np.array(run["initial_state"]),
        rows=run.get("rows", 0),  # files of November 2026 lack both
        correlation_time=run.get("residual_correlation_rows"),
        beyond_open=run.get("rmse_over_noise_beyond_open"),
    )
