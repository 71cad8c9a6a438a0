"""What the page of an FMU says of its accuracy: `Accuracy` in, texts and rows of tables out."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from haptid.fmu_build.accuracy.accuracy import Accuracy

MODES = {
    "as_fitted": "as fitted",
    "open_loop": "free simulation",
    "closed_loop": "closed loop",
    "torque": "torque of the measured motion",
}
"""How a run was compared, in words."""

SNIPPET = """import csv, fmpy, numpy, pathlib
folder = fmpy.extract("{identifier}.fmu")
lines = lambda name: csv.DictReader(pathlib.Path(folder, name).read_text().splitlines())
read = lambda name: [{{k: float(x) for k, x in row.items()}} for row in lines(name)]
draws, drive = read("extra/haptid/draws.csv"), read("documentation/{identifier}_in.csv")
signals = numpy.array([tuple(row.values()) for row in drive], dtype=[(name, float) for name in drive[0]])
times = {{"stop_time": {stop_s}, "output_interval": 0.005}}
run = lambda start: fmpy.simulate_fmu(folder, start_values=start, input=signals, **times)
nominal, drawn = run({{}}), [run({{k: x for k, x in draw.items() if k != "draw"}}) for draw in draws]
lower, upper = numpy.quantile([each["{output}"] for each in drawn], (0.025, 0.975), axis=0)"""
"""How a host steps the draws, with fmpy: the band of an output along the reference run."""


def write_snippet(identifier: str, output: str, stop_s: float) -> str:
    """Return the lines of Python that step the draws of an FMU.

    Parameters
    ----------
    identifier
        Model identifier, the name of the FMU.
    output
        FMU variable name of the output whose band is wanted.
    stop_s
        End of the simulation [s].

    Returns
    -------
    str
        Lines of Python that define ``nominal``, ``lower`` and ``upper``.
    """
    return SNIPPET.format(identifier=identifier, output=output, stop_s=stop_s)


def rows_of_runs(accuracy: Accuracy) -> Iterator[tuple[str, ...]]:
    """Yield the cells of every figure: joint, file, use, what is compared, RMS with its unit, times the noise.

    Parameters
    ----------
    accuracy
        Verification of each joint and run.

    Yields
    ------
    tuple of str
        Six cells of one figure; RMS of torque in N m or N where torques are compared.
    """
    for one in accuracy.joints:
        for run in one["runs"]:
            unit = one["unit"] if run["mode"] != "torque" else {"rad": "N m", "m": "N"}[one["unit"]]
            joints = run["free_joints"]
            free = "all joints free" if joints == "all" else f"free: {', '.join(map(str, joints))}"
            yield (
                str(one["joint"]),
                f"{run['file']} ({free})",
                str(run["use"]),
                MODES[run["mode"]],
                _number(run["rmse"], unit),
                _over(run),
            )


def _over(run: Mapping[str, Any]) -> str:
    relative = run.get("relative")
    if relative is not None:
        return f"{100 * relative:.3g} % of the torque"
    return _number(run.get("over_noise"), "")


def _number(value: float | None, unit: str) -> str:
    return "not finite or not made" if value is None else f"{value:.3g} {unit}".rstrip()


def sentences_of_effects(accuracy: Accuracy) -> Iterator[str]:
    """Yield a sentence about each effect in the model: estimates, evidence, stability, gap that it helps to close.

    Parameters
    ----------
    accuracy
        Effects in the model.

    Yields
    ------
    str
        One sentence an effect; what is not known is left out.
    """
    for effect in accuracy.effects:
        values = ", ".join(f"{id} = {_estimate(one)}" for id, one in effect["parameters"].items())
        told = [f"joint {effect['joint']}: {effect['id']}" + (f" ({values})" if values else "")]
        if effect.get("evidence") is not None:
            told.append(f"evidence {effect['evidence']:.3g}")
        if effect.get("stability") is not None:
            told.append(f"named in {100 * effect['stability']:.0f} % of bags of runs")
        gap = (effect.get("gap") or {}).get("validate") or {}
        if gap.get("closed") is not None:
            told.append(f"the effects close {100 * gap['closed']:.3g} % of the gap on runs that no fit saw")
        yield "; ".join(told)


def _estimate(one: Mapping[str, Any]) -> str:
    std = one.get("std")
    error = "" if std is None else f" ± {std:.2g}"
    return f"{one['value']:.4g}{error} {one.get('unit', '')}".rstrip()


def rows_of_digests(accuracy: Accuracy, equations: str) -> Iterator[tuple[str, str]]:
    """Yield name and value of what identifies campaign, data and code.

    Parameters
    ----------
    accuracy
        Digests that the values come from.
    equations
        Digest of the formulas.

    Yields
    ------
    tuple of (str, str)
        Digest of the formulas first; those without a value are left out.
    """
    yield "equations", equations
    for key, value in accuracy.digests.items():
        if isinstance(value, Mapping):
            yield from ((f"{key}: {name}", str(one)) for name, one in value.items() if one is not None)
        elif value is not None:
            yield key, str(value)
