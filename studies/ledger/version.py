"""When, on what and with which version of the code a result was measured."""

from __future__ import annotations

import datetime
import os
import platform
import subprocess
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from haptid.support.files.files import write_json, write_text
from studies.ledger.generator import ROOT


def git_version() -> str:
    """Describe the version of the code.

    Returns
    -------
    str
        As ``git describe`` says it, with ``-dirty`` after uncommitted changes; ``unknown`` outside a repository.
    """
    command = ["git", "describe", "--always", "--dirty"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    return done.stdout.strip() or "unknown"


def tell_version(stored: Mapping[str, Any]) -> str:
    """Say of which version stored results are.

    Parameters
    ----------
    stored
        Content of their JSON: ``git``, or ``stored_in``, the commit that brought them where they name no version.

    Returns
    -------
    str
        Words within a sentence.

    Examples
    --------
    >>> tell_version({"git": "abc1234"})
    'version abc1234'
    """
    if "git" in stored:
        return f"version {stored['git']}"
    if "stored_in" in stored:
        return f"stored in commit {stored['stored_in']}, its version not kept"
    return "version not kept"


def origin_of(command: str) -> dict[str, Any]:
    """Return what every stored result says of its origin.

    Parameters
    ----------
    command
        What made it.

    Returns
    -------
    dict
        ``command``, ``date`` (UTC), ``git`` as `git_version` says it, ``machine`` and ``load``, the mean number of
        processes that wanted to run in the last minute.
    """
    return {
        "command": command.strip(),
        "date": datetime.datetime.now(tz=datetime.UTC).date().isoformat(),
        "git": git_version(),
        "machine": f"{os.cpu_count()} cores, {platform.machine()}, Python {platform.python_version()}",
        "load": round(os.getloadavg()[0], 2),
    }


def tell_origin(stored: Mapping[str, Any]) -> str:
    """Say what `origin_of` returned.

    Parameters
    ----------
    stored
        Content of a JSON that holds it.

    Returns
    -------
    str
        One sentence of Markdown.
    """
    load = f", load {stored['load']:.1f} at the end" if "load" in stored else ""
    return f"`{stored['command'].strip()}`, {stored['date']}, {tell_version(stored)}, {stored['machine']}{load}."


def store(out: Path, stored: dict[str, Any], page: Callable[[dict[str, Any]], str]) -> str:
    """Write a result, and its page beside it.

    Parameters
    ----------
    out
        JSON file of the result; the page has its name and ends in ``.md``.
    stored
        The result.
    page
        Function that writes it as Markdown.

    Returns
    -------
    str
        The page.
    """
    text = page(stored)
    write_json(out, stored)
    write_text(out.with_suffix(".md"), text)
    return text
