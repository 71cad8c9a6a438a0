"""Cases of a plan as files: campaigns below ``cases``, and the answers in ``labels.json``."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, TypeVar

from haptid.support.files.files import write_json
from haptid.support.processes.pool import Pool

C = TypeVar("C")
Label = dict[str, Any]


def write_cases(
    out: Path, seed: int, cases: Sequence[C], write: Callable[[Path, C, Sequence[int]], Label], *, series: int,
    workers: int,
) -> list[Label]:  # fmt: skip
    """Write the campaign of every case of a plan, and all labels.

    Parameters
    ----------
    out
        Folder of the study.
    seed
        Seed of all random draws.
    cases
        What is hidden in each.
    write
        Function from the folder of a campaign, its case and the numbers that fix its draws to its label; picklable
        where several processes write.
    series
        Number of the truth among the seeds, so that no two truths share draws.
    workers
        Processes; the cases do not depend on it.

    Returns
    -------
    list of dict
        The labels, in the order of the cases.

    Raises
    ------
    NumericalError
        Where a case cannot be made.
    """
    jobs = [(out / "cases" / f"case_{k:04d}", case, (seed, series, k)) for k, case in enumerate(cases)]
    if workers == 1:
        labels = [write(*job) for job in jobs]
    else:
        with Pool(workers) as pool:
            labels = [each.result() for each in [pool.submit(write, *job) for job in jobs]]
    write_json(out / "labels.json", {"schema": "blind_labels/1", "seed": seed, "labels": labels})
    return labels
