"""Identify a campaign, for Python and for the command: campaign and choices in, `Identified` and its files out."""

from __future__ import annotations

from haptid.api.arguments import check_workers
from haptid.api.earlier_results import later_results, of_other_data
from haptid.api.identified import Identified
from haptid.api.place import Place
from haptid.fmu_build.building.packaging import Kind
from haptid.identification.job.identify import identify
from haptid.identification.job.job import Job
from haptid.identification.problem.options import FitOptions
from haptid.identification.sequence.configurations import configurations_of
from haptid.identification.sequence.resume import data_digest
from haptid.identification.sequence.step import Step
from haptid.measurement.format.devices import device_of
from haptid.measurement.values.campaign import Campaign as Values
from haptid.report.identification.drawings import Drawings
from haptid.support.listener import Listener

MOST_DRAWN_AT_THE_END = 2
"""Most configurations that are drawn in this process at the end: another one starts as slowly as it draws two."""


def identify_values(  # noqa: PLR0913 # one argument a choice
    values: Values,
    place: Place,
    listener: Listener,
    drawings: Drawings,
    *,
    joints: tuple[int, ...] | None,
    kind: Kind | None,
    options: FitOptions,
    scheduler: str | None,
    made_by: str,
) -> Identified:
    """Identify a campaign; ``identification.json`` and draws are written into the folder.

    Parameters
    ----------
    values
        Campaign that is ready for fits.
    place
        Folder of the results.
    listener
        Told of remarks and of each configuration.
    drawings
        Where the report's drawings of finished configurations begin.
    joints, kind, options, scheduler
        As `Campaign.identify` takes them.
    made_by
        Command or call, for the reader of the results.

    Returns
    -------
    Identified

    Raises
    ------
    InputError, NumericalError
        As `Campaign.identify`.
    """
    check_workers(options.workers)
    device = device_of(values)
    job = Job(
        campaign=values,
        device=device,
        configurations=configurations_of(values, device, joints),
        options=options,
        kind=kind,
        out=place.path,
        scheduler=scheduler,
        made_by=made_by,
    )
    _tell_other_data(job, listener)
    many = len(job.configurations) > MOST_DRAWN_AT_THE_END

    def finished(step: Step) -> None:
        if many:
            drawings.begin(step, job.build)

    made = identify(job, listener, finished)
    return Identified(data=made.data, place=place, values=values, steps=made.steps, made=made)


def _tell_other_data(job: Job, listener: Listener) -> None:
    """Tell of posteriors and findings in the folder that are not of what is identified now: nothing removes them."""
    if not later_results(job.out):
        return  # a digest reads every row of the campaign
    digests: dict[tuple[int, ...], set[str]] = {}
    for one in job.configurations:
        digests.setdefault(one.free_joints, set()).add(data_digest(job.campaign, job.device, one))
    known = {joints: frozenset(of_joints) for joints, of_joints in digests.items()}
    beside = of_other_data(job.out, job.campaign.title, known)
    if beside:
        names, verb = ", ".join(beside), "is" if len(beside) == 1 else "are"
        todo = "make them again by haptid posterior and haptid missing, or choose another --out"
        listener.note(f"warning: {job.out}: {names} {verb} of other data or of another version of haptid; {todo}")
