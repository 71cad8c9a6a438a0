"""Enter studies whose JSON is there already: ``python -m studies.evidence.enter STUDY.json …``.

Their entries say that they were made afterwards. What a study asked for is read from its command.
"""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import click

from haptid.support.command import exit_codes
from haptid.support.files.files import read_json, write_json
from haptid.support.files.folder_lock import lock_folder
from studies.ledger.entries import LEDGER, OWN, RESULTS, Entry, add_entry, read_ledger, state_of, write_ledger
from studies.ledger.generator import generator_at


@click.command(help=__doc__)
@click.argument("paths", nargs=-1, required=True, type=click.Path(path_type=Path, dir_okay=False))
@click.option("--ledger", type=click.Path(path_type=Path, dir_okay=False), default=LEDGER, show_default="docs/results")
@exit_codes
def main(paths: tuple[Path, ...], ledger: Path) -> None:
    """Enter each, and store its JSON beside the ledger."""
    with lock_folder(ledger.parent):
        studies = read_ledger(ledger)
        for path in paths:
            study = read_json(path, "the blind.json of a study", ("studies.blind", "blind.schema.json"))
            name = enter_afterwards(studies, study)
            write_json(ledger.parent / RESULTS / f"{name}.json", study)
            click.echo(f"{path}: entered as {name}")
        write_ledger(ledger, studies)


def enter_afterwards(studies: list[Entry], study: Mapping[str, Any]) -> str:
    """Append the entry of a study that has ended.

    Parameters
    ----------
    studies
        Entries, which get one more.
    study
        Content of the study's JSON.

    Returns
    -------
    str
        Name of the entry.
    """
    told = {key: study[key] for key in ("command", "date", "git", "code")}
    told["generator"] = generator_at(study["git"])
    name = add_entry(studies, plan_of(study), told, {"entered": "afterwards"})
    complete = study["worked_through"] == study["asked"]["cases"]
    studies[-1] |= state_of(name, study, complete=complete)
    return name


def plan_of(study: Mapping[str, Any]) -> dict[str, Any]:
    """Return the plan of a study: what it asked for, with the passes and the limit that its command names.

    Parameters
    ----------
    study
        ``asked`` and ``command`` of a study's JSON.

    Returns
    -------
    dict
        Plan as `studies.ledger.entries.begin_study` takes it.

    Examples
    --------
    >>> plan_of({"asked": {"seed": 1}, "command": "python -m studies.blind.run --no-settle --limit 300"})
    {'seed': 1, 'without': '', 'passes': ['found', 'without'], 'limit_s': 300.0}
    """
    words = shlex.split(study["command"])
    refused = {"found": "--no-whole", "without": "--no-leave-out", "settled": "--no-settle"}
    passes = [name for name, option in refused.items() if option not in words]
    if study["asked"].get("truth", OWN) != OWN:
        passes = [name for name in passes if name == "found"]  # the others know the formulas of the catalogue
    if "found" not in passes and "settled" in passes:
        passes.remove("settled")  # a proposed run follows a verdict with the whole catalogue
    limit = float(_option(words, "--limit", "1800"))
    return {**study["asked"], "without": _option(words, "--without", ""), "passes": passes, "limit_s": limit}


def _option(words: Sequence[str], name: str, default: str) -> str:
    for k, word in enumerate(words):
        if word == name:
            return words[k + 1]
        if word.startswith(f"{name}="):
            return word.partition("=")[2]
    return default


if __name__ == "__main__":
    main()
