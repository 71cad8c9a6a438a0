"""Values and provenance of an FMU's parameters: ``identification.json`` in, `Identified` out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from haptid.fmu_build.description.provenance import Provenance
from haptid.fmu_build.description.variables import structured_name
from haptid.fmu_build.exchange.identification_check import check_tests
from haptid.model.equations.drive import Controller, Drive
from haptid.model.equations.equations import Equations
from haptid.model.equations.parameter_ids import id_suffixes
from haptid.model.friction.registry import DEFAULT, law_named
from haptid.model.joint.parameter_table import all_ids, parameter_rows
from haptid.model.thresholds import THRESHOLDS as MODEL
from haptid.support.errors import InputError
from haptid.support.files.files import read_json


@dataclass(frozen=True, slots=True, kw_only=True)
class Identified:
    """Hold identified parameters.

    Parameters
    ----------
    values
        Value by id of the parameter, SI units.
    provenance
        Source and standard deviation by id.
    """

    values: dict[str, float]
    provenance: dict[str, Provenance | str]

    def among(self, equations: Equations) -> Identified:
        """Return a copy with only the parameters that ``equations`` have.

        Parameters
        ----------
        equations
            Equations with their parameters.

        Returns
        -------
        Identified
            Values and provenance of these alone.
        """
        known = {q.id for q in equations.parameters}
        return Identified(
            values={k: v for k, v in self.values.items() if k in known},
            provenance={k: v for k, v in self.provenance.items() if k in known},
        )

    def name_values(self, equations: Equations) -> tuple[dict[str, float], dict[str, str]]:
        """Return all parameters of some equations by FMU variable name.

        Parameters
        ----------
        equations
            Their first guesses stand where no value was identified.

        Returns
        -------
        values, units : dict
            Value and unit by name.
        """
        names = {q.id: structured_name(equations, q.id, q.structured) for q in equations.parameters}
        values = {names[q.id]: float(self.values.get(q.id, q.initial)) for q in equations.parameters}
        return values, {names[q.id]: q.unit for q in equations.parameters}


def read_identification(path: Path) -> dict[str, Any]:
    """Read and check an ``identification.json``.

    Parameters
    ----------
    path
        File that an identification wrote.

    Returns
    -------
    dict
        Its content. Device and links are not checked yet (`check_for_device`).

    Raises
    ------
    InputError
        Where the file does not follow ``identification.schema.json``, or states parameters that no device can have
        (`fmu_build.exchange.identification_check.check_tests`).
    """
    data = read_json(path, "an identification.json", ("haptid.fmu_build.exchange", "identification.schema.json"))
    for number, configuration in enumerate(data["configurations"]):
        _check_friction(configuration, f"{path}: configurations[{number}]")
    check_tests(data, str(path))
    return data


def _check_friction(configuration: Mapping[str, Any], where: str) -> None:
    """Refuse an unknown friction law, and parameters of one that a joint does not have."""
    joints = configuration["free_joints"]
    laws = friction_of(configuration, where)
    for joint, suffix, law in zip(joints, id_suffixes(joints), laws, strict=True):
        others = set(all_ids()) - {row.id for row in parameter_rows(law)}
        lacking = {f"{id}{suffix}" for id in others} & set(configuration["parameters"])
        if lacking:
            place, todo = f"{where}.parameters", f"the friction of joint {joint} is {law}"
            raise InputError(place, expected="parameters of a locked joint", got=repr(min(lacking)), todo=todo)


def friction_of(configuration: Mapping[str, Any], where: str = "friction") -> tuple[str, ...]:
    """Return the friction law of each free joint of a configuration.

    Parameters
    ----------
    configuration
        Entry of ``configurations``; ``friction`` is one law for all joints or one for each, LuGre where absent.
    where
        Place of the entry, for errors.

    Returns
    -------
    tuple of str
        Id of the law of each joint, in the order of ``free_joints``.

    Raises
    ------
    InputError
        Where the number of laws is not that of the joints, or a law is unknown.
    """
    joints, said = configuration["free_joints"], configuration.get("friction", DEFAULT)
    laws = (said,) * len(joints) if isinstance(said, str) else tuple(said)
    place = f"{where}: friction"
    if len(laws) != len(joints):
        raise InputError(place, expected="one law for each free joint", got=str(list(laws)))
    return tuple(law_named(id, place).id for id in laws)


def friction_by_joint(data: Mapping[str, Any]) -> dict[int, str]:
    """Return the friction law by joint, for every joint that some configuration frees; the last one decides.

    Parameters
    ----------
    data
        Content of an ``identification.json``.

    Returns
    -------
    dict of int to str
        Id of the friction law by joint.

    Raises
    ------
    InputError
        Where the number of laws of a configuration is not that of its joints, or a law is unknown.
    """
    pairs = ((c["free_joints"], friction_of(c)) for c in data["configurations"])
    return {joint: law for joints, laws in pairs for joint, law in zip(joints, laws, strict=True)}


def drive_of(data: Mapping[str, Any], joint: int) -> Drive | None:
    """Return the drive of a joint tested alone; None where the torque is its input.

    Parameters
    ----------
    data
        Content of an ``identification.json``.
    joint
        Number of the joint.

    Returns
    -------
    Drive or None
        That of the first such test.
    """
    told = next((c.get("drive") for c in data["configurations"] if c["free_joints"] == [joint]), None)
    if told is None:
        return None
    controller = told.get("controller")
    return Drive(kind=told["kind"], controller=None if controller is None else Controller(**controller))


def entries_of(data: Mapping[str, Any], joint: int) -> Mapping[str, Any]:
    """Return the parameters of one joint tested alone.

    Parameters
    ----------
    data
        Content of an ``identification.json``.
    joint
        Number of the joint.

    Returns
    -------
    mapping
        Entry ``{value, unit, std, lower, upper, status}`` by plain id, of the first such test.

    Raises
    ------
    InputError
        Where no configuration frees this joint alone.
    """
    for configuration in data["configurations"]:
        if list(configuration["free_joints"]) == [joint]:
            return configuration["parameters"]
    where = f"joint {joint}"
    raise InputError(where, expected="a configuration with this joint alone", got="none")


def of_joint(data: Mapping[str, Any], joint: int) -> Identified:
    """Return values and provenance of one joint tested alone, by their plain ids as ``Ks``; see `entries_of`.

    Parameters
    ----------
    data
        Content of an ``identification.json``.
    joint
        Number of the joint.

    Returns
    -------
    Identified
        Values in SI units.

    Raises
    ------
    InputError
        Where no configuration frees this joint alone.
    """
    return _of(entries_of(data, joint), f"test of joint {joint}", words_of_campaign(data))


def of_device(data: Mapping[str, Any]) -> Identified:
    """Return the parameters of the whole device.

    Parameters
    ----------
    data
        Content of an ``identification.json``.

    Returns
    -------
    Identified
        By id in the whole device: ``Ks_4`` from the test of joint 4, ``link6_m`` from the links. The values in
        ``whole`` overrule both, as they were fitted together with physically consistent links.
    """
    values: dict[str, float] = {}
    provenance: dict[str, Provenance | str] = {}
    for configuration in data["configurations"]:
        joints = list(configuration["free_joints"])
        test = f"test of joint{'s' * (len(joints) > 1)} {', '.join(map(str, joints))}"
        one = _of(configuration["parameters"], test, words_of_campaign(data))
        suffix = f"_{joints[0]}" if len(joints) == 1 else ""
        values |= {f"{id}{suffix}": value for id, value in one.values.items()}
        provenance |= {f"{id}{suffix}": origin for id, origin in one.provenance.items()}
    for link, parameters in data.get("links", {}).items():
        one = _of(parameters, "all tests together", words_of_campaign(data))
        prefix = link if link.startswith("motor_") else f"link{link}"
        values |= {f"{prefix}_{id}": value for id, value in one.values.items()}
        provenance |= {f"{prefix}_{id}": origin for id, origin in one.provenance.items()}
    values |= {id: float(value) for id, value in data.get("whole", {}).items()}
    return Identified(values=values, provenance=provenance)


def words_of_campaign(data: Mapping[str, Any]) -> str:
    """Return the title of the campaign, and whether its data were measured or are synthetic.

    Parameters
    ----------
    data
        Content of an ``identification.json``.

    Returns
    -------
    str
        As ``Freedom 6S (SYNTHETIC data)``.
    """
    kind = "measured" if data.get("measured") else "SYNTHETIC"
    return f"{data.get('campaign', 'campaign')} ({kind} data)"


def _of(parameters: Mapping[str, Any], test: str, campaign: str) -> Identified:
    origins: dict[str, Provenance | str] = {}
    for id, entry in parameters.items():
        told = entry.get("told_status", entry.get("status", ""))  # results of earlier versions have the status alone
        origins[id] = Provenance(source=f"{test}, {campaign}", std=entry.get("std"), status=told)
    return Identified(
        values={id: float(entry["value"]) for id, entry in parameters.items()},
        provenance=origins,
    )


def inner_step_of(identification: Mapping[str, Any], joint: int | None = None) -> float:
    """Return the inner step that the fits of a result needed, and the whole device.

    Parameters
    ----------
    identification
        Content of an ``identification.json``.
    joint
        Number of a joint that was tested alone; None for all configurations.

    Returns
    -------
    float
        The shortest of these configurations [s]; the model's own step where none needed a shorter one.
    """
    found = identification["configurations"]
    of_joint = [one for one in found if joint is None or one["free_joints"] == [joint]]
    if joint is None:
        of_joint = [*of_joint, identification.get("verification", {})]
    return min((one.get("inner_step_s", MODEL.inner_step_s) for one in of_joint), default=MODEL.inner_step_s)


def largest_torque_of(identification: Mapping[str, Any], joint: int | None = None) -> float:
    """Return the largest torque that the runs of a result applied to a joint that turns.

    Parameters
    ----------
    identification
        Content of an ``identification.json``.
    joint
        Number of a joint that was tested alone; None for all configurations.

    Returns
    -------
    float
        Torque [N m]; 0 where no joint turns, and where the result is one of an earlier version, which did not say it.
    """
    found = identification["configurations"]
    of_joint = [one for one in found if joint is None or one["free_joints"] == [joint]]
    return max((float(one.get("largest_torque_Nm", 0.0)) for one in of_joint), default=0.0)
