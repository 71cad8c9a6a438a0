"""Searches of a job: `Job` and joints in, a prepared search out, which `find` carries out.

Input is refused where a search is prepared, so that several can be prepared before the first long work begins.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypeAlias

from haptid.discrepancy.finding.accuracy import origin_of
from haptid.discrepancy.finding.finding import Finding, find
from haptid.discrepancy.finding.full_model import WholeFinding, whole_finding
from haptid.discrepancy.finding.torque_finding import TorqueFinding
from haptid.discrepancy.finding.torque_stages import find_torque
from haptid.discrepancy.job.job import Job
from haptid.discrepancy.study.coupled_study import coupled_study_of
from haptid.discrepancy.study.study import Study, begun_at, study_of, with_positions
from haptid.discrepancy.torque.choice import read_carried_fit, read_free_rms, read_zeros, residual_of
from haptid.discrepancy.torque.study import torque_study_of
from haptid.fmu_build.exchange.discrepancy_json import VERDICTS, by_joint, finding_of, law_of, read_discrepancy
from haptid.fmu_build.exchange.discrepancy_json import Finding as JointFinding
from haptid.fmu_build.exchange.identification_json import read_identification
from haptid.identification.sequence.carried_fit import FILE
from haptid.identification.sequence.equations_for import equations_for
from haptid.measurement.format.devices import device_of
from haptid.measurement.values.run import Run
from haptid.model.device.device import Device
from haptid.support.command import word_command
from haptid.support.errors import InputError, NumericalError
from haptid.support.listener import Progress

AnyFinding: TypeAlias = Finding | TorqueFinding | WholeFinding


@dataclass(frozen=True, slots=True, kw_only=True)
class SearchByTorque:
    """Search in the torque of a joint, as where a position controller moved it.

    Parameters
    ----------
    job
        What is asked for.
    joint
        Number of the joint.
    """

    job: Job
    joint: int

    @property
    def name(self) -> str:
        """Name of the finding, as ``joint3``."""
        return f"joint{self.joint}"

    @property
    def title(self) -> str:
        """Name for a reader, as ``joint 3``."""
        return f"joint {self.joint}"

    def find(self, tell: Progress) -> TorqueFinding:
        """Search; the FMU with the named effects is written below the job's folder.

        Parameters
        ----------
        tell
            Told of each step.

        Returns
        -------
        TorqueFinding
            Verdict, named effects and gaps in torque.
        """
        job, campaign, free = self.job, self.job.campaign, (self.joint,)
        base = equations_for(campaign, device_of(campaign), free)
        carried = read_carried_fit(campaign, free, base, job.out, springless=True)
        study = torque_study_of(campaign, self.joint, carried, threads=job.threads)
        return find_torque(
            study, job.catalogue, job.out, kind=job.kind, seed=job.seed, starts=job.starts, tell=tell,
            origin=origin_of(campaign, free), known_free_rms=read_free_rms(campaign, free, job.out),
        )  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class SearchByPosition:
    """Search in the position of one joint, or of several that move together.

    Parameters
    ----------
    job
        What is asked for.
    study
        Runs and nominal model, with the fit of an identification where there is one.
    remark
        What the reader has to know of the runs; empty where there is nothing.
    left_out
        Which findings of the joints alone the model does not hold, and why; empty where there is none.
    otherwise
        Search in the torque where no effect closes most of what the position shows; None where there is none.
    """

    job: Job
    study: Study
    remark: str = ""
    left_out: str = ""
    otherwise: SearchByTorque | None = None

    @property
    def name(self) -> str:
        """``joint3`` or ``joints01``."""
        return self.study.name

    @property
    def title(self) -> str:
        """``joint 3`` or ``joints 0, 1``."""
        return self.study.title.lower()

    def find(self, tell: Progress) -> Finding | TorqueFinding:
        """Search; the FMU with the named effects is written below the job's folder.

        Parameters
        ----------
        tell
            Told of each step.

        Returns
        -------
        Finding or TorqueFinding
            Verdict, named effects and gaps.
        """
        if self.otherwise is None:
            return self._find_in_position(tell)
        try:
            finding = self._find_in_position(tell)
        except NumericalError:  # a simulation from the recorded torque leaves the numbers
            return self.otherwise.find(tell)
        if finding.closes_half:
            return finding
        tell("no effect closes most of the gap in position: search in torque")
        if finding.rebuilt is not None:
            finding.rebuilt.fmu.path.unlink()
        return self.otherwise.find(tell)

    def _find_in_position(self, tell: Progress) -> Finding:
        job, origin = self.job, origin_of(self.job.campaign, self.study.fitted[0].free_joints)
        return find(
            self.study, job.out, kind=job.kind, seed=job.seed, starts=job.starts, tell=tell, origin=origin
        )  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class WholeCheck:
    """Check of the identified device, and of what was named in its joints, on runs with all joints free.

    Parameters
    ----------
    job
        What is asked for.
    device
        The device.
    runs
        Runs with all joints free.
    identification
        Content of ``identification.json``.
    named
        Findings of the single joints.
    left_out
        Which findings of the joints alone are not among these, and why; empty where there is none.
    """

    job: Job
    device: Device
    runs: tuple[Run, ...]
    identification: Mapping[str, Any]
    named: tuple[JointFinding, ...]
    left_out: str = ""

    name = "whole"
    title = "all joints"

    def find(self, tell: Progress) -> WholeFinding:
        """Simulate and judge.

        Parameters
        ----------
        tell
            Told of each step.

        Returns
        -------
        WholeFinding
            Residuals of the whole device by joint, with what they are compared with.
        """
        tell("simulate all joints")
        return whole_finding(self.job.campaign, self.device, self.runs, self.identification, self.named)


Prepared: TypeAlias = SearchByPosition | SearchByTorque | WholeCheck


def prepare_alone(job: Job, joint: int) -> SearchByPosition | SearchByTorque:
    """Prepare the search in the runs in which one joint moves alone.

    Parameters
    ----------
    job
        What is asked for.
    joint
        Number of the joint.

    Returns
    -------
    SearchByPosition or SearchByTorque
        As `residual_of` chooses.

    Raises
    ------
    InputError
        Where no run to fit frees this joint alone.
    """
    residual, by_torque = residual_of(job.campaign, joint, job.out), SearchByTorque(job=job, joint=joint)
    if residual == "torque":
        return by_torque
    search = _in_position(job, study_of(job.campaign, joint, job.catalogue, threads=job.threads))
    return replace(search, otherwise=by_torque if residual == "position_then_torque" else None)


def prepare_together(job: Job, joints: Sequence[int]) -> SearchByPosition | WholeCheck:
    """Prepare the search in the runs in which several joints move together.

    Parameters
    ----------
    job
        What is asked for.
    joints
        Numbers of the joints. What searches below the job's folder named in them alone is part of the nominal model.

    Returns
    -------
    SearchByPosition or WholeCheck
        A check of the whole device where all its joints move and no such run is to be fitted.

    Raises
    ------
    InputError
        Where there are too many joints, no run frees exactly these, or the whole device was not identified.
    """
    free = tuple(joints)
    if not job.campaign.runs_of(free, "fit"):
        return prepare_whole(job, free)
    known = by_joint(findings_below(job, free))
    search = _in_position(job, coupled_study_of(job.campaign, free, job.catalogue, known, threads=job.threads))
    return replace(search, left_out=tell_other_laws(job, free))


def prepare_whole(job: Job, joints: Sequence[int]) -> WholeCheck:
    """Prepare the check of the identified device on its runs with all joints free that no fit saw.

    Parameters
    ----------
    job
        What is asked for.
    joints
        Numbers of the joints: all of the device.

    Returns
    -------
    WholeCheck

    Raises
    ------
    InputError
        Where these are not all joints, there is no such run, or the job's folder holds no identification.
    """
    device, source, free = device_of(job.campaign), job.out / FILE, tuple(joints)
    if device is None or not moves_whole(job, free):
        where = f"--free {','.join(map(str, free))}"
        raise InputError(where, expected="runs in which these joints move together", got="none that tells")
    if not source.exists():
        raise InputError("--free", expected=f"an identified model, {source}", got="no such file", todo=need_of(job))
    return WholeCheck(
        job=job,
        device=device,
        runs=job.campaign.runs_of(free, "validate"),
        identification=read_identification(source),
        named=tuple(findings_below(job, free)),
        left_out=tell_other_laws(job, free),
    )


def moves_whole(job: Job, joints: Sequence[int]) -> bool:
    """Whether these are all joints of the device, and some run that no fit saw frees them.

    Parameters
    ----------
    job
        Job with the campaign.
    joints
        Numbers of the joints.

    Returns
    -------
    bool
        True where a check of the whole device is possible.
    """
    device = device_of(job.campaign)
    known = device is not None and len(joints) == len(device.joints)
    return known and bool(job.campaign.runs_of(tuple(joints), "validate"))


def need_of(job: Job) -> str:
    """Say what a check of the whole device needs.

    Parameters
    ----------
    job
        Job with the folder of the results.

    Returns
    -------
    str
        One line with the missing file and the command that makes it.
    """
    making = word_command("identify", "identification.run")
    return f"runs with all joints free need {job.out / FILE}: {making} makes it"


def findings_below(job: Job, joints: Sequence[int]) -> list[JointFinding]:
    """Read what earlier searches below the job's folder named in joints that were tested alone.

    Parameters
    ----------
    job
        Job with the folder.
    joints
        Numbers of the joints.

    Returns
    -------
    list
        Findings with a verdict that names effects; joints that were not studied are left out, and those for which
        another friction law was named: the model of the device has to be identified with that law first.
    """
    return [
        finding_of(data, str(path), dict(job.catalogue))
        for path, data in _named_below(job, joints).values()
        if law_of(data) is None
    ]


def tell_other_laws(job: Job, joints: Sequence[int]) -> str:
    """Say which findings `findings_below` leaves out since they name another friction law.

    Parameters
    ----------
    job
        Job with the folder.
    joints
        Numbers of the joints.

    Returns
    -------
    str
        One sentence with joints and laws; empty where there is no such finding.
    """
    laws = {joint: law_of(data) for joint, (_, data) in _named_below(job, joints).items()}
    other = [f"joint {joint} ({law})" for joint, law in laws.items() if law is not None]
    if not other:
        return ""
    told = f"Left out, since it was found under another friction law than the device's: {', '.join(other)}"
    return f"{told}; state the law in the device or campaign, and identify again."


def _named_below(job: Job, joints: Sequence[int]) -> dict[int, tuple[Path, dict[str, Any]]]:
    """Return file and content of the findings that name effects in joints that were tested alone, by joint."""
    named = {}
    for joint in joints:
        path = job.out / "discrepancy" / f"joint{joint}.json"
        data = read_discrepancy(path) if path.exists() else None
        if data is not None and data["verdict"] in VERDICTS:
            named[joint] = path, data
    return named


def _in_position(job: Job, study: Study) -> SearchByPosition:
    free = study.fitted[0].free_joints
    carried = read_carried_fit(job.campaign, free, study.base, job.out)
    study = begun_at(replace(study, effort=job.effort), carried)
    zeros = read_zeros(job.campaign, free, job.out)
    if not zeros:
        return SearchByPosition(job=job, study=study)
    remark = f"{study.title.lower()}: the encoder zeros of {job.out / FILE} are taken out of the readings"
    return SearchByPosition(job=job, study=with_positions(study, zeros), remark=remark)
