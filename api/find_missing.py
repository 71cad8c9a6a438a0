"""Find what is missing, for Python and for the command: campaign and choices in, `Missing` and its files out."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import get_args

from haptid.api.arguments import check_choice, check_workers, joints_of, only_one
from haptid.api.missing import Missing, write_report
from haptid.api.place import Place
from haptid.discrepancy.finding.drawn import SUFFIX, Drawn
from haptid.discrepancy.job.job import MOST_EFFORT, MOST_STARTS, Job, catalogue_without
from haptid.discrepancy.job.search import (
    Prepared,
    SearchByPosition,
    SearchByTorque,
    prepare_alone,
    prepare_together,
)
from haptid.discrepancy.job.summary import finding_json
from haptid.fmu_build.building.packaging import Kind
from haptid.measurement.checks.motion import in_first_postures
from haptid.measurement.values.campaign import Campaign as Values
from haptid.support.files.files import write_json
from haptid.support.listener import Listener


def find_values(  # noqa: PLR0913 # one argument a choice
    values: Values,
    joint: int | Sequence[int] | None,
    place: Place,
    listener: Listener,
    *,
    without: Sequence[str],
    own_effects: Path | None = None,
    kind: Kind = "python",
    seed: int,
    starts: int = MOST_STARTS,
    effort: int = MOST_EFFORT,
    workers: int,
) -> Missing:
    """Find what is missing in a joint's model.

    Parameters
    ----------
    values
        Campaign that is ready for fits.
    joint, without, own_effects, kind, seed, starts, effort, workers
        As `Campaign.find_missing` takes them.
    place
        Folder of the results, perhaps with those of an identification.
    listener
        Told of each step.

    Returns
    -------
    Missing

    Raises
    ------
    InputError, NumericalError
        As `Campaign.find_missing`.
    """
    joints = joints_of("joint", joint)
    check_choice("kind", kind, get_args(Kind))
    check_workers(workers)
    values = in_first_postures(values)
    job = Job(
        campaign=values, catalogue=catalogue_without(without, own_effects), out=place.path, kind=kind, seed=seed,
        starts=starts, effort=effort, threads=workers,
    )  # fmt: skip
    if joints is None or not isinstance(joint, Iterable):
        number = only_one(None if joints is None else joints[0], values.joints)
        return carry_out(prepare_alone(job, number), place, listener)
    return carry_out(prepare_together(job, tuple(sorted(joints))), place, listener)


def carry_out(search: Prepared, place: Place, listener: Listener) -> Missing:
    """Carry out a search; its JSON, and the FMU with what it names, are written into the folder.

    Parameters
    ----------
    search
        Prepared search.
    place
        Folder of the results.
    listener
        Told of each step.

    Returns
    -------
    Missing

    Raises
    ------
    NumericalError
        As `Campaign.find_missing`.
    """
    job = search.job
    remark = search.remark if isinstance(search, SearchByPosition) else ""
    if remark:
        listener.note(remark)

    def tell(title: str, done: float = 0, total: int | None = None, figures: str = "") -> None:
        listener.progress(f"{search.title}: {title}", done, total, figures)

    finding = search.find(tell)
    data = finding_json(finding, measured=job.campaign.measured, seed=job.seed)
    made = Missing(
        finding=finding, data=data, name=search.name, title=search.title, place=place, values=job.campaign,
        remark=remark, left_out="" if isinstance(search, SearchByTorque) else search.left_out,
    )  # fmt: skip
    write_json(made.file, data)
    Drawn.of(finding).save(made.file.with_suffix(SUFFIX))
    if not place.temporary:
        write_report(made)
    return made
