"""Identify a device: `Job` in, `Identification` out.

1. Fit every configuration in locking order; what is finished is on disk after each.
2. Combine the fits to the whole device, and verify it on runs with all joints free.
3. Draw the parameters of every model, for its FMU.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sized
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from haptid.fmu_build.accuracy.draws import COUNT
from haptid.fmu_build.exchange.recorded_device import COPY_OF_DEVICE
from haptid.identification.job.ahead import Ahead, compilations_of
from haptid.identification.job.job import Identification, Job
from haptid.identification.job.provenance import provenance, word_this_command
from haptid.identification.output.written_draws import write_draws
from haptid.identification.sequence.result_json import SCHEMA, step_json
from haptid.identification.sequence.resume import code_digest, data_digest, inputs_digest, kept_entries
from haptid.identification.sequence.sequence import Sequence
from haptid.identification.sequence.step import Step
from haptid.identification.sequence.whole_device import Whole, whole_device
from haptid.identification.thresholds import THRESHOLDS
from haptid.identification.verification.result import Verification
from haptid.identification.verification.verify import verify
from haptid.identification.workers.chosen_workers import workers_of
from haptid.measurement.checks.preparation import tell_remarks
from haptid.measurement.format.devices import SUFFIXES
from haptid.support.files.files import is_file, write_bytes, write_json
from haptid.support.listener import Listener

FOLDER_OF_DEVICE = "device"
"""Folder below that of the results with a copy of the device's file."""


def identify(job: Job, listener: Listener, finished: Callable[[Step], None] = lambda _: None) -> Identification:
    """Fit, combine and verify; write ``identification.json``, ``draws/`` and ``device/`` below ``job.out``.

    Parameters
    ----------
    job
        What to identify, and how.
    listener
        Told of remarks on the data and of each configuration.
    finished
        Called with each configuration that is fitted and on disk.

    Returns
    -------
    Identification
        Its JSON is on disk, but not as complete: `Identification.finish` says so once all that was asked for is there.

    Raises
    ------
    NumericalError
        Where a fit fails.
    InputError, WritingError
        Where the folder cannot be written, or the scheduler not be reached.
    """
    with Ahead(compilations_of(job)) as ahead:
        steps, data = _fit_configurations(job, listener, finished, ahead)
        ahead.wait(len(steps))
    listener.progress("whole device")
    whole, verification = _combine(job, steps)
    data |= {"links": _links_json(whole), "verification": verification.as_json()}
    data["whole"] = dict(whole.values) if whole else {}
    name = job.device.name if job.device else ""
    data["draws"] = write_draws(steps, whole, job.out, name=name, seed=job.options.seed)
    write_json(job.file, data)
    return Identification(
        steps=steps, verification=verification, data=data, build=job.build, workers=job.options.workers
    )


def _fit_configurations(
    job: Job, listener: Listener, finished: Callable[[Step], None], ahead: Ahead
) -> tuple[tuple[Step, ...], dict[str, Any]]:
    """Fit every configuration; the results so far are on disk after each."""
    digest = inputs_digest(job.campaign, job.device, job.configurations, job.options, str(job.kind))
    entries = kept_entries(job.file, digest)
    data = _head(job, digest)
    steps: list[Step] = []
    count = len(job.configurations)

    def tell(number: int, share: float, figures: str) -> None:
        listener.progress(_title(job, number), number + share, count, figures)

    with _tell_kept(steps, count), workers_of(job.scheduler, job.options.workers) as workers:
        tell_remarks(job.campaign, listener)
        sequence = Sequence(
            campaign=job.campaign,
            device=job.device,
            build=job.build,
            options=job.options,
            workers=workers,
            kept=dict(enumerate(entries)),
            tell=tell,
        )
        # What was kept takes no time, and is no measure of what is left.
        first = min(len(entries), count - 1)
        listener.progress(_title(job, first), first, count, "equations and kernels")
        ahead.wait(0)
        for step in sequence.steps(job.configurations):
            steps.append(step)
            source = data_digest(job.campaign, job.device, step.configuration)
            if not data["configurations"]:  # with the first result: a copy alone would be told as something finished
                data |= _copy_device(job)
            data["configurations"].append({**step_json(step), "data": source})
            # After every configuration: an interrupted identification is continued from the finished ones.
            write_json(job.file, data)
            finished(step)
            if first < len(steps) < count:
                listener.progress(_title(job, len(steps)), len(steps), count, "equations and kernels")
                ahead.wait(len(steps))
    return tuple(steps), data


@contextmanager
def _tell_kept(steps: Sized, count: int) -> Iterator[None]:
    """Say with an interruption where the identification goes on, where some of its configurations are on disk."""
    try:
        yield
    except KeyboardInterrupt as stop:
        if steps:
            kept = f"{len(steps)} of {count} configurations are kept"
            stop.args = (f"{kept}; the same command goes on with the next one: {word_this_command()}",)
        raise


def _title(job: Job, number: int) -> str:
    """Return name and place of a configuration, as in ``joint 4 (1 of 7)``."""
    return f"{job.configurations[number].name} ({number + 1} of {len(job.configurations)})"


def _head(job: Job, digest: str) -> dict[str, Any]:
    return {
        "schema": SCHEMA,
        "device": job.campaign.device,
        "campaign": job.campaign.title,
        "measured": job.campaign.measured,
        "remarks": list(job.campaign.remarks),
        **provenance(job.options, job.made_by),
        "code": code_digest().hex()[:16],
        "inputs": digest,
        "complete": False,
        "locking_order": [list(joints) for joints in dict.fromkeys(c.free_joints for c in job.configurations)],
        "configurations": [],
        "links": {},
        "verification": {"runs": []},
    }


def _copy_device(job: Job) -> dict[str, str]:
    """Copy the device's file to the results, which are exported without their campaign; return the key that says so."""
    file = Path(job.campaign.device)
    if job.campaign.loaded is not None or not job.campaign.device.endswith(SUFFIXES) or not is_file(file):
        return {}
    write_bytes(job.out / FOLDER_OF_DEVICE / file.name, file.read_bytes())
    return {COPY_OF_DEVICE: f"{FOLDER_OF_DEVICE}/{file.name}"}


def _combine(job: Job, steps: tuple[Step, ...]) -> tuple[Whole | None, Verification]:
    """Combine the steps and verify the whole model, where every joint of the device was tested."""
    device = job.device
    tested: set[int] = set()
    for step in steps:
        tested.update(step.configuration.free_joints)
    if device is None or tested != set(range(len(device.joints))):
        return None, Verification(runs=())
    whole = whole_device(device, steps, seed=job.options.seed, draws=COUNT)
    controller = job.campaign.extra.get("controller")
    unseen = [run for run in job.campaign.runs if run.use == "validate"]
    draws = whole.draws[: THRESHOLDS.draws_of_whole_device]
    return whole, verify(device, whole.values, unseen, controller, draws=draws, threads=job.options.workers)


def _links_json(whole: Whole | None) -> dict[str, Any]:
    """Return ``links`` of identification.json: the standard parameters of each link by id; none without the whole."""
    if whole is None:
        return {}
    links: dict[str, Any] = {}
    for link, table in whole.links.links.items():
        links[link] = {}
        for id, one in table.items():
            links[link][id] = {"value": one.value, "std": one.std, "unit": one.unit, "status": one.status}
    return links
