"""All performance figures in one list: stored results in, name, value, unit and origin of each out."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from haptid.support.installing.environment import ROOT

RESULTS = ROOT / "docs" / "results"
STORED = RESULTS / "performance.json"
TUTORIAL = ROOT / "docs" / "tutorial" / "from_tables_to_fmu.json"


class Figure(NamedTuple):
    """One row of the table.

    Parameters
    ----------
    group, name
        What is measured.
    value, unit
        How much.
    origin
        File and date.
    """

    group: str
    name: str
    value: float
    unit: str
    origin: str


def read_stored(name: str) -> dict[str, Any] | None:
    """Return a stored result; None where there is none."""
    path = RESULTS / name
    return json.loads(path.read_text(encoding="utf-8")) if path.is_file() else None


def all_figures() -> list[Figure]:
    """Return every performance figure that is stored, measured here or by another benchmark."""
    return [
        *_measured_here(),
        *_installation(),
        *_tutorial(),
        *_arm(),
        *_time_to_truth(),
        *_real_machines(),
        *_fmu_steps(),
        *_fuzzing(),
    ]


def _measured_here() -> Iterator[Figure]:
    stored = read_stored(STORED.name)
    if stored is None:
        return
    origin = f"performance.json, {stored['date']}"
    for name, seconds in stored["waiting_s"].items():
        yield Figure("first word", name, seconds, "s", origin)
    for curve in stored["curves"].values():
        for point in (curve["points"][0], curve["points"][-1]):
            group, name = curve["title"], f"{point['size']} {curve['axis']}"
            then = f"performance.json, {curve['date']}, commit {curve['commit']}, load {curve['load']:.1f}"
            yield Figure(group, name, point["cpu_s"], "s of processor", then)
            yield Figure(group, name, point["wall_s"], "s", then)
            yield Figure(group, name, point["peak_mb"], "MB", then)


def _installation() -> Iterator[Figure]:
    stored = read_stored("install.json")
    if stored is None:
        return
    low, high = stored["load"]
    origin = f"{_origin('install.json', stored)}, load {low:.1f} to {high:.1f}"
    for name, step in stored["steps"].items():
        yield Figure("installation", name, step["wall_s"], "s", origin)
        if "disk_mb" in step:
            yield Figure("installation", f"{name}, disk", step["disk_mb"], "MB", origin)


def _tutorial() -> Iterator[Figure]:
    if not TUTORIAL.is_file():
        return
    stored = json.loads(TUTORIAL.read_text(encoding="utf-8"))
    origin = f"from_tables_to_fmu.json, {stored['date']}"
    for name, seconds in stored["seconds"].items():
        yield Figure("tutorial, tables to FMU", name.partition(". ")[2], seconds, "s", origin)


def _arm() -> Iterator[Figure]:
    stored = read_stored("front_door.json")
    if stored is None or "arm" not in stored:
        return
    origin = _origin("front_door.json", stored["arm"])
    for name, seconds in stored["arm"]["commands"].items():
        yield Figure("two-joint arm, tables to FMU", name, seconds, "s", origin)
    yield Figure("two-joint arm, its report", "size", stored["arm"]["report"]["size_MB"], "MB", origin)
    yield Figure("two-joint arm, its report", "load in Chromium", stored["arm"]["report"]["load_s"], "s", origin)
    for of, one in stored["axe"].items():
        for width, number in one["violations"].items():
            origin = _origin("front_door.json", one)
            yield Figure("violations that axe-core finds", f"{of} at {width} px", number, "", origin)


def _time_to_truth() -> Iterator[Figure]:
    stored = read_stored("time_to_truth.json")
    if stored is None:
        return
    for case, ratios in stored["best_rival_over_haptid"].items():
        title = stored["cases"][case]["title"]
        for contestant, over in ratios.items():
            name = f"{title}: the best other takes, over {contestant}"
            yield Figure("time to truth, processor", name, over["cpu"], "times", _origin("time_to_truth.json", stored))


def _real_machines() -> Iterator[Figure]:
    stored = read_stored("real_machines.json")
    for one in [] if stored is None else stored["sets"]:
        wall = sum(command["wall_s"] for command in one["commands"])
        yield Figure("real machines, all commands", one["title"], wall, "s", _origin("real_machines.json", stored))


def _fmu_steps() -> Iterator[Figure]:
    stored = read_stored("fmu_speed.json")
    for name, nanoseconds in ({} if stored is None else stored["ns_per_step"]).items():
        yield Figure("a step of one joint", name, nanoseconds, "ns", _origin("fmu_speed.json", stored))


def _fuzzing() -> Iterator[Figure]:
    stored = read_stored("fuzzing.json")
    for name, reader in sorted(({} if stored is None else stored["readers"]).items()):
        origin = _origin("fuzzing.json", reader)
        yield Figure("readers, slowest changed file", name, reader["worst_seconds"], "s of processor", origin)


def _origin(name: str, stored: Mapping[str, Any] | None) -> str:
    return f"{name}, {stored['date']}" if stored else name
