"""Entries of the ledger: a study enters before its first case is worked through, and never leaves.

``ledger.json`` holds one entry a study, in the order in which they came; the results lie in files beside it.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from haptid.support.errors import InputError
from haptid.support.files.files import read_json, write_json
from haptid.support.files.folder_lock import lock_folder
from studies.ledger.generator import ROOT

Entry = dict[str, Any]
SCHEMA = "ledger/1"
LEDGER = ROOT / "docs" / "results" / "ledger.json"
RESULTS = "blind"
"""Folder beside the ledger with one file a study."""
OWN = "own"
"""The truth of the project's own virtual device, where a plan names no other."""
STRANGER = "stranger"
"""The truth of a machine whose formulas are not the catalogue's."""


def read_ledger(path: Path = LEDGER) -> list[Entry]:
    """Return the entries in the order in which they came.

    Parameters
    ----------
    path
        The ledger.

    Returns
    -------
    list of dict
        Empty where there is no ledger yet.

    Raises
    ------
    InputError
        Where the file is no ledger.
    """
    if not path.exists():
        return []
    stored = read_json(path, "a ledger of studies", ("studies.ledger", "ledger.schema.json"))
    return list(stored["studies"])


def begin_study(path: Path, out: Path, plan: Mapping[str, Any], told: Mapping[str, Any]) -> str:
    """Enter a study, or go on with the one that this folder holds.

    Parameters
    ----------
    path
        The ledger.
    out
        Folder of the study; it keeps the name of the entry.
    plan
        What was asked for, without what only decides how fast it is done.
    told
        ``command``, ``date``, ``git``, ``code`` and ``generator``.

    Returns
    -------
    str
        Name of the entry.

    Raises
    ------
    InputError
        Where the ledger cannot be read, written or locked.
    """
    note = out / "entry.json"
    before = str(json.loads(note.read_text(encoding="utf-8"))["id"]) if note.exists() else ""
    with lock_folder(path.parent):
        studies = read_ledger(path)
        for entry in studies:
            if entry["id"] == before and (entry["plan"], entry["code"]) == (dict(plan), told["code"]):
                entry["given_again"] = [*entry.get("given_again", []), {k: told[k] for k in ("command", "date", "git")}]
                write_ledger(path, studies)
                return before
        name = add_entry(studies, plan, told, {"entered": "before", "outcome": "begun"})
        write_ledger(path, studies)
    write_json(note, {"id": name})
    return name


def add_entry(studies: list[Entry], plan: Mapping[str, Any], told: Mapping[str, Any], state: Mapping[str, Any]) -> str:
    """Append an entry under a name of its own, in the series of its generator.

    Parameters
    ----------
    studies
        Entries, which get one more.
    plan
        What was asked for.
    told
        ``command``, ``date``, ``git``, ``code`` and ``generator``; None where it is not known.
    state
        ``entered`` and ``outcome``, and what else is known.

    Returns
    -------
    str
        Name of the entry: seed and digest of the code.
    """
    name = f"{plan['seed']}-{told['code'] or told['git'] or 'unknown'}"
    taken = sum(entry["id"] == name or entry["id"].startswith(f"{name}-") for entry in studies)
    name = f"{name}-{taken + 1}" if taken else name
    series = series_of(studies, told["generator"])
    studies.append({"id": name, "truth": plan.get("truth", OWN), "series": series, **told, "plan": dict(plan), **state})
    return name


def series_of(studies: Sequence[Entry], generator: str | None) -> int | None:
    """Return the number of a generator's series: a generator that is new in the ledger begins one.

    Parameters
    ----------
    studies
        Entries so far.
    generator
        Digest of the generator.

    Returns
    -------
    int or None
        Number from 1; None where the generator is not known.
    """
    if generator is None:
        return None
    known = {entry["generator"]: entry["series"] for entry in studies if entry["generator"] is not None}
    return int(known.get(generator, len(known) + 1))


def end_study(path: Path, name: str, study: Mapping[str, Any], *, complete: bool) -> None:
    """Store what a study worked through, and say in its entry how it ended.

    Parameters
    ----------
    path
        The ledger.
    name
        Name of the entry.
    study
        Content of the study's JSON.
    complete
        Whether all cases of all passes were worked through.

    Raises
    ------
    InputError
        Where the ledger lacks the entry, the study has fewer cases than before, or the ledger cannot be read, written
        or locked.
    """
    with lock_folder(path.parent):
        studies = read_ledger(path)
        entry = next((entry for entry in studies if entry["id"] == name), None)
        if entry is None:
            todo = "restore it: no study leaves the ledger"
            raise InputError(str(path), expected=f"the entry {name}", got="none", todo=todo)
        before = entry.get("worked_through", 0)
        if study["worked_through"] < before:
            where, got = f"the study {name}", f"{study['worked_through']}"
            todo = "keep the folder of a study, or choose another --out"
            raise InputError(where, expected=f"the {before} cases that it had", got=got, todo=todo)
        entry |= state_of(name, study, complete=complete)
        write_json(path.parent / entry["file"], dict(study))
        write_ledger(path, studies)


def state_of(name: str, study: Mapping[str, Any], *, complete: bool) -> Entry:
    """Return the part of an entry that tells how its study ended.

    Parameters
    ----------
    name
        Name of the entry.
    study
        Content of the study's JSON.
    complete
        Whether all cases of all passes were worked through.

    Returns
    -------
    dict
        ``outcome``, ``worked_through`` and ``file``.
    """
    return {
        "outcome": "complete" if complete else "interrupted",
        "worked_through": study["worked_through"],
        "file": f"{RESULTS}/{name}.json",
    }


def write_ledger(path: Path, studies: Sequence[Entry]) -> None:
    """Write the ledger whole or not at all.

    Parameters
    ----------
    path
        The ledger.
    studies
        Its entries.

    Raises
    ------
    InputError
        Where it cannot be written.
    """
    write_json(path, {"schema": SCHEMA, "studies": list(studies)})
