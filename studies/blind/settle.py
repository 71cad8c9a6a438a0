"""Ambiguous cases with the proposed run made: the virtual device simulates it, the workflow starts afresh."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from haptid.support.errors import NumericalError
from haptid.support.files.files import write_json
from studies.blind.outcome import Outcome
from studies.blind.study import ROOT, Job, last_line


def with_run(out: Path, outcomes: Sequence[Outcome]) -> list[Job]:
    """Return the cases whose alternatives the proposed run would tell apart, that run in a copy of the campaign.

    Parameters
    ----------
    out
        Folder of the study.
    outcomes
        Scored cases.

    Returns
    -------
    list of Job
        A job for each ambiguous case with a proposed run that should tell.

    Raises
    ------
    NumericalError
        Where the virtual device cannot simulate the proposed run.
    """
    jobs = []
    for o in outcomes:
        first = Job(case=o.case, campaign=out / "cases" / o.case, out=out / "found" / o.case)
        if o.verdict == "ambiguous" and o.proposed and (found := first.result()) is not None:
            folder = out / "asked" / o.case
            _ask(out, o.case, found["next_experiment"], folder)
            jobs.append(Job(case=o.case, campaign=folder, out=out / "settled" / o.case, without=o.left_out))
    return jobs


def options_of(proposal: Mapping[str, Any]) -> list[str]:
    """Return the options of the virtual device for a ``next_experiment``.

    Parameters
    ----------
    proposal
        ``next_experiment`` of a finding, SI units.

    Returns
    -------
    list of str
        ``--<name>=<value>`` for each quantity that the proposal holds.
    """
    names = {
        "torque_amplitude_Nm": "amplitude",
        "frequency_rad_s": "frequency",
        "end_frequency_rad_s": "end-frequency",
        "torque_offset_Nm": "offset",
        "duration_s": "duration",
        "row_spacing_s": "spacing",
        "repeats": "repeats",
    }
    return [f"--{option}={proposal[name]!r}" for name, option in names.items() if name in proposal]


def _ask(out: Path, case: str, proposal: Mapping[str, Any], folder: Path) -> None:
    """Have the run simulated, unless that very run is there."""
    note = folder / "asked.json"
    if note.exists() and json.loads(note.read_text(encoding="utf-8")) == dict(proposal):
        return
    command = ["studies.hidden.run", "--out", str(out), "--extra", case, "--to", str(folder), *options_of(proposal)]
    done = subprocess.run([sys.executable, "-m", *command], cwd=ROOT, capture_output=True, text=True, check=False)
    if done.returncode:
        msg = f"simulating the proposed run of {case}: {last_line(done.stderr)}"
        raise NumericalError(msg)
    write_json(note, dict(proposal))
