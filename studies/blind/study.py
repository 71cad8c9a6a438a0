"""The cases of a blind study on disk: made by one program, worked through by another, both behind their command lines.

``OUT/study.json`` says what was asked for, ``OUT/cases`` holds the campaigns, ``OUT/labels.json`` the answers, which
nothing here opens, and ``OUT/found/<case>`` what ``python -m discrepancy.run`` made of a campaign.
"""

from __future__ import annotations

import hashlib
import json
import math
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed, wait
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from haptid.support.errors import InputError, NumericalError
from haptid.support.files.files import write_json
from haptid.support.interrupts import INTERRUPTED, TERMINATED
from haptid.support.processes.running import Running

ROOT = Path(__file__).parents[2]
PACKAGES = ("discrepancy", "fmu_build", "identification", "measurement", "model", "noise", "report", "support")
MAKER = ("virtual_device", "studies", "support")
STAMP, FAILED = "stamp.json", "failed.json"
EVERY = 0.5
"""Time [s] between two looks at how many cases are made."""
STOPPED = (INTERRUPTED, TERMINATED, -signal.SIGINT, -signal.SIGTERM)
"""Exit codes of a workflow that somebody stopped."""
LONGEST_WAIT = 4.0
"""Longest duration of a workflow, as a multiple of its longest processor time: one that hangs takes none."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Job:
    """One campaign to be worked through.

    Parameters
    ----------
    case
        Name of the case.
    campaign, out
        Folders of the campaign and of the results.
    without
        Ids of effects that are left out of the catalogue.
    """

    case: str
    campaign: Path
    out: Path
    without: tuple[str, ...] = ()

    def command(self, seed: int, threads: int) -> list[str]:
        """Return the command line of the workflow: it gets the campaign, and no more.

        Parameters
        ----------
        seed
            Seed of the workflow.
        threads
            Number of its workers.

        Returns
        -------
        list of str
            Program and arguments.
        """
        left_out = ["--without", ",".join(self.without)] if self.without else []
        return [
            sys.executable, "-m", "discrepancy.run", str(self.campaign), "--out", str(self.out), "--seed", str(seed),
            "--workers", str(threads), "--quiet", *left_out,
        ]  # fmt: skip

    def result(self) -> dict[str, Any] | None:
        """Read the finding.

        Returns
        -------
        dict or None
            Content of ``discrepancy/joint<j>.json``; None where there is none.
        """
        for path in sorted((self.out / "discrepancy").glob("joint*.json")):
            return dict(json.loads(path.read_text(encoding="utf-8")))
        return None

    def failure(self) -> str | None:
        """Read why there is no finding.

        Returns
        -------
        str or None
            One line; None where the job has not failed.
        """
        path = self.out / FAILED
        return str(json.loads(path.read_text(encoding="utf-8"))["reason"]) if path.exists() else None


def digest(packages: Sequence[str] = PACKAGES) -> str:
    """Return twelve hex digits of the code of some packages, the blind study itself left out.

    Parameters
    ----------
    packages
        Names of top-level packages.

    Returns
    -------
    str
        Start of the SHA-256 of their paths and content.
    """
    found = hashlib.sha256()
    for package in packages:
        for path in sorted((ROOT / package).rglob("*")):
            if path.suffix in (".py", ".c", ".h", ".toml") and not path.name.startswith("blind"):
                found.update(path.relative_to(ROOT).as_posix().encode() + path.read_bytes())
    return found.hexdigest()[:12]


def make(
    out: Path, asked: dict[str, Any], workers: int, tell: Callable[[int], None] = lambda _: None
) -> tuple[str, ...]:
    """Make the cases unless they are there.

    Parameters
    ----------
    out
        Folder of the study.
    asked
        Options of `studies.hidden.run` by name; empty ones are left out.
    workers
        Number of processes that make cases.
    tell
        Called with the number of cases that are there so far.

    Returns
    -------
    tuple of str
        Names of the cases in alphabetical order.

    Raises
    ------
    InputError
        Where the folder holds another study, or the cases that are asked for cannot be made.
    NumericalError
        Where making the cases fails.
    """
    path, wanted = out / "study.json", {**asked, "maker": digest(MAKER)}
    if path.exists():
        if json.loads(path.read_text(encoding="utf-8")) != wanted:
            todo = "choose another --out, or remove that folder"
            raise InputError(str(path), expected="the study that is asked for", got="another one", todo=todo)
    else:
        options = [f"--{name}={value}" for name, value in asked.items() if value != ""]
        command = ["studies.hidden.run", "--out", str(out), *options, "--workers", str(workers)]
        code, said = _make_cases([sys.executable, "-m", *command], out / "cases", tell)
        if code == InputError.exit_code:
            raise InputError("the cases", expected="what can be made", got=last_line(said))
        if code:
            msg = f"making the cases: {last_line(said)}"
            raise NumericalError(msg)
        write_json(path, wanted)
    return tuple(sorted(p.name for p in (out / "cases").iterdir()))


def _make_cases(command: Sequence[str], cases: Path, tell: Callable[[int], None]) -> tuple[int, str]:
    """Run the program that makes the cases; return its exit code and what it said."""
    running = Running()
    with ThreadPoolExecutor(1) as pool:
        try:
            making = pool.submit(running.run, command, cwd=ROOT)
            while wait([making], timeout=EVERY).not_done:
                tell(count_cases(cases))
        except BaseException:
            running.end()
            raise
    tell(count_cases(cases))
    return making.result()


def count_cases(cases: Path) -> int:
    """Count the cases that are written below a folder.

    Parameters
    ----------
    cases
        Folder with a folder for each case.

    Returns
    -------
    int
        Number of folders with a ``campaign.toml``.
    """
    return len(list(cases.glob("*/campaign.toml")))


def last_line(text: str) -> str:
    """Return the last line that says something.

    Parameters
    ----------
    text
        What a command wrote.

    Returns
    -------
    str
        Stripped line; ``no message`` where all are blank.
    """
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    return lines[-1] if lines else "no message"


def has_result_of(job: Job, stamp: str) -> bool:
    """Say whether the result of the same code is there.

    Parameters
    ----------
    job
        Job.
    stamp
        Digest of the code.

    Returns
    -------
    bool
        False where the job has no stamp, or that of other code.
    """
    done = job.out / STAMP
    return done.exists() and json.loads(done.read_text(encoding="utf-8"))["code"] == stamp


def limited(command: Sequence[str], seconds: float) -> list[str]:
    """Let the system end a command after some processor time, which hardly depends on what else a machine does.

    Parameters
    ----------
    command
        Program and arguments.
    seconds
        Processor time of all its threads [s]; the system counts whole seconds.

    Returns
    -------
    list of str
        Program and arguments, for a POSIX shell; the command ends by SIGXCPU.
    """
    return ["sh", "-c", f'ulimit -S -t {math.ceil(seconds)}; exec "$@"', "sh", *command]


def work(job: Job, running: Running, *, seed: int, limit: float, stamp: str, threads: int) -> None:
    """Run the workflow on one campaign, in place of any result that is there.

    A failure is kept as such; what was stopped is not, and is begun again.

    Parameters
    ----------
    job
        Campaign, and the folder of the result.
    running
        Commands that run at the moment, so that all can be ended.
    seed
        Seed of the workflow.
    limit
        Longest processor time [s].
    stamp
        Digest of the code, kept beside the result.
    threads
        Threads of the workflow.
    """
    done = job.out / STAMP
    for old in (done, job.out / FAILED, *(job.out / "discrepancy").glob("joint*.json")):
        old.unlink(missing_ok=True)
    began, reason = time.perf_counter(), ""
    environment = {**os.environ, "OMP_NUM_THREADS": str(threads), "OPENBLAS_NUM_THREADS": str(threads)}
    try:
        command = limited(job.command(seed, threads), limit)
        code, said = running.run(command, cwd=ROOT, env=environment, limit=LONGEST_WAIT * limit)
        if code in STOPPED:
            return
        if code == -signal.SIGXCPU:
            reason = f"not finished within {limit:g} s of processor time"
        else:
            reason = "" if code == 0 else f"exit code {code}: {last_line(said)}"
    except subprocess.TimeoutExpired:
        reason = f"not finished within {LONGEST_WAIT * limit:g} s"
    if reason or job.result() is None:
        write_json(job.out / FAILED, {"reason": reason or "no result was written"})
    write_json(done, {"code": stamp, "command_wall_s": time.perf_counter() - began})


def work_all(
    jobs: Sequence[Job], *, seed: int, workers: int, limit: float, until: float, tell: Callable[[], None]
) -> tuple[Job, ...]:
    """Work through jobs in parallel; results of the same code that are there already count whatever the time.

    Parameters
    ----------
    jobs
        Jobs.
    seed
        Seed of each workflow.
    workers
        Number of jobs that run at the same time; they share the threads of this machine.
    limit
        Longest processor time of a job [s].
    until
        Time after which no job is begun [s], by `time.monotonic`.
    tell
        Called whenever a job is over.

    Returns
    -------
    tuple of Job
        Jobs that were done, in the order of their cases.
    """
    stamp, finished, running = digest(), [], Running()
    threads = max(1, (os.cpu_count() or 1) // workers)

    def one(job: Job) -> Job | None:
        if not has_result_of(job, stamp):
            if time.monotonic() > until:
                return None
            work(job, running, seed=seed, limit=limit, stamp=stamp, threads=threads)
        return job if has_result_of(job, stamp) else None

    pool = ThreadPoolExecutor(workers)
    try:
        for ended in as_completed([pool.submit(one, job) for job in jobs]):
            tell()
            if (job := ended.result()) is not None:
                finished.append(job)
    except BaseException:
        running.end()
        raise
    finally:
        pool.shutdown(wait=True, cancel_futures=True)
    return tuple(sorted(finished, key=lambda job: job.case))
