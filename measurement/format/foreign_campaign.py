"""Read a campaign about any FMU: folder in, `ForeignCampaign` out, checked to the last cell (INTERFACES, section 6).

1. Parse ``campaign.toml``, and check its tables and the FMU's file.
2. Check what is stated of inputs, outputs and parameters.
3. Read the columns of each ``[[runs]]`` entry.
4. Estimate the noise of the outputs that state none: the median over the runs.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from haptid.measurement.format import schema
from haptid.measurement.format.places import check_inside
from haptid.measurement.format.reading import open_source
from haptid.measurement.format.toml_source import TomlSource
from haptid.measurement.signals.noise import estimate_noise
from haptid.measurement.signals.resolution import estimate_resolution
from haptid.measurement.tables.table import Table, read_table
from haptid.measurement.values.foreign_campaign import ForeignCampaign
from haptid.measurement.values.run import Array, Run
from haptid.support.errors import InputError, one_line
from haptid.support.files.files import is_file
from haptid.support.suggestion import did_you_mean

TABLES = ("campaign", "inputs", "outputs", "parameters", "runs")


def read_foreign_campaign(folder: Path | str, model: Path | None = None) -> ForeignCampaign:
    """Read and check a campaign about an FMU; the FMU's own variables are not looked at.

    Parameters
    ----------
    folder
        The folder with ``campaign.toml``.
    model
        The FMU; the one that ``campaign.toml`` names where None.

    Returns
    -------
    ForeignCampaign

    Raises
    ------
    InputError
        With file, line or key, what was expected and what came, at the first fault.
    """
    folder = Path(folder)
    source = open_source(folder, TABLES)
    head = schema.check_table(source, source.data.get("campaign"), schema.FOREIGN_CAMPAIGN, "campaign")
    archive = _model(source, head, model)
    inputs = _check_tables(source, "inputs", schema.INPUT)
    outputs = _check_tables(source, "outputs", schema.OUTPUT)
    if not outputs:
        raise InputError(source.where("outputs"), expected="at least one output under [outputs]", got="none")
    parameters = _check_tables(source, "parameters", schema.PARAMETER)
    for name, entry in parameters.items():
        _check_parameter(entry, source.where("parameters", name))
    held = [run.but(hold=head.get("hold", "zero")) for run in _read_runs(source, inputs, outputs)]
    runs = tuple(_with_noise(held, outputs))
    return ForeignCampaign(
        folder=folder,
        title=one_line(head.get("title", folder.resolve().name)),
        measured=head["measured"],
        model=archive,
        inputs=tuple(inputs),
        outputs=tuple(outputs),
        parameters=parameters,
        runs=runs,
        starts={entry["file"]: _numbers(entry.get("start", {})) for entry in source.data["runs"]},
        noise_given={name: "noise" in entry for name, entry in outputs.items()},
        places={(s, key): source.where(s, key) for s in TABLES[1:4] for key in source.data.get(s, {})}
        | {("runs", e["file"]): source.where("runs", "start", k) for k, e in enumerate(source.data["runs"])},
    )


def _model(source: TomlSource, head: Mapping[str, Any], model: Path | None) -> Path:
    """Return the FMU's path: the user's own, or the one that the campaign names inside its folder."""
    if model is not None:
        return model
    where = source.where("campaign", "model")
    if "model" not in head:
        raise InputError(where, expected="the file of an FMU", got="none", todo="name it, or give --model ANY.fmu")
    path = source.path.parent / head["model"]
    if not is_file(path):
        raise InputError(where, expected="the file of an FMU", got=f"no file {head['model']!r} there")
    check_inside(source.path.parent, head["model"], where)
    return path


def _check_tables(source: TomlSource, section: str, keys: Mapping[str, schema.Key]) -> dict[str, dict[str, Any]]:
    """Return a table of tables by variable, each checked."""
    table = source.data.get(section, {})
    if not isinstance(table, dict):
        raise InputError(source.where("", section), expected=f"a table [{section}]", got=repr(table))
    for name, entry in table.items():
        where = source.where(section, name)
        if not isinstance(entry, dict):
            expected = f"a table {{ {', '.join(keys)} }}"
            raise InputError(where, expected=expected, got=repr(entry))
        _check_keys(entry, keys, name, where)
    return table


def _check_keys(entry: Mapping[str, Any], keys: Mapping[str, schema.Key], name: str, where: str) -> None:
    """Refuse unknown keys of one variable, values of another kind, and missing keys."""
    for key, value in entry.items():
        place = f"{where}.{key}"
        if key not in keys:
            # An unquoted dot makes a table of its own in TOML.
            dotted = f'write "{name}.{key}" with its quotes' if isinstance(value, dict) else ""
            raise InputError(place, expected="a known key", got=repr(key), todo=dotted or did_you_mean(key, keys))
        if not keys[key].accepts(value):
            raise InputError(place, expected=keys[key].words, got=repr(value))
    for key, demanded in keys.items():
        if demanded.required and key not in entry:
            raise InputError(where, expected=f"{key}, {demanded.words}", got="no such key")


def _check_parameter(entry: Mapping[str, Any], where: str) -> None:
    if "fixed" in entry and len(entry) > 1:
        others = ", ".join(key for key in entry if key != "fixed")
        raise InputError(where, expected="fixed alone", got=f"fixed with {others}", todo="keep one of the two")
    lower, upper = entry.get("lower", -np.inf), entry.get("upper", np.inf)
    if not lower < upper:
        raise InputError(where, expected="lower < upper", got=f"lower {lower:g}, upper {upper:g}")
    inside = {"initial": entry.get("initial"), "mean": entry.get("prior", {}).get("mean")}
    for key, value in inside.items():
        if value is not None and not lower <= value <= upper:
            got = f"{key} {value:g} outside [{lower:g}, {upper:g}]"
            raise InputError(where, expected="values within the bounds", got=got)


def _read_runs(
    source: TomlSource, inputs: Mapping[str, Mapping[str, Any]], outputs: Mapping[str, Mapping[str, Any]]
) -> list[Run]:
    listed = source.data.get("runs")
    if not isinstance(listed, list) or not listed:
        raise InputError(source.where("runs"), expected="at least one [[runs]]", got=repr(listed))
    runs: list[Run] = []
    for index, entry in enumerate(listed):
        schema.check_table(source, entry, schema.FOREIGN_RUN, "runs", index)
        name = entry["file"]
        if name in [run.file for run in runs]:
            raise InputError(source.where("runs", "file", index), expected="each table once", got=f"{name!r} again")
        if entry["use"] == "excluded" and not entry.get("reason"):
            where = source.where("runs", "reason", index)
            raise InputError(where, expected="a reason why the run is excluded", got="none", todo='add reason = "…"')
        check_inside(source.path.parent, name, source.where("runs", "file", index))
        runs.append(_run(read_table(source.path.parent / name), entry, inputs, outputs))
    if not any(run.use == "fit" for run in runs):
        raise InputError(source.where("runs"), expected='at least one run with use = "fit"', got="none")
    return runs


def _run(
    table: Table,
    entry: Mapping[str, Any],
    inputs: Mapping[str, Mapping[str, Any]],
    outputs: Mapping[str, Mapping[str, Any]],
) -> Run:
    t = table.time()
    y = np.column_stack([table.numbers(one["column"]) for one in outputs.values()])
    return Run(
        file=entry["file"],
        free_joints=tuple(range(len(outputs))),
        t=t - t[0],
        start_time=float(t[0]),
        u=np.zeros_like(y),
        y=y,
        drive_inputs={name: table.numbers(one["column"]) for name, one in inputs.items()},
        noise=np.array([one.get("noise", np.nan) for one in outputs.values()]),
        resolution=np.zeros(len(outputs)),
        posture=np.zeros(0),
        use=entry["use"],
        reason=one_line(entry.get("reason", "")),
        notes=(one_line(str(entry["note"])),) if "note" in entry else (),
    )


def _with_noise(runs: list[Run], outputs: Mapping[str, Mapping[str, Any]]) -> list[Run]:
    """Fill in the noise and the step of the outputs that state no noise."""
    for k, entry in enumerate(outputs.values()):
        if "noise" in entry:
            continue
        steps = [estimate_resolution(run.y[:, k]) for run in runs]
        noise = [estimate_noise(run.t, run.y[:, k], step) for run, step in zip(runs, steps, strict=True)]
        runs = [
            run.but(
                noise=_replace_one(run.noise, k, float(np.median(noise))),
                resolution=_replace_one(run.resolution, k, float(np.median(steps))),
            )
            for run in runs
        ]
    return runs


def _replace_one(values: Array, place: int, value: float) -> Array:
    changed = values.copy()
    changed[place] = value
    return changed


def _numbers(values: Mapping[str, Any]) -> dict[str, float]:
    return {name: float(value) for name, value in values.items()}
