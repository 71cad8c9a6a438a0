"""What verifies the model of each joint: configurations and runs of ``identification.json`` in, one entry a joint out.

Numbers are those of identification.json. A run is told as fitted, with the start and the feedback of the fit
(``as_fitted``); as a free simulation from the measured start (``open_loop``); through the recorded controller
(``closed_loop``); and by the torque that the measured motion needs (``torque``).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

MODES = (("open_loop", "free_rmse"), ("closed_loop", "closed_rmse"))
"""Figures of a run in position, by the mode that they are told as."""


def joint_in_tests(tests: Sequence[Mapping[str, Any]], joint: int) -> dict[str, Any]:
    """Return the verification of one joint by the tests in which it was free.

    Parameters
    ----------
    tests
        Entries of ``configurations``.
    joint
        Number of the joint.

    Returns
    -------
    dict
        ``joint``, ``unit`` (rad or m), ``verdict`` in words, and ``runs``; each run has ``file``, ``use``,
        ``free_joints``, ``mode``, ``rmse`` in ``unit`` and ``over_noise`` [1]; for the mode ``torque``, ``rmse`` is in
        N m (N), with ``relative`` [1] beside it.
    """
    own = [test for test in tests if joint in test["free_joints"]]
    rows: list[dict[str, Any]] = []
    for test in own:
        for run in test.get("runs", []):
            rows += _rows(test, run, joint)
    unit = "m" if _is_prismatic(own, joint) else "rad"
    return {"joint": joint, "unit": unit, "verdict": tell_verdict(rows, unit), "runs": rows}


def joint_in_whole(
    told: Mapping[str, Any], runs: Sequence[Mapping[str, Any]], joint: int, *, after: bool
) -> dict[str, Any]:
    """Add the runs in which all joints of the device were free.

    Parameters
    ----------
    told
        Verification by the joint's own tests (`joint_in_tests`).
    runs
        Runs of the table ``verification``.
    joint
        Number of the joint.
    after
        Whether effects were added to the model since: the figures are then those of the model without them.

    Returns
    -------
    dict
        As ``told``; the verdict is by runs of the whole device where there are any.
    """
    rows = [
        {
            "file": run["file"],
            "use": run.get("use", "validate"),
            "free_joints": "all",
            "mode": run["mode"],
            "rmse": one.get("rmse_rad"),
            "over_noise": one.get("rmse_over_noise"),
            "spread_of_draws": one.get("spread_rad"),
        }
        for run in runs
        for one in run["joints"]
        if one["joint"] == joint
    ]
    verdict = tell_verdict(rows or told["runs"], told["unit"])
    note = " These figures are of the model without the effects that were added." if after else ""
    return {**told, "verdict": verdict + note, "runs": [*told["runs"], *rows]}


def _rows(test: Mapping[str, Any], run: Mapping[str, Any], joint: int) -> Iterator[dict[str, Any]]:
    """Yield the figures of one run for one joint, as far as the results hold them."""
    place = list(test["free_joints"]).index(joint)
    about = {"file": run.get("file"), "use": run.get("use"), "free_joints": list(test["free_joints"])}
    model = (run.get("figures") or {}).get("model") or {}
    stated = _of_joint(test.get("sigma", {}).get(run.get("file"), test.get("noise_rad")), place)
    # Where the torque was fitted, the noise of a run is that of its torque.
    by_torque = test.get("residual") == "torque"
    noise, of_torque = (None, stated) if by_torque else (stated, None)
    alone = len(test["free_joints"]) == 1
    if run.get("rmse_rad") is not None:
        rmse = run["rmse_rad"] if alone else _of_joint(run.get("rmse_per_joint"), place)
        over = run.get("rmse_over_noise") if alone else _over(rmse, noise)
        yield {**about, "mode": "as_fitted", "rmse": rmse, "over_noise": over}
    for mode, key in MODES:
        rmse = _of_joint(model.get(key), place)
        if rmse is not None:
            yield {**about, "mode": mode, "rmse": rmse, "over_noise": _over(rmse, noise)}
    torque = _of_joint(model.get("torque_rmse"), place)
    if torque is not None:
        relative = _of_joint(model.get("torque_error"), place)
        yield {**about, "mode": "torque", "rmse": torque, "relative": relative, "over_noise": _over(torque, of_torque)}


def _of_joint(value: Any, place: int) -> float | None:
    """Return the number of one joint: results hold a list where several joints are free, a number where one is."""
    if isinstance(value, list):
        value = value[place] if place < len(value) else None
    return None if value is None else float(value)


def _over(rmse: float | None, noise: float | None) -> float | None:
    return rmse / noise if rmse is not None and noise else None


def _is_prismatic(tests: Sequence[Mapping[str, Any]], joint: int) -> bool:
    """Whether the unit of the joint's spring stiffness or inertia is that of a prismatic joint."""
    for test in tests:
        for id, unit in (("inertia", "kg"), ("Ks", "N/m"), (f"Ks_{joint}", "N/m")):
            if test["parameters"].get(id, {}).get("unit") == unit:
                return True
    return False


def tell_verdict(rows: Sequence[Mapping[str, Any]], unit: str) -> str:
    """Say in words how far the model misses.

    Parameters
    ----------
    rows
        Figures of the runs.
    unit
        Unit of the position.

    Returns
    -------
    str
        For each mode the worst run that no fit saw, or that was fitted where there is no other.
    """
    unseen = [row for row in rows if row["use"] == "validate"]
    told: list[str] = []
    words = {"closed_loop": "in closed loop", "open_loop": "simulated freely", "as_fitted": "as fitted"}
    for mode, how in words.items():
        chosen = [row for row in unseen or rows if row["mode"] == mode and row["rmse"] is not None]
        if chosen and not (told and mode == "as_fitted"):
            worst = max(chosen, key=lambda row: row["rmse"])
            over = worst["over_noise"]
            noise = "" if over is None else f", {over:.3g} times the sensor's noise"
            told.append(f"{how} it misses {worst['file']} by {worst['rmse']:.3g} {unit}{noise}")
    torque = [row for row in unseen or rows if row["mode"] == "torque" and row["relative"] is not None]
    if torque:
        worst = max(torque, key=lambda row: row["relative"])
        told.append(f"it misses the torque of {worst['file']} by {100 * worst['relative']:.2g} %")
    if not told:
        return "Nothing was verified."
    which = "Of the runs that no fit saw" if unseen else "No run was held out; of the fitted runs"
    return f"{which}, the worst: {'; '.join(told)}."
