"""``haptid doctor``: the installation examined, one check after the other, each with its remedy.

What a check needs is imported within it: an import that fails is a finding, and must not end the command.
"""

from __future__ import annotations

import os
import platform
import shutil
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import click

from haptid.support.declaring.declaration import IncompleteError
from haptid.support.errors import one_line, shorten
from haptid.support.files.cache import VARIABLE, cache_folder
from haptid.support.installing.environment import in_clone, missing
from haptid.support.tables import Table
from haptid.support.terminal import Count, is_terminal, show

OLDEST_PYTHON = (3, 11)
LEAST_FREE_BYTES = 1_000_000_000
"""Free space of the cache's disk below which a campaign may fill it; kernels and FMUs of one device take a tenth."""
EXTRAS = {
    "posterior": "haptid posterior",
    "parquet": "Parquet tables",
    "mcap": "rosbags in MCAP",
    "rosbags": "rosbags of ROS 1, and of ROS 2 in SQLite",
    "matlab": "MATLAB files of version 7.3",
    "cluster": "--scheduler",
    "suggest": "formulas suggested for what is unnamed",
}
"""Optional extras, and what needs each."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Check:
    """Result of one check.

    Parameters
    ----------
    name
        What was checked.
    status
        ``OK``, ``PROBLEM``, or ``absent`` for an optional part.
    found
        What was found.
    todo
        What to do about it; empty where all is well.
    """

    name: str
    status: str
    found: str
    todo: str = ""


class CheckFailedError(Exception):
    """A check found a problem.

    Parameters
    ----------
    found
        What was found, one line.
    todo
        Remedy.
    """

    def __init__(self, found: str, todo: str) -> None:
        super().__init__(found)
        self.found, self.todo = found, todo


def examine() -> dict[str, Any]:
    """Do all checks and print a line for each.

    Returns
    -------
    dict
        Whether all is well, and the checks.

    Raises
    ------
    IncompleteError
        Where a check found a problem.
    """
    checks = []
    # A terminal gets one table at the end, and sees meanwhile what is done; a pipe gets each line as it comes.
    drawn = is_terminal(sys.stdout)
    with Count[None](title="checks", quiet=not drawn) as bar:
        for check in _checks():
            checks.append(check)
            bar.update(figures=check.name)
            if not drawn:
                todo = f": {check.todo}" if check.todo else ""
                click.echo(f"{check.status.ljust(8)} {check.name.ljust(10)} {check.found}{todo}")
    if drawn:
        rows = [(check.status, check.name, check.found, check.todo) for check in checks]
        show([Table(header=("", "check", "found", "what to do"), rows=rows)])
    problems = [check.name for check in checks if check.status == "PROBLEM"]
    result = {"ok": not problems, "checks": [asdict(check) for check in checks]}
    if problems:
        sentence = f"haptid doctor: {len(problems)} of {len(checks)} checks found a problem: {', '.join(problems)}"
        raise IncompleteError(sentence, result)
    return result


def _checks() -> Iterator[Check]:
    """Yield the checks in an order in which each needs those before it."""
    yield _attempt("Python", _python)
    packages = _attempt("packages", _packages)
    yield packages
    yield _attempt("compiler", _compiler)
    yield _attempt("cores", _cores)
    yield _attempt("cache", _cache)
    yield _attempt("disk", _disk)
    yield from (_extra(name, need) for name, need in EXTRAS.items())
    if packages.status == "OK":
        with _fresh_cache():
            yield _attempt("kernel", _kernel)
            yield _attempt("FMU", _fmu)


def _attempt(name: str, check: Callable[[], str]) -> Check:
    """Do one check; whatever ends it is its finding."""
    try:
        return Check(name=name, status="OK", found=check())
    except CheckFailedError as problem:
        return Check(name=name, status="PROBLEM", found=problem.found, todo=problem.todo)
    except Exception as error:
        found = shorten(one_line(f"{type(error).__name__}: {error}"), 200)
        return Check(name=name, status="PROBLEM", found=found, todo=f"repair it by `{_installation()}`")


def _installation() -> str:
    return "make fmu" if in_clone() else "pip install --force-reinstall haptid"


def _python() -> str:
    found = f"{platform.python_implementation()} {platform.python_version()} at {sys.executable}"
    if sys.version_info < OLDEST_PYTHON:
        raise CheckFailedError(found, f"use Python {'.'.join(map(str, OLDEST_PYTHON))} or newer")
    return found


def _packages() -> str:
    lacking = ", ".join(requirement.text for requirement in missing())
    if lacking:
        raise CheckFailedError("lacks " + lacking, f"run `{_installation()}`")
    return "all required ones are installed"


def _cores() -> str:
    cores = os.cpu_count() or 1
    usable = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else cores
    allowed = "" if usable == cores else f", of which this process may use {usable}"
    return f"{cores}{allowed}; --workers takes as many"


def _compiler() -> str:
    from haptid.support.processes.c_compiler import is_available  # noqa: PLC0415 (see the module)

    if not is_available():
        raise CheckFailedError("no C compiler: the package ziglang is absent or cannot run here", "pip install ziglang")
    from importlib.metadata import version  # noqa: PLC0415 (see the module)

    return f"ziglang {version('ziglang')}"


def _cache() -> str:
    stated = os.environ.get(VARIABLE)
    wanted = Path(stated) if stated else Path("~/.cache/haptid").expanduser()
    folder = cache_folder("doctor")
    if not folder.absolute().is_relative_to(wanted.absolute()):
        todo = f"let {VARIABLE} name a folder of your own that can be written; else every command compiles anew"
        raise CheckFailedError(str(wanted) + " cannot be used", todo)
    return f"{wanted} can be written"


def _disk() -> str:
    free = shutil.disk_usage(cache_folder("doctor")).free
    found = f"{free / 1e9:.1f} GB free where the cache lies"
    if free < LEAST_FREE_BYTES:
        raise CheckFailedError(found, f"free {LEAST_FREE_BYTES / 1e9:.0f} GB, or let {VARIABLE} name another disk")
    return found


def _extra(name: str, need: str) -> Check:
    lacking = [requirement.name for requirement in missing(extra=name)]
    if not lacking:
        return Check(name=name, status="OK", found=f"installed, for {need}")
    how = f"make {name}" if in_clone() and name != "suggest" else f"pip install 'haptid[{name}]'"
    found = f"optional, for {need}; lacks {', '.join(lacking)}"
    return Check(name=name, status="absent", found=found, todo=f"where you need it, run `{how}`")


@contextmanager
def _fresh_cache() -> Iterator[None]:
    """Let the cache be an empty folder within it, so that nothing is taken from an earlier day."""
    before = os.environ.get(VARIABLE)
    # Windows cannot delete a library that is loaded: then the folder stays until the cache is emptied.
    with tempfile.TemporaryDirectory(dir=cache_folder("doctor"), ignore_cleanup_errors=True) as folder:
        os.environ[VARIABLE] = folder
        try:
            yield
        finally:
            os.environ.pop(VARIABLE)
            if before is not None:
                os.environ[VARIABLE] = before


def _kernel() -> str:
    from haptid.model.joint.locked_joint import joint_equations  # noqa: PLC0415 (see the module)
    from haptid.model.kernel.cache import cached_kernel  # noqa: PLC0415 (see the module)

    begin = time.perf_counter()
    cached_kernel(joint_equations(0), many=False)
    return f"that of a joint was compiled and loaded in {time.perf_counter() - begin:.1f} s"


def _fmu() -> str:
    import fmpy  # noqa: PLC0415 (see the module)

    from haptid.fmu_build.building.cached import cached_fmu  # noqa: PLC0415 (see the module)
    from haptid.model.joint.locked_joint import joint_equations  # noqa: PLC0415 (see the module)

    begin = time.perf_counter()
    fmu = cached_fmu(joint_equations(0))
    rows = fmpy.simulate_fmu(str(fmu.path), stop_time=0.1, output_interval=0.01)
    return f"that of a joint was built, loaded and run for {len(rows)} rows in {time.perf_counter() - begin:.1f} s"
