"""Page and picture of a blind study, beside its JSON: ``python -m studies.blind.page blind/blind.json``."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from haptid.report.common.style import png
from haptid.support.command import exit_codes
from haptid.support.errors import InputError
from haptid.support.files.files import read_json, write_bytes, write_text
from studies.blind.outcome import RIGHT
from studies.blind.picture import confusion_picture
from studies.blind.stranger_page import SAID, count_kinds, describe_cases

Row = dict[str, Any]
SIZES_SAID = (
    "Sizes: `nominal` moves the joint by 1 to 5 % of its motion and leaves at least twice the noise after a refit; "
    "`threshold` leaves 0.1 to 0.3 of the noise; `small` is their geometric mean.\n"
)


@click.command(help=__doc__)
@click.argument("path", type=click.Path(path_type=Path, dir_okay=False))
@exit_codes
def main(path: Path) -> None:
    """Write the page and its picture, and print the summary."""
    study = read_json(path, "the blind.json of a study", ("studies.blind", "blind.schema.json"))
    picture = path.with_suffix(".png")
    drawn, page = png(confusion_picture(study["confusion"], study["confusion_leave_one_out"])), ""
    try:
        page = blind_page(study, picture.name) + _stranger_part(path, study)
    except (KeyError, TypeError, ValueError, AttributeError) as error:  # nested figures: the page asks for each by name
        got = f"{type(error).__name__}: {error}"
        raise InputError(str(path), expected="all figures of a blind study", got=got) from None
    write_bytes(picture, drawn)
    write_text(path.with_suffix(".md"), page)
    click.echo("\n".join(headlines(study)))
    click.echo(f"written: {path}, {path.with_suffix('.md').name}, {picture.name}")


def share(row: Row) -> str:
    """Write a rate with its interval.

    Parameters
    ----------
    row
        ``hits``, ``n``, ``share``, ``low`` and ``high``, as `rate` of `studies.blind.score` returns them.

    Returns
    -------
    str
        Shares in percent; ``no case`` where n is 0.

    Examples
    --------
    >>> share({"hits": 9, "n": 10, "share": 0.9, "low": 0.596, "high": 0.982})
    '9 of 10 (90 %; 60 to 98.2 %)'
    """
    if not row["n"]:
        return "no case"
    return (
        f"{row['hits']} of {row['n']} ({_percent(row['share'])} %; {_percent(row['low'])} to {_percent(row['high'])} %)"
    )


def _percent(x: float) -> str:
    """Write a share in percent, with a digit more near 0 and 1, so that a few cases of many still show."""
    near = 0.0 < x < 0.1 or 0.9 < x < 1.0
    return f"{100 * x:.1f}" if near else f"{100 * x:.0f}"


def headlines(study: Row) -> list[str]:
    """Return the figures in one line each.

    Parameters
    ----------
    study
        Content of the study's JSON.

    Returns
    -------
    list of str
        Sentences.
    """
    alarms, outside, left = study["false_alarms"], study["outside_the_catalogue"], study["leave_one_out"]
    settled, closed, cover = study["settled_by_one_run"], study["gap_closed_on_unseen_runs"], study["coverage"]["all"]
    wall, runs = study["wall_s_per_joint"], study["simulations_per_joint"]
    return [
        f"Right verdicts: {share(study['right'])}.",
        f"False alarms where nothing is hidden: {share(alarms['all'])}; with correlated noise "
        f"{share(alarms['correlated_noise'])}; more found than a lone scatter {share(alarms['beside_scatter'])}.",
        f"Disturbances outside the catalogue: flagged {share(outside['flagged'])}, confident wrong names "
        f"{share(outside['confident_wrong_name'])}.",
        f"The true entry left out of the catalogue: flagged {share(left['flagged'])}, confident wrong names "
        f"{share(left['confident_wrong_name'])}, nothing found {share(left['missed'])}.",
        f"Ambiguous verdicts: {settled['ambiguous']}, {settled['proposed']} of them with a run that should tell; named "
        f"exactly once it was made: {share(settled['settled'])}; wrongly: {share(settled['settled_wrongly'])}.",
        f"Gap closed on unseen runs where named exactly: median {_number(closed['median'])} (n = {closed['n']}).",
        f"95 % intervals of the effects' own parameters that hold the truth: {share(cover)}.",
        f"A joint takes {_number(wall['median'])} s (median; nine in ten within {_number(wall['p90'])} s) and "
        f"{_number(runs['median'])} simulations of a run.",
    ]


def _number(x: float | None) -> str:
    return "–" if x is None else f"{x:.4g}"


def blind_page(study: Row, picture: str) -> str:
    """Return the page as Markdown.

    Parameters
    ----------
    study
        Content of the study's JSON.
    picture
        File name of the confusion matrix, to which the page links.

    Returns
    -------
    str
        Markdown.
    """
    parts = [
        "# Blind study of the search for missing effects\n",
        "A virtual device, with formulas and integrator of its own, hides effects in campaigns; the search sees the "
        "campaigns, the scorer alone the labels.\n",
        f"`{study['command']}`, {study['date']}, version {study['git']}, {study['machine']}, "
        f"{study['workers']} workers; {study['worked_through']} of "
        f"{study['asked']['cases']} cases worked through. Intervals are Wilson's, 95 %.\n",
        *([f"{study['note']}\n"] if "note" in study else []),
        *(f"- {line}" for line in headlines(study)),
        "\n## By kind and size\n",
        _table(
            ("kind", "size", "right verdict", "named exactly, or nothing rightly"),
            [(r["kind"], r["size"], share(r["right"]), share(r["exact"])) for r in study["by_kind_and_size"]],
        ),
        SAID if study["asked"].get("truth") == "stranger" else SIZES_SAID,
        "## Results\n",
        _table(
            ("result", "cases", "meaning"),
            [(r, str(study["results"].get(r, 0)), meaning) for r, meaning in study["meaning"].items()],
        ),
        "## What was taken for what\n",
        f"![rows: what was hidden; columns: the verdict]({picture})\n",
        "## Verdicts that were not right\n",
        _table(("case", "hidden", "size", "joint", "verdict"), [_wrong(c, study) for c in _not_right(study["cases"])]),
        "## Without the true entry: confident wrong names\n",
        _table(
            ("case", "hidden", "size", "joint", "verdict"),
            [_wrong(c, study) for c in study["leave_one_out_cases"] if c["verdict"] == "named"],
        ),
        "## Coverage by parameter\n",
        _table(
            ("parameter", "intervals that hold the truth"),
            [(name, share(row)) for name, row in study["coverage"]["parameters"].items()],
        ),
    ]
    return "\n".join(parts)


def _stranger_part(path: Path, study: Row) -> str:
    """Return the tables of a study of the stranger, whose labels stand beside it."""
    beside = path.with_name(f"{path.stem}_labels.json")
    if study["asked"].get("truth") != "stranger" or not beside.exists():
        return ""
    labels = read_json(beside, "the labels of a blind study", ("studies.hidden", "labels.schema.json"))["labels"]
    kinds, cases = count_kinds(study["cases"], labels), describe_cases(study["cases"], labels)
    return "\n".join(["\n## By what was hidden\n", _table(*kinds), "## All cases\n", _table(*cases)])


def _not_right(cases: list[Row]) -> list[Row]:
    return [c for c in cases if c["result"] not in RIGHT]


def _wrong(case: Row, study: Row) -> tuple[str, ...]:
    hidden = ", ".join(case.get("truth", ())) or "nothing"
    told = ", ".join(case.get("names", ()))
    verdict = f"{case['verdict']} {told}".strip() + (f" ({case['reason']})" if "reason" in case else "")
    return case["case"], hidden, case["size"], str(case["joint"]), f"{verdict}: {study['meaning'][case['result']]}"


def _table(header: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    if not rows:
        return "None.\n"
    lines = [header, ("---",) * len(header), *rows]
    return "\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in lines) + "\n"


if __name__ == "__main__":
    main()
