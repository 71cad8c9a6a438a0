"""Page and README paragraph of the real machines: stored JSON in, Markdown out."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

from docs.parts.tables import table
from haptid.support.numbers import with_unit

MARKS = {True: "yes", False: "no", None: "-"}
NONE = "no result"
"""What stands where a command gave none."""
PLAIN = "plain"
"""Outcome of a configuration whose fit the plain model replaced."""


def page_of(data: Mapping[str, Any]) -> str:
    """Write the page from the stored results."""
    lines = [
        "# Real machines",
        "",
        "Both commands with their defaults on measured campaigns, beside what was published. The campaigns state "
        "units, references and the use of every run; nothing is smoothed or left out. What is missing is judged in "
        "torques that passed the filter of inverse dynamics twice.",
        "",
        f"`{data['command']}`, {data['date']}, {data['cores']} cores that others used as well; a command is stopped "
        f"after {data['limit_s']:.0f} s.",
        "",
        "## Figures",
        "",
        _figures(data["sets"]),
    ]
    for one in data["sets"]:
        lines += _section(one)
    return "\n".join(lines).rstrip() + "\n"


def readme_text(data: Mapping[str, Any]) -> str:
    """Write the table of README that names the figures, rounded for reading; the page has them in full."""
    all_figures = [figure for one in data["sets"] for figure in one["figures"]]
    met = sum(figure["met"] is True for figure in all_figures)
    rows = []
    for one in data["sets"]:
        title = one["title"]
        for figure in one["figures"]:
            rows.append((title, short_name(figure["name"]), _reached(figure), _aim(figure), MARKS[figure["met"]]))
            title = ""  # a machine is named once
    first = (
        f"- [Real machines](docs/results/real_machines.md) are harder than synthetic joints: {met} of "
        f"{len(all_figures)} figures reach their aims."
    )
    header = ("machine", "figure", "reached", "aim", "met")
    return f"{first}\n\n{table(header, rows)}"


def short_name(name: str) -> str:
    """Return the name of a figure without the published value and other remarks."""
    return re.sub(r"deviation from .*", "deviation from the published", re.sub(r" \(.*\)", "", name))


def _reached(figure: Mapping[str, Any]) -> str:
    """Write a figure with two digits, and with a third where two would hide on which side of its aim it is."""
    value, aim = figure["reached"], figure["aim"]
    if not isinstance(value, float) or not isinstance(aim, float):
        return _value(value, figure["unit"])
    short = float(f"{value:.2g}")
    return _value(short if (short <= aim) == (value <= aim) else value, figure["unit"])


def _figures(sets: Sequence[Mapping[str, Any]]) -> str:
    rows = [
        (
            one["folder"],
            figure["name"],
            _aim(figure),
            _value(figure["published"], figure["unit"], none=""),
            _value(figure["reached"], figure["unit"]),
            MARKS[figure["met"]],
        )
        for one in sets
        for figure in one["figures"]
    ]
    return table(("set", "figure", "aim", "published", "reached", "aim reached"), rows)


def _aim(figure: Mapping[str, Any]) -> str:
    aim = figure["aim"]
    return " or ".join(aim) if isinstance(aim, list) else f"≤ {_value(aim, figure['unit'])}"


def _value(value: float | Sequence[str] | None, unit: str, *, none: str = NONE) -> str:
    if value is None:
        return none
    if isinstance(value, float):
        return with_unit(f"{value:.3g}", unit)
    return ", ".join(value) or "none"


def _section(one: Mapping[str, Any]) -> list[str]:
    run_at = f"Run on {one['date']} with haptid at `{one['version']}`."
    lines = ["", f"## {one['title']}", "", f"Published: {one['source']}. {run_at}", ""]
    lines += [f"- `{call['command']}`: {call['outcome']}, {call['wall_s']:.1f} s" for call in one["commands"]]
    found, missing = one["identification"], one["missing"]
    if found is not None:
        lines += ["", f"Outcome `{found['outcome']}`, residual in {found['residual']}: {found['why']}."]
        if found["outcome"] == PLAIN:
            lines[-1] += " The plain model replaced the fit, so that the figures above are those of the plain model."
        lines[-1] += _describe_delay(found.get("delay"))
    if one["picture"]:
        lines += ["", f"![Measured, computed and simulated signals of an unseen run, with residuals]({one['picture']})"]
    if found is not None:
        lines += ["", _parameters(found["parameters"]), _runs(found["runs"], found["outcome"])]
    if missing is not None:
        lines += ["", f"What is missing: `{missing['verdict']}`. {missing['sentence']}"]
        # Under any other verdict an effect only stands in for what is missing.
        if missing["verdict"] in ("named", "partly_named", "ambiguous"):
            lines += _effects(missing["effects"])
    return lines


def _parameters(rows: Sequence[Mapping[str, Any]]) -> str:
    cells = [
        (row["id"], _number(row["published"]), _with_std(row["plain"]), _with_std(row["fit"]), row["unit"])
        for row in rows
    ]
    return table(("parameter", "published", "plain model ± std", "fit ± std", "unit"), cells)


def _with_std(parameter: Mapping[str, Any] | None) -> str:
    if parameter is None:
        return ""
    std = parameter["std"]
    return f"{parameter['value']:.4g}" + (f" ± {std:.2g}" if std else "")


def _describe_delay(delay: Mapping[str, Any] | None) -> str:
    """Write the delay between torque and motion; empty where none earned its place."""
    if delay is None:
        return ""
    late = "after" if delay["value"] > 0 else "before"
    size, error = (f"{1e3 * abs(delay[key]):.2g}" for key in ("value", "std"))
    return f" The torque acts {size} ± {error} ms {late} it is recorded."


def _runs(runs: Sequence[Mapping[str, Any]], outcome: str) -> str:
    # The residual over the noise is that of the result.
    result = "baseline" if outcome == PLAIN else "model"
    rows = []
    for run in runs:
        for name, label in (("model", "fit"), ("baseline", "plain model")):
            figures = run["figures"].get(name)
            if figures is None:
                continue
            horizons = [_number(figures["horizon_rmse"].get(h)) for h in ("0.1", "1", "10")]
            own = [_number(figures[key]) for key in ("free_rmse", "torque_rmse", "torque_error")]
            over = _number(run["rmse_over_noise"]) if name == result else ""
            rows.append((run["file"], run["use"], label, *own, *horizons, over))
    header = ("run", "use", "model", "free RMS", "torque RMS", "torque error", "0.1 s", "1 s", "10 s", "RMS / noise")
    return "RMS in rad or m, torque in N m or N, torque error over the torque's RMS:\n\n" + table(header, rows)


def _number(value: float | Sequence[float | None] | None) -> str:
    if isinstance(value, (list, tuple)):
        return ", ".join(_number(x) for x in value)
    return "-" if value is None else f"{value:.3g}"


def _effects(effects: Sequence[Mapping[str, Any]]) -> list[str]:
    lines = []
    for effect in effects:
        told = [f"{id} {_with_std(p)} {p['unit']}" for id, p in effect["parameters"].items()]
        lines.append(f"- {effect['id']}: {'; '.join(told)}")
    return ["", *lines] if lines else []
