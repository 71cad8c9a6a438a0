"""Figures of each set of real measurements: results of the two commands in, `Figure`s out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.machines.commands import Call
from benchmarks.machines.figure import Figure
from benchmarks.machines.filtered_away import filtered_away
from benchmarks.machines.published import published_scores

EMPS_PUBLISHED = {"inertia": 95.1089, "Fv": 203.5034, "Fc": 20.3935}
"""Mass [kg], viscous [N s/m] and Coulomb [N] friction by inverse dynamics (Janot, Gautier, Brunot 2019)."""
EMPS_LARGEST_DEVIATION = {"inertia": 1.0, "Fv": 3.0, "Fc": 3.0}
"""Deviation of the plain model from them that reaches the aim [%]."""
PENDULUM_WEIGHT_NM = 0.6755 * 9.81 * 0.5
"""Torque of the mass of 0.6755 kg at 0.5 m [N m]."""
PENDULUM_INERTIA_OVER_WEIGHT_S2 = 0.5 / 9.81
"""m·l²/(m·g·l) of a point mass at 0.5 m [s²]: no error of the drive's torque constant changes it."""
ASYMMETRIC = ("asymmetric_viscous", "asymmetric_coulomb")
"""Effects of friction that differ between directions."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Results:
    """Results of both commands on a set.

    Parameters
    ----------
    identified, missing
        Calls of ``identification.run`` and ``discrepancy.run``.
    campaign
        Folder of the campaign.
    """

    identified: Call
    missing: Call
    campaign: Path

    @property
    def configuration(self) -> Mapping[str, Any] | None:
        """Entry of the last configuration in identification.json; None without a result."""
        result = self.identified.result
        return None if result is None else dict(result["configurations"][-1])

    def runs(self, use: str) -> list[Mapping[str, Any]]:
        """Return the runs of one use."""
        entry = self.configuration
        return [] if entry is None else [run for run in entry["runs"] if run["use"] == use]

    @property
    def result(self) -> str:
        """Which of the two models is the result: where the plain one replaced the fit, the fit's figures are not it."""
        entry = self.configuration
        return "baseline" if entry is not None and entry["outcome"] == "plain" else "model"

    def mean(self, use: str, key: str) -> float | None:
        """Return the root mean square over the runs of one use of a figure of the result; None where a run lacks it."""
        values = [(run["figures"] or {}).get(self.result, {}).get(key) for run in self.runs(use)]
        if not values or any(value is None for value in values):
            return None
        return float(np.sqrt(np.mean(np.square(values))))

    @property
    def names(self) -> list[str] | None:
        """Ids of the named effects; None without a result. What only stands in for an unlisted effect is no name.

        Where the runs cannot tell some effects apart, those that stand in every alternative are named.
        """
        result = self.missing.result
        if result is None:
            return None
        ids = [e["id"] for e in result["effects"]]
        if result["verdict"] == "ambiguous":
            return [id for id in ids if all(id in other["ids"] for other in result["alternatives"])]
        return ids if result["verdict"] in ("named", "partly_named") else []

    def torque_left(self, use: str) -> float | None:
        """Return the RMS torque that the model with the named effects leaves [N m]; None where position was scored."""
        result = self.missing.result
        if result is None or result.get("scored") != "torque":
            return None
        return float(result["gap"][use]["after"])

    def torque_error_with_names(self, use: str) -> float | None:
        """Return the relative torque error of the model with the named effects; None where position was scored."""
        left, rmse, error = self.torque_left(use), self.mean(use, "torque_rmse"), self.mean(use, "torque_error")
        if left is None or rmse is None or not error or self.missing.result is None:
            return None
        before = float(self.missing.result["gap"][use]["before"])
        # The search filters twice: what only its second pass takes away no effect has explained.
        second_pass = max(rmse**2 - before**2, 0.0)
        return float(np.sqrt(left**2 + second_pass)) * error / rmse


def emps_figures(results: Results) -> list[Figure]:
    """Return the figures of the prismatic drive."""
    entry = results.configuration
    made = []
    for id, published in EMPS_PUBLISHED.items():
        value = None if entry is None or entry["baseline"] is None else entry["baseline"]["parameters"][id]["value"]
        deviation = None if value is None else 100.0 * abs(value / published - 1.0)
        aim = EMPS_LARGEST_DEVIATION[id]
        name = f"{id} of the plain model, deviation from the published {published:g}"
        made.append(Figure(name=name, unit="%", aim=aim, reached=deviation))
    made.append(Figure(name="asymmetric friction named", unit="", aim=ASYMMETRIC, reached=results.names))
    share = results.torque_error_with_names("fit")
    name = "force error with the named effects, fitted run"
    made.append(Figure(name=name, unit="%", aim=3.2, reached=None if share is None else 100.0 * share, published=3.11))
    free = results.mean("validate", "free_rmse")
    millimetres = None if free is None else 1e3 * free
    made.append(
        Figure(name="free simulation of the unseen run", unit="mm", aim=6.0, reached=millimetres, published=9.25)
    )
    wall = results.identified.wall_s + results.missing.wall_s
    return [*made, Figure(name="wall time of both commands", unit="s", aim=60.0, reached=round(wall, 1))]


def dvrk_figures(results: Results) -> list[Figure]:
    """Return the figures of the tendon-driven joint."""
    reached: dict[str, float | None] = {}
    for use in ("fit", "validate"):
        left = results.torque_left(use)
        # The published residuals are those of the recorded torque, with all that a filter takes away.
        reached[use] = None if left is None else 1e3 * float(np.hypot(left, filtered_away(results.campaign, use)))
    friction = ("position_dependent_friction", "position_dependent_viscous")
    fitted = "unfiltered torque left, fitted two thirds (published value: all rows, all fitted)"
    unseen = "unfiltered torque left, held-out last third (aim and published value: every third of 48 stretches)"
    return [
        Figure(name=fitted, unit="mN m", aim=4.2, reached=reached["fit"], published=4.2),
        Figure(name=unseen, unit="mN m", aim=3.7, reached=reached["validate"], published=4.63),
        Figure(name="position-dependent friction named", unit="", aim=friction, reached=results.names),
    ]


def simple_pendulum_figures(results: Results) -> list[Figure]:
    """Return the figures of the pendulum; its weight hangs on the drive's torque constant, its ratio to inertia not."""
    entry = results.configuration
    weight = None if entry is None else entry["parameters"]["gravity_sin"]["value"]
    inertia = None if entry is None else entry["parameters"]["inertia"]["value"]
    deviation = None if weight is None else 100.0 * abs(weight / PENDULUM_WEIGHT_NM - 1.0)
    ratio = None
    if weight is not None and inertia is not None:
        ratio = 100.0 * abs(inertia / weight / PENDULUM_INERTIA_OVER_WEIGHT_S2 - 1.0)
    error = results.mean("validate", "torque_error")
    share = None if error is None else 100.0 * error
    unseen = "torque error, unseen trajectory (published value: least squares fitted to it)"
    name = f"gravity, deviation from {PENDULUM_WEIGHT_NM:.4g} N m"
    known = f"{PENDULUM_INERTIA_OVER_WEIGHT_S2:.4g} s² of a point mass, whatever the torque constant"
    return [
        Figure(name=name, unit="%", aim=3.0, reached=deviation),
        Figure(name=f"inertia over gravity, deviation from {known}", unit="%", aim=3.0, reached=ratio),
        Figure(name=unseen, unit="%", aim=13.0, reached=share, published=15.2),
    ]


def double_pendulum_figures(results: Results) -> list[Figure]:
    """Return the figures of the two-joint arm."""
    ratios = [run["rmse_over_noise"] for run in results.runs("validate")]
    known = bool(ratios) and all(ratio is not None for ratio in ratios)
    reached = float(np.sqrt(np.mean(np.square(ratios)))) if known else None
    entry = results.configuration
    published = None
    if entry is not None:
        scores = published_scores(results.campaign, entry["observer_gain_per_s"])
        unseen = [scores[run["file"]] for run in results.runs("validate")]
        published = float(np.sqrt(np.mean(np.square(unseen))))
    name = "residual over the noise, unseen runs, published values through the same simulation"
    return [Figure(name=name, unit="1", aim=15.0, reached=reached, published=published)]


def xl330_figures(results: Results) -> list[Figure]:
    """Return the figures of the servo; a root mean square is never below the mean absolute error."""
    closed = results.mean("validate", "closed_rmse")
    reached = None if closed is None else 1e3 * closed
    name = "closed loop on gain 400 from the measured start, RMS (aim and published value: mean absolute error)"
    loop = None if results.missing.result is None else results.missing.result.get("closed_loop")
    # Sealed runs are runs of gain 400 too, that took part in no choice.
    unseen = [] if loop is None else [loop["after"][use] for use in ("validate", "sealed") if use in loop["after"]]
    runs = sum(part["runs"] for part in unseen)
    named = 1e3 * sum(part["runs"] * part["mean_absolute"] for part in unseen) / runs if runs else None
    with_names = "closed loop on gain 400 with the named effects, mean absolute error"
    return [
        Figure(name=name, unit="mrad", aim=40.0, reached=reached, published=40.7),
        Figure(name=with_names, unit="mrad", aim=40.0, reached=named, published=40.7),
        Figure(name="load-dependent friction named", unit="", aim=("load_dependent_friction",), reached=results.names),
    ]
