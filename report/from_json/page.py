"""A plain page of a result of which only the JSON is left: its content in, `Page` without pictures out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from haptid.report.common.numbers import with_error
from haptid.report.common.page import Page, Section, Table, status_cell
from haptid.support.errors import InputError
from haptid.support.numbers import says_nothing

NO_PICTURES = "Written from the JSON alone: the command that made it writes the page with pictures."


def page_from_json(data: Mapping[str, Any], where: str) -> Page:
    """Render the tables of a result.

    Parameters
    ----------
    data
        Content of an identification.json, a posterior.json, or of the finding of a joint.
    where
        Name of the file, for errors.

    Returns
    -------
    Page
        With the label of synthetic data where the result says so.

    Raises
    ------
    InputError
        Where the content is that of no such result.
    """
    try:
        title, lead, sections = _content_of(data)
        measured = data["measured"]
    except (KeyError, TypeError, AttributeError, ValueError) as error:
        got = f"{type(error).__name__}: {error}"
        raise InputError(where, expected="a result that haptid wrote", got=got) from None
    return Page(title=title, lead=lead, sections=sections, synthetic=not measured, footer=[NO_PICTURES])


def _content_of(data: Mapping[str, Any]) -> tuple[str, str, list[Section]]:
    """Return title, lead and sections."""
    if "configurations" in data:
        return data["campaign"], NO_PICTURES, [_configuration(entry) for entry in data["configurations"]]
    if "verdict" in data:
        return (
            f"Joint {data['joint']}: what is missing",
            data["sentence"],
            [_effects(data["effects"]), _gap(data["gap"])],
        )
    return data["campaign"], NO_PICTURES, [_posterior(entry) for entry in data["joints"]]


def _configuration(entry: Mapping[str, Any]) -> Section:
    joints = entry.get("free_joints", [])
    parameters = [
        (id, _tell_value(p), p.get("unit", ""), status_cell(p["status"], entry.get("outcome", "")))
        for id, p in entry["parameters"].items()
    ]
    runs = [(run["file"], run["use"], _score(run["rmse_over_noise"])) for run in entry["runs"]]
    return Section(
        title=f"Joint {', '.join(map(str, joints))}" if joints else "Model",
        paragraphs=[f"Outcome: {entry['outcome_sentence']}."],
        tables=[
            Table(header=("parameter", "value ± std", "unit", "status"), rows=parameters),
            Table(header=("run", "use", "RMS × noise"), rows=runs),
        ],
    )


def _posterior(entry: Mapping[str, Any]) -> Section:
    rows = [
        (id, f"{p['median']:.6g}", _ends(p["intervals"]["0.95"]), p["unit"]) for id, p in entry["parameters"].items()
    ]
    header = ("parameter", "median", "95 % interval", "unit")
    return Section(title=f"Joint {entry['joint']}", tables=[Table(header=header, rows=rows)])


def _effects(effects: Sequence[Mapping[str, Any]]) -> Section:
    rows = [
        (effect["id"], id, _with_std(p["value"], p["std"]), p.get("unit", ""))
        for effect in effects
        for id, p in effect["parameters"].items()
    ]
    header = ("effect", "parameter", "value ± std", "unit")
    return Section(title="What is missing", tables=[Table(header=header, rows=rows)])


def _gap(gap: Mapping[str, Mapping[str, Any] | None]) -> Section:
    rows = [(name, *(_score(one[key]) for key in ("before", "after", "noise"))) for name, one in gap.items() if one]
    header = ("runs", "RMS before", "after", "noise")
    return Section(title="Before and after", tables=[Table(header=header, rows=rows)])


def _tell_value(p: Mapping[str, Any]) -> str:
    """Write a parameter with its error; no error that is far beyond the range, and then no value that is open."""
    lower, upper = p.get("lower"), p.get("upper")
    if p["std"] and lower is not None and upper is not None and says_nothing(p["std"], lower, upper):
        return "–" if p["status"] == "unidentifiable" else f"{p['value']:.6g}"
    return _with_std(p["value"], p["std"])


def _with_std(value: float, std: float | None) -> str:
    return with_error(value, std) if std else f"{value:.6g}"


def _ends(interval: Sequence[float]) -> str:
    return " … ".join(f"{end:.6g}" for end in interval)


def _score(value: float | Mapping[str, float] | None) -> str:
    """Return a score: one, or one by output; a dash where it is not finite."""
    if isinstance(value, Mapping):
        return ", ".join(f"{name} {_score(one)}" for name, one in value.items())
    return "–" if value is None else f"{value:.3g}"
