"""With which version of the code a result was measured."""

from __future__ import annotations

import subprocess
from collections.abc import Mapping
from typing import Any

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
