"""The table and the page of performance: stored results in, text, Markdown and a picture of growth out."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as Drawing
from matplotlib.ticker import MaxNLocator

from benchmarks.performance.figures import RESULTS, STORED, Figure, read_stored
from haptid.report.common.style import MEASURED, SIMULATED, figure, png, style
from haptid.support.files.files import write_bytes, write_text

PAGE = STORED.with_suffix(".md")
PICTURE = RESULTS / "performance.png"
PANELS_IN_A_ROW = 3
"""Curves beside one another, so that their labels have room at the size of the text."""
HEAD = """# Performance

How long a user waits, and what grows with what. `make bench` prints one table of these figures and of those that other
benchmarks stored. Curves show processor time, which depends less on what else a machine does; memory is a peak,
packages included."""


def machine_words(stored: Mapping[str, Any]) -> str:
    """Return machine, load and versions of the measurement in a sentence."""
    versions = ", ".join(f"{name} {version}" for name, version in stored["versions"].items())
    return f"{stored['machine']}; {versions}; load {stored['load']:.1f} at the end; commit {stored['commit']}."


def text_table(figures: Sequence[Figure]) -> str:
    """Return all figures as a table for a terminal."""
    lines, group = [], ""
    for one in figures:
        if one.group != group:
            group = one.group
            lines.append(group)
        lines.append(f"  {one.name[:84]:84s} {one.value:10.3g} {one.unit:15s} {one.origin}")
    return "\n".join(lines)


def growth_rows(stored: Mapping[str, Any]) -> list[str]:
    """Return a row for each point of each curve, with the exponent of the growth from the first to the last."""
    rows = []
    for curve in stored["curves"].values():
        points = curve["points"]
        first, last = points[0], points[-1]
        grown = np.log(last["cpu_s"] / first["cpu_s"]) / np.log(last["size"] / first["size"])
        listed = ", ".join(f"{one['size']}: {one['cpu_s']:.2g} ({one['wall_s']:.2g})" for one in points)
        ends = dict.fromkeys(f"{one['peak_mb']:.0f}" for one in (first, last))
        memory = " to ".join(ends)
        rows.append(f"| {curve['title']} | {curve['axis']} | {listed} | {grown:.2f} | {memory} |")
    return rows


def draw_growth(stored: Mapping[str, Any]) -> Drawing:
    """Draw processor time and memory of each curve over what grows."""
    curves = list(stored["curves"].values())
    blocks = -(-len(curves) // PANELS_IN_A_ROW)
    with style():
        made = figure(9.0, 3.8 * blocks)
        axes = made.subplots(2 * blocks, PANELS_IN_A_ROW, squeeze=False)
        for axis in axes.flat:
            axis.set_visible(False)
        for number, curve in enumerate(curves):
            block, column = divmod(number, PANELS_IN_A_ROW)
            above, below = axes[2 * block, column], axes[2 * block + 1, column]
            _draw_curve(above, below, curve)
            if column == 0:
                above.set_ylabel("processor time [s], log")
                below.set_ylabel("peak memory [MB]")
    return made


def _draw_curve(above: Axes, below: Axes, curve: Mapping[str, Any]) -> None:
    """Draw processor time above and memory below; the ends of what grows and of the time are told by their numbers."""
    sizes, times, memory = ([one[key] for one in curve["points"]] for key in ("size", "cpu_s", "peak_mb"))
    above.loglog(sizes, times, "o-", ms=3, color=SIMULATED)
    below.semilogx(sizes, memory, "o-", ms=3, color=MEASURED)
    below.set_ylim(0.0, 1.2 * max(memory))
    below.yaxis.set_major_locator(MaxNLocator(4))
    ends = sorted({min(times), max(times)})
    # Within less than a power of ten a logarithmic axis has no number of its own.
    above.set_yticks(ends, [f"{end:.2g}" for end in ends])
    below.set_xlabel(curve["axis"])
    for axis in (above, below):
        axis.set_visible(True)
        axis.set_xticks([sizes[0], sizes[-1]], [str(sizes[0]), str(sizes[-1])])
        axis.minorticks_off()


def _front_door(stored: Mapping[str, Any] | None) -> list[str]:
    """Return the section on what a newcomer meets; nothing where it was not measured."""
    if stored is None:
        return []
    pages, machine = stored["documentation"], stored["machine"]
    lines = [
        "## The front door",
        "",
        f"`{stored['command']}`, {stored['date']}: {machine}.",
        "",
        f"The documentation has {pages['pages']} pages, README included. Tests run, compile or read the blocks of code "
        f"on them: {pages['bash']} of command lines, {pages['python']} of Python, {pages['toml']} of TOML.",
        "",
        *_axe_in_words(stored["axe"]),
    ]
    if "arm" not in stored:
        return lines
    arm = stored["arm"]
    report, load = arm["report"], arm["load"]
    rows = [f"| {name} | {seconds:.1f} |" for name, seconds in arm["commands"].items()]
    total = sum(arm["commands"].values())
    return [
        *lines,
        f"From {arm['tables']} raw tables and a URDF of a two-joint arm to its FMU in a second tool, on {arm['date']} "
        f"at a load of {load[0]} to {load[1]}: {len(rows)} commands with no edit between them, {total / 60.0:.1f} "
        "minutes. "
        "The pendulum of the [tutorial](../tutorial/from_tables_to_fmu.md) has its own times there.",
        "",
        "| command | s |",
        "| --- | ---: |",
        *rows,
        "",
        f"Its report has {report['size_MB']:.1f} MB in one file; headless Chromium takes {report['load_s']:.2f} s.",
        "",
    ]


def _axe_in_words(examined: Mapping[str, Any]) -> list[str]:
    """Return the lines on what axe-core found on the pages and on a report, by the width of the screen."""
    told = []
    for of, one in examined.items():
        where = f"the {one['pages']} built pages" if of == "documentation" else "the report of the arm below"
        found = " and ".join(f"{number} at {width} px" for width, number in one["violations"].items())
        told.append(f"{found} on {where} ({one['date']})")
    return [f"Violations that axe-core finds: {'; '.join(told)}.", ""]


def workers_in_words(stored: Mapping[str, Any]) -> str:
    """Say whether several workers were sooner than one; empty where that was not measured."""
    points = stored["curves"].get("workers", {}).get("points", ())
    if len(points) < 2:
        return ""
    alone, most = points[0], points[-1]
    walls = f"{alone['wall_s']:.2g} s with {alone['size']}, {most['wall_s']:.2g} s with {most['size']}"
    if most["wall_s"] < alone["wall_s"]:
        return f"Several workers were sooner than one ({walls})."
    return (
        f"Several workers were no sooner than one for so short a fit ({walls}): each starts an interpreter first, and "
        "the work of others on the machine lengthens all wall times."
    )


def curves_in_words(stored: Mapping[str, Any]) -> str:
    """Say when, of which commit and beside what load the curves were measured."""
    loads: dict[tuple[str, str], list[float]] = defaultdict(list)
    for curve in stored["curves"].values():
        loads[curve["date"], curve["commit"]].append(curve["load"])
    return "; ".join(
        f"{date}, commit {commit}, load {min(each):.1f} to {max(each):.1f}" for (date, commit), each in loads.items()
    )


def page_of(stored: Mapping[str, Any]) -> str:
    """Return the page of stored results."""
    waiting = [f"| `{name}` | {seconds:.2f} |" for name, seconds in stored["waiting_s"].items()]
    lines = [
        HEAD,
        "",
        f"`{stored['command']}`, {stored['date']}: {machine_words(stored)}",
        "",
        "## Until the first word",
        "",
        "| command | s |",
        "| --- | ---: |",
        *waiting,
        "",
        "The shortest of five starts, until the first byte is there.",
        "",
        "## What grows with what",
        "",
        "![Processor time and peak memory over what grows](performance.png)",
        "",
        "What grows and processor time are on logarithmic axes, each panel with its own ends; memory is from 0.",
        "",
        f"Measured {curves_in_words(stored)}. Memory is that of the first process and its workers together.",
        "",
        "| work | what grows | size: processor s (wall s) | exponent | memory [MB] |",
        "| --- | --- | --- | ---: | --- |",
        *growth_rows(stored),
        "",
        "The exponent is 1 where double the size takes double the time, from the first to the last size.",
        workers_in_words(stored),
        "",
        *_front_door(read_stored("front_door.json")),
    ]
    return "\n".join(lines)


def write_page(stored: Mapping[str, Any]) -> None:
    """Write the page and its picture."""
    write_bytes(PICTURE, png(draw_growth(stored)))
    write_text(PAGE, page_of(stored))
