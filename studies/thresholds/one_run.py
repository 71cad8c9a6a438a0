"""One run of one case in a process of its own: a change is made before any reader of thresholds is loaded."""

from __future__ import annotations

import multiprocessing
import signal
import sys
import time
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from importlib import import_module
from multiprocessing.connection import Connection
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from haptid.support.errors import HaptidError, one_line
from studies.thresholds.change import change_threshold, loaded_readers, noted_reads
from studies.thresholds.panel import Case
from studies.thresholds.values import Value

PRELOADED = (
    *("numpy", "pandas", "scipy.optimize", "scipy.stats", "scipy.signal", "sympy", "matplotlib.pyplot"),
    *("arviz", "emcee", "h5py", "fmpy", "pythonfmu", "jsonschema", "jinja2"),
)
"""Packages that read no threshold and take seconds to load."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Run:
    """A run of a case.

    Parameters
    ----------
    case
        Of the panel.
    campaign
        Its folder.
    room, name, value
        Threshold and its changed value; an empty room leaves all as delivered.
    note
        Whether the thresholds that are read are noted.
    """

    case: Case
    campaign: Path
    room: str = ""
    name: str = ""
    value: Value = 0
    note: bool = False

    def outcome(self) -> dict[str, Any]:
        """Work the case through in this process.

        Returns
        -------
        dict
            Outcome, and where asked ``read`` and ``read_as_loaded``: keys of thresholds.
        """
        if known := loaded_readers():
            return {"failed": f"{known[0]} was loaded before the change"}
        change: AbstractContextManager[None] = nullcontext()
        noting: AbstractContextManager[set[str]] = noted_reads() if self.note else nullcontext(set())
        if self.room:
            change = change_threshold(self.room, self.name, self.value)
        with change, noting as reads, TemporaryDirectory() as out:
            module, _, name = self.case.work.partition(":")
            try:
                work = getattr(import_module(module), name)
                as_loaded = sorted(reads)
                reads.clear()
                told = dict(work(self.campaign, Path(out), **self.case.given))
            except HaptidError as error:
                told, as_loaded = {"failed": one_line(str(error))}, []
            except Exception as error:  # a value may break what no input breaks: that is a result, too
                told, as_loaded = {"failed": one_line(f"{type(error).__name__}: {error}")}, []
            noted = {"read": sorted(reads), "read_as_loaded": sorted(set(as_loaded) - reads)} if self.note else {}
        return told | noted


def run_apart(run: Run, limit_s: float) -> dict[str, Any]:
    """Run a case in a new process.

    Parameters
    ----------
    run
        Case and change.
    limit_s
        Longest duration [s].

    Returns
    -------
    dict
        Outcome with ``wall_s``; ``failed`` says why there is none.
    """
    context = _context()
    receiver, sender = context.Pipe(duplex=False)
    process = context.Process(target=_send, args=(sender, run), daemon=True)
    began = time.perf_counter()
    process.start()
    sender.close()
    try:
        told = dict(receiver.recv()) if receiver.poll(limit_s) else {"failed": f"not finished within {limit_s:g} s"}
    except EOFError:
        told = {"failed": "the process ended without a result"}
    finally:
        process.kill()
        process.join()
        receiver.close()
    return told | {"wall_s": round(time.perf_counter() - began, 2)}


def end_runs() -> None:
    """End all runs, which then fail."""
    for process in multiprocessing.active_children():
        process.kill()


def _context() -> Any:
    """Return how processes begin: from one that has loaded the large packages and no reader of thresholds."""
    if sys.platform == "win32":
        return multiprocessing.get_context("spawn")
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(list(PRELOADED))
    return context


def _send(sender: Connection, run: Run) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent ends this process
    # BLAS on one thread: sums then have the same bits in every run.
    from haptid.support.processes.threads import single_threaded  # noqa: PLC0415 (after the packages are loaded)

    sender.send(single_threaded(run.outcome))
    sender.close()
