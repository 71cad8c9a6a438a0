"""Page of the study of thresholds, from its JSON."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from studies.thresholds.outcome import RULES

Row = Mapping[str, Any]
COLUMNS = ("threshold", "what it is", "value", "halved: what changes", "doubled: what changes")


def page(stored: Row) -> str:
    """Write the page of the study.

    Parameters
    ----------
    stored
        Content of thresholds.json.

    Returns
    -------
    str
        Markdown.
    """
    parts = [
        "# What halving and doubling each threshold changes\n",
        f"`{stored['command']}`, {stored['date']}, code {stored['code']}, {stored['machine']}; {stored['workers']} run "
        f"at a time, {stored['wall_s'] / 60:.0f} minutes in all. All numbers: `thresholds.json` beside this page.\n",
        "Every threshold is halved and doubled alone, in each case of the panel that reads it. Counts are whole and at "
        "least 1; a share that would reach 1 goes half the way to 1; several numbers of one threshold are scaled "
        f"together. {RULES}\n",
        headline(stored) + "\n",
        _changing(stored),
        "## The panel\n",
        "Short runs of joints of the virtual device; searches have few entries of the catalogue. A threshold that "
        "changes nothing here may change something elsewhere.\n",
        _table(
            ("case", "what is done", "as delivered", "simulations", "s"), [_case(stored, c) for c in stored["panel"]]
        ),
        *(_room(stored, room) for room in dict.fromkeys(t["room"] for t in stored["thresholds"])),
    ]
    return "\n".join(parts)


def counts(stored: Row) -> dict[str, int]:
    """Count thresholds and runs.

    Parameters
    ----------
    stored
        Content of thresholds.json.

    Returns
    -------
    dict
        ``thresholds``; ``read`` by the panel; of these ``changing`` an outcome, ``costing`` the number of simulations
        alone, ``steady`` in all runs that are planned, and ``open``: steady so far; ``runs`` made and ``planned``.
    """
    keys = [_key(t) for t in stored["thresholds"]]
    read = [key for key in keys if _readers(stored, key)]
    changing = [key for key in read if any(run["differences"] for run in _runs(stored, key))]
    costing = [
        key for key in read if key not in changing and any(run["cost"] is not None for run in _runs(stored, key))
    ]
    rest = [key for key in read if key not in (*changing, *costing)]
    steady = [key for key in rest if len(_runs(stored, key)) == _count_planned(stored, key)]
    return {
        "thresholds": len(keys),
        "read": len(read),
        "changing": len(changing),
        "costing": len(costing),
        "steady": len(steady),
        "open": len(rest) - len(steady),
        "runs": sum(len(_runs(stored, key)) for key in keys),
        "planned": sum(_count_planned(stored, key) for key in keys),
    }


def headline(stored: Row) -> str:
    """Sum the study up.

    Parameters
    ----------
    stored
        Content of thresholds.json.

    Returns
    -------
    str
        Sentences with the counts of `counts`.
    """
    n = counts(stored)
    return (
        f"Of {n['thresholds']} thresholds the panel reads {n['read']}. {n['runs']} of {n['planned']} runs under a "
        f"change are made. {n['changing']} thresholds change an outcome in them; {n['costing']} others change the "
        f"number of simulations alone. {n['steady']} change neither and are run in all cases that read them; "
        f"{n['open']} have changed neither so far."
    )


def _changing(stored: Row) -> str:
    """List the thresholds that change an outcome."""
    told = []
    for t in stored["thresholds"]:
        runs = stored["changes"].get(_key(t), {})
        ways = [change for change, cases in runs.items() if any(run["differences"] for run in cases.values())]
        if ways:
            told.append(f"`{_key(t)}` ({' and '.join(ways)})")
    return f"They change an outcome: {', '.join(told)}.\n" if told else ""


def _case(stored: Row, case: Row) -> tuple[object, ...]:
    made = stored["delivered"].get(case["name"])
    if made is None:
        return case["name"], case["words"], "not run yet", "", ""
    names = ", ".join(made["names"]) if made["names"] and len(made["names"]) < 4 else ""
    told = made["verdict"] + (f": {names}" if names else "")
    return case["name"], case["words"], told, made["simulations"] or "", f"{made['wall_s']:.1f}"


def _room(stored: Row, room: str) -> str:
    rows = [
        (
            f"`{t['name']}`",
            t["meaning"],
            _value(t["value"]),
            *(_cell(stored, t, change) for change in ("halved", "doubled")),
        )
        for t in stored["thresholds"]
        if t["room"] == room
    ]
    return f"## {room}\n\n" + _table(COLUMNS, rows)


def _cell(stored: Row, threshold: Row, change: str) -> str:
    """Tell what a change of one threshold does in the cases that read it."""
    key = _key(threshold)
    readers = _readers(stored, key)
    if threshold[change] is None:
        return "the same value"
    if not readers:
        return "not read by the panel"
    runs = stored["changes"].get(key, {}).get(change, {})
    told = [
        f"*{case}*: {_word_run(run)}" for case, run in runs.items() if run["differences"] or run["cost"] is not None
    ]
    quiet = sum(not run["differences"] and run["cost"] is None for run in runs.values())
    if quiet:
        told.append(
            f"nothing in {quiet} of {len(readers)} cases" if told or quiet < len(readers) else f"nothing ({quiet})"
        )
    if missing := len(readers) - len(runs):
        told.append(f"{missing} not run yet")
    return "; ".join(told)


def _word_run(run: Row) -> str:
    told = [f"**{text}**" for text in run["differences"]]
    if run["cost"] is not None:
        told.append(f"{run['cost']:.2g} × the simulations")
    return ", ".join(told)


def _value(value: Any) -> str:
    if isinstance(value, list | tuple):
        return "(" + ", ".join(map(_value, value)) + ")"
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def _key(threshold: Row) -> str:
    return f"{threshold['room']}.{threshold['name']}"


def _readers(stored: Row, key: str) -> list[str]:
    """Return the cases that read a threshold."""
    return [name for name, made in stored["delivered"].items() if key in made["read"] or key in made["read_as_loaded"]]


def _count_planned(stored: Row, key: str) -> int:
    threshold = next(t for t in stored["thresholds"] if _key(t) == key)
    return len(_readers(stored, key)) * sum(threshold[change] is not None for change in ("halved", "doubled"))


def _runs(stored: Row, key: str) -> list[Row]:
    return [run for cases in stored["changes"].get(key, {}).values() for run in cases.values()]


def _table(header: tuple[str, ...], rows: list[tuple[object, ...]]) -> str:
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join("| " + " | ".join(str(c).replace("|", "\\|") for c in line) + " |" for line in lines) + "\n"
