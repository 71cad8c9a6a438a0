"""Write what was found on a torque: `TorqueFinding` in, content of ``discrepancy/joint<j>.json`` out."""

from __future__ import annotations

from typing import Any

from haptid.discrepancy.finding.torque_finding import TorqueFinding
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.discrepancy.torque.closed_loop import ClosedLoop
from haptid.discrepancy.torque.fit import TorqueFit
from haptid.discrepancy.torque_search.candidate import compare_candidates
from haptid.discrepancy.torque_search.search import TorqueSearch
from haptid.discrepancy.verdict.estimate import Estimate
from haptid.measurement.values.units import unit_for
from haptid.model.effects.effect import Effect, id_of


def torque_json(finding: TorqueFinding, *, measured: bool, seed: int) -> dict[str, Any]:
    """Return the content of ``discrepancy/joint<j>.json`` for a joint whose torque was scored.

    Parameters
    ----------
    finding
        Finding of one joint.
    measured
        Whether the runs were measured.
    seed
        Seed of the search.

    Returns
    -------
    dict
        Fields of INTERFACES; RMS are in N m, as the field ``scored`` says.
    """
    found, left = finding.search, finding.remaining
    return {
        "schema": "discrepancy/1",
        "joint": found.study.joint,
        "measured": measured,
        "seed": seed,
        "scored": "torque",
        "torque_delay_s": found.study.delay,
        "friction_by_run": None if found.study.friction_by_run is None else dict(found.study.friction_by_run.levels),
        "verdict": finding.verdict,
        "sentence": finding.sentence,
        "effects": [effect_json(finding, e) for e in found.final.effects],
        "alternatives": _alternatives_json(found),
        "next_experiment": None,
        "where": [r.as_json() for r in finding.regions],
        "gap": gaps_json(finding),
        "gap_unit": unit_for("N m", [found.study.prismatic]),
        "residual": "torque",
        "unnamed_shape": {
            "variable": "position_rad",
            "knots": left.position.tolist(),
            "torque_up_Nm": left.up.tolist(),
            "torque_down_Nm": left.down.tolist(),
            "std_Nm": left.std.tolist(),
        }
        if finding.verdict in ("unlisted", "partly_named")
        else None,
        "fmu": f"fmu/{finding.fmu.path.name}" if finding.fmu else None,
        "closed_loop": None
        if finding.nominal_loop is None or finding.final_loop is None
        else {"before": finding.nominal_loop.as_json(), "after": finding.final_loop.as_json()},
        "nominal": final_values(found, finding.nominal_loop, found.base),
        "refit": final_values(found, finding.final_loop),
        "soundness": None if finding.soundness is None else finding.soundness.as_json(),
        "rounds": len(found.steps),
        "refitted": sum(len(step.candidates) for step in found.steps),
        "simulations": found.simulations,
        "wall_s": finding.wall_s,
    }


def gaps_json(finding: TorqueFinding) -> dict[str, Any]:
    """Return RMS torques before and after, with what does not repeat and what the best table leaves [N m].

    Parameters
    ----------
    finding
        Finding of one joint.

    Returns
    -------
    dict
        Field ``gap``: RMS by group of runs.
    """
    gaps: dict[str, Any] = {"sealed": None}
    for name, gap in finding.gaps.items():
        gaps[name] = {
            "before": gap.before,
            "after": gap.after,
            "noise": gap.noise,
            "closed": gap.closed,
            "floor": finding.floor,
            "black_box": finding.black_box if name == "validate" else None,
        }
    return gaps


def _alternatives_json(found: TorqueSearch) -> list[dict[str, Any]]:
    """Return the rivals; where the runs tell all names apart, the next best candidates of the rounds."""
    if found.rivals:
        over = [(rival, compare_candidates(rival.key, found.base, rival.model)) for rival in found.rivals]
        return [
            {"ids": [e.id for e in rival.model.effects], "evidence": gain.evidence, "bic": gain.bic}
            for rival, gain in over
        ]
    others = [c for step in found.steps for c in step.candidates if c is not step.taken]
    listed = others[: THRESHOLDS.verdict.most_alternatives_listed]
    return [{"ids": [id_of(c.key)], "evidence": c.evidence, "bic": c.bic} for c in listed]


def effect_json(finding: TorqueFinding, effect: Effect) -> dict[str, Any]:
    """Return what is told of an effect of the final model.

    Parameters
    ----------
    finding
        Finding of one joint.
    effect
        Effect of its final model.

    Returns
    -------
    dict
        An element of ``effects``.
    """
    final = finding.search.final
    std = final.std
    evidence = next(s.taken.evidence for s in finding.search.steps if s.taken is not None and s.taken.key == effect.key)
    return {
        "id": effect.id,
        "variant": effect.variant or None,
        "parameters": {
            x.id: Estimate.of_parameter(x, final.values[x.id], std[x.id]).as_json()
            for x in effect.parameters
            if not x.fixed
        },
        "evidence": evidence,
        "stability": finding.stability.get(effect.key),
        "certain": effect.key not in finding.doubted,
    }


def final_values(found: TorqueSearch, loop: ClosedLoop | None, model: TorqueFit | None = None) -> dict[str, float]:
    """Return the parameters of a model, with those of the drive: refitted where there is a controller.

    Parameters
    ----------
    found
        Result of the search.
    loop
        The model, refitted through the recorded controller; None without one.
    model
        The model; the final one where None.

    Returns
    -------
    dict
        Values by id, in SI units.
    """
    if loop is not None:
        return dict(loop.values)
    drive, values = found.study.drive, (found.final if model is None else model).values
    return values if drive is None else {**values, **drive.values}
