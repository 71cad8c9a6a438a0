"""One revision on all cases: its commit in, the folder with the results of its commands out.

The results of a commit stay in the folder of work, so that a commit that stands in two pairs runs once.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from pathlib import Path

from benchmarks.revisions.cases import WRITERS, Case
from haptid.support.installing.environment import ROOT
from haptid.support.processes.running import Running

OUTCOME = "outcome.json"
"""File in the folder of a case: how its command ended, and its wall time."""
WRITE_WITH_OWN_CODE = (
    "import sys; from pathlib import Path; from benchmarks.machines import campaigns; "
    "getattr(campaigns, sys.argv[1])(Path(sys.argv[2]), Path(sys.argv[3]))"
)
"""Program that a revision with writers of its own makes its campaign by."""


def commit_of(revision: str) -> str:
    """Return the short hash of a revision."""
    asked = ["git", "rev-parse", "--short=8", revision]
    return subprocess.run(asked, cwd=ROOT, capture_output=True, text=True, check=True).stdout.strip()


def check_out(revision: str, tree: Path) -> None:
    """Clone the repository into ``tree`` at a revision; a tree that is there already stays."""
    if tree.is_dir():
        return
    subprocess.run(["git", "clone", "--quiet", str(ROOT), str(tree)], check=True)
    subprocess.run(["git", "checkout", "--quiet", revision], cwd=tree, check=True)


def environment_of(folder: Path, packages: Path | None) -> dict[str, str]:
    """Return the environment of commands of the revision below ``folder``: its own code, one thread, its own cache.

    Parameters
    ----------
    folder
        Folder of the revision, with its checkout in ``tree``.
    packages
        Folder with packages that the revision needs beside the present ones; None for none.
    """
    paths = [str(path) for path in (folder / "tree", packages) if path is not None]
    return {
        **os.environ,
        "HAPTID_CACHE": str(folder / "cache"),
        "PYTHONDONTWRITEBYTECODE": "1",
        "PYTHONPATH": os.pathsep.join(paths),
        "OMP_NUM_THREADS": "1",
    }


def make_campaign(name: str, data: Path, folder: Path, environment: dict[str, str]) -> Path:
    """Write the campaign of real measurements, with the revision's own code where that has a writer of it.

    Parameters
    ----------
    name
        Folder of the measurements below ``data``.
    data
        Folder of all real measurements.
    folder
        Folder of the revision.
    environment
        Environment of its commands.

    Returns
    -------
    Path
        Folder of the campaign. The present writers fill it where the revision has none.
    """
    out = folder / "campaigns" / name
    if (out / "campaign.toml").is_file():
        return out
    out.mkdir(parents=True, exist_ok=True)
    writer, tree = WRITERS[name], folder / "tree"
    if (tree / "benchmarks" / "machines" / "campaigns.py").is_file():
        arguments = [writer.__name__, str(data / name), str(out)]
        subprocess.run([sys.executable, "-c", WRITE_WITH_OWN_CODE, *arguments], cwd=tree, env=environment, check=True)
    else:
        writer(data / name, out)
    return out


def run_case(case: Case, data: Path, folder: Path, packages: Path | None) -> Path:
    """Run the command of a case with the revision below ``folder``, unless it ran there before.

    Parameters
    ----------
    case
        Campaign and command.
    data
        Folder of all real measurements.
    folder
        Folder of the revision, with its checkout in ``tree``.
    packages
        Folder with packages that the revision needs beside the present ones; None for none.

    Returns
    -------
    Path
        Folder with the results and with ``outcome.json``: ``outcome``, which is ``done`` or says why there is no
        result, and ``wall_s``.
    """
    out = folder / "results" / case.name
    if (out / OUTCOME).is_file():
        return out
    environment = environment_of(folder, packages)
    campaign = [str(make_campaign(case.campaign, data, folder, environment))] if case.real else []
    module, *options = case.command
    words = [sys.executable, "-m", module, *campaign, "--out", str(out), "--quiet", *options]
    began = time.perf_counter()
    try:
        code, errors = Running().run(words, cwd=folder / "tree", env=environment, limit=case.limit_s)
    except subprocess.TimeoutExpired:
        outcome = f"stopped after {case.limit_s:.0f} s"
    else:
        outcome = "done" if code == 0 else _last_line(errors)
    end = {"outcome": outcome, "wall_s": round(time.perf_counter() - began, 1)}
    out.mkdir(parents=True, exist_ok=True)
    (out / OUTCOME).write_text(json.dumps(end) + "\n", encoding="utf-8")
    return out


def _last_line(errors: str) -> str:
    lines = errors.strip().splitlines()
    return f"failed: {lines[-1].strip()}" if lines else "failed"
